"""A subject's template as a file beside a session: `.template.h5`."""

from __future__ import annotations

from pathlib import Path

from ...data import KinemarkError
from ...io.records import load_any, save_any
from ...label.subject_template import SubjectTemplate

ENDING = ".template.h5"
"""Of a template's file."""


def is_template(path: Path | str) -> bool:
    """Whether a file is a template by its name."""
    return Path(path).name.lower().endswith(ENDING)


def save_template(path: Path | str, template: SubjectTemplate) -> None:
    """Write a subject's template; `load_template` gives back the same.

    Raises:
        KinemarkError: the name has another ending than `.template.h5`, or the file cannot be written.
    """
    if not is_template(path):
        raise KinemarkError(f"{path} has not the ending {ENDING} of a template. Name it {Path(path).stem}{ENDING}.")
    save_any(path, template)


def load_template(path: Path | str) -> SubjectTemplate:
    """Read a subject's template.

    Raises:
        KinemarkError: the file is absent, truncated, no template, of a later version, or contradicts itself.
    """
    found: SubjectTemplate = load_any(path, {"SubjectTemplate": SubjectTemplate})
    return found
