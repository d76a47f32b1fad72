"""A run as a plain value, which can be sent to another process, and a process that does it and can be ended at once.

A job names its session by its folder, so that whoever gets it reads the settings and the answers as they are then.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path

from ..data import KinemarkError
from ..data.progress import Cancelled
from .open_trial import OpenTrial
from .progress import Cancel, Progress, silent
from .session import Session
from .sources import Frames


@dataclass(frozen=True, slots=True)
class Job:
    """A stage of a trial that shall be done, or the calibration alone.

    Attributes:
        session: the folder of the session, or its file.
        trial: its name; empty for the calibration alone.
        to: the stage to run to.
        overrides: methods and parameters instead of the file's, as "track.method=kiss_tracking".
        frames: first and last frame of a preview, counted from 1; None for what session.toml says.
        results: where everything computed goes; `results` in the session's folder where None.
        threads: how many detection may use; all processors where None.
    """

    session: Path
    trial: str
    to: str = "write"
    overrides: tuple[str, ...] = ()
    frames: Frames = None
    results: Path | None = None
    threads: int | None = None

    def run(self, *, progress: Progress = silent, cancel: Cancel | None = None) -> OpenTrial | None:
        """Do it here; None for the calibration alone.

        Raises:
            KinemarkError: the session or the trial cannot be used.
            Cancelled: `cancel` was set.
        """
        session = Session.open(self.session, overrides=self.overrides, results=self.results)
        if not self.trial:
            session.calibrate(progress=progress, cancel=cancel, threads=self.threads)
            return None
        trial = session.trial(self.trial)
        if self.frames is not None:
            trial = trial.preview(*self.frames)
        return trial.run(self.to, progress=progress, cancel=cancel, threads=self.threads)

    @property
    def words(self) -> str:
        """What it does, in words."""
        return f"trial {self.trial!r}" if self.trial else "the calibration"

    def start(self) -> RunningJob:
        """Do it in a process of its own."""
        context = multiprocessing.get_context("spawn")  # a fork would copy threads in the midst of their work
        here, there = context.Pipe(duplex=False)
        process = context.Process(target=_work, args=(self, there), daemon=True)
        process.start()
        there.close()
        return RunningJob(self, process, here)


@dataclass(frozen=True, slots=True)
class RunningJob:
    """A job in a process of its own.

    Attributes:
        job: what is done.
        process: where.
        heard: what it says.
    """

    job: Job
    process: BaseProcess
    heard: Connection

    def progress(self) -> Iterator[tuple[str, int, int]]:
        """The stage, how much of it is done, and how much there is, as they come, until the job ends.

        Raises:
            KinemarkError: the session or the trial cannot be used, or the process died.
            Cancelled: the job was cancelled.
        """
        while True:
            try:
                said = self.heard.recv()
            except (EOFError, OSError):
                self.process.join()
                if self.process.exitcode and self.process.exitcode < 0:
                    raise Cancelled(f"{self.job.words} was stopped; what was finished is kept") from None
                raise KinemarkError(f"The process of {self.job.words} ended without a word. Run it again.") from None
            if isinstance(said, Exception):
                self.process.join()
                raise said
            if said is None:
                self.process.join()
                return
            yield said

    def wait(self, *, progress: Progress = silent) -> None:
        """Until the job has ended; raises what `progress` raises."""
        for stage, done, total in self.progress():
            progress(stage, done, total)

    def cancel(self) -> None:
        """End it at once; what was finished is kept, nothing half-written counts."""
        self.process.terminate()
        self.process.join()


def _work(job: Job, connection: Connection) -> None:
    """What the process does."""
    try:
        job.run(progress=lambda *said: connection.send(said))
        connection.send(None)
    except (KinemarkError, Cancelled) as error:
        connection.send(error)
