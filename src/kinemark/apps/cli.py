"""The command `kinemark`. Only the command that is called is imported: `--help` and `info` start at once."""

from __future__ import annotations

import ast
import os
import sys
from pathlib import Path

from cyclopts import App

from ..data import KinemarkError
from ..engine.system import absence_notice
from ..version import __version__
from .output import errors

COMMANDS = {
    "commands/simulate.py": ("demo", "simulate"),
    "commands/new_session.py": ("init",),
    "commands/session.py": ("run", "status", "calibrate"),
    "commands/listings.py": ("methods", "schema", "cite"),
    "commands/detect.py": ("detect",),
    "commands/fill.py": ("fill",),
    "commands/files.py": ("info", "convert"),
    "commands/analysis.py": ("angles", "sensitivity"),
    "um2as.py": ("digitise", "um2as"),
}
"""The commands of each module; a module that is called as its command holds further commands."""


def descriptions(file: Path) -> dict[str, str]:
    """What the docstrings of a module and its functions say, but for the arguments; the module is not imported."""
    module = ast.parse(file.read_text(encoding="utf-8"))
    documented = {file.stem: ast.get_docstring(module)}
    documented |= {node.name: ast.get_docstring(node) for node in module.body if isinstance(node, ast.FunctionDef)}
    return {name: (text or "").split("\n\nArgs:")[0] for name, text in documented.items()}


def command_line() -> App:
    """All commands, not yet imported."""
    app = App(
        name="kinemark", help="Marker-based optical motion capture, from images to trajectories.", version=__version__
    )
    here = Path(__file__).parent
    for file, names in COMMANDS.items():
        said = descriptions(here / file)
        for name in names:
            module = f"{__package__}.{file.removesuffix('.py').replace('/', '.')}"
            app.command(f"{module}:{name}", name=name, help=said[name])
    return app


app = command_line()


def main() -> None:
    """The command `kinemark`."""
    if notice := absence_notice():
        errors().print(f"kinemark: {notice}", markup=False, highlight=False, soft_wrap=True)
    try:
        app()
    except KinemarkError as error:
        from ..report.terminal_summary import finding_lines  # takes long to import, and most commands end well

        text = "\n".join([f"kinemark: {error}", *finding_lines([found.as_dict() for found in error.findings])])
        errors().print(text, style="red", markup=False, highlight=False, soft_wrap=True)
        sys.exit(1)
    except BrokenPipeError:  # whoever read the output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except KeyboardInterrupt:
        errors().print("stopped; what was finished is kept, and the next run goes on from there")
        sys.exit(130)
