"""Kinemark's own tracker, and tracking once more where images belong to other cameras or frames than they say.

Cameras may be in another order than they were calibrated in, started whole images apart, as late as the wand's film
told, or have dropped images on the way. Each is tried where the tracks or the calibration give a reason, and kept where
more images then confirm points, or about as many lie nearer to them.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..data import Detections, Finding, Rig, Tracks
from ..data.array_types import Floats
from ..findings.cameras import residuals
from ..reconstruct import LeastSquares, image_errors
from ..signal.common_time import moved_in_time
from ..track.simultaneous import (
    AmbiguousDecision,
    Simultaneous,
    ambiguous_decisions,
    diagnose,
    diagnose_points,
    track_simultaneously,
)
from ..track.simultaneous.rig.camera_strobes import diagnose_strobes
from .camera_checks.camera_order import FITS_NOTHING, IN_PLACE_OF, images_of_others, put_in_order, told_in_order
from .camera_checks.dropped_images import dropped_images, shifts_to_ask
from .camera_checks.pixel_axes import pixel_axes
from .camera_checks.start_times import APART, in_time, with_start_times
from .camera_checks.told_delays import delays_learned, found_as_told, parts_of_images
from .settings import Settings
from .trial_rig import TrialRig

SAME = 0.99
"""Of the images that confirm points, from which on two ways of tracking have about as many; chosen, as of delays that
are learned (`track.simultaneous.learned_delays`). In short recordings chance is more."""


class Tracked(NamedTuple):
    """Tracks, the decisions of the tracker that were close, what it found of its input, and the cameras by which the
    points were solved; None where these are those of the stage `track`."""

    tracks: Tracks
    ambiguous_decisions: tuple[AmbiguousDecision, ...] = ()
    diagnostics: tuple[Finding, ...] = ()
    cameras: TrialRig | None = None


def in_any_order(
    detections: Detections,
    rig: Rig,
    method: Simultaneous,
    place: LeastSquares,
    matching: Any,
    told_ms: Mapping[str, float],
) -> Tracked:
    """Tracks of Kinemark's own tracker; of cameras in the wrong order, by the right one, where that fits better.

    Mirrored images of a ring are those of a ring in another order too, and would be tracked in a mirrored world.

    Args:
        matching: the method by which images are matched where the order is asked for.
        told_ms: delays that the calibration told.
    """
    tracked = _simultaneously(detections, rig, method, place)
    cloud = tracked.tracks.cloud
    images_of = images_of_others(tracked.diagnostics, detections, rig, cloud)
    if images_of and not pixel_axes(detections, rig, cloud, matching=matching, placing=place):
        ordered = put_in_order(rig, images_of)
        first = _simultaneously(detections, ordered, method, place)
        again = _in_time(detections, ordered, method, place, first, told_ms)
        unlike = {name for one in again.diagnostics if one.kind in (IN_PLACE_OF, FITS_NOTHING) for name in one.cameras}
        if _confirmed(again.tracks) > _confirmed(tracked.tracks) and not unlike & images_of.keys():
            return again._replace(diagnostics=(*again.diagnostics, told_in_order(images_of)))
    return _in_time(detections, rig, method, place, tracked, told_ms)


def _in_time(
    detections: Detections,
    rig: Rig,
    method: Simultaneous,
    place: LeastSquares,
    tracked: Tracked,
    told_ms: Mapping[str, float],
) -> Tracked:
    """What was tracked, or what is tracked with images of other frames in place, in each way that explains them."""
    tracked = _at_any_start(detections, rig, method, place, tracked)
    tracked = _as_told(told_ms, detections, rig, tracked, method, place)
    return _without_dropped(detections, rig, method, place, tracked)


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
        better = _nearer(again, tracked, detections, either)
    else:
        better = _confirmed(again.tracks) >= _confirmed(tracked.tracks)
    return again if better else tracked


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
    learned = delays_learned(again.diagnostics)
    if any(abs(learned.get(name, 0.0)) > abs(ms) / 2 for name, ms in told_ms.items()):
        return tracked  # the trial takes them back
    return again if _fits_better(again, tracked, detections, {*told_ms}) else tracked


def _without_dropped(
    detections: Detections, rig: Rig, method: Simultaneous, place: LeastSquares, tracked: Tracked
) -> Tracked:
    """What was tracked; once again with images behind those that a camera dropped in place, if they then fit better."""
    told, cameras = tracked.diagnostics, tracked.cameras or TrialRig.given(rig)
    apart = tuple(one for one in told if one.kind in APART)
    there, among = in_time(apart, detections), shifts_to_ask(detections, told, rig)
    found = tuple(dropped_images(there, cameras.timed(there), rig, tracked.tracks.cloud, among=among, told=told))
    if not found:
        return tracked
    again = _again((*apart, *found), detections, rig, method, place)
    dropped = {name for one in found for name in one.cameras}
    return again if _fits_better(again, tracked, detections, dropped) else tracked


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
    if abs(more - less) > max((1 - SAME) * max(more, less), np.sqrt(more + less)):  # by more than chance
        return more > less
    return _nearer(again, before, detections, names)


def _nearer(again: Tracked, before: Tracked, detections: Detections, names: Set[str]) -> bool:
    """Whether images of cameras of these names lie nearer to their points.

    The nearest of either, half as many as the most: else those that are lost, the farthest, would be a gain.
    """
    beside, was = (_offsets(one, in_time(one.diagnostics, detections), names) for one in (again, before))
    half = max(len(beside), len(was)) // 2
    return half < len(beside) and (half >= len(was) or bool(beside[half] < was[half]))


def puts_in_time(settings: Settings) -> bool:
    """Whether tracking tries images of cameras that were started apart in the frames that they show."""
    return isinstance(settings.track, Simultaneous) and isinstance(settings.reconstruct, LeastSquares)


def _untouched(rig: Rig, given: Rig, turned: Set[str]) -> Rig:
    """The cameras of a trial, those of these names turned back to where they were calibrated."""
    both = zip(rig, given, strict=True)
    cameras = (replace(was, distortion=one.distortion) if one.name in turned else one for one, was in both)
    return replace(rig, cameras=tuple(cameras))


def _offsets(tracked: Tracked, detections: Detections, names: Set[str]) -> Floats:
    """(n) px by which images of cameras of these names lie beside their points, the least first."""
    cameras = tracked.cameras or TrialRig.given(Rig(()))
    offsets = residuals(cameras.rig, cameras.timed(detections), tracked.tracks.cloud)
    own = [one for one, camera in zip(offsets, cameras.rig, strict=True) if camera.name in names]
    off = np.linalg.norm(np.concatenate(own), axis=1)
    return np.sort(off[np.isfinite(off)])


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
