"""Axes of knee and ankle that a standing trial shows, by knee alignment devices or markers inside of the joints.

A device on the knee has three markers KAX, KD1 and KD2 at the ends of three rods of one length L, square to each other,
with KAX along the axis of the knee outwards. Its apex, where the rods meet, stands for the marker KNE, which is put on
at the same place afterwards:

    O = c ± n L / √3,   L = mean distance of the three / √2,   c their mean, n their plane's normal            (1)

on that side which is nearer to the line from hip to ankle. Markers KNM on the inner epicondyle and MED on the inner
malleolus show the axes from the inside: outwards of KNE lies 2 KNE − KNM (2). Knee and ankle then follow by the chord
with these in place of the wands, and

    wand = angle about the segment from the joint's axis to THI or TIB, outwards                              (3)
    torsion = angle about the shank from the knee's axis to the ankle's, outwards                             (4)

are the offsets by which the walks' wands are turned back. Without MED the ankle's axis is the knee's, turned by the
torsion that is stated (5).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from ..data.array_types import Floats
from ..data.model_markers import DEVICE, INSIDE
from ..data.subject_measures import LETTER, SIDES, TO_THE_LEFT, LegMeasures, Side, SubjectMeasures
from .lower_limb import hips_of
from .segments import joint_centre, perpendicular, unit

AxesShown = Literal["", "devices", "markers"]
ROUNDS = 8
"""Of (5), where the ankle hangs on its own axis; chosen, the sixth changes nothing at double precision."""


def axes_shown(static: Mapping[str, Floats]) -> AxesShown:
    """By what a standing trial shows the axes of both knees: "devices", "markers", or "" where it shows none.

    Args:
        static: (F, 3) mm by the model's names.
    """
    if all(device_worn(static, letter) for letter in LETTER.values()):
        return "devices"
    return "markers" if all(_seen(static, letter + INSIDE[0]) for letter in LETTER.values()) else ""


def with_knees(static: Mapping[str, Floats]) -> dict[str, Floats]:
    """The standing trial with the apex of each device (1) as the knee's marker, where it wears none.

    Args:
        static: (F, 3) mm by the model's names.
    """
    out = dict(static)
    for letter in LETTER.values():
        inner = {letter + name for name in ("ASI", "ANK")}
        if device_worn(static, letter) and inner <= set(static) and not _seen(static, letter + "KNE"):
            centre = np.mean([static[name] for name in inner], axis=0)
            kax, kd1, kd2 = (static[letter + name] for name in DEVICE)
            out[letter + "KNE"] = _apex(kax, kd1, kd2, centre)
    return out


def with_static_axes(
    measures: SubjectMeasures, static: Mapping[str, Floats], *, hip_centre: str = "davis"
) -> SubjectMeasures:
    """The measures with the wands and torsions (3), (4) that a standing trial shows, means over its frames.

    Args:
        measures: of the subject. static: (F, 3) mm by the model's names, knees with their marker (`with_knees`).
        hip_centre: the regression.

    Raises:
        KinemarkError: a marker of the pelvis is not there.
    """
    if not axes_shown(static):
        return measures
    hips = hips_of(static, measures, hip_centre=hip_centre)
    for side in SIDES:
        measures = measures.with_leg(side, _with_axes(measures, static, side, hips[side]))
    return measures


def _with_axes(measures: SubjectMeasures, static: Mapping[str, Floats], side: Side, hip: Floats) -> LegMeasures:
    own, s, r = measures.leg(side), TO_THE_LEFT[side], measures.marker_diameter_mm / 2
    thi, kne, tib, ank = (static[LETTER[side] + name] for name in ("THI", "KNE", "TIB", "ANK"))
    beyond = _beyond(static, side)
    knee = joint_centre(hip, kne, beyond, half_width_mm=own.knee_mm / 2 + r, outwards=s)
    axis = s * (kne - knee)
    half, inner = own.ankle_mm / 2 + r, static.get(LETTER[side] + "MED")
    if inner is not None and np.isfinite(inner).any():
        ankle = joint_centre(knee, ank, 2 * ank - inner, half_width_mm=half, outwards=s)
        torsion = s * _mean_angle(axis, s * (ank - ankle), knee - ankle)  # (4)
    else:
        ankle, torsion = _ankle_below(knee, ank, axis, half, s, own.torsion_deg), own.torsion_deg
    return replace(
        own, thigh_wand_deg=s * _mean_angle(kne - knee, thi - knee, hip - knee), torsion_deg=torsion,
        shank_wand_deg=s * _mean_angle(ank - ankle, tib - ankle, knee - ankle),
    )  # fmt: skip


def _beyond(static: Mapping[str, Floats], side: Side) -> Floats:
    """(F, 3) mm a point outwards on the axis of the knee: KAX or (2)."""
    letter = LETTER[side]
    if device_worn(static, letter):
        return static[letter + "KAX"]
    return np.asarray(2 * static[letter + "KNE"] - static[letter + "KNM"])


def _ankle_below(knee: Floats, ank: Floats, axis: Floats, half: float, s: float, torsion_deg: float) -> Floats:
    """(F, 3) mm of the ankle whose axis is the knee's, turned by the torsion (5)."""
    ankle, turn = ank, np.radians(s * torsion_deg)
    for _ in range(ROUNDS):
        z = unit(knee - ankle)
        y = perpendicular(axis, z)
        outwards = s * (np.cos(turn) * y + np.sin(turn) * np.cross(z, y))
        ankle = joint_centre(knee, ank, knee + outwards, half_width_mm=half, outwards=s)
    return ankle


def _mean_angle(a: Floats, b: Floats, axis: Floats) -> float:
    """deg about an axis from a to b, (F, 3) each; the mean of the frames that have all."""
    z = unit(axis)
    a, b = perpendicular(a, z), perpendicular(b, z)
    deg = np.degrees(np.arctan2((np.cross(a, b) * z).sum(-1), (a * b).sum(-1)))
    known = np.isfinite(deg)
    return float(deg[known].mean()) if known.any() else 0.0


def _apex(kax: Floats, kd1: Floats, kd2: Floats, inner: Floats) -> Floats:
    """(F, 3) mm by (1), on the side of `inner`."""
    sides = [np.linalg.norm(a - b, axis=-1) for a, b in ((kax, kd1), (kax, kd2), (kd1, kd2))]
    rod = np.mean(sides, axis=0) / np.sqrt(2)
    centre = (kax + kd1 + kd2) / 3
    n = unit(np.cross(kd1 - kax, kd2 - kax))
    n = n * np.where(((inner - centre) * n).sum(-1, keepdims=True) < 0, -1.0, 1.0)
    return np.asarray(centre + n * rod[..., None] / np.sqrt(3))


def device_worn(static: Mapping[str, Floats], letter: str) -> bool:
    """Whether a standing trial wears a knee alignment device on the leg of that letter.

    Args:
        static: (F, 3) mm by the model's names. letter: L or R.
    """
    return all(_seen(static, letter + name) for name in DEVICE)


def _seen(static: Mapping[str, Floats], name: str) -> bool:
    return name in static and bool(np.isfinite(static[name]).any())
