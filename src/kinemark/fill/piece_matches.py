"""Which marker a piece of track is, by where filling puts the markers that are missing then (Swamidas 1997, 2.5 (12)).

"If you can reconstruct the marker position … find where a marker should be. If you have a data segment that is similar
to the reconstruction, it may be a match" (Olree, in the appendix). Every marker that is seen in no frame of the piece
is filled there, the piece left out, and compared with its first samples x(t). With the fill x̂ and its covariance P,
and C of the samples,

    off = median |x − x̂|,     deviations = median √((x − x̂)ᵀ (P + C)⁻¹ (x − x̂))                          (1)

A piece within `SURE` of one marker, and of no other within `APART` times as many millimetres, is likely that one.
Nothing is joined: a claim does that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import MarkerTrajectory, Origin, Trajectories
from ..data.array_types import Floats, Ints
from .marker_array import Gap, MarkerArray, Prediction
from .methods.relational import Relational
from .methods.rigid_body import RigidBody
from .methods.stage import FillMethod, filler_of

LOOK_S = 0.3
"""s of the piece that are compared; chosen: more costs time, and tells little more."""
SURE = 3.5
"""Deviations at most; chosen: of three axes 1 in 100 is farther by chance. With `APART`, of four neighbours hidden at
once for 0.3 to 1.5 s in two walks and acrobatics, 144 pieces, the nearest marker was the right one for 129; 62 were
called likely, none wrongly (chosen on 72 others)."""
APART = 3.0
"""Times as far off as the best that the next one must be; chosen."""
USUAL_MM = 1.0
"""mm, standard deviation of a sample that states none, per axis; chosen, as in joining."""
METHODS: tuple[FillMethod, ...] = (RigidBody(), Relational())
"""That are asked in turn, until one has an answer; chosen: exact on a segment, fast, and asking no samples near."""


class PieceMatch(NamedTuple):
    """A marker that a piece may be.

    Attributes:
        name: of the marker. gap: frames between its nearest sample and the piece.
        off_mm, deviations: (1). likely: whether the piece is likely this marker.
    """

    name: str
    gap: int
    off_mm: float
    deviations: float
    likely: bool = False


def piece_matches(trajectories: Trajectories, track: str) -> tuple[PieceMatch, ...]:
    """The markers that a piece may be, the nearest first; those that nothing can fill there are left out.

    Args:
        trajectories: of a trial, the piece among them.
        track: the name of the piece.

    Raises:
        KeyError: there is no such track.
        ValueError: it has no sample.
    """
    piece = trajectories[track]
    own = np.flatnonzero(piece.origin != Origin.MISSING)
    if not len(own):
        raise ValueError(f"{track} has no sample")
    frames = own[own < own[0] + max(round(LOOK_S * trajectories.rate), 1)]
    motion = MarkerArray.of(trajectories.select([name for name in trajectories.names if name != track]))
    missing = [k for k in range(len(motion.names)) if not motion.seen[k, own].any() and motion.seen[k].any()]
    gaps = [Gap(k, int(frames[0]), int(frames[-1]) + 1) for k in missing]
    found = [
        _match(motion, gap, said, piece, frames)
        for gap, said in zip(gaps, _filled(motion, gaps), strict=True)
        if np.isfinite(said.xyz[frames - frames[0]]).all()
    ]
    return _judged(sorted(found, key=lambda match: match.off_mm))


def _filled(motion: MarkerArray, gaps: list[Gap]) -> list[Prediction]:
    """Of each gap the first answer."""
    said = [Prediction.none(gap.length, "") for gap in gaps]
    for method in METHODS:
        left = [k for k, one in enumerate(said) if not np.isfinite(one.xyz).all()]
        answers = filler_of(method)(motion, [gaps[k] for k in left], method=method) if left else []
        for k, answer in zip(left, answers, strict=True):
            said[k] = answer
    return said


def _match(motion: MarkerArray, gap: Gap, said: Prediction, piece: MarkerTrajectory, frames: Ints) -> PieceMatch:
    """(1) of one marker."""
    difference = piece.xyz[frames] - said.xyz[frames - gap.start]
    cov = np.nan_to_num(said.cov[frames - gap.start]) + _covariance(piece, frames)
    deviations = np.sqrt((difference * np.linalg.solve(cov, difference[..., None])[..., 0]).sum(1))
    apart = np.abs(np.flatnonzero(motion.seen[gap.marker])[:, None] - frames[[0, -1]]).min()
    distance = float(np.median(np.linalg.norm(difference, axis=1)))
    return PieceMatch(motion.names[gap.marker], int(apart) - 1, distance, float(np.median(deviations)))


def _covariance(piece: MarkerTrajectory, frames: Ints) -> Floats:
    """(n, 3, 3) mm² of samples; a usual one of those that state none."""
    cov = piece.cov[frames]
    return np.where(np.isfinite(cov).all(axis=(1, 2), keepdims=True), cov, USUAL_MM**2 * np.eye(3))


def _judged(found: list[PieceMatch]) -> tuple[PieceMatch, ...]:
    """With the first one likely, where it is."""
    if not found or found[0].deviations > SURE:
        return tuple(found)
    if len(found) > 1 and found[1].off_mm < APART * found[0].off_mm:
        return tuple(found)
    return (found[0]._replace(likely=True), *found[1:])
