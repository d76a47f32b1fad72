"""Axes of knees and ankles from devices and markers inside of the joints, against a subject who has them."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data.model_markers import DEVICE, INSIDE
from kinemark.data.subject_measures import LETTER, SIDES, LegMeasures, SubjectMeasures
from kinemark.gait import lower_limbs, marker_points, with_static_offsets
from kinemark.gait.gait_methods import PlugInGait
from kinemark.gait.gait_trial import gait_of, inputs_of
from kinemark.gait.static_axes import axes_shown, with_knees, with_static_axes
from kinemark.gait.static_checks import static_doubts
from kinemark.gait.uncertainty import GaitErrors, gait_uncertainty
from kinemark.synth import WalkingBody, gait_laboratory

WORN = {"device": DEVICE, "device and ankle": (*DEVICE, "MED"), "inside": INSIDE}
TURNED = ("thigh_wand_deg", "shank_wand_deg", "torsion_deg")


def subject(seed):
    """A subject with wands and torsions of their own on each leg."""
    rng = np.random.default_rng(seed)
    legs = [
        LegMeasures(rng.uniform(700, 980), rng.uniform(80, 120), rng.uniform(55, 80), torsion_deg=rng.uniform(-15, 35),
                    thigh_wand_deg=rng.uniform(-15, 15), shank_wand_deg=rng.uniform(-15, 15))
        for _ in SIDES
    ]  # fmt: skip
    return SubjectMeasures(*legs, mass_kg=60.0)


def untold(measures, *, torsion=False):
    """The measures as they are before the standing trial; torsions that no marker shows are measured."""
    own = {name: 0.0 for name in TURNED if torsion or name != "torsion_deg"}
    return replace(measures, left=replace(measures.left, **own), right=replace(measures.right, **own))


def recorded(worn, seed, **body):
    return gait_laboratory(WalkingBody(subject(seed), worn=worn, **body), duration_s=1.0, seed=seed)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("worn", WORN)
def test_wands_and_torsions_come_back_and_the_walk_is_the_true_one(worn, seed):
    lab = recorded(WORN[worn], seed)
    static = with_knees(marker_points(lab.static))
    believed = untold(lab.body.measures, torsion="MED" in WORN[worn])
    found = with_static_offsets(believed, static, flat_foot=True)
    for side in SIDES:
        for name in TURNED:
            assert getattr(found.leg(side), name) == pytest.approx(getattr(lab.body.measures.leg(side), name), abs=1e-6)
    limbs = lower_limbs(marker_points(lab.walk), found)
    for side in SIDES:
        ours, true = limbs.leg(side), lab.limbs.leg(side)
        for part in ("thigh", "shank", "shank_at_knee", "foot"):
            assert np.abs(getattr(ours, part).R - getattr(true, part).R).max() < 1e-6, part
        assert np.abs(ours.ankle - true.ankle).max() < 1e-5
    without = lower_limbs(marker_points(lab.walk), with_static_offsets(believed, static, flat_foot=True, axes=False))
    assert np.abs(without.left.thigh.R - lab.limbs.left.thigh.R).max() > 0.01


def test_the_apex_of_a_device_is_the_knees_marker_and_a_marker_of_its_own_is_kept():
    lab = recorded(DEVICE, 4)
    static = marker_points(lab.static)
    true = WalkingBody(subject(4)).markers(lab.body.standing(len(static["LASI"])), walking=False)
    assert "LKNE" not in static and axes_shown(static) == "devices"
    for name in ("LKNE", "RKNE"):
        np.testing.assert_allclose(with_knees(static)[name], true[name], atol=1e-9)
    own = static | {"LKNE": true["LKNE"] + 1.0}
    np.testing.assert_array_equal(with_knees(own)["LKNE"], own["LKNE"])


def test_without_them_nothing_changes():
    lab = recorded((), 5)
    measures = lab.body.measures
    assert axes_shown(marker_points(lab.static)) == ""
    assert with_static_axes(measures, marker_points(lab.static)) is measures


@pytest.mark.parametrize("worn", ["device and ankle", "inside"])
def test_what_placement_makes_of_them_is_as_large_as_is_said(worn):
    lab, sd = recorded(WORN[worn], 6), 4.0
    believed = untold(lab.body.measures, torsion=True)
    walk, method = lab.walk.trajectories.frames(0, 25), PlugInGait()
    trial, static = replace(lab.walk, trajectories=walk, analog=(), plates=()), with_knees(marker_points(lab.static))
    static = {name: xyz[:1] for name, xyz in static.items()}
    quiet = GaitErrors(placement_mm=sd, hip_mm=0, width_mm=0, tissue_mm=0, plate_mm=0, draws=0)
    said = gait_uncertainty(trial, believed, method=method, errors=quiet, static=static)["placement"]
    rng, found = np.random.default_rng(7), []
    still, limbs = lab.body.standing(1), lab.body.limbs(np.arange(25) / 100.0)
    for _ in range(150):
        moved, stood = dict(marker_points(trial)), dict(static)
        for name in static:
            shift = sd * rng.normal(size=3)
            if name[1:] in ("KD1", "KD2"):
                continue  # the device turns by its first rod
            moved |= {name: moved[name] + _on(limbs, name) @ shift} if name in moved else {}
            stood[name] = stood[name] + _on(still, name) @ shift
        measures = with_static_offsets(believed, stood, flat_foot=True)
        signals = gait_of(inputs_of(trial, moved, measures, threshold_n=5), method.mechanics).signals
        found.append({s.name: s.values for s in signals})
    for name in ("LHipAngles", "LKneeAngles", "RAnkleAngles"):
        seen = np.sqrt(np.mean(np.std([one[name] for one in found], axis=0) ** 2, axis=0))
        ours = np.sqrt(np.mean(said[name] ** 2, axis=0))
        moves = seen > 1e-9
        np.testing.assert_allclose(ours[moves], seen[moves], rtol=0.2, err_msg=name)


def _on(limbs, name):
    part = {"THI": "thigh", "KNE": "thigh", "KAX": "thigh", "KNM": "thigh", "TIB": "shank", "ANK": "shank",
            "MED": "shank", "HEE": "foot", "TOE": "foot"}.get(name[1:])  # fmt: skip
    return limbs.pelvis.R if part is None else getattr(limbs.leg("left" if name[0] == "L" else "right"), part).R


def doubts(static, measures, **shown):
    """What is doubted, by side."""
    static = with_knees(static)
    return {(d.side, d.what) for d in static_doubts(static, measures, with_static_axes(measures, static, **shown))}


def test_what_contradicts_itself_is_told():
    lab = recorded((*DEVICE, *INSIDE), 8, asis_mm=230.0)
    static, measures = with_knees(marker_points(lab.static)), untold(lab.body.measures)
    assert doubts(static, measures) == set()
    swapped = static | {"LKNM": static["RKNM"], "RKNM": static["LKNM"]}
    assert {(side, "knee_width") for side in SIDES} <= doubts(swapped, measures)
    wide = replace(measures, right=replace(measures.right, ankle_mm=measures.right.ankle_mm - 25))
    assert doubts(static, wide) == {("right", "ankle_width")}
    bent = static | {"LKD2": static["LKD2"] + [30.0, 0, 0]}
    assert ("left", "device") in doubts(bent, measures)
    turned = static | {"LKAX": static["LKAX"] + [60.0, 0, 0]}
    assert ("left", "axes") in doubts(turned, measures)
    wrong = static | {LETTER["right"] + "THI": static["RTHI"] + [150.0, 0, 0]}
    assert doubts(wrong, measures) == {("right", "turn")}
