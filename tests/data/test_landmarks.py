"""Marker names of many laboratories: sides, feet and pelvis are read from each."""

import numpy as np
import pytest

from kinemark.data.landmarks import landmarks
from kinemark.data.marker_sides import one_sided
from kinemark.data.model_markers import model_names
from kinemark.label import sides_by_name
from kinemark.label.anatomy import Anatomy
from kinemark.synth import walking

DIALECTS = {
    "with a subject": "Anna:LASI Anna:RASI Anna:SACR Anna:LHEE Anna:RHEE Anna:LTOE Anna:RTOE Anna:LKNE Anna:RKNE",
    "small letters": "lasi rasi sacr lhee rhee ltoe rtoe lkne rkne",
    "waist": "LFWT RFWT SACR LHEE RHEE LTOE RTOE LKNE RKNE",
    "Helen Hayes": "L.ASIS R.ASIS V.Sacral L.Heel R.Heel L.Toe R.Toe L.Knee R.Knee",
    "ISB": "L_IAS R_IAS SACR L_FCC R_FCC L_FM2 R_FM2 L_FLE R_FLE",
    "Rizzoli": "LASIS RASIS SACR LCA RCA LSM RSM LLE RLE",
    "animation": "WaistLFront WaistRFront WaistBack LHeelBack RHeelBack LForefoot2 RForefoot2 LKneeOut RKneeOut",
    "words": "Left_ASIS Right_ASIS Sacrum Left_Heel Right_Heel Left_Toe Right_Toe Left_Knee Right_Knee",
    "side behind": "ASIS_L ASIS_R SACR HEEL_L HEEL_R TOE_L TOE_R KNEE_L KNEE_R",
    "side behind, close": "SIASL SIASR Sacrum HEELL HEELR TOEL TOER KNEEL KNEER",
    "Davis": "l_asis r_asis sacrum l_heel r_heel l_met r_met l_knee_1 r_knee_1",
}
OURS = ("LASI", "RASI", "SACR", "LHEE", "RHEE", "LTOE", "RTOE", "LKNE", "RKNE")


@pytest.mark.parametrize("names", [text.split() for text in DIALECTS.values()], ids=DIALECTS)
def test_markers_mean_the_same_whatever_they_are_called(names):
    assert sides_by_name(names) == tuple(zip(names[0:2:2] + names[3::2], names[1:2] + names[4::2], strict=True))
    assert model_names(names) == dict(zip(OURS, names, strict=True))
    walk = walking(duration_s=1.0, seed=3).trajectories.select(OURS)
    y = np.moveaxis(walk.xyz, 1, 0)
    plain, found = Anatomy.of(OURS), Anatomy.of(names)
    assert found == plain
    assert found.agreement(y) == plain.agreement(y) > 1.5


def test_a_marker_without_a_partner_has_the_side_before_its_name():
    names = ["Heel", "KNEEL", "R.Heel", "ARMm", "ARMl"]
    assert model_names(names) == {"RHEE": "R.Heel"}
    assert not sides_by_name(names)
    assert [one.side for one in landmarks(names)["Heel"]] == [None]


def test_a_toes_tip_shows_the_front_of_a_foot_and_is_not_the_models_toe():
    names = ["R.Heel", "R.Toe.Tip", "L.Heel", "L.Toe.Tip", "R.Toe.Lat", "L.Toe.Lat", "C7"]
    assert "LTOE" not in model_names(names)
    assert sorted(Anatomy.of(names).toe) == [1, 3]


def test_feet_of_two_subjects_are_not_one():
    assert Anatomy.of(["A:LHEE", "B:LTOE", "B:LHEE"]).heel == [2]


def test_wands_are_those_of_helen_hayes_too_and_plates_are_none():
    names = ["L.Thigh", "R.Thigh", "L.Shank", "R.Shank", "L.Ankle", "R.Ankle"]
    assert model_names(names) == dict(zip(("LTHI", "RTHI", "LTIB", "RTIB", "LANK", "RANK"), names, strict=True))
    assert not model_names(["L.Thigh.1", "L.Thigh.2", "R.Thigh.1", "R.Thigh.2", "L.Shank.Upper", "R.Shank.Upper"])


@pytest.mark.parametrize(
    ("names", "alone"),
    [
        (("LASI", "RASI", "RBAK", "LELB", "C7"), ("RBAK", "LELB")),
        (("l knee", "r knee", "l mall", "sacrum"), ("l mall",)),
        (("Left Knee", "Right Knee", "Right Toe"), ("Right Toe",)),
        (("KNEE_L", "KNEE_R", "TOE_R", "HEAD"), ("TOE_R",)),
        (("C7", "STRN", "LASI"), ()),
        (("KNEl", "KNEr", "SCAPl", "SCAPm", "ANKl"), ("ANKl",)),
        (("LASI", "RASI", "LKNEL", "LKNEM"), ("LKNEL", "LKNEM")),
        (("KNEl", "KNEr", "STYLr", "STYLu", "ANKr"), ("ANKr",)),
        (("KNEE_L", "KNEE_R", "WRIST_R", "WRIST_U", "HEEL_R"), ("HEEL_R",)),
        (("A:KNEEL", "A:KNEER", "A:WRISTR", "A:WRISTU", "B:WRISTR"), ("B:WRISTR",)),
        (("LASI", "RASI", "LE", "ME", "RS", "US", "RWRr"), ("RWRr",)),
        (("HIPL", "HIPR", "THIU", "THIL", "ARML", "ANKL"), ("ARML", "ANKL")),
        (("LASI", "RASI", "LARM", "UARM"), ("LARM",)),
        (("Lknee", "Rknee", "Radius", "Ulna", "LatAnkle", "Lankle"), ("Lankle",)),
        (("lasi", "rasi", "l5", "l3", "lateral malleolus", "lhee"), ("lhee",)),
        (("L1", "R1", "L2", "R2", "L3"), ("L3",)),
        (("LASI", "RASI", "T10", "L5"), ()),
    ],
)
def test_markers_of_a_side_whose_other_is_not_there_are_known_by_how_the_pairs_are_called(names, alone):
    """Without any pair nothing says how the sides are called."""
    assert one_sided(names) == alone


@pytest.mark.parametrize(
    ("names", "pairs"),
    [
        (("FOREl", "FOREm", "FOREr", "FOREu"), ()),
        (("HEADl", "HEADm", "HEADr"), (("HEADl", "HEADr"),)),
        (("HIP_L", "HIP_R", "HEAD_L", "HEAD_M", "HEAD_R", "HEAD_U"), (("HIP_L", "HIP_R"), ("HEAD_L", "HEAD_R"))),
        (("LFOREr", "LFOREu", "RFOREr", "RFOREu"), (("LFOREr", "RFOREr"), ("LFOREu", "RFOREu"))),
    ],
)
def test_lateral_and_radial_markers_of_a_limb_are_no_sides(names, pairs):
    assert sides_by_name(names) == pairs
