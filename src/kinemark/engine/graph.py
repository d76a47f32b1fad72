"""A graph of stages: what each needs, how it is done, and under which key its record is kept.

A stage is addressed by its name. To run to a stage is to do all that it needs, in order, each from its file where
nothing changed. The key of a stage is made of the package's sources, its name, its method, what else it is given, and
the keys of the stages that it needs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeVar

from ..data import KinemarkError
from ..data.progress import listening, tell
from .keys import code_key, digest
from .progress import Watch
from .store import Store

Inputs = TypeVar("Inputs")

Records = Mapping[str, Any]
"""The records of stages by their names."""


@dataclass(frozen=True, slots=True)
class Stage(Generic[Inputs]):
    """A stage of a graph over inputs.

    Attributes:
        name: as commands, settings and messages call it.
        needs: names of the stages whose records it is computed from.
        files: what it leaves in the folder of results; the first holds its record.
        compute: its record, from the inputs and the records of the stages that it needs.
        save, load: write and read the record; load raises KinemarkError where the file is damaged.
        method: the method and its parameters, a record; None where there is no choice.
        given: what else it depends on, for its key.
        in_place: whether `compute` itself writes files.
        cameras: methods of single cameras, by their names, in place of `method`.
    """

    name: str
    needs: tuple[str, ...]
    files: tuple[str, ...]
    compute: Callable[[Inputs, Records], Any]
    save: Callable[[Path, Any], None]
    load: Callable[[Path], Any]
    method: Any = None
    given: tuple[Any, ...] = ()
    in_place: bool = False
    cameras: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Graph(Generic[Inputs]):
    """Stages, each after those that it needs."""

    stages: tuple[Stage[Inputs], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The stages in order."""
        return tuple(stage.name for stage in self.stages)

    def to(self, name: str) -> tuple[Stage[Inputs], ...]:
        """A stage and all that it needs, in order.

        Raises:
            KinemarkError: there is no such stage.
        """
        if name not in self.names:
            raise KinemarkError(f"There is no stage {name!r} here; there are {', '.join(self.names)}.")
        wanted = {name}
        for stage in reversed(self.stages):
            wanted |= set(stage.needs) if stage.name in wanted else set()
        return tuple(stage for stage in self.stages if stage.name in wanted)

    def keys(self, name: str) -> dict[str, str]:
        """The keys of a stage and of all that it needs."""
        keys: dict[str, str] = {}
        for stage in self.to(name):
            parts = (stage.name, type(stage.method).__name__, stage.method, dict(stage.cameras), stage.given)
            keys[stage.name] = digest(code_key(), *parts, [keys[need] for need in stage.needs])
        return keys

    def run(self, name: str, inputs: Inputs, store: Store, watch: Watch) -> dict[str, Any]:
        """The records of a stage and of all that it needs, in a store that is open.

        Raises:
            KinemarkError: an input cannot be used.
            Cancelled: the watch says so; what was finished before is kept.
        """
        records: dict[str, Any] = {}
        keys = self.keys(name)
        for stage in self.to(name):
            with listening(watch.of(stage.name)):
                tell(0, 1)
                records[stage.name] = store.do(
                    stage.name,
                    stage.method,
                    keys[stage.name],
                    files=stage.files,
                    make=partial(stage.compute, inputs, records),
                    save=stage.save,
                    load=stage.load,
                    in_place=stage.in_place,
                    cameras=stage.cameras,
                )
                tell(1, 1)
        return records
