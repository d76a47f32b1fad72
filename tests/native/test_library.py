"""Which path runs: the compiled library, or NumPy and why."""

import _ctypes
import ctypes
import re
from pathlib import Path

import pytest

from kinemark import native
from kinemark.native import compiled_library, pixel_sums, shape_fits, shape_images

SOURCES = Path(native.__file__).parent
needs_library = pytest.mark.skipif(native.library() is None, reason="Kinemark was installed without a compiler")
needs_sources = pytest.mark.skipif(not (SOURCES / "native.h").is_file(), reason="the C sources are not installed")


@pytest.fixture
def fresh(monkeypatch):
    """What is remembered of the library is forgotten before and after."""
    monkeypatch.setenv(native.PLAIN, "")
    compiled_library._loaded.cache_clear()
    yield monkeypatch
    monkeypatch.undo()
    compiled_library._loaded.cache_clear()


@needs_library
def test_the_environment_decides_at_any_time(monkeypatch):
    monkeypatch.setenv(native.PLAIN, "")
    before = native.library()
    monkeypatch.setenv(native.PLAIN, "1")
    assert native.library() is None
    assert native.status() == (None, None, "the environment variable KINEMARK_PLAIN is set")
    monkeypatch.setenv(native.PLAIN, "")
    assert native.library() is before is not None
    assert native.status() == (compiled_library.PATH, compiled_library.VERSION, "")


@needs_library
def test_a_library_of_another_version_is_not_used(fresh):
    fresh.setattr(compiled_library, "VERSION", -1)
    assert native.library() is None
    assert re.search(r"of version \d+, wanted -1", native.status().reason)


def test_a_library_of_another_kind_is_not_used(fresh):
    fresh.setattr(compiled_library, "PATH", Path(_ctypes.__file__ if hasattr(_ctypes, "__file__") else ctypes.__file__))
    assert native.library() is None and native.status().reason


def test_an_absent_library_is_told(fresh, tmp_path):
    fresh.setattr(compiled_library, "PATH", tmp_path / "none.so")
    assert native.library() is None and "none.so is absent" in native.status().reason


@needs_library
def test_arguments_of_another_dtype_never_reach_the_library():
    """What the functions check, ctypes checks again."""
    compiled = native.library()
    floats = [compiled_library.np.zeros((3, 3)) for _ in range(6)]
    compiled.update(0, *floats)
    for wrong in (floats[0].astype("f4"), floats[0][:, ::-1]):
        with pytest.raises(ctypes.ArgumentError, match="wanted float64 in C order"):
            compiled.update(0, wrong, *floats[1:])


@needs_sources
def test_constants_of_both_languages_agree():
    assert f"VERSION = {compiled_library.VERSION} " in (SOURCES / "library.c").read_text()
    pixels = (SOURCES / "pixels.c").read_text()
    shapes, used = (SOURCES / "shape_light.h").read_text(), shape_images
    assert f"TINY = {used.TINY:.0e}".replace("e-0", "e-") in shapes and f"CORNER = {used.CORNER}," in shapes
    assert f"MOST_CORRELATION = {used.MOST_CORRELATION};" in shapes and f"MOST = {shape_fits.MOST}," in shapes
    assert f"NODES = {len(used.NODES)}," in shapes and f"NODES_CORNER = {len(used.NODES_CORNER)} " in shapes
    assert f"MARGIN = {pixel_sums.MARGIN} " in pixels and f"1 << {pixel_sums.EMPTY.bit_length() - 1})" in pixels


@needs_sources
def test_every_function_of_the_sources_is_declared():
    sources = "".join(path.read_text() for path in sorted(SOURCES.glob("*.[ch]")))
    sources = re.sub(r"OF_TYPE\((\w+)\)", r"\1_8", sources)
    found = {name: text for name, text in re.findall(r"^API \w+ (\w+)\(([^)]*)\)", sources, re.M)}
    declared = {name for name in compiled_library.FUNCTIONS if not name.endswith("_16")}
    assert set(found) - {"kinemark_native_version"} == declared
    for name in declared:
        assert found[name].count(",") + 1 == len(compiled_library.FUNCTIONS[name]), name
