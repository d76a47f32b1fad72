"""What a walk gives: segments, angles, reactions, moments and powers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..data import Signal, Signals, Trial
from ..data.array_types import Bools, Floats
from ..data.method import Stage
from ..data.short_repr import ShortRepr
from ..data.strides import FootEvent
from ..data.subject_measures import LETTER, SIDES, Side, SubjectMeasures
from ..kinematics.chain import points_of
from ..numerics.runs import true_runs
from .clinical_angles import READINGS, clinical_angles
from .clinical_moments import clinical_force, clinical_moment
from .clusters import CalibratedBody
from .hip_centre import HipCentre
from .inverse_dynamics import Derivative, GroundContact, JointLoad, joint_loads, twice_five_point
from .lower_limb import LowerLimbs, lower_limbs
from .plate_contacts import Contact, contacts
from .progression import progression, way_walked
from .reaction import Reaction, plate_axes, reaction
from .segment_inertia import SegmentInertia
from .upper_body import UPPER_BODY_AXES, upper_body_angles

GAIT = Stage("gait", "kinemark.gait", default="physical", meaning="angles, moments and powers of walking")
"""Called as `function(trial, measures, method=…)` with a `Trial` whose markers have names, and give a `GaitTrial`."""

MOMENT_AXES = {
    "Ankle": ("plantarflexion", "abduction", "rotation"),
    "Knee": ("extension", "abduction", "rotation"),
    "Hip": ("extension", "abduction", "rotation"),
}
"""What positive moments do to the distal segment, by joint; rotation is external."""
REACTION = "GroundReactionForce"
"""After L or R; conventional."""
REACTION_AXES = ("anterior", "medial", "vertical")
"""Where the floor pushes the foot, as the subject walks."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class GaitTrial(ShortRepr):
    """One trial.

    Attributes:
        limbs: segments over frames.
        reactions: of the plates; contacts: loads on them, and whose.
        loads: force, moment and power by "LAnkle", "RHip", …; of feet whose contacts count.
        signals: angles, ground reactions, forces, moments and powers under the usual names.
        way: (3, 3), or (F, 3, 3) where it bends, forward, left and up as columns: from where pelvis and feet are seen.
    """

    limbs: LowerLimbs
    reactions: tuple[Reaction, ...]
    contacts: tuple[Contact, ...]
    loads: Mapping[str, JointLoad]
    signals: Signals
    way: Floats


def analyse_gait(
    trial: Trial, measures: SubjectMeasures, *, method: Any = None, body: CalibratedBody | None = None
) -> GaitTrial:
    """Segments, angles, ground reactions, moments and powers of a trial.

    Args:
        trial: with named markers, mm; plates and channels where there are.
        measures: of the subject, with the offsets of the feet.
        method: one of `GAIT`; `Physical()` where None.
        body: clusters that show segments; by the model's markers alone where None.

    Raises:
        KinemarkError: a marker is missing, or a plate cannot be read.
        ValueError: the method is none of gait analysis.
    """
    method = GAIT.make() if method is None else method
    found: GaitTrial = GAIT.function(method)(trial, measures, method=method, body=body)
    return found


class Mechanics(NamedTuple):
    """What the methods of gait analysis differ in.

    Attributes:
        hip_centre: regression of the hip.
        inertia: of foot, shank and thigh.
        rotation_derivative: of the axes of segments.
        counts: reasons for which a contact of a foot with a plate still counts.
        acceleration: of centres of mass.
        along_way: pelvis and feet are seen from the way walked, and not from the laboratory's axis nearest to it.
    """

    hip_centre: HipCentre
    inertia: Mapping[str, SegmentInertia]
    rotation_derivative: Derivative
    counts: Sequence[str]
    acceleration: Derivative = twice_five_point
    along_way: bool = True


class Inputs(NamedTuple):
    """What gait follows from.

    Attributes:
        points: (F, 3) mm by name. measures: of the subject.
        reactions: of the plates. contacts: on them. rate: frames a second.
        body: clusters that show segments, where there are.
    """

    points: Mapping[str, Floats]
    measures: SubjectMeasures
    reactions: tuple[Reaction, ...]
    contacts: tuple[Contact, ...]
    rate: float
    body: CalibratedBody | None = None


