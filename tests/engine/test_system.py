"""`kinemark info --system`, and the line that says once that nothing could be compiled."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from kinemark import native
from kinemark.apps.commands.files import info
from kinemark.data import KinemarkError
from kinemark.engine.system import absence_notice, system
from kinemark.native import compiled_library
from kinemark.version import __version__


@pytest.fixture
def absent(monkeypatch, tmp_path):
    """An installation without the compiled library."""
    monkeypatch.setenv(native.PLAIN, "")
    monkeypatch.setattr(compiled_library, "PATH", tmp_path / "absent.so")
    compiled_library._loaded.cache_clear()
    yield monkeypatch
    compiled_library._loaded.cache_clear()


def command(*arguments, **environment):
    return subprocess.run(
        [sys.executable, "-m", "kinemark", *arguments], env=os.environ | environment, capture_output=True, text=True
    )


def test_the_command_says_what_runs():
    done = command("info", "--system", "--json", OPENBLAS_NUM_THREADS="1", **{native.PLAIN: "1"})
    found = json.loads(done.stdout)
    assert (found["kinemark"], found["numpy"]) == (__version__, np.__version__)
    assert found["native"] == {
        "runs": "numpy", "path": None, "version": None, "reason": "the environment variable KINEMARK_PLAIN is set",
    }  # fmt: skip
    assert found["thread_limits"]["OPENBLAS_NUM_THREADS"] == "1" and found["blas_threads"] in (1, None)
    assert found["work_threads"] == 1
    assert not done.stderr


def test_text_and_figures_say_the_same():
    now = system()
    text, figures = now.text(), now.figures()
    assert json.loads(json.dumps(figures)) == figures
    for value in (figures["python"], figures["numpy"], figures["platform"], figures["blas"]):
        assert value in text
    path, version, reason = native.status()
    assert (f"compiled library, version {version}: {path}" if path else f"NumPy: {reason}") in text


def test_files_or_the_system(tmp_path):
    for asked in ({"system": False}, {"system": True}):
        with pytest.raises(KinemarkError, match="files, or --system"):
            info(*[tmp_path] * asked["system"], **asked)


def test_an_absent_library_is_said_once(absent, tmp_path):
    folder = tmp_path / "cache" / "kinemark"
    said = absence_notice(folder)
    assert said is not None and "absent.so is absent" in said and "\n" not in said
    assert absence_notice(folder) is None
    absent.setattr(compiled_library, "PATH", tmp_path / "other.so")  # another reason is said again
    compiled_library._loaded.cache_clear()
    assert "other.so" in absence_notice(folder)


def test_who_asks_for_numpy_is_told_nothing(absent, tmp_path):
    absent.setenv(native.PLAIN, "1")
    assert absence_notice(tmp_path) is None and not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_does_no_harm(absent, tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    assert absence_notice(file / "cache") is not None
    absent.setattr(Path, "home", lambda: (_ for _ in ()).throw(RuntimeError("no home")))
    absent.delenv("XDG_CACHE_HOME", raising=False)
    absent.delenv("LOCALAPPDATA", raising=False)
    assert absence_notice() is not None


def test_an_installation_with_the_library_says_nothing(monkeypatch, tmp_path):
    monkeypatch.setenv(native.PLAIN, "")
    if native.library() is None:
        pytest.skip("Kinemark was installed without a compiler")
    assert absence_notice(tmp_path) is None and not list(tmp_path.iterdir())
