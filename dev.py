#!/usr/bin/env python3
"""Sets Kinemark up on a fresh machine and runs it: `python3 dev.py demo`, `python3 dev.py test`.

    demo      make the environment, install, run `kinemark demo`, which simulates a gait laboratory and processes it
    test      make the environment, install with the test tools, run the tests
    check     the same, then format, lint, types, layers
    fix       let ruff format and mend what it can
    studio    install what `kinemark studio` needs, and build its page with node from a wheel;
              `python3 dev.py studio test` runs its tests
    docs      build the documentation as a site: docs/_build/index.html
    validate  run the studies and write what they print to docs/validation; names of studies may follow
    nightly   the tests with new random examples, the tests without compiled parts, studies and benchmarks against
              what is kept of them; takes hours

Needs Python 3.11 or later and nothing else; all goes into `.venv` beside this file. The versions are those of
`requirements.lock`; `KINEMARK_UNLOCKED=1` takes the newest that pyproject.toml allows. `KINEMARK_EXTRAS=test,ui,docs`
installs once what several tasks need, instead of what each needs.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import threading
import time
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")

CHECKS: tuple[tuple[str, list[str]], ...] = (
    ("format", ["ruff", "format", "--check"]),
    ("lint", ["ruff", "check"]),
    ("types", ["mypy"]),
    ("layers", []),
)
EXTRAS = {"demo": "run", "docs": "docs", "studio": "studio,ui"}
"""What is installed for a task; for all others the tools of the tests."""
SITE = ("sphinx", "--fail-on-warning", "--keep-going", "--quiet", "-b", "html", "docs", "docs/_build")
NIGHTLY: tuple[tuple[str, list[str], dict[str, str]], ...] = (
    ("tests, new random examples", ["-m", "pytest", "-m", "", "--hypothesis-profile=nightly"], {}),
    ("tests without compiled parts", ["-m", "pytest"], {"KINEMARK_PLAIN": "1"}),
    ("studies", ["docs/validation/generate.py", "--check"], {}),
    ("benchmarks", ["benchmarks/compare.py"], {}),
)


def run(*command: str | Path) -> None:
    """Run a command in the project, and end with its status where it fails."""
    status = subprocess.run([str(part) for part in command], cwd=ROOT, check=False).returncode
    if status:
        sys.exit(status)


def run_told(*command: str | Path) -> None:
    """The same of a long installation: a line for each part that is fetched or built; all of it where it fails."""
    began = time.monotonic()
    said: list[str] = []
    process = subprocess.Popen(
        [str(part) for part in command],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
    )  # fmt: skip
    beating = threading.Event()
    thread = threading.Thread(target=tell_now_and_then, args=(said, began, beating), daemon=True)
    thread.start()
    assert process.stdout is not None
    for line in process.stdout:
        said.append(line.rstrip())
        if (step := step_of(line)) is not None:
            print(f"  {time.monotonic() - began:4.0f} s  {step}", flush=True)
    beating.set()
    if status := process.wait():
        print(*said[-40:], sep="\n", file=sys.stderr)
        sys.exit(status)
    print(f"  {time.monotonic() - began:4.0f} s  installed", flush=True)


STEPS = ("Downloading", "Using cached", "Building", "Installing", "Preparing", "Getting requirements")
"""What a line of pip's begins with that is worth a line of ours."""
EVERY_S = 10.0
"""Between two signs of life; chosen."""


def step_of(line: str) -> str | None:
    """What pip does now, in short; None for what it says besides."""
    words = line.strip()
    return words[:100] if words.startswith(STEPS) and ".metadata" not in words else None


def tell_now_and_then(said: list[str], began: float, done: threading.Event) -> None:
    """A line where nothing new came for so many seconds."""
    known = len(said)
    while not done.wait(EVERY_S):
        if len(said) == known:
            print(
                f"  {time.monotonic() - began:4.0f} s  still at work: {said[-1].strip()[:80] if said else 'pip'}",
                flush=True,
            )
        known = len(said)


def keep_compiled() -> None:
    """Let Python keep what it compiles: tests start hundreds of processes, and each would compile all of it again."""
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


def wanted(extras: str) -> str:
    """A key of what should be installed, so that it is only done again when that changes."""
    sources = sorted((ROOT / "src" / "kinemark" / "native").glob("*.[ch]"))  # to be compiled again
    files = [*(ROOT / name for name in ("pyproject.toml", "setup.py", "requirements.lock")), *sources]
    content = b"".join(path.read_bytes() for path in files)
    return hashlib.sha256(content + extras.encode() + sys.version.encode()).hexdigest()


def install(extras: str) -> None:
    """Make the environment, and install Kinemark with its extras, unless that was done."""
    stamps = [VENV / f"installed-{known}" for known in ("test", extras)]
    if extras != "run":
        del stamps[0]
    if any(s.is_file() and s.read_text() == wanted(s.name.removeprefix("installed-")) for s in stamps):
        return
    if not PYTHON.is_file():
        print(f"making {VENV}", flush=True)
        venv.create(VENV, with_pip=True)
    locked = not os.environ.get("KINEMARK_UNLOCKED")
    print("installing" + (" the locked versions" if locked else ""), flush=True)
    pip = (PYTHON, "-m", "pip", "install", "--disable-pip-version-check", "--progress-bar", "off")
    constraints = ("--constraint", "requirements.lock") if locked else ()
    run_told(*pip, *constraints, "--editable", "." if extras == "run" else f".[{extras}]")
    stamps[-1].write_text(wanted(extras))


def check(rest: list[str]) -> None:
    """Format, lint, types, layers."""
    for name, command in CHECKS:
        print(f"{name}:", flush=True)
        tool = [BIN / "lint-imports"] if name == "layers" else [PYTHON, "-m", *command]
        run(*tool, *(() if name == "layers" else rest))


def fix() -> None:
    """Mend what ruff can."""
    run(PYTHON, "-m", "ruff", "check", "--fix", "--quiet")
    run(PYTHON, "-m", "ruff", "format")


def nightly() -> None:
    """All that takes too long for every change; every part runs, and the status says whether one failed."""
    failed = []
    for name, command, more in NIGHTLY:
        print(f"{name}:", flush=True)
        ran = subprocess.run([str(PYTHON), *command], cwd=ROOT, env=os.environ | more, check=False)
        if ran.returncode:
            failed.append(name)
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


def main() -> None:
    """Do what the first argument says."""
    task, rest = (sys.argv[1] if len(sys.argv) > 1 else "help"), sys.argv[2:]
    if sys.version_info < (3, 11):  # noqa: UP036  whoever runs this may have an older one
        sys.exit(f"Kinemark needs Python 3.11 or later; this is {sys.version.split()[0]}.")
    extras = os.environ.get("KINEMARK_EXTRAS") or EXTRAS.get(task, "test")
    commands = {
        "demo": lambda: run(PYTHON, "-m", "kinemark", "demo", *rest),
        "test": lambda: run(PYTHON, "-m", "pytest", *rest),
        "check": lambda: check(rest),
        "fix": fix,
        "studio": lambda: run(PYTHON, "ui/build.py", *rest),
        "docs": lambda: run(PYTHON, "-m", *SITE, *rest),
        "validate": lambda: run(PYTHON, "docs/validation/generate.py", *rest),
        "nightly": nightly,
    }
    if task not in commands:
        sys.exit(__doc__)
    keep_compiled()
    install(extras)
    commands[task]()


if __name__ == "__main__":
    main()
