"""Images that a camera dropped within a recording, where it has fewer at the end than the others.

Each later image then stands too early in its camera, by an image or a few: that is a px or two where people walk, and
looks as if the camera had been touched. With X_f the points of frame f that two and more other cameras show, and image
f − s of the camera the one that shows them,

    cost(f, s) = Σ over X_f of min(d², REACH²)                            (1)

where d is the distance from the projection of a point to the nearest detection in that image; points that are near one
in none of these images are hidden from the camera, and left out. The shifts s_f that make
Σ cost(f, s_f) least, from none up to the images that the camera has fewer, and never back, follow by dynamic
programming (2). A step from frame to frame is where images were dropped, if the cost becomes less by more than chance,
the root of the sum of the squares of what it becomes less in each frame (3). A camera that stopped early has none. One
that steps in its first frames takes all its images later, and none is told of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from scipy.spatial import cKDTree

from ...data import Cloud, Detections, Finding, Rig, make_finding
from ...data.array_types import Floats, Ints
from ...geometry import project, triangulate
from ...geometry.camera import undistort_all
from .start_times import images_late

MOST = 10
"""Images that are looked for; chosen: a camera that drops more is of no use, and by more markers meet others."""
REACH = 5.0
"""px of (1); chosen: an image late moves who walks by less at 100 Hz, and who runs at 50 Hz by not much more."""
SURE = 3.0
"""Standard deviations by which the cost is less with steps (3); chosen: n frames after a step reach the root of n at
most, so that nine are enough. Whether it is kept is decided by tracking again."""
FEW = 100
"""Points from which something can be said; chosen."""


def dropped_images(
    detections: Detections,
    timed: Detections,
    rig: Rig,
    cloud: Cloud,
    *,
    among: Mapping[str, int],
    told: Sequence[Finding],
) -> Iterator[Finding]:
    """About cameras that dropped images, one for each place, frames from 0.

    Args:
        detections: images in the frames that they show, by what is told of cameras that were started apart.
        timed: the same rows, where they would be at the times of the frames.
        rig: the cameras. cloud: the points of the tracks. among: as `fewer_images` has it.
        told: what is told; images of a finding are counted with these.
    """
    for name, fewer in among.items():
        c = rig.names.index(name)
        frame, xyz = _by_others(cloud, timed, rig, c)
        if len(frame) >= FEW:
            cost = shift_costs(detections, rig, c, frame, xyz, fewer)
            end = int(detections.frame[detections.valid & (detections.camera == c)].max(initial=-1))
            cost[:, end + 1 :] = 0.0  # else a camera that stopped early would be thought to show the end
            yield from _findings(name, least_shifts(cost), cost, images_late(told, name, 0))


def fewer_images(recorded: Detections) -> dict[str, int]:
    """How many images each camera has fewer at the end than the others, 1 to MOST, by name."""
    counts = recorded.keep(recorded.valid).counts
    last = [int(np.flatnonzero(own)[-1]) if own.any() else -1 for own in counts]
    fewer = {name: max(last) - end for name, end in zip(recorded.cameras, last, strict=True) if end >= 0}
    return {name: n for name, n in fewer.items() if 0 < n <= MOST}


def shift_costs(detections: Detections, rig: Rig, c: int, frame: Ints, xyz: Floats, most: int) -> Floats:
    """(most + 1, F) px², by (1), of images of camera c that stand 0 … most frames too early, by points xyz (P, 3) mm of
    frames (P)."""
    uv, valid = project(rig[c], xyz), np.flatnonzero(detections.valid & (detections.camera == c))
    inside = np.flatnonzero(((uv >= 0) & (uv < rig[c].size)).all(1))
    apart = 4.0 * (max(rig[c].size) + REACH)  # images lie so far from each other that none is near the next
    tree = cKDTree(np.column_stack([detections.uv[valid], detections.frame[valid] * apart]))
    shifts, frame = np.arange(most + 1), frame[inside]
    place = [np.column_stack([uv[inside], (frame - s) * apart]) for s in shifts]
    d = np.minimum(tree.query(np.array(place), distance_upper_bound=REACH)[0], REACH)
    d[:, (d == REACH).all(0)] = 0.0  # hidden from the camera
    cost = np.zeros((most + 1, detections.n_frames))
    np.add.at(cost, (shifts[:, None], frame), d**2)
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


def _by_others(cloud: Cloud, timed: Detections, rig: Rig, c: int) -> tuple[Ints, Floats]:
    """Frames (P), and where they are (P, 3) mm, of points that two and more cameras show that are not c."""
    others = cloud.detection.copy()
    others[:, c] = -1
    rows = np.flatnonzero((others >= 0).sum(1) >= 2)
    uv = np.where((others[rows] >= 0)[..., None], timed.uv[others[rows]], np.nan)
    return cloud.frame[rows], triangulate(undistort_all(rig, uv), rig.P)


def _findings(name: str, shift: Ints, cost: Floats, before: int) -> Iterator[Finding]:
    """About each step of the shifts (F), where they lower the cost (S, F) enough; as many images are late before."""
    gain = cost[0] - cost[shift, np.arange(len(shift))]
    step = np.diff(shift, prepend=0)
    if step[: round(SURE**2)].any() or not gain.sum() > SURE * np.linalg.norm(gain):  # (3)
        return
    for f in np.flatnonzero(step).tolist():
        n, late = int(step[f]), before + int(shift[f])
        frames = [(max(f - n, 0), len(shift) - 1)]
        yield make_finding("camera_dropped_images", cameras=[name], frames=frames, dropped=n, images=late)
