"""A foot on several plates has the load of all of them; what stands beside it is not added."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.gait import analyse_gait, contacts, marker_points
from kinemark.gait.gait_methods import PlugInGait
from kinemark.gait.plate_events import plate_events
from kinemark.synth import WalkingBody, gait_laboratory
from support.split_plates import split

LEG = LegMeasures(890.0, 105.0, 72.0, plantar_offset_deg=2.0, rotation_offset_deg=3.0)
BODY = WalkingBody(SubjectMeasures(LEG, LEG, mass_kg=70.0))
LAB = gait_laboratory(BODY, duration_s=3.0, rate=100.0)
POINTS = marker_points(LAB.walk)
STOOD = next(one for one in analyse_gait(LAB.walk, BODY.measures).contacts if one.side == "left")
ALONE = replace(LAB.walk, plates=LAB.walk.plates[STOOD.plate : STOOD.plate + 1])
LEFT = slice(STOOD.first, STOOD.stop)


def place(share):
    """mm along the way, a share of the foot before its heel."""
    middle = (STOOD.first + STOOD.stop) // 2
    heel, toe = (POINTS[name][middle, 0] for name in ("LHEE", "LTOE"))
    return float(heel + share * (toe - heel))


@pytest.mark.parametrize("share", [0.3, 0.5, 0.8])
def test_a_step_on_two_plates_has_the_moments_and_events_of_one_plate(share):
    walk = split(LAB.walk, STOOD.plate, edge_mm=place(share))
    found, one = analyse_gait(walk, BODY.measures), analyse_gait(ALONE, BODY.measures)
    assert [(c.side, c.reason) for c in found.contacts] == [("left", "shared")] * 2
    for joint in ("Ankle", "Knee", "Hip"):
        name = f"L{joint}Moment"
        off = found.signals[name].values[LEFT] - one.signals[name].values[LEFT]
        assert np.sqrt(np.nanmean(off**2)) < 0.01  # what either plate carries below its threshold is missing
    events, known = plate_events(walk, POINTS), plate_events(ALONE, POINTS)
    assert [(e.side, e.strike) for e in events] == [(e.side, e.strike) for e in known]
    np.testing.assert_allclose([e.time for e in events], [e.time for e in known], atol=0.005)


def test_plug_in_gait_leaves_such_a_step_out():
    walk = split(LAB.walk, STOOD.plate, edge_mm=place(0.5))
    found = analyse_gait(walk, BODY.measures, method=PlugInGait())
    assert [(c.side, c.reason) for c in found.contacts] == [(None, "two_plates")] * 2
    assert np.isnan(found.signals["LKneeMoment"].values[LEFT]).all()


@pytest.mark.parametrize("aside_mm", [100.0, 150.0, 250.0])
def test_a_stick_on_the_next_plate_is_not_added(aside_mm):
    reactions = analyse_gait(ALONE, BODY.measures).reactions
    foot = reactions[0]
    heel, toe = POINTS["LHEE"], POINTS["LTOE"]
    centre = (heel + toe) / 2 * (1, 1, 0) + [0.0, aside_mm, 0.0]
    on = foot.loaded & (np.arange(len(foot.loaded)) > STOOD.first + 5)
    stick = replace(
        foot, loaded=on, force=np.where(on[:, None], [0.0, 0.0, 100.0], 0.0),
        centre=np.where(on[:, None], centre, np.nan), free_moment=np.zeros_like(foot.force),
        corners=foot.corners + np.array([0.0, 420.0, 0.0]),
    )  # fmt: skip
    assert "shared" not in {c.reason for c in contacts((foot, stick), POINTS, rate=100.0)}
