"""What methods there are, and what can be said to each."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from ...data import KinemarkError
from .method_tables import METHODS, plain_parameters
from .suggestions import are, guess


def parameters(stage: str | None = None) -> dict[str, dict[str, dict[str, Any]]]:
    """stage → method → parameter → default, of one stage or of all, as a session file names them.

    Raises:
        KinemarkError: there is no such stage.
    """
    if stage is not None and stage not in METHODS:
        raise KinemarkError(f"{stage!r} is no stage{guess(stage, list(METHODS))}; there {are(list(METHODS))}.")
    chosen = METHODS if stage is None else {stage: METHODS[stage]}
    return {name: {method: _defaults(kind) for method, kind in kinds.items()} for name, kinds in chosen.items()}


def methods_text(found: dict[str, dict[str, dict[str, Any]]]) -> str:
    """The same for reading: a line a parameter, those that have no default left open."""
    lines = []
    for stage, methods in found.items():
        lines.append(f"[{stage}]")
        for method, defaults in methods.items():
            lines.append(f'  method = "{method}"')
            lines += [
                f"    {key:<18} {'none' if value is None else json.dumps(value)}" for key, value in defaults.items()
            ]
    return "\n".join(lines)


def _defaults(kind: type) -> dict[str, Any]:
    """The parameters of a method and their defaults."""
    values = asdict(kind())
    return {name: values[name] for name in plain_parameters(kind)}
