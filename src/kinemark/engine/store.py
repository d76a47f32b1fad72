"""Doing only what changed: every stage is written down with a key of all that it depends on.

The key of a stage is a hash of its name, its method and parameters, Kinemark's version and the key of its input, so
that a change anywhere makes new keys from there on. A stage whose key stands in `steps.json` and whose file is there is
read instead of computed. The file is written after every stage, and a run that was cut off goes on where it was.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..data import KinemarkError, Step
from ..io.files import replacing
from ..version import __version__

Record = TypeVar("Record")

STEPS = "steps.json"


def digest(*parts: Any) -> str:
    """A hash of plain values, arrays and dataclasses of them, the same on every machine."""
    h = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            h.update(f"{part.dtype.str}{part.shape}".encode())
            h.update(np.ascontiguousarray(part).tobytes())
        elif isinstance(part, bytes):
            h.update(part)
        else:
            h.update(json.dumps(part, sort_keys=True, default=str).encode())
        h.update(b"\0")
    return h.hexdigest()[:16]


def file_key(*paths: Path) -> str:
    """A key of files by name, size and time of change, which costs no reading of gigabytes of images."""
    seen = [(path.name, path.stat().st_size, path.stat().st_mtime_ns) for path in paths if path.is_file()]
    return digest(seen)


@dataclass(slots=True)
class Store:
    """The steps of one results folder.

    Attributes:
        folder: where the stages' files and `steps.json` are.
        old: steps of the last run by stage; steps: those of this run.
        computed: stages that had to be computed this time.
    """

    folder: Path
    old: dict[str, Step] = field(default_factory=dict)
    steps: list[Step] = field(default_factory=list)
    computed: list[str] = field(default_factory=list)

    @classmethod
    def open(cls, folder: Path) -> Store:
        """The ledger of a folder; one that is absent or unreadable counts as empty, and all is computed anew."""
        try:
            rows = json.loads((folder / STEPS).read_text("utf-8"))
            return cls(folder, {row["stage"]: Step(**row) for row in rows})
        except (OSError, ValueError, TypeError, KeyError):
            return cls(folder)

    def do(
        self,
        stage: str,
        method: Any,
        source: str,
        *,
        file: str,
        make: Callable[[], Record],
        save: Callable[[Path, Record], None],
        load: Callable[[Path], Record],
    ) -> tuple[Record, str]:
        """The record of a stage and its key: loaded where nothing changed, else made and saved.

        Args:
            stage: its name.
            method: a dataclass of parameters, or None.
            source: key of what goes in.
            file: where in the folder the record is.
            make: computes the record; save, load: write and read it.
        """
        parameters = {} if method is None else asdict(method)
        name = "" if method is None else type(method).__name__
        key = digest(stage, name, parameters, __version__, source)
        record, seconds = self._loaded(stage, key, file, load), 0.0
        if record is None:
            began = time.perf_counter()
            record = make()
            seconds = time.perf_counter() - began
            save(self.folder / file, record)
            self.computed.append(stage)
        else:
            seconds = self.old[stage].seconds
        self.steps.append(Step(stage, name, parameters, __version__, key, seconds))
        self._write()
        return record, key

    def stands(self, stage: str, key: str) -> bool:
        """Whether a stage was done with this key in the last run."""
        return stage in self.old and self.old[stage].input == key

    def note(self, stage: str, key: str) -> None:
        """Write down that a stage without a record of its own is done."""
        self.steps.append(Step(stage, "", {}, __version__, key, 0.0))
        self._write()

    def _loaded(self, stage: str, key: str, file: str, load: Callable[[Path], Record]) -> Record | None:
        """The record of an unchanged stage, or None where it must be made."""
        if not self.stands(stage, key) or not (self.folder / file).is_file():
            return None
        try:
            return load(self.folder / file)
        except KinemarkError:  # damaged since: what can be computed again need not stop the user
            return None

    def _write(self) -> None:
        """Steps of this run, and those of the last that it has not come to yet."""
        done = {step.stage for step in self.steps}
        rows = [asdict(step) for step in self.steps]
        rows += [asdict(step) for stage, step in self.old.items() if stage not in done]
        with replacing(self.folder / STEPS) as part:
            part.write_text(json.dumps(rows, indent=1), "utf-8")
