"""What the tracker does over again: wrong images left out, tracks that strayed, and the second look."""

import numpy as np
import pytest

from kinemark.data import Cloud
from kinemark.synth.score import score
from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.associate import Association, information, predict_images
from kinemark.track.simultaneous.following.kalman_states import KalmanStates, update
from kinemark.track.simultaneous.following.likelihood import FAIR, SURE, evidence
from kinemark.track.simultaneous.following.passes import Associations, _off_without_itself, without_outliers
from kinemark.track.simultaneous.joining import stitch as stitch_module
from kinemark.track.simultaneous.joining.stitch import stitched
from kinemark.track.simultaneous.points import second_pass as second
from kinemark.track.simultaneous.points.neighbouring_points import TrackPoints
from kinemark.track.simultaneous.points.second_pass import second_pass
from kinemark.track.simultaneous.points.solved_points import precise_enough
from kinemark.track.simultaneous.tracker import _without_evidence
from support.laboratory import observe, ring
from support.motions import dance

RATE, METHOD = 100.0, Simultaneous()


def test_an_image_is_judged_by_what_all_the_others_say():
    """Against the filter told of the others only, and the innovation of the one left out."""
    rng = np.random.default_rng(4)
    images, points, detection = made(n=3, frames=1, cameras=5)
    root = rng.normal(0, 1, (3, 9, 9))
    V = (root @ root.swapaxes(1, 2)).transpose(1, 2, 0) + np.eye(9)[..., None]
    before = KalmanStates(np.concatenate([points.xyz.T + rng.normal(0, 0.5, (3, 3)), np.zeros((6, 3))]), V)
    expected = predict_images(images.P, before)
    association = Association(detection, images.variance[detection], np.zeros(detection.shape), detection < 0)
    after = update(before, *information(images, expected, association))
    off = images.uv[detection].swapaxes(1, 2) - expected.uv - (expected.J * (after.position - before.position)).sum(2)
    found = _off_without_itself(off, association.variance, predict_images(images.P, after).S)
    for c, t in np.ndindex(detection.shape):
        out = np.arange(5)[:, None] == c
        others = association._replace(
            detection=np.where(out, -1, detection), variance=np.where(out, np.inf, association.variance)
        )
        without = update(before, *information(images, expected, others))
        J = expected.J[c, :, :, t]
        left = images.uv[detection[c, t]] - expected.uv[c, :, t] - J @ (without.position - before.position)[:, t]
        cov = J @ without.cov[..., t] @ J.T + np.eye(2) * association.variance[c, t]
        assert found[c, t] == pytest.approx(left @ np.linalg.solve(cov, left), rel=0.02)


def sightings(frame, id, *, own=3, before=1.0, squared=1.0, cameras=6):
    """Associations of tracks that have `own` images each."""
    n = len(frame)
    detection = np.full((cameras, n), -1)
    for k, count in enumerate(np.broadcast_to(own, n)):
        detection[:count, k] = np.arange(count)
    each = (np.broadcast_to(value, n).astype(float) for value in (squared, before))
    none = np.zeros(detection.shape, bool)
    return Associations(np.array(frame), np.array(id), detection, none, *each, np.zeros((3, n)), np.zeros((3, 3, n)))


def test_what_a_lost_track_finds_must_be_evidence():
    frame = [10, 11, 12, *range(13, 20), *range(20, 24), 24, *range(9, 2, -1)]
    lost = [20 <= f < 24 for f in frame]
    before = [30.0 if 22 <= f <= 24 else 1.0 for f in frame]
    own = np.where(lost, 1, 2)
    seen = sightings(frame, [0] * len(frame), own=own, before=before)
    assert [
        f for f, gone in zip(frame, _without_evidence(seen, seen.detection >= 0, 4, METHOD), strict=True) if gone
    ] == [
        22,
        23,
        24,
    ]
    more = sightings(frame, [0] * len(frame), own=np.where(np.array(frame) == 24, 4, own), before=before)
    assert [
        f for f, gone in zip(frame, _without_evidence(more, more.detection >= 0, 4, METHOD), strict=True) if gone
    ] == [
        22,
        23,
    ]
    bad = sightings(frame, [0] * len(frame), own=np.where(np.array(frame) > 23, 2, own), before=before, squared=60.0)
    found = {"own": [2] * 4 + [1] * 4 + [2] * 10, "before": [1.0] * 8 + [30.0] + [1.0] * 9, "squared": 60.0}
    longer = sightings(list(range(10, 28)), [0] * 18, **found)
    assert (
        _without_evidence(bad, bad.detection >= 0, 4, METHOD).any()
        and not _without_evidence(longer, longer.detection >= 0, 10, METHOD).any()
    )
    wide = sightings(frame, [0] * len(frame), own=2, before=30.0)
    assert not _without_evidence(wide, wide.detection >= 0, 4, METHOD).any(), "never lost, its place is only vague"
    backwards = sightings([10, 11, 12, 9, 8, 7, 6], [0] * 7, own=[2, 2, 2, 1, 1, 2, 1], before=[1, 1, 1, 1, 30, 30, 5])
    assert np.flatnonzero(_without_evidence(backwards, backwards.detection >= 0, 4, METHOD)).tolist() == [4, 5, 6]


