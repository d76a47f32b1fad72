"""Tracks of a plate that moves by half of its pitch from frame to frame are told by their places on it."""

import numpy as np

from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.bodies import rigid_bodies
from kinemark.track.simultaneous.bodies.body_poses import body_poses, in_place
from kinemark.track.simultaneous.bodies.rigid_bodies import fitted, learned_bodies
from kinemark.track.simultaneous.bodies.rigid_pass import RigidPass
from kinemark.track.simultaneous.bodies.same_body import joined_bodies
from kinemark.track.simultaneous.points import found_points
from kinemark.track.simultaneous.points.neighbouring_points import TrackPoints, rows_of
from support.laboratory import observe, ring

RATE, F = 25.0, 300
PLACES = 100.0 * np.array([[0, 0], [1, 0], [3, 0], [0, 1], [2, 1], [3, 2], [1, 3], [4, 3], [0, 4], [2, 4]], float)


def plate(F=F):
    """(10, F, 3) mm: a plate on a grid of 100 mm that turns and is carried about, gently and at times fast, to 1 mm."""
    t = np.arange(F) / RATE
    turn = 0.4 * np.sin(2 * np.pi * 0.2 * t)
    R = np.array([[np.cos(turn), -np.sin(turn), 0 * t], [np.sin(turn), np.cos(turn), 0 * t], [0 * t, 0 * t, 0 * t + 1]])
    path = 200 * np.sin(2 * np.pi * 0.15 * t[:, None] + np.array([0.0, 1.0, 2.0]))
    inside = np.column_stack([PLACES - 180, np.full(len(PLACES), 1000.0)])
    return path + np.einsum("ijf,mj->mfi", R, inside) + np.random.default_rng(1).normal(0, 1.0, (len(PLACES), F, 3))


def in_pieces(xyz, goes_over=(), length=60):
    """Points of markers (M, F, 3), of which each piece of `length` frames is a track; in frames `goes_over` those of
    the pieces are the next marker's."""
    M, F = xyz.shape[:2]
    frame, marker = (column.ravel() for column in np.meshgrid(np.arange(F), np.arange(M), indexing="ij"))
    id = marker + M * (frame // length)
    wrong = np.isin(frame, goes_over)
    id[wrong] = (marker[wrong] + 1) % M + M * (frame[wrong] // length)
    return TrackPoints(frame, id, xyz[marker, frame], np.broadcast_to(np.eye(3), (len(frame), 3, 3))), marker


def test_pieces_that_go_over_are_told_by_their_places():
    points, marker = in_pieces(plate(), goes_over=[30, 31, 95, 150])
    rows = rows_of(points)
    (body,) = joined_bodies(learned_bodies(points, rows), rows >= 0)
    assert len(body.shape) == len(PLACES)
    poses = body_poses(body, points, rows, lambda f: np.zeros((0, 3)))
    assert (poses.fit > 0).all()
    member = in_place(body, poses, points).member
    which = [np.unique(member[marker == m]) for m in range(len(PLACES))]
    assert sorted(int(one[0]) for one in which) == list(range(len(PLACES))) and all(len(one) == 1 for one in which)


def test_only_poses_that_lose_a_member_are_fitted_again(monkeypatch):
    xyz = plate(40).swapaxes(0, 1).copy()
    shape, reach, aligned, frames = xyz[0].copy(), np.full(len(PLACES), 10.0), rigid_bodies._aligned, []
    xyz[[3, 17], 5] += 400
    xyz[17, 2] -= 250
    alone = [fitted(shape, one[None], reach) for one in xyz]

    def noted(A, at, used):
        frames.append(len(at))
        return aligned(A, at, used)

    monkeypatch.setattr(rigid_bodies, "_aligned", noted)
    poses = fitted(shape, xyz, reach)
    assert frames == [40, 2, 1]
    assert poses.fit[[3, 17]].tolist() == [9, 8] and (np.delete(poses.fit, [3, 17]) == 10).all()
    for column, *each in zip(poses, *alone, strict=True):
        np.testing.assert_allclose(column, np.concatenate(each), rtol=1e-9, atol=1e-9)


def test_a_body_that_is_seen_again_is_the_same_and_one_beside_it_is_not():
    xyz = plate()
    points, _ = in_pieces(xyz, length=150)  # no track is in both halves
    rows = rows_of(points)
    assert len(learned_bodies(points, rows)) == 2
    assert len(joined_bodies(learned_bodies(points, rows), rows >= 0)) == 1
    t = np.arange(F)[:, None] / RATE
    other = xyz + 700.0 + 150 * np.sin(2 * np.pi * 0.37 * t + np.array([2.0, 0.0, 1.0]))
    both, _ = in_pieces(np.concatenate([xyz, other]), length=F)
    rows = rows_of(both)
    assert [len(body.shape) for body in joined_bodies(learned_bodies(both, rows), rows >= 0)] == [10, 10]


def test_what_bends_is_no_body():
    xyz, t = plate(), np.arange(F) / RATE
    xyz[5:, :, :2] += 90 * np.sin(2 * np.pi * 0.5 * t)[:, None]
    points, _ = in_pieces(xyz, length=F)
    assert all(len(body.shape) <= 5 for body in learned_bodies(points, rows_of(points)))


def fast_plate():
    """The plate; for a second it goes there and back by 60 mm a frame, more than half of its pitch."""
    xyz, f = plate(), np.arange(F)
    return xyz + np.interp(f, [120, 132, 144, 156, 168], [0, 1, 0, -1, 0])[:, None] * [720.0, 0.0, 0.0]


def pieces(tracks, xyz):
    """How many tracks lie on each marker (M, F, 3) in three frames and more, and the share of samples found."""
    cloud = tracks.cloud
    near = np.linalg.norm(xyz[:, cloud.frame] - cloud.xyz, axis=-1)
    marker = np.where(near.min(0) < 20, near.argmin(0), -1)
    count = np.zeros((len(xyz), len(tracks)), int)
    some = (marker >= 0) & (tracks.id >= 0)
    np.add.at(count, (marker[some], tracks.id[some]), 1)
    found = np.unique(np.stack([marker[some], cloud.frame[some]]), axis=1).shape[1]
    return (count >= 3).sum(1), found / (xyz.shape[0] * xyz.shape[1])


def test_a_plate_that_moves_by_its_pitch_from_frame_to_frame_keeps_its_tracks(monkeypatch):
    xyz = fast_plate()
    detections, _ = observe(ring(6), xyz, noise=0.1, seed=4, rate=RATE)
    number, found = pieces(track_detections(detections, ring(6)), xyz)

    def nothing(points, detection, *others):
        none = points.take(np.zeros(0, np.int64))
        return RigidPass(points.id, none, detection[:, :0], np.arange(points.id.max() + 1))

    monkeypatch.setattr(found_points, "rigid_pass", nothing)
    before, less = pieces(track_detections(detections, ring(6)), xyz)
    assert (number == 1).all() and found > 0.98
    assert before.sum() > 1.4 * number.sum() and less < found
