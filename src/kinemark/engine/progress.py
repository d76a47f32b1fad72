"""Progress of a run, and cancelling it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from ..data import KinemarkError
from ..data.progress import Cancelled, Listener

Progress = Callable[[str, int, int], None]
"""Called with the stage, how much of it is done, and how much there is."""


def silent(stage: str, done: int, total: int) -> None:
    """Shows nothing."""


class Cancel(Protocol):
    """A request to stop a run, such as a `threading.Event`."""

    def is_set(self) -> bool:
        """Whether it shall stop now."""
        ...


@dataclass(frozen=True, slots=True)
class Watch:
    """Receives a run's progress, and may cancel it.

    Attributes:
        progress: called with each step.
        cancel: checked at each step; None where the run cannot be cancelled.
    """

    progress: Progress = silent
    cancel: Cancel | None = None

    def of(self, stage: str) -> Listener:
        """The listener of a stage."""

        def listen(done: int, total: int) -> None:
            self.progress(stage, done, total)
            if self.cancel is not None and self.cancel.is_set():
                raise Cancelled(f"stopped in {stage}; what was finished before is kept, and the next run goes on there")

        return listen


SILENT = Watch()
"""No progress is shown, and nothing cancels the run."""


def check_threads(threads: int | None) -> None:
    """Raises a KinemarkError where a number of threads is none; None leaves it to the machine."""
    if threads is not None and threads < 1:
        raise KinemarkError(f"threads is {threads}, wanted at least 1. Leave it out to use all processors.")
