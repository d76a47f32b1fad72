"""Phrases of the errors."""

from __future__ import annotations

import difflib


def guess(key: str, keys: list[str]) -> str:
    """A suggestion for a mistyped key."""
    near = difflib.get_close_matches(key, keys, 1)
    return f" (did you mean {near[0]!r}?)" if near else ""


def are(keys: list[str]) -> str:
    """What there is, in words."""
    return ("is only " if len(keys) == 1 else "are ") + ", ".join(keys)
