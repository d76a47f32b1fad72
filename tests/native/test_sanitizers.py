"""The C sources compiled with sanitizers: no access beyond an array, nothing undefined, whatever is passed."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from kinemark import native

SOURCES = sorted(Path(native.__file__).parent.glob("*.c"))
DRIVER = Path(__file__).parents[1] / "support" / "native_driver.py"
COMPILER = shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")
FLAGS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1", "-fPIC", "-shared")


@pytest.fixture(scope="module")
def sanitized(tmp_path_factory):
    """The library with sanitizers, and the environment in which Python can load it."""
    path = tmp_path_factory.mktemp("sanitized") / "library.so"
    if not SOURCES or COMPILER is None or sys.platform != "linux":
        pytest.skip("needs Linux, a C compiler, and a checkout with the C sources")
    built = subprocess.run([COMPILER, *FLAGS, *SOURCES, "-o", path], capture_output=True, text=True)
    if built.returncode:
        pytest.skip(f"the compiler has no sanitizers: {built.stderr[:200]}")
    runtime = subprocess.run([COMPILER, "-print-file-name=libasan.so"], capture_output=True, text=True).stdout.strip()
    if not Path(runtime).is_file():
        pytest.skip("the compiler's AddressSanitizer has no shared library to preload")
    wanted = {"LD_PRELOAD": runtime, "ASAN_OPTIONS": "detect_leaks=0", "PYTHONMALLOC": "malloc", native.PLAIN: ""}
    return path, os.environ | wanted


def driven(sanitized, task):
    path, environment = sanitized
    command = [sys.executable, DRIVER, path, task]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)


def test_no_fault_is_found(sanitized):
    done = driven(sanitized, "60")
    assert (done.returncode, done.stdout) == (0, "done\n"), done.stderr


def test_a_fault_would_be_found(sanitized):
    done = driven(sanitized, "beyond")
    assert done.returncode != 0 and "AddressSanitizer" in done.stderr
