"""New tracks, from images that no track has.

Points (`candidate_points`) of three successive frames make a track where they fit a motion whose velocity and
acceleration have the standard deviations v and a,

    c² = (x₁ − 2 x₂ + x₃)ᵀ (V₁ + 4 V₂ + V₃ + (a T²)² I)⁻¹ (x₁ − 2 x₂ + x₃) + p(|x₃ − x₁| / 2T)      (1)

and of all triples, those of the least c² less the scores of their groups are taken, each group once. Half of the
markers are expected to move as is usual in these frames, with the standard deviation v₀, so that at the speed s

    p(s) = s²/v² − 2 ln(1 + (v/v₀)³ exp(−s²/2 (1/v₀² − 1/v²)))                              (3)

Otherwise what goes along the markers of a finger, 17 mm from frame to frame, is hardly less likely than that they stay.
For v₀ the slowest triple through each of the middle points is taken; from LONG on it is v. Of the n points
other than the marker's that lie within its reach in the last frame, in a volume U, one fits as well by chance as the
marker does itself where the bend, of the covariance S and d standard deviations from none, has

    n √|2π S| / U > exp(−d²/2)                                                            (2)

so such triples are left, but none of less than LEAST_GATE: at few frames a second a marker among others begins where it
is hardly accelerated. Of the rest, points of SOUND and more images, which hardly meet by chance, are looked at again as
if v were FAST, where frames follow each other within SHORT: what is struck or thrown is faster than all else in a
recording, and leaves no track that could tell how fast.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ....native import inverse
from ..detection_index import Images
from ..simultaneous_method import Simultaneous
from .candidate_points import CandidatePoints, find_candidate_points
from .standing_images import find_standing_points

LEAST_FRAMES = 3
"""From which a track is initiated; by definition of (1)."""

REACH = 3
"""Standard deviations of velocities within which a point may have gone on; chosen: all but one marker in a hundred."""

LEAST_GATE = 3.0
"""Standard deviations of a bend that are always tried; chosen: 97 % of the markers with accelerations as expected. The
plate of studies/infrared_footage.py moves by half of its pitch more from frame to frame, as all LEDs do alike."""

FAST, SOUND = 15_000.0, 3
"""mm/s, and images of a point, a number; chosen: steps are looked for up to three times FAST, and few balls that are
struck are faster than 45 m/s."""

SHORT = 0.0101
"""s from frame to frame; chosen: at 10 Hz steps reach across a plate, which had 13 and 99 swaps for at most 5."""

LONG = 0.03
"""s from frame to frame, from which v₀ = v; chosen: at 25 Hz one scene of benchmarks/tracking_scenes.py (2121) had 17
swaps for 9 by (3), and the plate of studies/infrared_footage.py 21 tracks for 20. Hands would have fewer swaps."""

MEDIAN_OF_CHI, SLOWEST = 1.538, 1e-3
"""Median of the length of three normal numbers, by definition; and mm/s, the least v₀, chosen: it is 0 where all stands
still and there is no noise."""


class InitiatedTracks(NamedTuple):
    """B tracks seen in three successive frames: places (3) of `CandidatePoints`, all in the same order."""

    groups: tuple[CandidatePoints, CandidatePoints, CandidatePoints]

    def __len__(self) -> int:
        return self.groups[0].xyz.shape[-1]


def initiate(
    images: Images,
    free: Bools,
    F: Floats,
    lasts: list[int],
    T: float,
    method: Simultaneous,
    lasting: Floats | None = None,
) -> list[InitiatedTracks]:
    """Tracks that are initiated in the three frames that end with each of `lasts`, among the free images; among those
    alone that stand still, where `lasting_variance` (C) px² is given."""
    frames = [last - back for last in lasts for back in (2, 1, 0)]
    if lasting is None:
        groups = find_candidate_points(images, free, F, frames, method.gate)
    else:
        groups = find_standing_points(images, free, F, frames, T, method.gate, lasting)
    initiated, fast = [], replace(method, velocity_sd=max(FAST, method.velocity_sd))
    for last in lasts:
        each = [groups.frame == f for f in (last - 2, last - 1, last)]
        if not all(own.any() for own in each):  # mostly so, once all markers have their tracks
            continue
        first, middle, final = (groups.take(own) for own in each)
        i, j, k = _triples(first, middle, final, T, method)
        initiated.append(InitiatedTracks((first.take(i), middle.take(j), final.take(k))))
        if T < SHORT:
            first, middle, final = _sound_rest(first, i), _sound_rest(middle, j), _sound_rest(final, k)
            i, j, k = _triples(first, middle, final, T, fast)
            initiated.append(InitiatedTracks((first.take(i), middle.take(j), final.take(k))))
    return [one for one in initiated if len(one)]


def _sound_rest(groups: CandidatePoints, taken: Ints) -> CandidatePoints:
    """Those of SOUND and more images that are not taken."""
    rest = (groups.detection >= 0).sum(0) >= SOUND
    rest[taken] = False
    return groups.take(rest)


def _triples(
    first: CandidatePoints, middle: CandidatePoints, last: CandidatePoints, T: float, method: Simultaneous
) -> tuple[Ints, Ints, Ints]:
    """Places in each of the groups that are one point each, the surest first."""
    a, b = _neighbours(first, middle, T, method)
    b2, c = _neighbours(middle, last, T, method)
    pair, onward = np.nonzero(b[:, None] == b2)
    i, j, k = a[pair], b[pair], c[onward]
    bend = first.xyz[:, i] - 2 * middle.xyz[:, j] + last.xyz[:, k]
    S = first.cov[..., i] + 4 * middle.cov[..., j] + last.cov[..., k]
    S = S + (method.acceleration_sd * T * T) ** 2 * np.eye(3)[..., None]
    squared = (bend * np.einsum("ijt,jt->it", inverse(S), bend)).sum(0)  # (1)
    speed = np.linalg.norm(last.xyz[:, k] - first.xyz[:, i], axis=0) / (2 * T)
    fitting = squared < method.gate**2 if T < LONG else np.zeros(len(squared), bool)
    cost = squared + _pace(speed, j, fitting, method) - first.score[i] - middle.score[j] - last.score[k]
    reach = REACH * method.velocity_sd * T + _spread(middle)[j] + _spread(last)[k]
    chance = (np.bincount(b2)[j] - 1) * np.sqrt((2 * np.pi) ** 3 * np.linalg.det(S.T)) / (4 / 3 * np.pi * reach**3)
    least = LEAST_GATE if method.max_coasting >= 2 * T else method.gate  # at 10 Hz all LEDs of a plate bend alike
    rare = -2 * np.log(np.maximum(chance, np.finfo(float).tiny))
    fits = np.flatnonzero(squared < np.clip(rare, min(least, method.gate) ** 2, method.gate**2))  # (2)
    order = fits[np.argsort(cost[fits], kind="stable")]
    chosen = _once(np.array([i[order], j[order], k[order]]).T.tolist())
    return i[order[chosen]], j[order[chosen]], k[order[chosen]]


def _pace(speed: Floats, middle: Ints, fits: Bools, method: Simultaneous) -> Floats:
    """(3) of triples of speeds (N) mm/s through middle points (N), where `fits` (N) says which of them tell v₀."""
    least = np.full(middle.max(initial=-1) + 1, np.inf)
    np.minimum.at(least, middle[fits], speed[fits])
    least = least[np.isfinite(least)]
    usual = float(np.median(least)) / MEDIAN_OF_CHI if len(least) else np.inf
    wide, slower = (speed / method.velocity_sd) ** 2, max(method.velocity_sd / max(usual, SLOWEST), 1.0)
    return np.asarray(wide - 2 * np.log1p(slower**3 * np.exp(-wide * (slower**2 - 1) / 2)))


def _once(triples: list[list[int]]) -> list[int]:
    """Which of the triples have nothing of one before them."""
    used: set[tuple[int, int]] = set()
    chosen = []
    for n, triple in enumerate(triples):
        parts = set(enumerate(triple))
        if not parts & used:
            used |= parts
            chosen.append(n)
    return chosen


def _neighbours(one: CandidatePoints, other: CandidatePoints, T: float, method: Simultaneous) -> tuple[Ints, Ints]:
    """Points of successive frames between which a point may have gone: within REACH times the usual speed."""
    apart = np.linalg.norm(one.xyz[:, :, None] - other.xyz[:, None], axis=0)
    a, b = np.nonzero(apart < REACH * method.velocity_sd * T + _spread(one)[:, None] + _spread(other))
    return a, b


def _spread(groups: CandidatePoints) -> Floats:
    """(G) standard deviation of all three axes together, mm."""
    return np.sqrt(groups.cov[0, 0] + groups.cov[1, 1] + groups.cov[2, 2])
