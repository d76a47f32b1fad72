"""Direction of progression, from which pelvis and feet are seen.

Plug-in Gait takes the horizontal axis of the laboratory nearest the way of the pelvis (1). The way itself counts where
it is not along an axis (2), as tilt, obliquity and rotation mix as soon as they are seen from aside. Where the pelvis
stays, as on a treadmill, it is that of the feet to and fro below it.

A subject may walk there and back, or round a corner, in one trial. Each part of the way that is straight
(`straight_passes`) has a direction of its own, as if it were a trial (3). Where the way bends, its direction is that
from half a second before a frame to half a second after, about a stride, in which sway cancels (4). Beside a straight
part the direction stays that part's as long as (4) is near it (5). Who walks backwards (`backwards`) is seen from where
the way comes from, as a subject that faces there (6).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data.array_types import Floats
from ..data.subject_measures import SIDES
from .backwards import parts_by_way, way_as_faced
from .lower_limb import LowerLimbs
from .segments import Z_UP, Segment, along_floor, unit
from .straight_passes import BEND_MM, WALKED_MM, Pass, straight_passes

ALONG_DEG = 5.0
"""Between way and axis of the laboratory, up to which the walkway is taken to lie along the axis, deg; chosen: a pelvis
that sways 40 mm turns a way of `WALKED_MM` by 3, and 10 of tilt seen 5 from aside are 0.9 of obliquity."""
HALF_S = 0.5
"""Half of the time over which the direction of a way that bends is taken, s; chosen: half of a stride."""
STANDING_MM = 250.0
"""Of way in both halves, below which the subject stands, or drifts on a treadmill, and the direction before or after
counts, mm; chosen: slow walkers have 400."""
TO_AND_FRO_MM = 100.0
"""Root mean square of the feet's way below the pelvis from which on it is walking, mm; chosen: a step of 0.4 m has
more."""
NEAR_DEG = 30.0
"""Between the way at a moment and a straight part beside it, up to which that part's direction counts, deg; chosen:
sway turns the way at a moment by up to 15."""


def progression(limbs: LowerLimbs) -> Floats:
    """(3, 3) forward, left and up of (1) as columns: a horizontal axis of the laboratory."""
    forward = _walked(limbs)
    if np.linalg.norm(forward) < WALKED_MM:
        forward = _faced(limbs)
    return _turned_to(_nearest_axis(forward))


def way_walked(limbs: LowerLimbs, *, rate: float) -> Floats:
    """(3, 3) forward, left and up of (2) as columns: the way, or the laboratory's axis within `ALONG_DEG` of it.

    Where the way turns or bends it is (F, 3, 3), of each frame (3) to (5); of who walks backwards by (6).

    Args:
        limbs: over frames. rate: frames a second.
    """
    forward = _walked(limbs)
    if _bends(limbs, forward) and (each := _at_each_moment(limbs, rate)) is not None:
        each = _with_passes(each, straight_passes(along_floor(limbs.pelvis.origin), rate=rate))
        return _turned_to(_as_faced(each, limbs.pelvis))
    sign = -1.0 if way_as_faced(limbs.pelvis) <= -WALKED_MM else 1.0  # (6)
    if np.linalg.norm(forward) < WALKED_MM:
        forward = sign * _stepped(limbs)
    if np.linalg.norm(forward) == 0:
        return progression(limbs)
    return _turned_to(sign * _along_axis(unit(forward)))


def _as_faced(each: Floats, pelvis: Segment) -> Floats:
    """(F, 3) directions of the way, turned about where the subject walks backwards (6): throughout, or where it faces
    against the way in a trial of both."""
    if len(parts := parts_by_way(pelvis)) == 1:
        return -each if parts[0].backwards else each
    against = (each * pelvis.R[..., 0]).sum(-1) < 0
    return np.where(against[:, None], -each, each)


def _along_axis(forward: Floats) -> Floats:
    """(3) of the laboratory's axis, where a direction is that near to it."""
    axis = _nearest_axis(forward)
    return axis if forward @ axis >= np.cos(np.radians(ALONG_DEG)) else forward


