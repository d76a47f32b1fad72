"""Wheels say what is in them: py3-none-PLATFORM with the compiled library, py3-none-any without."""

import os
import shutil
import subprocess
import sys
import zipfile
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def has_build_tools():
    try:
        return int(version("setuptools").split(".")[0]) >= 77
    except PackageNotFoundError:
        return False


READY = (ROOT / "setup.py").is_file() and has_build_tools()
pytestmark = [
    pytest.mark.nightly,
    pytest.mark.skipif(not READY, reason="needs a checkout, and setuptools 77 or later"),
]


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """A copy of what a wheel is built from, without what was compiled before."""
    folder = tmp_path_factory.mktemp("checkout")
    shutil.copytree(ROOT / "src", folder / "src", ignore=shutil.ignore_patterns("*.so", "__pycache__", "*.egg-info"))
    for name in ("pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder)
    return folder


def wheel(checkout, folder, **environment):
    """The name of the wheel that is built, and the names of the files in it."""
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    done = subprocess.run(
        [*command, "--wheel-dir", folder, checkout], env=os.environ | environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    (path,) = Path(folder).glob("*.whl")
    return path.name, zipfile.ZipFile(path).namelist()


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_a_wheel_with_the_library_serves_every_python_of_a_platform(checkout, tmp_path):
    name, files = wheel(checkout, tmp_path)
    assert "-py3-none-" in name and not name.endswith("-any.whl")
    assert [file for file in files if "_native" in file] in (
        ["kinemark/native/_native.so"],
        ["kinemark/native/_native.dll"],
    )
    assert not [file for file in files if file.endswith((".c", ".h"))]


@pytest.mark.skipif(os.name == "nt", reason="the compiler is not chosen by CC")
def test_a_wheel_without_the_library_serves_every_platform(checkout, tmp_path):
    """Also where an earlier build left a library."""
    name, files = wheel(checkout, tmp_path, CC="/bin/false")
    assert name.endswith("-py3-none-any.whl")
    assert not [file for file in files if "_native" in file] and "kinemark/native/compiled_library.py" in files
