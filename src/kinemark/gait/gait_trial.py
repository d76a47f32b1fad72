"""What a walk gives: segments, angles, reactions, moments and powers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..data import Signal, Signals, Trial
from ..data.array_types import Floats
from ..data.subject_measures import LETTER, SIDES, Side, SubjectMeasures
from ..kinematics.chain import points_of
from .clinical_angles import READINGS, clinical_angles
from .clinical_moments import clinical_force, clinical_moment
from .inverse_dynamics import Derivative, GroundContact, JointLoad, joint_loads
from .lower_limb import LowerLimbs
from .plate_contacts import Contact
from .reaction import Reaction
from .segment_inertia import SegmentInertia
from .stage import GAIT

MOMENT_AXES = {
    "Ankle": ("plantarflexion", "adduction", "rotation"),
    "Knee": ("extension", "adduction", "rotation"),
    "Hip": ("extension", "adduction", "rotation"),
}
"""What moments do, by joint."""


@dataclass(frozen=True, slots=True, eq=False)
class GaitTrial:
    """One trial.

    Attributes:
        limbs: segments over frames.
        reactions: of the plates; contacts: loads on them, and whose.
        loads: force, moment and power by "LAnkle", "RHip", …; of feet whose contacts count.
        signals: angles, ground reactions, forces, moments and powers under the usual names.
    """

    limbs: LowerLimbs
    reactions: tuple[Reaction, ...]
    contacts: tuple[Contact, ...]
    loads: Mapping[str, JointLoad]
    signals: Signals


def analyse_gait(trial: Trial, measures: SubjectMeasures, *, method: Any = None) -> GaitTrial:
    """Segments, angles, ground reactions, moments and powers of a trial.

    Args:
        trial: with named markers, mm; plates and channels where there are.
        measures: of the subject, with the offsets of the feet.
        method: one of `GAIT`; `Physical()` where None.

    Raises:
        KinemarkError: a marker is missing, or a plate cannot be read.
        ValueError: the method is none of gait analysis.
    """
    method = GAIT.make() if method is None else method
    found: GaitTrial = GAIT.function(method)(trial, measures, method=method)
    return found


def leg_loads(
    limbs: LowerLimbs,
    reactions: Sequence[Reaction],
    contacts: Sequence[Contact],
    points: Mapping[str, Floats],
    measures: SubjectMeasures,
    *,
    rate: float,
    counts: Sequence[str],
    inertia: Mapping[str, SegmentInertia],
    rotation_derivative: Derivative,
    up: Floats,
) -> dict[str, JointLoad]:
    """Loads of both legs by "LAnkle", … where a mass is known; NaN in frames of contacts that do not count.

    Args:
        limbs: of F frames. reactions: of the plates. contacts: on them.
        points: (F, 3) mm by name. measures: of the subject. rate: frames a second.
        counts: reasons for which a contact still counts.
        inertia: of foot, shank and thigh. rotation_derivative: of axes. up: of the laboratory.
    """
    found: dict[str, JointLoad] = {}
    for side in SIDES if measures.mass_kg else ():
        loads = joint_loads(
            limbs.leg(side), limbs.pelvis, ground_contact(side, reactions, contacts, counts),
            mass_kg=measures.mass_kg or np.nan, foot_mm=foot_length(points, measures, side), rate=rate, inertia=inertia,
            rotation_derivative=rotation_derivative, up=up,
        )  # fmt: skip
        found |= {LETTER[side] + joint: load for joint, load in loads.items()}
    return found


def foot_length(points: Mapping[str, Floats], measures: SubjectMeasures, side: Side) -> float:
    """mm from heel to toe without half a marker (Plug-in Gait)."""
    length = np.linalg.norm(points[LETTER[side] + "TOE"] - points[LETTER[side] + "HEE"], axis=-1)
    known = length[np.isfinite(length)]
    return float(known.mean()) - measures.marker_diameter_mm / 2 if len(known) else np.nan


def ground_contact(
    side: Side, reactions: Sequence[Reaction], contacts: Sequence[Contact], counts: Sequence[str]
) -> GroundContact:
    """What the plates do to one foot: 0 in the air, NaN while it may stand on a plate in a way that does not count."""
    n = len(reactions[0].loaded) if reactions else 0
    force, centre, free = np.zeros((n, 3)), np.full((n, 3), np.nan), np.zeros((n, 3))
    for one in contacts:
        frames = slice(one.first, one.stop)
        plate = reactions[one.plate]
        if one.side == side and one.reason in counts:
            force[frames], free[frames] = plate.force[frames], plate.free_moment[frames]
            centre[frames] = plate.centre[frames]
        elif one.side in (side, None):
            force[frames] = np.nan
    return GroundContact(force, centre, free)


def signals_of(
    limbs: LowerLimbs, loads: Mapping[str, JointLoad], contact: Mapping[Side, GroundContact], mass_kg: float | None,
    *, rate: float, up: Floats,
) -> Signals:  # fmt: skip
    """All quantities under the usual names, as `LKneeAngles`, `LKneeMoment`, `LKneePower`, `LGroundReactionForce`."""
    axes = {reading.name: reading.axes for reading in READINGS}
    out = [
        Signal.of(name, "angle", "deg", deg, rate=rate, axes=axes[name[1:].removesuffix("Angles")])
        for name, deg in clinical_angles(limbs, up=up).items()
    ]
    if mass_kg is None:
        return Signals(tuple(out))
    for side, one in contact.items():
        if len(one.force):
            out.append(Signal.of(f"{LETTER[side]}GroundReactionForce", "force", "N/kg", one.force / mass_kg, rate=rate))
    for name, load in loads.items():
        side, joint = ("left" if name[0] == "L" else "right"), name[1:]
        moment = clinical_moment(load, joint, side, mass_kg)
        out.append(Signal.of(f"{name}Force", "force", "N/kg", clinical_force(load, joint, mass_kg), rate=rate))
        out.append(Signal.of(f"{name}Moment", "moment", "N·m/kg", moment, rate=rate, axes=MOMENT_AXES[joint]))
        power = load.power[:, None] / mass_kg
        out.append(Signal.of(f"{name}Power", "power", "W/kg", power, rate=rate, axes=("power",)))
    return Signals(tuple(out))


def marker_points(trial: Trial) -> dict[str, Floats]:
    """(F, 3) mm by name, a subject's prefix ("Anna:LASI") left out."""
    return {name.rsplit(":", 1)[-1]: xyz for name, xyz in points_of(trial.trajectories).items()}
