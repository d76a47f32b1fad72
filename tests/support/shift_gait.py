"""Cases of the shift law: gait."""

from dataclasses import replace
from functools import cache

import numpy as np

from kinemark import gait
from kinemark.data import Analog, ForcePlate, MarkerTrajectory, Trajectories, Trial
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.synth import WalkingBody, walking
from support.shift_law import Answer, law, moved, on_grid

LEG = LegMeasures(890.0, 105.0, 72.0)
MEASURES = SubjectMeasures(LEG, LEG, mass_kg=70.0)
RATE = 100.0


@moved.register
def _(trial: Trial, by):
    plates = tuple(replace(plate, corners=plate.corners + by) for plate in trial.plates)
    return replace(trial, trajectories=moved(trial.trajectories, by), plates=plates)


@cache
def stepping():
    """A walk, with a plate below one step of the left foot."""
    paths = walking(duration_s=4.0, rate=RATE, seed=1, wobble_mm=1.0).trajectories
    paths = replace(paths, paths=tuple(replace(p, xyz=on_grid(p.xyz)) for p in paths))
    at = {p.name: p.xyz for p in paths}
    middle = (at["LHEE"] + at["LTOE"])[stance(at)].mean(0) / 2 * (1, 1, 0)
    square = np.array([[300.0, -300, 0], [300, 300, 0], [-300, 300, 0], [-300, -300, 0]])
    corners = on_grid(middle + square)
    push = np.zeros((6, paths.n_frames))
    push[2, stance(at)] = -600.0 * np.sin(np.linspace(0.1, 3.0, len(push[2, stance(at)])))
    names = tuple("123456")
    plate = ForcePlate(2, corners, np.array([0.0, 0.0, -40.0]), names)
    return Trial("walk", paths, (Analog(names, ("N",) * 3 + ("N·mm",) * 3, RATE, push),), (plate,))


def stance(at):
    """Frames of the one step, between two swings of the left foot."""
    v = np.linalg.norm(np.gradient(at["LHEE"] + at["LTOE"], axis=0), axis=1) / 2 * RATE
    still = np.flatnonzero(v < 300.0)
    first = next(k for k in still if k > 150 and v[k - 1] >= 300.0)
    return slice(first, next(k for k in range(first, len(v)) if v[k] >= 300.0))


def at(by):
    return gait.marker_points(moved(stepping(), by))


def limbs(by):
    return gait.lower_limbs(at(by), MEASURES)


def plates(by):
    walk = moved(stepping(), by)
    return [gait.reaction(p, walk.analog, n_frames=walk.trajectories.n_frames, rate=RATE) for p in walk.plates]


def turned(one):
    """Axes of all segments."""
    legs = (one.left, one.right)
    return one.pelvis.R, [part.R for leg in legs for part in (leg.thigh, leg.shank, leg.shank_at_knee, leg.foot)]


@law(gait.lower_limbs, gait.clinical_angles, gait.progression, gait.marker_points)
def _(by):
    one = limbs(by)
    joints = [(leg.hip, leg.knee, leg.ankle) for leg in (one.left, one.right)]
    return Answer((one.pelvis.origin, joints), (turned(one), gait.clinical_angles(one), gait.progression(one)))


@law(gait.with_static_offsets)
def _(by):
    found = gait.with_static_offsets(MEASURES, at(by), flat_foot=True)
    return Answer(rest=(found.left.plantar_offset_deg, found.right.rotation_offset_deg, found.asis_mm))


@law(gait.functional_hip, gait.with_functional_hips, mm=1e-6, share=1e-6)
def _(by):
    body = WalkingBody(MEASURES)
    swung = {name: on_grid(xyz) + by for name, xyz in body.markers(body.swinging(np.arange(240) / 10.0)).items()}
    found = gait.functional_hip(swung, "left", tissue_mm=0.1)
    measures = gait.with_functional_hips(MEASURES, [found])
    return Answer(rest=(found.place, found.sd, np.array(measures.left.hip_mm)))


