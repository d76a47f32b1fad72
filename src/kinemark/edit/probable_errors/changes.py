"""Changes of identity: how likely it is that a path goes on as another marker at a place.

At a place of path p, with the halves p₋ and p₊ before and after and those of another path q, either each goes on as
itself, or as the other. What two halves cost that are one marker is

    c = 7/2 ln(1 + χ²/4) + 3/2 ln(2π σ²),      χ² = d²/σ²                                                    (1)

with the distance d of their continuations and its variance σ² per axis, as of Student's t with four degrees of freedom,
which knows outliers; a half that begins or ends costs END, and in files a place after a gap so long that it may be
anywhere costs no more than both: else long gaps by themselves would speak for two markers. The evidence of motion for
an exchange is

    motion = c(p₋ p₊) + c(q₋ q₊) − c(p₋ q₊) − c(q₋ p₊),                                                       (2)

that of shape the same difference of the misfits of `shape` (3). No other path, q = none, is a partner like others: the
path is then two. Of all partners the one with the most evidence is taken.

The probability of a change is a logistic function of (2), (3) and what `Evidence` lists (4); its coefficients were
fitted to seeded faults (studies/probable_errors.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints
from ...data.progress import tell
from ...numerics.finite import finite_mean
from .carried import Leaving
from .paths import SIGNIFICANT, Ends, Meeting, Paths, ends, meeting
from .places import APART_S, Partner, Place
from .probability import of_source, probability
from .shape import Distances, companions, distances, misfit, spread

END = 10.0
"""Nats that the beginning or end of a path costs; chosen: a place anywhere in a room's corner."""
MOST = 30.0
"""Nats of motion that count at most; chosen."""


class Evidence(NamedTuple):
    """What tells of a change at a place, for the partner with the most of it.

    Attributes:
        motion: (2), nats, for the exchange. shape: (3), 0 where unknown.
        own_misfit: of the path's own halves by shape; 0 where unknown. known: 1 where shape is known, else 0.
        own_chi: ln(1 + χ²/4) of its own halves by motion. own_sd: ln σ of their distance, mm. own_off: ln(1 + d / 10
            mm) of their distance where that is significant.
        surely: motion above 0, else 0.
        told: 1 where tracking was not sure of the place. images: ln of how many images the samples beside it have, the
            fewer of both; that of two where they are not known.
        other_chi: as own_chi, of the worse of both exchanged pairs of halves; 0 where there is none. alone: 1 where
            there is no partner, else 0.
        near: 1 where tracking saw another come so near that either could have had the other's images. companions: nats
            / 10 that those beside it on both sides say for one marker (`shape.companions`), 0 where unknown; both 0 in
            files.
        left: ln(1 + mm) that the path comes over the place from where its companions carry it (`carried`), 0 where
            unknown, or over more than STIFF_S: (3) is of a second, in which a stretch of some frames is not seen.
            beside: the same of what is nearest to it, the median; both 0 of tracks that have images.
    """

    motion: float
    shape: float
    own_misfit: float
    known: float
    own_chi: float
    own_sd: float
    own_off: float
    surely: float
    told: float
    images: float
    other_chi: float
    alone: float
    near: float = 0.0
    companions: float = 0.0
    left: float = 0.0
    beside: float = 0.0


class Change(NamedTuple):
    """A place of a path, and what tells that it goes on there as another marker.

    Attributes:
        place: where. partner: the path that it may be exchanged with, or none, and where that is cut.
        evidence: what tells. wrong: probability of a change. kind: of its source (`probability.of_source`).
        keep_mm, exchange_mm: how far both paths are off from where their motion leads, as they are and exchanged.
    """

    place: Place
    partner: Partner
    evidence: Evidence
    wrong: float
    keep_mm: float
    exchange_mm: float
    kind: str


def changes(paths: Paths, found: Sequence[Place]) -> list[Change]:
    """What is to be said of each place."""
    if not found:
        return []
    costs = _Costs.of(paths, found)
    window = _Windows(paths)
    at, out = 0, list[Change]()
    for place in found:
        tell(len(out), len(found))
        rows = slice(at, at + len(place.partners))
        at = rows.stop
        out.append(_change(place, costs.rows(rows), window))
    return out


class _Costs(NamedTuple):
    """Of each place and partner: what (1) says of the halves, in the order p₋p₊, q₋q₊, p₋q₊, q₋p₊ (4, N): cost; off,
    mm; χ²; and variance."""

    cost: Floats
    off: Floats
    squared: Floats
    variance: Floats

    def rows(self, some: slice) -> _Costs:
        return _Costs(*(column[:, some] for column in self))

    @classmethod
    def of(cls, paths: Paths, found: Sequence[Place]) -> _Costs:
        p, i, q, j, k = (np.array(column, np.int64) for column in zip(*_pairs(paths, found), strict=True))
        p_before, p_after = ends(paths, p, i, -1), ends(paths, p, i + 1, 1)
        q_before, q_after = ends(paths, q, j, -1), ends(paths, q, k, 1)
        halves = (p_before, p_after), (q_before, q_after), (p_before, q_after), (q_before, p_after)
        met = [_met(a, b, paths) for a, b in halves]
        return cls(*(np.array(column) for column in zip(*met, strict=True)))


def _pairs(paths: Paths, found: Sequence[Place]) -> list[tuple[int, int, int, int, int]]:
    """Path and index of each place; each partner, and the indices of its last sample before and first after, or −1."""
    rows, far = [], APART_S * paths.rate
    for place in found:
        for q, j in place.partners:
            own = paths.frames[q] if q >= 0 else np.zeros(0, np.int64)
            k = j + 1 if q >= 0 and j + 1 < len(own) and own[j + 1] - place.middle < far else -1
            rows.append((place.path, place.sample, max(q, 0), j if j >= 0 and place.middle - own[j] < far else -1, k))
    return rows


