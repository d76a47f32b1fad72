"""What a run shows of its input: cameras that were moved, swapped, shifted or stopped, and a rate that cannot be.

Each camera is compared with what all the others together say: `shifted_cameras` (1), (2), (7) to (9) and (11).
Where the images of most cameras lie beside the others', it is the calibration that fits no better (10).
A camera without any image has stopped only where it misses markers that it saw before: when the subject has left, what
still lies about may never have been in its sight (5). Nor has one that was as long without images before: few markers
turn away from it now and then (6).
A camera whose images fit nothing may be another one's: its images are tried with the calibration of each other (3).
Images that lie where the marker was, or will be, show a camera that is not synchronous (`time_offsets`).
A rate that is wrong changes all speeds by one factor, which no image tells; only one that makes people faster than they
are is seen (4). Half of the true rate goes unnoticed.
A rig without any lens term may be of cameras that have none, or of a calibration that left them out (`missing_lens`):
where the terms were lost they are used; else it should be calibrated again (12). Noise that is stated OVERSTATED times
as large as it is counts as unstated (13). A wet floor shows markers once more, below it (`mirror_images`) (14).
"""

from __future__ import annotations

import numpy as np

from ....data import Detections, Finding, Rig, make_finding
from ....data.array_types import Bools, Floats, Ints
from ....data.finding import red_if
from ....numerics.finite import finite_median
from ..detection_index import read_images
from ..following.initiate import LEAST_FRAMES
from ..noise.measurement_noise import MIN_FOUND_SHARE, OVERSTATED
from ..rig.misfitting_cameras import image_offset, is_confirmed
from ..rig.shifted_cameras import (
    FEW,
    PARTS,
    expected_places,
    images_fit_nothing,
    in_view,
    least_shifts,
    nearest_images,
    parts_of_recording,
    shifted,
    usual_offsets,
)
from ..times.time_offsets import MIN_SHIFT, TimeOffsets, time_offsets
from ..tracker import CameraTimes, ImageOffset, TrackingResult
from .mirror_images import mirror_images

MAX_SPEED = 15_000.0
"""mm/s; markers on people hardly move faster than the hand of a thrower; chosen (see benchmarks/tracking.py)."""

MISFIT_SD = 1.0
"""px of standard deviation, from which on images that need lens terms make a trial useless (12); chosen, as markers at
the edge of a view are then lost or several px off."""


def diagnose(detections: Detections, rig: Rig, result: TrackingResult) -> list[Finding]:
    """What is odd about the input, cameras by the rig as given; nothing where nothing is."""
    rig = result.rig
    found, late = [], _not_synchronous(detections, rig, time_offsets(result))
    parts = [parts_of_recording(result, c) for c in range(len(rig))]
    least = least_shifts(result, parts)
    lost = {c: _left_out(c, result, detections, rig) for c in {one.camera for one in result.unfitting}}
    lost |= {rig.names.index(name): [one] for one in result.shifted for name in one.cameras}
    turned = {one.camera: [_put_right(one, rig)] for one in result.put_right}
    for c, name in enumerate(rig.names):
        found += (
            lost.get(c)
            or turned.get(c)
            or _without_images(detections, result, c)
            or late.get(c)
            or shifted(result, c, name, parts[c], least[c])
            or _in_no_track(result, c, name)
            or _doubtful(result, c, name)
        )
    found += _calibration_off(rig, usual_offsets(result, parts), late)
    told = {*lost, *np.flatnonzero(_valid_counts(detections).sum(1) == 0).tolist()}
    found += [_inconsistent_camera(result, rig, c) for c in result.noise.inconsistent.tolist() if c not in told]
    if 0 < detections.n_frames < LEAST_FRAMES and len(detections):
        return [*found, make_finding("too_few_frames", frame_count=detections.n_frames, least=LEAST_FRAMES)]
    return (
        found
        + _lenses(rig, result)
        + _overstated(detections, result)
        + _learned_delays(rig, result)
        + _too_fast(result, detections.rate)
        + _mirrored(result)
    )


