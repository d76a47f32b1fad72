"""Tracking, and tracking again where the tracks show that a camera does not fit the others.

Lens terms that were lost from the rig's file are learned first (`missing_lens`), and images of strobes left out
(`camera_strobes`). Each time all is tracked with the delays that the cameras show (`learned_delays`). A camera is then
left out of the frames in which it fits the others no more (`unfitting_stretches`), or of all where it fits them nowhere
(`misfitting_cameras`), until nothing new is found. One that was turned, or knocked, since the calibration is put right
where the tracks of the others say how (`turned_camera`, `moved_cameras`, `shifted_stretches`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from ...data import Detections, Finding, Rig, Tracks, make_finding
from ...data.array_types import Floats
from ...geometry.weighted_points import DEFAULT_ERRORS, ImageErrors
from ..stage import DETECTIONS, TRACK
from .detection_index import read_images
from .learned_delays import SAME, track_with_delays
from .rig.camera_strobes import without_strobes
from .rig.misfitting_cameras import beside_tracks, image_offset
from .rig.missing_lens import missing_lenses
from .rig.moved_cameras import as_calibrated, moved_camera
from .rig.put_back import less_certain
from .rig.shifted_stretches import shifted_stretches
from .rig.turned_camera import put_right, with_camera
from .rig.unfitting_stretches import Stretch, is_followed, is_lost, unfitting_stretches, without_stretches
from .simultaneous_method import Simultaneous
from .tracker import ImageOffset, TrackingResult

_Track = Callable[[Detections, Rig], TrackingResult]
"""Tracks detections by cameras, in the way that the caller asks for."""

VOLUME_MARGIN = 100.0
"""mm outside the volume that a point may lie; chosen: markers of a subject within it may."""

NEARLY = 0.95
"""Of the points, the least that is left where a camera that lies beside the others is put right or left out; chosen
(scenes 481000 to 482009 of the second generator, a camera knocked): ghosts that it made with them are up to a
twentieth. Of 990000 to 995200, put right, 0.98 is left and more."""


@TRACK.method("simultaneous", Simultaneous, takes=DETECTIONS)
def simultaneous_tracks(detections: Detections, rig: Rig, *, method: Simultaneous) -> Tracks:
    """Tracks of all markers; called through `track_detections`."""
    return track_simultaneously(detections, rig, method).tracks


def track_simultaneously(
    detections: Detections,
    rig: Rig,
    method: Simultaneous,
    *,
    errors: ImageErrors = DEFAULT_ERRORS,
    volume_margin: float | None = VOLUME_MARGIN,
) -> TrackingResult:
    """Tracks of all markers, their points by the `errors` of images, and how they came about.

    Lens terms that were lost from the rig's file are learned (`missing_lens`). A camera is left out of the frames in
    which it fits the others no more (`unfitting_stretches`), or of all where it fits them nowhere
    (`misfitting_cameras`) and the others do not show how it was turned since (`turned_camera`). Points farther than
    `volume_margin` mm outside the rig's volume, where it has one, are left out and listed; None keeps all. So are
    images of the strobes of other cameras (`camera_strobes`).
    """
    track = partial(track_with_delays, method=method, errors=errors, volume_margin=volume_margin)
    lenses = missing_lenses(detections, rig)
    rig = rig if lenses is None else lenses.on(rig)
    detections = without_strobes(detections, rig)
    suspected, tried = unfitting_stretches(detections, rig), set[Stretch]()
    while True:
        result = track(without_stretches(detections, suspected), rig)
        tried |= {*suspected}
        sure = tuple(one for one in suspected if is_lost(one, result.tracks, result.images, detections, rig))
        beside = [Stretch(c, 0, detections.n_frames) for c in beside_tracks(result.tracks, result.images)]
        untried = [one for one in beside if one not in tried]
        if not sure and (hidden := _hidden_misfits(tried, detections, rig)):
            suspected = (hidden[0],)
        elif sure == suspected and not untried:
            if followed := _followed(suspected, detections, rig, track):
                suspected = tuple(one for one in suspected if one not in followed)
                continue
            doubtful = {one.camera for one in tried if one.whole(detections.n_frames) and not sure}
            result = result._replace(unfitting=suspected, lenses=lenses, doubtful=tuple(sorted(doubtful)))
            right = _with_put_right(result, detections, rig, track)
            return _without_shifted(right, detections, right.rig, track)
        else:
            suspected = sure if sure != suspected else _with(sure, untried[0])


def _followed(suspected: tuple[Stretch, ...], detections: Detections, rig: Rig, track: _Track) -> list[Stretch]:
    """Those of parts of the recording in which tracks that are made with the camera go on."""
    parts = [one for one in suspected if not one.whole(detections.n_frames)]
    if not parts:
        return []
    rest = tuple(one for one in suspected if one not in parts)
    tracks = track(without_stretches(detections, rest), rig).tracks
    return [one for one in parts if is_followed(one, tracks, detections)]


def _hidden_misfits(tried: set[Stretch], detections: Detections, rig: Rig) -> list[Stretch]:
    """Cameras that fit nowhere, untried, behind stretches of others, or their own, in which none is lost."""
    cameras, n = {one.camera for one in tried if not one.whole(detections.n_frames)}, detections.n_frames
    found = unfitting_stretches(detections, rig, cameras) if cameras else ()
    return [one for one in found if one.whole(n) and one not in tried]


def _with(stretches: tuple[Stretch, ...], whole: Stretch) -> tuple[Stretch, ...]:
    """The same and a whole recording, which holds other stretches of its camera."""
    return tuple(sorted((whole, *(one for one in stretches if one.camera != whole.camera))))


def _without_shifted(result: TrackingResult, detections: Detections, rig: Rig, track: _Track) -> TrackingResult:
    """Tracks again with cameras put right that lie beside the others; without them, where few points need them.

    Beside two or three others a camera shares most of its points with one of them alone. There it stays, and its noise
    as the images have it says how far off points may be.
    """
    found = shifted_stretches(detections, rig, result)
    whole, within = (
        {one: said for one, said in found.items() if bool(said.frames) == since} for since in (False, True)
    )
    if whole:
        again = _left_out(result, whole, detections, rig, track)
        result = _most_points(_with_put_right(again, detections, rig, track), result)
    if within:
        moved = _with_moved(result, within, detections, result.rig, track)
        result = _most_points(moved or _left_out(result, within, detections, result.rig, track), result)
    return result


def _most_points(again: TrackingResult, before: TrackingResult) -> TrackingResult:
    """What was tracked again, where it has nearly as many points."""
    return again if len(again.tracks.cloud) >= NEARLY * len(before.tracks.cloud) else before


def _left_out(
    result: TrackingResult, found: Mapping[Stretch, Finding], detections: Detections, rig: Rig, track: _Track
) -> TrackingResult:
    """Tracks again without cameras in these stretches."""
    left = tuple(sorted((*result.unfitting, *found)))
    again = track(without_stretches(detections, left), rig)
    return _of_same(result, again)._replace(unfitting=left, shifted=(*result.shifted, *found.values()))


def _of_same(result: TrackingResult, again: TrackingResult) -> TrackingResult:
    """What was tracked again, with what is known of the cameras."""
    same = ("unfitting", "lenses", "put_right", "doubtful", "shifted", "moved")
    return again._replace(**{name: getattr(result, name) for name in same})


def _with_moved(
    result: TrackingResult, found: Mapping[Stretch, Finding], detections: Detections, rig: Rig, track: _Track
) -> TrackingResult | None:
    """Tracks again with images of cameras that were knocked within the recording where they would have been.

    None where the points of the others cannot tell, or they do not fit then.
    """
    alone = {Stretch(one.camera, 0, detections.n_frames): said for one, said in found.items()}
    others = _left_out(result, alone, detections, rig, track).tracks
    tried = [moved_camera(one, _offset(said), others, detections, rig) for one, said in found.items()]
    back = [one for one in tried if one is not None]
    if len(back) < len(tried):
        return None
    moved = tuple(one.moved for one in back)
    again = track(without_stretches(as_calibrated(detections, rig, moved), result.unfitting), rig)
    if {*beside_tracks(again.tracks, again.images)} & {one.camera for one in moved}:
        return None
    said = (*result.shifted, *(_put_right(one) for one in found.values()))
    return _of_same(result, less_certain(again, back))._replace(moved=moved, shifted=said)


def _put_right(one: Finding) -> Finding:
    """What is said of a camera that was shifted, once it was put right."""
    u, v = _offset(one).tolist()
    return make_finding("camera_put_right", cameras=one.cameras, frames=one.frames, offset_u_px=u, offset_v_px=v)


def _offset(one: Finding) -> Floats:
    """(2) px by which the images of a camera that was shifted lie beside."""
    return np.array([one.values[f"offset_{axis}_px"] for axis in "uv"], np.float64)


def _with_put_right(result: TrackingResult, detections: Detections, rig: Rig, track: _Track) -> TrackingResult:
    """Tracks again with the cameras that were left out of the whole recording, or fit nothing, and can be put right.

    The same where there are none, or where they do not fit then.
    """
    turned = list[ImageOffset]()
    whole = {one.camera for one in result.unfitting if one.whole(detections.n_frames)}
    known = {one.cameras[0]: _offset(one) for one in result.shifted}
    for c in sorted(whole | {*result.noise.inconsistent.tolist()}):
        offset = known.get(rig.names[c])
        if offset is None:
            offset = image_offset(c, result.tracks, read_images(detections, rig))
        if offset is None or np.isnan(offset).any():
            continue
        if (right := put_right(c, offset, result.tracks, detections, rig)) is not None:
            rig, turned = with_camera(rig, c, right.camera), [*turned, ImageOffset(c, *offset.tolist())]
    if not turned:
        return result
    own = [one.camera for one in turned]
    left = tuple(one for one in result.unfitting if one.camera not in own)
    again = track(without_stretches(detections, left), rig)
    others = np.delete(np.arange(len(rig)), own)
    seen, before = ((one.tracks.cloud.detection[:, others] >= 0).sum() for one in (again, result))
    if seen < SAME * before or {*beside_tracks(again.tracks, again.images)} & {*own}:
        return result
    shifted = tuple(one for one in result.shifted if rig.names.index(one.cameras[0]) not in own)
    turned = [*result.put_right, *turned]
    return again._replace(unfitting=left, lenses=result.lenses, put_right=tuple(turned), shifted=shifted)
