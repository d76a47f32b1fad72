"""Markers that hide lamps behind them, and people who hide lamps: found where they are, and nothing where lamps are."""

import numpy as np
import pytest
import scipy

from kinemark.detect import detect
from kinemark.detect.ground import opening
from support.films import Film

W, H, FRAMES = 320, 240, 60
MARKER, LAMP = 210.0, 140.0  # grey levels


def disc(u, v, radius):
    """(H, W) share of each pixel that a disc covers."""
    y, x = np.mgrid[:H, :W]
    return np.clip(radius - np.hypot(x - u, y - v) + 0.5, 0, 1)


def filmed(seed, *, body=None, paths=None, light=None):
    """A film of opaque discs of 7 px before a window, and of a body (F, H, W), and the discs' places (F, M, 2)."""
    rng = np.random.default_rng([415, seed])
    ground = np.full((H, W), 12.0)
    ground[30:200, 150:260] = LAMP
    phase, turn = rng.uniform(0, 6, (12, 2)), np.arange(FRAMES)[:, None, None] * 0.1
    grid = np.stack(np.meshgrid(np.arange(4), np.arange(3)), -1).reshape(-1, 2) * [75, 75] + [45, 45]
    places = grid + 22 * np.sin(turn * [1.0, 1.3] + phase) if paths is None else paths
    images = []
    for f in range(FRAMES):
        image = 12 + (ground - 12) * (1.0 if light is None else light[f])
        if body is not None:
            image = np.where(body[f], 25.0, image)
        for u, v in places[f]:
            share = disc(u, v, 3.5)
            image = image * (1 - share) + MARKER * share
        image = scipy.ndimage.gaussian_filter(image, 0.6) + rng.normal(0, 1.5, (H, W))
        images.append(np.clip(np.rint(image), 0, 255).astype(np.uint8))
    return Film(images), places


def judged(film, places):
    """Share of the markers that are found within 1.5 px, their root mean square error, px, false ones a frame."""
    found = detect([film], cameras=["cam1"], rate=50.0)
    assert found.ground_subtracted == ("cam1",)
    errors, false = [], 0
    for f in range(FRAMES):
        apart = np.linalg.norm(found.uv[(found.frame == f) & found.valid] - places[f][:, None], axis=-1)
        errors.append(apart.min(1, initial=9.0))
        false += int((apart.min(0, initial=9.0) > 3).sum())
    near = np.concatenate(errors)
    return (near < 1.5).mean(), np.sqrt((near[near < 1.5] ** 2).mean()), false / FRAMES


@pytest.mark.parametrize("seed", [1, 2])
def test_markers_before_and_at_the_edge_of_a_window_are_where_they_are(seed):
    """Those at its edge were drawn to the dark side."""
    recall, off, false = judged(*filmed(seed))
    assert recall >= 0.98 and off < 0.06 and false < 0.1


@pytest.mark.parametrize("seed", [10, 11])
def test_markers_that_stay_before_a_window_are_where_they_are(seed):
    """They are at each place of theirs in more than one of seven frames, which is no change of light."""
    turn, phase = np.arange(FRAMES)[:, None, None] * 0.1, np.random.default_rng(seed).uniform(0, 6, (12, 2))
    outside, before = ([(u + 45 * (k % 2), 50 + 50 * (k // 2)) for k in range(6)] for u in (40, 180))
    recall, off, false = judged(*filmed(seed, paths=[*outside, *before] + 8 * np.sin(turn * [1.0, 1.3] + phase)))
    assert recall >= 0.98 and off < 0.05 and false < 0.1


@pytest.mark.parametrize("seed", [3, 4])
def test_light_that_was_hidden_most_of_the_time_is_no_marker(seed):
    """Hands before the window for three quarters of the recording."""
    body = np.zeros((FRAMES, H, W), np.bool_)
    for row, column in ((45, 170), (80, 210), (110, 240), (150, 165), (180, 200)):
        body[: FRAMES * 3 // 4, row : row + 9, column : column + 9] = True
    recall, _, false = judged(*filmed(seed, body=body))
    assert recall >= 0.97 and false < 0.1


@pytest.mark.parametrize("seed", [5, 6])
def test_markers_of_a_person_who_stands_first_are_kept(seed):
    _, places = filmed(seed)
    standing = np.concatenate([np.repeat(places[:1], 40, 0), places[:20]])
    recall, _, false = judged(*filmed(seed, paths=standing))
    assert recall >= 0.95 and false < 0.2


@pytest.mark.parametrize("seed", [7, 8])
def test_light_that_rises_slowly_is_no_marker(seed):
    recall, _, false = judged(*filmed(seed, light=np.linspace(0.75, 1.25, FRAMES)))
    assert recall >= 0.95 and false < 0.1


@pytest.mark.parametrize("side", [1, 3, 9, 17])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_the_opening_is_that_of_scipy(side, dtype):
    image = np.random.default_rng(9).integers(0, np.iinfo(dtype).max, (41, 53)).astype(dtype)
    np.testing.assert_array_equal(opening(image, side), scipy.ndimage.grey_opening(image, size=(side, side)))
