"""What the commands share: options, progress and printing."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Literal

from cyclopts import Parameter
from rich.console import Console

from ..engine.progress import Progress

errors = Console(stderr=True)

LengthUnit = Literal["mm", "cm", "m", "in"] | None
Json = Annotated[bool, Parameter(name="--json", negative="", help="Print the results for a machine.")]
SelfContained = Annotated[
    bool,
    Parameter(negative="", help="Put the drawing library into the page, for mailing; otherwise pages share one file."),
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


@contextmanager
def progress() -> Iterator[Progress]:
    """Bars on the terminal, one a stage; nothing where the output goes to a file."""
    from rich import progress as bars  # only commands that take long need it

    columns = (
        bars.SpinnerColumn(),
        bars.TextColumn("{task.description:<12}"),
        bars.BarColumn(),
        bars.MofNCompleteColumn(),
        bars.TimeElapsedColumn(),
    )
    with bars.Progress(*columns, console=errors, disable=not errors.is_terminal) as shown:
        tasks: dict[str, bars.TaskID] = {}

        def tell(stage: str, done: int, total: int) -> None:
            if stage not in tasks or shown.tasks[tasks[stage]].completed > done:
                tasks[stage] = shown.add_task(stage, total=total)
            shown.update(tasks[stage], completed=done, total=total)

        yield tell


def print_result(value: object) -> None:
    """Text as it is, anything else as JSON."""
    sys.stdout.write((value if isinstance(value, str) else json.dumps(value, indent=1)) + "\n")
    sys.stdout.flush()
