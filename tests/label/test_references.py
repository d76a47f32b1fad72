"""Whose the samples of a stored reference are, where its own names glide over to another marker's place."""

import sys
from pathlib import Path

import numpy as np

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


def test_samples_at_an_absent_markers_place_are_that_ones_and_none_is_left_out():
    sys.path.insert(0, str(BENCHMARKS))
    try:
        from labelling_from_cameras import whose
    finally:
        sys.path.remove(str(BENCHMARKS))
    rng = np.random.default_rng(5)
    body = rng.uniform(0, 400, (6, 1, 3)) + np.cumsum(rng.normal(0, 3, (1, 200, 3)), axis=1)
    given = body.copy()
    given[0, :30], given[1, :30] = body[1, :30], np.nan
    own = whose(given)
    assert (own[0, :30] == 1).all(), "what glided over is the other's"
    assert (own[0, 30:] == 0).all() and (own[1:] == np.arange(1, 6)[:, None]).all(), "its witnesses are themselves"
