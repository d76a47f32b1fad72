"""Sizes, brightness and banks tell markers apart where the epipolar line does not."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Detections, Rig
from kinemark.geometry import project, to_camera
from kinemark.match import NearestEpipolar, match
from kinemark.match.distinguishing import in_banks
from support.laboratory import IDEAL, camera

RIG = Rig((camera("c0", (4000.0, -1200.0, 1000.0), lens=IDEAL), camera("c1", (4000.0, 1500.0, 1000.0), lens=IDEAL)))
"""At one height, so that markers at their height are all in one epipolar plane."""


def scene(points, *, radius=None, peak=None, noise=0.3, seed=0):
    """Detections of points (n, 3) in both cameras, the second in another order, and the right pairs (n, 2)."""
    rng = np.random.default_rng(seed)
    n = len(points)
    order = rng.permutation(n)
    uv, area, light = [], [], []
    for c, own in ((RIG[0], np.arange(n)), (RIG[1], order)):
        uv.append(project(c, points[own]) + rng.normal(0, noise, (n, 2)))
        size = np.ones(n) if radius is None else np.asarray(radius)[own] * 1200 / to_camera(c, points[own])[:, 2]
        area.append(np.pi * size**2 * rng.normal(1, 0.05, n))
        light.append((np.ones(n) if peak is None else np.asarray(peak)[own]) * rng.normal(1, 0.05, n))
    light[1] *= 1.7  # another exposure
    shape = {"area": np.concatenate(area), "peak": np.concatenate(light)}
    seen = Detections.build(RIG.names, 100.0, [[n], [n]], np.concatenate(uv), **shape)
    right = sorted((int(k), n + int(np.flatnonzero(order == k)[0])) for k in range(n))
    return seen, right


def found(seen, **parameters):
    method = NearestEpipolar(line_sd=0.5, **parameters)
    return sorted(map(tuple, match(seen, RIG, method=method).detection.tolist()))


def in_one_plane(n, seed, apart=150.0):
    """Points at the cameras' height, none near another."""
    rng = np.random.default_rng(seed)
    points = [np.array([0.0, 0.0, 1000.0])]
    while len(points) < n:
        new = np.array([*rng.uniform(-600, 600, 2), 1000.0])
        if min(np.linalg.norm(new - p) for p in points) > apart:
            points.append(new)
    return np.array(points)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("way", ["radius", "peak"])
def test_in_one_epipolar_plane_sizes_or_brightness_tell(way, seed):
    seen, right = scene(in_one_plane(5, seed), **{way: [4.0, 6.0, 9.0, 13.5, 20.0]}, seed=seed)
    assert found(seen) != right  # by the line alone it is chance
    assert found(seen, **{"size_spread" if way == "radius" else "brightness_spread": 0.15}) == right


@pytest.mark.parametrize("seed", range(4))
def test_a_bank_tells_its_markers(seed):
    rng = np.random.default_rng(seed)
    bank = np.array([[0, 0, 0], [90.0, 0, 0], [30.0, 70.0, 0]])
    turn = rng.uniform(0, 2 * np.pi)
    R = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    points = np.concatenate([bank @ R.T + [200.0, 100.0, 1000.0], in_one_plane(2, seed, 300.0) - [0, 300.0, 0]])
    distances = tuple(float(np.linalg.norm(bank[a] - bank[b])) for a, b in ((0, 1), (1, 2), (2, 0)))
    right_of_bank = []
    for banks in ((), (distances,)):
        seen, right = scene(points, noise=0.2, seed=seed)
        pairs = found(seen, banks=banks, bank_tolerance=8.0)
        right_of_bank.append(sum(pair in pairs for pair in right[:3]))
    assert right_of_bank[1] == 3 and right_of_bank[0] < 3


def test_a_triangle_wants_three_pairs_without_a_common_image():
    X = np.full((3, 3, 3), 1e6) * np.arange(1, 10).reshape(3, 3, 1)
    X[0, 0], X[1, 1], X[2, 2] = [0, 0, 0], [90, 0, 0], [0, 40, 0]
    sides = (90.0, 40.0, float(np.hypot(90, 40)))
    near = np.ones((3, 3), bool)
    assert np.array_equal(in_banks(X, near, (sides,), 1.0), np.eye(3, dtype=bool))
    assert not in_banks(X, near, ((90.0, 45.0, sides[2]),), 1.0).any()
    assert np.array_equal(in_banks(X, near, ((40.0,),), 1.0), np.diag([True, False, True]))
    assert not in_banks(X, near & ~np.diag([False, False, True]), (sides,), 1.0).any()
    X[2, 1], X[2, 2] = X[2, 2], 5e6  # now two of them would be one image of the second camera
    assert not in_banks(X, near, (sides,), 1.0).any()


def test_what_an_image_does_not_say_counts_for_nothing():
    seen, _ = scene(in_one_plane(5, 1))
    silent = replace(seen, area=np.full(10, np.nan), peak=np.full(10, np.nan))
    assert found(silent, size_spread=0.1, brightness_spread=0.1) == found(silent)


def test_a_bank_has_one_distance_or_three():
    with pytest.raises(ValueError, match="length of a segment or the three distances"):
        NearestEpipolar(banks=((10.0, 20.0),))
