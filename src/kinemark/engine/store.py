"""What was computed, kept in a folder and found again by its key.

`steps.json` says of every stage how it was done and under which key. A stage whose key stands there, and whose file is
there, is read instead of computed. The file is written after every stage, so a run that was cut off goes on where it
was. One process at a time works in a folder; another one waits. What a killed process left half-written is removed.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

from filelock import FileLock, Timeout

from ..data import KinemarkError, Step
from ..data.method import plain_parameters
from ..data.progress import Listener
from ..io.files import write_text
from ..version import __version__
from .keys import code_key

Record = TypeVar("Record")

STEPS = "steps.json"
WAITING = "wait for another run"
"""What is told as a stage while another process has the folder."""

PAUSE = 0.2
"""s between two looks whether another process is done; chosen."""


@dataclass(slots=True)
class Store:
    """The stages of one folder of results.

    Attributes:
        folder: where the stages' files and `steps.json` are.
        old: steps of earlier runs by stage; steps: those of this run.
        computed: stages that had to be computed this time.
    """

    folder: Path
    old: dict[str, Step] = field(default_factory=dict)
    steps: list[Step] = field(default_factory=list)
    computed: list[str] = field(default_factory=list)

    @classmethod
    def read(cls, folder: Path) -> Store:
        """What stands in a folder, to look at; one that is absent or unreadable counts as empty."""
        try:
            rows = json.loads((folder / STEPS).read_text("utf-8"))
            return cls(folder, {row["stage"]: Step(**row) for row in rows})
        except (OSError, ValueError, TypeError, KeyError):
            return cls(folder)

    @classmethod
    @contextmanager
    def open(cls, folder: Path, lock: Path, waiting: Listener) -> Iterator[Store]:
        """A folder's store, for this process alone while it holds `lock`; `waiting` is called while another has it.

        A folder that cannot be written is opened all the same: what is unchanged can be read.
        """
        with _alone(folder, lock, waiting):
            yield cls.read(folder)

    def do(
        self,
        stage: str,
        method: Any,
        key: str,
        *,
        files: tuple[str, ...],
        make: Callable[[], Record],
        save: Callable[[Path, Record], None],
        load: Callable[[Path], Record],
        in_place: bool = False,
        cameras: Mapping[str, Any] = MappingProxyType({}),
    ) -> Record:
        """The record of a stage: loaded where it is there under this key and can be read, else made and saved.

        Args:
            stage: its name.
            method: a record of parameters, or None; for `steps.json`.
            key: of all that the stage depends on.
            files: what the stage leaves in the folder; the first holds the record.
            make: computes the record; save, load: write and read it.
            in_place: `make` itself writes files, so that an earlier record counts no longer once it begins.
            cameras: methods of single cameras, by their names, for `steps.json` as well.
        """
        kept = self._kept(stage, key, files, load)
        if kept is not None:
            self.steps.append(self.old[stage])
            return kept[0]
        if in_place:
            self._forget(stage)
        began = time.perf_counter()
        record = make()
        seconds = time.perf_counter() - began
        self._forget(stage)
        save(self.folder / files[0], record)
        self.computed.append(stage)
        name = "" if method is None else type(method).__name__
        done = _parameters(method, cameras)
        self.steps.append(Step(stage, name, done, f"{__version__}+{code_key()}", key, seconds))
        self._write()
        return record

    def holds(self, stage: str, key: str, files: tuple[str, ...]) -> bool:
        """Whether a stage was done with this key and all its files are there."""
        done = stage in self.old and self.old[stage].input == key
        return done and all((self.folder / file).is_file() for file in files)

    def _kept(
        self, stage: str, key: str, files: tuple[str, ...], load: Callable[[Path], Record]
    ) -> tuple[Record] | None:
        """The record of an unchanged stage, in a tuple; None where it must be made."""
        if not self.holds(stage, key, files):
            return None
        try:
            return (load(self.folder / files[0]),)
        except KinemarkError:  # damaged since: what can be computed again need not stop the user
            return None

    def _forget(self, stage: str) -> None:
        """A stage counts as not done from now on: a file of one key must never stand under another."""
        if self.old.pop(stage, None) is not None:
            self._write()

    def _write(self) -> None:
        """Steps of this run, and those of the last that it has not come to yet."""
        done = {step.stage for step in self.steps}
        rows = [asdict(step) for step in self.steps]
        rows += [asdict(step) for stage, step in self.old.items() if stage not in done]
        write_text(self.folder / STEPS, json.dumps(rows, indent=1))


@contextmanager
def _alone(folder: Path, file: Path, waiting: Listener) -> Iterator[None]:
    """A folder for this process alone, without what killed processes left half-written."""
    lock = FileLock(file)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        _wait(lock, waiting)
    except OSError:  # read-only: nothing will be written, so nothing can be damaged
        yield
        return
    try:
        for part in folder.glob(".*.part*"):  # whoever wrote these is gone, since the lock was free
            with suppress(OSError):
                part.unlink()
        yield
    finally:
        lock.release()


def _wait(lock: FileLock, waiting: Listener) -> None:
    """Take a lock as soon as it is free; meanwhile the run can be cancelled."""
    while True:
        try:
            lock.acquire(timeout=0)
            return
        except Timeout:
            waiting(0, 1)
            time.sleep(PAUSE)


def _parameters(method: Any, cameras: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters of a method, and those of single cameras that differ."""
    usual = plain_parameters(method)
    own = {name: plain_parameters(one) for name, one in cameras.items()}
    differ = {name: {k: v for k, v in one.items() if v != usual.get(k)} for name, one in own.items()}
    return usual | ({"cameras": differ} if differ else {})


def load_figures(path: Path) -> dict[str, Any]:
    """Figures that an earlier run left as JSON.

    Raises:
        KinemarkError: the file is damaged.
    """
    try:
        return dict(json.loads(path.read_text("utf-8")))
    except (OSError, ValueError) as error:
        raise KinemarkError(f"{path} is damaged: {error}. Delete it.") from error
