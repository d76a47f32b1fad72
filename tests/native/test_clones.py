"""Versions of a function for different processors give the same to the last bit."""

import platform
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from kinemark import native
from kinemark.native import compiled_library
from support.native_calls import CALLS, outcome

SOURCES = sorted(Path(native.__file__).parent.glob("*.c"))
COMPILER = shutil.which("gcc")
HERE = SOURCES and COMPILER and sys.platform == "linux" and platform.machine() == "x86_64"


@pytest.mark.skipif(
    not HERE or native.library() is None, reason="needs Linux on x86-64, gcc, the C sources, the library"
)
def test_fits_do_not_depend_on_the_processor(monkeypatch, tmp_path):
    """The library as it is, and one without versions for newer processors in which pixels are worked on one by one."""
    path = tmp_path / "library.so"
    subprocess.run([COMPILER, "-O0", "-fPIC", "-shared", "-DCLONES=", *SOURCES, "-o", path, "-lm"], check=True)
    plainer = compiled_library.opened(path)
    calls = [CALLS[name](np.random.default_rng(k)) for name in ("fit_shapes", "light_sides") for k in range(40)]
    found = [outcome(call) for call in calls]
    monkeypatch.setattr(compiled_library, "_loaded", lambda: (plainer, ""))
    for call, expected in zip(calls, found, strict=True):
        for one, other in zip(outcome(call), expected, strict=True):
            np.testing.assert_array_equal(one, other)
