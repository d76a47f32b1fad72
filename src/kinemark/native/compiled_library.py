"""The compiled library: where it is, whether it is used, and what its functions take.

It is compiled from the C sources beside this file when Kinemark is installed and a C compiler is there, and loaded with
ctypes, which lets other threads run meanwhile. It uses nothing of Python's C interface, so that one build serves every
version of Python.
"""

from __future__ import annotations

import ctypes
import os
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

VERSION = 6
"""Of the functions' meaning, as in library.c: a library left over from another version is not used; by definition."""

PLAIN = "KINEMARK_PLAIN"
"""Environment variable: where it is set and not empty, NumPy does the work."""

PATH = Path(__file__).with_name("_native.dll" if os.name == "nt" else "_native.so")
"""Where the library is; setup.py puts it there."""


class Pointer:
    """An argument that is an array of one dtype in C order; ctypes asks `from_param` to pass it."""

    def __init__(self, dtype: type[np.generic]) -> None:
        """Take the dtype of the arrays."""
        self._dtype = np.dtype(dtype)

    def from_param(self, array: NDArray[Any]) -> Any:
        """Where the array is in memory.

        Raises:
            TypeError: it is of another dtype, or not contiguous.
        """
        flags = array.flags
        if array.dtype != self._dtype or not flags.c_contiguous:
            raise TypeError(f"found an array of {array.dtype}, wanted {self._dtype} in C order")
        if flags.writeable and array.size:
            return ctypes.byref(ctypes.c_char.from_buffer(array))  # type: ignore[arg-type]  # a fifth of the time
        return ctypes.c_void_p(array.ctypes.data)


_SIZE, _REAL = ctypes.c_int64, ctypes.c_double
_FLOATS, _INTS, _BOOLS, _GREY8, _GREY16 = map(Pointer, (np.float64, np.int64, np.bool_, np.uint8, np.uint16))
_ROWS = Pointer(np.int32)
_DEPTHS = (8, _GREY8), (16, _GREY16)  # bits of a pixel, as in library.c

FUNCTIONS: dict[str, tuple[Any, ...]] = {
    **{f"find_runs_{bits}": (grey, *4 * [_SIZE], *3 * [_INTS]) for bits, grey in _DEPTHS},
    "group_runs": (_SIZE, *3 * [_INTS], *2 * [_SIZE], *4 * [_INTS]),
    **{f"sum_pixels_{bits}": (grey, *5 * [_SIZE], *5 * [_INTS], _FLOATS) for bits, grey in _DEPTHS},
    **{
        f"cut_pixels_{bits}": (grey, *5 * [_SIZE], *4 * [_INTS], *4 * [_SIZE], _GREY8, *3 * [_INTS], _FLOATS, _BOOLS)
        for bits, grey in _DEPTHS
    },
    **{f"peaks_{bits}": (grey, *5 * [_SIZE], *4 * [_INTS], _FLOATS) for bits, grey in _DEPTHS},
    **{f"sum_peaks_{bits}": (grey, *5 * [_SIZE], *4 * [_INTS], *5 * [_FLOATS]) for bits, grey in _DEPTHS},
    "predict": (_SIZE, _REAL, *5 * [_FLOATS]),
    "update": (_SIZE, *6 * [_FLOATS]),
    "project": (*2 * [_SIZE], *6 * [_FLOATS]),
    "information": (*3 * [_SIZE], *2 * [_FLOATS], _INTS, *4 * [_FLOATS]),
    "candidates": (
        *3 * [_SIZE], _ROWS, _INTS, *2 * [_FLOATS], _BOOLS,
        _SIZE, _INTS, *3 * [_FLOATS], _REAL, _SIZE, *2 * [_INTS], *2 * [_FLOATS],
    ),
    "cluster_pixels": (*4 * [_SIZE], *2 * [_FLOATS], _BOOLS, *3 * [_FLOATS]),
    "fit_shapes": (*5 * [_SIZE], *15 * [_FLOATS]),
    "light_sides": (*4 * [_SIZE], *12 * [_FLOATS]),
    "intersect": (*4 * [_SIZE], *3 * [_FLOATS], *2 * [_INTS], *3 * [_FLOATS]),
}  # fmt: skip
"""The arguments of each C function."""

_RETURN_NOTHING = {"predict", "update", "project", "cluster_pixels"}


class Status(NamedTuple):
    """Which path runs.

    Attributes:
        path: the compiled library; None where NumPy does its work.
        version: of the library's functions.
        reason: why NumPy does the work; empty where the library does.
    """

    path: Path | None
    version: int | None
    reason: str


def plain() -> bool:
    """Whether NumPy is to do the work whatever is there."""
    return bool(os.environ.get(PLAIN))


def library() -> Any:
    """The functions of the compiled library; None where it is absent or `PLAIN` is set, and NumPy does the work."""
    return None if plain() else _loaded()[0]


def status() -> Status:
    """Which path runs now, and why."""
    if plain():
        return Status(None, None, f"the environment variable {PLAIN} is set")
    functions, reason = _loaded()
    return Status(PATH, VERSION, "") if functions else Status(None, None, reason)


def opened(path: Path) -> ctypes.CDLL:
    """The functions of a compiled library, their arguments declared.

    Raises:
        OSError: it cannot be loaded, or was built from another version of the sources.
    """
    functions = ctypes.CDLL(str(path))
    if not hasattr(functions, "kinemark_native_version"):
        raise OSError(f"{path} is not Kinemark's")
    if (found := functions.kinemark_native_version()) != VERSION:
        raise OSError(f"{path} is of version {found}, wanted {VERSION}")
    for name, arguments in FUNCTIONS.items():
        function = getattr(functions, name)
        function.argtypes, function.restype = arguments, None if name in _RETURN_NOTHING else _SIZE
    return functions


@cache
def _loaded() -> tuple[ctypes.CDLL | None, str]:
    """The library, or the reason why there is none."""
    if not PATH.is_file():
        return None, f"{PATH} is absent: it was not compiled when Kinemark was installed"
    try:
        return opened(PATH), ""
    except OSError as error:
        return None, str(error)
