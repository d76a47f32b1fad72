"""What a long recording takes of memory."""

import tracemalloc

import numpy as np
import pytest

from kinemark.data import Cloud, Detections
from kinemark.geometry.weighted_points import ImageErrors
from kinemark.track.simultaneous import Simultaneous, track_simultaneously
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following import associate
from kinemark.track.simultaneous.following.passes import Run
from kinemark.track.simultaneous.ghosts import near_held, unmarked_merging
from kinemark.track.simultaneous.ghosts.unmarked_merging import Merging
from kinemark.track.simultaneous.joining.stitch import scores_by_distance
from kinemark.track.simultaneous.noise.measurement_noise import Noise
from kinemark.track.simultaneous.points.neighbouring_points import RowsByTrack, TrackPoints, rows_of
from kinemark.track.simultaneous.points.solved_points import Solver, Working
from kinemark.track.simultaneous.rig import misfitting_cameras, shifted_cameras
from kinemark.track.simultaneous.times import time_offsets
from support.laboratory import ring
from support.scenes import make, scene


@pytest.fixture(scope="module")
def made():
    return make(scene(38)._replace(markers=39, cameras=6, motion="walk", rate=100.0, seconds=2.4))


def test_a_pass_keeps_what_was_associated_and_not_the_states_of_the_tracks(made):
    run = Run(read_images(made.detections, made.rig), made.scene.rate, Simultaneous())
    tracemalloc.start()
    found = run.whole()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(found.id) > 5000
    assert peak < 3 * sum(column.nbytes for column in found)
    assert run.seen == []


def test_time_offsets_from_some_of_the_points_are_those_from_all(made, monkeypatch):
    result = track_simultaneously(made.detections, made.rig, Simultaneous())
    whole = time_offsets.time_offsets(result)
    monkeypatch.setattr(time_offsets, "MAX_PLACES", 8000)
    part = time_offsets.time_offsets(result)
    assert (part.error > whole.error).any()
    np.testing.assert_allclose(part.delay, whole.delay, atol=4 * float(np.hypot(part.error, whole.error).max()))


def test_a_cameras_view_of_all_points_takes_little_and_is_the_same_part_by_part(made, monkeypatch):
    result = track_simultaneously(made.detections, made.rig, Simultaneous())
    whole = misfitting_cameras._peaks(1, result.tracks, result.images)
    monkeypatch.setattr(associate, "AT_ONCE", 777)
    part = misfitting_cameras._peaks(1, result.tracks, result.images)
    assert all(np.array_equal(a, b) for a, b in zip(whole, part, strict=True))
    xyz = np.tile(result.tracks.cloud.xyz, (8, 1))
    tracemalloc.start()
    associate.places_in_image(result.images.P[1], xyz)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3 * xyz.nbytes  # covariances alone are three times as much


def test_where_images_lie_beside_is_looked_at_part_by_part(made, monkeypatch):
    result = track_simultaneously(made.detections, made.rig, Simultaneous())
    by_parts = peak_of(lambda: shifted_cameras.parts_of_recording(result, 1))
    monkeypatch.setattr(shifted_cameras, "PARTS", 1)
    assert by_parts < 0.3 * peak_of(lambda: shifted_cameras.parts_of_recording(result, 1))


def test_merging_looked_at_part_by_part_is_that_of_all_at_once(monkeypatch):
    own = make(scene(38)._replace(markers=39, cameras=6, motion="arms", rate=100.0, seconds=2.4))
    whole = track_simultaneously(own.detections, own.rig, Simultaneous())
    assert whole.images.merged.any()  # inferred: the file marks none
    for module in (unmarked_merging, near_held):
        monkeypatch.setattr(module, "AT_ONCE", 777)
    part = track_simultaneously(own.detections, own.rig, Simultaneous())
    np.testing.assert_array_equal(part.images.merged, whole.images.merged)
    np.testing.assert_array_equal(part.tracks.cloud.xyz, whole.tracks.cloud.xyz)
    np.testing.assert_array_equal(part.tracks.id, whole.tracks.id)


