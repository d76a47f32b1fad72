"""`import kinemark` takes no time and brings no interface; the public names come when they are used."""

import subprocess
import sys

import pytest

import kinemark

BLOCKED = """
import sys
for name in ("plotly", "cyclopts", "rich", "pydantic", "jinja2", "kinemark.apps", "kinemark.engine", "kinemark.report"):
    sys.modules[name] = None  # importing it raises ImportError
"""
WORK = """
import numpy as np
import kinemark
for name in kinemark.__all__:
    getattr(kinemark, name)
xyz = np.stack([np.arange(30.0), np.zeros(30), np.ones(30)], -1)
xyz[10:13] = np.nan
trial = kinemark.Trajectories((kinemark.MarkerTrajectory.measured("knee", xyz),), 100.0)
filled, gaps = kinemark.fill(trial)
print(len(gaps))
"""


def said(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert not done.returncode, done.stderr
    return done.stdout.strip()


def test_the_library_works_where_no_interface_can_be_imported():
    assert said(BLOCKED + WORK) == "1"


def test_import_brings_nothing_heavy():
    """Their import takes most of the time; benchmarks/startup.py measures it."""
    heavy = ("numpy", "scipy", "av", "h5py", "plotly", "cyclopts", "rich", "pydantic", "kinemark.data")
    assert said(f"import sys, kinemark; print([m for m in {heavy} if m in sys.modules])") == "[]"


def test_parts_of_scipy_come_when_they_are_used():
    """Each takes a fifth of a second or more: `import scipy`, then `scipy.fft.rfft`."""
    parts = (
        "detect",
        "calibrate",
        "match",
        "reconstruct",
        "track",
        "fill",
        "kinematics",
        "digitise",
        "sensitivity",
        "io",
    )
    code = "".join(f"import kinemark.{part}\n" for part in parts)
    named = ("fft", "interpolate", "linalg", "ndimage", "optimize", "signal", "sparse", "spatial", "special", "stats")
    assert said(f"{code}import sys; print([n for n in {named} if f'scipy.{{n}}' in sys.modules])") == "[]"


def test_help_brings_no_stage():
    code = """
import sys
sys.argv = ["kinemark", "--help"]
from kinemark.apps.cli import main
try:
    main()
except SystemExit:
    pass
print([m for m in ("scipy.linalg", "av", "h5py", "plotly", "pydantic", "kinemark.detect") if m in sys.modules])
"""
    assert said(code).splitlines()[-1] == "[]"


def test_information_on_a_file_brings_no_stage():
    code = "import sys, kinemark.apps.commands.files as f; print([m for m in sys.modules if m == 'kinemark.track'])"
    assert said(code) == "[]"


@pytest.mark.parametrize("first", ["kinemark.detect.kiss", "kinemark.track.simultaneous", "kinemark.fill.judge"])
def test_a_function_keeps_its_name_whichever_package_is_imported_first(first):
    """The packages detect, match, reconstruct, track and fill are called as the functions are."""
    code = f"""
import {first}
import kinemark, types
functions = [getattr(kinemark, name) for name in ("detect", "match", "reconstruct", "track", "fill")]
print([one for one in functions if not isinstance(one, types.FunctionType)])
"""
    assert said(code) == "[]"


def test_all_names_are_there_and_no_others():
    assert set(kinemark.__all__) <= set(dir(kinemark))
    with pytest.raises(AttributeError, match="kinemarkk"):
        kinemark.kinemarkk  # noqa: B018


def test_each_command_is_described_by_its_docstring():
    """The list of `kinemark --help` is read from the sources, since nothing is imported for it."""
    from kinemark.apps.cli import COMMANDS, app

    for names in COMMANDS.values():
        for name in names:
            text = app[name].help
            assert text.splitlines()[0].endswith("."), name
