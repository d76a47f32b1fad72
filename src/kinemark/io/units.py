"""Lengths of files in mm: the one table that every format reads."""

from __future__ import annotations

SPELLINGS = {
    1.0: ("mm", "millimeter", "millimeters", "millimetre", "millimetres"),
    10.0: ("cm", "centimeter", "centimeters", "centimetre", "centimetres"),
    100.0: ("dm", "decimeter", "decimeters", "decimetre", "decimetres"),
    1000.0: ("m", "meter", "meters", "metre", "metres"),
    0.001: ("um", "µm", "micrometer", "micrometers", "micrometre", "micrometres"),
    25.4: ("in", "inch", "inches"),
    304.8: ("ft", "foot", "feet"),
}
MM = {name: mm for mm, names in SPELLINGS.items() for name in names}
"""mm in one unit, by its name in small letters."""
CALLERS = ("mm", "cm", "m", "in")
"""What a caller may say of a file that is silent."""
USUAL_UNITS = "mm, cm, m or in"
"""The same in messages."""


def mm_per(unit: object) -> float | None:
    """mm in one unit of length, however it is capitalised; None where it is no unit that is known."""
    return MM.get(unit.casefold()) if isinstance(unit, str) else None
