"""What a mistyped word may have meant, and what there is instead."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from typing import Any

MOST_LISTED = 12
"""Names in an error; chosen, two lines: a file can have hundreds."""


def guess(word: str, known: Iterable[str]) -> str:
    """A suggestion for a mistyped word, in brackets; empty where none of the known ones is near."""
    near = difflib.get_close_matches(word, list(known), 1)
    return f" (did you mean {near[0]!r}?)" if near else ""


def some_names(names: Sequence[Any], most: int = MOST_LISTED) -> str:
    """`a, b and 3 more`; `none` where there are none."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(map(str, names[:most])) + more or "none"


def are(words: Sequence[str]) -> str:
    """What there is, after "there": "is only a", "are a, b"."""
    return ("is only " if len(words) == 1 else "are ") + ", ".join(words)
