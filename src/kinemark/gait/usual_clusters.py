"""Clusters that need no statement, because the names of the markers tell their segment.

Sets without wands have three or more markers on thigh and shank: the landmarks of the Rizzoli sets and of the ISB
(trochanter, epicondyles; head of the fibula, tuberosity of the tibia, malleoli; Leardini et al. 2007), plates or skin
markers numbered on a segment (LTH1 … LTH4), CGM2's THAP and THAD, "Thigh.Upper". They stand for the wands of the model.
"""

from __future__ import annotations

import re
from collections.abc import Collection

from ..data.landmarks import landmarks
from ..data.model_markers import INSIDE
from ..data.subject_measures import LETTER, SIDES
from .clusters import FEWEST, Clusters, landmarks_of
from .lower_limb import absent_markers

ON_SEGMENT = {
    "thigh": r"th(igh)?[1-9]|thi[1-9]|thap|thad|thigh(upper|lower|front|rear|back|lat|med|side|top|bottom)"
    r"|ftc|gt|gtr|(greater)?troch(anter)?",
    "shank": r"sk[1-9]|shank[1-9]|tib[1-9]|tiap|tiad|shank(upper|lower|front|rear|back|lat|med|side|top|bottom)"
    r"|fax|hf|fh|fib(ula)?head|headfib(ula)?|ttc|tt|tub|tibtub|tibialtuberosity",
}
"""What markers are called that sit on a segment and are none of the model's, without side and signs; conventional."""
OF_JOINT = {"thigh": ("KNE", INSIDE[0]), "shank": ("ANK", INSIDE[1])}
"""The model's markers that may belong to its cluster, after L or R; conventional."""


def usual_clusters(walk: Collection[str], static: Collection[str], stated: Clusters) -> dict[str, tuple[str, ...]]:
    """Clusters by segment of thighs and shanks that the walk wants one for, by names; none of segments that have one.

    The model's own markers at knee and ankle belong to a cluster only where it would be too small without them.

    Args:
        walk: names of markers, the model's own called as the model has them, that all walks have.
        static: the same of the standing trial, with wands (`with_wands`). stated: by whoever knows.
    """
    lacking = set(absent_markers(walk))
    if not lacking & set(static):
        return {}  # most walks wear all, and to read names takes a while
    ways = landmarks(list(walk))
    taken = {marker for own in stated.values() for marker in own}
    found = {}
    for side in SIDES:
        for part, pattern in ON_SEGMENT.items():
            segment = f"{side} {part}"
            wanted = lacking & set(landmarks_of(segment))
            if segment in stated or not wanted or not wanted <= set(static):
                continue
            free = [name for name in walk if name in static and name not in taken]
            own = [n for n in free if any(way.side == side and re.fullmatch(pattern, way.word) for way in ways[n])]
            if len(own) < FEWEST:
                own += [n for n in (LETTER[side] + name for name in OF_JOINT[part]) if n in free]
            if len(own) >= FEWEST:
                found[segment] = tuple(own)
    return found
