"""Ground reactions in the report go with the subject, whichever way it walks; in files they are the laboratory's."""

import numpy as np
import pytest

from kinemark.data.laboratory_axes import turned
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.walks import KnownMeasures, Recorded, subject_gait
from kinemark.gait import StandardTrial
from kinemark.synth.gait_body import WalkingBody
from kinemark.synth.gait_laboratory import gait_laboratory
from support.shift_gait import MEASURES


@pytest.fixture(scope="module")
def walk():
    return gait_laboratory(WalkingBody(MEASURES), duration_s=3.0).walk


def about_the_vertical(deg):
    c, s = np.cos(np.radians(deg)), np.sin(np.radians(deg))
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def reactions(*walks):
    own = [Recorded(f"walk{i}", one, StandardTrial(one, np.eye(3), {})) for i, one in enumerate(walks)]
    found = subject_gait(own, KnownMeasures(MEASURES), None, GaitSettings(uncertainty=False))
    return {one.name: one for one in found.curves if one.name.endswith("GroundReactionForce")}


def test_the_floor_brakes_and_then_propels_and_pushes_towards_the_middle(walk):
    for curve in reactions(walk).values():
        assert curve.axes == ("anterior", "medial", "vertical")
        anterior, medial, vertical = curve.mean.T
        assert np.nanmin(anterior[:30]) < -0.5 < 0.5 < np.nanmax(anterior[30:62])
        assert np.nanmean(medial[10:50]) > 0.1
        assert np.nanmax(vertical) > 9.0


@pytest.mark.parametrize("deg", [90.0, 180.0, 270.0])
def test_reactions_of_a_walk_do_not_depend_on_its_direction(walk, deg):
    other = reactions(turned(walk, about_the_vertical(deg)))
    for name, curve in reactions(walk).items():
        np.testing.assert_allclose(other[name].mean, curve.mean, atol=1e-6)


def test_walks_there_and_back_do_not_take_each_other_away(walk):
    both = reactions(walk, turned(walk, about_the_vertical(180.0)))
    for name, curve in reactions(walk).items():
        np.testing.assert_allclose(both[name].mean, curve.mean, atol=1e-6)
