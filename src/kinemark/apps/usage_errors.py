"""Messages for a command line that is not understood: what was found, what is wanted, and where the help is."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:  # most command lines are understood
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
    what = _described(error, argument.field_info.name)
    return f"{command} wants {name}{': ' if what else ''}{what}."


def _described(error: CycloptsError, name: str) -> str:
    """What the docstring of a command says of a parameter; empty where it says nothing."""
    from docstring_parser import parse  # cyclopts reads help by it

    params = parse(getattr(error.target, "__doc__", None) or "").params
    said = next((one.description for one in params if one.arg_name == name), None)
    return " ".join((said or "").split()).rstrip(".")
