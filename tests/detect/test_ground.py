"""The static ground is subtracted where it is uneven, and nothing that may be a marker; dark grounds are left alone."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy

from kinemark.data import same
from kinemark.detect import Centroids, detect, stability
from kinemark.detect.ground_learning import Spots, static_ground, without_spots
from kinemark.detect.stability import bright_pixels, groups_above, marker_gap
from kinemark.engine.trial_graph import subtracted
from kinemark.geometry import project, sphere_offset
from kinemark.io.records import load, save
from kinemark.report.words import advice_of, text_of
from kinemark.synth import Optics, render, ring
from support.films import Film

W, H, FRAMES = 320, 240, 48
DIAMETER = 36.0  # mm
AMONG = [f"cam{k + 1}" for k in range(2)]


def hall(rng, low, high, *, objects=True):
    """(H, W) light of a slope from `low` to `high` grey levels, a window, a lamp and a rod aslant."""
    x, y = np.meshgrid(np.arange(W), np.arange(H))
    slope = x * np.cos(turn := rng.uniform(0, 2 * np.pi)) + y * np.sin(turn)
    light = low + (high - low) * (slope - slope.min()) / np.ptp(slope)
    if objects:
        light[20:60, 200:260] = 220
        light = np.where(np.hypot(x - 60, y - 190) < 28, 230, light)
        across, along = x + y - 330, x - y - 60
        light = np.where((np.abs(across) < 4) & (np.abs(along) < 50), 190, light)
    return scipy.ndimage.gaussian_filter(light, 0.7)


@cache
def _filmed(seed, light):
    return _made(seed, **dict(light))


def filmed(seed, **light):
    """Two cameras' films of spheres of which some stand still, their grounds, and the true places (F, M, 2) in each."""
    films, grounds, places = _filmed(seed, tuple(light.items()))
    return [Film(film.images.copy(), interlaced=film.interlaced) for film in films], grounds, places


def _made(seed, *, brightness=90.0, low=40.0, high=120.0, noise=2.0, still=0, objects=True, fields=False):
    rng, films, grounds, places = np.random.default_rng(seed), [], [], []
    light = Optics(brightness=brightness, background=0.0, read_noise=0.0)
    base = rng.uniform((-900, -900, 300), (900, 900, 1500), (16, 3))
    step, phase = rng.normal(0, 250, (16, 3)), rng.uniform(0, 6, (16, 1))
    for camera in ring(2, size=(W, H * 2 if fields else H)):
        ground = hall(rng, low, high, objects=objects)
        images, true = [], []
        for f in range(FRAMES):
            xyz = base + np.where(np.arange(16)[:, None] < still, 0, step * np.sin(2 * np.pi * f / FRAMES + phase))
            sight = render(camera, xyz, DIAMETER / 2, optics=light).astype(np.float64)
            grey = (sight[f % 2 :: 2] if fields else sight) + ground
            images.append(np.clip(np.rint(grey + noise * rng.normal(size=grey.shape)), 0, 255).astype(np.uint8))
            uv = project(camera, xyz) + sphere_offset(camera, xyz, diameter=DIAMETER)
            true.append(uv / [1, 2] if fields else uv)
        films.append(Film(images, interlaced=fields))
        grounds.append(ground)
        places.append(np.array(true))
    return films, grounds, places


def judged(found, c, ground, places, brightness=90.0, only=slice(None)):
    """Recall of markers apart from others that the sensor can show, false detections a frame, median squared error."""
    hidden = scipy.ndimage.maximum_filter(ground, 11) + brightness > 250
    hit, errors, false = [], [], 0
    for f, true in enumerate(places):
        rows = (found.camera == c) & (found.frame == f) & (found.validity == 0)
        apart = np.linalg.norm(found.uv[rows] - true[:, None], axis=-1)
        others = np.linalg.norm(true - true[:, None], axis=-1) + 1e9 * np.eye(len(true))
        u, v = np.clip(np.rint(true).astype(int), 0, [W - 1, H - 1]).T
        fair = ((true > 8) & (true < [W - 9, H - 9])).all(1) & (others.min(1) > 16) & ~hidden[v, u]
        close = np.pad(apart, ((0, 0), (0, 1)), constant_values=9.0).min(1) < 1.5
        hit += close[only][fair[only]].tolist()
        false += int((apart.min(0) > 4).sum()) if apart.size else 0
        for m in np.flatnonzero(fair & close):
            row = np.flatnonzero(rows)[apart[m].argmin()]
            off = found.uv[row] - true[m]
            errors.append(off @ np.linalg.inv(found.cov[row]) @ off / 2)
    return np.mean(hit) if hit else 1.0, false / len(places), np.median(errors) if errors else np.nan


@pytest.mark.parametrize(
    ("seed", "light"),
    [(11, {}), (12, {"brightness": 60.0}), (13, {"objects": False}), (15, {"fields": True})],
)
def test_markers_before_an_uneven_ground_are_found_with_true_covariances(seed, light):
    films, grounds, places = filmed(seed, **light)
    bright = light.get("brightness", 90.0)
    found = detect(films, cameras=AMONG, rate=100.0)
    plain = detect(films, cameras=AMONG, rate=100.0, method=Centroids(background="none"))
    assert found.ground_subtracted == tuple(AMONG) and plain.ground_subtracted == ()
    for c in range(2):
        recall, false, nees = judged(found, c, grounds[c], places[c], bright)
        assert recall >= 0.98 and false < 0.5
        assert light.get("fields") or 0.4 < nees < 2.2  # the rims of fields' lines are sharper than (6) of `moments`
        recall, false, off = judged(plain, c, grounds[c], places[c], bright)
        assert recall < 0.98 or false >= 1 or off > 2 * nees


