"""Sentences with places for the values of a finding, each written in its declared unit.

A place is the name of a value, `{limit_mm}`, or one of `{cameras}`, `{markers}` ("camera a", "cameras a, b"; with a
capital letter at the beginning of a sentence), `{camera_names}`, `{marker_names}`, `{first_frame}`, `{last_frame}` and
`{frames}`. After a colon stands how it is written:

    {residual_px:3}          with three decimals
    {residual_px:.2g}        as Python formats it
    {gaps:gap|gaps}          one of two words, by the number or the length of a list
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from string import Formatter
from typing import Any, NamedTuple

from ...data import KINDS, Finding
from ...data.finding import Unit
from ...data.nearest_word import some_names
from ..formatting import LEAST, millimetres, number, percent, some, span_of_frames

Text = str | Callable[[Finding], str]

MOST_NAMED = 6
"""Names of a list; the others are counted; chosen."""
SUFFIX: dict[Unit, str] = {
    "px": "\u00a0px",
    "mm": "\u00a0mm",
    "m": "\u00a0m",
    "deg": "°",
    "s": "\u00a0s",
    "ms": "\u00a0ms",
    "Hz": "\u00a0Hz",
    "m/s": "\u00a0m/s",
    "kg": "\u00a0kg",
    "N": "\u00a0N",
}
DECIMALS: dict[Unit, int] = {"px": 2, "s": 2, "ms": 1, "frames": 2, "m/s": 0, "ratio": 1, "level": 0, "m": 2}
"""Where nothing else is said."""


class Words(NamedTuple):
    """What a kind of finding says, and what to do about it; a sentence with places, or a function that writes it."""

    text: Text
    advice: Text = ""

    def of(self, found: Finding) -> tuple[str, str]:
        """Text and advice for one finding."""
        return _written(self.text, found), _written(self.advice, found)


def _written(text: Text, found: Finding) -> str:
    return fill(text, found) if isinstance(text, str) else text(found)


def fill(template: str, found: Finding) -> str:
    """The template with the values of a finding.

    Raises:
        KeyError: it has a place for a value that the kind does not declare.
    """
    return _Places(found).vformat(template, (), {})


class _Places(Formatter):
    """Fills places from a finding."""

    def __init__(self, found: Finding) -> None:
        self.found = found

    def get_field(self, field_name: str, args: Sequence[Any], kwargs: Any) -> tuple[Any, str]:
        """The name itself: `format_field` looks the value up, since it needs the unit as well."""
        return field_name, field_name

    def format_field(self, value: Any, format_spec: str) -> str:
        """The value of that name, as the specification says."""
        name, found = str(value), self.found
        if "|" in format_spec:
            one, many = format_spec.split("|")
            return one if _is_one(_raw(name, found)) else many
        if (text := _about(name, found)) is not None:
            return text
        return shown(found.values[name], KINDS[found.kind].values[name], format_spec)


def _raw(name: str, found: Finding) -> Any:
    return getattr(found, name) if name in ("cameras", "markers", "frames") else found.values[name]


def _is_one(value: Any) -> bool:
    return (len(value) if isinstance(value, tuple) else value) == 1


def _about(name: str, found: Finding) -> str | None:
    """What the finding is about, where a place asks for that."""
    match name:
        case "cameras" | "markers":
            return some(name.removesuffix("s"), getattr(found, name), MOST_NAMED)
        case "Cameras" | "Markers":
            return some(name.removesuffix("s"), getattr(found, name.lower()), MOST_NAMED)
        case "camera_names":
            return listed(found.cameras)
        case "marker_names":
            return listed(found.markers)
        case "first_frame":
            return number(found.frames[0][0]) if found.frames else "–"
        case "last_frame":
            return number(found.frames[-1][1]) if found.frames else "–"
        case "frames":
            if len(found.frames) == 1:
                return span_of_frames(*found.frames[0])
            return some("frame", [f"{a}–{b}" if b > a else f"{a}" for a, b in found.frames], 4)
    return None


def listed(names: Sequence[Any], most: int = MOST_NAMED) -> str:
    """`a, b and 3 more`."""
    return some_names(names, most) if names else ""


def shown(value: Any, unit: Unit, spec: str = "") -> str:
    """A value in its unit; a list as its items and the unit once; a dash for what is not known."""
    if isinstance(value, tuple):
        if unit == "text":
            return listed([item if item is not None else "–" for item in value])
        bare = [_number(item, unit, spec) for item in value]
        return listed(bare) + SUFFIX.get(unit, "")
    if value is None or unit in ("text", "flag"):
        return "–" if value is None else str(value)
    if unit == "mm" and not spec:
        return millimetres(value)
    if unit == "share":
        return percent(value)
    return _number(value, unit, spec) + SUFFIX.get(unit, "")


def _number(value: Any, unit: Unit, spec: str) -> str:
    if value is None:
        return "–"
    if spec.startswith((".", "+")):
        return f"{value:{spec}}"
    if spec:
        return number(value, int(spec))
    if unit == "parts":
        return number(float(f"{value:.2g}"), 0)
    if unit == "deg":
        if 0 < abs(value) < LEAST:
            return f"< {LEAST}"
        return f"{value:.2g}" if abs(value) < 1 else number(value, 1)
    if unit == "mm":
        return number(value, max(0, 1 - math.floor(math.log10(abs(value)))) if 0 < abs(value) < 10 else 0)
    return number(value, DECIMALS.get(unit))
