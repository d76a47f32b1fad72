"""What was recorded beside the cameras: force plates, EMG and other channels, events."""

from __future__ import annotations

from dataclasses import replace

from ...data import KinemarkError, Trajectories, Trial
from ...io.trial import read_trial
from ..keys import file_key
from .excerpt import cut
from .trial_source import TrialSource


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
