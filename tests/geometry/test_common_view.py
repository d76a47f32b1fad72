"""A place that cameras look at together, wherever their axes meet."""

import numpy as np
import pytest

from kinemark.calibrate.quality import points_of, view_volume, volume_grid
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


@pytest.mark.parametrize("distance", [4_000.0, 20_000.0, 80_000.0])
def test_a_box_nobody_states_is_what_long_lenses_see(distance):
    around = np.deg2rad(np.arange(5) * 72.0)
    places = np.stack([distance * np.cos(around), distance * np.sin(around), np.full(5, 1800.0)], 1)
    rig = Rig(tuple(camera(f"c{i}", at, focal=0.4 * distance) for i, at in enumerate(places)))
    box = view_volume(rig)
    assert (seen_by(rig, points_of(volume_grid(box))) >= 2).mean() >= 0.98
    assert np.ptp(box, axis=0).min() > 1000
