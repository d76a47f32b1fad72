"""The second generator says which image is whose, and the oracle of `benchmarks/tracking_oracle.py` goes by it."""

import sys
from pathlib import Path

import numpy as np
import pytest

from support.scenes import make, scene
from support.scenes.placements import seen

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
from tracking_oracle import of_one, oracle, piece_numbers

SEED = 29
"""Of 39 markers before four cameras, where images merge and no file says so."""


@pytest.fixture(scope="module")
def made():
    return make(scene(SEED))


def test_images_are_where_their_markers_are(made):
    alone = of_one(made)
    np.testing.assert_array_equal(alone.sum(0), made.own)
    there = np.array([seen(camera, made.xyz)[0] for camera in made.true])
    off = np.linalg.norm(there - made.detections.uv[made.image], axis=-1)
    assert np.median(off[alone]) < 2 * made.scene.optics.noise
    assert off[alone].max() < 6 * made.scene.optics.noise


def test_holes_part_no_piece_that_are_as_long_as_is_said():
    there = np.array([[True, False, False, True, False, False, False, True], [True] * 8])
    assert piece_numbers(there, 3).tolist() == [[0, -1, -1, 0, -1, -1, -1, 1], [2] * 8]


def test_the_oracle_meets_the_aims_but_does_not_find_all_for_nothing(made):
    found = oracle(made)
    assert found.two == ((made.own == 2) & (made.sd <= 50)).sum()
    assert found.two_found > 0.97 * found.two
    assert found.ghosts <= 0.02 * found.frames
    assert found.two_found < found.two  # there are chance meetings that are likelier than some of its pieces
