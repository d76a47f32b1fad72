"""Memory that is no longer used goes back to the system."""

from __future__ import annotations

import ctypes
import os
import platform
import subprocess
import sys
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


KEEPS = f"""
import numpy as np
from kinemark.numerics.returned_memory import return_memory
from numerics.test_returned_memory import resident
pieces = [np.ones({PIECE}, np.uint8) for _ in range(600)]
last = np.ones({PIECE}, np.uint8)
del pieces
before = resident()
return_memory()
print(before - resident())
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only glibc can give memory back from amid its own")
def test_what_is_soon_asked_for_again_is_kept() -> None:
    """38 MB were given back each time, and cleared by the system when they were asked for again."""
    own = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, [*sys.path, Path(__file__).parents[1]]))}
    told = subprocess.run([sys.executable, "-c", KEEPS], env=own, check=True, capture_output=True, text=True)
    assert int(told.stdout) < PIECE


def test_nothing_happens_where_the_library_cannot(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> object:
        raise OSError("no such library")

    returned_memory._functions.cache_clear()
    monkeypatch.setattr(ctypes, "CDLL", none)
    return_memory()
    returned_memory._functions.cache_clear()
