"""Cameras with times of their own: other rates, delays, rolling shutters, uneven times and long exposures.

Markers move along smooth paths that are known at any time, so that each image is exact at the time of each of its rows.
"""

from dataclasses import dataclass, field

import numpy as np

from kinemark.data import Detections
from kinemark.geometry import project

SUBTIMES = 5  # of an exposure, whose mean a centroid is


@dataclass(frozen=True)
class Paths:
    """n markers on two bodies that walk about, and sway or jump, with limbs that swing; mm, s and mm/s."""

    n: int
    speed: float
    seed: int
    jump: bool = False
    own: dict[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self):
        rng, n = np.random.default_rng(self.seed), self.n
        place = np.stack([rng.permutation(n) * 90.0 - 45 * n, rng.uniform(-400, 400, n), rng.uniform(300, 1600, n)], -1)
        body = np.arange(n) % 2
        turn = rng.uniform(0.5, 1.2, 2)[body]  # Hz
        radius = self.speed * rng.uniform(0.3, 1.0, n) / (2 * np.pi * turn) / 1.5
        self.own.update(place=place, turn=turn, phase=rng.uniform(0, 2 * np.pi, 2)[body], radius=radius)

    def __call__(self, marker, t):
        """Places (N, 3) mm of markers (N) at times (N) s."""
        place, turn, phase, radius = (self.own[key][marker] for key in ("place", "turn", "phase", "radius"))
        angle = 2 * np.pi * turn * t + phase
        swing = np.stack([np.cos(angle), np.sin(angle), 0.5 * np.sin(2 * angle)], -1)
        height = 500 * np.maximum(np.sin(2 * np.pi * 0.8 * t), 0) ** 2 if self.jump else np.zeros_like(t)
        return place + radius[:, None] * swing + height[:, None] * np.array([0, 0, 1.0])


@dataclass(frozen=True)
class Times:
    """Of each camera: Hz, delay in s, read-out of all rows in s, standard deviation of each image's time in s, and
    exposure in s."""

    rate: np.ndarray
    delay: np.ndarray
    readout: np.ndarray
    uneven: np.ndarray
    exposure: float = 0.0

    @classmethod
    def of(cls, C, rate, *, delay=0.0, readout=0.0, uneven=0.0, exposure=0.0):
        """The same for all of C cameras where one number is given."""
        each = (np.broadcast_to(np.asarray(one, float), C) for one in (rate, delay, readout, uneven))
        return cls(*each, exposure)


def recorded(rig, paths, times, *, frames, rate, noise=0.1, seed=0, stated=True, miss=0.0):
    """(Detections of `frames` images of each camera at the nominal rate, the marker of each)."""
    rng, counts, uv, marker = np.random.default_rng(seed), [], [], []
    for c, camera in enumerate(rig):
        image = np.repeat(np.arange(frames), paths.n)
        who = np.tile(np.arange(paths.n), frames)
        off = times.uneven[c] * rng.standard_normal(frames)
        begun = image / times.rate[c] + times.delay[c] + off[image]
        row = np.zeros(len(image))
        for _ in range(3):  # the row that sees a marker depends on when it is read
            t = begun + times.readout[c] * row
            row = project(camera, paths(who, t))[:, 1] / (camera.size[1] - 1) - 0.5
        sub = (np.arange(SUBTIMES) - (SUBTIMES - 1) / 2) / SUBTIMES * times.exposure
        seen = np.mean([project(camera, paths(who, t + one)) for one in sub], axis=0)
        seen = seen + noise * rng.standard_normal(seen.shape)
        inside = ((seen > 0) & (seen < camera.size - 1)).all(1) & (rng.random(len(seen)) >= miss)
        counts.append(np.bincount(image[inside], minlength=frames))
        uv.append(seen[inside])
        marker.append(who[inside])
    uv = np.concatenate(uv)
    cov = np.tile(np.eye(2) * noise**2, (len(uv), 1, 1)) if stated else np.full((len(uv), 2, 2), np.nan)
    return Detections.build(rig.names, rate, np.array(counts), uv, cov), np.concatenate(marker)


def truth(paths, frames, rate):
    """(n, F, 3) mm of the markers at the times of the frames."""
    t = np.arange(frames) / rate
    each = [paths(np.full(frames, m), t) for m in range(paths.n)]
    return np.array(each)


def compared(tracks, xyz):
    """Recall within 30 mm, RMS error in mm, share within 95 % ellipsoids, tracks, and swaps against xyz (n, F, 3)."""
    cloud, ids = tracks.cloud, tracks.id
    off = cloud.xyz[:, None] - xyz[:, cloud.frame].swapaxes(0, 1)
    who = np.linalg.norm(off, axis=-1).argmin(1)
    error = off[np.arange(len(who)), who]
    near = np.linalg.norm(error, axis=1) < 30
    squared = np.einsum("pi,pi->p", error, np.linalg.solve(cloud.cov, error[..., None])[..., 0])
    order = np.lexsort([cloud.frame, ids])
    same = np.diff(ids[order]) == 0
    swaps = int((same & (np.diff(who[order]) != 0) & near[order][1:] & near[order][:-1]).sum())
    found = len(set(zip(who[near].tolist(), cloud.frame[near].tolist(), strict=True))) / xyz[..., 0].size
    rms = float(np.sqrt((error[near] ** 2).sum(1).mean()))
    return found, rms, float((squared[near] < 7.815).mean()), len(tracks), swaps