@law(gait.standard_trial, gait.with_heels, gait.estimated_measures)
def _(by):
    barefoot = moved(stepping(), by)
    barefoot = replace(barefoot, trajectories=barefoot.trajectories.select(
        [n for n in barefoot.trajectories.names if n[1:] != "HEE"]))  # fmt: skip
    found = gait.with_heels(gait.standard_trial(barefoot), at(by))
    points = gait.marker_points(found.trial)
    return Answer((points["LHEE"],), (found.turn, found.heels, gait.estimated_measures(points)))


@law(gait.calibrated_body, gait.with_landmarks, gait.with_wands, mm=1e-6, share=1e-6)
def _(by):
    lean = WalkingBody(MEASURES, plated=("left thigh",), worn=("KNM",))
    stood = {name: on_grid(xyz) + by for name, xyz in lean.markers(lean.standing(3), walking=False).items()}
    shown = gait.with_wands({name: xyz for name, xyz in stood.items() if name != "LTHI"})
    plate = {"left thigh": ("LTH1", "LTH2", "LTH3", "LTH4")}
    steps = {name: on_grid(xyz) + by for name, xyz in lean.markers(lean.limbs(np.arange(4) / 10.0)).items()}
    body = gait.calibrated_body(stood, MEASURES, plate)
    limbs = body.limbs(steps, MEASURES, hip_centre="davis")
    paths = tuple(MarkerTrajectory.measured(name, xyz) for name, xyz in steps.items() if name != "LKNE")
    walk = gait.standard_trial(Trial("walk", Trajectories(paths, 10.0)), turn=np.eye(3))
    carried = gait.marker_points(gait.with_landmarks(walk, stood, plate).trial)
    return Answer((shown["LTHI"], limbs.left.knee, carried["LKNE"]), (turned(limbs), body.misfit(steps)))


@law(gait.mass_on_plates, share=1e-6)
def _(by):
    events = gait.foot_events(moved(stepping(), by), at(by))
    found = plates(by)
    return Answer(rest=gait.mass_on_plates(found, gait.contacts(found, at(by), rate=RATE), events, rate=RATE))


@law(gait.reaction, gait.contacts)
def _(by):
    (one,) = plates(by)
    (found,) = gait.contacts([one], at(by), rate=RATE)
    assert found.side == "left" and not found.reason
    return Answer((one.centre, one.corners), (one.force, one.free_moment, one.loaded, found))


@law(gait.joint_loads, gait.clinical_moment, gait.clinical_force, share=1e-7)
def _(by):
    one, (plate,) = limbs(by), plates(by)
    contact = gait.GroundContact(plate.force, plate.centre, plate.free_moment)
    found = gait.joint_loads(one.left, one.pelvis, contact, mass_kg=70.0, foot_mm=200.0, rate=RATE,
                             inertia=gait.INERTIAS["winter"])  # fmt: skip
    rest = {
        joint: (load.force, load.moment, load.power, gait.clinical_moment(load, joint, "left", 70.0),
                gait.clinical_force(load, joint, 70.0))
        for joint, load in found.items()
    }  # fmt: skip
    return Answer(rest=rest)


@law(gait.analyse_gait, share=1e-6)
def _(by):
    found = gait.analyse_gait(moved(stepping(), by), MEASURES)
    assert np.nanmax(found.signals["LAnkleMoment"].values[:, 0]) > 0.1
    return Answer(found.limbs.left.knee, {signal.name: signal.values for signal in found.signals})


@law(gait.foot_events, gait.strides, share=1e-6)
def _(by):
    found = gait.foot_events(moved(stepping(), by), at(by))
    assert {event.source for event in found} == {"plate", "markers"}
    return Answer(rest=(found, gait.strides(found, at(by), rate=RATE)))
