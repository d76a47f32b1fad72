"""The conventional gait model against what Plug-in Gait stored: developers' trials of seven subjects."""

from functools import cache

import numpy as np
import pytest

from kinemark.data.subject_measures import LETTER, SIDES
from kinemark.gait import (
    INERTIAS,
    GroundContact,
    clinical_angles,
    clinical_force,
    clinical_moment,
    five_point_slope,
    joint_loads,
    lower_limbs,
    progression,
    reaction,
    spline_acceleration,
    with_static_offsets,
)
from kinemark.io.c3d.subject_measures import measures_of
from support.plug_in_gait import TRIALS, points, trial

every_trial = pytest.mark.parametrize("processed", TRIALS, ids=str)


@cache
def subject(processed):
    """Measures, with the foot offsets of the static trial."""
    static = processed.static
    return with_static_offsets(measures_of(trial(static).source), points(static), flat_foot=processed.flat)


@cache
def limbs(processed):
    return lower_limbs(points(processed.walk), subject(processed))


def stored(processed, name):
    """(F, 3) of a stored quantity, with or without the suffix V; None where there is none."""
    signals = trial(processed.walk).signals
    return next((signals[one].values for one in (name, name + "V") if one in signals.names), None)


@every_trial
def test_joint_centres_are_the_stored_ones(processed):
    own, there = limbs(processed), points(processed.walk)
    for side in SIDES:
        leg = own.leg(side)
        for ours, name, mm in ((leg.hip, "FEP", 0.005), (leg.knee, "FEO", 0.001), (leg.ankle, "TIO", 0.001)):
            assert np.nanmax(np.linalg.norm(ours - there[LETTER[side] + name], axis=1)) < mm


@every_trial
def test_angles_are_the_stored_ones_from_static_trial_and_measures_alone(processed):
    compared = 0
    for name, ours in clinical_angles(limbs(processed)).items():
        if (theirs := stored(processed, name)) is not None:
            off = np.remainder(ours - theirs + 180, 360) - 180
            assert np.nanmax(np.abs(off)) < 0.001, name
            compared += 1
    assert compared == 10


MOMENT_LIMIT = {"Ankle": (1, 1, 2), "Knee": (7, 13, 2), "Hip": (10, 13, 4)}
"""N·mm/kg, RMS of flexion, adduction, rotation."""
POWER_LIMIT = {"Ankle": 0.06, "Knee": 0.05, "Hip": 0.05}
"""W/kg, RMS."""


@pytest.mark.parametrize("processed", TRIALS[:-1], ids=str)  # the last has no plates
def test_reaction_moments_and_powers_are_the_stored_ones(processed):
    walk, own = trial(processed.walk), subject(processed)
    n, rate, mass = walk.trajectories.n_frames, walk.trajectories.rate, own.mass_kg
    plates = [reaction(plate, walk.analog, n_frames=n, rate=rate) for plate in walk.plates]
    for side in SIDES:
        letter, force = LETTER[side], stored(processed, LETTER[side] + "GroundReactionForce")
        if force is None or stored(processed, letter + "AnkleMoment") is None:
            continue
        contact, on = on_these_plates(plates, np.nan_to_num(force) * mass)
        assert np.abs(contact.force[on] / mass - force[on]).max() < 1e-4
        loads = joint_loads(
            limbs(processed).leg(side), limbs(processed).pelvis, contact, mass_kg=mass,
            foot_mm=foot_length(processed, letter), rate=rate, inertia=INERTIAS["plug_in_gait"],
            rotation_derivative=five_point_slope, acceleration=spline_acceleration,
        )  # fmt: skip
        for joint, load in loads.items():
            part = f"{letter}{joint}"
            assert (rms(clinical_force(load, joint, mass), stored(processed, part + "Force"), on) < 2e-4).all()
            moment = 1000 * clinical_moment(load, joint, side, mass)
            assert (rms(moment, stored(processed, part + "Moment"), on) < MOMENT_LIMIT[joint]).all(), part
            power = stored(processed, part + "Power")[:, 2:]
            assert (rms(load.power[:, None] / mass, power, on) < POWER_LIMIT[joint]).all(), part


def on_these_plates(plates, force):
    """The contact of one foot: of each plate where it shows the stored force; and where there is one."""
    n = len(force)
    contact = GroundContact(np.zeros((n, 3)), np.full((n, 3), np.nan), np.zeros((n, 3)))
    on = np.zeros(n, bool)
    for plate in plates:
        here = plate.loaded & (np.linalg.norm(plate.force - force, axis=1) < 1)
        for mine, theirs in zip(contact, (plate.force, plate.centre, plate.free_moment), strict=True):
            mine[here] = theirs[here]
        on |= here
    return contact, on


def foot_length(processed, letter):
    there = points(processed.walk)
    length = np.linalg.norm(there[letter + "TOE"] - there[letter + "HEE"], axis=1)
    return np.nanmean(length) - subject(processed).marker_diameter_mm / 2


def rms(ours, theirs, on):
    off = (ours - theirs)[on]
    return np.sqrt(np.nanmean(off**2, axis=0))


@pytest.mark.parametrize("processed", [*TRIALS[:10], TRIALS[-1]], ids=str)  # those with a whole body
def test_head_trunk_and_arms_are_the_stored_ones(processed):
    from kinemark.gait.upper_body import upper_body_angles

    measures = measures_of(trial(processed.walk).source)
    own = limbs(processed)
    found = upper_body_angles(points(processed.walk), measures, own.pelvis, progression(own))
    compared = 0
    for name, ours in found.items():
        if (theirs := stored(processed, name)) is not None:
            other = ours * (1, -1, 1) + 180  # the other triple of the same rotation
            off = [np.abs(np.remainder(one - theirs + 180, 360) - 180).max(1) for one in (ours, other)]
            assert np.nanmax(np.fmin(*off)) < 0.01, name
            compared += 1
    assert compared == 14
