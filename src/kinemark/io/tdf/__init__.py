"""TDF, the file of BTS Bioengineering's systems: calibration, 2D, 3D, force plates, EMG and events of one trial.

The layouts stand in `docs/reference/files.md`. Those of plates, EMG and events are what BTS's own MATLAB readers and
the Biomechanical ToolKit (Barré and Armand, 2014) take them for, and were checked on a recorded gait trial.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...data import Analog, Detections, Events, ForcePlate, KinemarkError, Rig, Trajectories, same
from ...data.trial import UP
from ..notes import UNREADABLE
from . import calibration_blocks, signal_blocks
from .cursor import Cursor, TdfFile, UnreadableBlock, open_tdf

__all__ = ["TDF_PARTS", "Tdf", "read_tdf"]

TDF_PARTS = ("rig", "detections", "trajectories", "plates", "analog", "events")
"""What `read_tdf` can read, each unless `parts` leaves it out."""

RIG, DETECTIONS, TRAJECTORIES, PLATES, WRENCHES, EMG, EVENTS = 2, 4, 5, 7, 9, 11, 16  # codes of blocks; of the format
KINDS = (RIG, DETECTIONS, TRAJECTORIES, PLATES, WRENCHES, EMG, EVENTS)
NAMES = {
    RIG: "the calibration of the cameras (block 2)",
    DETECTIONS: "the 2D points of the cameras (block 4)",
    TRAJECTORIES: "the tracks (block 5)",
    PLATES: "the force plates (block 7)",
    WRENCHES: "the forces of the plates (block 9)",
    EMG: "the EMG (block 11)",
    EVENTS: "the events (block 16)",
    3: "the 2D points of a calibration (block 3)",
    6: "the setup of the cameras (block 6)",
    8: "the 2D points of a calibration of plates (block 8)",
    10: "the subject's anthropometry (block 10)",
    12: "computed forces and torques (block 12)",
    13: "volumes (block 13)",
    14: "general-purpose channels (block 14)",
    15: "the calibration of general-purpose channels (block 15)",
}
"""What blocks hold; of the format. Those that are not in KINDS have a layout that is not read."""
RECORDED = (14,)
"""Blocks of those that hold what a trial recorded, and not how its system was set up or what follows from the rest; of
the format."""


@dataclass(frozen=True, slots=True, eq=False)
class Tdf:
    """What one TDF file holds; a part that it does not hold is None or empty.

    Attributes:
        rig: the calibrated cameras, with the control volume.
        detections: distorted centroids, all valid, of unknown covariance.
        trajectories: the tracked markers, mm.
        plates: force plates, type 1.
        analog: the plates' channels, then the EMG; each keeps its own rate, start and length.
        events: with their times, s.
        about: what else is known of the file: "date" it was made, UTC, labels of its plates, comments on its blocks,
            and "up", the axis that goes up in every TDF.
        notes: blocks that could not be read, and why; what was odd and how it was read.
    """

    rig: Rig | None = None
    detections: Detections | None = None
    trajectories: Trajectories | None = None
    plates: tuple[ForcePlate, ...] = ()
    analog: tuple[Analog, ...] = ()
    events: Events = field(default_factory=Events)
    about: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def read_tdf(path: Path | str, *, parts: Collection[str] | None = None, partial: bool = False) -> Tdf:
    """Read a TDF file.

    Lengths become mm; the world keeps the file's axes, in which **Y points up**. Cameras are called `cam1`, `cam2`, …
    after their physical channel, in the rig and in the detections alike. Force plates become C3D's type 1
    (frames and signs: `signal_blocks`), with `Fx1, Fy1, Fz1` N, `Px1, Py1` mm and `Mz1` N·m as their channels.

    Args:
        path: the file.
        parts: what to read; blocks that are not asked for are not looked at. Where it is not given, all that can be
            read is, and `notes` says what cannot.
        partial: read the blocks that are whole in a file that is cut off.

    Raises:
        ValueError: `parts` has a name that is not in `TDF_PARTS`.
        KinemarkError: the file is absent, empty, truncated, no TDF, or a block that `parts` asks for cannot be read,
            or none can.
    """
    if unknown := set(parts or ()) - set(TDF_PARTS):
        raise ValueError(f"parts has {sorted(unknown)}, wanted some of {', '.join(TDF_PARTS)}")
    # damaged files hold signalling NaN, which would warn before it is found and refused
    with np.errstate(invalid="ignore", over="ignore"):
        return checked(path, parsed(open_tdf(path, partial=partial), parts))


def parsed(file: TdfFile, parts: Collection[str] | None) -> Tdf:
    """The blocks that are there and asked for, in our records.

    Raises:
        KinemarkError: a block that is asked for cannot be read, or none can.
    """
    failed: dict[int, UnreadableBlock] = {}

    def block(kind: int, part: str, read: Callable[[Cursor], Any]) -> Any:
        cursor = file.blocks.get(kind) if parts is None or part in parts else None
        try:
            return None if cursor is None else read(cursor)
        except UnreadableBlock as error:
            if parts is not None:
                raise
            failed[kind] = error
            return None

    trajectories = block(TRAJECTORIES, "trajectories", signal_blocks.trajectories)
    origin = 0.0 if trajectories is None else (trajectories.first_frame - 1) / trajectories.rate
    wrenches = block(WRENCHES, "analog", lambda cursor: signal_blocks.wrenches(cursor, origin))
    emg = block(EMG, "analog", lambda cursor: signal_blocks.emg(cursor, origin))
    found = Tdf(
        rig=block(RIG, "rig", calibration_blocks.rig),
        detections=block(DETECTIONS, "detections", calibration_blocks.detections),
        trajectories=trajectories,
        plates=block(PLATES, "plates", lambda cursor: signal_blocks.plates(cursor, wrenches)) or (),
        analog=tuple(analog for analog in (wrenches, emg) if analog is not None),
        events=block(EVENTS, "events", signal_blocks.events) or Events(),
    )
    if failed and same(found, Tdf()):
        raise next(iter(failed.values()))
    if parts is not None:
        return found
    unread = [
        f"{NAMES.get(kind, f'the block of type {kind}')} is not read"
        for kind in file.blocks
        if kind not in (*KINDS, *RECORDED)
    ]
    odd = [note for kind in KINDS if kind in file.blocks for note in file.blocks[kind].notes]
    lost = [UNREADABLE + f"{NAMES[kind]}, as it {error.why}" for kind, error in failed.items()]
    lost += [UNREADABLE + f"{NAMES[kind]}, whose layout is not known" for kind in RECORDED if kind in file.blocks]
    return replace(found, about=_about(file), notes=(*lost, *odd, *unread))


def _about(file: TdfFile) -> dict[str, str]:
    """What a file says of itself."""
    cursor = file.blocks.get(PLATES)
    said = {**file.about, UP: "+Y"}
    if cursor is not None:
        with suppress(KinemarkError):
            labels = signal_blocks.plate_labels(replace(cursor, at=0))
            said |= {f"plate {i}": label for i, label in enumerate(labels, 1) if label}
    return said


def checked(path: Path | str, tdf: Tdf) -> Tdf:
    """The same, when its parts agree.

    Raises:
        KinemarkError: a camera that saw something is not calibrated.
    """
    seeing = tdf.detections.cameras if tdf.detections is not None else ()
    if tdf.rig is not None and (lost := set(seeing) - set(tdf.rig.names)):
        raise KinemarkError(f"{path} has points of {sorted(lost)} but no calibration of them. Export it again.")
    return tdf
