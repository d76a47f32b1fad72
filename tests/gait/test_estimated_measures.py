"""Measures of subjects whom nobody measured, against what files state of those whom somebody did."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.walks import WIDTH_MM, completed, known_measures, recorded
from kinemark.gait import estimated_measures, marker_points
from kinemark.gait.estimated_measures import WIDTH_SD_MM, joints_by_share
from kinemark.io.c3d.subject_measures import measures_of
from support.plug_in_gait import CHILDREN, trial
from support.shift_gait import stepping

WALKS = [f"{child}{walks[0]}.c3d" for child, (_, *walks) in CHILDREN.items()] + [
    "pig_gait_3plates_emg/PiG_Motion3_FF.c3d"
]


@pytest.mark.parametrize("name", WALKS)
def test_legs_and_mass_are_near_the_measured_ones(name):
    walk = recorded("walk", trial(name), {}, GaitSettings())
    stated = measures_of(walk.given.source)
    nobody = recorded("walk", trial(name).__class__("walk", *list_of(trial(name))), {}, GaitSettings())
    found = known_measures(None, [nobody], None)
    assert found.estimated == ("legs", "mass", "knees", "ankles") and found.width_mm == WIDTH_SD_MM
    assert found.measures.mean_leg_mm == pytest.approx(stated.mean_leg_mm, abs=35)
    assert found.measures.mass_kg == pytest.approx(stated.mass_kg, rel=0.07)
    assert found.measures.left.knee_mm == pytest.approx(stated.left.knee_mm, abs=3 * WIDTH_SD_MM)
    assert known_measures(None, [walk], None).width_mm == WIDTH_MM


def list_of(walk):
    return walk.trajectories, walk.analog, walk.plates, walk.events


def test_widths_follow_from_markers_on_both_sides_of_a_joint():
    points = marker_points(stepping())
    plain = estimated_measures(points)
    assert joints_by_share(points) == ("knees", "ankles")
    for letter in "LR":
        points |= {
            letter + "KNM": points[letter + "KNE"] + (0, 60, 80),
            letter + "MED": points[letter + "ANK"] + (75, 0, 0),
        }
    found = estimated_measures(points, marker_diameter_mm=10.0)
    assert joints_by_share(points) == ()
    for leg, before in ((found.left, plain.left), (found.right, plain.right)):
        assert (leg.knee_mm, leg.ankle_mm) == pytest.approx((90.0, 65.0)) and leg.leg_mm == before.leg_mm
    off = points | {"LKNM": points["LKNE"] + (600, 0, 0)}  # no knee is that wide
    assert joints_by_share(off) == ("knees",) and estimated_measures(off).left.knee_mm == plain.left.knee_mm


@pytest.mark.parametrize("mass_kg", [72269.0, 0.4])
def test_plates_in_another_unit_are_said(mass_kg):
    """The words were: mass_kg is 72269, wanted 2 to 400 kg, which nobody had stated."""
    with pytest.raises(KinemarkError, match=f"By the force plates the body weighs {mass_kg:.1f} kg"):
        estimated_measures(marker_points(stepping()), mass_kg=mass_kg)


def test_units_that_are_no_millimetres_are_said():
    points = {name: xyz / 1000 for name, xyz in marker_points(stepping()).items()}
    with pytest.raises(KinemarkError, match="unit of length"):
        estimated_measures(points)
    hidden = marker_points(stepping()) | {"LANK": np.full((400, 3), np.nan)}
    with pytest.raises(KinemarkError, match="left leg cannot be measured"):
        estimated_measures(hidden)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_a_walk_in_another_unit_than_its_standing_trial_is_refused(factor):
    standing = stepping()
    paths = tuple(MarkerTrajectory.measured(p.name, p.xyz * factor) for p in standing.trajectories)
    walk = replace(standing, trajectories=replace(standing.trajectories, paths=paths))
    right, wrong = (recorded("walk", one, {}, GaitSettings(up="z")) for one in (standing, walk))
    assert completed(right, right).points.keys() == right.points.keys()
    with pytest.raises(KinemarkError, match=r"walk: By its markers the left leg is .* unit of length"):
        completed(wrong, right)
