"""What coarse sampling does to centroids is in their covariance: in whole frames, and in the lines of a field."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from kinemark.detect import Centroids, detect_frames
from kinemark.detect.moments import _undersampled
from kinemark.geometry import project, sphere_offset
from kinemark.synth import Optics, look_at, render

FINE = 4
"""Pixels of the rendered image along one of the sensor, so that blur comes before sampling, as in a lens."""
SIZE, FOCAL, AWAY, NOISE = np.array([180, 150]), 770.0, 4200.0, 2.0
SHARP = Centroids(threshold=60, min_area=1, max_area=2000, min_width=1, max_aspect=4, noise_sd=NOISE)


def sphere_images(d, blur, seed):
    """An image of spheres about d px wide at random places of a grid, and these (N, 2) px."""
    rng, px = np.random.default_rng(seed), AWAY / FOCAL
    camera = look_at("a", (0, -AWAY, 0), (0, 0, 0), focal_px=FOCAL * FINE, size=tuple(SIZE * FINE))
    x, z = (np.arange(-n, n + 1) * (d + 12.3) * px for n in ((SIZE - 30) / 2 / (d + 12.3)).astype(int))
    xyz = np.stack(np.meshgrid(x, [0.0], z), -1).reshape(-1, 3) + rng.uniform(-3 * px, 3 * px, (len(x) * len(z), 3))
    optics = Optics(blur_px=blur * FINE, read_noise=0.0, brightness=210.0)
    fine = render(camera, xyz, d * px / 2, optics=optics).reshape(SIZE[1], FINE, SIZE[0], FINE).mean((1, 3))
    image = np.clip(np.round(fine + rng.normal(0, NOISE, fine.shape)), 0, 255).astype(np.uint8)
    return image, (project(camera, xyz) + sphere_offset(camera, xyz, diameter=d * px) + 0.5) / FINE - 0.5


def squared_errors(image, places, aspect):
    """(N, 2) squared errors by the stated variance, u and v, and what is left once both are uncorrelated (N)."""
    found = detect_frames(image[None], method=replace(SHARP, aspect=aspect))
    off = found.uv - places[:, None]
    near = np.linalg.norm(off, axis=-1).argmin(1)
    off, cov = off[np.arange(len(near)), near], found.cov[near]
    assert np.abs(off).max() < 1.5
    return np.c_[off**2 / cov[:, [0, 1], [0, 1]], np.einsum("ni,nij,nj->n", off, np.linalg.inv(cov), off) / 2]


@pytest.mark.parametrize("fields", [False, True])
def test_errors_of_spheres_are_as_large_as_stated(fields):
    """Of sharp spheres in fields the squared error across the lines was 5 to 79 times what was stated."""
    ratio = {}
    for k, (d, blur) in enumerate(product((4, 5, 6, 8, 10, 12), (0.0, 0.3, 0.6))):
        image, places = sphere_images(d, blur, seed=300 + k)
        both = [(image[f::2], (places - [0, f]) / [1, 2]) for f in (0, 1)] if fields else [(image, places)]
        ratio[d, blur] = np.concatenate([squared_errors(*one, 0.5 if fields else 1.0) for one in both]).mean(0)
    of_all = np.array(list(ratio.values()))
    assert (of_all.max() < 2.8) and (of_all.min() > 0.25), ratio
    assert (of_all.mean(0) > 0.75).all() and (of_all.mean(0) < 1.3).all(), of_all.mean(0)


def test_whole_frames_are_the_limit_of_lines_that_lie_close():
    """What is left out of (7) and (8) for square pixels is nothing."""
    diameter = np.linspace(2, 14, 7)
    around = diameter**2 / 16 + 0.1 + 1 / 12
    spread, area = np.stack([around, np.zeros(7), around]), np.pi / 4 * diameter**2
    whole, close = (_undersampled(spread, area, aspect) for aspect in (1.0, 1 - 1e-9))
    np.testing.assert_allclose(whole, close, rtol=1e-6, atol=1e-15)
