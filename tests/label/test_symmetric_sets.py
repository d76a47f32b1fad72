"""Sets that are their own mirror image without names of left and right, as a hand whose markers are numbered."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import label, learn_template
from kinemark.label.side_pairs import other_sides

FRAMES, RATE = 300, 100.0
ALIKE, UNLIKE = (1.0,) * 5, (0.8, 1.0, 1.1, 1.0, 0.85)
"""Lengths of fingers, of a hand that is its own mirror image and of one that is not."""
BONES_MM = (0.0, 40.0, 25.0, 20.0)


def waves(rng, n, size):
    t = np.arange(FRAMES)[:, None] / RATE
    return sum(size / (k + 1) * np.sin(2 * np.pi * (0.3 + 0.4 * k) * t + rng.uniform(0, 6.3, n)) for k in range(4))


@cache
def hand(seed, fingers):
    """A wrist and five fingers of four markers, each of which bends for itself, to both sides."""
    rng = np.random.default_rng([seed, 5])
    x, y, z = np.moveaxis(Rotation.from_rotvec(waves(rng, 3, 0.5)).as_matrix(), 2, 0)
    wrist, out = waves(rng, 3, 150.0), {}
    for f, share in enumerate(fingers):
        bend, place, angle = 0.5 + waves(rng, 1, 0.4), wrist + x * 80 * share + y * (f - 2) * 20, 0.0
        for j, bone in enumerate(BONES_MM):
            angle = angle + bend * (j > 0)
            place = place + bone * share * (np.cos(angle) * x + np.sin(angle) * z)
            out[f"{f}{j}"] = place
    paths = {"wrist": wrist, **out}.items()
    return Trajectories(
        tuple(MarkerTrajectory.measured(name, xyz + rng.normal(0, 0.3, xyz.shape)) for name, xyz in paths), RATE
    )


def named(seed, fingers):
    trial = hand(seed, fingers)
    return trial.names, label(trial, learn_template(hand(1, fingers)))


@pytest.mark.parametrize("seed", [2, 3])
def test_names_of_a_hand_that_nothing_tells_from_its_mirror_image_are_asked_for(seed):
    names, found = named(seed, ALIKE)
    sure = [(one, name) for one, name, state in zip(found.names, names, found.state, strict=True) if state == "sure"]
    assert all(one == name for one, name in sure)
    assert found.undecided is not None and found.undecided.kind == "sides_undecided"
    assert {"00", "10", "30", "40"} <= set(found.undecided.markers) and "wrist" not in found.undecided.markers


def test_a_hand_whose_fingers_differ_has_sure_names():
    names, found = named(2, UNLIKE)
    assert found.names == names and set(found.state) == {"sure"} and found.undecided is None


def test_sides_are_by_names_where_any_has_one_and_of_few_markers_by_nothing_else():
    template = learn_template(hand(1, ALIKE))
    other = other_sides(template.names, template.distance)
    partner = dict(zip(template.names, (template.names[a] for a in other), strict=True))
    assert [partner[name] for name in ("wrist", "00", "31", "23")] == ["wrist", "40", "11", "23"]
    by_name = other_sides(("LASI", "RASI", *template.names[2:]), template.distance)
    np.testing.assert_array_equal(by_name, [1, 0, *range(2, 21)])
    np.testing.assert_array_equal(other_sides(template.names[:5], template.distance[:5, :5]), np.arange(5))
