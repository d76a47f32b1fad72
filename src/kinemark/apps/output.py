"""What the commands share: options, printing, and the status that they end with."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

if TYPE_CHECKING:
    from rich.console import Console

    from ..data import KinemarkError


@cache
def errors() -> Console:
    """Where errors and progress go."""
    from rich.console import Console  # most commands end well and at once

    return Console(stderr=True)


BAD_VERDICT = 3
"""Exit status where all was computed and the verdict is bad; 1 is an error, 2 a wrong command; chosen."""

LengthUnit = Annotated[
    Literal["mm", "cm", "m", "in"] | None,
    Parameter(help="Unit of length of a file that is silent or wrong about it."),
]
Rate = Annotated[
    float | None, Parameter(name="--rate-hz", help="Frames a second of a file that is silent or wrong about it.")
]
Partial = Annotated[
    bool, Parameter(name="--partial", negative="", help="Read what there is of a file that is cut off or damaged.")
]
Json = Annotated[bool, Parameter(name="--json", negative="", help="Print the results for a machine.")]
SelfContained = Annotated[
    bool,
    Parameter(negative="", help="Put the drawing library into the page, for mailing; otherwise pages share one file."),
]
NO_EMPTY = Parameter(negative_iterable=())
"""Of all commands: several values have no option that empties them (--empty-size-px)."""
FailOn = Annotated[
    Literal["red", "amber", "never"], Parameter(help="a verdict as bad as this ends the command with status 3.")
]
Set = Annotated[
    list[str] | None,
    Parameter(
        name="--set",
        negative="",
        help="STAGE.PARAMETER=VALUE instead of the file's, as track.method=kiss_tracking; may be repeated. "
        "The command methods lists what there is.",
    ),
]


def print_result(value: object) -> None:
    """Text as it is, anything else as JSON.

    Raises:
        KinemarkError: the output is closed, or its disk is full.
    """
    text = value if isinstance(value, str) else json.dumps(value, indent=1)
    if sys.stdout is None:
        raise _unwritten("it is closed")
    try:
        sys.stdout.write(f"{text}\n")
        sys.stdout.flush()
    except BrokenPipeError:  # whoever read it has seen enough
        raise
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left is not tried again at the end
        raise _unwritten(str(error)) from error


def _unwritten(why: str) -> KinemarkError:
    """The error of an output that takes no text."""
    from ..data import KinemarkError  # brings NumPy, which --help does without

    return KinemarkError(
        f"The results cannot be printed: {why}. Send the output to a place with room. Files that were asked for are "
        "written."
    )


def print_note(said: str) -> None:
    """What a person should know, beside the results."""
    errors().print(f"kinemark: {said}", markup=False, highlight=False, soft_wrap=True)


def print_errors(failed: Mapping[str, KinemarkError]) -> None:
    """Why some of many could not be used, by their names."""
    for name, error in failed.items():
        said = str(error) if str(error).startswith(name) else f"{name}: {error}"
        errors().print(f"kinemark: {said}", style="red", markup=False, highlight=False, soft_wrap=True)


def exit_by_verdict(grades: Sequence[str], fail_on: FailOn) -> None:
    """End with `BAD_VERDICT` where a verdict is as bad as `fail_on`, so that a script sees it."""
    if fail_on != "never" and {"red": {"red"}, "amber": {"red", "amber"}}[fail_on] & set(grades):
        sys.exit(BAD_VERDICT)