def test_a_track_is_not_lost_where_it_was_initiated():
    """Two neighbouring cameras leave the depth vague; it goes on backwards from its first points, not from its end."""
    own = [2, 2, 2, 1, 1, 2, 1]
    seen = sightings([10, 11, 12, 13, 14, 9, 8], [0] * 7, own=own, before=[30, 20, 20, 20, 30, 30, 30])
    assert np.flatnonzero(_without_evidence(seen, seen.detection >= 0, 4, METHOD)).tolist() == [4]


@pytest.mark.parametrize(("own", "sd", "given"), [(2, 90.0, True), (2, 110.0, False), (1, 1.9, True), (1, 2.1, False)])
def test_points_of_merged_images_must_be_known_better(own, sd, given):
    cov = np.eye(3)[None] * sd**2 / 3
    cloud = Cloud(RATE, np.array([0, 1]), np.zeros((1, 3)), cov, np.zeros(1), np.zeros((1, 2), int))
    assert precise_enough(cloud.cov, np.array([own]), METHOD).tolist() == [given]


def test_two_images_that_agree_half_are_no_marker():
    frame, id = list(range(30)), [0] * 30
    for squared, marker in ((0.0, True), (1.0, True), (2.2, False)):
        pairs = sightings(frame, id, own=2, squared=squared)
        (total,) = evidence(pairs, pairs.detection >= 0, METHOD.gate)
        assert (total > SURE) == marker
        own = [3, *[2] * 29]
        (total,) = evidence(once := sightings(frame, id, own=own, squared=squared), once.detection >= 0, METHOD.gate)
        assert total > SURE, "three cameras saw it once"
    assert 0.4 < FAIR < 0.5


def made(n=6, frames=60, cameras=6, seed=2):
    """Images of a dance, its points with the images that belong to them, and their covariances."""
    rig, xyz = ring(cameras), dance(n=n, frames=frames, seed=seed)
    detections, marker = observe(rig, xyz, noise=0.1, seed=seed)
    images = read_images(detections, rig)
    detection = np.full((cameras, n * frames), -1)
    place = marker * frames + images.frame
    detection[images.camera[marker >= 0], place[marker >= 0]] = np.flatnonzero(marker >= 0)
    id, frame = np.divmod(np.arange(n * frames), frames)
    cov = np.tile(np.eye(3) * 0.1, (len(id), 1, 1))
    return images, TrackPoints(frame, id, xyz.reshape(-1, 3), cov), detection


def without(detection, keep):
    """The views with images of these cameras only."""
    return np.where(np.isin(np.arange(len(detection)), keep)[:, None], detection, -1)


def test_frames_that_two_cameras_see_are_found_between_known_ones():
    images, points, detection = made()
    gap = (points.id == 0) & (points.frame >= 20) & (points.frame < 28)
    usable = images.usable.copy()
    usable[detection[2:, gap][detection[2:, gap] >= 0]] = False  # two cameras alone have images of it there
    images = images._replace(usable=usable)
    again = second_pass(points.take(~gap), detection[:, ~gap], images, 1 / RATE, METHOD)
    assert again.kept.all() and again.found.id.tolist() == [0] * 8
    order = np.argsort(again.found.frame)
    assert again.found.frame[order].tolist() == list(range(20, 28))
    assert (again.detection[:, order] == without(detection[:, gap], [0, 1])).all()
    assert np.linalg.norm(again.found.xyz[order] - points.xyz[gap], axis=1).max() < 3


def test_a_track_goes_on_beyond_its_end_only_where_three_cameras_saw_it():
    images, points, detection = made()
    late = (points.id == 0) & (points.frame >= 40)
    again = second_pass(points.take(~late), detection[:, ~late], images, 1 / RATE, METHOD)
    found = np.sort(again.found.frame)
    assert (found == np.arange(40, 40 + len(found))).all() and len(found) >= 8, "each look some frames on"
    assert set(again.found.id.tolist()) == {0}
    two = np.where(points.id == 0, without(detection, [0, 1]), detection)
    again = second_pass(points.take(~late), two[:, ~late], images, 1 / RATE, METHOD)
    assert not (again.found.id == 0).any()


