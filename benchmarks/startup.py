"""How much a process pays before it works: CPU time of imports and of commands, beside that of `import numpy`.

    python benchmarks/startup.py [--runs N]

Each is run in turns, in a process of its own with one BLAS thread; the median counts.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from metrics import Metric

from kinemark import MarkerTrajectory, Trajectories, Trial, write_c3d

RUNS = 5
NUMPY = "import numpy"
CONVERT = """
import os, sys
sys.argv[0:1] = ["kinemark", "convert"]
if os.path.exists(sys.argv[3]):
    os.remove(sys.argv[3])
from kinemark.apps.cli import main
main()
"""


def programs(folder: Path) -> dict[str, list[str]]:
    """What is timed: name → arguments of Python."""
    file = folder / "trial.c3d"
    if not file.exists():
        paths = (MarkerTrajectory.measured("knee", np.ones((50, 3))),)
        write_c3d(file, Trial("trial", Trajectories(paths, 100.0)))
    return {
        NUMPY: ["-c", "import numpy"],
        "import kinemark": ["-c", "import kinemark"],
        "import kinemark, all names": ["-c", "from kinemark import *"],
        "kinemark --help": ["-m", "kinemark", "--help"],
        "kinemark gait --help": ["-m", "kinemark", "gait", "--help"],
        "kinemark methods": ["-m", "kinemark", "methods"],
        "kinemark info FILE.c3d": ["-m", "kinemark", "info", str(file)],
        "kinemark convert FILE.c3d FILE.trc": ["-c", CONVERT, str(file), str(folder / "again.trc")],
    }


def cpu_seconds(arguments: Sequence[str]) -> float:
    """User and system time of one process, whose modules are compiled once, as installed ones are."""
    before = os.times()
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": ""}
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL, env=environment)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def measured(runs: int) -> Mapping[str, float]:
    """Median CPU seconds of each, run in turns; the first round, which fills the caches, does not count."""
    with tempfile.TemporaryDirectory() as folder:
        asked = programs(Path(folder))
        rounds = [{name: cpu_seconds(arguments) for name, arguments in asked.items()} for _ in range(runs + 1)][1:]
    return {name: statistics.median(one[name] for one in rounds) for name in asked}


def metrics() -> list[Metric]:
    """Each as a ratio to NumPy's own import."""
    found = measured(RUNS)
    return [
        Metric(f"CPU by {NUMPY}'s: {name}", seconds / found[NUMPY], "ratio", "less", relative=0.4)
        for name, seconds in found.items()
        if name != NUMPY
    ]


def main() -> None:
    """Print the seconds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=RUNS)
    for name, seconds in measured(parser.parse_args().runs).items():
        print(f"{name:30s}{seconds:8.3f} s of CPU")


if __name__ == "__main__":
    main()
