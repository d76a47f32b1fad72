"""Whether a subject walks backwards: events of the feet come in the reverse order then, and the way goes behind.

Over ground, with the pelvis at p and d its own direction on the floor, the way that it goes as it faces

    w = Σ (pₖ₊₁ − pₖ) · dₖ                                                                                    (1)

is below zero. On a treadmill w tells nothing, or where the subject drifts; there a foot that swings is high, and goes
the way of the walk from the pelvis, so that the correlation of its height and of this speed has the sign of the way
(2).

Who goes to and fro without turning round walks forwards in one part and backwards in the next: the sum (1) up to a
frame turns there by what is a walk. It counts where (2) agrees in each part (3), as who drifts to and fro on a
treadmill walks one way.

Backward walking is forward walking with time turned, as far as the motion of legs goes (Winter et al. 1989).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats, Ints
from ..data.subject_measures import LETTER
from .lower_limb import pelvis_of
from .segments import Z_UP, Segment, along_floor, unit
from .straight_passes import WALKED_MM

AGAINST = -0.2
"""Correlation (2), mean of both feet, below which the walk goes behind; chosen: in 13 public walks and turns forward it
was 0.51 and more, and in one on stairs 0.25."""


CLEAR = 0.4
"""Size of the correlation (2) above which it counts against (1), as of one who drifts on a treadmill; chosen: below
what walks over ground had, forward and turned in time."""


class WalkedPart(NamedTuple):
    """Frames first to stop − 1 of a trial, in which the subject walks one way: backwards, or forwards."""

    first: int
    stop: int
    backwards: bool


def walks_backwards(points: Mapping[str, Floats]) -> bool:
    """Whether the subject does in any part; `points` as in `walked_parts`."""
    return any(part.backwards for part in walked_parts(points))


def walked_parts(points: Mapping[str, Floats]) -> list[WalkedPart]:
    """The parts of a trial by (3), mostly one; which way by (1), or by (2) where the pelvis stays.

    Args:
        points: (F, 3) mm by the model's names; without pelvis or feet nothing is known.
    """
    feet = [s + name for s in LETTER.values() for name in ("HEE", "TOE")]
    whole = WalkedPart(0, max(map(len, points.values()), default=0), backwards=False)
    if not {"LASI", "RASI", *feet} <= set(points) or not ({"SACR"} <= set(points) or {"LPSI", "RPSI"} <= set(points)):
        return [whole]
    pelvis = pelvis_of(points)[0]
    parts = parts_by_way(pelvis)
    if len(parts) > 1 and all((_agreement(points, pelvis, part) < 0) == part.backwards for part in parts):
        return parts
    w, agreement = way_as_faced(pelvis), _agreement(points, pelvis, whole)
    drifts = w * agreement < 0 and abs(agreement) > CLEAR
    backwards = w < 0 if abs(w) >= WALKED_MM and not drifts else agreement < AGAINST
    return [whole._replace(backwards=backwards)]


def reversals(points: Mapping[str, Floats]) -> Ints:
    """Frames in which the subject turns from walking forwards to backwards or the reverse; `points` as above."""
    return np.array([part.first for part in walked_parts(points)[1:]], np.int64)


def parts_by_way(pelvis: Segment) -> list[WalkedPart]:
    """Parts of (F) frames between which the sum (1) turns by `WALKED_MM` or more; one where it never does."""
    at = np.concatenate([[0.0], np.nancumsum(_steps_as_faced(pelvis))])
    edges, way, farthest = [0], 0.0, 0
    for k, w in enumerate(at):
        if way == 0 and abs(w) >= WALKED_MM:
            way, farthest = float(np.sign(w)), k
        elif way * (w - at[farthest]) > 0:
            farthest = k
        elif way * (at[farthest] - w) >= WALKED_MM:
            edges.append(farthest)
            way, farthest = -way, k
    bounds = pairwise([*edges, len(at)])
    return [WalkedPart(first, stop, bool(at[stop - 1] - at[first] <= -WALKED_MM)) for first, stop in bounds]


def way_as_faced(pelvis: Segment) -> float:
    """(1), mm, over the frames in which the pelvis (F) is known."""
    return float(np.nansum(_steps_as_faced(pelvis)))


def _steps_as_faced(pelvis: Segment) -> Floats:
    """(F−1) mm, the terms of (1); NaN where the pelvis is not known."""
    d = _faced(pelvis)
    return np.asarray((np.diff(pelvis.origin, axis=0) * (d[1:] + d[:-1]) / 2).sum(-1))


def _agreement(points: Mapping[str, Floats], pelvis: Segment, part: WalkedPart) -> float:
    """(2) in a part, mean of both feet."""
    k = slice(part.first, part.stop)
    own = replace(pelvis, origin=pelvis.origin[k], R=pelvis.R[k])
    feet = ((points[s + "HEE"] + points[s + "TOE"])[k] for s in LETTER.values())
    return float(np.mean([_correlation(foot, own) for foot in feet]))


def _faced(pelvis: Segment) -> Floats:
    """(F, 3) d."""
    x = pelvis.R[..., 0]
    return unit(along_floor(x))


def _correlation(twice_middle: Floats, pelvis: Segment) -> float:
    """(2) of a foot, of twice its middle (F, 3); 0 where it is hardly known, or does not move."""
    ahead = ((twice_middle / 2 - pelvis.origin) * _faced(pelvis)).sum(-1)
    if len(ahead) < 2:
        return 0.0
    both = np.stack([twice_middle @ Z_UP, np.gradient(ahead)])
    both = both[:, np.isfinite(both).all(0)]
    if both.shape[1] < 2 or not both.std(axis=1).all():
        return 0.0
    return float(np.corrcoef(both)[0, 1])
