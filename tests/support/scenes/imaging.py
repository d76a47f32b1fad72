"""What the cameras see of a body: occlusion, drop-outs, noise, images that run together, false images."""

from typing import NamedTuple

import numpy as np

from kinemark.data import Detections

from .placements import seen

RADIUS = 7.0  # mm of a marker


class Optics(NamedTuple):
    """How well cameras see: noise px, stated or not; merging below px, marked or not; drop-outs and false images."""

    noise: float
    stated: bool
    merge: float
    marked: bool
    dropout: float
    false: float


def hidden(centre, body, xyz):
    """(M, F) whether a capsule lies between a camera at `centre` (3) mm and markers (M, F, 3) mm."""
    out = np.zeros(xyz.shape[:2], bool)
    ray = xyz - centre
    a = (ray * ray).sum(-1)
    for begin, end, radius in zip(body.begin, body.end, body.radius, strict=True):
        axis, to = end - begin, begin - centre
        e, b = (axis * axis).sum(-1), (ray * axis).sum(-1)
        c, f = (ray * to).sum(-1), (axis * to).sum(-1)
        s = np.clip((c * e - b * f) / np.maximum(a * e - b * b, 1e-9), 0, 1)  # on the ray, then on the axis, and again
        along = np.clip((b * s - f) / e, 0, 1)
        s = np.clip((along * b + c) / a, 0, 1)
        nearest = centre + s[..., None] * ray - (begin + along[..., None] * axis)
        out |= (np.linalg.norm(nearest, axis=-1) < radius - 1) & (s < 0.9995)
    return out


def dropped(shape, share, rng):
    """(M, F) drop-outs of some frames each, `share` of all samples."""
    begin = rng.random(shape) < share / 3
    return begin | np.roll(begin, 1, 1) | np.roll(begin, 2, 1)


def images(true, body, rate, optics, rng):
    """Detections; of each sample (C, M, F) the detection, −1 for none, and whether it is of this marker alone."""
    M, F = body.xyz.shape[:2]
    counts, rows, own = np.zeros((len(true), F), int), [], np.zeros((len(true), M, F), bool)
    image, n = np.full(own.shape, -1), 0
    for c, camera in enumerate(true):
        uv, depth = seen(camera, body.xyz)
        with np.errstate(invalid="ignore"):
            inside = ((uv > 2) & (uv < camera.size - 3)).all(-1)
        there = inside & ~hidden(camera.centre, body, body.xyz) & ~dropped((M, F), optics.dropout, rng)
        area = np.pi * (camera.K[0, 0] * RADIUS / depth) ** 2
        for f in range(F):
            m = np.flatnonzero(there[:, f])
            group = together(uv[m, f], optics.merge)
            frame = blobs(uv[m, f], area[m, f], group)
            own[c, m, f] = frame[group, 3] == 0
            frame[:, :2] += optics.noise * rng.normal(size=(len(frame), 2))
            both = np.vstack([frame, clutter(camera, optics, rng)])
            both = rng.permutation(np.column_stack([both, np.arange(len(both))]))
            image[c, m, f] = n + np.argsort(both[:, 4])[group]
            counts[c, f] = len(both)
            n += len(both)
            rows.append(both)
    return as_detections(true.names, rate, counts, np.vstack(rows), optics), image, own


def clutter(camera, optics, rng):
    """(n, 4) false images of a frame, as `blobs`."""
    n = rng.poisson(optics.false)
    return np.column_stack([rng.uniform(0, camera.size, (n, 2)), rng.uniform(5, 60, n), np.zeros(n)])


def together(uv, px):
    """(N) the group of each image, those nearer than `px` to each other being one."""
    group = np.arange(len(uv))
    if px and len(uv) > 1:
        i, j = np.nonzero(np.triu(np.linalg.norm(uv[:, None] - uv, axis=-1) < px, 1))
        for a, b in zip(i, j, strict=True):
            group[group == group[b]] = group[a]
    return np.unique(group, return_inverse=True)[1]


def blobs(uv, area, group):
    """(G, 4) u, v, area and whether it is of several, of groups of images (N, 2)."""
    n = int(group.max(initial=-1)) + 1
    weight = np.bincount(group, area, n)
    u, v = (np.bincount(group, area * x, n) / weight for x in uv.T)
    return np.column_stack([u, v, weight, np.bincount(group, minlength=n) > 1])


def as_detections(names, rate, counts, rows, optics):
    """The record; without areas and marks where they are not `marked`, without covariance where it is not stated."""
    cov = np.broadcast_to(np.eye(2) * optics.noise**2, (len(rows), 2, 2)) if optics.stated else None
    shape = {"area": rows[:, 2], "merged": rows[:, 3] > 0} if optics.marked else {}
    return Detections.build(names, rate, counts, rows[:, :2], cov, **shape)
