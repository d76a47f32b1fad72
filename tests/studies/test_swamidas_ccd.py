"""Noise in images of a Gaussian target (Swamidas 1997, appendix C): the trends that the thesis notes."""

import numpy as np
import swamidas_ccd as study


def test_edges_are_better_than_the_centroid_and_errors_grow_with_the_noise():
    found = [study.errors(10, noise, 40, seed=3) for noise in study.NOISE]
    for one in found:
        assert (one["edge"] < 0.1).all() and (one["centroid"] > 10 * one["edge"]).all()
    for way in ("centroid", "edge"):
        assert (np.diff([one[way] for one in found], axis=0) > 0).all()


def test_a_flatter_target_has_less_error_of_the_centroid():
    found = [study.errors(variance, 0.05, 40, seed=3)["centroid"].mean() for variance in (5, 10, 20)]
    assert found[0] > found[1] > found[2]


def test_without_noise_both_ways_find_the_centre():
    centre = np.array([52.3, 47.6])
    seen = study.image(centre, 10.0, 0.0, np.random.default_rng(0))
    np.testing.assert_allclose(study.centroid(seen), centre, atol=0.1)  # the disc is cut at whole pixels
    np.testing.assert_allclose(study.edge_centre(seen, centre), centre, atol=0.05)
