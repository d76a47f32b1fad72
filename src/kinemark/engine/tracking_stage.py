"""The stage `track` of a trial's graph, in the ways that there are."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..data import Cloud, Detections, Finding, KinemarkError, Matches, Tracks
from ..digitise import identified_matches, identified_tracks
from ..geometry.ideal_pixels import check_cameras
from ..geometry.weighted_points import inside_volume
from ..io.files import write_text
from ..io.records import load, save
from ..reconstruct import LeastSquares, reconstruct
from ..track import track
from ..track.simultaneous import (
    AmbiguousDecision,
    Simultaneous,
    diagnose_tracks,
    track_detections,
)
from ..track.simultaneous.diagnosis.diagnostics_of_points import points_left_out
from ..track.swamidas import Swamidas, diagnose_model, follow_points
from .calibration.task import Calibrated
from .camera_checks.start_times import with_delays_to_state
from .camera_checks.told_delays import told_delays
from .fill_files import angle_model
from .graph import Records, Stage
from .settings import Settings
from .sources import OperatorIdentities
from .tracking_in_time import Tracked, in_any_order
from .trial_inputs import TrialInputs
from .trial_rig import TrialRig

Record = TypeVar("Record")
TRACKS, DECISIONS = "tracks.h5", "ambiguous_decisions.json"


class Tracking(NamedTuple):
    """What the ways of tracking have in common: the files that they leave."""

    files: tuple[str, ...]

    def stage(
        self,
        compute: Callable[[TrialInputs, Records], Tracked],
        needs: tuple[str, ...],
        method: Any,
        given: tuple[Any, ...],
    ) -> Stage[TrialInputs]:
        """The stage `track`, done in this way."""
        return Stage("track", needs, self.files, compute, save_tracked, load_tracked, method, given)


def as_operated(inputs: TrialInputs, records: Records) -> Tracked:
    """Tracks of the markers that an operator named."""
    detections, operated = records["detect"], inputs.source.operated()
    assert isinstance(operated, OperatorIdentities)
    check_cameras(detections, inputs.rig)
    matches = identified_matches(detections, operated.marker)
    cloud = reconstruct(matches, detections, inputs.rig, method=inputs.settings.reconstruct)
    tracks = identified_tracks(cloud, operated.marker)
    outside = tuple(_left_outside(inputs, matches, detections, operated, tracks))
    return Tracked(tracks, diagnostics=outside, cameras=TrialRig.given(inputs.rig))


def _left_outside(
    inputs: TrialInputs, matches: Matches, detections: Detections, operated: OperatorIdentities, tracks: Tracks
) -> Iterator[Finding]:
    """About named markers outside the control volume, which would else look as if nobody had seen them."""
    out = _outside(inputs, matches, detections, len(tracks.cloud))
    if out is not None:
        gone = set(identified_tracks(out, operated.marker).id.tolist()) - set(tracks.id.tolist())
        names = [operated.names[m] for m in sorted(gone)]
        yield _told_outside(inputs, out, len(tracks.cloud), names)


def _outside(inputs: TrialInputs, matches: Matches, detections: Detections, kept: int) -> Cloud | None:
    """The points that were left out as they lie outside the control volume, where so many were kept; None if none."""
    method: Any = inputs.settings.reconstruct  # every one has a volume
    rig = inputs.rig
    if not method.within_volume or np.isnan(rig.volume).any() or kept == len(matches.frame):
        return None
    whole = reconstruct(matches, detections, rig, method=replace(method, within_volume=False))
    out = ~inside_volume(whole.xyz, rig.volume, margin=method.volume_margin)
    return whole.keep(out) if out.any() else None


def _told_outside(inputs: TrialInputs, out: Cloud, kept: int, names: Iterable[str] = ()) -> Finding:
    """About these points, beside which so many were kept; the names are those of which nothing is left."""
    method: Any = inputs.settings.reconstruct
    return points_left_out(out.xyz, kept, method.volume_margin, inputs.rig.volume, names)


def from_detections(inputs: TrialInputs, records: Records) -> Tracked:
    """Tracks straight from the detections; Kinemark's own tracker lists its ambiguous decisions."""
    detections, rig = records["detect"], inputs.rig
    method, place = inputs.settings.track, inputs.settings.reconstruct
    check_cameras(detections, rig)
    if not isinstance(method, Simultaneous) or not isinstance(place, LeastSquares):
        tracks = track_detections(detections, rig, method=method)
        return Tracked(tracks, (), tuple(diagnose_tracks(detections, rig, tracks)), TrialRig.given(rig))
    told_ms = told_by_calibration(inputs.calibrated, inputs.settings)
    tracked = in_any_order(detections, rig, method, place, inputs.settings.match, told_ms)
    late = with_delays_to_state(tracked.diagnostics, inputs.settings.cameras.delays_ms)
    own = inputs.source.of.entry.images is not None  # of its own centroids nobody can state another noise
    return tracked._replace(diagnostics=tuple(one for one in late if not own or one.kind != "noise_overstated"))


