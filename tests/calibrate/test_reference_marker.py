"""Fixed marks: shifts are undone, whatever else is in the image, and cameras that turned are refused."""

import numpy as np
import pytest

from kinemark.calibrate import corrected, find_marks, mark_shift, reference_shift
from kinemark.data import Detections, KinemarkError
from support.shared import shared_data

MARKS = np.array([[[100.0, 900.0], [640.0, 950.0], [1200.0, 80.0]], [[50.0, 60.0], [600.0, 40.0], [1210.0, 990.0]]])
SHIFT = np.array([[3.0, -7.0], [-11.0, 0.5]])


def recording(jitter, rng, *, noise=0.05, seen=1.0, n=6):
    """Moving markers and the fixed marks, shifted by (C, F, 2), in any order."""
    counts, rows = [], []
    for c, shifts in enumerate(jitter):
        start, speed = rng.uniform(0, 1000, (n, 2)), rng.normal(0, 8, (n, 2))
        for f, shift in enumerate(shifts):
            marks = MARKS[c][rng.uniform(size=len(MARKS[c])) < seen] + rng.normal(0, noise, 2)
            rows.append(rng.permutation(np.concatenate([marks, start + f * speed]) + shift))
            counts.append(len(rows[-1]))
    return Detections.build(("a", "b"), 50.0, np.reshape(counts, jitter.shape[:2]), np.concatenate(rows))


def test_a_common_shift_is_found_and_undone():
    np.testing.assert_allclose(reference_shift(MARKS, MARKS + SHIFT[:, None]), SHIFT)
    jitter = np.repeat(SHIFT[:, None], 4, 1)
    moved, still = (recording(j, np.random.default_rng(0)) for j in (jitter, 0 * jitter))
    np.testing.assert_allclose(corrected(moved, SHIFT).uv, still.uv)
    np.testing.assert_allclose(corrected(moved, jitter).uv, still.uv)


def test_a_shift_a_frame_and_frames_between_are_filled():
    rng = np.random.default_rng(1)
    jitter = rng.normal(0, 4, (2, 30, 2))
    now = MARKS[:, None] + jitter[:, :, None]
    np.testing.assert_allclose(reference_shift(MARKS, now), jitter)
    now[0, 10] = np.nan  # no mark in sight
    now[1, 5, 0] = np.nan
    found = reference_shift(MARKS, now)
    np.testing.assert_allclose(found[0, 10], (jitter[0, 9] + jitter[0, 11]) / 2)
    np.testing.assert_allclose(found[1], jitter[1])


def test_more_marks_tell_better_and_the_spread_is_their_noise():
    rng = np.random.default_rng(2)
    before = rng.uniform(0, 1000, (1, 9, 2))
    now = before[:, None] + SHIFT[0] + rng.normal(0, 0.4, (1, 3000, 9, 2))
    shift, spread = mark_shift(before, now)
    assert np.std(shift - SHIFT[0]) == pytest.approx(0.4 / 3, rel=0.05)
    assert spread[0] == pytest.approx(0.4 * np.sqrt(2), rel=0.02)
    one = mark_shift(before[:, :1], now[:, :, :1])
    assert np.isnan(one.spread[0]) and np.std(one.shift - SHIFT[0]) == pytest.approx(0.4, rel=0.05)


def test_another_thing_taken_for_a_mark_in_one_frame_does_no_harm():
    now = np.repeat(MARKS[:, None] + SHIFT[:, None, None], 400, 1)
    now[0, 7, 1] += [30, 0]
    np.testing.assert_allclose(reference_shift(MARKS, now)[0, 7], SHIFT[0])


