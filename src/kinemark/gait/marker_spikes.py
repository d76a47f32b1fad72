"""Spikes of markers are left out before anything is computed: samples that stand off their path, and off what is near.

A marker that another one stood for in an image, or that was exchanged with its neighbour, is off by centimetres for a
frame or a few. By the path before and after, and by the markers beside it that carry it as a rigid body, such samples
are told from motion, each with the probability that it is wrong (`edit.probable_errors.spikes`). Those that are
likelier wrong than right, and short, are taken away, and the path goes on between what is before and after them.
Longer ones stay, for what carries a marker may itself bend meanwhile; `marker_leaps` tells of them.

Beside a gap and at the ends of a trial there is no path before or after. There samples from which a marker leaps
(`marker_leaps`) to where it stays are left out, and nothing stands for them.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..data import MarkerTrajectory, Origin, Trial
from ..data.array_types import Floats
from ..edit.probable_errors import Paths, Spike, spikes
from ..edit.probable_errors.paths import between
from ..edit.probable_errors.paths import ends as ends_of
from ..numerics.runs import true_runs
from .marker_leaps import leap_mm

LIKELY = 0.5
"""Probability above which a sample is left out; by definition of likelier wrong than right."""
LONGEST_S = 0.06
"""Of what is left out, s; chosen: in 20 public walks, at 100 and 50 frames a second, a path that goes on over three
frames is off by 0.2 and 0.8 mm (RMS of the worst of them), over seven at 50 by 5."""


class MarkerSpikes(NamedTuple):
    """What was left out of a trial.

    Attributes:
        markers: the farthest off first, then those at ends. frames: first and last of each stretch, from 0, in order of
            time.
        samples: of all markers. most_mm: by which one is off its path.
    """

    markers: tuple[str, ...] = ()
    frames: tuple[tuple[int, int], ...] = ()
    samples: int = 0
    most_mm: float = 0.0


def without_spikes(trial: Trial) -> tuple[Trial, MarkerSpikes]:
    """A trial without the spikes of its named markers, and what they were; the same trial where there are none."""
    trial, inside = _without_inner_spikes(trial)
    rate, paths, ends = trial.trajectories.rate, [], []
    for path in trial.trajectories:
        loose = [] if path.name.startswith("*") else _loose_ends(path.xyz, rate)
        ends += [(path.name, first, stop, mm) for first, stop, mm in loose]
        out = np.zeros(len(path), np.bool_)
        for first, stop, _ in loose:
            out[first:stop] = True
        paths.append(path.only(~out) if loose else path)
    if not ends:
        return trial, inside
    told = MarkerSpikes(
        tuple(dict.fromkeys([*inside.markers, *(name for name, *_ in ends)])),
        tuple(sorted({*inside.frames, *((first, stop - 1) for _, first, stop, _ in ends)})),
        inside.samples + sum(stop - first for _, first, stop, _ in ends),
        max(inside.most_mm, *(mm for *_, mm in ends)),
    )
    return replace(trial, trajectories=replace(trial.trajectories, paths=tuple(paths))), told


def _loose_ends(xyz: Floats, rate: float) -> list[tuple[int, int, float]]:
    """First and last-plus-one frame of samples of a path (F, 3) mm, beside a gap or an end, from which it leaps to
    where it stays, and by how many mm."""
    most, found = int(LONGEST_S * rate), []
    for first, stop in true_runs(np.asarray(np.isfinite(xyz).all(1), np.bool_)).tolist():
        if most < 1 or stop - first < 4 * most + 4:
            continue
        for begins in (True, False):
            own = xyz[first:stop] if begins else xyz[first:stop][::-1]
            mm = np.linalg.norm(np.diff(own[: 2 * most + 2], 2, axis=0), axis=1)  # about the samples 1, 2, …
            at = np.flatnonzero(mm > leap_mm(rate)) + 1
            if len(at) and at[-1] <= most:
                n = int(at[-1])
                found.append((first, first + n, float(mm.max())) if begins else (stop - n, stop, float(mm.max())))
    return found


def _without_inner_spikes(trial: Trial) -> tuple[Trial, MarkerSpikes]:
    """Without those that have a path before and after them."""
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
    sides = ends_of(paths, who, before, -1), ends_of(paths, who, after, 1)
    place, variance = between(*sides, to.astype(np.float64), paths.rate, paths.q)
    path = path.only(~np.isin(np.arange(len(path)), to))
    xyz, cov, origin = path.xyz.copy(), path.cov.copy(), path.origin.copy()
    xyz[to], origin[to] = place, Origin.FILLED
    if np.isfinite(path.cov).any():
        cov[to] = variance[:, None, None] * np.eye(3)
    return replace(path, xyz=xyz, cov=cov, origin=origin)
