"""Markers that cannot be where their names say: exchanged with another side or neighbour, or moved on the bone.

Names that are wrong turn all that follows, and look plausible there. With the horizontal direction p from the back of
the pelvis to its front, which is the same whatever side its markers are called, and l = z × p to its left, in the
median over the frames

    (left − right) · l > 0   of every pair of markers                                                         (1)
    cos(toe − heel, p) > −½  of every foot                                                                    (2)
    |near − end| < |far − end|   of the markers of a leg, which follow each other from pelvis to toe          (3)

Exchanged names turn a foot by 180°; who turns it in or out, by less than 120°. Where (1) fails for all pairs that tell,
left and right are exchanged throughout, or the axes of the file are left-handed; where (2) fails as well, the front of
the pelvis is its back. Two markers of one segment keep their distance but for skin (4).

Legs that scissor, and feet that turn in, bring ankles, heels and toes across as well. These count as exchanged only
where they leave their own leg: where (4) fails, the joint above is exchanged as well, or a heel or toe of either side
is nearer to the ankle of the other (5).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..data.subject_measures import LETTER
from ..numerics.finite import finite_median
from .segments import Z_UP, along_floor, unit

ACROSS = ("ASI", "PSI", "THI", "KNE", "TIB", "ANK", "HEE", "TOE")
"""Pairs of (1), after L and R; conventional."""
ALONG = {
    "KNE": (("ANK", "ASI", 30.0),),
    "THI": (("KNE", "ASI", 30.0),),
    "TIB": (("KNE", "ANK", 30.0), ("ANK", "KNE", 30.0)),
    "ANK": (("HEE", "KNE", 15.0), ("TOE", "HEE", 30.0)),
}
"""By the nearer marker the farther and the end of (3), after L or R, and by how many mm it must fail; chosen: in 50
legs of public standing trials, walks, turns and leaps the least of (3) was +61, from ankle to heel +30."""
SEGMENTS = (
    ("KNE", "ANK"),
    ("KNE", "TIB"),
    ("TIB", "ANK"),
    ("HEE", "TOE"),
    ("ANK", "HEE"),
    ("ANK", "TOE"),
    ("THI", "KNE"),
)
"""Pairs of (4), after L or R; conventional."""
ABOVE = {"ANK": "KNE", "HEE": "ANK", "TOE": "ANK"}
"""The joint above of (5), after L or R; by definition."""
ON_FOOT = ("HEE", "TOE")
"""Of (5), on one bone with the ankle but for skin; by definition."""
OPPOSITE_MM = 30.0
"""By which (1) must fail, mm; chosen: in 17 public walks and turns the least was +63; legs that cross by less are a
person's."""
TURNED = -0.5
"""Cosine with the direction that names ask for, as of (2), below which it fails; by definition of 120°."""
MOVED_MM = 90.0
"""Width of the middle 95 % of a distance (4), mm; chosen: in the same walks it was up to 43, in one of poor
names 66."""
MIDDLE = (2.5, 97.5)
"""Percentiles of (4); by definition of its middle."""

Exchange = Literal["sides", "pelvis", "across", "foot", "leg"]


class MarkerDoubts(NamedTuple):
    """What of a trial's names cannot be.

    Attributes:
        exchanged: how, with the model's names of the markers: "sides" all of them, left and right; "pelvis" its front
            and back; "across" with the other side; "foot" heel and toe; "leg" two that follow each other.
        moved: pairs of markers of one segment whose distance changes, with the width of its middle 95 %, mm.
    """

    exchanged: tuple[tuple[Exchange, tuple[str, ...]], ...] = ()
    moved: tuple[tuple[str, str, float], ...] = ()


def marker_doubts(points: Mapping[str, Floats]) -> MarkerDoubts:
    """What of a trial's names cannot be; nothing of markers that are not there.

    Args:
        points: (F, 3) mm by the model's names.
    """
    changing = list(_moved(points))
    exchanged = (*_exchanged_sides(points, changing), *_exchanged_in_legs(points))
    named = {name for _, names in exchanged for name in names}
    moved = tuple((a, b, mm) for a, b, mm in changing if not {a, b} & named)
    return MarkerDoubts(exchanged, moved)