def test_rows_by_track_are_those_of_the_table_and_grow_with_the_points_alone():
    rng = np.random.default_rng(3)
    id, frame = (
        np.arange(2000) * 5,
        rng.integers(0, 5000, 2000),
    )  # most numbers have no point, as dropped tracks have not
    points = TrackPoints(frame, id, np.zeros((2000, 3)), np.zeros((2000, 3, 3)))
    rows, table = RowsByTrack.of(frame, id), rows_of(points)
    asked, when = rng.integers(0, len(table), 9000), rng.integers(-9, table.shape[1] + 9, 9000)
    asked[:2000], when[:2000] = id, frame
    inside = (when >= 0) & (when < table.shape[1])
    np.testing.assert_array_equal(rows.at(asked, when), np.where(inside, table[asked, when * inside], -1))
    assert rows.row.nbytes + rows.place.nbytes == 12 * len(id) < table.nbytes / 1000


def test_images_keep_no_column_that_the_detections_have(made):
    images = read_images(made.detections, made.rig)
    assert images.area is made.detections.area and images.merged is made.detections.merged
    own = (images.uv, images.variance, images.camera, images.frame, images.usable, images.by_cell.order)
    assert sum(column.nbytes for column in own) == 37 * len(made.detections)
    assert not any(images.laid_aside().uv.strides)


def peak_of(run):
    """Bytes that something takes at most, beyond what is there."""
    run()  # what it imports and keeps for later is not of the recording
    tracemalloc.start()
    run()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def short_fragments(n, length=10):
    """Points of n fragments one after the other, beside three markers that are there all the time."""
    frame = np.arange(n * length)
    ids = [np.repeat(np.arange(n), length), *(np.full(len(frame), n + k) for k in range(3))]
    rng = np.random.default_rng(0)
    xyz = rng.normal(size=(4 * len(frame), 3)) + 100 * np.repeat(np.arange(4), len(frame))[:, None]
    return TrackPoints(np.tile(frame, 4), np.concatenate(ids), xyz, np.tile(np.eye(3), (len(xyz), 1, 1)))


def test_stitching_takes_memory_with_the_points_and_not_with_tracks_times_frames():
    one, other = np.array([0]), np.array([1])
    few, many = short_fragments(400), short_fragments(1600)
    least = peak_of(lambda: scores_by_distance(few, one, other, np.zeros(1)))
    assert peak_of(lambda: scores_by_distance(many, one, other, np.zeros(1))) < 5 * least


def test_images_of_two_markers_are_told_apart_without_a_copy_of_all_images():
    rig, D, n = ring(2), 100_000, 10
    detections = Detections.build(rig.names, 100.0, np.ones((2, D // 2)), np.full((D, 2), 500.0))
    images, none = read_images(detections, rig), np.zeros(2)
    working = Working(rig, images, Noise(none, none, none, none, none, none))
    solver = Solver(detections, working, np.zeros(D, bool), ImageErrors())
    image, ones = np.arange(n), np.ones(n)
    merging = Merging(image, 1.0, np.zeros(n, np.int64), ones > 0, np.full((n, 2), 3.0), 2 * ones, ones)
    detection = np.stack([image, np.full(n, -1)], 1)
    start = np.minimum(np.arange(D // 2 + 1), n)
    cloud = Cloud(100.0, start, np.zeros((n, 3)), np.zeros((n, 3, 3)), np.zeros(n), detection)
    told = merging.told_apart(cloud, np.zeros(n, np.int64), solver)
    assert np.hypot(*(told.uv(image) - 500.0).T) == pytest.approx(np.hypot(3, 3), rel=0.2)
    assert peak_of(lambda: merging.told_apart(cloud, np.zeros(n, np.int64), solver)) < detections.uv.nbytes
