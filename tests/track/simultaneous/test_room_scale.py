"""Small things before near cameras are tracked as people are before far ones."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Rig
from kinemark.track.simultaneous import Simultaneous, track_simultaneously
from kinemark.track.simultaneous.following.room_scale import USUAL, scaled
from support.scenes import make, scene, tally


def of_size(rig, k):
    """The rig k times as large."""
    volume = None if rig.volume is None else k * rig.volume
    return Rig(tuple(replace(camera, t=k * camera.t) for camera in rig), volume=volume)


@pytest.mark.parametrize("seed", [2103, 2101])
def test_of_any_size_alike(seed):
    made = make(scene(seed))
    result = track_simultaneously(made.detections, of_size(made.rig, 0.05), Simultaneous())
    cloud = result.tracks.cloud
    found = tally(made, replace(result.tracks, cloud=replace(cloud, xyz=20 * cloud.xyz, cov=400 * cloud.cov)))
    assert result.scale < 0.1
    assert found.ghosts <= 2 and found.swaps == 0  # 119 and 2, and 13 and 32, with the lengths of people
    assert found.two_found > 0.98 * found.two


def test_what_is_stated_counts_as_it_is():
    method = scaled(Simultaneous(uncertain_sd=4.0, gate=6.0), 0.1)
    assert (method.uncertain_sd, method.gate) == (4.0, 6.0)
    assert (method.max_sd, method.velocity_sd) == (10.0, 150.0)
    assert scaled(Simultaneous(), 1.0) == Simultaneous()


def test_a_laboratory_is_as_it_was():
    made = make(scene(2105))
    depth = np.median([np.linalg.norm(made.xyz - camera.centre, axis=-1) for camera in made.rig])
    assert depth > USUAL
    assert track_simultaneously(made.detections, made.rig, Simultaneous()).scale == 1.0