def _left_out(c: int, result: TrackingResult, detections: Detections, rig: Rig) -> list[Finding]:
    """About a camera that was left out as it fits the others in some frames, or in none."""
    own, name = [one for one in result.unfitting if one.camera == c], rig.names[c]
    if not any(one.whole(detections.n_frames) for one in own):
        return [make_finding("camera_moved", cameras=[name], frames=[(one.first, one.stop - 1) for one in own])]
    images = read_images(detections, rig)
    offset = image_offset(c, result.tracks, images)
    if offset is None or np.isnan(offset).any():
        return [_inconsistent_camera(result._replace(images=images), rig, c)]
    u, v = offset
    return [make_finding("camera_shifted", cameras=[name], offset_u_px=u, offset_v_px=v, left_out=True)]


def _put_right(one: ImageOffset, rig: Rig) -> Finding:
    """About a camera that was turned until it fitted the others."""
    return make_finding("camera_put_right", cameras=[rig.names[one.camera]], offset_u_px=one.u, offset_v_px=one.v)


def _lenses(rig: Rig, result: TrackingResult) -> list[Finding]:
    """About lens terms that the rig does not state, though its images need them, or states of images without (12)."""
    lenses = result.lenses
    if lenses is None:
        return []
    if not lenses.radial.any():
        return [make_finding("lens_terms_taken_out", cameras=rig.names, sd_px=lenses.sd)]
    k1 = tuple(round(float(k), 3) for k in lenses.radial)
    severity = red_if(not lenses.lost and lenses.sd > MISFIT_SD)
    return [
        make_finding(
            "lens_terms_unstated", severity=severity, cameras=rig.names, lost=lenses.lost, sd_px=lenses.sd, k1_list=k1
        )
    ]


def _overstated(detections: Detections, result: TrackingResult) -> list[Finding]:
    """About centroids that state far more noise than the images have (13)."""
    stated, seen = np.sqrt(result.images.usual), np.sqrt(finite_median(result.noise.seen, np.inf))
    if not np.isfinite(detections.cov[:, 0, 0]).any() or result.images.stated or stated < OVERSTATED * seen:
        return []
    return [make_finding("noise_overstated", stated_px=stated, seen_px=seen)]


def _learned_delays(rig: Rig, result: TrackingResult) -> list[Finding]:
    """About cameras that were tracked with times of their own."""
    ms = CameraTimes(*(1000 * each for each in result.times))
    late = [
        make_finding(
            "camera_delay_learned",
            cameras=[rig.names[c]],
            delay_ms=ms.delay[c],
            delay_se_ms=ms.delay_error[c],
            state_ms=ms.delay[c],
        )
        for c in np.flatnonzero(ms.delay).tolist()
    ]
    late += [
        make_finding("camera_uneven_times", cameras=[rig.names[c]], uneven_ms=ms.unsteady[c])
        for c in np.flatnonzero(ms.unsteady).tolist()
    ]
    return late + [
        make_finding(
            "camera_rolling_shutter",
            cameras=[rig.names[c]],
            readout_ms=2 * ms.line[c],
            readout_se_ms=2 * ms.line_error[c],
        )
        for c in np.flatnonzero(ms.line).tolist()
    ]


def _mirrored(result: TrackingResult) -> list[Finding]:
    """About tracks that are images in a mirror (14)."""
    images = mirror_images(result.tracks, result.rig)
    return [make_finding("tracks_mirrored", markers=[f"*{k + 1}" for k in images])] if len(images) else []


def _not_synchronous(detections: Detections, rig: Rig, found: TimeOffsets) -> dict[int, list[Finding]]:
    """About cameras that see at other times than the others, under their numbers."""
    return {
        c: [
            make_finding(
                "camera_out_of_sync",
                cameras=[rig.names[c]],
                delay_ms=found.delay[c] / detections.rate * 1000,
                delay_frames=found.delay[c],
                shift_px=found.shift[c],
            )
        ]
        for c in np.flatnonzero(found.significant).tolist()
    }


