"""What the tracks say of the cameras' time offsets."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import Detections
from kinemark.track.simultaneous import Simultaneous, diagnose, track_simultaneously
from kinemark.track.simultaneous.times.time_offsets import time_offsets
from support.laboratory import observe, ring
from support.motions import dance
from support.uneven_times import Paths, Times, compared, recorded, truth

FRAMES = 160


@pytest.fixture(scope="module")
def ball():
    """Cameras, and a dance twice as long as it is watched, so that it can be seen earlier and later."""
    return ring(6), dance(n=12, frames=FRAMES + 2)


def watched(rig, xyz, late):
    """What cameras see of paths (M, F + 2, 3) mm, each taken so many frames later than it should be."""
    frames = np.arange(1.0, FRAMES + 1)
    seen = []
    for c, delay in enumerate(late):
        f = frames + delay
        low = f.astype(int)
        share = (f - low)[:, None]
        moved = (1 - share) * xyz[:, low] + share * xyz[:, low + 1]
        one, _ = observe(rig, moved, noise=0.1, seed=c)
        seen.append((one.counts[c], one.uv[one.camera == c], one.cov[one.camera == c]))
    counts, uv, cov = zip(*seen, strict=True)
    return Detections.build(rig.names, 100.0, np.array(counts), np.concatenate(uv), np.concatenate(cov))


@pytest.mark.parametrize("late", [(0, 0, 0, 0, 0, 0), (0, 0, 0.3, 0, 0, 0), (0.2, 0, 0, -0.4, 0, 0)])
def test_delays_are_found_with_their_errors(ball, late):
    rig, xyz = ball
    found = time_offsets(track_simultaneously(watched(rig, xyz, late), rig, Simultaneous(learn_delays=False)))
    assert found.delay == pytest.approx(np.array(late) - np.median(late), abs=0.02)
    assert (found.error < 0.01).all()
    assert (np.abs(found.delay - late) < 8 * found.error + 0.01).all()


def test_a_late_camera_is_named_and_not_taken_for_a_moved_one(ball):
    rig, xyz = ball
    detections = watched(rig, xyz, (0, 0, 0.3, 0, 0, 0))
    (found,) = diagnose(detections, rig, track_simultaneously(detections, rig, Simultaneous(learn_delays=False)))
    assert (found.kind, found.cameras) == ("camera_out_of_sync", (rig.names[2],))
    assert found.values["delay_ms"] == pytest.approx(3.0, abs=0.15)
    assert found.values["delay_frames"] == pytest.approx(0.3, abs=0.015)


@pytest.mark.parametrize("late", [(0, 0, 0.3, 0, 0, 0), (0.6, 0, 0, -0.7, 0, 0)])
def test_delays_are_learned_and_then_cost_nothing(ball, late):
    rig, xyz = ball
    detections = watched(rig, xyz, late)
    result = track_simultaneously(detections, rig, Simultaneous())
    together = track_simultaneously(watched(rig, xyz, (0,) * 6), rig, Simultaneous())
    torn = track_simultaneously(detections, rig, Simultaneous(learn_delays=False))
    assert result.times.delay == pytest.approx(np.array(late) / 100, abs=2e-4)
    assert (result.times.delay_error[np.flatnonzero(late)] < 2e-4).all()
    assert len(result.tracks) == len(together.tracks) == 12
    assert error(result, xyz) < 1.05 * error(together, xyz) < error(torn, xyz)
    residual, before = (np.sqrt((one.tracks.cloud.residual**2).mean()) for one in (result, torn))
    assert residual < 0.6 * before
    found = diagnose(detections, rig, result)
    assert {one.cameras: one.kind for one in found} == {
        (rig.names[c],): "camera_delay_learned" for c in np.flatnonzero(late)
    }


def test_a_rolling_shutter_is_learned_and_then_costs_nothing(ball):
    rig, xyz = ball
    readout = (0, 0.8, 0, 0, 0.5, 0)
    detections = rolled(rig, xyz, readout)
    result = track_simultaneously(detections, rig, Simultaneous())
    torn = track_simultaneously(detections, rig, Simultaneous(learn_delays=False))
    assert 2 * 100 * result.times.line == pytest.approx(np.array(readout), abs=0.05)
    residual, before = (np.sqrt((one.tracks.cloud.residual**2).mean()) for one in (result, torn))
    assert residual < 0.8 * before
    named = [one.cameras for one in diagnose(detections, rig, result) if one.kind == "camera_rolling_shutter"]
    assert named == [(rig.names[1],), (rig.names[4],)]


def rolled(rig, xyz, readout):
    """What cameras see whose last rows are taken so many frames later than their first."""
    early, middle, late = (watched(rig, xyz, (shift,) * len(rig)) for shift in (-0.5, 0, 0.5))
    y = middle.uv[:, 1] / rig.cameras[0].size[1] - 0.5
    s = (np.array(readout)[middle.camera] * y)[:, None]
    uv = middle.uv + s * (late.uv - early.uv) + 2 * s**2 * (late.uv - 2 * middle.uv + early.uv)
    return replace(middle, uv=uv)


def test_synchronous_cameras_are_tracked_once(ball):
    rig, xyz = ball
    detections = watched(rig, xyz, (0,) * 6)
    result, once = (
        track_simultaneously(detections, rig, Simultaneous(learn_delays=learn)).tracks for learn in (True, False)
    )
    assert np.array_equal(result.cloud.xyz, once.cloud.xyz)


@pytest.mark.parametrize(("C", "rate", "speed"), [(4, 25.0, 2000.0), (6, 50.0, 4000.0)])
def test_uneven_times_are_variances_that_grow_with_speed(C, rate, speed):
    rig, paths, frames = ring(C), Paths(12, speed, seed=C), int(max(4 * rate, 160))
    uneven = np.where(np.arange(C) == 1, 0.12, 0.0) / rate
    detections, _ = recorded(rig, paths, Times.of(C, rate, uneven=uneven), frames=frames, rate=rate)
    xyz = truth(paths, frames, rate)
    torn = compared(track_simultaneously(detections, rig, Simultaneous(learn_delays=False)).tracks, xyz)
    result = track_simultaneously(detections, rig, Simultaneous())
    learned = compared(result.tracks, xyz)
    assert result.times.unsteady[1] == pytest.approx(0.12 / rate, rel=0.2)
    assert not np.delete(result.times.unsteady, 1).any()
    assert learned[1] < 0.98 * torn[1]  # RMS; vague points of the other are smoothed too
    assert 0.9 < learned[2] < 0.985  # within 95 % ellipsoids
    assert (learned[0] > 0.99, learned[3], learned[4]) == (True, 12, 0)
    found = [one for one in diagnose(detections, rig, result) if one.kind == "camera_uneven_times"]
    assert [one.cameras for one in found] == [(rig.names[1],)]
    assert found[0].values["uneven_ms"] == pytest.approx(1000 * result.times.unsteady[1])


@pytest.mark.parametrize("stated", [True, False])
def test_delays_and_lines_are_told_from_a_calibration_that_is_off(stated):
    rig, paths, rate, frames = ring(5), Paths(12, 1200.0, seed=5), 50.0, 200
    delay, readout = np.array([0, 0, 0.006, 0, -0.004]), np.array([0.012, 0, 0, 0.008, 0])
    times = Times.of(5, rate, delay=delay, readout=readout, exposure=0.004)
    detections, _ = recorded(rig, paths, times, frames=frames, rate=rate, stated=stated)
    result = track_simultaneously(detections, off(rig, 1.0), Simultaneous())
    assert result.times.delay == pytest.approx(delay, abs=6e-4)
    assert 2 * result.times.line == pytest.approx(readout, abs=2e-3)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_calibration_that_is_off_is_no_delay(seed):
    rig, paths, rate, frames = ring(4), Paths(12, 3000.0, seed), 100.0, 160
    detections, _ = recorded(rig, paths, Times.of(4, rate), frames=frames, rate=rate)
    times = track_simultaneously(detections, off(rig, 1.0, seed), Simultaneous()).times
    assert not np.any(times)


def off(rig, px, seed=3):
    """The rig with each camera turned and refocused by chance, by so many px at its middle and its edge."""
    rng = np.random.default_rng(seed)
    cameras = []
    for camera in rig:
        f = camera.K[0, 0]
        turn = Rotation.from_rotvec(rng.normal(0, px / f, 3)).as_matrix()
        K = camera.K * np.array([[1 + rng.normal(0, px / (camera.size[0] / 2))] * 2 + [1.0]] * 2 + [[1.0] * 3])
        cameras.append(replace(camera, K=K, R=turn @ camera.R, t=turn @ camera.t))
    return replace(rig, cameras=tuple(cameras))


def error(result, xyz):
    """RMS distance of the points from the nearest true one, mm."""
    cloud = result.tracks.cloud
    off = np.linalg.norm(cloud.xyz[:, None] - xyz[:, 1:-1].swapaxes(0, 1)[cloud.frame], axis=-1).min(1)
    return np.sqrt((off**2).mean())


def test_nothing_is_known_of_clocks_when_nothing_moves(ball):
    rig, xyz = ball
    still = np.repeat(xyz[:, :1], FRAMES + 2, axis=1)
    found = time_offsets(track_simultaneously(watched(rig, still, (0, 0, 0.4, 0, 0, 0)), rig, Simultaneous()))
    known = np.abs(found.delay) > 5 * found.error
    assert not (known & (found.shift > 0.1)).any()