def inputs_of(
    trial: Trial, points: Mapping[str, Floats], measures: SubjectMeasures, *, threshold_n: float,
    zeroed: bool = False, force_cutoff_hz: float | None = None, body: CalibratedBody | None = None,
) -> Inputs:  # fmt: skip
    """Of a trial whose markers are at `points` (F, 3) mm; of the plates what `reaction` says."""
    rate, n = trial.trajectories.rate, trial.trajectories.n_frames
    plates = tuple(
        reaction(
            plate, trial.analog, n_frames=n, rate=rate, threshold_n=threshold_n, zeroed=zeroed,
            cutoff_hz=force_cutoff_hz,
        )
        for plate in trial.plates
    )  # fmt: skip
    return Inputs(points, measures, plates, contacts(plates, points, rate=rate), rate, body=body)


def gait_of(given: Inputs, how: Mechanics) -> GaitTrial:
    """Segments, loads and all quantities."""
    limbs = limbs_of(given, how.hip_centre)
    on = {side: ground_contact(side, given.reactions, given.contacts, how.counts) for side in SIDES}
    loads = leg_loads(limbs, on, given, how)
    lab = way_walked(limbs, rate=given.rate) if how.along_way else progression(limbs)
    angles = clinical_angles(limbs, lab=lab)
    angles |= upper_body_angles(given.points, given.measures, limbs.pelvis, lab)
    signals = signals_of(angles, loads, on, given.measures.mass_kg, rate=given.rate)
    taken = given.contacts if "shared" in how.counts else tuple(one.apart for one in given.contacts)
    return GaitTrial(limbs, given.reactions, taken, loads, signals, lab)


def limbs_of(given: Inputs, hip_centre: HipCentre) -> LowerLimbs:
    """Segments, by clusters where there are."""
    if given.body is not None:
        return given.body.limbs(given.points, given.measures, hip_centre=hip_centre)
    return lower_limbs(given.points, given.measures, hip_centre=hip_centre)


