"""What the stages of a trial are given, and its trajectories as several of them see it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..data import Detections, Fills, MarkerTrajectory, Rig, Tracks, Trajectories
from ..digitise import called
from ..edit import Edited
from ..fill import Filled, FilledGap
from ..fill.fill_recording import STATIC
from ..track import to_trajectories
from .calibration.task import Calibrated
from .camera_checks.start_times import in_time
from .graph import Records
from .naming import Earlier
from .settings import Settings
from .sources import TrialSource
from .store import Store
from .trial_rig import TrialRig


@dataclass(frozen=True, slots=True)
class TrialInputs:
    """What the stages of a trial are given besides each other's records.

    Attributes:
        name: of the trial; folder: of its results.
        settings: of the session.
        source: of the detections.
        calibrated: the cameras, and how good they are.
        store: of the results, which knows how the stages were done.
        threads: how many detection may use; None leaves it to the machine.
        assets: folder of what pages share; None where each page is to hold it.
        earlier: trials of the session by whose names this one's are found.
    """

    name: str
    folder: Path
    settings: Settings
    source: TrialSource
    calibrated: Calibrated
    store: Store
    threads: int | None = None
    assets: Path | None = None
    earlier: tuple[Earlier, ...] = ()

    @property
    def rig(self) -> Rig:
        """The cameras as they were calibrated, for stages up to tracking; those after it take `trial_rig`."""
        return self.calibrated.rig


def last_tracked(records: Records) -> Any:
    """What tracking gave, `tracking_stage.Tracked`: with what people said as facts, where they asked for it."""
    return records["retrack"] if "retrack" in records else records["track"]


def detections_of(records: Records) -> Detections:
    """What the cameras saw, where their pictures show it, in the frames by which it was tracked: those of cameras that
    were started apart moved."""
    return in_time(last_tracked(records).diagnostics, records["detect"])


def trial_rig(records: Records) -> TrialRig:
    """The cameras that the trial was reconstructed with."""
    cameras: TrialRig = records["track"].cameras
    return cameras


def seen_of(records: Records) -> Detections:
    """What the cameras saw, as the tracker had it in the end: at the times of the frames, where they fit."""
    return trial_rig(records).seen(detections_of(records))


def tracks_of(records: Records) -> Tracks:
    """The tracks, joined to markers where they were labelled."""
    tracks: Tracks = records["label"].tracks if "label" in records else last_tracked(records).tracks
    return tracks


def measured_of(inputs: TrialInputs, records: Records) -> Trajectories:
    """The trajectories as they were measured, named where an operator said how, or the labelling."""
    measured = to_trajectories(tracks_of(records), trial_rig(records).rig)
    measured = replace(measured, first_frame=inputs.source.of.first_frame)
    operated = inputs.source.operated()
    if operated is not None:
        return called(measured, operated.names, records["detect"].n_frames)
    if "label" in records:
        names = records["label"].names
        paths = tuple(replace(path, name=name) for path, name in zip(measured, names, strict=True))
        measured = replace(measured, paths=paths)
    return measured


def edits_of(inputs: TrialInputs, records: Records) -> Edited:
    """The trajectories as people said they are."""
    return records["edit"].edited if "edit" in records else Edited(measured_of(inputs, records))


def filled_of(inputs: TrialInputs, records: Records) -> Filled:
    """The trajectories with what was filled, and what became of every gap."""
    measured = edits_of(inputs, records).trajectories
    if "fill" not in records:
        return Filled(measured, ())
    fills: Fills = records["fill"]
    gaps = tuple(FilledGap(**json.loads(text)) for text in fills.gaps)
    return Filled(fills.on(with_placed(measured, gaps)), gaps)


def with_placed(measured: Trajectories, gaps: Sequence[FilledGap]) -> Trajectories:
    """The trajectories and, empty, those markers that were placed from a static trial alone."""
    new = [gap.marker for gap in gaps if gap.method == STATIC and gap.marker not in measured.names]
    nowhere = np.full((measured.n_frames, 3), np.nan)
    return replace(measured, paths=(*measured, *(MarkerTrajectory.measured(name, nowhere) for name in new)))
