"""Cameras that were started apart by whole images, or lost some, are told so, and not something else."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from kinemark.data import make_finding
from kinemark.engine.camera_checks.camera_order import put_in_order
from kinemark.engine.camera_checks.start_times import in_time, with_start_times
from kinemark.engine.tracking_stage import from_detections
from kinemark.reconstruct import LeastSquares
from kinemark.report.words import advice_of, text_of
from kinemark.track.simultaneous import diagnose, track_simultaneously
from kinemark.track.simultaneous.simultaneous_method import DEFAULT
from support.laboratory import observe, ring
from support.motions import dance

RIG, FRAMES = ring(6), 100


@pytest.fixture(scope="module")
def seen():
    return observe(RIG, dance(n=12, frames=FRAMES), noise=0.1)[0]


def later(detections, n, since=0):
    """Of camera c1 every image from frame `since` on is that of n frames later."""
    own = (detections.camera == 1) & (detections.frame >= since)
    frame = np.where(own, detections.frame - n, detections.frame)
    kept = (frame >= 0) & (frame < FRAMES) & ~(own & (frame < since))
    moved = detections.keep(kept)
    counts = np.zeros((6, FRAMES), np.int64)
    np.add.at(counts, (moved.camera, frame[kept]), 1)
    return type(moved).build(moved.cameras, moved.rate, counts, uv=moved.uv, cov=moved.cov)


def told(detections, rig=RIG):
    return with_start_times(diagnose(detections, rig, track_simultaneously(detections, rig, DEFAULT)), detections, rig)


@pytest.mark.parametrize("n", [2, -5])
def test_a_camera_that_was_started_apart_is_told_by_how_many_images(seen, n):
    (found,) = told(later(seen, n))
    assert (found.kind, found.cameras, found.values["images"]) == ("camera_started_apart", ("c1",), n)
    assert f"delays_ms.c1 = {10 * n} below [cameras]" in advice_of(found)


def test_a_camera_that_dropped_images_was_not_touched(seen):
    (found,) = told(later(seen, 4, since=40))
    assert (found.kind, found.cameras, found.values["images"]) == ("camera_dropped_images", ("c1",), 4)
    assert abs(found.frames[0][0] - 40) <= 10 and "4\xa0images later" in text_of(found)


def test_a_camera_that_stands_otherwise_was_not_started_apart(seen):
    touched = replace(seen, uv=seen.uv + (seen.camera == 1)[:, None] * [9.0, 4.0])
    assert {one.kind for one in told(touched)} == {"camera_put_right"}
    turned = make_finding("camera_fits_nothing", cameras=["c1"], left_out=True)
    mirrored = replace(seen, uv=np.where((seen.camera == 1)[:, None], [1280.0, 1024.0] - seen.uv, seen.uv))
    assert with_start_times([turned], mirrored, RIG) == (turned,)


@pytest.mark.parametrize("n", [3, -5])
def test_images_of_a_camera_that_was_started_apart_are_put_into_the_frames_that_they_show(seen, n):
    late = later(seen, n)
    moved = in_time([make_finding("camera_started_apart", cameras=["c1"], images=n, delay_ms=0.0, state_ms=0.0)], late)
    np.testing.assert_array_equal(moved.uv, late.uv)  # rows stay
    for f in range(max(n, 0) + 1, FRAMES + min(n, 0) - 1):
        np.testing.assert_array_equal(moved[1, f], seen[1, f])
        np.testing.assert_array_equal(moved[0, f], seen[0, f])
    assert not diagnose(moved, RIG, track_simultaneously(moved, RIG, DEFAULT))


@pytest.mark.parametrize("n", [2, -1, 50])
def test_images_of_frames_that_were_not_recorded_are_not_valid(seen, n):
    frames = seen.frames(0, 40)
    moved = in_time(
        [make_finding("camera_started_apart", cameras=["c2"], images=n, delay_ms=0.0, state_ms=0.0)], frames
    )
    own = np.flatnonzero(frames.camera == 2)
    shown = frames.frame[own] + n
    np.testing.assert_array_equal(moved.valid[own], (shown >= 0) & (shown < 40))
    valid = own[moved.valid[own]]
    np.testing.assert_array_equal(moved.frame[valid], frames.frame[valid] + n)
    assert moved.valid[frames.camera != 2].all()


def inputs(rig, **delays_ms):
    cameras = SimpleNamespace(delays_ms=delays_ms)
    settings = SimpleNamespace(track=DEFAULT, reconstruct=LeastSquares(), match=None, cameras=cameras)
    source = SimpleNamespace(of=SimpleNamespace(entry=SimpleNamespace(images=None)))
    calibrated = SimpleNamespace(figures={})
    return SimpleNamespace(rig=rig, settings=settings, source=source, calibrated=calibrated)


def test_the_delay_to_state_is_all_that_is_stated_and_known():
    """Else who writes what two findings say, one after the other, never gets there."""
    points = dance(n=12, frames=1000, rate=1000.0)  # camera c1 is late by 37 ms, of which 5 are stated
    own = [observe(RIG, points[:, 100 + by : 900 + by : 10], noise=0.1)[0] for by in (0, 32)]
    counts = np.where(np.arange(6)[:, None] == 1, own[1].counts, own[0].counts)
    uv = np.concatenate([own[c == 1].uv[own[c == 1].camera == c] for c in range(6)])
    seen = type(own[0]).build(RIG.names, 100.0, counts, uv)
    tracked = from_detections(inputs(RIG, c1=5.0), {"detect": seen})
    late = [one for one in tracked.diagnostics if one.cameras == ("c1",)]
    assert {one.kind for one in late} == {"camera_started_apart", "camera_delay_learned"}
    for one in late:
        assert one.values["state_ms"] == pytest.approx(37, abs=0.5)
        assert re.search(r"delays_ms\.c1 = 3[67]\.\d", advice_of(one))


@pytest.mark.parametrize("late", [{0: 6}, {1: 4, 2: -7}, {1: 4, 2: 4}])
def test_cameras_that_were_started_apart_are_put_in_time_and_make_no_points_of_their_own(late):
    rig, n, points = ring(5 if 0 in late else 6), 80, dance(n=12, frames=100)
    each = [observe(rig, points[:, 10 + by : 10 + by + n], noise=0.1)[0] for by in (late.get(c, 0) for c in range(6))]
    own = [one.uv[one.camera == c] for c, one in enumerate(each[: len(rig)])]
    counts = [one.counts[c] for c, one in enumerate(each[: len(rig)])]
    seen = type(each[0]).build(rig.names, 100.0, counts, np.concatenate(own))
    tracked = from_detections(inputs(rig), {"detect": seen})
    told = {int(c.cameras[0][1:]): c.values["images"] for c in tracked.diagnostics if c.kind == "camera_started_apart"}
    assert told == late
    images = (tracked.tracks.cloud.detection >= 0).sum(1)
    assert len(images) == 12 * n and images.mean() > len(rig) - 0.4


@pytest.mark.parametrize("late", [{1: 4}, {4: -7}])
def test_a_late_camera_that_has_anothers_images_is_put_in_order_and_in_time(late):
    """The delay is of the images that have the camera's name, whose calibration it has."""
    rig, n, points = ring(5), 80, dance(n=12, frames=100)
    each = [observe(rig.select([one.name]), points[:, 10 + by : 10 + by + n], noise=0.1, seed=c)[0]
            for c, (one, by) in enumerate(zip(rig, (late.get(c, 0) for c in range(5)), strict=True))]  # fmt: skip
    counts, uv, cov = (np.concatenate([getattr(one, name) for one in each]) for name in ("counts", "uv", "cov"))
    seen = type(each[0]).build(rig.names, 100.0, counts, uv, cov)
    tracked = from_detections(inputs(put_in_order(rig, {"c1": "c4", "c4": "c1"})), {"detect": seen})
    told = {one.kind: one for one in tracked.diagnostics}
    assert told.keys() == {"camera_started_apart", "cameras_put_in_order"}
    (name,), images = told["camera_started_apart"].cameras, told["camera_started_apart"].values["images"]
    assert {int(name[1:]): images} == late
    assert told["cameras_put_in_order"].values["images_of_list"] == ("c4", "c1")