def _with_passes(each: Floats, passes: Sequence[Pass]) -> Floats:
    """(F, 3) directions of each moment, of straight parts theirs (3), and as far beside them as (5) has it."""
    out, bounds = each.copy(), [0, *(edge for one in passes for edge in (one.first, one.stop)), len(each)]
    for k, one in enumerate(passes):
        near = np.asarray(each @ one.direction >= np.cos(np.radians(NEAR_DEG)))
        before, after = near[bounds[2 * k] : one.first][::-1], near[one.stop : bounds[2 * k + 3]]
        first, stop = one.first - int(before.cumprod().sum()), one.stop + int(after.cumprod().sum())
        out[first:stop] = _along_axis(one.direction)
    return out


def _turned_to(forward: Floats) -> Floats:
    return np.stack([forward, np.cross(Z_UP, forward), np.broadcast_to(Z_UP, forward.shape)], -1)


def _bends(limbs: LowerLimbs, forward: Floats) -> bool:
    """Whether the pelvis walks and leaves the line between the ends of its way, or goes back along it."""
    at = along_floor(limbs.pelvis.origin)
    at = at[np.isfinite(at).all(-1)]
    if not len(at):
        return False
    line = unit(forward) if np.linalg.norm(forward) >= WALKED_MM else np.zeros(3)
    offset = at - at[0]
    far = np.linalg.norm(offset - np.outer(offset @ line, line), axis=1).max()
    back = (np.maximum.accumulate(offset @ line) - offset @ line).max()
    return bool(far > (BEND_MM if line.any() else WALKED_MM) or back > WALKED_MM)


def _at_each_moment(limbs: LowerLimbs, rate: float) -> Floats | None:
    """(F, 3) direction of the way (4); None where the subject stands, or drifts."""
    at = along_floor(limbs.pelvis.origin)
    frames = np.arange(len(at))
    seen = np.flatnonzero(np.isfinite(at).all(-1))
    early, late = (np.clip(frames + side * HALF_S * rate, seen[0], seen[-1]) for side in (-1, 1))
    way = np.stack([np.interp(late, seen, x) - np.interp(early, seen, x) for x in at[seen].T], -1)
    goes = np.flatnonzero(np.linalg.norm(way, axis=1) >= STANDING_MM)
    if not len(goes):
        return None
    nearest = np.round(np.interp(frames, goes, np.arange(len(goes)))).astype(int)
    return np.asarray(unit(way[goes[nearest]]))


def _nearest_axis(forward: Floats) -> Floats:
    """(3) of the laboratory."""
    k = int(np.abs(forward).argmax())
    return np.asarray(np.eye(3)[k] * (np.sign(forward[k]) or 1.0))


def _walked(limbs: LowerLimbs) -> Floats:
    """(3) mm along the floor, of the pelvis from its first to its last frame."""
    at = limbs.pelvis.origin
    seen = np.isfinite(at).all(-1)
    return along_floor(at[seen][-1] - at[seen][0] if seen.any() else np.zeros(3))


def _faced(limbs: LowerLimbs) -> Floats:
    """(3) along the floor, the mean of the pelvis' own x."""
    x = limbs.pelvis.R[..., 0]
    seen = np.isfinite(x).all(-1) & np.isfinite(limbs.pelvis.origin).all(-1)
    return along_floor(x[seen].mean(0) if seen.any() else np.zeros(3))


def _stepped(limbs: LowerLimbs) -> Floats:
    """(3) along the floor, in which feet go to and fro below the pelvis, as it faces; 0 where they stand."""
    apart = []
    for side in SIDES:
        foot = along_floor(limbs.leg(side).ankle - limbs.pelvis.origin)
        apart.append((foot := foot[np.isfinite(foot).all(-1)]) - (foot.mean(0) if len(foot) else 0.0))
    both = np.concatenate(apart)
    if not len(both):
        return np.zeros(3)
    _, size, axes = np.linalg.svd(both, full_matrices=False)
    if size[0] < TO_AND_FRO_MM * np.sqrt(len(both)):
        return np.zeros(3)
    return np.asarray(axes[0] * (np.sign(axes[0] @ _faced(limbs)) or 1.0))
