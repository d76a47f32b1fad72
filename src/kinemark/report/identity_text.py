"""Whose recording a page is about, and of which day, as it stands below the title."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def identity_text(identity: Mapping[str, Any] | None) -> str:
    """`Subject S01 · recorded 2026-05-03`, from the plain data of an `Identity`; it says what nobody stated."""
    told = identity or {}
    who = f"Subject {told['subject']}" if told.get("subject") else "Subject not stated"
    if told.get("date"):
        return f"{who} · recorded {told['date']}"
    return f"{who} · file of {told['file_date']}" if told.get("file_date") else f"{who} · date not stated"
