"""Forces, moments and powers of the joints of a leg, from the floor upwards (Newton and Euler).

For a segment of mass m, centre of mass c, inertia I and angular velocity ω, pushed at its distal end d by the force F_d
with the moment M_d,

    F = m (c̈ − g) − F_d                                                                             (1)
    M = d/dt (I ω) − M_d − (d − c) × F_d − (p − c) × F                                              (2)

act on it at its proximal joint p. On the next segment −F and −M act there. The foot's distal end is the centre of
pressure, with the ground reaction and its free moment. Moments are internal, of the muscles and ligaments; a joint's
power is that of the moment on the angular velocity of the distal segment in the proximal one:

    P = M · (ω_distal − ω_proximal)                                                                 (3)

Derivatives over frames of Δt are

    ẋ = (x₋₂ − 8 x₋₁ + 8 x₁ − x₂) / 12 Δt                                                            (4)
    ẋ = (−2 x₋₂ − x₋₁ + x₁ + 2 x₂) / 10 Δt                                                           (5)

where (5), the slope of a line through five frames, is smoother. Each derivative loses two frames at both ends. As its
stored forces and moments show, Plug-in Gait has for c̈ the second derivative of the quintic spline that passes through
the centres (`spline_acceleration`; Woltring 1986 without smoothing), and for rotations something near (5).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy

from ..data import KinemarkError
from ..data.array_types import Bools, Floats
from ..numerics.runs import true_runs
from .lower_limb import Leg
from .segment_inertia import SegmentInertia
from .segments import Z_UP, Segment, mean_length

GRAVITY = 9.81
"""m/s², downwards; conventional."""
LOST = 4
"""Frames at each end in which there is no acceleration; by definition, those of (4) twice."""


class GroundContact(NamedTuple):
    """What the floor does to one foot over F frames.

    Attributes:
        force: (F, 3) N; centre: (F, 3) mm, NaN where the force is 0; free_moment: (F, 3) N·m.
    """

    force: Floats
    centre: Floats
    free_moment: Floats


@dataclass(frozen=True, slots=True, eq=False)
class JointLoad:
    """A joint over F frames.

    Attributes:
        force: (F, 3) N and moment: (F, 3) N·m on the distal segment, in the laboratory.
        power: (F) W, positive where the moment gives energy.
        distal: the segment below the joint.
    """

    force: Floats
    moment: Floats
    power: Floats
    distal: Segment


def five_point(x: Floats, dt: float) -> Floats:
    """(F, …) derivative (4) of (F, …); NaN in two frames at each end."""
    return _stencil(x, (1.0, -8.0, 8.0, -1.0), 12.0 * dt)


def five_point_slope(x: Floats, dt: float) -> Floats:
    """(F, …) derivative (5)."""
    return _stencil(x, (-2.0, -1.0, 1.0, 2.0), 10.0 * dt)


def twice_five_point(x: Floats, dt: float) -> Floats:
    """(F, …) second derivative by (4) twice; NaN in four frames at each end."""
    return five_point(five_point(x, dt), dt)


def spline_acceleration(x: Floats, dt: float) -> Floats:
    """(F, …) second derivative of the natural quintic spline through (F, …); NaN in `LOST` frames at each end of a run
    without a hole, where it would follow from the spline's own end conditions."""
    flat = x.reshape(len(x), -1)
    out = np.full_like(flat, np.nan)
    whole: Bools = ~np.isnan(flat.sum(axis=1))
    for first, stop in true_runs(whole).tolist():
        if stop - first <= 2 * LOST:
            continue
        still = np.zeros(flat.shape[1])
        ends: Any = [(3, still), (4, still)]  # natural: no third and fourth derivative
        time = dt * np.arange(stop - first)
        spline = scipy.interpolate.make_interp_spline(time, flat[first:stop], k=5, bc_type=(ends, ends))
        out[first + LOST : stop - LOST] = spline(time, 2)[LOST:-LOST]
    return out.reshape(x.shape)


def _stencil(x: Floats, weights: tuple[float, float, float, float], over: float) -> Floats:
    out = np.full_like(x, np.nan)
    if len(x) > 4:
        a, b, c, d = weights
        out[2:-2] = (a * x[:-4] + b * x[1:-3] + c * x[3:-1] + d * x[4:]) / over
    return out


