"""What is up in the panels of gait is what the angle's sign says."""

import numpy as np
import pytest
import scipy

from kinemark.data import Signal, Signals
from kinemark.data.strides import Stride
from kinemark.data.subject_measures import LegMeasures, SubjectMeasures
from kinemark.gait.gait_cycles import gait_curves
from kinemark.gait.segments import Segment
from kinemark.gait.upper_body import upper_body_angles
from kinemark.report.figures_gait import KINEMATICS, TRUNK, panels_figure, trunk_figure

THORAX = {"CLAV": (100, 0, 1400), "C7": (-80, 0, 1450), "STRN": (120, 0, 1250), "T10": (-90, 0, 1200)}
"""Markers of a trunk that looks along x, mm."""
MEASURES = SubjectMeasures(LegMeasures(880, 100, 70), LegMeasures(880, 100, 70))


def angles(deg, axis):
    turn = scipy.spatial.transform.Rotation.from_rotvec(np.radians(deg) * np.array(axis, float)).as_matrix()
    points = {name: turn @ np.array(place, float) for name, place in THORAX.items()}
    return upper_body_angles(points, MEASURES, Segment(origin=np.zeros(3), R=np.eye(3)), np.eye(3))


@pytest.mark.parametrize(
    ("axis", "deg", "component", "signs"),
    [((0, 1, 0), 10, 0, (1, 1)), ((1, 0, 0), 10, 1, (1, -1)), ((0, 0, 1), -10, 2, (1, -1))],
    ids=["leans forward", "left shoulder up", "left shoulder forward"],
)
def test_the_trunks_words_are_those_of_its_signs(axis, deg, component, signs):
    for side, sign in zip("LR", signs, strict=True):
        name = f"{side}ThoraxAngles"
        change = angles(deg, axis)[name] - angles(0, axis)[name]
        assert change[component] == pytest.approx(10 * sign, abs=0.5)
    assert (TRUNK[component].up, TRUNK[component].down) == [("forward", "back"), ("up", "down")][component == 1]


def test_the_trunk_is_drawn_where_it_was_worn():
    strides = [Stride("left", 0.0, 1.0, {"foot_off": 60.0}, {})]
    trunk, knee = (
        gait_curves(Signals((Signal.of(name, "angle", "deg", np.ones((101, 3)), rate=100.0),)), strides)
        for name in ("LThoraxAngles", "LKneeAngles")
    )
    assert trunk_figure(trunk) is not None
    assert trunk_figure(knee) is None


@pytest.mark.parametrize("sides", [("left",), ("right",), ("left", "right")])
@pytest.mark.parametrize("foot_off", [60.0, np.nan])
def test_the_key_names_what_is_drawn_and_nothing_else(sides, foot_off):
    """A leg without markers stood in the key, and a foot off that no stride has."""
    values = Signals(
        tuple(
            Signal.of(f"{side[0].upper()}KneeAngles", "angle", "deg", np.ones((101, 3)), rate=100.0) for side in sides
        )
    )
    strides = [Stride(side, 0.0, 1.0, {"foot_off": foot_off}, {}) for side in sides]
    notes = panels_figure(gait_curves(values, strides), KINEMATICS).layout["annotations"]
    key = [note["text"] for note in notes if note["text"].startswith(("━━", "┊"))]
    assert key == [*(f"━━ {side}" for side in sides), *(["┊ foot off"] if np.isfinite(foot_off) else [])]
