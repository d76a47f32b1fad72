"""Who was recorded, as a C3D file says it in its group SUBJECTS."""

from __future__ import annotations

from typing import Any

import numpy as np

from .document import C3D


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
