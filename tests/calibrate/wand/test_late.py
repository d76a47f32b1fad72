"""Laws of a wand's late cameras: what pairs of cameras tell of them, and that a small wand in noise is calibrated."""

import numpy as np
import pytest

from kinemark.calibrate.wand import calibrate_wand
from kinemark.calibrate.wand.delays import delays_between, seem_late
from kinemark.calibrate.wand.identify import marker_places
from kinemark.data import Detections
from kinemark.geometry import project
from kinemark.synth import observe, ring, wand

LENS = (-0.12, 0.0, 0.0, 0.0, 0.0)


def waved(length, late, *, rate, frames, noise, seed):
    """Detections and markers (C, F, K, 2) px of a wand, where cameras take their images so many late."""
    rig = ring(len(late), distortion=LENS)
    duration = (frames + max(late)) / rate
    subject = wand(marker_places([length]), duration_s=duration, rate=rate, seed=seed, volume=rig.volume)
    observed = observe(rig, subject, noise_px=noise, seed=seed)
    shown = [observed.detections[c, f + d] for c, d in enumerate(late) for f in range(frames)]
    counts = np.reshape([len(part) for part in shown], (len(late), frames))
    seen = Detections.build(observed.detections.cameras, rate, counts, np.concatenate(shown))
    true = observed.sight.uv.transpose(0, 2, 1, 3)
    uv = np.stack([true[c, d : d + frames] for c, d in enumerate(late)])
    return rig, seen, uv + np.random.default_rng(seed).normal(0.0, noise, uv.shape)


@pytest.mark.parametrize("seed", range(3))
def test_pairs_take_lenses_for_no_parts_of_an_image(seed):
    _, _, uv = waved(500.0, [0, 0, 0, 0], rate=25, frames=150, noise=0.1, seed=seed)
    assert delays_between(uv) is None
    assert not seem_late(uv)


@pytest.mark.parametrize("late", [1, 3, 12])
def test_pairs_tell_whole_images(late):
    _, _, uv = waved(500.0, [0, 0, late, 0], rate=25, frames=150, noise=0.1, seed=1)
    assert seem_late(uv)
    np.testing.assert_array_equal(delays_between(uv), [0, 0, late, 0])


def rhythmic(late, *, beat, seed, frames=150, noise=0.2):
    """Markers (C, F, K, 2) px of a wand that is waved nearly the same every `beat` images."""
    rng = np.random.default_rng(seed)
    phase, pace = rng.uniform(0, 2 * np.pi, 6), rng.uniform(0.3, 0.9, 6)
    seen = []
    for camera, d in zip(ring(len(late), distortion=LENS), late, strict=True):
        f = np.arange(frames)[:, None] + d
        x = np.sin([1, 2, 1, 1, 2, 1] * (2 * np.pi * f / beat) + phase) + 0.4 * np.sin(pace * f / 20 + phase)
        centre = [1200, 700, 850] + [700, 400, 400] * x[:, :3]
        direction = x[:, 3:] / np.linalg.norm(x[:, 3:], axis=1, keepdims=True)
        seen.append(project(camera, centre[:, None] + np.array([-250, 250])[:, None] * direction[:, None]))
    return np.array(seen) + rng.normal(0, noise, (len(late), frames, 2, 2))


@pytest.mark.parametrize("seed", range(3))
def test_a_wand_waved_in_time_is_not_taken_for_the_same_a_beat_before(seed):
    """10 images late look a little like 3 early, where nothing fits, and that is nearer."""
    np.testing.assert_array_equal(delays_between(rhythmic([0, 0, 10, 0], beat=13, seed=seed)), [0, 0, 10, 0])


def test_a_late_camera_that_sees_a_small_wand_in_noise_is_calibrated():
    rig, seen, _ = waved(200.0, [0, 0, 9, 0], rate=60, frames=300, noise=0.8, seed=6)
    fit = calibrate_wand(seen, lengths=[200.0], sizes=[camera.size for camera in rig])
    np.testing.assert_allclose(fit.delay, [0, 0, 9, 0], atol=0.02)


@pytest.mark.parametrize(("cameras", "images"), [(2, 1), (4, 1), (4, -2)])
def test_a_camera_that_loses_images_in_the_film_is_put_in_time(cameras, images):
    rig, film, _ = waved(500.0, [0] * cameras, rate=50, frames=240, noise=0.1, seed=3)
    shown = np.arange(240) + images * (np.arange(240) >= 100)
    parts = [film[c, f] for c in range(cameras) for f in (np.clip(shown, 0, 239) if c == 1 else range(240))]
    counts = np.reshape([len(part) for part in parts], (cameras, 240))
    fit = calibrate_wand(
        Detections.build(film.cameras, 50, counts, np.concatenate(parts)), lengths=[500.0], sizes=[c.size for c in rig]
    )
    (one,) = fit.lost
    assert fit.step is None
    assert abs(one.images) == abs(images)
    if cameras > 2:
        assert (one.camera, one.images) == (film.cameras[1], images)
    assert one.first - 3 <= 100 <= one.last + 3
    focal = [camera.K[0, 0] / true.K[0, 0] for camera, true in zip(fit.rig, rig, strict=True)]
    np.testing.assert_allclose(focal, 1.0, atol=0.01)
