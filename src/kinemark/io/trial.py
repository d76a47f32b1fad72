"""The one way from any file of trajectories to a trial, and back."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from ..data import KinemarkError, Tracks, Trajectories, Trial
from ..data.track_trajectories import trajectories_of
from .formats import ReadOptions, endings, holds, read_file, write_file
from .notes import FileNote
from .tdf import Tdf


def read_trial(
    path: Path | str, *, rate_hz: float | None = None, length_unit: str | None = None, partial: bool = False
) -> Trial:
    """The trial in a file: C3D, TDF, TRC, TSV of Qualisys, CSV of trajectories, a record in HDF5, or UM²AS's TDC.

    Args:
        path: the file.
        rate_hz: frames a second, where the file is silent or wrong about it; not of TDF and HDF5.
        length_unit: "mm", "cm", "m" or "in", where the file is silent or wrong about it; not of TDF, HDF5 and our CSV.
        partial: read what there is of a file that is cut off or damaged; the trial's notes say what is not. HDF5 has
            no parts that could be read.

    Raises:
        KinemarkError: the file is absent, damaged, of no known kind, holds something else, or states no possible rate.
            Or it states itself what the caller states.
    """
    path = Path(path)
    if rate_hz is not None and not 0 < rate_hz < math.inf:
        raise KinemarkError(f"The rate is {rate_hz} Hz. Wanted is one above 0.")
    found = read_file(path, ReadOptions(rate_hz, length_unit, partial, "trajectories"))
    trial = trial_in(path.stem, found)
    if trial is None:
        odd = "".join(f" {note}" for note in getattr(found, "notes", ()))
        raise KinemarkError(
            f"{path} holds {holds(found)} and no trajectories. Wanted is a file that has some, with one of the endings "
            f"{', '.join((*endings('trajectories'), '.tdf'))}.{odd}"
        )
    if not 0 < trial.trajectories.rate < math.inf:
        raise KinemarkError(f"{path} states a rate of {trial.trajectories.rate:g} Hz. Give it one above 0.")
    return trial


def trial_in(name: str, found: Any) -> Trial | None:
    """The trial that a record is or has; None where it has none."""
    if isinstance(found, Trial):
        return found
    if isinstance(found, Trajectories):
        return Trial(name, found)
    if isinstance(found, Tracks):
        return Trial(name, trajectories_of(found))
    if isinstance(found, Tdf) and found.trajectories is not None:
        return Trial(
            name, found.trajectories, found.analog, found.plates, found.events, about=found.about, notes=found.notes
        )
    return None


def write_trial(trial: Trial, path: Path | str) -> tuple[FileNote, ...]:
    """Write a trial in the format that the ending names; returns what that format could not hold. HDF5 holds all.

    Raises:
        KinemarkError: no format of trajectories has that ending, the trial's rate is not above 0, it has no markers or
            no frames and the format holds nothing else, or the file cannot be written.
    """
    rate = trial.trajectories.rate
    if not 0 < rate < math.inf:
        raise KinemarkError(
            f"The trial has a rate of {rate:g} Hz, with which no file can be read. Give it one above 0."
        )
    return write_file(Path(path), "trajectories", trial)