def straight_on(frames, sway=3.0, mm_per_frame=12.0):
    """(20, F, 3) mm of markers on somebody who goes straight on, and sways hardly."""
    rng, t = np.random.default_rng(4), np.arange(frames) / 100
    place, phase = rng.uniform([-300, -200, 300], [300, 200, 1700], (20, 1, 3)), rng.uniform(0, 6, (20, 1))
    own = sway * np.sin(2 * np.pi * t + phase)[..., None] * rng.normal(size=(20, 1, 3))
    return place + own + mm_per_frame * (np.arange(frames) - 80)[:, None] * [1.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("late", "by", "kind"), [(4, (0.0, 0.0), "camera_started_apart"), (0, (-14.0, 0.0), "camera_put_right")]
)
def test_a_camera_that_is_late_and_one_that_was_turned_are_told_apart_by_who_goes_straight_on(late, by, kind):
    points = straight_on(160)
    each = [observe(RIG.select([one.name]), points[:, 30 + n : 130 + n], noise=0.2, seed=c)[0]
            for c, (one, n) in enumerate(zip(RIG, (0, late, 0, 0, 0, 0), strict=True))]  # fmt: skip
    counts, uv, cov = (np.concatenate([getattr(one, name) for one in each]) for name in ("counts", "uv", "cov"))
    seen = type(each[0]).build(RIG.names, 100.0, counts, uv, cov)
    seen = replace(seen, uv=seen.uv + (seen.camera == 1)[:, None] * np.array(by))
    tracked = from_detections(inputs(RIG), {"detect": seen})
    assert [(one.kind, one.cameras) for one in tracked.diagnostics] == [(kind, ("c1",))]
