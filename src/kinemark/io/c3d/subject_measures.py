"""A subject's measures as Plug-in Gait writes them into a C3D file's group PROCESSING, mm and kg."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...data.subject_measures import ArmMeasures, LegMeasures, SubjectMeasures
from .document import C3D

GROUP = "PROCESSING"
RADIANS_BELOW = 0.8
"""Greatest offset of a foot that is read as radians: as degrees, all four of a subject are never so small; chosen."""
OFFSETS = ("StaticPlantFlex", "StaticRotOff")


def measures_of(source: Any) -> SubjectMeasures | None:
    """The measures that a trial's source holds; None where it is no C3D file or lacks a length of leg, knee or ankle.

    Raises:
        KinemarkError: a length is none that a person can have.
    """
    if not isinstance(source, C3D):
        return None
    needed = [f"{side}{name}" for side in "LR" for name in ("LegLength", "KneeWidth", "AnkleWidth")]
    if not all(_number(source, name) for name in needed):
        return None
    return SubjectMeasures(
        _leg(source, "L"),
        _leg(source, "R"),
        mass_kg=_number(source, "Bodymass") or None,
        height_mm=_number(source, "Height") or None,
        asis_mm=_number(source, "InterAsisDistance") or None,
        marker_diameter_mm=_number(source, "MarkerDiameter") or 14.0,
        left_arm=_arm(source, "L"),
        right_arm=_arm(source, "R"),
        head_offset_deg=_head(_number(source, "HeadOffset") or 0.0),
    )


def _leg(source: C3D, side: str) -> LegMeasures:
    plantar, rotation = (_offset(source, side + name) for name in OFFSETS)
    return LegMeasures(
        leg_mm=_number(source, f"{side}LegLength") or np.nan,
        knee_mm=_number(source, f"{side}KneeWidth") or np.nan,
        ankle_mm=_number(source, f"{side}AnkleWidth") or np.nan,
        trochanter_mm=_number(source, f"{side}AsisTrocanterDistance") or None,
        thigh_wand_deg=_number(source, f"{side}ThighRotation") or 0.0,
        shank_wand_deg=_number(source, f"{side}ShankRotation") or 0.0,
        torsion_deg=_number(source, f"{side}TibialTorsion") or 0.0,
        sole_mm=_number(source, f"{side}SoleDelta") or 0.0,
        plantar_offset_deg=plantar,
        rotation_offset_deg=rotation,
    )


def _arm(source: C3D, side: str) -> ArmMeasures | None:
    """None where a measure is absent."""
    lengths = [_number(source, side + name) for name in ("ShoulderOffset", "ElbowWidth", "WristWidth", "HandThickness")]
    known = [length for length in lengths if length]
    return ArmMeasures(*known) if len(known) == len(lengths) else None


def _head(stated: float) -> float:
    """deg; as offsets of the feet are."""
    return float(np.degrees(stated)) if abs(stated) < RADIANS_BELOW else stated


def _offset(source: C3D, name: str) -> float | None:
    """deg; Nexus writes radians, Workstation degrees."""
    all_of = [abs(_number(source, side + each) or 0.0) for side in "LR" for each in OFFSETS]
    stated = _number(source, name)
    return stated if stated is None or max(all_of) > RADIANS_BELOW else float(np.degrees(stated))


def _number(source: C3D, name: str) -> float | None:
    values = source.numbers(GROUP, name)
    return float(values[0]) if len(values) and np.isfinite(values[0]) else None
