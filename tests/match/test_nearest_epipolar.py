"""The thesis' construction of the epipolar line, point by point, against matching by the nearest distance to it."""

import numpy as np
import pytest

from kinemark.geometry import project
from kinemark.match import NearestEpipolar, match
from support.laboratory import IDEAL, ring, seen_by


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


def frame(rig, seed):
    """Images (2, n, 2) of points that two cameras saw, with noise so great that lines contest them."""
    rng = np.random.default_rng(seed)
    points = rng.uniform([-600, -600, 200], [600, 600, 1600], (12, 3))
    return np.array([project(camera, points) + rng.normal(scale=6.0, size=(12, 2)) for camera in rig])


@pytest.mark.parametrize("kind", ["perpendicular", "vertical"])
def test_the_nearest_by_either_distance_is_that_of_the_documents_construction(kind):
    rig = ring(2 + 1, lens=IDEAL).select(["c0", "c1"])
    different = 0
    for seed in range(6):
        images = frame(rig, seed)
        lines = [line_by_two_points(rig[0], rig[1], uv) for uv in images[0]]
        cost = np.array([[distance(kind, *line, image) for image in images[1]] for line in lines])
        detections = seen_by(rig, images)
        found = match(detections, rig, method=NearestEpipolar(distance=kind)).detection - [0, 12]
        assert sorted(map(tuple, found.tolist())) == taken_in_order(cost)
        other = NearestEpipolar(distance="vertical" if kind == "perpendicular" else "perpendicular")
        different += (match(detections, rig, method=other).detection != found + [0, 12]).any()
    assert different > 0  # the choice counts where lines of several slopes ask for one image


def test_the_band_is_of_the_chosen_distance():
    rig = ring(3, lens=IDEAL).select(["c0", "c1"])
    images = frame(rig, 0)
    within = {}
    for kind in ("perpendicular", "vertical"):
        method = NearestEpipolar(distance=kind, search_band=2.0)
        within[kind] = {tuple(row) for row in match(seen_by(rig, images), rig, method=method).detection.tolist()}
    assert 0 < len(within["vertical"]) <= len(within["perpendicular"])
