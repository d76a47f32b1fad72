"""What the commands of problems print, and which edits an alternative stands for."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from ..data import KinemarkError
from ..data.edits import Edit
from ..data.problems import ASK_ABOVE, Problem, Problems


def problems_text(found: Problems, *, every: bool = False) -> str:
    """A paragraph for each, and how many errors are expected to be left."""
    shown = found.items if every else found.asked
    lines = [line for one in shown for line in _lines(one)]
    rest, asked = len(found.items) - len(found.asked), len(found.asked)
    more = (
        f"; {rest} more {'is' if rest == 1 else 'are'} less likely than {100 * ASK_ABOVE:.0f} % (--every)"
        if rest
        else ""
    )
    left = f"{found.errors_left:.1f} errors are expected to be left" + (" after these" if asked else "")
    lines.append(f"{_count(asked, 'problem') if asked else 'Nothing'} to look at{more}; {left}.")
    return "\n".join(lines)


def problems_figures(found: Problems) -> dict[str, Any]:
    """For a machine."""
    return {
        "head": found.head,
        "expected_errors": round(found.errors, 3),
        "errors_left": round(found.errors_left, 3),
        "problems": [_plain(asdict(one) | {"asked": one.asked}) for one in found.items],
    }


def chosen_edits(found: Problems, problem: str, alternative: int) -> tuple[Edit, ...]:
    """Of an alternative by its number, from 1.

    Raises:
        KinemarkError: there is no such problem or alternative, or nothing must be said for it.
    """
    try:
        one = found[problem]
    except KeyError as error:
        raise KinemarkError(f"There is no problem {problem}. List them: kinemark edits problems.") from error
    if not 1 <= alternative <= len(one.alternatives):
        raise KinemarkError(f"{problem} has {len(one.alternatives)} alternatives; give a number from 1.")
    edits = one.alternatives[alternative - 1].edits
    if not edits:
        raise KinemarkError(f"Nothing must be said to {one.alternatives[alternative - 1].words}.")
    return edits


def _lines(one: Problem) -> list[str]:
    """What it is, then its alternatives."""
    head = f"{one.id}  {100 * one.wrong:.0f} %  {one.words}; {_count(one.at_stake, 'sample')}"
    return [head, *(f"    {k}  {way.words}" for k, way in enumerate(one.alternatives, 1))]


def _count(n: int, one: str) -> str:
    """`1 sample`, `2 samples`; the report's own words take long to import."""
    return f"{n} {one if n == 1 else one + 's'}"


def _plain(value: Any) -> Any:
    """Without numbers that JSON does not know."""
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