def _exchanged_sides(
    points: Mapping[str, Floats], changing: Sequence[tuple[str, str, float]]
) -> Iterator[tuple[Exchange, tuple[str, ...]]]:
    """By (1), (2) and (5), with what fails (4)."""
    forward = forward_of(points)
    if forward is None:
        return
    left = np.cross(Z_UP, forward)
    pairs = [("L" + name, "R" + name) for name in ACROSS if {"L" + name, "R" + name} <= set(points)]
    aside = {(a, b): along(points[a] - points[b], left) for a, b in pairs}
    across = [pair for pair, mm in aside.items() if mm < -OPPOSITE_MM]
    feet = [(s + "HEE", s + "TOE") for s in LETTER.values() if {s + "HEE", s + "TOE"} <= set(points)]
    back = [(heel, toe) for heel, toe in feet if along(unit(points[toe] - points[heel]), forward) < TURNED]
    if len(across) > 2 and max(aside.values()) <= OPPOSITE_MM:
        pelvis = tuple(name for name in ("LASI", "RASI", "SACR", "LPSI", "RPSI") if name in points)
        yield ("pelvis", pelvis) if back and len(back) == len(feet) else ("sides", ())
        return
    moved = {name for a, b, _ in changing for name in (a, b)}
    exchanged: list[str] = []
    for pair in across:  # joints come before what is below them
        name = pair[0][1:]
        off = name in ON_FOOT and nearer_to_other(points, "ANK", name)
        if name not in ABOVE or ABOVE[name] in exchanged or moved.intersection(pair) or off:
            exchanged.append(name)
            yield "across", pair
    for pair in back:
        yield "foot", pair


def _exchanged_in_legs(points: Mapping[str, Floats]) -> Iterator[tuple[Exchange, tuple[str, ...]]]:
    """By (3), from the hip on: what is wrong above makes what is below it look wrong."""
    for side in LETTER.values():
        told = set[str]()
        for near, rows in ALONG.items():
            by = [(_farther(points, side + near, side + far, side + end) - mm, side + far) for far, end, mm in rows]
            most, far = max(by)
            if most > 0 and side + near not in told:
                told |= {side + near, far}
                yield "leg", (side + near, far)


def _farther(points: Mapping[str, Floats], near: str, far: str, end: str) -> float:
    """mm by which (3) fails in the median; 0 where one is not there."""
    if not {near, far, end} <= set(points):
        return 0.0
    distances = (np.linalg.norm(points[name] - points[end], axis=-1) for name in (near, far))
    return finite_median(np.subtract(*distances), 0.0)


def _moved(points: Mapping[str, Floats]) -> Iterator[tuple[str, str, float]]:
    """By (4)."""
    for side in LETTER.values():
        for a, b in ((side + first, side + second) for first, second in SEGMENTS):
            apart = np.linalg.norm(points[a] - points[b], axis=-1) if {a, b} <= set(points) else np.zeros(0)
            apart = apart[np.isfinite(apart)]
            width = float(np.ptp(np.percentile(apart, MIDDLE))) if len(apart) else 0.0
            if width > MOVED_MM:
                yield a, b, width


def apart(points: Mapping[str, Floats], a: str, b: str) -> float:
    """mm between two markers, the median; NaN, which is no more than anything, where one is not there."""
    return finite_median(np.linalg.norm(points[a] - points[b], axis=-1)) if {a, b} <= set(points) else np.nan


def nearer_to_other(points: Mapping[str, Floats], joint: str, name: str, *, times: float = 1.0) -> bool:
    """Whether a marker of either side is clearly, so many times, nearer to the other side's joint than to its own."""
    return all(
        apart(points, own + joint, own + name) > times * apart(points, other + joint, own + name) + OPPOSITE_MM
        for own, other in (("L", "R"), ("R", "L"))
    )


def forward_of(points: Mapping[str, Floats]) -> Floats | None:
    """(F, 3) p; None where the pelvis has no markers in front or at the back."""
    back = ["SACR"] if "SACR" in points else ["LPSI", "RPSI"]
    if not {"LASI", "RASI", *back} <= set(points):
        return None
    p = (points["LASI"] + points["RASI"]) / 2 - sum(points[name] for name in back) / len(back)
    return unit(along_floor(p))


def along(v: Floats, way: Floats) -> float:
    """mm of (F, 3) along (F, 3), the median; 0 where nothing is known."""
    return finite_median((v * way).sum(-1), 0.0)
