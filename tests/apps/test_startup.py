"""What a command does not need is not imported for it."""

import subprocess
import sys

import pytest

from kinemark.data import Trial
from kinemark.io.trial import write_trial
from support.trials import made_trial

HEAVY = ("av", "h5py", "tomlkit", "scipy", "plotly", "pydantic", "rich.console", "kinemark.engine.session")
CALL = """
import sys
from kinemark.apps.cli import main
sys.argv = ["kinemark", *sys.argv[1:]]
try:
    main()
except SystemExit as end:
    assert not end.code, end.code
print("LOADED", *[name for name in {names} if name in sys.modules])
""".replace("{names}", repr(HEAVY))


def loaded(*arguments):
    done = subprocess.run(
        [sys.executable, "-c", CALL, *map(str, arguments)], capture_output=True, text=True, timeout=100
    )
    assert "LOADED" in done.stdout, done.stderr
    return done.stdout.split("LOADED")[1].split()


@pytest.mark.parametrize("ending", [".c3d", ".trc", ".csv"])
def test_files_are_described_and_converted_without_video_hdf5_and_toml(tmp_path, ending):
    trial = made_trial()
    write_trial(Trial("a", trial.trajectories), tmp_path / f"a{ending}")
    assert loaded("info", tmp_path / f"a{ending}") == []
    for other in (".c3d", ".trc", ".csv"):
        assert loaded("convert", tmp_path / f"a{ending}", tmp_path / f"b{other}") == []


def test_help_brings_no_numbers():
    """Half of what `--help` took was the import of NumPy."""
    done = subprocess.run(
        [sys.executable, "-c", CALL.replace(repr(HEAVY), repr(("numpy", "kinemark.data", "rich.markdown"))), "--help"],
        capture_output=True, text=True, timeout=100,
    )  # fmt: skip
    assert done.stdout.split("LOADED")[1].split() == [], done.stderr


ENGINE = (
    "h5py",
    "plotly",
    "pydantic",
    "jinja2",
    "scipy.optimize",
    "kinemark.engine.settings",
    "kinemark.engine.session",
)
HELP = """
import sys
from kinemark.apps.cli import COMMANDS, main
for name in [name for names in COMMANDS.values() for name in names]:
    sys.argv = ["kinemark", name, "--help"]
    try:
        main()
    except SystemExit as end:
        assert not end.code, end.code
    print("LOADED", name, *[heavy for heavy in {names} if heavy in sys.modules])
""".replace("{names}", repr(ENGINE))


def test_help_of_no_command_brings_the_engine():
    """It took 1.5 to 2 s, all of it imports."""
    done = subprocess.run([sys.executable, "-c", HELP], capture_output=True, text=True, timeout=100)
    said = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("LOADED")]
    assert len(said) > 20 and all(len(words) == 1 for words in said), (said, done.stderr)


def test_each_library_is_imported_when_a_file_needs_it(tmp_path):
    write_trial(made_trial(), tmp_path / "a.h5")
    assert loaded("info", tmp_path / "a.h5") == ["h5py"]
