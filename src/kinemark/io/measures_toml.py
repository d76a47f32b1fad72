"""A subject's measures as TOML.

mass_kg = 61.5, height_mm = 1720, asis_mm = 240, marker_diameter_mm = 14, head_offset_deg = 0     all may be absent
[left]   leg_mm = 880, knee_mm = 102, ankle_mm = 68; trochanter_mm, thigh_wand_deg, shank_wand_deg, torsion_deg,
         sole_mm, plantar_offset_deg, rotation_offset_deg; hip_mm = [x, y, z], hip_sd_mm = [x, y, z] may be absent
[right]  the same
[left_arm]  shoulder_mm = 45, elbow_mm = 80, wrist_mm = 55, hand_mm = 28                           may be absent
[right_arm] the same
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from ..data import KinemarkError
from ..data.subject_measures import ArmMeasures, LegMeasures, SubjectMeasures
from .number_text import read_text
from .toml_text import check_keys, toml_table

OF_SUBJECT = ("mass_kg", "height_mm", "asis_mm", "marker_diameter_mm", "head_offset_deg")
ARMS = ("left_arm", "right_arm")
OF_ARM = tuple(field.name for field in fields(ArmMeasures))
PLACES = ("hip_mm", "hip_sd_mm")
"""Of a leg, three numbers each."""
OF_LEG = tuple(field.name for field in fields(LegMeasures) if field.name != "hip_shift_mm")


def read_measures(path: Path | str) -> SubjectMeasures:
    """The measures that a file holds.

    Raises:
        KinemarkError: the file is absent or no TOML, a key is unknown, missing or no number, or no person is so.
    """
    if not Path(path).is_file():
        raise KinemarkError(
            f"{path} is not a file. Measures are read from a TOML file: mass_kg = 61.5, then [left] and [right], each "
            "with leg_mm = 880, knee_mm = 102 and ankle_mm = 68, of the subject."
        )
    table = toml_table(read_text(path), str(path))
    try:
        return measures_of_table(table)
    except KinemarkError as error:
        raise KinemarkError(f"{path}: {error}") from None


def measures_of_table(table: Mapping[str, Any]) -> SubjectMeasures:
    """The measures of a table, as of a file's or of `[gait.measures]` in a session.

    Raises:
        KinemarkError: a key is unknown, missing or no number, or no person is so.
    """
    _check("the file of measures", table, (*OF_SUBJECT, "left", "right", *ARMS), ("left", "right"))
    parts: dict[str, Any] = {side: _leg(side, table[side]) for side in ("left", "right")}
    parts |= {name: _arm(name, table[name]) for name in ARMS if name in table}
    parts |= {name: _number(name, table[name]) for name in OF_SUBJECT if name in table}
    return SubjectMeasures(**parts)


def _leg(side: str, table: Any) -> LegMeasures:
    if not isinstance(table, Mapping):
        raise KinemarkError(f"{side} is {table!r}, wanted a table [{side}] with leg_mm, knee_mm and ankle_mm.")
    _check(f"[{side}]", table, OF_LEG, ("leg_mm", "knee_mm", "ankle_mm"))
    numbers: dict[str, Any] = {
        name: (_place if name in PLACES else _number)(f"{side}.{name}", value) for name, value in table.items()
    }
    return LegMeasures(**numbers)


def _arm(name: str, table: Any) -> ArmMeasures:
    if not isinstance(table, Mapping):
        raise KinemarkError(f"{name} is {table!r}, wanted a table [{name}] with {', '.join(OF_ARM)}.")
    _check(f"[{name}]", table, OF_ARM, OF_ARM)
    return ArmMeasures(**{key: _number(f"{name}.{key}", value) for key, value in table.items()})


def _check(where: str, table: Mapping[str, Any], known: tuple[str, ...], needed: tuple[str, ...]) -> None:
    try:
        check_keys(where, table, known)
    except ValueError as error:
        raise KinemarkError(f"{error}.") from None
    if absent := [key for key in needed if key not in table]:
        raise KinemarkError(f"{where} lacks {', '.join(absent)}. Measure and add it, in millimetres.")


def _place(name: str, value: Any) -> tuple[float, float, float]:
    if not isinstance(value, list) or len(value) != 3:
        raise KinemarkError(f"{name} is {value!r}, wanted three numbers: forward, left and up, in millimetres.")
    x, y, z = (_number(name, part) for part in value)
    return x, y, z


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise KinemarkError(f"{name} is {value!r}, wanted a number.")
    return float(value)
