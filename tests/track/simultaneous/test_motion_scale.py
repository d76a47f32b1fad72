"""Process noise and velocities that a recording has."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.synth.score import score
from kinemark.track.simultaneous import Simultaneous, track_detections, track_simultaneously
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.motion_scale import with_learned_motion
from kinemark.track.simultaneous.following.passes import run
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

RATE = 100.0


def fast(n=10, frames=100, *, accelerations=80_000.0, seed=0, rate=RATE):
    """Paths (n, F, 3) mm whose accelerations (mm/s²) swing as those of a sprinter's feet."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames) / rate
    w = 2 * np.pi * rng.uniform(2.0, 3.0, (n, 1, 3))
    start = rng.uniform([-700, -700, 500], [700, 700, 1500], (n, 3))
    return start[:, None] + accelerations / w**2 * np.sin(w * t[:, None] + rng.uniform(0, 6, (n, 1, 3)))


def scale(xyz, *, rate=RATE, **options):
    detections, _ = observe(ring(6), xyz, noise=0.2, rate=rate)
    return with_learned_motion(read_images(detections, ring(6)), rate, Simultaneous(**options)).method


def test_slow_motion_is_tracked_as_it_was():
    assert scale(dance(n=10, frames=100)) == Simultaneous()


def test_fast_motion_raises_process_noise_and_only_where_asked():
    assert scale(fast()).process_noise > 2 * Simultaneous().process_noise
    assert scale(fast(), learn_motion=False) == Simultaneous(learn_motion=False)


@pytest.mark.parametrize("accelerations", [60_000.0, 150_000.0])
@pytest.mark.parametrize("rate", [100.0, 250.0])
def test_the_accelerations_of_a_motion_are_learned(accelerations, rate):
    """Of three swings of random phases 97 % of the accelerations are below 1.6 times the amplitude."""
    xyz = fast(accelerations=accelerations, rate=rate)
    assert scale(xyz, rate=rate).acceleration_sd == pytest.approx(1.6 * accelerations / np.sqrt(8.947), rel=0.25)


def test_what_bends_much_in_all_frames_is_found_at_once():
    """A circle: no part of it bends less, and no new track began there."""
    t, n = np.arange(60) / RATE, 6
    w = 2 * np.pi * 4.0
    turn = w * t + np.arange(n)[:, None]
    circle = 130_000.0 / w**2 * np.stack([np.cos(turn), 0 * turn, np.sin(turn)], -1)
    xyz = circle + np.stack([np.linspace(-700, 700, n), np.zeros(n), np.full(n, 1000.0)], -1)[:, None]
    detections, _ = observe(ring(6), xyz, noise=0.2)
    found = score(track_simultaneously(detections, ring(6), Simultaneous()).tracks, xyz)
    assert found.recall > 0.99 and found.swaps == 0 and found.fragments.max() == 1


@pytest.mark.parametrize("q", [100_000.0, 300_000.0])
def test_the_process_noise_of_a_motion_that_has_one(q):
    """White noise of jerk about a place to which a spring and a damper hold the marker."""
    rng, T, steps = np.random.default_rng(0), 1 / RATE, 20
    x, v, a, path = np.zeros((12, 3)), np.zeros((12, 3)), np.zeros((12, 3)), []
    for k in range(120 * steps):
        h = T / steps
        if k % steps == 0:
            path.append(x.copy())
        a = a + q * np.sqrt(h) * rng.normal(size=a.shape) - h * (30 * a + 400 * v + 3000 * x)
        v = v + h * a
        x = x + h * v
    start = rng.uniform([-700, -700, 500], [700, 700, 1500], (12, 3))
    xyz = start[:, None] + np.array(path).swapaxes(0, 1)
    assert scale(xyz).process_noise == pytest.approx(q, rel=0.5)


def test_a_fast_motion_is_followed():
    xyz = fast()
    detections, _ = observe(ring(6), xyz, noise=0.2)
    found = score(track_simultaneously(detections, ring(6), Simultaneous()).tracks, xyz)
    assert found.recall > 0.99 and found.swaps == 0
    before = score(track_simultaneously(detections, ring(6), Simultaneous(learn_motion=False)).tracks, xyz)
    assert before.recall < 0.99 or before.fragments.sum() > len(xyz)


