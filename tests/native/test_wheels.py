"""Wheels say what is in them: py3-none-PLATFORM with the compiled library, py3-none-any without."""

import os
import re
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.request
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


PAGE = ROOT / "src" / "kinemark" / "apps" / "studio" / "page" / "index.html"
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
    name, files = wheel(checkout, tmp_path, CC="/bin/false", KINEMARK_SKIP_UI="1")
    assert name.endswith("-py3-none-any.whl")
    assert not [file for file in files if "/studio/page/" in file]
    assert not [file for file in files if "_native" in file] and "kinemark/native/compiled_library.py" in files


def first_answer(browser, address):
    """Of a server that says its address a little before it listens."""
    for _ in range(600):
        try:
            with browser.open(address) as answer:
                return answer.read()
        except urllib.error.URLError as error:
            assert isinstance(error.reason, ConnectionError), error
            time.sleep(0.1)
    raise AssertionError("nobody listens")


@pytest.mark.skipif(not PAGE.is_file(), reason="the page of the studio is not built: python3 dev.py studio")
def test_the_studio_of_a_wheel_works_outside_the_checkout(checkout, tmp_path):
    """The page is in the wheel as it was built, and its server gives all that the page names."""
    pytest.importorskip("uvicorn", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")
    name, _ = wheel(checkout, tmp_path / "dist", CC="/bin/false")
    with zipfile.ZipFile(tmp_path / "dist" / name) as archive:
        archive.extractall(tmp_path / "installed")
    there = tmp_path / "empty"
    there.mkdir()
    served = subprocess.Popen(
        [sys.executable, "-m", "kinemark", "studio", there, "--no-browser"], cwd=there, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        env=os.environ | {"PYTHONPATH": str(tmp_path / "installed"), "PYTHONUNBUFFERED": "1"},
    )  # fmt: skip
    try:
        said = served.stdout.readline()
        (address,) = re.findall(r"http://\S+", said) or [said]
        browser = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
        html = first_answer(browser, address)
        assert html == PAGE.read_bytes()
        for path in re.findall(r'(?:src|href)="(/[^"]+)"', html.decode()):
            with browser.open(address.partition("/?")[0] + path) as answer:
                assert answer.read() == (PAGE.parent / path[1:]).read_bytes(), path
    finally:
        served.kill()
        served.communicate()
