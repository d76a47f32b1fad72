"""What the gait model is off by when an assumption fails is what geometry says, and nothing without a failure."""

import gait_assumptions as study
import numpy as np
import pytest


@pytest.fixture(scope="module")
def found():
    """Errors (3) by quantity of one subject: nothing wrong, and each of three assumptions failing."""
    believed = study.subjects(1, 1)
    of = {one.name: one for one in study.ASSUMPTIONS}
    asked = {
        "nothing": ("knee is a hinge", 0.0),
        "axis": ("knee axis, about the thigh", 10.0),
        "glide": ("knee is a hinge", 10.0),
        "inertia": ("inertia, de Leva", 0.0),
    }
    return believed[0], {key: study.squares(of[name], by, believed) for key, (name, by) in asked.items()}


def test_the_model_is_exact_where_all_that_it_assumes_is_so(found):
    _, rows = found
    for name, row in rows["nothing"].items():
        assert row.max() < (0.02 if name.endswith("Angles") else 0.01), name


def test_a_turned_knee_axis_makes_flexion_into_adduction(found):
    """Adduction by about sin 10° of some 33° of flexion; the knee's centre goes round KNE, which bends the knee; the
    hip is turned by the 10° and by what that centre moves, and the ankle less."""
    _, rows = found
    flexion, adduction, rotation = rows["axis"]["KneeAngles"]
    assert 4 < adduction < 9 and flexion < adduction
    assert 10.0 < rows["axis"]["HipAngles"][2] < 20.0 and rotation > 5
    assert rows["axis"]["AnkleAngles"][2] < rotation


def test_a_shank_that_glides_is_tilted_by_its_length(found):
    """10 mm at 60° of flexion, over the length of the shank, is what flexion of the knee is off by at most."""
    believed, rows = found
    shank = (believed.left.leg_mm - 80) / 2
    most = np.degrees(10 / shank)
    assert 0.2 * most < rows["glide"]["KneeAngles"][0] < most
    assert rows["glide"]["HipAngles"].max() < 0.02


def test_other_inertia_changes_moments_alone(found):
    _, rows = found
    assert rows["inertia"]["HipMoment"][0] > 0.005
    assert rows["inertia"]["HipAngles"].max() < 0.02
