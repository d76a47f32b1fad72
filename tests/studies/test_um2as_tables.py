"""The tables of UM²AS chapter 4: what the study places, draws and bends is what it says."""

import numpy as np
import pytest
import um2as_tables as study


def test_markers_have_the_distances_that_were_measured():
    measured = np.array([[0, 304, 305, 305], [304, 0, 303, 311], [305, 303, 0, 302], [305, 311, 302, 0]], float)
    xyz = study.placed(measured)
    np.testing.assert_allclose(np.linalg.norm(xyz[:, None] - xyz, axis=2), measured, atol=1e-6)


def test_without_a_cause_there_is_no_error():
    found = study.draw(study.laboratory(), study.Cause(), 5)
    assert len(found) == 4 and all(np.abs(errors).max() < 1e-6 for errors in found.values())


def test_errors_follow_their_causes_and_the_rule_is_better_than_a_pair():
    lab = study.laboratory()
    once, twice = (study.draw(lab, study.Cause(markers=r), 300) for r in (0.25, 0.5))
    assert twice[study.RULE].std() == pytest.approx(2 * once[study.RULE].std(), rel=0.02)
    assert all(twice[study.RULE].std() < twice[way].std() for way in list(twice)[:3])


def test_a_barrel_makes_the_distances_too_long_and_noise_does_not():
    lab = study.laboratory()
    assert study.draw(lab, study.Cause(lens=-10.0), 200)[study.RULE].mean() < -0.7
    assert abs(study.draw(lab, study.Cause(0.5, 1.0, 0.5), 400)[study.RULE].mean()) < 0.1


@pytest.mark.parametrize(("hidden", "offset"), [(0.0, 0.0), (0.5, 4 / (3 * np.pi)), (1 - 1e-9, 1.0)])
def test_what_an_edge_leaves_of_a_disc(hidden, offset):
    """Half a disc has its centroid 4 / (3π) of the radius off; a sliver the whole radius."""
    assert study.segment_offset(hidden) == pytest.approx(offset, abs=2e-3)