def told_by_calibration(calibrated: Calibrated, settings: Settings) -> dict[str, float]:
    """Delays, ms by camera, that the calibration tells and the session does not state."""
    return told_delays(calibrated.figures, settings.cameras.delays_ms)


def from_points(inputs: TrialInputs, records: Records) -> Tracked:
    """Tracks of points that were matched before."""
    method = with_angle_model(inputs.settings.track, inputs.source.of.root)
    found = list[Finding]()
    if isinstance(method, Swamidas):
        followed = follow_points(records["reconstruct"], method=method)
        tracks, found = followed.tracks, [*diagnose_model(followed.model)]
    else:
        tracks = track(records["reconstruct"], method=method)
    found += diagnose_tracks(records["detect"], inputs.rig, tracks)
    out = _outside(inputs, records["match"], records["detect"], len(records["reconstruct"]))
    if out is not None:
        found.append(_told_outside(inputs, out, len(records["reconstruct"])))
    return Tracked(tracks, (), tuple(found), TrialRig.given(inputs.rig))


def with_angle_model(method: Any, root: Path) -> Any:
    """The method with the angle model that it names, read from a file in or beside the session's folder.

    Raises:
        KinemarkError: the file is absent or damaged, or there is no cycle in the trial that it holds.
    """
    if not isinstance(method, Swamidas) or method.model is not None or method.angle_model in (None, "own"):
        return method
    return replace(method, model=angle_model(root / method.angle_model))


def save_tracked(path: Path, record: Tracked) -> None:
    """The tracks, and beside them what was ambiguous, and the cameras."""
    decisions = [decision.as_dict() for decision in record.ambiguous_decisions]
    found = [one.as_dict() for one in record.diagnostics]
    said: dict[str, Any] = {"ambiguous_decisions": decisions, "diagnostics": found}
    if record.cameras is not None:
        said["cameras"] = record.cameras.as_dict()
        record.cameras.save(path.parent)
    write_text(_beside(path), json.dumps(said, indent=1, ensure_ascii=False) + "\n")
    save(path, record.tracks)


def load_tracked(path: Path) -> Tracked:
    """What an earlier run left; damaged files count as none."""
    try:
        said = json.loads(_beside(path).read_text("utf-8"))
        unsure = tuple(map(AmbiguousDecision.of, said["ambiguous_decisions"]))
        cameras = TrialRig.load(path.parent, said["cameras"]) if path.name == TRACKS else None
        return Tracked(reader(Tracks)(path), unsure, tuple(map(Finding.of, said["diagnostics"])), cameras)
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise KinemarkError(f"{_beside(path)} is damaged: {error}. Delete it.") from error


def _beside(path: Path) -> Path:
    """The file of what was ambiguous, and of the cameras' times, beside that of tracks."""
    return path.with_name(DECISIONS) if path.name == TRACKS else path.with_suffix(".json")


def reader(kind: type[Record]) -> Callable[[Path], Record]:
    """Reads a record of this kind, and takes any other for a damaged file."""

    def read(path: Path) -> Record:
        record = load(path)
        if not isinstance(record, kind):
            raise KinemarkError(f"{path} holds {type(record).__name__}, wanted {kind.__name__}. Delete it.")
        return record

    return read
