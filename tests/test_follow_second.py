"""What the tracker does over again: wrong images left out, tracks that strayed, and the second look."""

import numpy as np
import pytest
from laboratory import observe, ring
from test_follow import dance

from kinemark.follow import Simultaneous, follow
from kinemark.follow.claims import Claims, expect, information
from kinemark.follow.evidence import FAIR, SURE, evidence
from kinemark.follow.images import read_images
from kinemark.follow.motion import Motion, told
from kinemark.follow.paths import Points
from kinemark.follow.run import Sightings, _without_itself
from kinemark.follow.second import looked_again
from kinemark.follow.simultaneous import _strayed
from kinemark.score import score

RATE, METHOD = 100.0, Simultaneous()


def test_an_image_is_judged_by_what_all_the_others_say():
    """Against the filter told of the others only, and the innovation of the one left out."""
    rng = np.random.default_rng(4)
    images, points, row = made(n=3, frames=1, cameras=5)
    root = rng.normal(0, 1, (3, 9, 9))
    V = (root @ root.swapaxes(1, 2)).transpose(1, 2, 0) + np.eye(9)[..., None]
    before = Motion(np.concatenate([points.xyz.T + rng.normal(0, 0.5, (3, 3)), np.zeros((6, 3))]), V)
    expected = expect(images.P, before)
    claims = Claims(row, images.variance[row], np.zeros(row.shape), row < 0)
    after = told(before, *information(images, expected, claims))
    off = images.uv[row].swapaxes(1, 2) - expected.uv - (expected.J * (after.position - before.position)).sum(2)
    found = _without_itself(off, claims.variance, expect(images.P, after).S)
    for c, t in np.ndindex(row.shape):
        out = np.arange(5)[:, None] == c
        others = claims._replace(row=np.where(out, -1, row), variance=np.where(out, np.inf, claims.variance))
        without = told(before, *information(images, expected, others))
        J = expected.J[c, :, :, t]
        left = images.uv[row[c, t]] - expected.uv[c, :, t] - J @ (without.position - before.position)[:, t]
        cov = J @ without.cov[..., t] @ J.T + np.eye(2) * claims.variance[c, t]
        assert found[c, t] == pytest.approx(left @ np.linalg.solve(cov, left), rel=0.02)


def sightings(frame, id, *, own=3, before=1.0, squared=1.0, cameras=6):
    """Sightings of tracks that have `own` images each."""
    n = len(frame)
    row = np.full((cameras, n), -1)
    for k, count in enumerate(np.broadcast_to(own, n)):
        row[:count, k] = np.arange(count)
    each = (np.broadcast_to(value, n).astype(float) for value in (squared, before))
    return Sightings(np.array(frame), np.array(id), row, row > 99, *each, np.zeros((3, n)), np.zeros((3, 3, n)))


def test_what_a_lost_track_finds_must_be_evidence():
    frame = [10, 11, 12, *range(13, 20), *range(20, 24), 24, *range(9, 2, -1)]
    lost = [20 <= f < 24 for f in frame]
    before = [30.0 if 22 <= f <= 24 else 1.0 for f in frame]
    own = np.where(lost, 1, 2)
    seen = sightings(frame, [0] * len(frame), own=own, before=before)
    assert [f for f, gone in zip(frame, _strayed(seen, seen.row >= 0, 4, METHOD), strict=True) if gone] == [22, 23, 24]
    more = sightings(frame, [0] * len(frame), own=np.where(np.array(frame) == 24, 4, own), before=before)
    assert [f for f, gone in zip(frame, _strayed(more, more.row >= 0, 4, METHOD), strict=True) if gone] == [22, 23]
    wide = sightings(frame, [0] * len(frame), own=2, before=30.0)
    assert not _strayed(wide, wide.row >= 0, 4, METHOD).any(), "never lost, its place is only vague"
    backwards = sightings([10, 11, 12, 9, 8, 7, 6], [0] * 7, own=[2, 2, 2, 1, 1, 2, 1], before=[1, 1, 1, 1, 30, 30, 5])
    assert np.flatnonzero(_strayed(backwards, backwards.row >= 0, 4, METHOD)).tolist() == [4, 5, 6]


def test_two_images_that_agree_half_are_no_marker():
    frame, id = list(range(30)), [0] * 30
    for squared, marker in ((0.0, True), (1.0, True), (2.2, False)):
        pairs = sightings(frame, id, own=2, squared=squared)
        (total,) = evidence(pairs, pairs.row >= 0, METHOD.gate)
        assert (total > SURE) == marker
        own = [3, *[2] * 29]
        (total,) = evidence(once := sightings(frame, id, own=own, squared=squared), once.row >= 0, METHOD.gate)
        assert total > SURE, "three cameras saw it once"
    assert 0.4 < FAIR < 0.5


