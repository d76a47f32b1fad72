"""A virtual gait laboratory: a walking body with force plates and EMG, of which every result is known.

What acts on a joint from below follows from the momentum of all that is below it, without segment after segment:

    F = Σ mᵢ (c̈ᵢ − g) − F_ground                                                                             (1)
    M = d/dt Σ Lᵢ + Σ (cᵢ − p) × mᵢ (c̈ᵢ − g) − (q − p) × F_ground − T                                        (2)

with centres of mass cᵢ, angular momenta Lᵢ = Iᵢ ωᵢ about them, the joint p, the centre of pressure q and the free
moment T. Derivatives are taken on the body's functions of time in steps of `STEP_S`, not over frames. With s from 0 to
1 through the stance and the share w of the body that the foot carries, the ground's force on a foot is

    F = m g w (−a sin 2πs,  ∓b,  c (1 − d cos 4πs))                                                           (3)

forward, to the left and upwards, c such that the ground carries the body over a stride.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..data import Analog, ForcePlate, MarkerTrajectory, Signals, Trajectories, Trial
from ..data.array_types import Bools, Floats
from ..data.strides import FootEvent
from ..data.subject_measures import LETTER, SIDES, TO_THE_LEFT, Side
from ..gait.clinical_angles import clinical_angles
from ..gait.gait_trial import signals_of
from ..gait.inverse_dynamics import GRAVITY, GroundContact, JointLoad
from ..gait.lower_limb import Leg, LowerLimbs
from ..gait.segment_inertia import INERTIAS, SegmentInertia
from ..gait.segments import Segment
from .gait_body import BEGIN, FOOT_MM, WalkingBody

STEP_S = 1e-3
"""Of derivatives; chosen: five-point differences are exact to 1e-9 of a walk there."""
OFF = 0.6
"""Share of a stride at which a foot leaves the floor; chosen."""
SHAPE = (0.2, 0.05, 0.2)
"""a, b and d of (3), shares of the weight; chosen, of the size of walkers'."""
FREE_NM = 4.0
"""Greatest free moment; chosen, of the size of walkers'."""
PLATE_MM = (480.0, 420.0)
"""Length and width of the plates; chosen: one foot's stance is on one plate."""
SENSOR_MM = 40.0
"""How far a plate's sensors are below its surface; chosen."""
SWINGS_S = 24.0
"""Of the functional trial; chosen, 12 s a leg."""
BURSTS: Mapping[str, tuple[float, float]] = {"EMG LTA": (0.6, 0.98), "EMG LGAS": (0.15, 0.5)}
"""Shares of the left stride between which a muscle is on; chosen, as of walkers."""


@dataclass(frozen=True, slots=True, eq=False)
class GaitLaboratory:
    """A recording with its truth.

    Attributes:
        body: that walked. walk, static: trials as a laboratory has them.
        limbs: true segments; signals: true angles, forces, moments and powers under the usual names.
        events: true foot strikes and offs within the walk.
        on: (N) of each EMG channel, whether the muscle is on.
    """

    body: WalkingBody
    walk: Trial
    static: Trial
    functional: Trial
    limbs: LowerLimbs
    signals: Signals
    events: tuple[FootEvent, ...]
    on: Mapping[str, Bools]


