"""The stage `track` of a trial's graph, in the ways that there are."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..data import Cloud, Detections, Finding, KinemarkError, Matches, Rig, Tracks
from ..digitise import identified_matches, identified_tracks
from ..findings.cameras import residuals
from ..geometry.ideal_pixels import check_cameras
from ..geometry.weighted_points import inside_volume
from ..io.files import write_text
from ..io.records import load, save
from ..reconstruct import LeastSquares, image_errors, reconstruct
from ..signal.common_time import moved_in_time
from ..track import track
from ..track.simultaneous import (
    AmbiguousDecision,
    Simultaneous,
    ambiguous_decisions,
    diagnose,
    diagnose_points,
    diagnose_tracks,
    track_detections,
    track_simultaneously,
)
from ..track.simultaneous.camera_strobes import diagnose_strobes
from ..track.simultaneous.diagnostics_of_points import points_left_out
from ..track.swamidas import Swamidas, diagnose_model, follow_points
from .calibration.task import Calibrated
from .camera_checks.camera_order import FITS_NOTHING, IN_PLACE_OF, images_of_others, put_in_order, told_in_order
from .camera_checks.dropped_images import dropped_images
from .camera_checks.pixel_axes import pixel_axes
from .camera_checks.start_times import APART, in_time, with_delays_to_state, with_start_times
from .camera_checks.told_delays import found_as_told, parts_of_images, told_delays
from .fill_files import angle_model
from .graph import Records, Stage
from .settings import Settings
from .sources import OperatorIdentities
from .trial_inputs import TrialInputs
from .trial_rig import TrialRig

Record = TypeVar("Record")
TRACKS, DECISIONS = "tracks.h5", "ambiguous_decisions.json"
SAME = 0.99
"""Of the images that confirm points, from which on two ways of tracking have about as many; chosen, as of delays that
are learned (`track.simultaneous.learned_delays`)."""


class Tracked(NamedTuple):
    """Tracks, the decisions of the tracker that were close, what it found of its input, and the cameras by which the
    points were solved; None where these are those of the stage `track`."""

    tracks: Tracks
    ambiguous_decisions: tuple[AmbiguousDecision, ...] = ()
    diagnostics: tuple[Finding, ...] = ()
    cameras: TrialRig | None = None


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
    tracked = _in_any_order(detections, rig, method, place, inputs.settings.match)
    told = told_by_calibration(inputs.calibrated, inputs.settings)
    tracked = _as_told(told, detections, rig, tracked, method, place)
    tracked = _without_dropped(detections, rig, method, place, tracked)
    late = with_delays_to_state(tracked.diagnostics, inputs.settings.cameras.delays_ms)
    own = inputs.source.of.entry.images is not None  # of its own centroids nobody can state another noise
    return tracked._replace(diagnostics=tuple(one for one in late if not own or one.kind != "noise_overstated"))


def _in_any_order(
    detections: Detections, rig: Rig, method: Simultaneous, place: LeastSquares, matching: Any
) -> Tracked:
    """Tracks of Kinemark's own tracker; of cameras in the wrong order, by the right one, where that fits better.

    Mirrored images of a ring are those of a ring in another order too, and would be tracked in a mirrored world.
    """
    tracked = _simultaneously(detections, rig, method, place)
    cloud = tracked.tracks.cloud
    images_of = images_of_others(tracked.diagnostics, detections, rig, cloud)
    if images_of and not pixel_axes(detections, rig, cloud, matching=matching, placing=place):
        ordered = put_in_order(rig, images_of)
        first = _simultaneously(detections, ordered, method, place)
        again = _at_any_start(detections, ordered, method, place, first)
        unlike = {name for one in again.diagnostics if one.kind in (IN_PLACE_OF, FITS_NOTHING) for name in one.cameras}
        if _confirmed(again.tracks) > _confirmed(tracked.tracks) and not unlike & images_of.keys():
            return again._replace(diagnostics=(*again.diagnostics, told_in_order(images_of)))
    return _at_any_start(detections, rig, method, place, tracked)


def _at_any_start(
    detections: Detections, rig: Rig, method: Simultaneous, place: LeastSquares, tracked: Tracked
) -> Tracked:
    """What was tracked; once again with cameras in time that were started apart, if more then fit."""
    cameras = TrialRig.given(rig) if tracked.cameras is None else tracked.cameras
    turned = {name for one in tracked.diagnostics if one.kind == "camera_put_right" for name in one.cameras}
    found = with_start_times(tracked.diagnostics, detections, _untouched(cameras.rig, rig, turned))
    apart = tuple(one for one in found if one.kind == "camera_started_apart")
    if not apart:
        return tracked
    again = _again(apart, detections, rig, method, place)
    either = turned & {name for one in apart for name in one.cameras}
    if either:  # who goes straight on is beside by the same offset, whether the camera was turned or is late
        better = _residual(again, in_time(apart, detections), either) < _residual(tracked, detections, either)
    else:
        better = _confirmed(again.tracks) >= _confirmed(tracked.tracks)
    return again if better else tracked


def told_by_calibration(calibrated: Calibrated, settings: Settings) -> dict[str, float]:
    """Delays, ms by camera, that the calibration tells and the session does not state."""
    return told_delays(calibrated.figures, settings.cameras.delays_ms)


def _as_told(
    told_ms: Mapping[str, float],
    detections: Detections,
    rig: Rig,
    tracked: Tracked,
    method: Simultaneous,
    place: LeastSquares,
) -> Tracked:
    """What was tracked; once again with cameras as late as at the calibration, if their images then fit better."""
    if not told_ms:
        return tracked
    again = _again(found_as_told(told_ms, detections), detections, rig, method, place)
    return again if _fits_better(again, tracked, detections, {*told_ms}) else tracked


def _without_dropped(
    detections: Detections, rig: Rig, method: Simultaneous, place: LeastSquares, tracked: Tracked
) -> Tracked:
    """What was tracked; once again with images behind those that a camera dropped in place, if they then fit better."""
    apart = tuple(one for one in tracked.diagnostics if one.kind in APART)
    late = {name for one in apart for name in one.cameras}
    dropped = dropped_images(in_time(apart, detections), rig, tracked.tracks.cloud, method=place)
    found = tuple(one for one in dropped if not late & {*one.cameras})
    if not found:
        return tracked
    again = _again((*apart, *found), detections, rig, method, place)
    names = {name for one in found for name in one.cameras}
    return again if _fits_better(again, tracked, detections, names) else tracked


def _again(
    found: tuple[Finding, ...], detections: Detections, rig: Rig, method: Simultaneous, place: LeastSquares
) -> Tracked:
    """Tracks with images in time by what was found of their cameras, which it says too."""
    part = parts_of_images(found, detections)
    moved = moved_in_time(in_time(found, detections), part[detections.camera])
    again = _simultaneously(moved, rig, method, place)
    cameras = again.cameras or TrialRig.given(rig)
    cameras = cameras._replace(delay=cameras.delay + part)
    return again._replace(diagnostics=(*again.diagnostics, *found), cameras=cameras)


def _fits_better(again: Tracked, before: Tracked, detections: Detections, names: Set[str]) -> bool:
    """Whether more images confirm points; of about as many, whether those of cameras of these names lie nearer."""
    more, less = _confirmed(again.tracks), _confirmed(before.tracks)
    if min(more, less) < SAME * max(more, less):
        return more > less
    beside, was = (_residual(one, in_time(one.diagnostics, detections), names) for one in (again, before))
    return beside < was


def puts_in_time(settings: Settings) -> bool:
    """Whether tracking tries images of cameras that were started apart in the frames that they show."""
    return isinstance(settings.track, Simultaneous) and isinstance(settings.reconstruct, LeastSquares)


def _untouched(rig: Rig, given: Rig, turned: Set[str]) -> Rig:
    """The cameras of a trial, those of these names turned back to where they were calibrated."""
    both = zip(rig, given, strict=True)
    cameras = (replace(was, distortion=one.distortion) if one.name in turned else one for one, was in both)
    return replace(rig, cameras=tuple(cameras))


def _residual(tracked: Tracked, detections: Detections, names: Set[str]) -> float:
    """px, the median by which images of cameras of these names lie beside their points."""
    cameras = tracked.cameras or TrialRig.given(Rig(()))
    offsets = residuals(cameras.rig, cameras.timed(detections), tracked.tracks.cloud)
    own = [one for one, camera in zip(offsets, cameras.rig, strict=True) if camera.name in names]
    off = np.linalg.norm(np.concatenate(own), axis=1)
    return float(np.nanmedian(off)) if np.isfinite(off).any() else np.inf


def _confirmed(tracks: Tracks) -> int:
    """Images beyond the two that make a point, which say that it is one: cameras apart make points of their own."""
    return int(np.maximum((tracks.cloud.detection >= 0).sum(1) - 2, 0).sum())


def _simultaneously(detections: Detections, rig: Rig, method: Simultaneous, place: LeastSquares) -> Tracked:
    """Tracks by Kinemark's own tracker, its decisions, and what it found."""
    margin = place.volume_margin if place.within_volume else None
    result = track_simultaneously(detections, rig, method, errors=image_errors(place), volume_margin=margin)
    volume = None if np.isnan(rig.volume).any() else rig.volume
    found = *diagnose(detections, rig, result), *diagnose_strobes(detections, rig)
    found += tuple(diagnose_points(result, method, margin, volume))
    return Tracked(result.tracks, tuple(ambiguous_decisions(result, method)), found, TrialRig.of_result(result))


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
