"""The hip by motion: where a virtual laboratory has it, and as surely as is said."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.data.subject_measures import LETTER, SIDES, TO_THE_LEFT, LegMeasures, SubjectMeasures
from kinemark.gait import Physical, functional_hip, lower_limbs, marker_points, with_functional_hips
from kinemark.gait.functional_hip import gamage
from kinemark.gait.segments import relative
from kinemark.gait.uncertainty import GaitErrors, gait_uncertainty
from kinemark.kinematics import principal
from kinemark.synth import WalkingBody, gait_laboratory

LEG = LegMeasures(leg_mm=890.0, knee_mm=105.0, ankle_mm=72.0)
MEASURES = SubjectMeasures(LEG, LEG, mass_kg=70.0)
OFF = {"left": np.array([9.0, -12.0, 15.0]), "right": np.array([-14.0, 8.0, -11.0])}


def swung(body, *, tissue_mm=0.0, noise_mm=0.0, rng=None):
    """(F, 3) mm of markers, three more on each thigh, with skin that moves as the hip turns; and the true hips."""
    rng = rng or np.random.default_rng(0)
    limbs = body.swinging(np.arange(480) / 20.0)
    at, hips = body.markers(limbs), {}
    for side in SIDES:
        leg, letter, s = limbs.leg(side), LETTER[side], TO_THE_LEFT[side]
        at[letter + "KNM"] = leg.knee - s * 60 * leg.thigh.R[..., 1]
        at[letter + "THAP"] = leg.thigh.at(np.array([70.0, 20 * s, 250.0]))
        at[letter + "THAD"] = leg.thigh.at(np.array([60.0, 30 * s, 100.0]))
        turn = principal(relative(limbs.pelvis.R, leg.thigh.R), "yxz")[:, :2]
        course = (turn - turn.mean(0)) / turn.std(0) / np.sqrt(2)
        for name in ("THI", "KNE", "KNM", "THAP", "THAD"):
            slide = tissue_mm * rng.normal(size=(2, 3))
            at[letter + name] = at[letter + name] + np.einsum("fj,ji,fki->fk", course, slide, leg.thigh.R)
        hips[side] = np.einsum("ji,j->i", limbs.pelvis.R[0], leg.hip[0] - limbs.pelvis.origin[0])
    return {name: xyz + noise_mm * rng.normal(size=xyz.shape) for name, xyz in at.items()}, hips


def two_of(points):
    """Without all that the conventional set has not."""
    return {name: xyz for name, xyz in points.items() if name[1:] not in ("KNM", "THAP", "THAD")}


@pytest.mark.parametrize("way", ["score", "spheres"])
def test_the_hip_is_where_it_is(way):
    points, hips = swung(WalkingBody(MEASURES, hip_error_mm=OFF))
    for side in SIDES:
        found = functional_hip(points if way == "score" else two_of(points), side, tissue_mm=0.0)
        assert found.way == way and found.residual < 1e-6
        np.testing.assert_allclose(found.place, hips[side], atol=1e-4)


def test_spheres_about_one_point_need_no_iteration():
    rng = np.random.default_rng(1)
    ways = rng.normal(size=(2, 200, 3))
    v = np.array([7.0, -90, 400]) + [[[300.0]], [[120.0]]] * ways / np.linalg.norm(ways, axis=-1, keepdims=True)
    np.testing.assert_allclose(gamage(v), [7, -90, 400], atol=1e-8)


@pytest.mark.parametrize(("way", "tissue"), [("score", 5.0), ("spheres", 2.0)])
def test_it_is_as_sure_as_is_said(way, tissue):
    rng, z = np.random.default_rng(4), []
    for _ in range(8):
        body = WalkingBody(replace(MEASURES, left=replace(LEG, leg_mm=rng.uniform(700, 980))), hip_error_mm=OFF)
        points, hips = swung(body, tissue_mm=tissue, noise_mm=0.3, rng=rng)
        for side in SIDES:
            try:
                found = functional_hip(points if way == "score" else two_of(points), side, tissue_mm=tissue)
            except KinemarkError:  # it says that it does not know
                continue
            z.append((found.place - hips[side]) / found.sd)
    assert len(z) > 8 and 0.7 < np.sqrt(np.mean(np.square(z))) < 1.3


def test_a_leg_that_swings_in_a_plane_or_hardly_shows_no_hip():
    lab = gait_laboratory(WalkingBody(MEASURES), duration_s=2.0, noise_mm=0.3)
    with pytest.raises(KinemarkError, match="left hip turned too little"):
        functional_hip(marker_points(lab.walk), "left")
    still = {name: xyz[:1].repeat(100, 0) for name, xyz in marker_points(lab.static).items()}
    with pytest.raises(KinemarkError, match="hip cannot be found by motion: the thigh's markers move in a plane"):
        functional_hip(still, "left")
    with pytest.raises(KinemarkError, match="no LKNE"):
        functional_hip({name: xyz for name, xyz in still.items() if name != "LKNE"}, "left")


def hips_of(lab):
    return [functional_hip(marker_points(lab.functional), side, tissue_mm=0.0) for side in SIDES]


def test_the_model_takes_it_in_place_of_the_regression():
    lab = gait_laboratory(WalkingBody(MEASURES, hip_error_mm=OFF), duration_s=0.5, rate=50.0)
    known = with_functional_hips(MEASURES, hips_of(lab))
    for measures, low, high in ((known, 0, 0.01), (MEASURES, 15, 30)):
        limbs = lower_limbs(marker_points(lab.walk), measures)
        for side in SIDES:
            off = np.linalg.norm(limbs.leg(side).hip - lab.limbs.leg(side).hip, axis=1)
            assert low <= off.max() < high


def test_its_own_error_is_on_the_curves_and_a_misplaced_pelvis_marker_leaves_it_in_the_bone():
    lab = gait_laboratory(WalkingBody(MEASURES, hip_error_mm=OFF), duration_s=0.5, rate=50.0)
    known = with_functional_hips(MEASURES, hips_of(lab))
    errors = GaitErrors(placement_mm=0, width_mm=0, tissue_mm=0, plate_mm=0, draws=0)

    def knee(measures, **changed):
        causes = gait_uncertainty(lab.walk, measures, method=Physical(smoothing="none"),
                                  errors=replace(errors, **changed))  # fmt: skip
        return {cause: np.sqrt(np.mean(of["LKneeAngles"] ** 2)) for cause, of in causes.items() if "LKneeAngles" in of}

    assert knee(known)["hip centre"] < 0.01 * knee(MEASURES)["hip centre"]
    pelvis = WalkingBody(MEASURES, hip_error_mm=OFF, placement_mm={"SACR": np.array([0.0, 0.0, 10.0])})
    misplaced = gait_laboratory(pelvis, duration_s=0.5, rate=50.0)
    again = with_functional_hips(MEASURES, hips_of(misplaced))
    there = [lower_limbs(marker_points(one.walk), m).left.hip for one, m in ((lab, known), (misplaced, again))]
    np.testing.assert_allclose(*there, atol=0.01)
    stated = gait_uncertainty(lab.walk, known, method=Physical(smoothing="none"),
                              errors=replace(errors, placement_mm=5.0))  # fmt: skip
    plain = gait_uncertainty(lab.walk, MEASURES, method=Physical(smoothing="none"),
                             errors=replace(errors, placement_mm=5.0))  # fmt: skip
    sure, unsure = (np.sqrt(np.mean(of["placement"]["LKneeAngles"][:, 0] ** 2)) for of in (stated, plain))
    assert sure < unsure
