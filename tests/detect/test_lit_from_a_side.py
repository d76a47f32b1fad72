"""The threshold on ground that is brighter on one side: noise of the bright side is no marker."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.detect import Centroids, detect_frames
from kinemark.detect.learning import learned_limits
from kinemark.detect.stability import marker_gap

MARKERS = 12


def lit(seed, rise, n=12, shape=(300, 400)):
    """Images of markers that move, on ground that is `rise` levels brighter on the right."""
    rng = np.random.default_rng([2711, seed])
    y, x = np.mgrid[: shape[0], : shape[1]]
    grid = np.stack(np.meshgrid(np.arange(4), np.arange(3)), -1).reshape(-1, 2) * 90 + 50
    images = []
    for _ in range(n):
        image = 25 + rise * x / shape[1] + rng.normal(0, 3.6, shape)
        for u, v in grid + rng.uniform(-20, 20, grid.shape):
            image += 150 / (1 + np.exp(np.clip((np.hypot(x - u, y - v) - 1.3) / 0.3, -40, 40)))
        images.append(np.clip(np.round(image), 0, 255))
    return np.array(images, np.uint8)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("rise", [0, 15, 30])
def test_noise_where_the_ground_is_brightest_is_no_marker(seed, rise):
    """With a rise of 30, the usual threshold found some 300 false ones in each of these images."""
    images = lit(seed, rise)
    limits = replace(Centroids(), **learned_limits(images)._asdict())
    assert np.abs(detect_frames(images, method=limits).counts - MARKERS).max() <= 1


def test_a_lamp_in_view_is_no_ground():
    images = lit(4, 0)
    without = marker_gap(images).threshold
    images[:, 200:280, 340:390] = 255
    assert abs(marker_gap(images).threshold - without) < 8
