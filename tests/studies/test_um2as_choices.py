"""The factor of eq. 2.8 and the markers of 2.2: what the study measures moves as it must."""

import numpy as np
import pytest
import um2as_choices as study


def test_in_the_thesis_laboratory_a_factor_of_two_leaves_nothing_out():
    lab = study.placements()["at right angles, as in the thesis"]
    for noise in study.NOISES.values():
        found = study.errors(lab, noise, 1000, 3).factors
        every = study.FACTORS.index(np.inf)
        np.testing.assert_allclose(study.root(found[study.FACTORS.index(2.0)]), study.root(found[every]), rtol=1e-3)


def test_where_two_cameras_look_alike_the_rule_halves_the_error():
    lab = study.placements()["two 12° apart, one across"]
    found = study.errors(lab, study.ordinary, 2000, 3).factors
    assert study.root(found[study.FACTORS.index(2.0)]) < 0.6 * study.root(found[study.FACTORS.index(np.inf)])


def test_without_lights_every_marker_is_found_and_large_ones_are_more_exact():
    method = {"": study.Centroids(threshold=100.0)}
    large, small = (study.experiment(ball, 210.0, 0, method, 30, 1)[""] for ball in (34.0, 13.0))
    assert large.found == small.found == 1 and large.alike == small.alike == 0
    assert large.rms < small.rms < 0.1


def test_many_lights_engulf_markers():
    method = {"": study.Centroids(threshold=56.0)}
    dark, bright = (study.experiment(34.0, 84.0, lights, method, 20, 1)[""] for lights in (0, 150))
    assert dark.found == 1 and bright.engulfed > 0.1 and bright.alike > 1
    assert bright.found + bright.engulfed + bright.lost == pytest.approx(1)
