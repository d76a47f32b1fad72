"""A right arm that eats or drinks, with the seven markers and eight angles of UM²AS.

Each region has axes x forward, y up the limb and z to the right when the arm hangs at the side. The joint angles
φ, θ, ψ turn the parent's axes about z, then x, then y (UM²AS A.1–A.4); with the axes as rows,
A_child = T(φ, θ, ψ) A_parent and

    T = Rᵧ(ψ)ᵀ Rₓ(θ)ᵀ R_z(φ)ᵀ                                                                    (1)

Flexion, internal rotation and pronation are positive; so are adduction (abduction is negative) and, at the wrist,
deviation towards the little finger (ulnar). ψ₂ is zero when the rod is parallel to the elbow's axis, the hand supine.
The markers are the arm's skeleton:

    1 = 2 + post · y₀,   3 = 2 + dy · y₀ + dz · z₀         acromion and the shoulder's pivot             (2)
    4 = 3 − arm · y₁                                       lateral epicondyle                            (3)
    M = 4 − forearm · y₂,   5, 6 = M ∓ rod/2 · z₂          rod across ulna and radius at the styloids    (4)
    7 = M − hand · y₃                                      third metacarpal's head                       (5)

so that the axes built from the markers by A.9–A.20 give these angles back exactly. Those axes make three of the nine
angles vanish: θ₂ because the forearm lies in the plane of arm and forearm, and ψ₃ because x₃ is perpendicular to the
rod: R₁₃ = −cos θ₃ sin ψ₃ = 0. Shoulder three, elbow two, wrist two and ψ₃ ≡ 0 are the eight of the model.

The marker at the shoulder is where the arm pivots, and those at elbow and wrist lie on the limb's line as A.12–A.20
take them to; the limbs that hide markers run beside that line, under the skin.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ..data import Angles
from ..data.array_types import Floats
from .smooth_noise import smooth_noise
from .subjects import Capsules, Subject, pairs

NAMES = ("ACR1", "ACR2", "ARM3", "ELB4", "WRU5", "WRR6", "MC37")
"""The markers 1 … 7 of UM²AS: a post on the acromion, the acromion, upper arm, lateral epicondyle, the rod's ends at
ulna and radius, third metacarpal. Marker 1 stands above marker 2, as A.9 and the sense of table 2.1 want it."""

LINKS = (
    ("ACR1", "ACR2"),
    ("ACR2", "ARM3"),
    ("ARM3", "ELB4"),
    ("ELB4", "WRU5"),
    ("ELB4", "WRR6"),
    ("WRU5", "WRR6"),
    ("WRU5", "MC37"),
    ("WRR6", "MC37"),
)

RANGES = {
    "shoulder": ((-60.0, 180.0), (-180.0, 75.0), (-90.0, 90.0)),
    "elbow": ((-10.0, 150.0), (0.0, 0.0), (-90.0, 90.0)),
    "wrist": ((-70.0, 80.0), (-20.0, 30.0), (0.0, 0.0)),
}
"""Normal motion, deg, of φ, θ and ψ at each joint (UM²AS table 2.1)."""

POSES = {
    "feeding": ((18.0, -10.0, 36.0, 95.0, 78.0, -13.0, 3.0), (66.0, -12.0, 42.0, 120.0, 30.0, 3.0, 11.0)),
    "drinking": ((28.0, -10.0, 30.0, 80.0, 82.0, -22.0, 2.0), (66.0, -14.0, 46.0, 124.0, 68.0, -8.0, 15.0)),
}
"""Where the hand waits, at plate or table, and at the mouth: φ₁ θ₁ ψ₁ φ₂ ψ₂ φ₃ θ₃, deg."""


class ArmDimensions(NamedTuple):
    """Lengths of the arm's skeleton and thickness of its limbs, mm."""

    post: float = 60.0
    shoulder: tuple[float, float] = (-35.0, 50.0)
    arm: float = 290.0
    forearm: float = 250.0
    rod: float = 80.0
    hand: float = 85.0
    upper: float = 42.0
    lower: float = 30.0
    palm: float = 22.0


