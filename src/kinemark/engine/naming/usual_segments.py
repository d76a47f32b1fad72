"""Which markers of a static trial sit on one segment, where nobody says it and their names do.

One posture does not show which distances keep. But landmarks of the body have names that laboratories share or spell
each in their own way (`data.landmarks`), and those that are Plug-in Gait's keep the distances that its segments keep.
So do inner epicondyles and malleoli, a sacrum, and what names put on a thigh or shank ("Thigh.Upper", "LTHAP").
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from ...data import MarkerSet
from ...data.edits import is_named
from ...data.landmarks import landmarks
from ...data.model_markers import INSIDE, model_names
from ...data.subject_measures import LETTER, SIDES
from ...gait.clusters import ON_SEGMENT
from ...gait.upper_body_doubts import trunk_and_arm_names
from ...io.marker_sets import read_marker_set

SHIPPED = "plug-in-gait-full"
"""The marker set whose segments they are; conventional."""
BESIDES = {
    "pelvis": ("SACR",),
    **{f"{side} thigh": (LETTER[side] + INSIDE[0],) for side in SIDES},
    **{f"{side} shank": tuple(LETTER[side] + name for name in INSIDE) for side in SIDES},
    **{f"{side} foot": (LETTER[side] + INSIDE[1],) for side in SIDES},
}
"""The gait model's markers on segments besides Plug-in Gait's; conventional (Helen Hayes, CGM2)."""


def set_of_names(shown: Sequence[str]) -> MarkerSet | None:
    """All named markers of a static trial, those of a segment together; None where names tell no segment.

    Args:
        shown: names in the static trial, without the subject's.
    """
    named, shipped = tuple(filter(is_named, shown)), read_marker_set(SHIPPED)
    own = {**trunk_and_arm_names(named), **model_names(named), **{n: n for n in named if n in shipped.names}}
    segments = dict[str, tuple[str, ...]]()
    for key, markers in shipped.segments.items():
        landmarks_there = [own[name] for name in (*markers, *BESIDES.get(key, ())) if name in own]
        if len(there := dict.fromkeys((*landmarks_there, *_numbered(key, named)))) > 1:
            segments[key] = tuple(there)
    joints = {key: ends for key, ends in shipped.joints.items() if {*ends} <= {*segments}}
    rigidity = {key: shipped.rigidity[key] for key in segments}
    return MarkerSet(named, segments, name="of usual names", rigidity=rigidity, joints=joints) if segments else None


def _numbered(segment: str, names: tuple[str, ...]) -> list[str]:
    """Names of markers that say on which thigh or shank they are."""
    own, _, part = segment.partition(" ")
    ways = landmarks(names) if part in ON_SEGMENT else {}
    return [
        name for name in ways if any(way.side == own and re.fullmatch(ON_SEGMENT[part], way.word) for way in ways[name])
    ]
