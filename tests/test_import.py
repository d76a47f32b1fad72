"""`import kinemark` takes no time and brings no interface; the public names come when they are used."""

import subprocess
import sys
from pathlib import Path
from pkgutil import walk_packages

import numpy as np
import pytest

import kinemark
from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.io.trc import write_trc

BLOCKED = """
import sys
for name in ("plotly", "cyclopts", "rich", "pydantic", "jinja2", "kinemark.apps", "kinemark.engine", "kinemark.report"):
    sys.modules[name] = None  # importing it raises ImportError
"""
WORK = """
import numpy as np
import kinemark
from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.io.trc import write_trc
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


@pytest.mark.parametrize("words", [[], ["run"], ["status"], ["calibrate"]], ids=" ".join)
def test_help_brings_no_stage(words):
    code = f"""
import sys
sys.argv = ["kinemark", *{words}, "--help"]
from kinemark.apps.cli import main
try:
    main()
except SystemExit:
    pass
print([m for m in ("scipy", "av", "h5py", "plotly", "pydantic", "kinemark.detect") if m in sys.modules])
"""
    assert said(code).splitlines()[-1] == "[]"


def test_information_on_a_file_brings_no_stage():
    code = "import sys, kinemark.apps.commands.files as f; print([m for m in sys.modules if m == 'kinemark.track'])"
    assert said(code) == "[]"


def test_information_on_a_trial_brings_no_stage_and_no_part_of_scipy(tmp_path):
    """Nor what reads sessions: together they take three times as long as the rest."""
    source = tmp_path / "walk.trc"
    xyz = np.random.default_rng(0).normal(size=(30, 3)) * 300
    paths = tuple(MarkerTrajectory.measured(f"M{k}", xyz + 100 * k) for k in range(6))
    write_trc(source, Trajectories(paths, 100.0))
    code = f"""
import sys
from pathlib import Path
from kinemark.engine.describe import describe
assert len(describe(Path({str(source)!r}))["markers"]) == 6
print([m for m in ("kinemark.label", "pydantic", "scipy.spatial", "scipy.signal") if m in sys.modules])
"""
    assert said(code) == "[]"


STAGES = sorted(name for name in kinemark.__all__ if (Path(kinemark.__file__).parent / name).is_dir())


def test_the_stages_are_those_packages_whose_function_has_their_name():
    assert STAGES == ["detect", "fill", "label", "match", "reconstruct", "track"]


@pytest.mark.parametrize("first", ["from kinemark.{} import *", "import kinemark.{} as package", "import kinemark"])
def test_a_stage_is_a_function_and_a_package_whichever_way_it_is_imported_first(first):
    """By attribute, by `from` and by `import … as`, in a fresh process."""
    said_of_each = [
        f"""
{first.format(name)}
import inspect, pickle, kinemark
from kinemark import {name}
import kinemark.{name} as package
import kinemark.{name}.{inner} as module
function = vars(package)["{name}"]
print(
    callable({name})
    and kinemark.{name} is {name} is package is pickle.loads(pickle.dumps({name}))
    and inspect.isfunction(function)
    and inspect.signature({name}) == inspect.signature(function)
    and inspect.ismodule(module)
    and kinemark.{name}.{inner} is module
)"""
        for name, inner in zip(STAGES, ("learning", "judge", "stage", "stage", "stage", "simultaneous"), strict=True)
    ]
    assert said("".join(said_of_each)).split() == ["True"] * len(STAGES)


def test_a_stage_that_is_called_calls_its_function():
    with pytest.raises(ValueError, match="0 sources and 1 camera names"):
        kinemark.detect([], cameras=["left"], rate=100.0)
    assert kinemark.detect([], cameras=[], rate=100.0).rate == 100.0


@pytest.mark.parametrize("name", [m.name for m in walk_packages(kinemark.__path__, "kinemark.") if m.ispkg])
def test_every_package_can_be_imported_under_another_name(name):
    scope = {}
    exec(f"import {name} as package", scope)
    assert scope["package"] is sys.modules[name]


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