def test_a_point_elsewhere_is_given_up_and_found_again():
    images, points, detection = made()
    at = int(np.flatnonzero((points.id == 1) & (points.frame == 30))[0])
    wrong = detection.copy()
    wrong[2:, at] = -1
    xyz = points.xyz.copy()
    xyz[at] += [40.0, 0, 0]
    again = second_pass(points._replace(xyz=xyz), wrong, images, 1 / RATE, METHOD)
    assert np.flatnonzero(~again.kept).tolist() == [at]
    assert again.found.id.tolist() == [1] and again.found.frame.tolist() == [30]
    assert (again.detection[:, 0] == detection[:, at]).all() and np.linalg.norm(again.found.xyz[0] - points.xyz[at]) < 1


def test_a_point_of_two_images_gets_the_third_that_is_free():
    images, points, detection = made()
    at = (points.id == 2) & (points.frame == 15)
    less = np.where(at, without(detection, [0, 1]), detection)
    again = second_pass(points, less, images, 1 / RATE, METHOD)
    assert (~again.kept == at).all() and (again.detection[:, 0] == detection[:, at][:, 0]).all()


def test_images_that_known_points_have_are_not_taken():
    images, points, detection = made(n=1)
    other = points._replace(
        id=points.id + 1, xyz=np.add(points.xyz, [0.0, 0.0, 4.0])
    )  # so near that its images would fit
    gap = (points.frame >= 20) & (points.frame < 24)
    both, views = points.take(~gap).plus(other), np.concatenate([detection[:, ~gap], detection], 1)
    assert not len(second_pass(both, views, images, 1 / RATE, METHOD).found.id)
    alone = second_pass(points.take(~gap), detection[:, ~gap], images, 1 / RATE, METHOD)
    assert len(alone.found.id) == 4


def test_a_point_elsewhere_without_better_images_is_given_up():
    images, points, detection = made()
    at = int(np.flatnonzero((points.id == 1) & (points.frame == 30))[0])
    usable = images.usable.copy()
    usable[detection[2:, at][detection[2:, at] >= 0]] = False
    less, xyz, uv = detection.copy(), points.xyz.copy(), images.uv.copy()
    less[2:, at] = -1
    xyz[at] += [40.0, 0, 0]
    for c in (0, 1):
        uv[detection[c, at]] = predict_images(
            images.P, KalmanStates(np.append(xyz[at], np.zeros(6))[:, None], np.eye(9)[..., None])
        ).uv[c, :, 0]
    odd = second_pass(points._replace(xyz=xyz), less, images._replace(usable=usable, uv=uv), 1 / RATE, METHOD)
    assert np.flatnonzero(~odd.kept).tolist() == [at] and not len(odd.found.id)


def test_of_three_cameras_all_images_of_a_point_count_anew():
    images, points, detection = made(cameras=3)
    at = (points.id == 2) & (points.frame == 15)
    again = second_pass(points, np.where(at, without(detection, [0, 1]), detection), images, 1 / RATE, METHOD)
    assert (~again.kept == at).all() and (again.detection[:, 0] == detection[:, at][:, 0]).all()


def test_nothing_is_claimed_where_the_place_is_open():
    images, points, detection = made(frames=90)
    gap = (points.id == 0) & (points.frame >= 10) & (points.frame < 80)
    found = second_pass(points.take(~gap), detection[:, ~gap], images, 1 / RATE, METHOD).found
    assert 10 < len(found.id) < 40 and {10, 79} <= set(found.frame.tolist())
    assert np.abs(found.frame - 44.5).min() > 15, "frames in the middle"


def test_pairs_alone_do_not_go_on_into_a_gap_of_more_than_the_longest():
    images, points, detection = made(n=1, frames=200)
    gap = (points.frame >= 40) & (points.frame < 160)
    pairs = without(detection, [0, 1])[:, ~gap]
    assert not len(second_pass(points.take(~gap), pairs, images, 1 / RATE, METHOD).found.id)
    assert len(second_pass(points.take(~gap), detection[:, ~gap], images, 1 / RATE, METHOD).found.id) > 4


def test_a_track_goes_back_before_its_first_point():
    images, points, detection = made()
    early = (points.id == 0) & (points.frame < 20)
    found = np.sort(second_pass(points.take(~early), detection[:, ~early], images, 1 / RATE, METHOD).found.frame)
    assert (found == np.arange(20 - len(found), 20)).all() and len(found) >= 8


