"""Angles of the gait model as clinicians read them.

Each is the rotation of a segment in another, taken apart as Rᵧ(a) Rₓ(b) R_z(c):

    pelvis, hip, knee            flexion a, adduction b, rotation c                                             (1)
    ankle, foot progression      a, c, b                                                                        (2)

with signs such that flexion, dorsiflexion, adduction and internal rotation are positive on both sides, forward tilt and
the side's own pelvis upwards and forwards too (3); the ankle is at 0° where the foot stands square to the shank (4).
Pelvis and foot are seen from the direction of progression: the horizontal axis of the laboratory nearest the way (5),
as Plug-in Gait has it; or the way itself where it is not along an axis (6), as tilt, obliquity and rotation mix as soon
as they are seen from aside. The way is that of the pelvis; where it stays, as on a treadmill, that of the feet to and
fro below it. Where it bends it is that from half a second before each frame to half a second after, about a stride, in
which sway cancels (7).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..data.subject_measures import LETTER, SIDES, TO_THE_LEFT, Side
from ..kinematics import principal
from .lower_limb import FOOT_SEQUENCE, LowerLimbs
from .segments import Z_UP, relative, unit, within_half_turn

WALKED_MM = 800.0
"""Path of the pelvis below which its own x is the direction of progression, mm; conventional (Plug-in Gait)."""
ALONG_DEG = 5.0
"""Between way and axis of the laboratory, up to which the walkway is taken to lie along the axis, deg; chosen: a pelvis
that sways 40 mm turns a way of `WALKED_MM` by 3, and 10 of tilt seen 5 from aside are 0.9 of obliquity."""
BEND_MM = 100.0
"""By which a way leaves the line between its ends, from which on it bends, mm; chosen: a pelvis sways by up to 50."""
HALF_S = 0.5
"""Half of the time over which the direction of a way that bends is taken, s; chosen: half of a stride."""
STANDING_MM = 250.0
"""Of way in both halves, below which the subject stands, or drifts on a treadmill, and the direction before or after
counts, mm; chosen: slow walkers have 400."""
TO_AND_FRO_MM = 100.0
"""Root mean square of the feet's way below the pelvis from which on it is walking, mm; chosen: a step of 0.4 m has
more."""


class Reading(NamedTuple):
    """How an angle follows from a, b, c: which of them, with which sign on the left, and plus what in deg."""

    name: str
    axes: tuple[str, str, str]
    of: tuple[int, int, int]
    sign: tuple[float, float, float]
    plus: float = 0.0


READINGS = (
    Reading("Pelvis", ("tilt", "obliquity", "rotation"), (0, 1, 2), (1, 1, -1)),
    Reading("Hip", ("flexion", "adduction", "rotation"), (0, 1, 2), (-1, -1, -1)),
    Reading("Knee", ("flexion", "adduction", "rotation"), (0, 1, 2), (1, -1, -1)),
    Reading("Ankle", ("dorsiflexion", "adduction", "rotation"), (0, 2, 1), (-1, -1, -1), -90.0),
    Reading("FootProgress", ("pitch", "progression", "roll"), (0, 2, 1), (1, 1, -1)),
)
"""(1) to (4), of the left leg; on the right the second and third change their sign (3). As Plug-in Gait has them."""


def clinical_angles(limbs: LowerLimbs, *, up: Floats = Z_UP, lab: Floats | None = None) -> dict[str, Floats]:
    """(…, F, 3) deg by name: LPelvisAngles, LHipAngles, … RFootProgressAngles.

    Args:
        limbs: over frames. up: of the laboratory.
        lab: (3, 3) or (F, 3, 3) forward, left and up, from which pelvis and foot are seen; (5) where None.
    """
    lab = progression(limbs, up) if lab is None else lab
    return {
        f"{LETTER[side]}{reading.name}Angles": read(reading, rotation, side)
        for side in SIDES
        for reading, rotation in zip(READINGS, _rotations(limbs, side, lab), strict=True)
    }


def read(reading: Reading, R: Floats, side: Side) -> Floats:
    """(…, 3) deg of rotations R (…, 3, 3)."""
    deg = principal(R, FOOT_SEQUENCE)[..., list(reading.of)]
    mirror = TO_THE_LEFT[side]
    deg = deg * np.array(reading.sign) * (1.0, mirror, mirror)
    deg[..., 0] += reading.plus
    return within_half_turn(deg)


def _rotations(limbs: LowerLimbs, side: Side, lab: Floats) -> tuple[Floats, ...]:
    """Of pelvis, hip, knee, ankle and foot, in the order of `READINGS`."""
    leg, pelvis = limbs.leg(side), limbs.pelvis.R
    seen = np.swapaxes(lab, -1, -2)
    return (
        seen @ pelvis,
        relative(pelvis, leg.thigh.R),
        relative(leg.thigh.R, leg.shank_at_knee.R),
        relative(leg.shank.R, leg.foot.R),
        seen @ leg.foot.R,
    )


def progression(limbs: LowerLimbs, up: Floats = Z_UP) -> Floats:
    """(3, 3) forward, left and up of (5) as columns: a horizontal axis of the laboratory."""
    ahead = _walked(limbs, up)
    if np.linalg.norm(ahead) < WALKED_MM:
        ahead = _faced(limbs, up)
    return _turned_to(_nearest_axis(ahead), up)


def way_walked(limbs: LowerLimbs, up: Floats = Z_UP, *, rate: float) -> Floats:
    """(3, 3) forward, left and up of (6) as columns: the way, or the laboratory's axis within `ALONG_DEG` of it.

    Where the way bends it is (F, 3, 3), of each frame (7).

    Args:
        limbs: over frames. up: of the laboratory. rate: frames a second.
    """
    ahead = _walked(limbs, up)
    if _bends(limbs, ahead, up) and (each := _at_each_moment(limbs, up, rate)) is not None:
        return _turned_to(each, up)
    if np.linalg.norm(ahead) < WALKED_MM:
        ahead = _stepped(limbs, up)
    if np.linalg.norm(ahead) == 0:
        return progression(limbs, up)
    ahead, axis = unit(ahead), _nearest_axis(ahead)
    return _turned_to(axis if ahead @ axis >= np.cos(np.radians(ALONG_DEG)) else ahead, up)


def _turned_to(forward: Floats, up: Floats) -> Floats:
    return np.stack([forward, np.cross(up, forward), np.broadcast_to(up, forward.shape)], -1)


def _bends(limbs: LowerLimbs, ahead: Floats, up: Floats) -> bool:
    """Whether the pelvis walks and leaves the line between the ends of its way."""
    at = _floor(limbs.pelvis.origin, up)
    at = at[np.isfinite(at).all(-1)]
    if not len(at):
        return False
    line = unit(ahead) if np.linalg.norm(ahead) >= WALKED_MM else np.zeros(3)
    off = at - at[0]
    far = np.linalg.norm(off - np.outer(off @ line, line), axis=1).max()
    return bool(far > (BEND_MM if line.any() else WALKED_MM))


def _at_each_moment(limbs: LowerLimbs, up: Floats, rate: float) -> Floats | None:
    """(F, 3) direction of the way (7); None where the subject stands, or drifts."""
    at = _floor(limbs.pelvis.origin, up)
    frames = np.arange(len(at))
    seen = np.flatnonzero(np.isfinite(at).all(-1))
    early, late = (np.clip(frames + side * HALF_S * rate, seen[0], seen[-1]) for side in (-1, 1))
    way = np.stack([np.interp(late, seen, x) - np.interp(early, seen, x) for x in at[seen].T], -1)
    goes = np.flatnonzero(np.linalg.norm(way, axis=1) >= STANDING_MM)
    if not len(goes):
        return None
    nearest = np.round(np.interp(frames, goes, np.arange(len(goes)))).astype(int)
    return np.asarray(unit(way[goes[nearest]]))


def _floor(v: Floats, up: Floats) -> Floats:
    """(…, 3) without the vertical part."""
    return np.asarray(v - (v @ up)[..., None] * up)


def _nearest_axis(ahead: Floats) -> Floats:
    """(3) of the laboratory."""
    k = int(np.abs(ahead).argmax())
    return np.asarray(np.eye(3)[k] * (np.sign(ahead[k]) or 1.0))


def _walked(limbs: LowerLimbs, up: Floats) -> Floats:
    """(3) mm along the floor, of the pelvis from its first to its last frame."""
    at = limbs.pelvis.origin
    seen = np.isfinite(at).all(-1)
    return _floor(at[seen][-1] - at[seen][0] if seen.any() else np.zeros(3), up)


def _faced(limbs: LowerLimbs, up: Floats) -> Floats:
    """(3) along the floor, the mean of the pelvis' own x."""
    x = limbs.pelvis.R[..., 0]
    seen = np.isfinite(x).all(-1) & np.isfinite(limbs.pelvis.origin).all(-1)
    return _floor(x[seen].mean(0) if seen.any() else np.zeros(3), up)


def _stepped(limbs: LowerLimbs, up: Floats) -> Floats:
    """(3) along the floor, in which feet go to and fro below the pelvis, as it faces; 0 where they stand."""
    apart = []
    for side in SIDES:
        foot = _floor(limbs.leg(side).ankle - limbs.pelvis.origin, up)
        apart.append((foot := foot[np.isfinite(foot).all(-1)]) - (foot.mean(0) if len(foot) else 0.0))
    both = np.concatenate(apart)
    if not len(both):
        return np.zeros(3)
    _, size, axes = np.linalg.svd(both, full_matrices=False)
    if size[0] < TO_AND_FRO_MM * np.sqrt(len(both)):
        return np.zeros(3)
    return np.asarray(axes[0] * (np.sign(axes[0] @ _faced(limbs, up)) or 1.0))
