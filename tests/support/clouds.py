"""Clouds, tracks and points made of given motions, and what comes out of them."""

import numpy as np

from kinemark.data import Cloud, Tracks
from kinemark.track.simultaneous.points.neighbouring_points import TrackPoints


def groups_of(matches, truth):
    """For every group, the set of points that its images show."""
    return [set(truth[detection[detection >= 0]]) for detection in matches.detection]


def tracks(xyz, identity, sd=1.0):
    """Tracks from points (M, F, 3), NaN where none, and their identities (M, F)."""
    frames = xyz.shape[1]
    frame, marker = np.nonzero(~np.isnan(xyz[..., 0]).T)
    points = xyz[marker, frame]
    cloud = Cloud(
        rate=100.0,
        start=np.searchsorted(frame, np.arange(frames + 1)),
        xyz=points,
        cov=np.tile(np.eye(3) * sd**2, (len(points), 1, 1)),
        residual=np.zeros(len(points)),
        detection=np.full((len(points), 2), -1),
    )
    return Tracks(cloud, np.asarray(identity)[marker, frame])


def numbered(paths):
    return np.repeat(np.arange(len(paths))[:, None], paths.shape[1], 1)


def cloud_and_markers(xyz, seen=None, *, rate=30.0, order=None, cov=1.0):
    """A cloud of markers (M, F, 3) where seen (M, F), and the marker of each point; `order` sorts a frame's markers."""
    seen = np.ones(xyz.shape[:2], bool) if seen is None else seen
    rows = [np.flatnonzero(s) for s in seen.T]
    rows = [order(f, own) for f, own in enumerate(rows)] if order else rows
    points = np.concatenate([xyz[own, f] for f, own in enumerate(rows)])
    n = len(points)
    start_of = np.concatenate([[0], np.cumsum([len(own) for own in rows])])
    detection = np.full((n, 2), -1)
    return Cloud(rate, start_of, points, np.tile(cov * np.eye(3), (n, 1, 1)), np.zeros(n), detection), np.concatenate(
        rows
    )


def cloud_of(points, rate=50.0, order=None):
    """A cloud of the points (M, F, 3), those that are NaN left out; in each frame in their order, or shuffled."""
    m, f, _ = points.shape
    frame, marker = (k.ravel() for k in np.mgrid[:f, :m])
    if order is not None:
        marker = np.concatenate([order.permutation(m) for _ in range(f)])
    seen = ~np.isnan(points[marker, frame, 0])
    frame, marker = frame[seen], marker[seen]
    n = len(frame)
    start = np.searchsorted(frame, np.arange(f + 1))
    return Cloud(
        rate, start, points[marker, frame], np.tile(np.eye(3), (n, 1, 1)), np.zeros(n), np.arange(2 * n).reshape(n, 2)
    )


def pieces(ids):
    """Lengths of the tracks of an array of identities."""
    return np.bincount(ids[ids >= 0]).tolist()


def points(paths, sd=0.3, seed=0):
    """Points of paths (N, F, 3), NaN where a path is not."""
    rng = np.random.default_rng(seed)
    id, frame = np.nonzero(np.isfinite(paths[..., 0]))
    order = np.argsort(frame, kind="stable")
    id, frame = id[order], frame[order]
    xyz = paths[id, frame] + sd * rng.normal(size=(len(id), 3))
    return TrackPoints(frame, id, xyz, np.broadcast_to(np.eye(3) * sd**2, (len(id), 3, 3)))
