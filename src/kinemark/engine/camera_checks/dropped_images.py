"""Images that a camera dropped within a recording, or has twice.

Each later image then stands too early in its camera, or too late, by an image or a few: that is a px or two where
people walk, and looks as if the camera had been touched. With X_f the points of frame f that two and more other cameras
show, and image f − s of the camera the one that shows them,

    cost(f, s) = Σ over X_f of min(d², REACH²)                            (1)

where d is the distance from the projection of a point to the nearest detection in that image; points that are near one
in none of these images are hidden from the camera, and left out. The shifts s_f that make
Σ cost(f, s_f) least, from none on and never back, follow by dynamic programming (2). A step from frame to frame is
where images were dropped, if the cost of what follows is less with it by more than chance, the root of the sum of the
squares of what it is less in each frame (3). A camera that stopped early has none. One that steps in its first frames,
in which a few images tell nothing, takes all its images later, as far as they tell: it was started apart (4). That is
only told of one with fewer images, or of which tracking has told something: what a calibration leaves looks like a
delay too.

Asked are cameras with fewer images at the end than the others, up to as many. Where tracking found some camera to be
beside, any may have dropped images and gone on for as many, so all are asked, both ways (5).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ...data import Cloud, Detections, Finding, Rig, make_finding
from ...data.array_types import Floats, Ints
from ...geometry import project, triangulate
from ...geometry.camera import undistort_all
from .start_times import SUSPICIOUS, dropped_since, images_late, started_apart

MOST = 10
"""Images that are looked for; chosen: a camera that drops more is of no use, and by more markers meet others."""
REACH = 5.0
"""px of (1); chosen: an image late moves who walks by less at 100 Hz, and who runs at 50 Hz by not much more."""
SURE = 3.0
"""Standard deviations by which the cost is less with steps (3); chosen: whether it is kept is decided by tracking
again."""
EARLY = round(SURE**2)
"""First frames in which a step is not told: so many reach SURE of (3) at most, by definition."""
FEW = 100
"""Points from which something can be said; chosen."""


class Shifts(NamedTuple):
    """Of a camera: s (F) of (2), and by how many px² the cost is less than without."""

    of: Ints
    gain: float


def dropped_images(
    detections: Detections,
    timed: Detections,
    rig: Rig,
    cloud: Cloud,
    *,
    among: Mapping[str, Sequence[range]],
    told: Sequence[Finding],
) -> Iterator[Finding]:
    """About cameras that dropped images, or have some twice, one for each place, frames from 0.

    Args:
        detections: images in the frames that they show, by what is told of cameras that were started apart.
        timed: the same rows, where they would be at the times of the frames.
        rig: the cameras. cloud: the points of the tracks. among: as `shifts_to_ask` has it.
        told: what is told; images of a finding are counted with these.
    """
    for name, each in among.items():
        c = rig.names.index(name)
        frame, xyz = _by_others(cloud, timed, rig, c)
        if len(frame) >= FEW:
            likeliest = max((_shifts(detections, rig, c, frame, xyz, one) for one in each), key=lambda one: one.gain)
            yield from _findings(name, likeliest.of, detections.rate, told, apart=len(each) == 1)


def shifts_to_ask(recorded: Detections, told: Sequence[Finding], rig: Rig) -> dict[str, tuple[range, ...]]:
    """The shifts to ask for of cameras, by name (5).

    Args:
        recorded: what the cameras saw. told: by tracking. rig: the cameras.
    """
    counts = recorded.keep(recorded.valid).counts
    last = [int(np.flatnonzero(own)[-1]) if own.any() else -1 for own in counts]
    fewer = {name: max(last) - end for name, end in zip(recorded.cameras, last, strict=True) if end >= 0}
    asked: dict[str, tuple[range, ...]] = {name: (_up_to(n),) for name, n in fewer.items() if 0 < n <= MOST}
    if any(one.kind in SUSPICIOUS for one in told):
        asked |= {name: (_up_to(MOST), _up_to(-MOST)) for name, n in fewer.items() if n == 0}
    since = dropped_since(told, recorded, rig)
    return asked | {name: (_up_to(n),) for name, n in since.items() if abs(n) > MOST}


def _up_to(n: int) -> range:
    """The shifts 0 … n, which may be below 0."""
    return range(n + 1) if n >= 0 else range(0, n - 1, -1)


def _shifts(detections: Detections, rig: Rig, c: int, frame: Ints, xyz: Floats, shifts: range) -> Shifts:
    """The likeliest of some shifts of camera c, by points xyz (P, 3) mm of frames (P)."""
    cost = shift_costs(detections, rig, c, frame, xyz, shifts)
    end = int(detections.frame[detections.valid & (detections.camera == c)].max(initial=-1))
    cost[:, end + 1 + min(shifts[-1], 0) :] = 0.0  # no image tells of these frames
    least = sure_steps(least_shifts(cost), cost)
    return Shifts(np.array(shifts)[least], float((cost[0] - cost[least, np.arange(len(least))]).sum()))


def shift_costs(detections: Detections, rig: Rig, c: int, frame: Ints, xyz: Floats, shifts: range) -> Floats:
    """(S, F) px², by (1), of images of camera c that stand so many (S) too early, by points xyz (P, 3) mm of frames
    (P)."""
    uv, valid = project(rig[c], xyz), np.flatnonzero(detections.valid & (detections.camera == c))
    inside = np.flatnonzero(((uv >= 0) & (uv < rig[c].size)).all(1))
    apart = 4.0 * (max(rig[c].size) + REACH)  # images lie so far from each other that none is near the next
    tree = cKDTree(np.column_stack([detections.uv[valid], detections.frame[valid] * apart]))
    frame = frame[inside]
    place = [np.column_stack([uv[inside], (frame - s) * apart]) for s in shifts]
    d = np.minimum(tree.query(np.array(place), distance_upper_bound=REACH)[0], REACH)
    d[:, (d == REACH).all(0)] = 0.0  # hidden from the camera
    cost = np.zeros((len(shifts), detections.n_frames))
    np.add.at(cost, (np.arange(len(shifts))[:, None], frame), d**2)
    return cost


def least_shifts(cost: Floats) -> Ints:
    """(F) the shifts of least cost (S, F) together that begin with none and never become less, by (2)."""
    total = np.where(np.arange(len(cost)) > 0, np.inf, 0.0)
    came = np.zeros(cost.shape, np.int64)
    for f, now in enumerate(cost.T):
        best = np.minimum.accumulate(total)
        came[:, f] = np.maximum.accumulate(np.where(total <= best, np.arange(len(cost)), 0))
        total = best + now
    shift = np.empty(cost.shape[1], np.int64)
    at = int(total.argmin())
    for f in range(cost.shape[1] - 1, -1, -1):
        shift[f] = at
        at = came[at, f]
    return shift


def sure_steps(shift: Ints, cost: Floats) -> Ints:
    """(F) the shifts without the steps that lower cost (S, F) by no more than chance (3)."""
    every = np.arange(len(shift))
    for f in np.flatnonzero(np.diff(shift, prepend=0))[::-1].tolist():
        without = shift - np.where(every >= f, shift[f] - (shift[f - 1] if f else 0), 0)
        less = cost[without, every] - cost[shift, every]
        shift = shift if less.sum() > SURE * np.linalg.norm(less) else without
    return shift


def _by_others(cloud: Cloud, timed: Detections, rig: Rig, c: int) -> tuple[Ints, Floats]:
    """Frames (P), and where they are (P, 3) mm, of points that two and more cameras show that are not c."""
    others = cloud.detection.copy()
    others[:, c] = -1
    rows = np.flatnonzero((others >= 0).sum(1) >= 2)
    uv = np.where((others[rows] >= 0)[..., None], timed.uv[others[rows]], np.nan)
    return cloud.frame[rows], triangulate(undistort_all(rig, uv), rig.P)


def _findings(name: str, shift: Ints, rate: float, told: Sequence[Finding], *, apart: bool) -> Iterator[Finding]:
    """About each step of the shifts (F) of a camera, beside what is told; whether it may be told by (4)."""
    before, step = images_late(told, name, 0), np.diff(shift, prepend=0)
    if step[:EARLY].any():  # (4)
        own = {one.kind for one in told if name in one.cameras}
        if (apart or own & {*SUSPICIOUS}) and not (before or "camera_delay_learned" in own):
            yield started_apart(name, int(shift[EARLY]), rate)
        return
    for f in np.flatnonzero(step).tolist():
        n = int(step[f])
        frames = [(max(f - max(n, 1), 0), len(shift) - 1)]
        yield make_finding(
            "camera_dropped_images", cameras=[name], frames=frames, dropped=n, images=before + int(shift[f])
        )
