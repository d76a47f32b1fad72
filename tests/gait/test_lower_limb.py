"""Laws of the conventional gait model on a subject whose joints are known."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.gait import Physical, PlugInGait, clinical_angles, lower_limbs, progression, with_static_offsets
from kinemark.gait.gait_trial import Inputs, gait_of
from kinemark.gait.progression import way_walked
from kinemark.gait.segments import joint_centre, unit
from kinemark.kinematics import turned
from kinemark.synth import WalkingBody
from support.standing import walker

LEG = LegMeasures(leg_mm=900.0, knee_mm=100.0, ankle_mm=70.0, plantar_offset_deg=12.0, rotation_offset_deg=4.0)
MEASURES = SubjectMeasures(LEG, LEG, mass_kg=70.0)


def test_the_joint_is_at_half_its_width_from_the_marker_and_square_to_the_segment():
    above, lateral, wand = np.array([[0.0, 0, 400], [60, 0, 0], [40, 30, 200]])
    K = joint_centre(above, lateral, wand, half_width_mm=50.0)
    assert np.linalg.norm(K - lateral) == pytest.approx(50)
    assert (K - lateral) @ (K - above) == pytest.approx(0, abs=1e-9)
    assert np.linalg.det([K - above, lateral - above, wand - above]) == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize("outwards", [1.0, -1.0])
@pytest.mark.parametrize("deg", [-20.0, 3.0, 15.0])
def test_a_wand_that_is_turned_is_turned_back(deg, outwards):
    knee, hip = np.zeros(3), np.array([0.0, 0, 400])
    lateral = np.array([0.0, 50 * outwards, 0])
    angle = np.radians(deg)  # outwards is backwards beside the knee, on both sides
    wand = np.array([-80 * np.sin(angle), 80 * np.cos(angle) * outwards, 200])
    found = joint_centre(hip, lateral, wand, half_width_mm=50.0, wand_deg=deg, outwards=outwards)
    assert np.linalg.norm(found - knee) < 1e-6
    assert np.linalg.norm(joint_centre(hip, lateral, wand, half_width_mm=50.0) - knee) > 1.0


def test_a_mirrored_subject_has_the_angles_of_the_other_leg():
    points = walker(1)
    other = {"L": "R", "R": "L"}
    mirrored = {other.get(n[0], n[0]) + n[1:] if n != "SACR" else n: x * (1, -1, 1) for n, x in points.items()}
    ours, theirs = (clinical_angles(lower_limbs(p, MEASURES)) for p in (points, mirrored))
    for name, deg in ours.items():
        np.testing.assert_allclose(theirs[other[name[0]] + name[1:]], deg, atol=1e-9)


@pytest.mark.parametrize("turn", [90.0, 180.0, 270.0])
def test_angles_do_not_hang_on_where_the_walk_goes(turn):
    points = walker(2)
    R = turned(np.array([0.0, 0.0, turn]), "xyz")
    elsewhere = {name: x @ R.T + (1e4, -2e4, 50) for name, x in points.items()}
    ours, theirs = (clinical_angles(lower_limbs(p, MEASURES)) for p in (points, elsewhere))
    for name, deg in ours.items():
        np.testing.assert_allclose(theirs[name], deg, atol=1e-7)


def test_torsion_turns_the_knee_and_leaves_the_ankle():
    points, twisted = walker(3), replace(MEASURES, left=replace(LEG, torsion_deg=20.0))
    plain, turned_back = (clinical_angles(lower_limbs(points, m)) for m in (MEASURES, twisted))
    for name in ("LHipAngles", "LAnkleAngles", "RKneeAngles"):
        np.testing.assert_array_equal(plain[name], turned_back[name])
    change = turned_back["LKneeAngles"][:, 2] - plain["LKneeAngles"][:, 2]
    np.testing.assert_allclose(change, 20.0, atol=1e-9)


def test_in_the_static_trial_a_flat_foot_is_level():
    points = walker(4, n=1)
    measures = with_static_offsets(MEASURES, points, flat_foot=True)
    foot = lower_limbs(points, measures).left.foot
    assert abs(foot.R[0, 2, 2]) < 2e-3  # only the third angle, which is dropped, tilts it


def test_what_is_missing_is_named():
    points = walker()
    del points["LKNE"], points["SACR"]
    with pytest.raises(KinemarkError, match=r"LKNE, SACR \(or LPSI and RPSI\)"):
        lower_limbs(points, MEASURES)


def test_a_laboratory_without_wands_is_told_of_clusters():
    points = walker()
    del points["LTHI"], points["RTIB"]
    with pytest.raises(KinemarkError, match='--cluster "left thigh=A,B,C", and likewise for the right shank'):
        lower_limbs(points, MEASURES)


def test_a_measure_in_metres_is_refused():
    with pytest.raises(KinemarkError, match="millimetres"):
        LegMeasures(leg_mm=0.9, knee_mm=100, ankle_mm=70)


def test_a_missing_marker_leaves_its_own_leg_alone_missing():
    points = walker(5)
    points["LTIB"][3] = np.nan
    found = clinical_angles(lower_limbs(points, MEASURES))
    assert np.isnan(found["LKneeAngles"][3]).all() and np.isfinite(found["LHipAngles"][3]).all()
    assert np.isfinite(found["RKneeAngles"]).all() and np.isnan(unit(np.zeros(3))).all()


@pytest.mark.parametrize("turn", [20.0, 45.0, -130.0])
@pytest.mark.parametrize("treadmill", [False, True])
def test_the_pelvis_is_seen_from_the_way_where_this_lies_across_the_laboratory(turn, treadmill):
    """Also on a treadmill, where the pelvis stays; Plug-in Gait sees it from an axis of the laboratory."""
    body = WalkingBody(MEASURES)
    points = body.markers(body.limbs(np.arange(0.0, 2.4, 0.02)))
    along = clinical_angles(lower_limbs(points, MEASURES))
    R = turned(np.array([0.0, 0.0, turn]), "xyz")
    belt = np.linspace(0, 1, 120)[:, None] * (points["LASI"][-1] - points["LASI"][0]) * (1, 0, 0)
    limbs = lower_limbs({name: (xyz - treadmill * belt) @ R.T for name, xyz in points.items()}, MEASURES)
    across, theirs = clinical_angles(limbs, lab=way_walked(limbs, rate=50.0)), clinical_angles(limbs)
    for name in ("LPelvisAngles", "RFootProgressAngles"):
        assert np.abs(across[name] - along[name]).max() < 2.0, name  # the way sways about its axis
        assert np.abs(theirs[name] - along[name]).max() > 15.0, name


@pytest.mark.parametrize("deg_a_metre", [40.0, -60.0])
def test_in_a_turn_the_pelvis_is_seen_from_the_way_at_each_moment(deg_a_metre):
    body = WalkingBody(MEASURES)
    points = body.markers(body.limbs(np.arange(0.0, 3.0, 0.02)))
    along = clinical_angles(lower_limbs(points, MEASURES))
    x = (points["LASI"][:, :1] + points["RASI"][:, :1]) / 2  # mm, of the way
    radius = 1000 / np.radians(deg_a_metre)
    a = (x - x[0]) / radius
    R = turned(np.column_stack([np.zeros((len(a), 2)), np.degrees(a)]), "xyz")
    at = np.column_stack([radius * np.sin(a), radius * (1 - np.cos(a)), np.zeros(len(a))])
    bent = {name: np.einsum("fij,fj->fi", R, xyz - x * (1, 0, 0)) + at for name, xyz in points.items()}
    limbs = lower_limbs(bent, MEASURES)
    found, theirs = clinical_angles(limbs, lab=way_walked(limbs, rate=50.0)), clinical_angles(limbs)
    off = found["LPelvisAngles"] - along["LPelvisAngles"]
    assert np.abs(off[25:-25]).max() < 4.0 and np.abs(off).max() < 20.0  # half a second is half a window at the ends
    assert np.abs(theirs["LPelvisAngles"] - along["LPelvisAngles"]).max() > 30.0
    np.testing.assert_allclose(found["LKneeAngles"], along["LKneeAngles"], atol=1e-6)


def test_who_drifts_on_a_treadmill_does_not_turn():
    """By almost two metres in a minute, back and forth."""
    body = WalkingBody(MEASURES)
    time = np.arange(0.0, 60.0, 0.02)
    points = body.markers(body.limbs(time))
    x = (points["LASI"][:, :1] + points["RASI"][:, :1]) / 2
    drift = np.column_stack([-x[:, 0] + 900 * np.sin(2 * np.pi * time / 60.0), np.zeros((len(time), 2))])
    lab = way_walked(lower_limbs({name: xyz + drift for name, xyz in points.items()}, MEASURES), rate=50.0)
    np.testing.assert_allclose(lab, np.eye(3), atol=1e-9)


def test_of_the_methods_only_plug_in_gait_sees_the_pelvis_from_an_axis_of_the_laboratory():
    points = {name: xyz @ turned(np.array([0.0, 0.0, 30.0]), "xyz").T for name, xyz in walker(6, n=40).items()}
    given = Inputs(points, MEASURES, (), (), rate=50.0)
    limbs = lower_limbs(points, MEASURES)
    for method, lab in ((Physical(), way_walked(limbs, rate=50.0)), (PlugInGait(), progression(limbs))):
        found = gait_of(given, method.mechanics).signals["LPelvisAngles"].values
        np.testing.assert_array_equal(found, clinical_angles(limbs, lab=lab)["LPelvisAngles"])