@pytest.mark.parametrize(("markers", "frames"), [(1, 60), (2, 60), (1, 200)])
def test_few_markers_tell_how_they_move(markers, frames):
    xyz = fast(markers, frames, seed=1)
    assert scale(xyz).acceleration_sd > 2 * Simultaneous().acceleration_sd
    detections, _ = observe(ring(3), xyz, noise=0.2)
    found = score(track_simultaneously(detections, ring(3), Simultaneous()).tracks, xyz)
    assert found.recall > 0.99 and found.swaps == 0


def test_a_sprinter_crosses():
    """Everything moves at 8 m/s, faster than new tracks are looked for."""
    rate = 50.0
    xyz = dance(n=10, frames=30) + (np.arange(30)[:, None] / rate * 8000.0 - 2000) * np.array([1.0, 0, 0])
    detections, _ = observe(ring(6, focal=700.0), xyz, noise=0.2, rate=rate)
    images = read_images(detections, ring(6, focal=700.0))
    method = with_learned_motion(images, rate, Simultaneous()).method
    assert method.velocity_sd * 3 > 8000
    assert len(run(images, rate, method).id) > len(run(images, rate, Simultaneous()).id)


def plate(frames, reach, seed):
    """(15, F, 3) mm a grid of 100 mm that is carried about at 10 Hz and tilts, by up to `reach` mm a frame."""
    rng = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(np.arange(5) * 100.0, np.arange(3) * 100.0, [900.0]), -1).reshape(-1, 3)
    t = np.arange(frames)[:, None]
    turn = rng.uniform(0.08, 0.14, 3)
    middle = reach / turn.max() * np.array([0.7, 0.6, 0.3]) * np.sin(turn * t + rng.uniform(0, 6, 3))
    tilt = 0.15 * np.sin(0.1 * t[:, 0])
    return grid[:, None] + middle + np.stack([0 * tilt, 0 * tilt, 1 + 0 * tilt], -1) * (tilt * grid[:, :1])[..., None]


@pytest.mark.parametrize("seed", range(3))
def test_a_plate_that_is_carried_at_ten_hertz_stays_whole(seed):
    xyz = plate(120, 60.0, seed)
    seen, _ = observe(ring(4), xyz, noise=0.6, rate=10.0, seed=seed, cov=False)
    detections = replace(seen, cov=np.broadcast_to(np.eye(2) * 0.2**2, (len(seen), 2, 2)))
    found = score(track_simultaneously(detections, ring(4), Simultaneous()).tracks, xyz)
    assert found.swaps <= 5  # 700 and more where process noise is what people have
    assert found.recall > 0.98


def test_a_still_plate_at_ten_hertz_is_not_cut_where_stretches_meet():
    xyz = np.repeat(plate(1, 0.0, 0), 300, axis=1)
    detections, _ = observe(ring(4), xyz, noise=0.2, rate=10.0)
    assert len(track_simultaneously(detections, ring(4), Simultaneous()).tracks) == 15


def test_at_few_frames_a_second_less_process_noise_is_taken_where_tracks_then_have_more_images():
    """Sixty markers of a walk at 25 Hz, four cameras: with the usual process noise there are 109 ghosts."""
    made = make(scene(970338))
    usual = Simultaneous()
    less = with_learned_motion(read_images(made.detections, made.rig), 25.0, usual).method
    assert usual.process_noise / less.process_noise == usual.acceleration_sd / less.acceleration_sd >= 2
    assert less.velocity_sd == usual.velocity_sd
    found = tally(made, track_detections(made.detections, made.rig))
    assert found.ghosts < 10
    assert found.two_found > 0.93 * found.two


def test_markers_that_bend_much_keep_their_process_noise_at_few_frames_a_second():
    assert scale(fast(accelerations=40_000.0, rate=25.0), rate=25.0).process_noise >= Simultaneous().process_noise
