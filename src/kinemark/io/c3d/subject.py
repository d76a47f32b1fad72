"""Who was recorded, as a C3D file says it in its group SUBJECTS."""

from __future__ import annotations

from typing import Any

from .document import C3D


def subject_of(source: Any) -> str:
    """Names of the subjects, joined by commas; empty where the source of a trial is no C3D file or names nobody."""
    if not isinstance(source, C3D):
        return ""
    return ", ".join(dict.fromkeys(name.strip() for name in source.texts("SUBJECTS", "NAMES") if name.strip()))