def gait_laboratory(
    body: WalkingBody,
    *,
    duration_s: float = 3.0,
    rate: float = 100.0,
    analog_rate: float = 1000.0,
    inertia: str = "winter",
    noise_mm: float = 0.0,
    force_noise_n: float = 0.0,
    plates_off_mm: tuple[float, float] = (0.0, 0.0),
    plate_type: int = 2,
    seed: int = 0,
) -> GaitLaboratory:
    """A walk of the body over one plate for each foot, a standing trial, and one that swings the legs.

    Args:
        body: that walks; its measures state its mass.
        duration_s: of the walk. rate: frames, analog_rate: samples of plates and EMG, a second.
        inertia: of the segments, a name of `INERTIAS`.
        noise_mm: standard deviation of each marker along each axis, stated as its covariance.
        force_noise_n: standard deviation of each channel of force; of those of moment, N·mm, a hundred times it.
        plates_off_mm: how far the plates truly lie from where their corners say, along x and y.
        plate_type: 2, or 4 with a calibration matrix.
        seed: of noise and EMG.

    Raises:
        ValueError: the body's mass is unknown, or a rate or length is not positive.
    """
    mass = body.measures.mass_kg
    if mass is None or min(duration_s, rate, analog_rate) <= 0:
        raise ValueError("a gait laboratory wants a body of known mass, and positive duration and rates")
    rng = np.random.default_rng(seed)
    time = np.arange(round(duration_s * rate)) / rate
    fine = np.arange(round(duration_s * analog_rate)) / analog_rate
    parts = INERTIAS[inertia]
    limbs, ground = body.limbs(time), ground_reactions(body, time)
    plates, channels = _plates(body, fine, duration_s, plates_off_mm, plate_type)
    channels = channels + force_noise_n * np.array([1, 1, 1, 100, 100, 100] * 2)[:, None] * rng.normal(
        size=channels.shape
    )
    names = tuple(f"{name}{k}" for k in (1, 2) for name in ("Fx", "Fy", "Fz", "Mx", "My", "Mz"))
    on = {name: _between(body.turn_of(fine, "left"), *burst) for name, burst in BURSTS.items()}
    emg = np.stack([(0.02 + 0.5 * active) * rng.normal(size=len(fine)) for active in on.values()])
    analog = (
        Analog(names, ("N", "N", "N", "N·mm", "N·mm", "N·mm") * 2, analog_rate, channels),
        Analog(tuple(on), ("mV",) * len(on), analog_rate, emg),
    )
    walk = Trial("walk", _trajectories(body.markers(limbs), rate, noise_mm, rng), analog, plates)
    still = body.markers(body.standing(round(rate)), walking=False)
    static = Trial("static", _trajectories(still, rate, noise_mm, rng))
    swung = body.markers(body.swinging(np.arange(round(SWINGS_S * rate)) / rate))
    functional = Trial("functional", _trajectories(swung, rate, noise_mm, rng))
    loads = joint_truth(body, time, parts)
    signals = signals_of(clinical_angles(limbs), loads, ground, mass, rate=rate)
    return GaitLaboratory(body, walk, static, functional, limbs, signals, _events(body, duration_s), on)


def ground_reactions(body: WalkingBody, time: Floats) -> dict[Side, GroundContact]:
    """What the floor does to each foot by (3) at times (F) s."""
    weight = GRAVITY * float(body.measures.mass_kg or np.nan)
    found: dict[Side, GroundContact] = {}
    for side in SIDES:
        turn = body.turn_of(time, side)
        share, along = _share(turn), _along(turn)
        heel, toe = _stance(body, turn, side)
        centre = heel + (0.1 + 0.8 * _smooth(along))[:, None] * (toe - heel)
        free = FREE_NM * share * np.sin(2 * np.pi * along)
        centre = np.where(share[:, None] > 0, centre, np.nan)
        found[side] = GroundContact(weight * _force(turn, side), centre, free[:, None] * [0.0, 0.0, 1.0])
    return found


def joint_truth(body: WalkingBody, time: Floats, inertia: Mapping[str, SegmentInertia]) -> dict[str, JointLoad]:
    """Ankles, knees and hips by (1) and (2) at times (F) s, as "LAnkle"."""
    limbs, ground = remembered(body.limbs), ground_reactions(body, time)
    mass = float(body.measures.mass_kg or np.nan)
    return {
        LETTER[side] + joint: load
        for side in SIDES
        for joint, load in _loads(limbs, time, side, ground[side], inertia, mass).items()
    }


LimbsAt = Callable[[Floats], LowerLimbs]


def remembered(limbs: LimbsAt) -> LimbsAt:
    """The same, but of times that were asked for before without computing them again: derivatives share theirs."""
    known: dict[bytes, LowerLimbs] = {}

    def at(time: Floats) -> LowerLimbs:
        key = time.tobytes()
        if key not in known:
            known[key] = limbs(time)
        return known[key]

    return at


def _loads(
    limbs: LimbsAt, time: Floats, side: Side, ground: GroundContact, inertia: Mapping[str, SegmentInertia], mass: float
) -> dict[str, JointLoad]:
    """Ankle, knee and hip of a side."""
    leg = limbs(time).leg(side)
    chain = (("Ankle", "foot", leg.ankle), ("Knee", "shank", leg.knee), ("Hip", "thigh", leg.hip))
    below: list[tuple[Floats, Floats, Floats]] = []
    found: dict[str, JointLoad] = {}
    for joint, part, p in chain:
        centre, m = _centre(limbs, side, part, inertia), inertia[part].mass * mass
        push = m * (_second(centre, time) / 1000.0 + [0.0, 0.0, GRAVITY])
        below.append((centre(time), push, _first(_momentum(limbs, side, part, inertia[part], m), time)))
        F, M = -ground.force, -ground.free_moment - np.cross(_metres(ground.centre, p), ground.force)
        for c, own, change in below:
            F = F + own  # (1)
            M = M + change + np.cross((c - p) / 1000.0, own)
        omega = _spin(_segment(limbs, side, part), time) - _spin(_above(limbs, side, joint), time)
        found[joint] = JointLoad(F, M, (M * omega).sum(-1), _segment(limbs, side, part)(time))
    return found


