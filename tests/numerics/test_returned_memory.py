"""Memory that is no longer used goes back to the system."""

from __future__ import annotations

import ctypes
import os
import platform
from pathlib import Path

import numpy as np
import pytest

from kinemark.numerics import returned_memory
from kinemark.numerics.returned_memory import return_memory

PIECES, PIECE = 4000, 64_000  # arrays, bytes each: 256 MB in pieces that the C library keeps when they are freed


def resident() -> int:
    """Bytes of this process in memory."""
    return int(Path("/proc/self/statm").read_text("ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only glibc can give memory back from amid its own")
def test_freed_pieces_go_back_though_others_stay() -> None:
    pieces = [np.ones(PIECE, np.uint8) for _ in range(PIECES)]
    stay = pieces[::50]
    del pieces
    before = resident()
    return_memory()
    assert before - resident() > 0.8 * PIECES * PIECE
    assert all(one.all() for one in stay)


def test_nothing_happens_where_the_library_cannot(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> object:
        raise OSError("no such library")

    returned_memory._functions.cache_clear()
    monkeypatch.setattr(ctypes, "CDLL", none)
    return_memory()
    returned_memory._functions.cache_clear()
