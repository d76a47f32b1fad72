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
        passes = _Passes(stage)

        def listen(done: int, total: int) -> None:
            self.progress(*passes(done, total))
            if self.cancel is not None and self.cancel.is_set():
                raise Cancelled(f"stopped in {stage}; what was finished before is kept, and the next run goes on there")

        return listen


class _Passes:
    """Numbers the passes of a stage that goes over the trial more than once, so that what is done of each never falls.

    The step 1 of 1 is the stage's end, in whatever pass it is.
    """

    def __init__(self, stage: str) -> None:
        self._stage, self._number, self._done, self._total = stage, 1, 0, 1

    def __call__(self, done: int, total: int) -> tuple[str, int, int]:
        """A step, with the name of the stage and of its pass."""
        if done == total == 1:
            done = total = self._total
        elif done < self._done:
            self._number += 1
        self._done, self._total = done, total
        return self._stage if self._number == 1 else f"{self._stage}, pass {self._number}", done, total


SILENT = Watch()
"""No progress is shown, and nothing cancels the run."""


def check_threads(threads: int | None) -> None:
    """Raises a KinemarkError where a number of threads is none; None leaves it to the machine."""
    if threads is not None and threads < 1:
        raise KinemarkError(f"threads is {threads}, wanted at least 1. Leave it out to use all processors.")