def _force(turn: Floats, side: Side) -> Floats:
    """(F, 3) of the body's weight, by (3)."""
    forward, inwards, hump = SHAPE
    every = np.arange(1000) / 1000
    carried = 2 * np.mean(_share(every) * (1 - hump * np.cos(4 * np.pi * _along(every))))
    share, along = _share(turn), _along(turn)
    out = [-forward * np.sin(2 * np.pi * along), np.full_like(along, -TO_THE_LEFT[side] * inwards),
           (1 - hump * np.cos(4 * np.pi * along)) / carried]  # fmt: skip
    return share[:, None] * np.stack(out, -1)


def _along(turn: Floats) -> Floats:
    """(F) s of (3)."""
    return np.clip(np.mod(turn, 1.0) / OFF, 0.0, 1.0)


def _centre(limbs: LimbsAt, side: Side, name: str, inertia: Mapping[str, SegmentInertia]) -> Callable[[Floats], Floats]:
    """(F, 3) mm of a segment's centre of mass, as a function of time."""

    def at(time: Floats) -> Floats:
        proximal, distal = _ends(limbs(time).leg(side), name)
        return np.asarray(proximal + inertia[name].centre * (distal - proximal))

    return at


def _ends(leg: Leg, name: str) -> tuple[Floats, Floats]:
    """Proximal and distal end of a segment, (F, 3) mm; the foot ends its own length along its axis."""
    ends = {
        "foot": (leg.ankle, leg.ankle - FOOT_MM * leg.foot.R[..., 2]),
        "shank": (leg.knee, leg.ankle),
        "thigh": (leg.hip, leg.knee),
    }
    return ends[name]


def _segment(limbs: LimbsAt, side: Side, name: str) -> Callable[[Floats], Segment]:
    def at(time: Floats) -> Segment:
        found: Segment = getattr(limbs(time).leg(side), name)
        return found

    return at


def _above(limbs: LimbsAt, side: Side, joint: str) -> Callable[[Floats], Segment]:
    """The segment above a joint, as a function of time."""
    if joint == "Hip":
        return lambda time: limbs(time).pelvis
    return _segment(limbs, side, "shank" if joint == "Ankle" else "thigh")


def _momentum(limbs: LimbsAt, side: Side, name: str, share: SegmentInertia, mass: float) -> Callable[[Floats], Floats]:
    """(F, 3) N·m·s about the centre of mass, as a function of time."""

    def at(time: Floats) -> Floats:
        segment = _segment(limbs, side, name)
        R, (a, b) = segment(time).R, _ends(limbs(time).leg(side), name)
        length = np.linalg.norm(a - b, axis=-1)[:, None] / 1000.0
        local = np.einsum("fji,fj->fi", R, _spin(segment, time))
        return np.einsum("fij,fj->fi", R, mass * (np.array(share.radius) * length) ** 2 * local)

    return at


def _spin(segment: Callable[[Floats], Segment], time: Floats) -> Floats:
    """(F, 3) rad/s."""
    R = segment(time).R
    W = _first(lambda t: segment(t).R, time) @ np.swapaxes(R, -1, -2)
    return np.stack([W[:, 2, 1], W[:, 0, 2], W[:, 1, 0]], -1)


def _first(f: Callable[[Floats], Floats], time: Floats) -> Floats:
    """(F, …) derivative of a function of time."""
    h = STEP_S
    return np.asarray((f(time - 2 * h) - 8 * f(time - h) + 8 * f(time + h) - f(time + 2 * h)) / (12 * h))


def _second(f: Callable[[Floats], Floats], time: Floats) -> Floats:
    """(F, …) second derivative of a function of time."""
    h = STEP_S
    wide = f(time - 2 * h) + f(time + 2 * h)
    return np.asarray((16 * (f(time - h) + f(time + h)) - wide - 30 * f(time)) / (12 * h * h))


