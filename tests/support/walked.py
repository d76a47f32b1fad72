"""A walk of labelled markers, and what may go wrong with its paths."""

from dataclasses import replace
from functools import cache

import numpy as np

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.synth import walking, with_markers

RATE = 100.0


@cache
def walk(seed=3, duration_s=4.0, markers=24):
    """Names and places (M, F, 3) mm, with noise."""
    subject = walking(duration_s=duration_s, rate=RATE, wobble_mm=1.0, seed=seed)
    subject = with_markers(subject, markers, apart_mm=40.0, seed=seed)
    return subject.names, subject.xyz + np.random.default_rng(seed).normal(0, 0.2, subject.xyz.shape)


def trajectories(xyz, names, first_frame=1):
    """Markers of these places."""
    paths = tuple(MarkerTrajectory.measured(name, path) for name, path in zip(names, xyz, strict=True))
    return Trajectories(paths, RATE, first_frame)


def clean(**kinds):
    """The walk as it is."""
    names, xyz = walk(**kinds)
    return trajectories(xyz, names)


def nearest(xyz, p, f):
    """The marker next to p in frame f."""
    apart = np.linalg.norm(xyz[:, f] - xyz[p, f], axis=1)
    apart[p] = np.inf
    return int(apart.argmin())


def exchanged(trial, p, q, first, stop=None):
    """Two markers have each other's samples in frames first … stop − 1, from 0."""
    a, b = (trial.paths[k].xyz.copy() for k in (p, q))
    a[first:stop], b[first:stop] = b[first:stop].copy(), a[first:stop].copy()
    return with_xyz(trial, {p: a, q: b})


def with_xyz(trial, xyz):
    """Markers with other places, by index."""
    new = [MarkerTrajectory.measured(path.name, xyz[k]) if k in xyz else path for k, path in enumerate(trial)]
    return replace(trial, paths=tuple(new))


def every(trial, k):
    """One frame of so many."""
    paths = tuple(MarkerTrajectory.measured(path.name, path.xyz[::k]) for path in trial)
    return Trajectories(paths, trial.rate / k)


def spiked(trial, p, first, stop, mm=40.0):
    """Samples stand off."""
    xyz = trial.paths[p].xyz.copy()
    xyz[first:stop] += [mm, 0.0, 0.0]
    return with_xyz(trial, {p: xyz})


def without(trial, p, first, stop):
    """A gap."""
    xyz = trial.paths[p].xyz.copy()
    xyz[first:stop] = np.nan
    return with_xyz(trial, {p: xyz})
