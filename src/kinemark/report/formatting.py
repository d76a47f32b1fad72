"""Numbers, lists and who was recorded, as a reader wants them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any


def number(value: float | None, decimals: int | None = None) -> str:
    """With that many decimals, or all it has up to six digits; hard spaces between thousands; a dash if unknown."""
    if value is None:
        return "–"
    text = f"{value:,.6g}" if decimals is None else f"{value:,.{decimals}f}"
    negative_zero = not text.strip("-0.")
    return (text.removeprefix("-") if negative_zero else text).replace(",", "\u00a0")


def signed(value: float, decimals: int) -> str:
    """A difference with its sign; one that is rounded to nothing has no minus."""
    return f"{value:+z.{decimals}f}"


def percent(share: float | None) -> str:
    """A share in per cent with one decimal, never rounded to nothing or to all; a dash for what is unknown."""
    if share is None:
        return "–"
    if share in (0, 1):
        return f"{100 * share:.0f}\u00a0%"
    bound = "< " if share < 0.001 else "> " if share > 0.999 else ""
    return f"{bound}{100 * min(max(share, 0.001), 0.999):.1f}\u00a0%"


def measure(value: float | None, decimals: int, unit: str) -> str:
    """A number with its unit, or a dash."""
    return "–" if value is None else f"{number(value, decimals)}\u00a0{unit}"


LEAST = 0.001
"""Of lengths, mm, and angles, deg: what is less is said to be less; chosen, as no camera resolves it."""


def millimetres(value: float | None) -> str:
    """A length with two digits that count, below 10 mm; a dash if unknown."""
    if value is None or value == 0:
        return measure(value, 2, "mm")
    if abs(value) < LEAST:
        return f"< {measure(LEAST, 3, 'mm')}"
    return measure(value, max(0, 1 - math.floor(math.log10(abs(value)))) if abs(value) < 10 else 0, "mm")


def count(n: int, one: str, many: str = "") -> str:
    """`1 marker`, `2 markers`."""
    return f"{number(n)} {one if n == 1 else many or one + 's'}"


def some(kind: str, names: Sequence[str], most: int = 6) -> str:
    """`marker a`, `markers a, b and 3 more`."""
    listed = ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
    return f"{kind if len(names) == 1 else kind + 's'} {listed}"


def span_of_frames(first: int, last: int) -> str:
    """`frame 5`, `frames 5–9`."""
    return f"frame {first}" if first == last else f"frames {first}–{last}"


def degrees(value: float | None, decimals: int = 2) -> str:
    """An angle with its sign, or a dash."""
    return "–" if value is None else f"{number(value, decimals)}°"


def identity_text(identity: Mapping[str, Any] | None) -> str:
    """`Subject S01 · recorded 2026-05-03`, from the plain data of an `Identity`; it says what nobody stated."""
    stated = identity or {}
    who = f"Subject {stated['subject']}" if stated.get("subject") else "Subject not stated"
    if stated.get("date"):
        return f"{who} · recorded {stated['date']}"
    return f"{who} · file of {stated['file_date']}" if stated.get("file_date") else f"{who} · date not stated"
