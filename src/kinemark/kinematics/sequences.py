"""Angles from rotations, for every sequence of three turns.

A joint's rotation R has the child's axes, in the parent's, as columns; three turns, each about an axis as the turns
before have left it, are

    R = R_i(a) R_j(b) R_k(c)                                                                            (1)

Let ε be +1 where j follows i in the circle x, y, z, else −1. Where all three axes differ (Cardan; z-x-y),

    sin b = ε R_ik,   a = atan2(−ε R_jk, R_kk),   c = atan2(−ε R_ij, R_ii)                              (2)

and where the first comes again (Euler; y-x-y), with l the axis that is not used,

    cos b = R_ii,   a = atan2(R_ji, −ε R_li),   c = atan2(R_ij, ε R_il)                                 (3)

Each rotation has two such triples; the principal one has b in ±90° (2) or 0 … 180° (3), the other is

    (a + 180°, 180° − b, c + 180°) or (a + 180°, −b, c + 180°)                                          (4)

Gimbal lock: where cos b (2) or sin b (3) comes to nothing, only the sum or difference of a and c is there to be seen.
Errors of a and c grow as its inverse.

UM²AS (appendix A) has the rows of its matrix as axes, so its R is Rᵀ here and r₂₃ = R₃₂, and takes from z, x′, y″

    θ = sin⁻¹ r₂₃,   φ = cos⁻¹(r₂₂ / cos θ),   ψ = cos⁻¹(r₃₃ / cos θ)                                    (5)

An inverse cosine has no sign: (5) gives |φ| and |ψ| of (2), so extension reads as flexion and supination as pronation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from ..data.method import Method, parameter
from ..data.models import Joint, check_sequence
from .stage import ANGLES


@dataclass(frozen=True, slots=True)
class SignedAngles(Method):
    """Angles with their sign, by inverse tangents."""

    continuous: bool = parameter(
        True,
        meaning="of the two triples (4), and of whole turns, take what is nearest to the frame before, so that "
        "curves do not jump; else each frame's principal values",
    )
    lock_deg: float = parameter(
        10.0, unit="deg", low=0, below=90,
        meaning="how near to gimbal lock the second angle may come before a frame is flagged",
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class InverseCosines(Method):
    """Angles by inverse cosines, as UM²AS takes them, without the sign of the first and the third."""

    lock_deg: float = parameter(
        10.0, unit="deg", low=0, below=90,
        meaning="how near to gimbal lock the second angle may come before a frame is flagged",
    )  # fmt: skip


AngleMethod = SignedAngles | InverseCosines


def turned(deg: Floats, sequence: str) -> Floats:
    """R (…, 3, 3) of (1) from a, b, c (…, 3) deg."""
    check_sequence(sequence)
    one, two, three = (_about(axis, np.radians(deg[..., i])) for i, axis in enumerate(sequence))
    return one @ two @ three  # (1)


def _about(axis: str, angle: Floats) -> Floats:
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    R = np.zeros((*angle.shape, 3, 3))
    R[..., i, i] = 1
    R[..., j, j] = R[..., k, k] = np.cos(angle)
    R[..., k, j] = np.sin(angle)
    R[..., j, k] = -np.sin(angle)
    return R


def principal(R: Floats, sequence: str, *, negative_middle: bool = False) -> Floats:
    """a, b, c (…, 3) deg of rotations R (…, 3, 3) by (2) or (3); a and c are NaN in exact gimbal lock.

    Args:
        R: the child's axes as columns in the parent's; NaN stays NaN.
        sequence: such as "zxy" or "yxy".
        negative_middle: take the other triple of (4) in sequences whose first axis comes again.
    """
    check_sequence(sequence)
    i, j, k = ("xyz".index(axis) for axis in sequence)
    e = 1.0 if (j - i) % 3 == 1 else -1.0
    m = 3 - i - j
    if i == k:
        opening = np.hypot(R[..., j, i], R[..., m, i])
        b = np.arctan2(opening, R[..., i, i])  # (3)
        first, third = (R[..., j, i], -e * R[..., m, i]), (R[..., i, j], e * R[..., i, m])
        if negative_middle:
            b, first, third = -b, (-first[0], -first[1]), (-third[0], -third[1])  # (4)
    else:
        opening = np.hypot(R[..., i, i], R[..., i, j])
        b = np.arctan2(e * R[..., i, k], opening)  # (2)
        first, third = (-e * R[..., j, k], R[..., k, k]), (-e * R[..., i, j], R[..., i, i])
    lost = opening < 1e-9
    a, c = (np.where(lost, np.nan, np.arctan2(*pair)) for pair in (first, third))
    return np.degrees(np.stack([a, b, c], -1))


def lock_distance(R: Floats, sequence: str) -> Floats:
    """How far (…) deg the middle angle is from gimbal lock; 90 at best."""
    b = principal(R, sequence)[..., 1]
    return 90 - np.abs(b) if sequence[0] != sequence[2] else 90 - np.abs(np.abs(b) - 90)


def read_angles(R: Floats, joint: Joint, method: AngleMethod) -> tuple[Floats, Bools]:
    """Angles (F, 3) deg of a joint and whether they are in gimbal lock (F), from rotations R (F, 3, 3)."""
    with np.errstate(invalid="ignore"):
        locked = lock_distance(R, joint.sequence) < method.lock_deg
    return ANGLES.function(method)(R, joint, locked, method=method), locked


@ANGLES.method("signed", SignedAngles)
def signed_angles(R: Floats, joint: Joint, locked: Bools, *, method: SignedAngles) -> Floats:
    """(2) or (3) for R (F, 3, 3) of a joint, deg; frames that are locked (F) are not followed."""
    deg = principal(R, joint.sequence, negative_middle=joint.middle == "negative")
    return followed(deg, locked, joint.sequence) if method.continuous else deg


@ANGLES.method("inverse_cosines", InverseCosines, source="UM²AS, A.29 to A.36")
def unsigned_angles(R: Floats, joint: Joint, locked: Bools, *, method: InverseCosines) -> Floats:
    """(5) for R (F, 3, 3) of a joint, deg."""
    return inverse_cosines(R, joint.sequence)


def inverse_cosines(R: Floats, sequence: str) -> Floats:
    """(5) for R (…, 3, 3), and what corresponds to it in any Cardan sequence.

    Raises:
        ValueError: the sequence ends with the axis it began with; UM²AS gives no such form.
    """
    check_sequence(sequence)
    i, j, k = ("xyz".index(axis) for axis in sequence)
    if i == k:
        raise ValueError(f"inverse cosines are for sequences of three different axes, found {sequence!r}")
    e = 1.0 if (j - i) % 3 == 1 else -1.0
    with np.errstate(invalid="ignore", divide="ignore"):
        b = np.arcsin(np.clip(e * R[..., i, k], -1, 1))  # (5)
        a, c = (np.arccos(np.clip(R[..., m, m] / np.cos(b), -1, 1)) for m in (k, i))
    return np.degrees(np.stack([a, b, c], -1))


LOST_DEG = 90.0
"""Sum of the changes of three angles over gimbal lock or a gap, above which both triples are as far off and the frame
before tells nothing; chosen: swinging through lock, a limb goes on by some 10° an angle."""


def followed(deg: Floats, locked: Bools, sequence: str) -> Floats:
    """Of the triples (4) of each frame (F, 3), turned by whole turns, the one nearest to the frame before.

    The first frame that is known and not locked has principal values; frames before it are followed backwards. Where a
    stretch in lock or a gap ends and neither triple goes on with what was before it, the principal one counts. In
    sequences whose first axis comes again the sign of the middle angle is a convention; there the other triple is taken
    of all frames where most that are not locked would else have the other sign.
    """
    half = np.array([180.0, 180.0, 180.0]) if sequence[0] != sequence[2] else np.array([180.0, 0.0, 180.0])
    both = np.stack([deg, half + deg * [1, -1, 1]])  # (4)
    known = np.flatnonzero(np.isfinite(deg).all(-1))
    free = known[~locked[known]]
    if not len(known):
        return deg.copy()
    out, start = deg.copy(), int(free[0] if len(free) else known[0])
    for frames in (known[known > start], known[known < start][::-1]):
        _follow(out, both, frames, locked, start)
    if sequence[0] == sequence[2] and (out[free, 1] * deg[free, 1] < 0).sum() > len(free) / 2:
        return half + out * [1, -1, 1] - 360 * np.round((half + out * [1, -1, 1])[start] / 360)
    return out


def _follow(out: Floats, both: Floats, frames: Ints, locked: Bools, start: int) -> None:
    """Fill `out` (F, 3) with the triples of `both` (2, F, 3) in this order of frames, from what frame `start` has."""
    last, at = out[start], start
    for f in frames:
        near = both[:, f] - 360 * np.round((both[:, f] - last) / 360)
        change = np.abs(near - last).sum(-1)
        which = int(change.argmin())
        if abs(int(f) - at) > 1 and change[which] > LOST_DEG:
            which = 0
        out[f] = near[which]
        if not locked[f]:
            last, at = out[f], int(f)