def arm(
    task: Literal["feeding", "drinking"] = "feeding",
    *,
    duration_s: float = 6.0,
    rate: float = 50.0,
    seed: int = 0,
    period_s: float = 3.0,
    unsteady_deg: float = 1.0,
    sway_mm: float = 3.0,
    shoulder: ArrayLike = (300.0, 250.0, 750.0),
    marker_radius_mm: float = 17.0,
) -> Subject:
    """A seated person, facing +X, whose right hand goes to the mouth and back; `angles` holds φ, θ, ψ of (1) exactly.

    Args:
        task: "feeding" or "drinking".
        duration_s: length of the recording, s.
        rate: frames a second, Hz.
        seed: of unsteadiness and sway.
        period_s: from one mouthful to the next, s.
        unsteady_deg: standard deviation that the seed adds to each angle, deg.
        sway_mm: standard deviation of the shoulder's own motion on each axis, mm.
        shoulder: (3) where marker 2 sits, mm.
        marker_radius_mm: of the markers; ping-pong balls by default.

    Raises:
        ValueError: the task is another one, or a length of time is not positive.
    """
    if task not in POSES:
        raise ValueError(f"task is {task!r}, wanted one of {sorted(POSES)}")
    if min(duration_s, rate, period_s) <= 0:
        raise ValueError("duration_s, rate and period_s must be positive")
    n = max(round(duration_s * rate), 1)
    low, high = np.array(POSES[task])
    share = reach(np.arange(n) / rate / period_s)[:, None]
    eight = low + share * (high - low) + unsteady_deg * smooth_noise((7, n), rate, seed, cut_hz=1.2).T
    deg = _joint_angles(eight)
    place = np.asarray(shoulder, np.float64) + sway_mm * smooth_noise((3, n), rate, seed + 1, cut_hz=0.7).T
    markers, capsules = skeleton(deg, place, ArmDimensions(), marker_radius_mm)
    angles = Angles(("shoulder", "elbow", "wrist"), ("zxy",) * 3, deg, np.full((3, n, 3, 3), np.nan), rate)
    return Subject(NAMES, rate, markers, np.array(marker_radius_mm), capsules, pairs(NAMES, *LINKS), angles=angles)


def reach(turns: Floats) -> Floats:
    """How near the mouth the hand is, 0 to 1: 40 % of a turn up, 10 % there, 40 % down, 10 % waiting, without jerk."""
    up = np.clip((turns % 1.0) / 0.4, 0, 1) - np.clip((turns % 1.0 - 0.5) / 0.4, 0, 1)
    risen: Floats = up**3 * (10 - 15 * up + 6 * up**2)  # least jerk: Flash and Hogan 1985
    return risen


def _joint_angles(eight: Floats) -> Floats:
    """(3, F, 3) φ, θ, ψ of shoulder, elbow and wrist from the seven that are free (F, 7), within table 2.1."""
    none = np.zeros(len(eight))
    shoulder, elbow = eight[:, :3], np.stack([eight[:, 3], none, eight[:, 4]], -1)
    deg = np.stack([shoulder, elbow, np.stack([eight[:, 5], eight[:, 6], none], -1)])
    low, high = np.array(list(RANGES.values())).transpose(2, 0, 1)[:, :, None]
    within: Floats = np.clip(deg, low, high)
    return within


def skeleton(deg: Floats, place: Floats, dimensions: ArmDimensions, marker: float) -> tuple[Floats, Capsules]:
    """Markers (7, F, 3) mm and limbs from joint angles (3, F, 3) deg and the place (F, 3) of marker 2."""
    axes = [np.broadcast_to(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]), (len(place), 3, 3))]
    for joint in deg:
        axes.append(
            scipy.spatial.transform.Rotation.from_euler("ZXY", joint, degrees=True).as_matrix().transpose(0, 2, 1)
            @ axes[-1]
        )  # (1)
    (_, y0, z0), (_, y1, _), (_, y2, z2), (_, y3, _) = (a.transpose(1, 0, 2) for a in axes)
    m1, m3 = place + dimensions.post * y0, place + dimensions.shoulder[0] * y0 + dimensions.shoulder[1] * z0  # (2)
    m4 = m3 - dimensions.arm * y1  # (3)
    wrist = m4 - dimensions.forearm * y2
    m5, m6 = wrist - dimensions.rod / 2 * z2, wrist + dimensions.rod / 2 * z2  # (4)
    m7 = wrist - dimensions.hand * y3  # (5)
    return np.array([m1, place, m3, m4, m5, m6, m7]), _limbs(axes, place, m3, m4, wrist, m7, dimensions, marker)


def _limbs(
    axes: list[Floats],
    place: Floats,
    m3: Floats,
    m4: Floats,
    wrist: Floats,
    m7: Floats,
    dimensions: ArmDimensions,
    marker: float,
) -> Capsules:
    """Upper arm inside its markers, forearm and hand on the palm's side of theirs, trunk and head."""
    z1, x2, x3 = axes[1][:, 2], axes[2][:, 0], axes[3][:, 0]
    under = dimensions.upper + marker + 1
    elbow = m4 - under * z1
    carpus = wrist + (dimensions.lower + marker + 3) * x2
    parts = [
        ("upper arm", m3 - under * z1, elbow, dimensions.upper),
        ("forearm", elbow, carpus, dimensions.lower),
        ("hand", carpus, m7 + (dimensions.palm + marker + 1) * x3, dimensions.palm),
        ("trunk", place + np.array([0.0, 190.0, -140.0]), place + np.array([0.0, 190.0, -480.0]), 110.0),
        ("head", place + np.array([30.0, 190.0, 200.0]), place + np.array([35.0, 190.0, 260.0]), 85.0),
    ]
    names, a, b, radius = zip(*parts, strict=True)
    return Capsules(names, np.array(a), np.array(b), np.array(radius))
