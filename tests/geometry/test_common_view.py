"""A place that cameras look at together, wherever their axes meet."""

import numpy as np
import pytest

from kinemark.calibrate.quality import view_volume
from kinemark.data import KinemarkError, Rig
from kinemark.geometry.common_view import common_view_centre, seen_by
from support.laboratory import camera, ring


def row(n, *, toe, distance=4000.0, apart=900.0):
    """n cameras in a row; each looks `toe` times as far aside as it stands."""
    x = (np.arange(n) - (n - 1) / 2) * apart
    return Rig(tuple(camera(f"c{i}", (at, -distance, 1400.0), (toe * at, 0.0, 900.0)) for i, at in enumerate(x)))


def test_axes_that_meet_in_front_are_the_middle():
    np.testing.assert_allclose(common_view_centre(ring(6)), [0, 0, 900], atol=1e-6)


@pytest.mark.parametrize("toe", [1.0, 1.3])
@pytest.mark.parametrize("n", [2, 4])
def test_cameras_toed_out_have_a_common_place(n, toe):
    rig = row(n, toe=toe)
    assert seen_by(rig, common_view_centre(rig)[None])[0] >= 2
    low, high = view_volume(rig)
    assert (high > low).all()


def test_cameras_back_to_back_have_none():
    back = Rig((camera("a", (0, 0, 900.0), (5000.0, 0, 900.0)), camera("b", (-10.0, 0, 900.0), (-5000.0, 0, 900.0))))
    assert common_view_centre(back) is None
    with pytest.raises(KinemarkError, match="common place"):
        view_volume(back)
