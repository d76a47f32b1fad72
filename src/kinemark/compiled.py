"""Parts that are compiled from C where there is a compiler when Kinemark is installed.

They are loaded with ctypes, which lets other threads run meanwhile. Python's own C interface is not needed, so that a
part is some 300 lines of C that know nothing of Python, and no other package need be installed. Each stage that has one
(`detect`, `follow`) does the same with NumPy where there is none, and tests hold one against the other.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Library = TypeVar("Library")

PLAIN = "KINEMARK_PLAIN"
"""Environment variable: where it is set and not empty, NumPy does the work."""


def plain() -> bool:
    """Whether NumPy is to do the work whatever is there."""
    return bool(os.environ.get(PLAIN))


def opened(path: Path, version: int) -> ctypes.CDLL:
    """A compiled part.

    Raises:
        OSError: it cannot be loaded, or was built from another version of the source.
    """
    kernel = ctypes.CDLL(str(path))
    if not hasattr(kernel, "kernel_version") or kernel.kernel_version() != version:
        raise OSError(f"{path} is of another version, wanted {version}")
    return kernel


def loaded(beside: str, library: Callable[[Path], Library]) -> Library | None:
    """The compiled part `_kernel` beside a module's file; None where there is none, or one of another machine."""
    for suffix in EXTENSION_SUFFIXES:
        path = Path(beside).with_name("_kernel" + suffix)
        if path.is_file():
            try:
                return library(path)
            except OSError:  # of another version too: as if there were none
                continue
    return None


def at(array: NDArray[np.generic]) -> ctypes.c_void_p:
    """Where an array lies; it must be in one piece."""
    return ctypes.c_void_p(array.ctypes.data)


def size(n: int) -> ctypes.c_int64:
    """A number of things."""
    return ctypes.c_int64(n)


def floats(*arrays: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Arrays of double precision, each in one piece."""
    return [np.ascontiguousarray(array, np.float64) for array in arrays]


def ints(*arrays: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Arrays of 64-bit integers, each in one piece."""
    return [np.ascontiguousarray(array, np.int64) for array in arrays]
