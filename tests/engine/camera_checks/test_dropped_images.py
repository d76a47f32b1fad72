"""A camera that dropped images within a recording was not touched: its later images go where they belong."""

from dataclasses import replace
from itertools import combinations_with_replacement
from types import SimpleNamespace

import numpy as np
import pytest

from kinemark.data import make_finding
from kinemark.engine.camera_checks.dropped_images import dropped_images, fewer_images, least_shifts
from kinemark.engine.camera_checks.start_times import images_late, in_time
from kinemark.engine.tracking_stage import from_detections
from kinemark.reconstruct import LeastSquares
from kinemark.report.words import text_of
from kinemark.signal.common_time import moved_in_time
from kinemark.track.simultaneous.simultaneous_method import DEFAULT
from support.laboratory import observe, ring
from support.motions import dance

RIG, FRAMES = ring(5), 120


@pytest.fixture(scope="module")
def seen():
    return observe(RIG, dance(n=12, frames=FRAMES), noise=0.1)[0]


def without(detections, frames, camera=1):
    """The camera dropped the images of these frames: each later one stands earlier."""
    shift = np.searchsorted(frames, detections.frame, side="right") * (detections.camera == camera)
    kept = ~((detections.camera == camera) & np.isin(detections.frame, frames))
    moved, frame = detections.keep(kept), (detections.frame - shift)[kept]
    counts = np.zeros_like(detections.counts)
    np.add.at(counts, (moved.camera, frame), 1)
    return type(moved).build(moved.cameras, moved.rate, counts, uv=moved.uv, cov=moved.cov)


def tracked(detections):
    settings = SimpleNamespace(
        track=DEFAULT, reconstruct=LeastSquares(), match=None, cameras=SimpleNamespace(delays_ms={})
    )
    source = SimpleNamespace(of=SimpleNamespace(entry=SimpleNamespace(images=None)))
    calibrated = SimpleNamespace(figures={})
    inputs = SimpleNamespace(rig=RIG, settings=settings, source=source, calibrated=calibrated)
    return from_detections(inputs, {"detect": detections})


@pytest.mark.parametrize("frames", [[60], [30, 80], [50, 51]])
def test_images_behind_those_that_a_camera_dropped_are_put_into_their_frames(seen, frames):
    found = tracked(without(seen, frames))
    assert {one.kind for one in found.diagnostics} == {"camera_dropped_images"}
    assert {one.cameras for one in found.diagnostics} == {("c1",)}
    for one in found.diagnostics:
        assert min(abs(one.frames[0][0] - f) for f in frames) <= 3
    assert sum(one.values["dropped"] for one in found.diagnostics) == len(frames)
    assert (found.tracks.cloud.detection >= 0).sum() > 0.99 * len(seen)
    assert "dropped" in text_of(found.diagnostics[0])


@pytest.mark.parametrize("late", [4, -6])
def test_a_camera_that_is_late_and_drops_images_is_put_in_place_by_both(late):
    points = dance(n=12, frames=FRAMES + 20)
    in_time, own = (observe(RIG, points[:, 10 + by : 10 + by + FRAMES], noise=0.1)[0] for by in (0, late))
    counts = np.where(np.arange(len(RIG))[:, None] == 1, own.counts, in_time.counts)
    uv = np.concatenate([one.uv[one.camera == c] for c, one in ((c, own if c == 1 else in_time) for c in range(5))])
    both = without(type(own).build(RIG.names, 100.0, counts, uv), [80])
    found = tracked(both)
    told = {one.kind: one for one in found.diagnostics}
    assert told.keys() == {"camera_started_apart", "camera_dropped_images"}
    dropped = told["camera_dropped_images"]
    assert (told["camera_started_apart"].values["images"], dropped.values["images"]) == (late, late + 1)
    assert abs(dropped.frames[0][0] - 80 - late) <= 3
    assert (found.tracks.cloud.detection >= 0).sum() > 0.99 * (len(both) - 12 * abs(late))


def test_a_camera_that_stopped_early_dropped_none(seen):
    early = seen.keep(~((seen.camera == 1) & (seen.frame >= FRAMES - 2)))
    assert not tracked(early).diagnostics


def of_others(detections, camera=1):
    """Points of the tracks of all cameras but one."""
    rows = np.flatnonzero(detections.camera != camera)
    cloud = tracked(detections.keep(detections.camera != camera)).tracks.cloud
    return replace(cloud, detection=np.where(cloud.detection >= 0, rows[cloud.detection], -1))


@pytest.mark.parametrize("late", [0.5, 0.9, 1.0])
def test_a_camera_that_is_late_all_the_time_and_stopped_early_dropped_none(seen, late):
    """Its images fit the next frame better, or as well, from the first on."""
    there = moved_in_time(seen, np.where(seen.camera == 1, -late / seen.rate, 0.0))
    early = there.keep(~((there.camera == 1) & (there.frame >= FRAMES - 2)))
    assert fewer_images(early) == {"c1": 2}
    assert not [*dropped_images(early, early, RIG, of_others(early), among={"c1": 2}, told=())]


def test_only_of_cameras_that_are_asked_for_dropped_images_are_told(seen):
    lost = without(seen, [60])
    assert fewer_images(lost) == {"c1": 1} and not fewer_images(seen)
    each = [{"c1": 1}, {"c0": 1, "c2": 1}]
    told = [[*dropped_images(lost, lost, RIG, of_others(lost), among=among, told=())] for among in each]
    assert [len(one) for one in told] == [1, 0]


def test_images_go_back_to_where_they_were_taken(seen):
    found = [
        make_finding("camera_dropped_images", cameras=["c1"], frames=[(30, FRAMES - 1)], dropped=1, images=1),
        make_finding("camera_dropped_images", cameras=["c1"], frames=[(50, FRAMES - 1)], dropped=2, images=3),
    ]
    moved = in_time(found, without(seen, [30, 50, 51]))
    for f in range(FRAMES):
        own = seen[1, f] if f not in (30, 50, 51) else seen[1, f][:0]
        np.testing.assert_array_equal(moved[1, f], own)
        np.testing.assert_array_equal(moved[2, f], seen[2, f])
    assert [images_late(found, "c1", f) for f in (29, 31, 50, 52)] == [0, 1, 1, 3]
    assert moved.valid.all() and images_late(found, "c2", 80) == 0


def test_the_shifts_are_those_of_least_cost_that_never_become_less():
    rng = np.random.default_rng(3)
    for _ in range(20):
        cost = rng.uniform(size=(3, 6))
        cost[1:, 0] = 9.0  # a camera begins with the others
        every = [np.array(path) for path in combinations_with_replacement(range(3), 6)]
        best = min(every, key=lambda path: cost[path, np.arange(6)].sum())
        np.testing.assert_array_equal(least_shifts(cost), best)
