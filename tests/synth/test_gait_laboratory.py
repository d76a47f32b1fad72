"""The virtual gait laboratory, and gait analysis against its truth."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data.subject_measures import LETTER, SIDES, LegMeasures, SubjectMeasures
from kinemark.gait import (
    Physical,
    analyse_gait,
    estimated_measures,
    foot_events,
    lower_limbs,
    marker_points,
    with_static_offsets,
)
from kinemark.gait.emg import emg
from kinemark.gait.inverse_dynamics import GRAVITY
from kinemark.synth import WalkingBody, gait_laboratory

BODIES = {
    "plain": {},
    "torsions and wands": {"torsion_deg": 22.0, "thigh_wand_deg": 9.0, "shank_wand_deg": -7.0},
    "the other way": {"torsion_deg": -14.0, "thigh_wand_deg": -11.0, "shank_wand_deg": 12.0},
}


def subject(**turned):
    left = LegMeasures(890.0, 105.0, 72.0, **turned)
    return SubjectMeasures(left, replace(left, leg_mm=880.0, torsion_deg=left.torsion_deg / 2), mass_kg=64.0)


def analysed(lab, **how):
    known = with_static_offsets(lab.body.measures, marker_points(lab.static), flat_foot=True)
    return analyse_gait(lab.walk, known, method=Physical(**how))


@pytest.mark.parametrize("body", BODIES)
def test_angles_and_joint_centres_are_the_true_ones(body):
    lab = gait_laboratory(WalkingBody(subject(**BODIES[body])), duration_s=1.0)
    known = with_static_offsets(lab.body.measures, marker_points(lab.static), flat_foot=True)
    limbs = lower_limbs(marker_points(lab.walk), known)
    for side in SIDES:
        for joint in ("hip", "knee", "ankle"):
            assert np.abs(getattr(limbs.leg(side), joint) - getattr(lab.limbs.leg(side), joint)).max() < 1e-6
    found = analysed(lab, smoothing="none")
    for signal in lab.signals:
        if signal.kind == "angle":
            np.testing.assert_allclose(found.signals[signal.name].values, signal.values, atol=1e-6)


def test_wands_and_torsions_that_are_not_told_turn_the_angles():
    turned = WalkingBody(subject(thigh_wand_deg=9.0))
    lab = gait_laboratory(turned, duration_s=1.0)
    untold = replace(lab, body=replace(turned, measures=subject()))
    off = analysed(untold, smoothing="none").signals["LHipAngles"].values - lab.signals["LHipAngles"].values
    assert 9.0 < np.median(np.abs(off[:, 2])) < 18.0, "the wand is nearer to the knee's axis than its marker"


@pytest.mark.parametrize(("kind", "smoothing"), [(2, "none"), (4, "butterworth")])
def test_moments_and_powers_are_within_a_hundredth_of_their_range(kind, smoothing):
    body = WalkingBody(subject(**BODIES["torsions and wands"]))
    lab = gait_laboratory(body, duration_s=2.4, plate_type=kind)
    found = analysed(lab, smoothing=smoothing)
    on = {one.side: slice(one.first + 1, one.stop - 1) for one in found.contacts}
    assert set(on) == set(SIDES) and not any(one.reason for one in found.contacts)
    for signal in lab.signals:
        if signal.kind in ("moment", "power"):
            side = next(side for side in SIDES if signal.name.startswith(LETTER[side]))
            true, other = signal.values[on[side]], found.signals[signal.name].values[on[side]]
            assert (np.abs(other - true).max(0) < 0.01 * np.ptp(true, axis=0)).all(), signal.name


def test_the_ground_carries_the_body_and_the_plates_tell_its_mass():
    lab = gait_laboratory(WalkingBody(subject()), duration_s=2.4)
    period = round(100.0 * lab.body.period)
    both = sum(lab.signals[f"{letter}GroundReactionForce"].values[:, 2] for letter in "LR")
    assert both[20 : 20 + period].mean() == pytest.approx(GRAVITY, rel=0.01)
    assert estimated_measures(marker_points(lab.walk)).mean_leg_mm == pytest.approx(885.0, abs=30)


def test_events_and_muscles_are_found():
    lab = gait_laboratory(WalkingBody(subject()), duration_s=4.0)
    found = foot_events(lab.walk, marker_points(lab.walk))
    plates = [e for e in found if e.source == "plate"]
    assert len(plates) == 4
    for event in plates:  # the force crosses 20 N a little after it begins
        near = min(abs(event.time - t.time) for t in lab.events if (t.side, t.strike) == (event.side, event.strike))
        assert near < 0.02
    record = lab.walk.analog[1]
    for name, on in lab.on.items():
        active = emg(record[name], rate=record.rate, start=0.0).on
        assert (active == on).mean() > 0.9


def test_errors_have_the_size_that_is_said():
    place = {"LKNE": np.array([0.0, 0.0, 6.0])}
    body = WalkingBody(subject(), placement_mm=place)
    limbs = body.limbs(np.arange(50) / 100.0)
    off, true = (one.markers(limbs)["LKNE"] for one in (body, WalkingBody(subject())))
    np.testing.assert_allclose(np.linalg.norm(off - true, axis=1), 6.0, atol=1e-9)
    noisy = gait_laboratory(body, duration_s=0.5, noise_mm=0.5, seed=3).walk.trajectories["LKNE"]
    assert np.std(noisy.xyz - off) == pytest.approx(0.5, rel=0.2)
    assert (noisy.cov == 0.25 * np.eye(3)).all()


def test_what_makes_no_sense_is_refused():
    with pytest.raises(ValueError, match="known mass"):
        gait_laboratory(WalkingBody(replace(subject(), mass_kg=None)))
    with pytest.raises(ValueError, match="positive"):
        gait_laboratory(WalkingBody(subject()), rate=0.0)
