"""The probability of tracks measured on the trial itself: its own names, shredded at random, are given back or not.

The names that are confident are taken as the truth. Their markers are joined, cut at random into pieces as long as the
tracks that are not sure, put among all other tracks of the trial, cut alike, and named again by the evidence of
the same template, outwards from the fullest frame. (A marker without a name that stays whole takes those of pieces
beside it, by its length alone.) Each of the n pieces has the logit η that `margin` (3) gives it, and
is right or not, y; so has each track without a name that now took that of a confident marker beside which it is seen,
which is wrong. What the rest of the tracks are called tells nothing, as nobody knows what they are: one in a gap of the
marker may be the marker. The trial's own shift δ of all logits is
the most probable one,

    δ = argmax  r Σ [ y log p + (1 − y) log(1 − p) ] − δ² / (2 τ²),   p = logistic(η + δ)                          (1)

where τ, by which trials differ, is the prior that shrinks δ to 0 where there are few cases or few errors, and r < 1
because pieces of one marker, seen in the same half second, are no independent cases: r is independent segments over
pieces. An exchange of whole labels is invisible to this: `margin` (4) judges it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..data import MarkerTrajectory, Trajectories
from ..data.array_types import Bools, Floats, Ints
from .evidence import PairScore
from .margin import BETA_PIECE, logistic, margins, track_logit
from .stretches import Stretches, stretches_of
from .sweeps import outwards, sweep
from .template import Template

CONFIDENT = 0.9
"""Probability from which on a name is taken as the truth; chosen, nine in ten at least."""
BETWEEN = 1.0
"""τ of (1), in logits; chosen, no other was tried: the log score of tracks in benchmarks/labelling.py rose with it."""
SEGMENT_S = 0.5
"""Length of independent segments, s; chosen, as long as a new pose takes."""
MOST_PIECES, MOST_FRAMES = 10, 600
"""Of a marker, and of the trial; chosen, as many as are needed to see one error in a hundred."""
UNKNOWN, NOT_KNOWN = "?", -2
"""What the truth calls a track whose name is not sure, and its number; by definition."""
SWEEPS = 2
"""After the first naming; chosen, most trials need no more."""


class Pieces(NamedTuple):
    """Tracks (T) that markers were cut into, and the marker of each (T): None for none, `UNKNOWN` where not known."""

    tracks: Trajectories
    truth: Sequence[str | None]


class Cases(NamedTuple):
    """Pieces of the trial that were named again: logit by `margin` (3), whether right, share that is independent."""

    logit: Floats
    right: Bools
    independent: float


def calibrated_shift(
    trajectories: Trajectories,
    template: Template,
    pairs: PairScore,
    label: Ints,
    probability: Floats,
    *,
    sure: float,
    least_fit: float,
    nameless: float = 0.0,
    piece: Sequence[float] = BETA_PIECE,
) -> float:
    """δ of a labelled trial; 0 where all its names are sure, or too few are confident to tell.

    Args:
        trajectories: T tracks that were labelled. template, pairs: by which. label: (T) −1 for none.
        probability: (T) before. sure: from which on a name is sure. least_fit: of a track, below which it has
            no name.
        nameless: N of `margin` (3), of the trial. piece: its β of pieces.
    """
    unsure = (label >= 0) & (probability < sure)
    confident = np.flatnonzero(probability >= CONFIDENT)
    if not unsure.any() or len(np.unique(label[confident])) < 4:
        return 0.0
    seen = np.isfinite(trajectories.xyz[..., 0])
    first, stop = _window(seen, unsure)
    trial = _joined(trajectories, label, confident, template, first, stop)
    n = stop - first
    pieces = int(np.clip(round(n / np.median(seen[unsure].sum(1))), 1, min(MOST_PIECES, n)))
    rest = np.setdiff1d(np.flatnonzero(seen[:, first:stop].any(1)), confident)
    others = {f"+{t}": None if label[t] < 0 else UNKNOWN for t in rest.tolist()}
    paths = (MarkerTrajectory.measured(f"+{t}", trajectories.paths[t].xyz[first:stop]) for t in rest.tolist())
    parts = _cut(replace(trial, paths=(*trial.paths, *paths)), pieces)
    truth = [others.get(str(name), name) for name in parts.truth]
    return shift_of(cases_of(parts._replace(truth=truth), template, pairs, least_fit, nameless, piece))


def _cut(trial: Trajectories, n: int) -> Pieces:
    """Each marker cut into n pieces at random frames, and all shuffled."""
    rng, F = np.random.default_rng(0), trial.n_frames
    parts = []
    for path in trial:
        at = np.sort(rng.choice(np.arange(1, F), n - 1, replace=False)) if n > 1 else ()
        part = np.searchsorted(at, np.arange(F), side="right")
        seen = np.unique(part[np.isfinite(path.xyz[:, 0])]).tolist()
        parts += [(path.name, np.where((part == k)[:, None], path.xyz, np.nan)) for k in seen]
    parts = [parts[i] for i in rng.permutation(len(parts))]
    paths = tuple(MarkerTrajectory.measured(f"*{k}", xyz) for k, (_, xyz) in enumerate(parts, 1))
    return Pieces(Trajectories(paths, trial.rate), [name for name, _ in parts])


def _window(seen: Bools, unsure: Bools) -> tuple[int, int]:
    """At most so many frames, about the middle of the samples that are not sure."""
    F = seen.shape[1]
    middle = int(np.median(np.nonzero(seen[unsure])[1])) if seen[unsure].any() else F // 2
    first = int(np.clip(middle - MOST_FRAMES // 2, 0, max(F - MOST_FRAMES, 0)))
    return first, min(F, first + MOST_FRAMES)


def _joined(
    trajectories: Trajectories, label: Ints, confident: Ints, template: Template, first: int, stop: int
) -> Trajectories:
    """The markers of confident tracks, in these frames."""
    xyz = {int(a): np.full((stop - first, 3), np.nan) for a in np.unique(label[confident])}
    for t in confident:
        part = trajectories.paths[t].xyz[first:stop]
        rows = np.isfinite(part[:, 0])
        xyz[int(label[t])][rows] = part[rows]
    paths = (MarkerTrajectory.measured(template.names[a], part) for a, part in xyz.items() if np.isfinite(part).any())
    return Trajectories(tuple(paths), trajectories.rate)


def cases_of(
    parts: Pieces,
    template: Template,
    pairs: PairScore,
    least_fit: float,
    nameless: float = 0.0,
    piece: Sequence[float] = BETA_PIECE,
) -> Cases:
    """The pieces named again from the fullest frame, without key frames; beside as many nameless as in the trial."""
    number = {name: a for a, name in enumerate(template.names)} | {None: -1, UNKNOWN: NOT_KNOWN}
    truth = np.array([number[name] for name in parts.truth], np.int64)
    stretches = stretches_of(parts.tracks, template.size)
    label = _again(stretches, truth, pairs, least_fit)
    named = np.flatnonzero((label >= 0) & ((truth >= 0) | (truth == -1) & _beside_its_own(parts.tracks, label, truth)))
    about = margins(stretches, label, template, pairs, exchanges=False)
    about = about._replace(nameless=np.full(len(label), nameless))
    logit = track_logit(about, stretches.weight, piece)[named]
    segments = len(template) * max(1.0, parts.tracks.n_frames / parts.tracks.rate / SEGMENT_S)
    return Cases(logit, label[named] == truth[named], min(1.0, segments / max(len(named), 1)))


def _beside_its_own(tracks: Trajectories, label: Ints, truth: Ints) -> Bools:
    """(T) whether a track is seen at the same time as the marker whose name it has; in a gap it may be the marker."""
    seen = np.isfinite(np.array([path.xyz[:, 0] for path in tracks]))
    own = np.array([seen[truth == a].any(0) for a in label])
    return np.asarray((own & seen).sum(1) >= seen.sum(1) / 2)


def _again(stretches: Stretches, truth: Ints, pairs: PairScore, least_fit: float) -> Ints:
    """(T) labels, from the true ones of the frame that has most."""
    here = np.isfinite(stretches.xyz[..., 0]) & (truth >= 0)[:, None]
    key = int(here.sum(0).argmax())
    known = np.flatnonzero(here[:, key])
    label = outwards(stretches, key, known, truth[known], pairs)
    for _ in range(SWEEPS):
        label = sweep(stretches, label, pairs, least_fit, take_over=True)
    return label


def shift_of(cases: Cases) -> float:
    """δ of (1), by Newton's method; the sum is concave, so that there is one."""
    shift = 0.0
    for _ in range(50):
        p = logistic(cases.logit + shift)
        slope = cases.independent * (cases.right - p).sum() - shift / BETWEEN**2
        curve = cases.independent * (p * (1 - p)).sum() + 1 / BETWEEN**2
        step = float(np.clip(slope / curve, -1.0, 1.0))
        shift += step
        if abs(step) < 1e-6:
            break
    return shift