def leg_loads(
    limbs: LowerLimbs, on: Mapping[Side, GroundContact], given: Inputs, how: Mechanics
) -> dict[str, JointLoad]:
    """Loads of both legs by "LAnkle", …; none where there are no plates or no mass."""
    found: dict[str, JointLoad] = {}
    mass = given.measures.mass_kg
    for side in SIDES if mass and given.reactions else ():
        loads = joint_loads(
            limbs.leg(side), limbs.pelvis, on[side], mass_kg=mass or np.nan,
            foot_mm=foot_length(given.points, given.measures, side), rate=given.rate, inertia=how.inertia,
            rotation_derivative=how.rotation_derivative, acceleration=how.acceleration,
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
    sum_of = GroundContact(np.zeros((n, 3)), np.full((n, 3), np.nan), np.zeros((n, 3)))
    for one in contacts:
        plate, own = reactions[one.plate], np.zeros(n, np.bool_)
        own[one.first : one.stop] = True
        if one.side == side and one.reason in counts:
            sum_of = _added(sum_of, plate, own)
            sum_of.force[_beside(one, plate.unknown)] = np.nan
        elif one.side in (side, None):
            sum_of.force[own] = np.nan
    return sum_of


def _added(foot: GroundContact, plate: Reaction, own: Bools) -> GroundContact:
    """What the floor does to a foot, and a plate in the frames `own` (F) besides: the force of both acts where their
    vertical parts weigh the centres of pressure, and the levers from there add to the free moments."""
    vertical = plate_axes(plate.corners)[0][:, 2]
    new = own & np.isfinite(plate.centre).all(1)
    both = new & np.isfinite(foot.centre).all(1)
    force = foot.force + np.where(own[:, None], plate.force, 0.0)
    free = foot.free_moment + np.where(own[:, None], plate.free_moment, 0.0)
    centre = np.where(new[:, None], plate.centre, foot.centre)
    p, q = foot.centre[both], plate.centre[both]
    share = (plate.force[both] @ vertical) / (force[both] @ vertical)
    centre[both] = p + share[:, None] * (q - p)
    levers = np.cross(p - centre[both], foot.force[both]) + np.cross(q - centre[both], plate.force[both])
    free[both] += levers / 1000.0
    return GroundContact(force, centre, free)


def _beside(contact: Contact, unknown: Bools) -> Bools:
    """(F) unknown frames without a break before or after a contact: the foot may still stand there."""
    runs = [run for run in true_runs(unknown) if contact.first == run[1] or contact.stop == run[0]]
    found = np.zeros(len(unknown), np.bool_)
    for first, stop in runs:
        found[first:stop] = True
    return found


def measured_only(found: GaitTrial, events: Sequence[FootEvent], counts: Sequence[str], rate: float) -> GaitTrial:
    """Loads are NaN while a foot stands on the floor beside all plates: what the floor does to it is not known.

    Args:
        found: of the trial. events: of its feet. counts: reasons for which a contact counts. rate: frames a second.
    """
    unknown = {side: _unmeasured(found, events, side, counts, rate) for side in SIDES}
    out = []
    for signal in found.signals:
        side = next((side for side in SIDES if signal.name.startswith(LETTER[side])), None)
        if side is not None and signal.kind in ("force", "moment", "power"):
            hidden = unknown[side][:, None]
            signal = replace(signal, values=np.where(hidden, np.nan, signal.values))
        out.append(signal)
    return replace(found, signals=Signals(tuple(out)))


def _unmeasured(found: GaitTrial, events: Sequence[FootEvent], side: Side, counts: Sequence[str], rate: float) -> Bools:
    """(F) frames in which a foot stands, but on no plate."""
    n = len(found.limbs.pelvis.origin)
    hidden = np.zeros(n, bool)
    own = [one for one in found.contacts if one.side == side and one.reason in counts]
    for first, stop in _stances(events, side, n, rate):
        on = sum(max(0, min(stop, one.stop) - max(first, one.first)) for one in own)
        if on < 0.5 * (stop - first):
            hidden[first:stop] = True
    return hidden


def _stances(events: Sequence[FootEvent], side: Side, n: int, rate: float) -> list[tuple[int, int]]:
    """First and last-plus-one frame of each time a foot stands; all frames where nothing is known of it."""
    own = sorted((e for e in events if e.side == side), key=lambda e: e.time)
    if not own:
        return [(0, n)]
    strikes = ([] if own[0].strike else [0]) + [round(e.time * rate) for e in own if e.strike]
    offs = [round(e.time * rate) + 1 for e in own if not e.strike] + ([n] if own[-1].strike else [])
    return [(a, min((b for b in offs if b > a), default=n)) for a in strikes]


def signals_of(
    angles: Mapping[str, Floats], loads: Mapping[str, JointLoad], contact: Mapping[Side, GroundContact],
    mass_kg: float | None, *, rate: float,
) -> Signals:  # fmt: skip
    """All quantities under the usual names, as `LKneeAngles`, `LKneeMoment`, `LKneePower`, `LGroundReactionForce`."""
    axes = {reading.name: reading.axes for reading in READINGS} | UPPER_BODY_AXES
    out = [
        Signal.of(name, "angle", "deg", deg, rate=rate, axes=axes[name[1:].removesuffix("Angles")])
        for name, deg in angles.items()
    ]
    if mass_kg is None:
        return Signals(tuple(out))
    for side, one in contact.items():
        if len(one.force):
            out.append(Signal.of(f"{LETTER[side]}{REACTION}", "force", "N/kg", one.force / mass_kg, rate=rate))
    for name, load in loads.items():
        side, joint = ("left" if name[0] == "L" else "right"), name[1:]
        moment = clinical_moment(load, joint, side, mass_kg)
        out.append(Signal.of(f"{name}Force", "force", "N/kg", clinical_force(load, joint, mass_kg), rate=rate))
        out.append(Signal.of(f"{name}Moment", "moment", "N·m/kg", moment, rate=rate, axes=MOMENT_AXES[joint]))
        power = load.power[:, None] / mass_kg
        out.append(Signal.of(f"{name}Power", "power", "W/kg", power, rate=rate, axes=("power",)))
    return Signals(tuple(out))


def along_way(found: GaitTrial) -> Signals:
    """The signals with ground reactions by `REACTION_AXES`, so that walks in different directions can be averaged, and
    left be laid upon right; in the laboratory's axes one way takes away what the other adds."""
    return Signals(tuple(_along(s, found.way) if s.name.endswith(REACTION) else s for s in found.signals))


def _along(force: Signal, way: Floats) -> Signal:
    """A ground reaction by `REACTION_AXES`."""
    medial = -1.0 if force.name.startswith(LETTER["left"]) else 1.0
    axes = way * (1.0, medial, 1.0)
    values = (force.values[:, None] @ axes)[:, 0]
    return replace(force, axes=REACTION_AXES, values=values, cov=np.swapaxes(axes, -1, -2) @ force.cov @ axes)


def marker_points(trial: Trial) -> dict[str, Floats]:
    """(F, 3) mm by name, a subject's prefix ("Anna:LASI") left out."""
    return {name.rsplit(":", 1)[-1]: xyz for name, xyz in points_of(trial.trajectories).items()}