Derivative = Callable[[Floats, float], Floats]


def joint_loads(
    leg: Leg,
    pelvis: Segment,
    contact: GroundContact,
    *,
    mass_kg: float,
    foot_mm: float,
    rate: float,
    inertia: Mapping[str, SegmentInertia],
    rotation_derivative: Derivative = five_point,
    acceleration: Derivative = twice_five_point,
) -> dict[str, JointLoad]:
    """Ankle, knee and hip by (1) to (3); NaN in four frames at each end, where a marker is missing, and
    everywhere where the foot's length is unknown.

    Args:
        leg, pelvis: over F frames.
        contact: of this foot with the floor.
        mass_kg: of the body. foot_mm: length of the foot, along which its centre of mass lies; NaN
            where nobody knows it.
        rate: frames a second.
        inertia: of foot, shank and thigh.
        rotation_derivative: (4) or (5).
        acceleration: of centres of mass, mm/s²: `twice_five_point` or `spline_acceleration`.

    Raises:
        KinemarkError: the mass is unknown.
    """
    if not mass_kg > 0:
        raise KinemarkError("Moments want the subject's mass: give mass_kg in the measures.")
    dt = 1.0 / rate
    toes = leg.ankle - foot_mm * leg.foot.R[..., 2]
    shank_mm, thigh_mm = (mean_length(a - b) for a, b in ((leg.knee, leg.ankle), (leg.hip, leg.knee)))
    chain = (
        ("Ankle", "foot", leg.foot, leg.ankle, toes, foot_mm),
        ("Knee", "shank", leg.shank, leg.knee, leg.ankle, shank_mm),
        ("Hip", "thigh", leg.thigh, leg.hip, leg.knee, thigh_mm),
    )
    above = {"Ankle": leg.shank, "Knee": leg.thigh, "Hip": pelvis}
    force, at, moment = contact.force, contact.centre, contact.free_moment
    spin = {name: angular_velocity(segment.R, dt, rotation_derivative) for name, segment in above.items()}
    found: dict[str, JointLoad] = {}
    for name, part, segment, proximal, distal, length in chain:
        share = inertia[part]
        m, centre = share.mass * mass_kg, proximal + share.centre * (distal - proximal)
        F = m * (acceleration(centre, dt) / 1000.0 + GRAVITY * Z_UP) - force  # (1)
        omega = angular_velocity(segment.R, dt, rotation_derivative)
        change = _momentum_change(segment.R, omega, m, share.radius, length, dt, rotation_derivative)
        levers = np.cross(_lever(at, centre), force) + np.cross(_lever(proximal, centre), F)
        M = change - moment - levers  # (2)
        power = (M * (omega - spin[name])).sum(-1)  # (3)
        found[name] = JointLoad(F, M, power, segment)
        force, at, moment = -F, proximal, -M
    return found


def _lever(point: Floats, centre: Floats) -> Floats:
    """(F, 3) m; 0 where there is no point, as no force acts there."""
    return np.where(np.isnan(point).any(-1, keepdims=True), 0.0, point - centre) / 1000.0


def angular_velocity(R: Floats, dt: float, derivative: Derivative) -> Floats:
    """(F, 3) rad/s in the laboratory of axes R (F, 3, 3): the skew part of Ṙ Rᵀ."""
    W = derivative(R.reshape(len(R), 9), dt).reshape(R.shape) @ np.swapaxes(R, -1, -2)
    turning = [W[:, 2, 1] - W[:, 1, 2], W[:, 0, 2] - W[:, 2, 0], W[:, 1, 0] - W[:, 0, 1]]
    return np.stack(turning, -1) / 2.0


def _momentum_change(
    R: Floats, omega: Floats, mass: float, radius: tuple[float, float, float], length: float, dt: float, d: Derivative
) -> Floats:
    """(F, 3) N·m, I ω̇ + ω × I ω."""
    inertia = mass * np.diag((np.array(radius) * length / 1000.0) ** 2)
    I_lab = R @ inertia @ np.swapaxes(R, -1, -2)
    spin = np.einsum("fij,fj->fi", I_lab, omega)
    return np.einsum("fij,fj->fi", I_lab, d(omega, dt)) + np.cross(omega, spin)
