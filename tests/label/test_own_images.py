"""Sets that are their own image, as a hand whose markers are numbered or a box: names are asked for, never wrong."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import label, learn_template
from kinemark.label.evidence import PairScore
from kinemark.label.own_images import images
from kinemark.report.words import advice_of, text_of

FRAMES, RATE = 300, 100.0
ALIKE, UNLIKE = (1.0,) * 5, (0.8, 1.0, 1.1, 1.0, 0.85)
"""Lengths of fingers, of a hand that is its own mirror image and of one that is not."""
BONES_MM = (0.0, 40.0, 25.0, 20.0)
BRICK = np.array([[x, y, z] for x in (-150, 150) for y in (-100, 100) for z in (-50, 50)], float)


def waves(rng, n, size):
    t = np.arange(FRAMES)[:, None] / RATE
    return sum(size / (k + 1) * np.sin(2 * np.pi * (0.3 + 0.4 * k) * t + rng.uniform(0, 6.3, n)) for k in range(4))


def recorded(paths, rng):
    noisy = {name: xyz + rng.normal(0, 0.3, xyz.shape) for name, xyz in paths.items()}
    return Trajectories(tuple(MarkerTrajectory.measured(name, xyz) for name, xyz in noisy.items()), RATE)


@cache
def hand(seed, fingers=ALIKE):
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
    return recorded({"wrist": wrist, **out}, rng)


def box(seed, corners=BRICK):
    rng = np.random.default_rng([seed, 7])
    R, middle = Rotation.from_rotvec(waves(rng, 3, 1.0)).as_matrix(), waves(rng, 3, 300.0)
    return recorded({f"m{k}": middle + R @ corner for k, corner in enumerate(corners)}, rng)


def sure_and_wrong(found, trial):
    each = zip(found.names, trial.names, found.state, strict=True)
    return [(one, name) for one, name, state in each if state == "sure" and one != name]


@pytest.mark.parametrize("seed", [2, 12, 13])
def test_names_of_a_hand_that_nothing_tells_from_its_mirror_image_are_asked_for(seed):
    found = label(hand(seed), learn_template(hand(1)))
    assert not sure_and_wrong(found, hand(seed))
    assert found.undecided.kind == "own_image" and found.undecided.values["ways"] == 2
    other = dict(zip(found.undecided.markers, found.undecided.values["other_list"], strict=True))
    assert other["00"] == "40" and other["31"] == "11" and "wrist" not in other and "23" not in other
    k = found.names.index("00")
    assert found.probability[k] <= 0.5 and found.runner_up[k] == "40"


@pytest.mark.parametrize("marker", ["01", "43"])
def test_one_name_that_was_stated_makes_all_of_them_sure_and_right(marker):
    found = label(hand(2), learn_template(hand(1)), stated={marker: marker})
    assert found.names == hand(2).names and set(found.state) == {"sure"} and found.undecided is None


def test_a_marker_on_the_plane_of_symmetry_breaks_none():
    found = label(hand(2), learn_template(hand(1)), stated={"20": "20"})
    assert found.undecided is not None and not sure_and_wrong(found, hand(2))


def test_a_hand_whose_fingers_differ_has_sure_names():
    found = label(hand(2, UNLIKE), learn_template(hand(1, UNLIKE)))
    assert found.names == hand(2).names and set(found.state) == {"sure"} and found.undecided is None


@pytest.mark.parametrize("seed", [2, 3])
def test_a_box_has_four_ways_as_quadruples_tell_it_from_its_mirror_image(seed):
    found = label(box(seed), learn_template(box(1)))
    assert found.undecided.values["ways"] == 4 and (found.probability <= 0.25).all()
    assert "m0" in text_of(found.undecided) and advice_of(found.undecided)


def test_a_box_that_differs_by_a_few_mm_has_sure_names():
    uneven = BRICK + np.array([[0, 0, 0], [6, 0, 0], [0, 0, 0], [0, 5, 0], [0, 0, 0], [0, 0, -7], [0, 0, 0], [4, 0, 0]])
    found = label(box(2, uneven), learn_template(box(1, uneven)))
    assert found.names == box(2).names and found.undecided is None


def test_images_keep_all_distances_and_those_that_were_stated():
    d = np.linalg.norm(BRICK[:, None] - BRICK, axis=2).astype(np.float32)
    pairs = PairScore.of_template(learn_template(box(1)))
    found = images(d, pairs, np.array([], int), most=5.0)
    assert len(found) == 7  # of the eight symmetries of a brick those that move anything
    for turn in found:
        np.testing.assert_allclose(d[np.ix_(turn, turn)], d, atol=1e-3)
    assert not len(images(d, pairs, np.array([0]), most=5.0)[:, 0].nonzero()[0])
