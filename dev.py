#!/usr/bin/env python3
"""Sets Kinemark up on a fresh machine and runs it: `python3 dev.py demo`, `python3 dev.py test`.

    demo    make the environment, install, run `kinemark demo`, which simulates a gait laboratory and processes it
    test    make the environment, install with the test tools, run the tests
    check   the same, then format, lint, types, layers
    fix     let ruff format and mend what it can

Needs Python 3.11 or later and nothing else; all goes into `.venv` beside this file. The versions are those of
`requirements.lock`; `KINEMARK_UNLOCKED=1` takes the newest that pyproject.toml allows.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
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


def run(*command: str | Path) -> None:
    """Run a command in the project, and end with its status where it fails."""
    status = subprocess.run([str(part) for part in command], cwd=ROOT, check=False).returncode
    if status:
        sys.exit(status)


def wanted(extras: str) -> str:
    """A key of what should be installed, so that it is only done again when that changes."""
    sources = sorted((ROOT / "src" / "kinemark" / "native").glob("*.[ch]"))  # to be compiled again
    files = [*(ROOT / name for name in ("pyproject.toml", "setup.py", "requirements.lock")), *sources]
    content = b"".join(path.read_bytes() for path in files)
    return hashlib.sha256(content + extras.encode() + sys.version.encode()).hexdigest()


def install(extras: str) -> None:
    """Make the environment, and install Kinemark with its extras, unless that was done."""
    stamps = [VENV / f"installed-{known}" for known in ("test", extras)]
    if any(s.is_file() and s.read_text() == wanted(s.name.removeprefix("installed-")) for s in stamps):
        return
    if not PYTHON.is_file():
        print(f"making {VENV}", flush=True)
        venv.create(VENV, with_pip=True)
    locked = not os.environ.get("KINEMARK_UNLOCKED")
    print("installing" + (" the locked versions" if locked else ""), flush=True)
    pip = (PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check")
    constraints = ("--constraint", "requirements.lock") if locked else ()
    run(*pip, *constraints, "--editable", ".[test]" if extras == "test" else ".")
    stamps[-1].write_text(wanted(extras))


def main() -> None:
    """Do what the first argument says."""
    task, rest = (sys.argv[1] if len(sys.argv) > 1 else "help"), sys.argv[2:]
    if sys.version_info < (3, 11):  # noqa: UP036  whoever runs this may have an older one
        sys.exit(f"Kinemark needs Python 3.11 or later; this is {sys.version.split()[0]}.")
    if task == "demo":
        install("run")
        run(PYTHON, "-m", "kinemark", "demo", *rest)
    elif task == "test":
        install("test")
        run(PYTHON, "-m", "pytest", *rest)
    elif task == "check":
        install("test")
        for name, command in CHECKS:
            print(f"{name}:", flush=True)
            tool = [BIN / "lint-imports"] if name == "layers" else [PYTHON, "-m", *command]
            run(*tool, *(() if name == "layers" else rest))
    elif task == "fix":
        install("test")
        run(PYTHON, "-m", "ruff", "check", "--fix", "--quiet")
        run(PYTHON, "-m", "ruff", "format")
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
