"""Gaps in which one camera still sees the marker."""

import numpy as np
import pytest

from kinemark.data import Detections
from kinemark.fill.rays import Rays, sharpened
from support.laboratory import observe, ring
from support.motions import dance

SD = 8.0


@pytest.fixture(scope="module")
def gap():
    """Cameras of which one alone sees a marker in 30 frames, a fill that is off by some mm, and the truth."""
    rig, xyz = ring(4), dance(n=6, frames=30)
    detections, shown = observe(rig, xyz, noise=0.1)
    free = (shown == 0) & (detections.camera == 1)
    error = np.random.default_rng(1).normal(0, SD, 3)  # what a filler is wrong by lasts
    return rig, detections, free, xyz[0], xyz[0] + error, np.broadcast_to(np.eye(3) * SD**2, (30, 3, 3))


def test_one_ray_takes_the_error_across_it_away(gap):
    rig, detections, free, truth, guess, cov = gap
    found = sharpened(guess, np.array(cov), 0, Rays(rig, detections, free))
    ray = rig[1].centre - truth
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    off = found.xyz - truth
    along = (off * ray).sum(1)
    across = np.linalg.norm(off - along[:, None] * ray, axis=1)
    assert (found.cameras == 2).all()
    assert np.median(across) < 0.6
    assert np.allclose(np.abs(along), np.abs(((guess - truth) * ray).sum(1)), atol=1.0)
    squared = (off * np.linalg.solve(found.cov, off[..., None])[..., 0]).sum(1)
    assert np.median(squared) < 8
    assert (np.linalg.eigvalsh(found.cov)[:, 0] > 0).all()


def test_images_of_other_markers_and_passing_spots_are_not_taken(gap):
    rig, detections, free, _truth, guess, cov = gap
    none = sharpened(guess, np.array(cov), 0, Rays(rig, detections, np.zeros(len(detections), bool)))
    assert np.array_equal(none.xyz, guess) and not none.cameras.any()
    one = np.flatnonzero(free)[10:11]
    spot = np.zeros(len(detections), bool)
    spot[one] = True
    assert not sharpened(guess, np.array(cov), 0, Rays(rig, detections, spot)).cameras.any()


def test_a_crowd_tells_nothing(gap):
    rig, detections, _free, _truth, guess, cov = gap
    crowd = Detections.build(
        detections.cameras,
        detections.rate,
        np.full((4, 30), 300),
        np.random.default_rng(0).uniform(0, 1000, (36000, 2)),
    )
    found = sharpened(guess, np.array(cov) * 9, 0, Rays(rig, crowd, np.ones(36000, bool)))
    assert (found.cameras == 0).mean() > 0.9


def test_what_is_not_known_or_not_in_the_recording_stays(gap):
    rig, detections, free, _truth, guess, cov = gap
    unknown = guess.copy()
    unknown[5] = np.nan
    found = sharpened(unknown, np.array(cov), 20, Rays(rig, detections, free))
    assert np.isnan(found.xyz[5]).all()
    assert not found.cameras[10:].any()
