"""Phrases of the errors."""

from __future__ import annotations

from ...data.nearest_word import guess

__all__ = ["are", "guess"]


def are(keys: list[str]) -> str:
    """What there is, in words."""
    return ("is only " if len(keys) == 1 else "are ") + ", ".join(keys)
