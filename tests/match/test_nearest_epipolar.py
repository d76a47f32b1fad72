"""The thesis' construction of the epipolar line, point by point, against matching by the nearest distance to it."""

import numpy as np
import pytest

from kinemark.data import Rig
from kinemark.geometry import project
from kinemark.match import NearestEpipolar, match
from support.laboratory import IDEAL, camera, seen_by

N = 40
RIG = Rig((camera("low", (4000.0, 0.0, 900.0), lens=IDEAL), camera("far", (-4000.0, 300.0, 1100.0), lens=IDEAL)))
"""Each sees the other one, so that lines fan out in the image; far from there those of rivals are all but parallel."""


def line_by_two_points(base, other, uv):
    """Points (2, 2) px in the other camera of two points of the ray through uv of the base (3.1.5, steps 1 to 3)."""
    way = base.R.T @ np.linalg.solve(base.K, [*uv, 1.0])
    return [project(other, base.centre + scale * way) for scale in (3000.0, 5000.0)]


def distance(kind, one, two, image):
    """From a line through two points, px: along v, or perpendicular to it."""
    slope = (two[1] - one[1]) / (two[0] - one[0])
    off = abs(one[1] + slope * (image[0] - one[0]) - image[1])
    return off if kind == "vertical" else off / np.hypot(1.0, slope)


def taken_in_order(cost):
    """Pairs of rows and columns in rising order of cost, each once."""
    pairs = []
    while np.isfinite(cost).any():
        i, j = np.unravel_index(np.argmin(cost), cost.shape)
        pairs.append((int(i), int(j)))
        cost[i], cost[:, j] = np.inf, np.inf
    return sorted(pairs)


def frame(seed):
    """Images (2, n, 2) of points that two cameras saw, with noise so great that lines contest them."""
    rng = np.random.default_rng(seed)
    points = rng.uniform([-600, -600, 200], [600, 600, 1600], (N, 3))
    return np.array([project(camera, points) + rng.normal(scale=20.0, size=(N, 2)) for camera in RIG])


@pytest.mark.parametrize("kind", ["perpendicular", "vertical"])
def test_the_nearest_by_either_distance_is_that_of_the_documents_construction(kind):
    different = 0
    for seed in range(6):
        images = frame(seed)
        lines = [line_by_two_points(*RIG, uv) for uv in images[0]]
        cost = np.array([[distance(kind, *line, image) for image in images[1]] for line in lines])
        detections = seen_by(RIG, images)
        found = match(detections, RIG, method=NearestEpipolar(distance=kind)).detection - [0, N]
        assert sorted(map(tuple, found.tolist())) == taken_in_order(cost)
        other = NearestEpipolar(distance="vertical" if kind == "perpendicular" else "perpendicular")
        different += (match(detections, RIG, method=other).detection - [0, N] != found).any()
    assert different > 0  # the choice counts where lines of several slopes ask for one image


def test_the_band_is_of_the_chosen_distance():
    images = frame(0)
    within = {}
    for kind in ("perpendicular", "vertical"):
        method = NearestEpipolar(distance=kind, search_band=8.0)
        within[kind] = {tuple(row) for row in match(seen_by(RIG, images), RIG, method=method).detection.tolist()}
    assert 0 < len(within["vertical"]) <= len(within["perpendicular"])