def test_dark_markers_before_an_uneven_bright_ground():
    films, grounds, places = filmed(11)
    for film in films:
        film.images = 255 - film.images
    found = detect(films, cameras=AMONG, rate=100.0, method=Centroids(inverted=True))
    assert found.ground_subtracted == tuple(AMONG)
    for c in range(2):
        recall, false, _ = judged(found, c, grounds[c], places[c])
        assert recall >= 0.98 and false < 0.5


def test_markers_that_stand_still_are_kept():
    for seed, still in ((26, 6), (27, 16)):  # some, and all, as in a static trial
        films, grounds, places = filmed(seed, still=still)
        found = detect(films, cameras=AMONG, rate=100.0)
        for c in range(2):
            assert judged(found, c, grounds[c], places[c], only=slice(still))[0] >= 0.98


def test_dark_grounds_short_recordings_and_stated_thresholds_are_left_alone():
    films, _, _ = filmed(19, low=5.0, high=15.0, objects=False, brightness=200.0)
    found = detect(films, cameras=AMONG, rate=100.0)
    assert same(found, detect(films, cameras=AMONG, rate=100.0, method=Centroids(background="none")))
    films, _, _ = filmed(11)
    short = [Film(film.images[:47]) for film in films]
    assert detect(short, cameras=AMONG, rate=100.0).ground_subtracted == ()
    assert detect(films, cameras=AMONG, rate=100.0, method=Centroids(threshold=150)).ground_subtracted == ()


@pytest.mark.parametrize("inverted", [False, True])
def test_a_stated_threshold_counts_from_the_ground_that_is_subtracted(inverted):
    films, grounds, places = filmed(11)
    for film in films if inverted else ():
        film.images = 255 - film.images
    method = Centroids(background="subtract", threshold=45, inverted=inverted)
    found = detect(films, cameras=AMONG, rate=100.0, method=method)
    for c in range(2):
        assert judged(found, c, grounds[c], places[c])[0] >= 0.98


def test_peaks_are_grey_levels_of_the_recording():
    films, grounds, _ = filmed(13, objects=False)
    found = detect(films, cameras=AMONG, rate=100.0)
    some = (found.camera == 0) & (found.validity == 0) & (found.area > 12) & ~found.merged
    u, v = np.rint(found.uv[some]).astype(int).T
    assert abs(np.median(found.peak[some] - grounds[0][v, u]) - 90.0) < 5


def test_a_large_thing_belongs_to_the_ground_and_a_spot_does_not():
    rng = np.random.default_rng(23)
    light = hall(rng, 30.0, 60.0)
    light[120:126, 100:106] += 90
    images = np.clip(light + rng.normal(0, 2, (12, H, W)), 0, 255).astype(np.uint8)
    ground = static_ground(images, np.zeros(12, np.int64))
    kept = without_spots(ground, Spots(40.0, 120.0, 2.5, 90.0)).taken_from(images, 0).astype(int)
    assert kept[:, 121:125, 101:105].min() > 70  # the spot is still there
    kept[:, 115:131, 95:111] = 0
    assert kept.max() < ground.level + 40  # window, lamp and rod are not


def test_it_is_kept_with_the_detections(tmp_path):
    films, _, _ = filmed(11)
    found = detect(films, cameras=AMONG, rate=100.0)
    save(tmp_path / "detections.h5", found)
    assert same(load(tmp_path / "detections.h5"), found)
    assert found.select(["cam2"]).ground_subtracted == ("cam2",)
    assert found.frames(3, 9).ground_subtracted == found.ground_subtracted


def test_thresholds_are_tried_on_bright_pixels_alone(monkeypatch):
    """The same groups, and all pixels are looked at twice, not for every threshold."""
    films, _, _ = filmed(19, low=5.0, high=15.0, objects=False, brightness=200.0)
    images = films[0].images[:6]
    bright = bright_pixels(images, 20.0)
    for level in (20.0, 31.7, 60.0, 101.0, 254.0):
        usual, fast = groups_above(images, level), groups_above(images, level, bright)
        assert all(np.array_equal(a, b) for a, b in zip(usual.runs, fast.runs, strict=True))
        assert np.array_equal(usual.start, fast.start) and np.array_equal(usual.area, fast.area)

    calls, find = [], stability.find_runs
    monkeypatch.setattr(stability, "find_runs", lambda *a, **k: calls.append(1) or find(*a, **k))
    marker_gap(images)
    assert len(calls) <= 2


def test_a_finding_says_whose_ground_was_subtracted():
    films, _, _ = filmed(11)
    found = detect(films, cameras=AMONG, rate=100.0)
    (finding,) = subtracted(found)
    assert finding.kind == "ground_subtracted" and finding.cameras == tuple(AMONG)
    assert "static ground was subtracted" in text_of(finding)
    assert all(word in advice_of(finding) for word in ("mask", "aperture"))
    assert not list(subtracted(replace(found, ground_subtracted=())))
