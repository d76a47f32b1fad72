"""Memory that is no longer used, given back to the system."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any


def return_memory() -> None:
    """Give back what the C library keeps of freed arrays, where it can (glibc); nothing elsewhere.

    It keeps arrays of up to 32 MB for the next ones, in pieces that are mostly too small for them: a stage that has
    freed many of them leaves up to a fifth of all memory unused. Ten milliseconds a gigabyte.
    """
    if (trim := _trim()) is not None:
        trim(0)


@cache
def _trim() -> Any:
    """`malloc_trim` of the C library; None where it has none."""
    try:
        return ctypes.CDLL(None).malloc_trim
    except (OSError, AttributeError, TypeError):  # another system or C library
        return None
