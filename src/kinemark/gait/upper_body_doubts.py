"""Markers of head, trunk and arms that cannot be where their names say, of somebody who stands or walks.

With p and l of `marker_doubts`, and z upwards, in the median over the frames

    (left − right) · l > 0   of shoulders and head                                                            (1)
    (front − back) · p > 0   of head and trunk                                                                (2)
    (upper − lower) · z > 0   of the trunk                                                                    (3)
    |near − end| < |far − end|   of the markers of an arm, which follow each other from neck to hand          (4)

Arms may be folded, with hands on the other side, so that (1) tells nothing of them. But an elbow is nearer to its own
shoulder than to the other one, and a forearm is not much longer than the upper arm,

    |elbow − wrist| < 1.5 |shoulder − elbow|                                                                  (5)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..data.array_types import Floats
from ..data.landmarks import landmarks
from ..data.subject_measures import LETTER
from .marker_doubts import OPPOSITE_MM, along, apart, forward_of, nearer_to_other
from .segments import Z_UP

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
ACROSS = ("FHD", "BHD", "SHO")
"""Pairs of (1), after L and R; conventional."""
IN_FRONT = (("LFHD", "LBHD"), ("RFHD", "RBHD"), ("CLAV", "C7"), ("STRN", "T10"))
"""Front and back of (2); conventional."""
ABOVE = (("C7", "T10"), ("CLAV", "STRN"))
"""Upper and lower of (3); conventional."""
ALONG = (("SHO", "ELB", "C7"), ("WRA", "ELB", "FIN"), ("WRB", "ELB", "FIN"), ("WRA", "FIN", "ELB"))
"""Near, far and end of (4), after L or R where they have a side; conventional."""
LEAST_MM = 10.0
"""By which (2), (3) and (4) must fail, mm; chosen: of 29 public trials, in which people stand, walk, dance and serve,
the least was +32, from wrist to hand, and +86 of the others."""
PARTS = (("SHO", "ELB", "WRA"), ("SHO", "ELB", "WRB"), ("ELB", "WRA", "FIN"))
"""Of (5), after L and R; conventional."""
LONGER = 1.5
"""Of (5); chosen: forearms are 0.8 of upper arms (Drillis and Contini 1966), and markers sit beside the joints."""


def upper_body_doubts(points: Mapping[str, Floats], *, up: Floats = Z_UP) -> Iterator[tuple[str, ...]]:
    """Names of two markers each that cannot be where they are; nothing of markers that are not there.

    Args:
        points: (F, 3) mm by names. up: of the laboratory.
    """
    forward = forward_of(points, up)
    if forward is None:
        return
    own = _model_names(points)
    known = {name: points[one] for name, one in own.items()}
    told = set[str]()
    for two, by in _exchanged(known, forward, np.cross(up, forward), up):
        if told.isdisjoint((*two, *by)):  # what is wrong above makes what is below it look wrong
            told |= {*two}
            yield tuple(own[name] for name in two)


def _model_names(names: Sequence[str] | Mapping[str, Floats]) -> dict[str, str]:
    """Names by those of `WORDS`, with L or R before those that have a side."""
    found: dict[str, tuple[int, str]] = {}
    for name, ways in landmarks(tuple(names)).items():
        for one in ways:
            for word, spelt in WORDS.items():
                if one.word in spelt:
                    rank = spelt.index(one.word), name
                    key = (LETTER[one.side] if one.side else "") + word
                    found[key] = min(rank, found.get(key, rank))
    return {key: name for key, (_, name) in found.items()}


Told = tuple[tuple[str, str], tuple[str, ...]]
"""Two markers that are exchanged, and others by which that is told."""


def _exchanged(known: Mapping[str, Floats], forward: Floats, left: Floats, up: Floats) -> Iterator[Told]:
    """By (1) to (5), from the trunk on."""
    for name in ACROSS:
        if _along(known, "L" + name, "R" + name, left) < -OPPOSITE_MM:
            yield ("L" + name, "R" + name), ()
    for rows, way in ((IN_FRONT, forward), (ABOVE, np.broadcast_to(up, forward.shape))):
        yield from ((two, ()) for two in rows if _along(known, *two, way) < -LEAST_MM)
    if nearer_to_other(known, "SHO", "ELB"):
        yield ("LELB", "RELB"), ("LSHO", "RSHO")
    for a, b, c in PARTS:
        if all(apart(known, s + b, s + c) > LONGER * apart(known, s + a, s + b) for s in LETTER.values()):
            yield ("L" + c, "R" + c), ("L" + a, "R" + a, "L" + b, "R" + b)
    for near, far, end in ALONG:
        for side in LETTER.values():
            own = end if end in known else side + end
            if apart(known, side + near, own) > apart(known, side + far, own) + LEAST_MM:
                yield (side + near, side + far), (own,)


def _along(known: Mapping[str, Floats], a: str, b: str, way: Floats) -> float:
    """mm of a − b along (F, 3), the median; 0 where one is not there."""
    return along(known[a] - known[b], way) if {a, b} <= set(known) else 0.0