def _met(before: Ends, after: Ends, paths: Paths) -> tuple[Floats, Floats, Floats, Floats]:
    """(1) of N pairs of halves, with what an end costs where one half is not."""
    met: Meeting = meeting(before, after, paths.rate, paths.q)
    none_before, none_after = np.isinf(before.variance[:, 0]), np.isinf(after.variance[:, 0])
    with np.errstate(invalid="ignore"):
        squared = met.squared
        most = np.inf if paths.images.any() else 2 * END
        cost = 3.5 * np.log1p(squared / 4) + np.minimum(1.5 * np.log(2 * np.pi * met.variance), most)
    cost = np.where(none_before & none_after, 0.0, np.where(none_before | none_after, END, cost))
    return cost, met.off, squared, met.variance


class _Windows:
    """Distances of halves, each worked out once."""

    def __init__(self, paths: Paths) -> None:
        self.paths = paths
        self.spread = spread(paths)
        self.leaving = Leaving(paths)
        self.known: dict[tuple[int, float, int], Distances] = {}

    def of(self, p: int, middle: float, side: int) -> Distances:
        key = p, middle, side
        if key not in self.known:
            self.known[key] = distances(self.paths, p, middle, side)
        return self.known[key]

    def images(self, place: Place) -> Ints:
        """Of the samples before and after."""
        paths, own = self.paths, self.paths.frames[place.path]
        return paths.images[place.path, own[place.sample : place.sample + 2]]

    def companions(self, place: Place) -> float:
        """What those beside it say for one marker."""
        return companions(self.paths, place.path, place.sample, self.spread) / 10

    def left(self, place: Place) -> tuple[float, float] | None:
        """`Evidence.left` and `beside`; None where they are not known, or over a gap in which a body bends."""
        p, (f, g) = place.path, self.paths.frames[place.path][place.sample :][:2].tolist()
        if g - f > max(1, STIFF_S * self.paths.rate):
            return None
        beside, mm = self.leaving.beside(p, f, g), self.leaving.mm(p, f, g)  # both are worked out at once
        return None if np.isnan(mm) else (float(np.log1p(mm)), float(np.log1p(beside)))

    def misfits(self, place: Place, partner: Partner) -> tuple[float, float, float]:
        """Of p's own halves; of both paths as they are; and exchanged. NaN where unknown."""
        p, t, q = place.path, place.middle, partner.path
        p_before, p_after = self.of(p, t, -1), self.of(p, t, 1)
        if q < 0:
            own = misfit(p_before, p_after)
            return own, own, np.nan
        own_q = self.paths.frames[q]
        at = own_q[partner.sample] + 0.5 if 0 <= partner.sample < len(own_q) - 1 else t
        q_before, q_after = self.of(q, at, -1), self.of(q, at, 1)
        own = misfit(p_before, p_after, (q,))
        others = misfit(q_before, q_after, (p,))
        across = misfit(p_before, q_after, (p, q)), misfit(q_before, p_after, (p, q))
        keep = np.array([own, others])
        return own, finite_mean(keep), finite_mean(np.array(across))


def _change(place: Place, costs: _Costs, windows: _Windows) -> Change:
    """The partner with the most evidence."""
    best: Change | None = None
    images = windows.images(place)
    tracked = bool(images.any())
    kept = windows.companions(place) if tracked else 0.0
    left = None if tracked else windows.left(place)
    for n, partner in enumerate(place.partners):
        own, keep, other = windows.misfits(place, partner)
        shape = keep - (other if np.isfinite(other) else USUAL_MISFIT)
        motion = float(np.clip(costs.cost[0, n] + costs.cost[1, n] - costs.cost[2, n] - costs.cost[3, n], -MOST, MOST))
        known = np.isfinite(shape)
        evidence = Evidence(
            motion, float(shape) if known else 0.0, float(own) if np.isfinite(own) else 0.0, float(known),
            float(np.log1p(costs.squared[0, n] / 4)), float(np.log(costs.variance[0, n]) / 2),
            float(np.log1p(costs.off[0, n] / USUAL_MM) * (costs.squared[0, n] > SIGNIFICANT)), max(motion, 0.0),
            float(place.told), float(np.log(max(int(images.min()), 2))),
            float(np.log1p(_most(costs.squared[2:, n], 0.0) / 4)), float(partner.path < 0),
            float(place.near and tracked), kept, *(left or (0.0, 0.0)),
        )  # fmt: skip
        off = costs.off[:, n]
        kind = of_source("cut" if tracked and partner.path < 0 else "change", tracked)
        wrong = probability(kind if tracked or left else f"{kind}_alone", evidence)
        one = Change(place, partner, evidence, wrong, _most(off[:2]), _most(off[2:]), kind)
        if best is None or _strength(one.evidence) > _strength(best.evidence):
            best = one
    assert best is not None
    return best


STIFF_S = 0.15
"""s over which companions carry a path, at most; chosen, as a leap may be smeared: in longer gaps bodies bend, and a
recording with 224 gaps had eight problems for none."""
USUAL_MM = 10.0
"""mm beside which distances are told apart; chosen."""
USUAL_MISFIT = 1.0
"""Misfit by shape of halves that are one marker, in the mean; measured by studies/probable_errors.py."""
SHAPE_NATS = 4.0
"""Nats of motion that 1 of misfit is worth when a partner is chosen; chosen."""


def _strength(evidence: Evidence) -> float:
    return evidence.motion + SHAPE_NATS * evidence.shape


def _most(off: Floats, none: float = float("nan")) -> float:
    """The largest that is known."""
    return max((mm for mm in off.tolist() if math.isfinite(mm)), default=none)