def made(n=6, frames=60, cameras=6, seed=2):
    """Images of a dance, its points with the images that belong to them, and their covariances."""
    rig, xyz = ring(cameras), dance(n=n, frames=frames, seed=seed)
    detections, marker = observe(rig, xyz, noise=0.1, seed=seed)
    images = read_images(detections, rig)
    row = np.full((cameras, n * frames), -1)
    place = marker * frames + images.frame
    row[images.camera[marker >= 0], place[marker >= 0]] = np.flatnonzero(marker >= 0)
    id, frame = np.divmod(np.arange(n * frames), frames)
    cov = np.tile(np.eye(3) * 0.1, (len(id), 1, 1))
    return images, Points(frame, id, xyz.reshape(-1, 3), cov), row


def without(row, keep):
    """The views with images of these cameras only."""
    return np.where(np.isin(np.arange(len(row)), keep)[:, None], row, -1)


def test_frames_that_two_cameras_see_are_found_between_known_ones():
    images, points, row = made()
    gap = (points.id == 0) & (points.frame >= 20) & (points.frame < 28)
    usable = images.usable.copy()
    usable[row[2:, gap][row[2:, gap] >= 0]] = False  # two cameras alone have images of it there
    images = images._replace(usable=usable)
    again = looked_again(points.take(~gap), row[:, ~gap], images, 1 / RATE, METHOD)
    assert again.kept.all() and again.found.id.tolist() == [0] * 8
    order = np.argsort(again.found.frame)
    assert again.found.frame[order].tolist() == list(range(20, 28))
    assert (again.row[:, order] == without(row[:, gap], [0, 1])).all()
    assert np.linalg.norm(again.found.xyz[order] - points.xyz[gap], axis=1).max() < 3


def test_a_track_goes_on_beyond_its_end_only_where_three_cameras_saw_it():
    images, points, row = made()
    late = (points.id == 0) & (points.frame >= 40)
    again = looked_again(points.take(~late), row[:, ~late], images, 1 / RATE, METHOD)
    found = np.sort(again.found.frame)
    assert (found == np.arange(40, 40 + len(found))).all() and len(found) >= 8, "each look some frames on"
    assert set(again.found.id.tolist()) == {0}
    two = np.where(points.id == 0, without(row, [0, 1]), row)
    again = looked_again(points.take(~late), two[:, ~late], images, 1 / RATE, METHOD)
    assert not (again.found.id == 0).any()


def test_a_point_elsewhere_is_given_up_and_found_again():
    images, points, row = made()
    at = int(np.flatnonzero((points.id == 1) & (points.frame == 30))[0])
    wrong = row.copy()
    wrong[2:, at] = -1
    xyz = points.xyz.copy()
    xyz[at] += [40.0, 0, 0]
    again = looked_again(points._replace(xyz=xyz), wrong, images, 1 / RATE, METHOD)
    assert np.flatnonzero(~again.kept).tolist() == [at]
    assert again.found.id.tolist() == [1] and again.found.frame.tolist() == [30]
    assert (again.row[:, 0] == row[:, at]).all() and np.linalg.norm(again.found.xyz[0] - points.xyz[at]) < 1


def test_a_point_of_two_images_gets_the_third_that_is_free():
    images, points, row = made()
    at = (points.id == 2) & (points.frame == 15)
    less = np.where(at, without(row, [0, 1]), row)
    again = looked_again(points, less, images, 1 / RATE, METHOD)
    assert (~again.kept == at).all() and (again.row[:, 0] == row[:, at][:, 0]).all()


def test_nothing_to_look_at():
    images, points, row = made(n=2, frames=8)
    none = np.zeros(len(points.id), bool)
    again = looked_again(points.take(none), row[:, none], images, 1 / RATE, METHOD)
    assert not len(again.kept) and not len(again.found.id)
    pairs = without(row, [0, 1])
    again = looked_again(points, pairs, images, 1 / RATE, METHOD)
    assert again.kept.all() and not len(again.found.id)


def test_one_camera_for_a_while_and_two_for_a_moment():
    """A marker that one camera loses sight of for 150 ms, but for a moment of which two have images."""
    rig, xyz = ring(6), dance(n=8, frames=80, seed=3)
    detections, marker = observe(rig, xyz, noise=0.1, seed=3)
    f, c = detections.frame, detections.camera
    hidden = (marker == 4) & (f >= 30) & (f < 45) & (c != 0) & ~((c == 3) & (f >= 37) & (f < 40))
    tracks = follow(detections.keep(~hidden), rig)
    seen = np.ones(xyz.shape[:2], bool)
    seen[4, 30:45] = False
    seen[4, 37:40] = True
    found = score(tracks, xyz, seen=seen)
    assert found.recall == 1 and found.extra_per_frame == 0 and len(tracks) == 8
