"""A camera that dropped images within a recording was not touched: its later images go where they belong."""

from dataclasses import replace
from itertools import combinations_with_replacement
from types import SimpleNamespace

import numpy as np
import pytest

from kinemark.data import make_finding
from kinemark.engine.camera_checks.dropped_images import dropped_images, least_shifts, shifts_to_ask, sure_steps
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


def as_many(detections, n):
    """Every camera has images to the end, n frames before that of the others: the one that dropped n went on."""
    return detections.frames(0, FRAMES - n)


def twice(detections, at, camera=1):
    """The camera has the image of a frame once more in the next: each later one stands later."""
    frame = np.where((detections.camera == camera) & (detections.frame > at), detections.frame + 1, detections.frame)
    again = (detections.camera == camera) & (detections.frame == at)
    rows = np.concatenate([np.flatnonzero(frame < FRAMES), np.flatnonzero(again)])
    frame = np.concatenate([frame[frame < FRAMES], frame[again] + 1])
    order = np.lexsort([frame, detections.camera[rows]])
    rows, frame, counts = rows[order], frame[order], np.zeros_like(detections.counts)
    np.add.at(counts, (detections.camera[rows], frame), 1)
    return type(detections).build(
        detections.cameras, detections.rate, counts, uv=detections.uv[rows], cov=detections.cov[rows]
    )


@pytest.mark.parametrize("frames", [[40], [50, 51, 52]])
def test_a_camera_that_dropped_images_and_has_as_many_as_the_others_is_told(seen, frames):
    found = tracked(as_many(without(seen, frames), len(frames)))
    assert {(one.kind, one.cameras) for one in found.diagnostics} == {("camera_dropped_images", ("c1",))}
    assert sum(one.values["dropped"] for one in found.diagnostics) == len(frames)
    assert all(min(abs(one.frames[0][0] - f) for f in frames) <= 3 for one in found.diagnostics)
    least = 12 * (5 * (FRAMES - len(frames)) - 2 * len(frames))
    assert (found.tracks.cloud.detection >= 0).sum() > 0.99 * least


def test_a_camera_that_has_an_image_twice_is_told_and_has_it_once(seen):
    found = tracked(twice(seen, 60))
    (told,) = found.diagnostics
    assert (told.kind, told.cameras, told.values["dropped"]) == ("camera_dropped_images", ("c1",), -1)
    assert abs(told.frames[0][0] - 60) <= 3 and "has an image twice" in text_of(told)
    assert (found.tracks.cloud.detection >= 0).sum() > 0.99 * len(seen)


@pytest.mark.parametrize("n", [1, 2])
def test_images_of_a_camera_that_has_some_twice_go_back_to_where_they_were_taken(seen, n):
    there = seen
    for at in range(50, 50 + n):
        there = twice(there, at)
    found = [make_finding("camera_dropped_images", cameras=["c1"], frames=[(50, FRAMES - 1)], dropped=-n, images=-n)]
    moved = in_time(found, there)
    for f in (*range(50), *range(51 + n, FRAMES - n - 1)):
        np.testing.assert_array_equal(moved[1, f][moved.valid[moved.rows(1, f)]], seen[1, f])
    assert (~moved.valid).sum() == 12 * n and moved.valid[moved.camera != 1].all()


@pytest.mark.parametrize("equal", [False, True])
def test_a_camera_that_dropped_images_in_the_first_frames_was_started_apart(seen, equal):
    lost = without(seen, [5, 6])
    found = tracked(as_many(lost, 2) if equal else lost)
    (told,) = found.diagnostics
    assert (told.kind, told.cameras, told.values["images"]) == ("camera_started_apart", ("c1",), 2)


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
    among = shifts_to_ask(early, (), RIG)
    assert among == {"c1": (range(3),)}
    told = dropped_images(early, early, RIG, of_others(early), among=among, told=())
    assert "camera_dropped_images" not in {one.kind for one in told}


def test_cameras_are_asked_for_images_that_they_have_fewer_and_all_where_one_is_beside(seen):
    beside = make_finding("camera_in_doubt", cameras=["c2"])
    assert not shifts_to_ask(seen, (), RIG) and shifts_to_ask(seen, (beside,), RIG).keys() == {*RIG.names}


def test_only_of_cameras_that_are_asked_for_dropped_images_are_told(seen):
    lost = without(seen, [60])
    each = [{"c1": (range(2),)}, {"c0": (range(2),), "c2": (range(2),)}]
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


def test_a_step_that_lowers_the_cost_by_chance_alone_is_left_out():
    cost = np.random.default_rng(1).uniform(8.0, 9.0, (3, 80))
    cost[1:, :40] += 1.0
    cost[1, 40:] -= 5.0  # an image late from frame 40 on
    cost[2, 75:] = cost[1, 75:] - 1.0  # and a few frames at the end seem two
    shift = least_shifts(cost)
    assert shift[-1] == 2
    np.testing.assert_array_equal(sure_steps(shift, cost), np.arange(80) >= 40)
