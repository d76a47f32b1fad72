"""`kinemark methods`, `schema` and `cite`: what there is."""

from __future__ import annotations

from typing import Literal

from ...data import KinemarkError
from ..output import Json, print_result


def methods(stage: str | None = None, *, json: Json = False) -> None:
    """List the methods of each stage with their parameters: default, unit, range and meaning.

    Args:
        stage: calibrate, detect, match, reconstruct, track, fill, digitise, angles or smooth; all where none is given.
    """
    from ...engine.settings import methods_figures, methods_text

    print_result(methods_figures(stage) if json else methods_text(stage))


def schema(what: Literal["session", "quality"] = "session") -> None:
    """Print the JSON schema of session.toml, for an editor that completes and checks it, or of quality.json.

    Args:
        what: of which file.
    """
    from ...engine.settings import session_schema
    from ...findings.schema import quality_schema

    print_result({"session": session_schema, "quality": quality_schema}[what]())


def cite(*words: str, bibtex: bool = False, json: Json = False) -> None:
    """List the works that the methods come from, to be cited by whoever uses them.

    Args:
        words: only works whose authors, year or title hold all of these.
        bibtex: write entries for LaTeX.
    """
    from ...engine.bibliography import as_bibtex, as_text, chosen

    found = chosen(words)
    if bibtex and json:
        raise KinemarkError("--bibtex and --json are two forms of one list. Ask for one.")
    print_result(found if json else as_bibtex(found) if bibtex else as_text(found))
