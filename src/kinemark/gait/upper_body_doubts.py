"""Markers of head, trunk and arms that cannot be where their names say, of somebody who stands or walks.

With l to the left and p to the front of the shoulders, which is the same whatever side these are called, or of the
pelvis (`marker_doubts`), and z upwards, in the median over the frames in which the trunk stands above the pelvis

    (left − right) · l > 0   of shoulders, by the pelvis, and head                                            (1)
    (front − back) · p > 0   of head and trunk                                                                (2)
    (upper − lower) · z > 0   of the trunk                                                                    (3)

and in all frames

    |near − end| < |far − end|   of the markers of an arm, which follow each other from neck to hand          (4)

Exchanged names turn a direction by 180°; who bends down, or looks over the shoulder, turns it by less than 120°. Arms
may be folded, with hands on the other side, so that (1) tells nothing of them. But an elbow is nearer to its own
shoulder than to the other one, and a forearm is not much longer than the upper arm,

    |elbow − wrist| < 1.5 |shoulder − elbow|                                                                  (5)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..data.array_types import Bools, Floats
from ..data.landmarks import landmarks
from ..data.subject_measures import LETTER
from .marker_doubts import TURNED, along, apart, forward_of, nearer_to_other
from .segments import Z_UP, along_floor, unit

WORDS = {
    "FHD": ("fhd", "fronthead", "headfront"),
    "BHD": ("bhd", "backhead", "headback"),
    "SHO": ("sho", "shoulder", "shouldertop", "acromion", "acr", "acj"),
    "ELB": ("elb", "elbow", "elbowout", "elblat"),
    "WRA": ("wra", "wrist", "wristin"),
    "WRB": ("wrb", "wristout"),
    "FIN": ("fin", "hand", "handout"),
    "C7": ("c7", "cv7"),
    "T10": ("t10", "tv10"),
    "CLAV": ("clav", "jug", "ij", "chesttop"),
    "STRN": ("strn", "sternum", "px", "xiphoid"),
}
"""What laboratories call them, after the side, most usual first; conventional."""
SHOULDERS = ("LSHO", "RSHO")
"""Pair of (1); conventional."""
ACROSS = ("FHD", "BHD")
"""Pairs of (1) on the head, after L and R; conventional."""
IN_FRONT = (("LFHD", "LBHD"), ("RFHD", "RBHD"), ("CLAV", "C7"), ("STRN", "T10"))
"""Front and back of (2); conventional."""
ABOVE = (("C7", "T10"), ("CLAV", "STRN"))
"""Upper and lower of (3); conventional."""
ALONG = (("SHO", "ELB", "C7"), ("WRA", "ELB", "FIN"), ("WRB", "ELB", "FIN"), ("WRA", "FIN", "ELB"))
"""Near, far and end of (4), after L or R where they have a side; conventional."""
TRUNK = (*SHOULDERS, "C7", "CLAV", "T10", "STRN")
"""Which together are above the pelvis rather than beside it where (1) to (3) tell something; conventional."""
LEAST_MM = 10.0
"""By which (4) must fail, mm; chosen: of 29 public trials, in which people stand, walk, dance and serve, the least was
+32, from wrist to hand, and +86 of the others."""
FARTHER = 1.3
"""Times as far from its own shoulder as from the other one, from which an elbow is of the other; chosen: the other
one is 1.4 times as far and more, also of folded arms, and elbows that cross before the chest are up to 1.2 of it."""
PARTS = (("SHO", "ELB", "WRA"), ("SHO", "ELB", "WRB"), ("ELB", "WRA", "FIN"))
"""Of (5), after L and R; conventional."""
LONGER = 1.5
"""Of (5); chosen: forearms are 0.8 of upper arms (Drillis and Contini 1966), and markers sit beside the joints."""


def upper_body_doubts(points: Mapping[str, Floats]) -> Iterator[tuple[str, ...]]:
    """Names of two markers each that cannot be where they are; nothing of markers that are not there.

    Args:
        points: (F, 3) mm by names.
    """
    own = trunk_and_arm_names(tuple(points))
    known = {name: points[one] for name, one in own.items()}
    forward = forward_of(points)
    if forward is None:
        return
    told = set[str]()
    for two, by in _exchanged(known, _stands(points, known), np.cross(Z_UP, forward)):
        if told.isdisjoint((*two, *by)):  # what is wrong above makes what is below it look wrong
            told |= {*two}
            yield tuple(own[name] for name in two)


def trunk_and_arm_names(names: Sequence[str]) -> dict[str, str]:
    """Names by those of `WORDS`, with L or R before those that have a side."""
    found: dict[str, tuple[int, str]] = {}
    for name, ways in landmarks(names).items():
        for one in ways:
            for word, spelt in WORDS.items():
                if one.word in spelt:
                    rank = spelt.index(one.word), name
                    key = (LETTER[one.side] if one.side else "") + word
                    found[key] = min(rank, found.get(key, rank))
    return {key: name for key, (_, name) in found.items()}


Told = tuple[tuple[str, str], tuple[str, ...]]
"""Two markers that are exchanged, and others by which that is told."""


def _stands(points: Mapping[str, Floats], known: Mapping[str, Floats]) -> Bools:
    """(F) whether the trunk is above the pelvis rather than beside it; yes where it has no markers."""
    trunk = [known[name] for name in TRUNK if name in known]
    if not trunk:
        return np.ones(len(points["LASI"]), bool)
    v = sum(trunk) / len(trunk) - (points["LASI"] + points["RASI"]) / 2
    return np.asarray(v @ Z_UP > np.linalg.norm(along_floor(v), axis=1))


def _left_of_trunk(known: Mapping[str, Floats], left: Floats) -> Floats:
    """(F, 3) l by the shoulders, whatever side they are called; as that of the pelvis, `left`, without them."""
    if not {*SHOULDERS} <= set(known):
        return left
    across = known["LSHO"] - known["RSHO"]
    across = unit(along_floor(across))
    return across * np.sign(along(across, left))


def _exchanged(known: Mapping[str, Floats], stands: Bools, left: Floats) -> Iterator[Told]:
    """By (1) to (5), from the trunk on."""
    by = _left_of_trunk(known, left)
    head = [("L" + name, "R" + name) for name in ACROSS]
    above = np.broadcast_to(Z_UP, left.shape)
    for rows, way in (((SHOULDERS,), left), (head, by), (IN_FRONT, np.cross(by, Z_UP)), (ABOVE, above)):
        yield from ((two, ()) for two in rows if _turned(known, *two, way, stands))
    yield from _exchanged_in_arms(known)


def _turned(known: Mapping[str, Floats], a: str, b: str, way: Floats, stands: Bools) -> bool:
    """Whether a − b points the other way than (F, 3), by (1) to (3); no where one is not there."""
    return {a, b} <= set(known) and along(unit(known[a] - known[b])[stands], way[stands]) < TURNED


def _exchanged_in_arms(known: Mapping[str, Floats]) -> Iterator[Told]:
    """By (4) and (5)."""
    if nearer_to_other(known, "SHO", "ELB", times=FARTHER):
        yield ("LELB", "RELB"), SHOULDERS
    for a, b, c in PARTS:
        if all(apart(known, s + b, s + c) > LONGER * apart(known, s + a, s + b) for s in LETTER.values()):
            yield ("L" + c, "R" + c), ("L" + a, "R" + a, "L" + b, "R" + b)
    for near, far, end in ALONG:
        for side in LETTER.values():
            own = end if end in known else side + end
            if apart(known, side + near, own) > apart(known, side + far, own) + LEAST_MM:
                yield (side + near, side + far), (own,)
