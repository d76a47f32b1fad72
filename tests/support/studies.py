"""The studies as programs: what they print, and the figures in it."""

import os
import re
import subprocess
import sys
from pathlib import Path

from support.shared import ROOT

STUDIES = Path(__file__).parents[2] / "studies"


def printed(study, *arguments):
    """What a study prints."""
    done = subprocess.run(
        [sys.executable, STUDIES / f"{study}.py", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "KINEMARK_DATA": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def figures(text, row):
    """The last numbers of the line that begins with `row`."""
    line = next(line for line in text.splitlines() if line.strip().startswith(row))
    return [float(x) for x in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", line.split(row, 1)[1])]
