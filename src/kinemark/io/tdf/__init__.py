"""TDF, the file of BTS Bioengineering's systems: calibration, 2D, 3D, force plates, EMG and events of one trial.

The layouts stand in `docs/reference/files.md`. Those of plates, EMG and events are what BTS's own MATLAB readers and
the Biomechanical ToolKit (Barré and Armand, 2014) take them for, and were checked on a recorded gait trial.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...data import Analog, Detections, Events, ForcePlate, KinemarkError, Rig, Trajectories
from . import calibration_blocks, signal_blocks
from .cursor import Cursor, blocks

__all__ = ["TDF_PARTS", "Tdf", "read_tdf"]

TDF_PARTS = ("rig", "detections", "trajectories", "plates", "analog", "events")
"""What `read_tdf` can read, each unless `parts` leaves it out."""

RIG, DETECTIONS, TRAJECTORIES, PLATES, WRENCHES, EMG, EVENTS = 2, 4, 5, 7, 9, 11, 16  # codes of blocks; of the format


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
    """

    rig: Rig | None = None
    detections: Detections | None = None
    trajectories: Trajectories | None = None
    plates: tuple[ForcePlate, ...] = ()
    analog: tuple[Analog, ...] = ()
    events: Events = field(default_factory=Events)


def read_tdf(path: Path | str, *, parts: Collection[str] = TDF_PARTS) -> Tdf:
    """Read a TDF file.

    Lengths become mm; the world keeps the file's axes, in which **Y points up**. Cameras are called `cam1`, `cam2`, …
    after their physical channel, in the rig and in the detections alike. Force plates become C3D's type 1
    (frames and signs: `signal_blocks`), with `Fx1, Fy1, Fz1` N, `Px1, Py1` mm and `Mz1` N·m as their channels.

    Args:
        path: the file.
        parts: what to read; blocks that are not asked for are not looked at.

    Raises:
        ValueError: `parts` has a name that is not in `TDF_PARTS`.
        KinemarkError: the file is absent, empty, truncated, no TDF, or has a block of a format that is not read.
    """
    if unknown := set(parts) - set(TDF_PARTS):
        raise ValueError(f"parts has {sorted(unknown)}, wanted some of {', '.join(TDF_PARTS)}")
    # damaged files hold signalling NaN, which would warn before it is found and refused
    with np.errstate(invalid="ignore", over="ignore"):
        return checked(path, parsed(blocks(path), parts))


def parsed(found: Mapping[int, Cursor], parts: Collection[str]) -> Tdf:
    """The blocks that are there and asked for, in our records."""

    def block(kind: int, part: str) -> Cursor | None:
        return found.get(kind) if part in parts else None

    rig = calibration_blocks.rig(cursor) if (cursor := block(RIG, "rig")) else None
    detections = calibration_blocks.detections(cursor) if (cursor := block(DETECTIONS, "detections")) else None
    trajectories = signal_blocks.trajectories(cursor) if (cursor := block(TRAJECTORIES, "trajectories")) else None
    origin = 0.0 if trajectories is None else (trajectories.first_frame - 1) / trajectories.rate
    wrenches = signal_blocks.wrenches(cursor, origin) if (cursor := block(WRENCHES, "analog")) else None
    emg = signal_blocks.emg(cursor, origin) if (cursor := block(EMG, "analog")) else None
    return Tdf(
        rig=rig,
        detections=detections,
        trajectories=trajectories,
        plates=signal_blocks.plates(cursor, wrenches) if (cursor := block(PLATES, "plates")) else (),
        analog=tuple(analog for analog in (wrenches, emg) if analog is not None),
        events=signal_blocks.events(cursor) if (cursor := block(EVENTS, "events")) else Events(),
    )


def checked(path: Path | str, tdf: Tdf) -> Tdf:
    """The same, when its parts agree.

    Raises:
        KinemarkError: a time or a corner is not finite, or a camera that saw something is not calibrated.
    """
    numbers = [plate.corners for plate in tdf.plates] + [tdf.events.time]
    if not all(np.isfinite(a).all() for a in numbers) or not all(np.isfinite(a.start) for a in tdf.analog):
        raise KinemarkError(f"{path} has times or plate corners that are not finite. Export it again.")
    seeing = tdf.detections.cameras if tdf.detections is not None else ()
    if tdf.rig is not None and (lost := set(seeing) - set(tdf.rig.names)):
        raise KinemarkError(f"{path} has points of {sorted(lost)} but no calibration of them. Export it again.")
    return tdf
