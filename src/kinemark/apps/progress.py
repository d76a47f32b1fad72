"""How far a command is: bars on a terminal, a line now and then where the output goes to a file."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from .output import errors

if TYPE_CHECKING:  # NumPy comes with it, which --help does without
    from ..engine.progress import Progress

LINE_EVERY = 10.0
"""s between two lines of progress in a file; chosen: short against any wait that makes one look."""
BEATS = 10
"""Looks, between two lines, whether one is due though no step came; chosen: a line is late by a tenth at most."""


class ProgressLines:
    """Tells in lines how far each stage is and how long it will take, the first after `every` seconds.

    Args:
        write: takes a line.
        clock: s, of any origin.
        every: s between two lines.
    """

    def __init__(
        self, write: Callable[[str], None], *, clock: Callable[[], float] = time.monotonic, every: float = LINE_EVERY
    ) -> None:
        self._write, self._clock, self._every = write, clock, every
        self._one_at_a_time = threading.Lock()
        self._stage, self._before, self._total = "", 0, 0
        self._began = self._last_line = clock()

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Hear of a step."""
        now = self._clock()
        if stage != self._stage or done < self._before:
            self._stage, self._began = stage, now
        self._before, self._total = done, total
        self._line(f"{stage}: {done} of {total}{self._left(done, total, now)}", now)

    def beat(self) -> None:
        """Tell that it goes on, where no step came for long."""
        now = self._clock()
        where = f"{self._stage}: {self._before} of {self._total}," if self._stage else "at work:"
        self._line(f"{where} {now - self._began:.0f} s so far", now)

    def _line(self, line: str, now: float) -> None:
        """Write it, unless the one before was a moment ago."""
        with self._one_at_a_time:
            if now - self._last_line < self._every:
                return
            self._last_line = now
        self._write(line)

    def _left(self, done: int, total: int, now: float) -> str:
        """How long the stage will go on at the pace it has had; nothing where it has none yet."""
        if not 0 < done < total or now <= self._began:
            return ""
        return f", about {(now - self._began) * (total - done) / done:.0f} s left"


@contextmanager
def progress(*, every: float = LINE_EVERY) -> Iterator[Progress]:
    """Shows progress on the error stream.

    Args:
        every: s between two lines where the stream is no terminal.
    """
    if not errors().is_terminal:
        lines = ProgressLines(_print_line, every=every)
        with _beating(lines.beat, every / BEATS):
            yield lines
        return
    from rich import progress as bars  # only commands that take long need it

    columns = (
        bars.SpinnerColumn(),
        bars.TextColumn("{task.description:<12}"),
        bars.BarColumn(),
        bars.MofNCompleteColumn(),
        bars.TimeElapsedColumn(),
        bars.TextColumn("left:"),
        bars.TimeRemainingColumn(),
    )
    with bars.Progress(*columns, console=errors()) as shown:
        tasks: dict[str, bars.TaskID] = {}

        def tell(stage: str, done: int, total: int) -> None:
            if stage not in tasks or shown.tasks[tasks[stage]].completed > done:
                tasks[stage] = shown.add_task(stage, total=total)
            shown.update(tasks[stage], completed=done, total=total)

        yield tell


@contextmanager
def at_work(*, every: float = LINE_EVERY) -> Iterator[Callable[[str], None]]:
    """Takes what is being done now, and shows on the error stream that it goes on: what has no steps to count.

    Args:
        every: s between two lines where the stream is no terminal.
    """
    if errors().is_terminal:
        with errors().status("") as shown:
            yield lambda what: shown.update(what)
        return
    steps = [("at work", time.monotonic())]

    def beat() -> None:
        what, began = steps[-1]
        _print_line(f"{what}: {time.monotonic() - began:.0f} s so far")

    with _beating(beat, every):
        yield lambda what: steps.append((what, time.monotonic()))


@contextmanager
def _beating(beat: Callable[[], None], every: float) -> Iterator[None]:
    """Calls it every so many s in a thread of its own, until the block ends."""
    done = threading.Event()

    def go_on() -> None:
        while not done.wait(every):
            beat()

    thread = threading.Thread(target=go_on, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _print_line(line: str) -> None:
    errors().print(line, markup=False, highlight=False, soft_wrap=True)
