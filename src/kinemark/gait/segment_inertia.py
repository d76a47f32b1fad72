"""Mass, centre and inertia of the segments of a leg, as shares of the body's mass and of the segment's length."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class SegmentInertia(NamedTuple):
    """One segment.

    Attributes:
        mass: share of the body's.
        centre: share of the length from the proximal joint, where the centre of mass is.
        radius: shares of the length: radii of gyration about the segment's x, y and z through that centre.
    """

    mass: float
    centre: float
    radius: tuple[float, float, float]


PLUG_IN_GAIT: Mapping[str, SegmentInertia] = {
    "foot": SegmentInertia(0.0145, 0.5, (0.69, 0.69, 0.0)),
    "shank": SegmentInertia(0.0465, 0.433, (0.528, 0.528, 0.0)),
    "thigh": SegmentInertia(0.1, 0.433, (0.54, 0.54, 0.0)),
}
"""As Plug-in Gait has them: radii about the proximal joint, taken as if they were about the centre of mass."""
WINTER: Mapping[str, SegmentInertia] = {
    "foot": SegmentInertia(0.0145, 0.5, (0.475, 0.475, 0.0)),
    "shank": SegmentInertia(0.0465, 0.433, (0.302, 0.302, 0.0)),
    "thigh": SegmentInertia(0.1, 0.433, (0.323, 0.323, 0.0)),
}
"""Dempster's, from Winter (2009), with the radii about the centre of mass."""
DE_LEVA_MALE: Mapping[str, SegmentInertia] = {
    "foot": SegmentInertia(0.0137, 0.4415, (0.257, 0.245, 0.124)),
    "shank": SegmentInertia(0.0433, 0.4459, (0.255, 0.249, 0.103)),
    "thigh": SegmentInertia(0.1416, 0.4095, (0.329, 0.329, 0.149)),
}
"""Zatsiorsky's, for joint centres, of young men (de Leva 1996)."""
DE_LEVA_FEMALE: Mapping[str, SegmentInertia] = {
    "foot": SegmentInertia(0.0129, 0.4014, (0.299, 0.279, 0.139)),
    "shank": SegmentInertia(0.0481, 0.4416, (0.271, 0.267, 0.093)),
    "thigh": SegmentInertia(0.1478, 0.3612, (0.369, 0.364, 0.162)),
}
"""Of young women (de Leva 1996)."""
INERTIAS: Mapping[str, Mapping[str, SegmentInertia]] = {
    "plug_in_gait": PLUG_IN_GAIT,
    "winter": WINTER,
    "de_leva_male": DE_LEVA_MALE,
    "de_leva_female": DE_LEVA_FEMALE,
}
"""By name."""