def _share(turn: Floats) -> Floats:
    """(F) of the body that a foot carries; with that of the other foot, half a stride later, 1."""
    x = np.mod(turn, 1.0)
    double = OFF - 0.5
    return np.asarray(_smooth(np.clip(x / double, 0, 1)) - _smooth(np.clip((x - 0.5) / double, 0, 1)))


def _smooth(x: Floats) -> Floats:
    """From 0 to 1 with two derivatives."""
    return np.asarray(x**3 * (10 - 15 * x + 6 * x * x))


def _stance(body: WalkingBody, turn: Floats, side: Side) -> tuple[Floats, Floats]:
    """(F, 3) mm heel and toe on the floor in the middle of the stance that each moment is in."""
    time = (np.floor(turn) + OFF / 2 - BEGIN - (0.0 if side == "left" else 0.5)) * body.period
    foot = body.limbs(time).leg(side).foot
    return (foot.origin + FOOT_MM * foot.R[..., 2]) * (1, 1, 0), foot.origin * (1, 1, 0)


def _metres(point: Floats, about: Floats) -> Floats:
    """(F, 3) m; 0 where there is no point."""
    return np.where(np.isnan(point), 0.0, point - about) / 1000.0


def _between(turn: Floats, a: float, b: float) -> Bools:
    x = np.mod(turn, 1.0)
    return np.asarray((x >= a) & (x < b))


def _events(body: WalkingBody, duration_s: float) -> tuple[FootEvent, ...]:
    period = body.period
    found = []
    for side in SIDES:
        begin = float(body.turn_of(np.zeros(1), side)[0])
        for strike, at in ((True, 0.0), (False, OFF)):
            first = np.ceil(begin - at) + at - begin
            times = np.arange(first * period, duration_s, period)
            found += [FootEvent(side, strike, float(t), 0.0, "truth") for t in times]
    return tuple(sorted(found, key=lambda event: event.time))


def _plates(
    body: WalkingBody, time: Floats, duration_s: float, off: tuple[float, float], kind: int,
) -> tuple[tuple[ForcePlate, ...], Floats]:  # fmt: skip
    """A plate below the stance of each foot nearest to the middle of the walk, and its channels (12, N)."""
    plates, channels, ground = [], [], ground_reactions(body, time)
    for k, side in enumerate(SIDES):
        turn = body.turn_of(time, side)
        mid_stance = int(np.abs(time - duration_s * (0.42 if k == 0 else 0.58)).argmin())
        own = np.floor(turn) == np.floor(turn[mid_stance])
        heel, toe = (end[mid_stance] for end in _stance(body, turn, side))
        centre = (heel + toe) / 2
        half = np.array(PLATE_MM) / 2
        square = np.array([[1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]]) * [*half, 0.0]
        names = tuple(f"{name}{k + 1}" for name in ("Fx", "Fy", "Fz", "Mx", "My", "Mz"))
        axes = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])  # of the plate, as columns: y, x and downwards
        force = np.where(own[:, None], -ground[side].force, 0.0) @ axes
        at = np.where(np.isnan(ground[side].centre), 0.0, ground[side].centre - centre) @ axes
        free = np.where(own[:, None], -ground[side].free_moment * 1000.0, 0.0) @ axes
        moment = np.cross(at - [0.0, 0.0, SENSOR_MM], force) + free
        values = np.concatenate([force, moment], 1).T
        matrix = np.diag([2.0, 2.0, 4.0, 500.0, 500.0, 300.0]) if kind == 4 else None
        if matrix is not None:
            values = np.linalg.solve(matrix, values)
        corners = square[[1, 0, 3, 2]] + centre + [*off, 0.0]
        plates.append(ForcePlate(kind, corners, np.array([0.0, 0.0, -SENSOR_MM]), names, matrix))
        channels.append(values)
    return tuple(plates), np.concatenate(channels)


def _trajectories(markers: Mapping[str, Floats], rate: float, noise: float, rng: np.random.Generator) -> Trajectories:
    cov = noise**2 * np.eye(3)
    paths = [
        MarkerTrajectory.measured(
            name, xyz + noise * rng.normal(size=xyz.shape),
            **({"cov": np.broadcast_to(cov, (len(xyz), 3, 3))} if noise else {}),
        )
        for name, xyz in markers.items()
    ]  # fmt: skip
    return Trajectories(tuple(paths), rate)
