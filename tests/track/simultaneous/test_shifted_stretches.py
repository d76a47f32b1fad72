"""A camera that was touched and lies little beside the others is put right, or takes no part from then on."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.track.simultaneous import Simultaneous, diagnose, track_simultaneously
from kinemark.track.simultaneous.unfitting_stretches import Stretch
from support.laboratory import observe, ring
from support.motions import dance

TOUCHED, SINCE, FRAMES = 3, 40, 80


@pytest.fixture(scope="module", params=[(6, 1), (8, 3)], ids=["six", "eight"])
def knocked(request):
    """A rig, true places (M, F, 3) mm, and what its cameras see with one 2 px beside from a frame on."""
    cameras, seed = request.param
    rig, xyz = ring(cameras), dance(12, FRAMES, seed=seed)
    seen, _ = observe(rig, xyz, noise=0.2, seed=seed)

    def beside(since):
        those = (seen.camera == TOUCHED) & (seen.frame >= since)
        return replace(seen, uv=seen.uv + those[:, None] * [1.6, -1.2])

    return rig, xyz, beside


def off(result, xyz, since):
    """(n) mm by which points lie beside the nearest true place, from a frame on."""
    cloud = result.tracks.cloud
    late = cloud.frame >= since
    near = np.linalg.norm(cloud.xyz[late, None] - xyz[:, cloud.frame[late]].swapaxes(0, 1), axis=-1)
    return near.min(1)


def test_within_a_recording_it_takes_no_part_from_then_on(knocked):
    rig, xyz, beside = knocked
    result = track_simultaneously(beside(SINCE), rig, Simultaneous())
    (stretch,) = result.unfitting
    cloud = result.tracks.cloud
    assert stretch == Stretch(TOUCHED, SINCE - FRAMES // 10, FRAMES)
    assert not (cloud.detection[cloud.frame >= stretch.first, TOUCHED] >= 0).any()
    assert (cloud.detection[cloud.frame < stretch.first, TOUCHED] >= 0).mean() > 0.8
    (found,) = diagnose(beside(SINCE), rig, result)
    assert (found.kind, found.cameras, found.values["left_out"]) == ("camera_shifted", (rig.names[TOUCHED],), True)
    assert found.frames == ((SINCE, FRAMES - 1),)
    assert np.median(off(result, xyz, SINCE)) < 1.15 * np.median(off(result, xyz, 0))


def test_in_a_whole_recording_it_is_put_right(knocked):
    rig, xyz, beside = knocked
    result = track_simultaneously(beside(0), rig, Simultaneous())
    good = track_simultaneously(beside(FRAMES), rig, Simultaneous())
    (found,) = diagnose(beside(0), rig, result)
    assert result.unfitting == () and [one.camera for one in result.put_right] == [TOUCHED]
    assert found.kind == "camera_put_right"
    assert np.median(off(result, xyz, 0)) < 1.15 * np.median(off(good, xyz, 0))