def test_the_wrong_image_of_four_is_given_back():
    """Not the one that is farthest off, which may be a good one that the wrong one has drawn the point away from."""
    rng, right = np.random.default_rng(3), 0
    for seed in range(40):
        images, points, detection = made(n=1, frames=1, cameras=4, seed=seed)
        uv, wrong = images.uv.copy(), int(rng.integers(4))
        off = rng.normal(size=2)
        uv[detection[wrong, 0]] += 8 * off / np.linalg.norm(off)
        variance = np.full(len(uv), 0.3**2)
        variance[detection[wrong, 0]] = 0.1**2  # it says that it is the surest
        images = images._replace(uv=uv, variance=variance)
        V = np.diag([400.0] * 3 + [1e6] * 6)[..., None]
        before = KalmanStates(np.append(points.xyz[0] + rng.normal(0, 10, 3), np.zeros(6))[:, None], V)
        expected = predict_images(images.P, before)
        association = Association(detection, images.variance[detection], np.ones(detection.shape), detection < 0)
        after = update(before, *information(images, expected, association))
        kept = (
            without_outliers(images, METHOD.gate, before, expected, association, after).association.detection[:, 0] >= 0
        )
        right += (kept == (np.arange(4) != wrong)).all()
    assert right >= 38


def test_what_a_lost_track_meets_by_chance_is_no_point_of_it():
    """A marker goes out of all cameras' sight, and two false images meet near where it would be, for three frames."""
    rig, xyz = ring(6), dance(n=5, frames=70, seed=3)
    ghost = np.full((1, 70, 3), np.nan)
    ghost[0, 34:37] = xyz[2, 34:37] + [15.0, 10.0, 0.0]
    detections, marker = observe(rig, np.concatenate([xyz, ghost]), noise=0.1, seed=3)
    f, c = detections.frame, detections.camera
    hidden = (marker == 2) & (f >= 30) & (f < 50)
    tracks = track_detections(detections.keep(~hidden & ((marker < 5) | (c < 2))), rig)
    found = score(tracks, xyz)
    assert found.extra_per_frame == 0 and found.swaps == 0
    assert not np.isin(tracks.cloud.frame[found.owner == 2], range(33, 47)).any()


def test_nothing_to_look_at():
    images, points, detection = made(n=2, frames=8)
    none = np.zeros(len(points.id), bool)
    again = second_pass(points.take(none), detection[:, none], images, 1 / RATE, METHOD)
    assert not len(again.kept) and not len(again.found.id)
    pairs = without(detection, [0, 1])
    again = second_pass(points, pairs, images, 1 / RATE, METHOD)
    assert again.kept.all() and not len(again.found.id)


def test_one_camera_for_a_while_and_two_for_a_moment():
    """A marker that one camera loses sight of for 150 ms, but for a moment of which two have images."""
    rig, xyz = ring(6), dance(n=8, frames=80, seed=3)
    detections, marker = observe(rig, xyz, noise=0.1, seed=3)
    f, c = detections.frame, detections.camera
    hidden = (marker == 4) & (f >= 30) & (f < 45) & (c != 0) & ~((c == 3) & (f >= 37) & (f < 40))
    tracks = track_detections(detections.keep(~hidden), rig)
    seen = np.ones(xyz.shape[:2], bool)
    seen[4, 30:45] = False
    seen[4, 37:40] = True
    found = score(tracks, xyz, seen=seen)
    assert found.recall == 1 and found.extra_per_frame == 0 and len(tracks) == 8


def test_markers_that_come_late_are_born_in_a_later_stretch():
    rig, xyz = ring(5), dance(n=3, frames=160)
    detections, _ = observe(rig, xyz, noise=0.1)
    late = detections.keep(detections.frame >= 100)
    assert score(track_detections(late, rig), np.where(np.arange(160)[:, None] >= 100, xyz, np.nan)).recall == 1


def test_looking_in_parts_changes_nothing(monkeypatch):
    images, points, detection = made()
    gone = np.random.default_rng(6).random(len(points.id)) < 0.3
    args = points.take(~gone), detection[:, ~gone], images, 1 / RATE, METHOD
    whole = second_pass(*args)
    monkeypatch.setattr(second, "AT_ONCE", 7)
    parts = second_pass(*args)
    assert len(whole.found.id) > 50 and (whole.detection == parts.detection).all() and (whole.kept == parts.kept).all()
    assert (whole.found.frame == parts.found.frame).all()


def test_joining_in_parts_changes_nothing(monkeypatch):
    xyz = dance(n=6, frames=60)
    id, frame = np.divmod(np.arange(6 * 60), 60)
    there = (frame < 25) | (frame > 28)
    points = TrackPoints(
        frame, np.where(frame < 25, id, id + 6), xyz.reshape(-1, 3), np.tile(np.eye(3) * 0.1, (360, 1, 1))
    )
    whole = stitched(points.take(there), 1 / RATE, METHOD)
    monkeypatch.setattr(stitch_module, "AT_ONCE", 5)
    parts = stitched(points.take(there), 1 / RATE, METHOD)
    assert len(np.unique(whole.id)) == 6 and (whole.id == parts.id).all() and whole.stitches == parts.stitches
