"""Pages from templates: every value is escaped where it is written, and a name that is missing is an error."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ..io.files import replacing
from .drawing import Figure
from .words import TAGS, advice_of, headline_of, sentences_of, text_of


@cache
def environment() -> Environment:
    """The templates of this package, with what they call."""
    found = Environment(
        loader=PackageLoader(__package__),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.filters |= {
        "headline": headline_of,
        "sentences": sentences_of,
        "text": text_of,
        "advice": advice_of,
        "tag": TAGS.__getitem__,
    }
    found.policies["json.dumps_function"] = _as_json
    found.policies["json.dumps_kwargs"] = {}
    return found


def render(template: str, **content: Any) -> Markup:
    """A template with its content, escaped.

    Pages extend `frame.html`, which asks for `heading`, `below` (a line under it), `nav` (place → name) and `library`
    (a `DrawingLibrary`, or None on a page without drawings that need one).
    """
    return Markup(environment().get_template(template).render(content))


def write_text(path: Path | str, text: str) -> None:
    """Write a page, whole or not at all.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")


def _as_json(value: Any) -> str:
    """A figure as Plotly reads it, or plain data; the filter `tojson` makes it harmless inside a script."""
    if isinstance(value, Figure):
        return value.to_json()
    return json.dumps(value, separators=(",", ":"))