@pytest.mark.parametrize(
    ("angle", "zoom", "says"), [(1.0, 1.0, r"turn of 1.00°.*1.0000"), (0.0, 1.02, r"zoom by 1.02")]
)
def test_a_camera_that_was_turned_or_zoomed_is_refused(angle, zoom, says):
    a = zoom * np.exp(1j * np.radians(angle))
    z = a * (MARKS[..., 0] + 1j * MARKS[..., 1])
    now = np.stack([z.real, z.imag], -1)
    with pytest.raises(KinemarkError, match=rf"Camera one: its 3 fixed marks did not shift alike.*{says}"):
        reference_shift(MARKS, now, names=("one", "two"))
    moved = MARKS.copy()
    moved[1, 2] += [40, 10]  # one mark was knocked over
    with pytest.raises(KinemarkError, match=r"Camera 2: .*a mark moved"):
        reference_shift(MARKS, moved)


def test_marks_are_found_among_moving_markers():
    rng = np.random.default_rng(3)
    jitter = SHIFT[:, None] + rng.normal(0, 0.5, (2, 60, 2))
    found = find_marks(recording(jitter, rng, seen=0.9), MARKS)
    off = found - MARKS[:, None] - jitter[:, :, None]
    assert np.isfinite(off).mean() > 0.8
    assert np.nanmax(np.abs(off)) < 1.5 or np.nanmedian(np.abs(off)) < 0.1  # a marker may pass through a mark
    shift = reference_shift(MARKS, found)
    assert np.abs(shift - jitter).max() < 0.7


def test_of_two_places_as_good_the_nearer_one():
    uv = np.tile([[103.0, 900.0], [112.0, 905.0]], (20, 1))  # the mark, and a reflection beside it
    seen = Detections.build(("a",), 50.0, np.full((1, 20), 2), uv)
    np.testing.assert_allclose(find_marks(seen, MARKS[:1, :1])[0, :, 0], np.tile([103.0, 900.0], (20, 1)))


def test_marks_that_are_not_there_are_refused():
    rng = np.random.default_rng(4)
    seen = recording(np.zeros((2, 20, 2)), rng)
    away = MARKS.copy()
    away[1, 0] += 200
    with pytest.raises(KinemarkError, match=r"Camera b: its fixed mark 1 is seen .* 0 % of the frames"):
        find_marks(seen, away)
    away[1, 0] = np.nan  # said not to be seen
    assert np.isnan(find_marks(seen, away)[1, :, 0]).all()
    now = MARKS.copy()
    now[0] = np.nan
    with pytest.raises(KinemarkError, match="Camera 1 sees none"):
        reference_shift(MARKS, now)


def test_arrays_that_do_not_fit():
    seen = recording(np.zeros((2, 3, 2)), np.random.default_rng(5))
    for before, now in ((MARKS[0], MARKS), (MARKS, MARKS[:1]), (MARKS, MARKS[:, :2])):
        with pytest.raises(ValueError, match="wanted"):
            reference_shift(before, now)
    for shift in (SHIFT[:1], np.zeros((2, 4, 2)), SHIFT * np.nan):
        with pytest.raises(ValueError, match="shift has shape"):
            corrected(seen, shift)
    with pytest.raises(ValueError, match="before has shape"):
        find_marks(seen, MARKS[:1])
    with pytest.raises(ValueError, match="tolerance"):
        reference_shift(MARKS, MARKS, tolerance=0.0)


def test_real_film_lies_otherwise_in_the_digitiser_each_time():
    folder = shared_data("cameras/kinemat_running_3cam")
    for c, known in ((1, (2.30, 10.76)), (2, (22.37, -7.63)), (3, (17.82, 5.87))):
        before = np.loadtxt(folder / f"r1cam{c}.cal")[None, 6:]
        film = np.loadtxt(folder / f"r1cam{c}.raw").reshape(-1, 27, 2)
        shift, spread = mark_shift(before, film[None, :, 24:], tolerance=10.0)
        np.testing.assert_allclose(shift[0].mean(0), known, atol=0.01)
        assert spread[0] < 8
        with pytest.raises(KinemarkError, match="did not shift alike"):
            mark_shift(before, film[None, :, 22:25], tolerance=10.0)  # a marker of the runner among them
