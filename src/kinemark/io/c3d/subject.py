"""Who was recorded, as a C3D file says it in its group SUBJECTS."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .document import C3D, with_parameters
from .parameters import Parameter


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
