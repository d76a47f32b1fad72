"""Spikes of markers are left out before anything is computed: samples that stand off their path, and off what is near.

A marker that another one stood for in an image, or that was exchanged with its neighbour, is off by centimetres for a
frame or a few. By the path before and after, and by the markers beside it that carry it as a rigid body, such samples
are told from motion, each with the probability that it is wrong (`edit.probable_errors.spikes`). Those that are
likelier wrong than right, and short, are taken away, and the path goes on between what is before and after them.
Longer ones stay, for what carries a marker may itself bend meanwhile; `marker_leaps` tells of them.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..data import MarkerTrajectory, Origin, Trial
from ..edit.probable_errors import Paths, Spike, spikes
from ..edit.probable_errors.paths import between, ends

LIKELY = 0.5
"""Probability above which a sample is left out; by definition of likelier wrong than right."""
LONGEST_S = 0.06
"""Of what is left out, s; chosen: in 20 public walks, at 100 and 50 frames a second, a path that goes on over three
frames is off by 0.2 and 0.8 mm (RMS of the worst of them), over seven at 50 by 5."""


class MarkerSpikes(NamedTuple):
    """What was left out of a trial.

    Attributes:
        markers: the farthest off first. frames: first and last of each stretch, from 0, in order of time.
        samples: of all markers. most_mm: by which one is off its path.
    """

    markers: tuple[str, ...] = ()
    frames: tuple[tuple[int, int], ...] = ()
    samples: int = 0
    most_mm: float = 0.0


def without_spikes(trial: Trial) -> tuple[Trial, MarkerSpikes]:
    """A trial without the spikes of its named markers, and what they were; the same trial where there are none."""
    paths, mended = Paths.of(trial.trajectories), list(trial.trajectories)
    longest = LONGEST_S * trial.trajectories.rate
    found = [
        one for one in spikes(paths)
        if one.wrong > LIKELY and one.last - one.first < longest and not mended[one.path].name.startswith("*")
    ]  # fmt: skip
    if not found:
        return trial, MarkerSpikes()
    found.sort(key=lambda one: -one.keep_mm)
    for one in found:
        mended[one.path] = _mended(mended[one.path], one, paths)
    told = MarkerSpikes(
        tuple(dict.fromkeys(mended[one.path].name for one in found)),
        tuple(sorted({(one.first, one.last) for one in found})),
        sum(one.last - one.first + 1 for one in found),
        found[0].keep_mm,
    )
    return replace(trial, trajectories=replace(trial.trajectories, paths=tuple(mended))), told


def _mended(path: MarkerTrajectory, spike: Spike, paths: Paths) -> MarkerTrajectory:
    """The path with the place that its other samples show, as filled, where the spike is."""
    to = np.arange(spike.first, spike.last + 1)
    who = np.full(len(to), spike.path)
    before = np.full(len(to), paths.index_before(spike.path, spike.first - 1))
    after = np.full(len(to), paths.index_before(spike.path, spike.last) + 1)
    sides = ends(paths, who, before, -1), ends(paths, who, after, 1)
    place, variance = between(*sides, to.astype(np.float64), paths.rate, paths.q)
    path = path.only(~np.isin(np.arange(len(path)), to))
    xyz, cov, origin = path.xyz.copy(), path.cov.copy(), path.origin.copy()
    xyz[to], origin[to] = place, Origin.FILLED
    if np.isfinite(path.cov).any():
        cov[to] = variance[:, None, None] * np.eye(3)
    return replace(path, xyz=xyz, cov=cov, origin=origin)