def _without_images(detections: Detections, result: TrackingResult, c: int) -> list[Finding]:
    """About a camera without images at the end, or the beginning, of the recording, though markers were in its view."""
    n, some, name = detections.n_frames, np.flatnonzero(_valid_counts(detections)[c]), [detections.cameras[c]]
    if not n or not len(some):
        return [make_finding("camera_without_images", cameras=name)] if n else []
    inside = in_view(result, c, expected_places(result, c), min(2, len(detections.cameras) - 1))
    should = result.tracks.cloud.frame[inside & _of_tracks_seen(result, c)]
    found, long = [], max(n / PARTS, 2 * np.diff(some, prepend=some[0]).max())  # (6)
    if n - some[-1] > long and (should > some[-1]).sum() >= FEW:
        found.append(make_finding("camera_stopped", cameras=name, frames=[(some[-1] + 1, n - 1)], recorded_frames=n))
    if some[0] > long and (should < some[0]).sum() >= FEW:
        found.append(make_finding("camera_started_late", cameras=name, frames=[(0, some[0] - 1)], recorded_frames=n))
    return found


def _valid_counts(detections: Detections) -> Ints:
    """(C, F) valid images a camera and frame."""
    return detections.keep(detections.valid).counts


def _of_tracks_seen(result: TrackingResult, c: int) -> Bools:
    """(P) points of tracks of which camera c has an image at some time (5)."""
    cloud, ids = result.tracks.cloud, result.tracks.id
    return np.isin(ids, ids[cloud.detection[:, c] >= 0])


def _calibration_off(rig: Rig, usual: Floats, late: dict[int, list[Finding]]) -> list[Finding]:
    """About a calibration by which the images of most cameras lie beside the others', usual (C) px (10)."""
    if (middle := finite_median(usual, 0.0)) <= MIN_SHIFT or late:
        return []
    names = [rig.names[c] for c in np.flatnonzero(usual > MIN_SHIFT)]
    return [make_finding("calibration_off", cameras=names, offset_px=middle)]


def _in_no_track(result: TrackingResult, c: int, name: str) -> list[Finding]:
    """About a camera that has images, about as many as markers that it should see, and hardly any in a track (2)."""
    cut = len(result.outside) > len(result.tracks.cloud)  # by the volume: its images may be of these
    if cut or c in result.noise.inconsistent or not images_fit_nothing(result, c, 0):
        return []
    should = in_view(result, c, expected_places(result, c), 2).sum()
    has = (result.images.usable & (result.images.camera == c)).sum()
    return [make_finding("camera_fits_nothing", cameras=[name], left_out=False)] if has > should / 2 > FEW / 2 else []


def _doubtful(result: TrackingResult, c: int, name: str) -> list[Finding]:
    """About a camera that hardly fits the others, and that too few points confirm."""
    if c not in result.doubtful or is_confirmed(c, result.tracks, result.images):
        return []
    return [make_finding("camera_in_doubt", cameras=[name])]


def _inconsistent_camera(result: TrackingResult, rig: Rig, c: int) -> Finding:
    """About a camera whose images fit nothing: which other one it might be (3)."""
    cloud, images = result.tracks.cloud, result.images
    found = np.zeros(len(rig))
    for other in range(len(rig)):
        uv = expected_places(result, other)
        inside = ((uv >= 0) & (uv < images.size[c])).all(1)
        if inside.any():
            found[other] = (nearest_images(images, cloud.frame[inside], c, uv[inside]) >= 0).mean()
    best = int(found.argmax())
    if best != c and found[best] > 2 * MIN_FOUND_SHARE:
        return make_finding("camera_takes_place_of_other", cameras=[rig.names[c], rig.names[best]], left_out=True)
    return make_finding("camera_fits_nothing", cameras=[rig.names[c]], left_out=True)


def _too_fast(result: TrackingResult, rate: float) -> list[Finding]:
    """About speeds that nobody has (4)."""
    cloud, ids = result.tracks.cloud, result.tracks.id
    order = np.lexsort([cloud.frame, ids])
    xyz, frame, ids = cloud.xyz[order], cloud.frame[order], ids[order]
    next_one = (np.diff(ids) == 0) & (np.diff(frame) == 1)
    speed = np.linalg.norm(np.diff(xyz, axis=0)[next_one], axis=1) * rate
    if not len(cloud) and not len(result.outside) and (result.noise.found > MIN_FOUND_SHARE).any():
        return [make_finding("nothing_goes_on", rate_hz=rate)]
    if len(speed) < FEW or np.percentile(speed, 99) < MAX_SPEED:
        return []
    return [make_finding("speeds_impossible", speed_m_s=np.percentile(speed, 99) / 1000, rate_hz=rate)]
