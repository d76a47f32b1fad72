"""Memory that is no longer used, given back to the system."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

WORTH = 64 << 20
"""Bytes below which nothing is given back, as they would soon be asked for again; chosen for speed: trackers ask some
hundred times a second. With 16 MB that of 1600 frames of six cameras took a tenth more, to clear 400 MB of fresh pages.
"""


def return_memory() -> None:
    """Give back what the C library keeps of freed arrays, where it can (glibc) and that is much; nothing elsewhere.

    It keeps arrays of up to 32 MB for the next ones, in pieces that are mostly too small for them: a stage that has
    freed many of them leaves up to a fifth of all memory unused. Ten milliseconds a gigabyte.
    """
    trim, kept = _functions()
    if trim is not None and kept() >= WORTH:
        trim(0)


class _Figures(ctypes.Structure):
    """`struct mallinfo2` of glibc; `fordblks` are the bytes that it keeps."""

    _fields_ = [
        *((f"other{k}", ctypes.c_size_t) for k in range(8)),
        ("fordblks", ctypes.c_size_t),
        ("keepcost", ctypes.c_size_t),
    ]


@cache
def _functions() -> tuple[Any, Callable[[], int]]:
    """`malloc_trim` of the C library, None where it has none, and how many bytes it keeps, many where it cannot say."""
    try:
        library = ctypes.CDLL(None)
        trim = library.malloc_trim
    except (OSError, AttributeError, TypeError):  # another system or C library
        return None, lambda: 0
    try:
        figures = library.mallinfo2
    except AttributeError:  # glibc before 2.33
        return trim, lambda: WORTH
    figures.restype = _Figures
    return trim, lambda: int(figures().fordblks)
