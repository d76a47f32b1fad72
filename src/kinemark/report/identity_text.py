"""Whose recording a page is about, and of which day, as it stands below the title."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def identity_text(identity: Mapping[str, Any] | None) -> str:
    """`Subject S01 · recorded 2026-05-03`, from the plain data of an `Identity`; it says what nobody stated."""
    stated = identity or {}
    who = f"Subject {stated['subject']}" if stated.get("subject") else "Subject not stated"
    if stated.get("date"):
        return f"{who} · recorded {stated['date']}"
    return f"{who} · file of {stated['file_date']}" if stated.get("file_date") else f"{who} · date not stated"
