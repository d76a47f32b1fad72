"""A marker from the pose of the body part around it and from its own past and future: kriging in local frames.

Three reference markers carry a local frame (R, c) (`triad`). In it the marker is a function of the pose φ, the
reference markers' local coordinates, and a remainder that drifts in time (soft tissue, what the reference markers do
not tell):

    Rᵀ(y − c)(t) = a + f(φ(t)) + r(t) + noise                                                             (1)

All three are Gaussian processes, so that the marker in a gap given all that is seen is a matter of linear algebra
(`kriging`; regression kriging: Hengl et al. 2007). Which frames are learnt from, and what φ is: `training_frames`.

Left and right are alike. The mirrored trial (`mirror`) is a second source of the same function, but not the same one,
as markers are never put on quite alike: ρ says how alike. In the mirrored trial a reference marker's part is played by
its partner: one whose partner is missing in the gap would leave the other side out there, and unless it is of the first
`FIRSTS` it is not used (2).

Two measures say how good a model is for a gap. The likelihood p of the n frames learnt from is that of small
steps, which are most of what is seen; but a model is never quite true, and a long gap asks for long steps. So with e
the mean error with which blocks of the gap's length are predicted when they are left out, a model is the worse the
greater

    J = ln e − ln p / 3n                                                                                  (3)

is. λ, ℓ, ν, ρ, θ and the order of r's covariance are those of a small grid with the least J, found one after the
other: each value in turn takes the place of the best so far if J is less by `MARGIN`. ρ = 0 sets the mirror aside.
Which three reference markers carry the frame matters too, and how f may bend. Every base is tried with each of BENDS,
and the `kept` best are averaged with weights w ∝ exp(−SHARPNESS J) (what is best in the blocks is best in the gap only
by so much). With y_k and V_k what each predicts, the fill has (law of total covariance)

    ȳ = Σ w y_k,     V = Σ w (V_k + (y_k − ȳ)(y_k − ȳ)ᵀ),     Σ w = 1                                        (4)

A reference marker that is not seen throughout the gap is not used, nor one that jumps in it (`jumping_markers`). Where
one is missing beside the gap, the fill is tied to the marker's sample there (`edge_tie`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...data.method import parameter
from ...numerics.evenly import evenly
from ..jumping_markers import JumpingMarkers
from ..marker_array import Gap, MarkerArray, Prediction
from ..mirrored_markers import partners
from ..reference_ranking import Ranks
from .edge_tie import edge_offsets, tied
from .kriging import ORDERS, FramePairs, Hyper, fit, left_out, predict
from .stage import FILL, FillMethod
from .training_frames import FEWEST, LocalView, TrainingFrames, local_view, pairs_of, training_frames_of

FIRSTS = 4
"""Reference markers that are used even where their partner is missing in the gap; chosen (see benchmarks/gaps.py)."""
FEW = 4
"""Gaps that λ, ℓ, ν … of a trial are found from; chosen (see benchmarks/gaps.py)."""
SHARPNESS = 5.0  # of the weight exp(−SHARPNESS J), without unit; chosen; docs/theory/fill.md has what comes of it
MARGIN = 0.005  # of J, by which a value must be better; chosen, lest noise decide (see benchmarks/gaps.py)
GRID = {
    "theta": (0.03, 0.1, 0.6),
    "rho": (0.0, 0.5, 0.98),
    "ell": (0.02, 0.05, 0.12),
    "lam": (3.0,),
    "nu": (1e-5, 1e-3, 0.1),
    "order": (3.5,),
}
"""What is tried for θ, ρ, ℓ (s), λ, ν and the order beside their usual values (`Hyper`)."""
BENDS = ((1.0, 3.0), (2.0, 0.5), (8.0, 3.0))
"""κ and η of `kriging` that are tried; chosen (see benchmarks/gaps.py)."""


@dataclass(frozen=True, slots=True)
class Body(FillMethod):
    """Kriging on the pose of reference markers, in local frames, with the mirrored side as a second source."""

    most_markers: int = parameter(16, unit="markers", low=3, meaning="at most so many reference markers")
    local_frames: int = parameter(
        5, unit="frames", low=1, meaning="local frames that are tried, each of three of the first reference markers"
    )
    averaged: int = parameter(5, unit="predictions", low=1, meaning="how many of the best predictions are averaged")
    training_frames: int = parameter(
        150, unit="frames", low=FEWEST,
        meaning="training frames at most; half of them beside the gap, half all over the trial",
    )  # fmt: skip
    training_rate_hz: float = parameter(
        30.0, unit="Hz", above=0, high=math.inf, meaning="rate at which training frames are taken"
    )
    mirror: bool = parameter(True, meaning="learn from the other side of the body too")
    hyper: Hyper | None = parameter(
        None,
        meaning="λ, ℓ, ν … of the trial (`common_hyper`), with which there is one prediction, in one local frame; "
        "None: each marker's own are found",
    )

    def check_together(self) -> None:
        """Refuse an order of the drift that there is not."""
        if self.hyper and self.hyper.order not in ORDERS:
            raise ValueError(f"the order of the drift is {self.hyper.order}, wanted one of {ORDERS}")

    def for_many_gaps(self, gaps: Sequence[Gap], source: MarkerArray | None) -> Body:
        """Fewer reference markers and frames, one local frame, one set of λ, ℓ, ν … learned from the source."""
        quick = replace(
            self, most_markers=min(self.most_markers, 12), local_frames=1, training_frames=min(self.training_frames, 75)
        )
        if self.hyper or source is None:
            return quick
        return replace(quick, hyper=common_hyper(source, list(gaps), method=quick))


class _Trial(NamedTuple):
    motion: MarkerArray
    seen: Bools
    partner: Ints
    ranks: Ranks
    trust: JumpingMarkers
    hypers: dict[tuple[int, bytes], Hyper]


class _GapTraining(NamedTuple):
    references: Ints
    training: TrainingFrames
    views: list[LocalView]


@FILL.method("body", Body, rank=14, source="Hengl et al. 2007")
def fill_body(motion: MarkerArray, gaps: list[Gap], *, method: Body) -> list[Prediction]:
    """Each gap by (4); gaps of one marker with the same reference markers share λ, ℓ, ν …"""
    trial = _trial(motion, method)
    return [_fill(trial, gap, method) for gap in gaps]


def common_hyper(motion: MarkerArray, gaps: list[Gap], *, method: Body) -> Hyper:
    """λ, ℓ, ν … that are best for `FEW` of the gaps together."""
    trial = _trial(motion, method)
    some = [gaps[k] for k in evenly(len(gaps), FEW)]
    each = [found for gap in some if not isinstance(found := _gap_training(trial, gap, method), str)]
    return _best(each)


def _trial(motion: MarkerArray, method: Body) -> _Trial:
    partner = partners(motion.names) if method.mirror else np.arange(len(motion.names))
    ranks = Ranks(motion)
    return _Trial(motion, motion.seen, partner, ranks, JumpingMarkers(motion, ranks), {})


def _fill(trial: _Trial, gap: Gap, method: Body) -> Prediction:
    found = _gap_training(trial, gap, method)
    if isinstance(found, str):
        return Prediction.none(gap.length, found)
    references, training, views = found
    if method.hyper:
        kept = [(1.0, views[0], method.hyper)]
    else:
        key = gap.marker, references.tobytes()
        if key not in trial.hypers:
            trial.hypers[key] = _best([found])
        kept = _weighted(training, views, trial.hypers[key])[: method.averaged]
    xyz, cov = _mean(training, kept)
    learnt = {frame: bool(trial.seen[references, frame].all()) for frame in _beside(trial, gap)}
    offsets = edge_offsets(trial.motion.xyz[gap.marker], gap, xyz, learnt)
    xyz = tied(xyz, gap, offsets, rate=trial.motion.rate, hyper=kept[0][2])
    return Prediction(xyz, cov, references=tuple(int(d) for d in references))


def _beside(trial: _Trial, gap: Gap) -> list[int]:
    """The frame before a gap and that after it, where the trial has them."""
    return [frame for frame in (gap.start - 1, gap.stop) if 0 <= frame < trial.seen.shape[1]]


def _gap_training(trial: _Trial, gap: Gap, method: Body) -> _GapTraining | str:
    """Reference markers, training frames and local views of a gap, or why there is too little."""
    references = _references(trial, gap, method.most_markers)
    if len(references) < 3:
        return f"only {len(references)} other markers are seen throughout the gap; wanted 3"
    most, rate_hz = method.training_frames, method.training_rate_hz
    training = training_frames_of(
        trial.motion, trial.seen, gap, references, partner=trial.partner, most=most, rate_hz=rate_hz
    )
    if training is None:
        return f"fewer than {FEWEST} frames show the marker together with its reference markers"
    views = [view for base in _bases(len(references), method.local_frames) if (view := local_view(training, base))]
    if not views:
        return "the reference markers stand on one line or in one point: they carry no local frame"
    return _GapTraining(references, training, views)


def _weighted(training: TrainingFrames, views: list[LocalView], hyper: Hyper) -> list[tuple[float, LocalView, Hyper]]:
    """Every view with every bend, the least J (3) first, with weights that are not normalised yet."""
    out = []
    for view in views:
        pairs, y = pairs_of(training, view, training.judged, training.judged), view.y[training.judged]
        for kappa, eta in BENDS:
            bent = hyper._replace(kappa=kappa, eta=eta)
            out.append((_loss(pairs, y, bent, training.blocks), view, bent))
    out.sort(key=lambda each: each[0])
    return [(float(np.exp(-SHARPNESS * (J - out[0][0]))), view, bent) for J, view, bent in out]


def _loss(pairs: FramePairs, y: Floats, h: Hyper, blocks: list[Ints]) -> float:
    """J of (3)."""
    found = fit(pairs, y, h)
    missed = np.log(max(left_out(found, blocks), 1e-6)) if blocks else 0.0
    return float(missed - found.likely / (3 * len(y)))


def _mean(training: TrainingFrames, kept: list[tuple[float, LocalView, Hyper]]) -> tuple[Floats, Floats]:
    """(4)."""
    w = np.array([weight for weight, _, _ in kept])
    w /= w.sum()
    predictions = [_laboratory(training, view, h) for _, view, h in kept]
    each = np.array([xyz for xyz, _ in predictions])
    mean = np.tensordot(w, each, 1)
    cov = np.tensordot(w, np.array([V for _, V in predictions]), 1)
    return mean, cov + np.einsum("k,kfi,kfj->fij", w, each - mean, each - mean)


def _laboratory(training: TrainingFrames, view: LocalView, h: Hyper) -> tuple[Floats, Floats]:
    """What one model predicts for the gap, rotated back into the laboratory."""
    seen, wanted = slice(training.n), slice(training.n, None)
    found = fit(pairs_of(training, view, seen, seen), view.y, h)
    inside, var = predict(pairs_of(training, view, wanted, seen), found)
    R = view.R[wanted]
    xyz = view.c[wanted] + np.einsum("fij,fj->fi", R, view.mean + inside)
    return xyz, np.einsum("fij,fj,fkj->fik", R, var, R)


def _references(trial: _Trial, gap: Gap, most: int) -> Ints:
    """The first of the ranked markers that are seen throughout the gap, and leave most frames to learn from."""
    marker = gap.marker
    thin = trial.seen[:, :: max(1, trial.seen.shape[1] // 400)]
    chosen: list[int] = []
    together = thin[marker]
    ready: Bools = np.logical_and.reduce(trial.seen[:, gap.start : gap.stop], axis=1)
    ready &= trial.trust.of(gap)
    n = np.count_nonzero(together)
    missing = ~ready
    missing[marker] = True
    order = trial.ranks.of(marker)[ready[trial.ranks.of(marker)]]
    order = order[(np.arange(len(order)) < FIRSTS) | ~missing[trial.partner[order]]]  # (2)
    for reference in order:
        if len(chosen) == most:
            break
        both = together & thin[reference]
        if (left := np.count_nonzero(both)) >= 0.8 * n:
            together, n = both, left
            chosen.append(int(reference))
    return np.array(chosen, np.int64)


@cache
def _bases(references: int, n: int) -> list[tuple[int, int, int]]:
    """n triples of reference markers, of the lowest ranks first; the marker itself is row 0."""
    triples = combinations(range(1, references + 1), 3)
    return sorted(triples, key=lambda t: (max(t), sum(t)))[:n]


def _best(each: list[_GapTraining]) -> Hyper:
    """The best of the grid for the first views of all gaps together, one parameter after the other."""
    first = [(training, views[0], training.judged) for _, training, views in each]
    seen = [(pairs_of(s, view, judged, judged), view.y[judged], s.blocks) for s, view, judged in first]

    def loss(h: Hyper) -> float:
        return sum(_loss(pairs, y, h, blocks) for pairs, y, blocks in seen)

    best, at = Hyper(), loss(Hyper())
    for name, values in GRID.items():
        for value in values:
            new = best._replace(**{name: value})
            if (found := loss(new)) < at - MARGIN * len(each):
                best, at = new, found
    return best
