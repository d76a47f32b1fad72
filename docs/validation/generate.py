"""Runs the studies, and writes what they print with date, seed, command, version and machine: `runs/`, results.md.

    python docs/validation/generate.py [study …]           run them, keep their output, write the page
    python docs/validation/generate.py --check [study …]   run them, and fail where a figure differs from the one kept
    python docs/validation/generate.py --page              only write the page from what is kept

`studies.toml` lists the studies. Those whose recordings are absent are named and left out.
"""

from __future__ import annotations

import argparse
import datetime
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
RUNS, PAGE = HERE / "runs", HERE / "results.md"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
Study = dict[str, Any]


# ---- Running ----


def studies() -> dict[str, Study]:
    """name → what `studies.toml` says."""
    return tomllib.loads((HERE / "studies.toml").read_text(encoding="utf-8"))


def recordings() -> Path:
    """The folder of the recordings."""
    return Path(os.environ.get("KINEMARK_DATA", ROOT.parent / "shared" / "data"))


def absent(study: Study) -> list[str]:
    """What the study needs and is not here."""
    return [name for name in study.get("data", []) if not (recordings() / name).exists()]


def run(study: Study) -> tuple[str, float]:
    """What a study prints, and how many seconds it took.

    Raises:
        RuntimeError: it failed.
    """
    env = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "KINEMARK_DATA": str(recordings())}
    began = time.perf_counter()
    call = [sys.executable, *study["command"].split()]
    ran = subprocess.run(call, cwd=ROOT, env=env, capture_output=True, encoding="utf-8", check=False)
    if ran.returncode:
        raise RuntimeError(f"{study['command']} failed:\n{ran.stderr}")
    output = re.sub(re.escape(tempfile.gettempdir()) + r"\S*", "…", ran.stdout)
    return output.rstrip() + "\n", time.perf_counter() - began


def machine() -> str:
    """The class of this machine."""
    return f"{os.cpu_count()} processors {platform.machine()}, {platform.system()}, Python {platform.python_version()}"


# ---- Keeping ----


def keep(name: str, study: Study, output: str, seconds: float) -> None:
    """Write `runs/NAME.txt`: lines of facts, an empty line, and the output."""
    from kinemark.version import __version__

    facts = {
        "command": f"python {study['command']}",
        "seed": study["seed"],
        "date": datetime.date.today().isoformat(),
        "version": __version__,
        "machine": machine(),
        "seconds": f"{seconds:.0f}",
    }
    head = "".join(f"{key}: {value}\n" for key, value in facts.items())
    (RUNS / f"{name}.txt").write_text(f"{head}\n{output}", encoding="utf-8")


def kept(name: str) -> tuple[dict[str, str], str] | None:
    """The facts and the output of a run that was kept."""
    path = RUNS / f"{name}.txt"
    if not path.is_file():
        return None
    head, _, output = path.read_text(encoding="utf-8").partition("\n\n")
    return dict(line.split(": ", 1) for line in head.splitlines()), output


def page() -> str:
    """Markdown: a heading a study that was kept."""
    lines = [
        "# Results of the studies",
        "",
        "Output of the programs in `studies/`, written by `python3 dev.py validate`; do not edit this page. Figures",
        "are computed by the run that is named above each output, except for those that the line “Quoted” names.",
        "",
    ]
    for name, study in studies().items():
        if (run_kept := kept(name)) is None:
            continue
        facts, output = run_kept
        lines += [f"## {study['title']}", "", *_facts(facts, study), "", "```text", output.rstrip(), "```", ""]
    return "\n".join(lines)


def _facts(facts: dict[str, str], study: Study) -> Iterator[str]:
    """What stands above an output."""
    yield f"`{facts['command']}`, seed: {facts['seed']}. {facts['date']}, Kinemark {facts['version']},"
    yield f"{facts['machine']}; {facts['seconds']} s."
    if "quoted" in study:
        yield ""
        yield f"*Quoted:* {study['quoted']}"


# ---- Comparing ----


def differences(study: Study, before: str, after: str) -> list[str]:
    """Lines of two outputs that differ by more than the study's tolerance."""
    ignore, tolerance = study.get("ignore", []), study.get("tolerance", 0.02)
    old, new = (_lines(text, ignore) for text in (before, after))
    if len(old) != len(new):
        return [f"{len(old)} lines before, {len(new)} now"]
    return [f"- {a}\n+ {b}" for a, b in zip(old, new, strict=True) if not alike(a, b, tolerance)]


def _lines(text: str, ignore: Iterable[str]) -> list[str]:
    """Lines without what differs from machine to machine."""
    lines = text.splitlines()
    for what in ignore:
        lines = [re.sub(what, " …", line) for line in lines]
    return [" ".join(line.split()) for line in lines if line.strip()]


def alike(a: str, b: str, tolerance: float) -> bool:
    """Whether two lines have the same words, and numbers within the tolerance or a unit of their last digit."""
    if NUMBER.sub("#", a) != NUMBER.sub("#", b):
        return False
    return all(_near(x, y, tolerance) for x, y in zip(NUMBER.findall(a), NUMBER.findall(b), strict=True))


def _near(x: str, y: str, tolerance: float) -> bool:
    """Two printed numbers."""
    mantissa, _, exponent = x.partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    whole = "." not in mantissa and not exponent
    slack = tolerance * abs(float(x)) + (0.0 if whole else 1.001 * unit)
    return abs(float(x) - float(y)) <= slack


def main() -> None:
    """Do what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("studies", nargs="*", help="all where none is named")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--page", action="store_true")
    asked = parser.parse_args()
    worse = 0
    for name, study in studies().items():
        if asked.page or (asked.studies and name not in asked.studies):
            continue
        if missing := absent(study):
            print(f"{name}: left out, {', '.join(missing)} is absent", flush=True)
            continue
        output, seconds = run(study)
        if not asked.check:
            keep(name, study, output, seconds)
            print(f"{name}: kept, {seconds:.0f} s", flush=True)
        elif (before := kept(name)) is not None:
            found = differences(study, before[1], output)
            worse += bool(found)
            print(f"{name}: {'as kept' if not found else 'differs'}, {seconds:.0f} s", *found, sep="\n", flush=True)
    if asked.check:
        sys.exit(1 if worse else 0)
    RUNS.mkdir(exist_ok=True)
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
