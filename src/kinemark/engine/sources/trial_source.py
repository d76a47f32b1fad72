"""What a source of detections is: anything that gives those of a trial, and what was recorded beside the cameras."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

from ...data import Detections, Finding, KinemarkError, Trajectories, Trial
from ...data.array_types import GreyLevels, Ints
from ...io.trial import read_trial
from ..keys import file_key
from .excerpt import cut
from .recording import Recording


class TrialSource(Protocol):
    """Where the detections of a trial come from."""

    @property
    def of(self) -> Recording:
        """What is recorded, and where."""
        ...

    def key(self) -> str:
        """Changes when the input does."""
        ...

    def detections(self, threads: int | None = None) -> Detections:
        """Reads or makes them."""
        ...

    def contradictions(self) -> tuple[Finding, ...]:
        """What contradicts itself in the input."""
        ...

    def beside(self) -> Trial | None:
        """Analog channels, force plates and events of the same recording, in a trial without markers."""
        ...

    def pictures(self, frames: Sequence[int]) -> list[GreyLevels] | None:
        """One image (H, W) of each camera, of the frames (C) asked for; None where there are no images."""
        ...

    def operated(self) -> OperatorIdentities | None:
        """Which marker each detection is, where an operator said it; then nothing is matched or tracked."""
        ...


class PlainSource:
    """What a source says that has no images, nothing recorded beside, no contradictions and no operator."""

    __slots__ = ()

    def contradictions(self) -> tuple[Finding, ...]:
        """None is known."""
        return ()

    def beside(self) -> Trial | None:
        """Nothing was recorded beside."""
        return None

    def pictures(self, frames: Sequence[int]) -> list[GreyLevels] | None:
        """There are no images."""
        return None

    def operated(self) -> OperatorIdentities | None:
        """Nobody did."""
        return None


@dataclass(frozen=True, slots=True)
class OperatorIdentities:
    """What an operator said of a trial.

    Attributes:
        names: (M) of its markers.
        marker: (D) the marker of each detection, −1 for none.
        figures: how much the operator had to do; empty where it is not known.
    """

    names: tuple[str, ...]
    marker: Ints
    figures: Mapping[str, Any]


def recorded_beside(source: TrialSource, rate: float) -> Trial | None:
    """The trial's `analog` file where it names one, else what its source holds besides, without markers.

    Args:
        source: of the trial. rate: frames a second of its cameras, which begin when the file does.

    Raises:
        KinemarkError: the file cannot be read, or holds nothing but markers.
    """
    of = source.of
    if of.entry.analog is None:
        return source.beside()
    read = read_trial(of.root / of.entry.analog)
    if not (read.analog or read.plates or len(read.events)):
        raise KinemarkError(
            f"{of.root / of.entry.analog} holds no channels, plates or events. Name another file as analog of trial "
            f"{of.entry.name!r}, or leave it out."
        )
    whole = replace(read, trajectories=Trajectories((), rate), source=None)
    return whole if of.frames is None else cut(whole, of.frames, rate)


def beside_key(source: TrialSource) -> str:
    """A key of the trial's `analog` file; empty where it names none."""
    of = source.of
    return "" if of.entry.analog is None else file_key(of.root / of.entry.analog)
