"""Whether cameras of a trial that fit badly were started at another time, or dropped images, by whole images.

Delays below one frame the tracker learns. By more, a camera's images belong to other frames: few of them fit, and those
that fit by chance tell a wrong delay. `match.start_offsets` asks at which offset they fit best. A camera that fits
from one frame on no more, and does at another offset, has dropped images there. Who is apart, or dropped some, is moved
in time by whole images, and all is tracked again (`in_time`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from ...data import Detections, Finding, KinemarkError, Rig, make_finding
from ...data.array_types import Bools, Ints
from ...data.detections import Validity
from ...geometry.ideal_pixels import ideal_pixels
from ...match.start_offsets import agreement, start_offsets

SUSPICIOUS = (
    "camera_out_of_sync",
    "camera_fits_nothing",
    "camera_shifted",
    "camera_moved",
    "camera_put_right",
    "camera_in_doubt",
)
"""Findings of cameras whose images may belong to other frames, and that say so less well."""
APART = ("camera_started_apart", "camera_late_as_calibrated")
"""Findings of cameras whose images were put into the frames that they show."""
MOVED = (*APART, "camera_dropped_images")
"""The same, and of cameras that dropped some on the way."""
LATE = (*APART, "camera_delay_learned")
"""Findings of delays that tracking has reckoned with."""
MOST_S, MOST = 1.0, 100
"""Seconds, and frames at most, that cameras are looked for apart; chosen: `kinemark starts` looks farther."""
GOOD = 0.6
"""Of the agreement of cameras in time with one another, what a camera that is late must have with them; chosen:
images three and twenty late had 0.75 to 0.86, a camera that is calibrated 12 px off at its best 0.35."""
BETTER = 1.2
"""Times the agreement that a camera has as it is, what it must have with its images in time; chosen: images three late
of 16 scenes had 1.21 to 10, a camera in time that a crawling subject seems to be one image apart 0.98."""
FEW = 20
"""Frames, from which on offsets are looked for; chosen."""


def with_start_times(
    findings: Sequence[Finding], detections: Detections, rig: Rig, *, whole: bool = True
) -> tuple[Finding, ...]:
    """The findings of tracking, of cameras that are whole images apart by how many; others stay as they are.

    Args:
        findings: of the tracker, frames from 0.
        detections: what the cameras saw.
        rig: the cameras.
        whole: whether to ask for cameras apart in the whole trial; False where tracking has tried it, as images of a
            camera that was turned may look like those of other frames, but fewer of them fit there.
    """
    suspects = [one for one in findings if one.kind in SUSPICIOUS and one.cameras]
    if not suspects:
        return tuple(findings)
    found = [one for one in _apart(suspects, detections, rig) if whole or one.frames]
    known = {name for one in found for name in one.cameras}
    rest = (one for one in findings if not (one.kind in SUSPICIOUS and known & {*one.cameras}))
    return (*rest, *found)


def dropped_since(findings: Sequence[Finding], detections: Detections, rig: Rig) -> dict[str, int]:
    """How many images late (or early, below 0) cameras are, by name, of which a finding says that they fit from a frame
    on no more."""
    since = [one for one in findings if one.kind in SUSPICIOUS and one.frames and one.frames[0][0] > 0]
    return {one.cameras[0]: round(_number(one, "images")) for one in _apart(since, detections, rig) if one.frames}


def in_time(findings: Sequence[Finding], detections: Detections) -> Detections:
    """The detections with images in the frames that they show, of cameras that were started apart or dropped some.

    Their rows stay. Images of frames that were not recorded, in the first or last frame, and those that a camera has
    twice are not valid.

    Args:
        findings: with those about these cameras. detections: as recorded.
    """
    start, validity, n = detections.start.copy(), detections.validity.copy(), detections.n_frames
    image = detections.frame
    for name in sorted({name for one in findings if one.kind in MOVED for name in one.cameras}):
        c = detections.cameras.index(name)
        shown = np.array([f - images_late(findings, name, f) for f in range(n + 1)])
        rows = slice(*detections.start[c, [0, n]])
        validity[rows][~np.isin(image[rows], shown[:-1])] = Validity.MASKED
        start[c, 1:-1] = detections.start[c, np.maximum.accumulate(np.clip(shown, 0, n))[1:-1]]
    return replace(detections, start=start, validity=validity)


def images_late(findings: Sequence[Finding], name: str, frame: int) -> int:
    """How many images too early a camera's image of a frame, from 0, stands in the recording: it is that of frame less
    these."""
    own = [one for one in findings if one.kind in MOVED and name in one.cameras]
    since = [one for one in own if not one.frames or one.frames[0][0] < frame]
    return round(_number(max(since, key=lambda one: one.frames[0][0] if one.frames else -1), "images")) if since else 0


def with_delays_to_state(findings: Sequence[Finding], stated_ms: Mapping[str, float]) -> tuple[Finding, ...]:
    """The findings of cameras that are late, with the delay that is to be stated of each: all that is known of it.

    Args:
        findings: of tracking. stated_ms: delays that are stated, which those of the findings come on top of.
    """
    late = [one for one in findings if one.kind in LATE]
    whole = {
        name: stated_ms.get(name, 0.0) + sum(_number(one, "delay_ms") for one in late if name in one.cameras)
        for name in {name for one in late for name in one.cameras}
    }
    return tuple(
        replace(one, values={**one.values, "state_ms": whole[one.cameras[0]]}) if one.kind in LATE else one
        for one in findings
    )


def _number(found: Finding, name: str) -> float:
    return float(np.asarray(found.values[name], np.float64))


def _apart(suspects: Sequence[Finding], detections: Detections, rig: Rig) -> Iterator[Finding]:
    """By frame from which on it is so: about the cameras that are apart from most others."""
    known: set[str] = set()
    for since in sorted({one.frames[0][0] if one.frames else 0 for one in suspects}):
        names = {name for one in suspects for name in one.cameras if since == (one.frames or [(0, 0)])[0][0]}
        late = _late(detections.keep(detections.frame >= since), rig, detections.n_frames - since)
        for c in np.flatnonzero(late).tolist():
            if rig.names[c] in names - known:
                yield _finding(rig.names[c], int(late[c]), since, detections)
                known.add(rig.names[c])


def started_apart(name: str, late: int, rate: float) -> Finding:
    """About a camera that is late by so many images in the whole trial."""
    delay_ms = 1000.0 * late / rate
    return make_finding("camera_started_apart", cameras=[name], images=late, delay_ms=delay_ms, state_ms=delay_ms)


def _finding(name: str, late: int, since: int, detections: Detections) -> Finding:
    """About a camera that is late by so many images, in the whole trial or from a frame on."""
    if not since:
        return started_apart(name, late, detections.rate)
    frames = [(since, detections.n_frames - 1)]
    return make_finding("camera_dropped_images", cameras=[name], frames=frames, dropped=late, images=late)


def _late(detections: Detections, rig: Rig, frames: int) -> Ints:
    """(C) by how many images each camera is later than the median one; 0 where the markers do not tell."""
    most = int(min(MOST_S * detections.rate, MOST, frames // 2))
    seeing = [name for name, n in zip(detections.cameras, detections.counts.sum(1), strict=True) if n]
    if frames < FEW or most < 1 or len(seeing) < 3:
        return np.zeros(len(rig), np.int64)
    try:
        images = start_offsets(detections, rig, most=most).images
    except KinemarkError:
        return np.zeros(len(rig), np.int64)
    late = np.asarray(images - int(np.median(images)))
    return np.where(_as_good(late, detections, rig), late, 0)


def _as_good(late: Ints, detections: Detections, rig: Rig) -> Bools:
    """(C) whether the images of cameras that are late agree with those in time as well as these with one another."""
    uv, in_time = ideal_pixels(detections, rig), np.flatnonzero(late == 0).tolist()
    usual = [float(agreement(detections, rig, uv, a, b, 0)[0]) for a, b in combinations(in_time, 2)]
    good = np.zeros(len(rig), bool)
    for c in np.flatnonzero(late).tolist() if usual else []:
        own = [agreement(detections, rig, uv, a, c, abs(late[c]))[abs(late[c]) - late[c]] for a in in_time]
        as_is = [agreement(detections, rig, uv, a, c, 0)[0] for a in in_time]
        good[c] = np.median(own) > max(GOOD * np.median(usual), BETTER * np.median(as_is))
    return good
