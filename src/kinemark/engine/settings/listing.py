"""All methods and their parameters: as text, as data, and as the tables of the documentation."""

from __future__ import annotations

import json
from collections.abc import Iterable
from textwrap import wrap
from typing import Any

from ...data import KinemarkError
from ...data.method import Declaration, Parameter, Stage
from ...data.nearest_word import are, guess
from ...data.parameter import ONE
from .method_tables import COMMON, STAGES

WIDTH = 118
"""Of a line on the terminal, characters; chosen."""

LONG = 40
"""Characters above which only the number of a list's elements is shown; chosen."""


def stages(stage: str | None = None) -> list[Stage]:
    """One stage by its name, or all.

    Raises:
        KinemarkError: there is no such stage.
    """
    if stage is not None and stage not in STAGES:
        raise KinemarkError(f"{stage!r} is no stage{guess(stage, list(STAGES))}; there {are(list(STAGES))}.")
    return [one for name, one in STAGES.items() if stage in (None, name)]


def methods_figures(stage: str | None = None) -> dict[str, Any]:
    """stage → its meaning, default, parameters that all its methods share, and methods with all there is to say.

    Raises:
        KinemarkError: there is no such stage.
    """
    return {one.name: _stage_figures(one) for one in stages(stage)}


def _stage_figures(stage: Stage) -> dict[str, Any]:
    return {
        "meaning": stage.meaning,
        "default": stage.default,
        "parameters": {p.name: _figures(p) for p in COMMON.get(stage.name, ())},
        "methods": {name: _method_figures(declared) for name, declared in stage.items()},
    }


def _method_figures(declared: Declaration) -> dict[str, Any]:
    return {
        "summary": declared.summary,
        "source": declared.source,
        "class": f"{declared.kind.__module__}.{declared.kind.__qualname__}",
        **({"ways": list(declared.ways)} if declared.ways else {}),
        "parameters": {p.name: _figures(p) for p in declared.stateable},
    }


def _figures(p: Parameter) -> dict[str, Any]:
    """All of a parameter; a bound that is infinite is not there."""
    bounds = {key: value for key, value in p.range._asdict().items() if value not in (None, float("inf"))}
    return {
        "kind": p.kind,
        "default": p.default,
        **({"required": True} if p.required else {}),
        **({"optional": True} if p.optional else {}),
        "unit": "" if p.unit == ONE else p.unit,
        **bounds,
        **({"choices": list(p.choices)} if p.choices else {}),
        "wanted": p.wanted(),
        "meaning": p.meaning,
    }


def methods_text(stage: str | None = None) -> str:
    """The same for reading: a line a parameter, with default, unit, range and meaning.

    Raises:
        KinemarkError: there is no such stage.
    """
    head = "# of each parameter: name, default, unit, range, meaning"
    return "\n\n".join([head, *(_stage_text(one) for one in stages(stage))])


def _stage_text(stage: Stage) -> str:
    lines = [f"[{stage.name}]  {stage.meaning}"]
    if common := COMMON.get(stage.name):
        lines += ["", "  with every method", *_rows(common)]
    for name, declared in stage.items():
        summary = declared.summary + (f" ({declared.source})" if declared.source else "")
        lines += ["", f'  method = "{name}"{_when(stage, declared)}']
        lines += wrap(summary, WIDTH - 4, initial_indent="    ", subsequent_indent="    ")
        lines += _rows(declared.stateable)
    return "\n".join(lines)


def _when(stage: Stage, declared: Declaration) -> str:
    """When a method is taken that is not named, or may be named."""
    if declared.ways:
        return f"  (of a calibration by {' or '.join(declared.ways)})"
    return "  (default)" if declared.name == stage.default else ""


def _rows(parameters: Iterable[Parameter]) -> list[str]:
    """Parameters in columns; meanings go on below themselves."""
    columns = [(p.name, default_text(p), "" if p.unit == ONE else p.unit, range_text(p), p.meaning) for p in parameters]
    if not columns:
        return []
    widths = [max(len(row[k]) for row in columns) for k in range(4)]
    lines = []
    for *cells, meaning in columns:
        start = "      " + "  ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True)) + "  "
        room = max(WIDTH - len(start), 40)
        first, *rest = wrap(meaning, room)
        lines += [start + first, *(" " * len(start) + line for line in rest)]
    return lines


def default_text(p: Parameter) -> str:
    """The default as a session file has it; "none" where it may be left out, and "must be given"."""
    if p.required:
        return "must be given"
    text = "none" if p.default is None else json.dumps(p.default, ensure_ascii=False)
    return text if len(text) <= LONG else f"list of {len(p.default)}"


def range_text(p: Parameter) -> str:
    """What a parameter may be, in few words; its unit stands beside."""
    if p.choices:
        return ", ".join(p.choices)
    if p.kind == "list":
        return f"list{', each ' if p.range.text() else ''}{p.range.text()}"
    return {"true or false": "true, false", "text": "text"}.get(p.kind, p.range.text() or "any")


def methods_table_markdown(stage: str | None = None) -> str:
    """The same as pages of the documentation have it: a heading a method and a table of its parameters.

    Raises:
        KinemarkError: there is no such stage.
    """
    parts = []
    for one in stages(stage):
        parts.append(f"## {one.name}\n\n{_sentence(one.meaning)}")
        if common := COMMON.get(one.name):
            parts.append(f"With every method:\n\n{_table(common)}")
        for name, declared in one.items():
            source = f" Source: {declared.source}." if declared.source else ""
            parts.append(f"### `{name}`{_when(one, declared)}\n\n{_sentence(declared.summary)}{source}")
            parts.append(_table(declared.stateable) if declared.stateable else "It has no parameters.")
    return "\n\n".join(parts) + "\n"


def _table(parameters: Iterable[Parameter]) -> str:
    rows = [
        (f"`{p.name}`", f"`{default_text(p)}`", "" if p.unit == ONE else p.unit, range_text(p), p.meaning)
        for p in parameters
    ]
    head = ["| parameter | default | unit | range | meaning |", "| --- | --- | --- | --- | --- |"]
    return "\n".join([*head, *("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows)])


def _sentence(text: str) -> str:
    """With a capital letter and a full stop."""
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "!", "?")) else ".")
