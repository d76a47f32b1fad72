"""What is known of a capture besides its numbers: date, subjects and whose each marker is, labels and comments.

SUBJECTS:NAMES is C3D's own place for the subject, POINT:Y_SCREEN for the axis of the world that goes up, which is read
where it is not z; its sign is that of the screen, which some programs count downwards. It is written where it is
known: a file of which nothing is known claims nothing. All else stands in KINEMARK:ABOUT, a row "name: text" each.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...data.trial import UP
from .document import C3D, with_parameters
from .parameter_tables import with_text
from .parameters import Parameter
from .provenance import GROUP

ABOUT = "ABOUT"
BETWEEN = ": "
SUBJECT = "subject"
OWN_PLACE = (SUBJECT, UP)
USUAL = "+Z"
"""The axis that goes up where a file says nothing else; by definition."""


def about_of(doc: C3D) -> dict[str, str]:
    """What a document says; subjects with commas between them."""
    subjects = ", ".join(name for name in doc.texts("SUBJECTS", "NAMES") if name)
    rows = (row.partition(BETWEEN) for row in doc.texts(GROUP, ABOUT))
    stated = {name: text for name, between, text in rows if between}
    up = _up_in(doc)
    axis = {UP: up} if up not in ("", USUAL) else {}
    return ({SUBJECT: subjects} if subjects else {}) | axis | stated


def subjects_in(about: Mapping[str, str]) -> tuple[str, ...]:
    """Names of the subjects, of which `about` has a text with commas between them."""
    return tuple(name for name in about.get(SUBJECT, "").split(", ") if name)


def with_about(doc: C3D, about: Mapping[str, str]) -> C3D:
    """The document that says this."""
    had = about_of(doc)
    if had == dict(about):
        return doc
    subject = about.get(SUBJECT, "")
    if subject != had.get(SUBJECT, ""):
        names = [subject] if subject else []
        parameters = [Parameter.whole("USED", len(names)), Parameter.text("NAMES", names)]
        doc = with_parameters(doc, "SUBJECTS", parameters)
    if (up := about.get(UP, USUAL if UP in had else "")) and up != _up_in(doc):
        right = "+Y" if up.endswith("X") else "+X"
        screen = [Parameter.text("X_SCREEN", right), Parameter.text("Y_SCREEN", up)]
        doc = with_parameters(doc, "POINT", screen)
    rows = [f"{name}{BETWEEN}{text}" for name, text in about.items() if name not in OWN_PLACE]
    return with_text(doc, GROUP, ABOUT, rows, [-1] * len(rows), doc.texts(GROUP, ABOUT))


def _up_in(doc: C3D) -> str:
    """The axis that the document says goes up, as "+Y"; "" where it says none."""
    letter = next(iter(doc.texts("POINT", "Y_SCREEN")), "").strip().upper()[-1:]
    return f"+{letter}" if letter in ("X", "Y", "Z") else ""


def subject_of(source: Any) -> str:
    """Names of the subjects, joined by commas; empty where the source of a trial is no C3D file or names nobody."""
    if not isinstance(source, C3D):
        return ""
    return ", ".join(dict.fromkeys(name.strip() for name in source.texts("SUBJECTS", "NAMES") if name.strip()))


def prefixes_of(source: Any) -> dict[str, str]:
    """Subject → what stands before the names of its markers, as SUBJECTS:LABEL_PREFIXES says it.

    Empty where the source of a trial is no C3D file, or USES_PREFIXES is 0 or absent.
    """
    if not isinstance(source, C3D) or not np.any(source.numbers("SUBJECTS", "USES_PREFIXES")):
        return {}
    names, prefixes = ([text.strip() for text in source.texts("SUBJECTS", key)] for key in ("NAMES", "LABEL_PREFIXES"))
    return {name: prefix for name, prefix in zip(names, prefixes, strict=False) if name and prefix}


def with_prefixes(doc: C3D, subjects: Sequence[str], markers: Sequence[str]) -> C3D:
    """The document that says which subject's each marker is, where names and a colon stand before those of markers.

    Args:
        doc: a document. subjects: their names. markers: such as `A:LKNE`; where none has a subject, nothing is said.
    """
    prefixes = [f"{name}:" for name in subjects]
    if not any(marker.startswith(tuple(prefixes)) for marker in markers):
        return doc
    if prefixes_of(doc) == dict(zip(subjects, prefixes, strict=True)):
        return doc
    texts = [Parameter.text("NAMES", list(subjects)), Parameter.text("LABEL_PREFIXES", prefixes)]
    whole = [Parameter.whole("USED", len(prefixes)), Parameter.whole("USES_PREFIXES", 1)]
    return with_parameters(doc, "SUBJECTS", [*whole, *texts])
