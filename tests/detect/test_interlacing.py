"""Woven fields are told from whole frames by what moves, and not by noise or by markers of a pixel."""

import numpy as np
import pytest

from kinemark.detect.interlacing import interlacing


def film(radius, noise, *, fields, speed=4.0, frames=6, size=160, seed=0):
    """Frames of ten discs that move by `speed` px a frame; `fields` is the one taken first, "" for whole frames."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[:size, :size]
    begin, way = rng.uniform(30, size - 30, (10, 2)), rng.uniform(0, 2 * np.pi, 10)

    def at(t):
        places = begin + speed * t * np.stack([np.cos(way), 0.5 * np.sin(way)], 1)
        off = np.hypot(u - places[:, :1, None], v - places[:, 1:, None]).min(0)
        return 30.0 + 180.0 * np.clip(radius + 0.5 - off, 0, 1)

    images = np.stack([at(f) for f in range(frames)])
    if fields:
        first = int(fields == "top")
        images[:, first::2] = np.stack([at(f + 0.5) for f in range(frames)])[:, first::2]
    return np.clip(images + rng.normal(0, noise, images.shape), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("fields", ["top", "bottom"])
@pytest.mark.parametrize("seed", range(3))
def test_woven_fields_are_told(fields, seed):
    assert interlacing(film(4.0, 3.0, fields=fields, seed=seed)).first == fields


@pytest.mark.parametrize(("radius", "noise"), [(0.5, 3.0), (0.5, 25.0), (0.7, 12.0), (4.0, 40.0)])
@pytest.mark.parametrize("seed", range(3))
def test_noise_and_markers_of_a_pixel_are_no_fields(radius, noise, seed):
    assert not interlacing(film(radius, noise, fields="", seed=seed)).first


@pytest.mark.parametrize("radius", [1.5, 4.0])
def test_whole_frames_of_slow_crisp_discs_are_no_fields(radius):
    assert not interlacing(film(radius, 3.0, fields="", speed=1.0)).first
