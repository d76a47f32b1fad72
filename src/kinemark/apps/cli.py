"""The command `kinemark`. Only the command that is called is imported: `--help` and `info` start at once."""

from __future__ import annotations

import ast
import io
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from cyclopts import App

from ..version import __version__
from .output import NO_EMPTY, errors

if TYPE_CHECKING:
    from cyclopts.exceptions import CycloptsError


def usage_error(error: CycloptsError) -> str:
    """A line or two for whoever typed it."""
    from cyclopts.exceptions import MissingArgumentError
    from rich.markup import escape

    command = " ".join(["kinemark", *(error.command_chain or ())])
    said = _missing(command, error) if type(error) is MissingArgumentError else f"kinemark: {error}"
    return f"[red]{escape(said)}[/red]\n{escape(f'What there is: {command} --help')}"


def _missing(command: str, error: CycloptsError) -> str:
    """What a command lacks, as its help describes it."""
    argument = error.argument
    assert argument is not None  # that is what is missing
    given = getattr(error, "keyword", None) or next((t.keyword for t in argument.tokens if t.keyword), None)
    if given is not None:
        return f"{command}: {given} wants a value."
    name = argument.name if argument.index is None else argument.name.lstrip("-").upper().replace("-", "_")
    what = (argument.parameter.help or _described(error, argument.field_info.name)).rstrip(".")
    return f"{command} wants {name}{': ' if what else ''}{what}."


def _described(error: CycloptsError, name: str) -> str:
    """What the docstring of a command says of a parameter; empty where it says nothing."""
    from docstring_parser import parse  # cyclopts reads help by it

    params = parse(getattr(error.target, "__doc__", None) or "").params
    said = next((one.description for one in params if one.arg_name == name), None)
    return " ".join((said or "").split()).rstrip(".")


COMMANDS = {
    "commands/simulate.py": ("demo", "simulate"),
    "commands/new_session.py": ("init",),
    "commands/session.py": ("run", "status", "calibrate"),
    "commands/listings.py": ("methods", "schema", "cite"),
    "commands/detect.py": ("detect", "white-pixels"),
    "commands/label.py": ("label",),
    "commands/marker_set.py": ("marker-set",),
    "commands/template.py": ("template",),
    "commands/edits.py": ("edits",),
    "commands/audit.py": ("audit",),
    "commands/fill.py": ("fill",),
    "commands/studio.py": ("studio",),
    "commands/files.py": ("info", "convert", "starts"),
    "commands/pdf.py": ("pdf",),
    "commands/plan.py": ("plan",),
    "commands/aspect.py": ("aspect",),
    "commands/analysis.py": ("angles", "velocities", "gait", "gait-compare", "gait-reference", "sensitivity"),
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
        name="kinemark",
        help="Marker-based optical motion capture, from images to trajectories.",
        help_format="plaintext",
        version=__version__,
        error_formatter=usage_error,
        default_parameter=NO_EMPTY,
        suppress_keyboard_interrupt=False,  # __main__ tells what is kept
    )
    here = Path(__file__).parent
    for file, names in COMMANDS.items():
        said = descriptions(here / file)
        for name in names:
            module = f"{__package__}.{file.removesuffix('.py').replace('/', '.')}"
            function = name.replace("-", "_")
            app.command(f"{module}:{function}", name=name, help=said[function])
    return app


app = command_line()


def main() -> None:
    """Call the command that the arguments name; an error of the user's is a line, and status 1."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # an output in cp1252 or ASCII has no σ, and no name that is not Latin
    try:
        app()
    except BrokenPipeError:  # whoever read the output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except Exception as error:
        text = error_text(error)
        if text is None:
            raise
        errors().print(text, style="red", markup=False, highlight=False, soft_wrap=True)
        sys.exit(1)
    finally:
        _say_absence()


def error_text(error: Exception) -> str | None:
    """What an error of the user's or the machine's says, with its findings; None for a fault of the program."""
    from ..data import KinemarkError  # brings NumPy, which --help does without

    if isinstance(error, (FileExistsError, NotADirectoryError)):
        return f"kinemark: {error.filename} is a file, and a folder is wanted there. Name another folder."
    if isinstance(error, OSError):  # the disk is full, or not theirs to write
        return f"kinemark: {error}. Is there room, and may you read and write there?"
    if not isinstance(error, KinemarkError):
        return None
    if not error.findings:
        return f"kinemark: {error}"
    from ..report.terminal_summary import finding_lines  # takes long to import, and few errors have findings

    return "\n".join([f"kinemark: {error}", *finding_lines([found.as_dict() for found in error.findings])])


def _say_absence() -> None:
    """Say once that the compiled library is absent, where a command would have used it."""
    if "kinemark.native" in sys.modules:
        from ..engine.system import absence_notice

        if notice := absence_notice():
            errors().print(f"kinemark: {notice}", markup=False, highlight=False, soft_wrap=True)
