"""What is expected of a fill that is tied to suspicious samples."""

import numpy as np
import pytest

from kinemark.fill import Body, Gap, LocalRegression, fill
from kinemark.fill.edges import GapEdges
from support.filling import moving, trial

GAP = Gap(2, 100, 125)


def filled_beside(wrong_mm, method=None):
    """The gap filled where the sample before it is wrong by so much; what is said of it and how wrong it is, mm."""
    motion = moving(300, soft=3.0, noise=0.2)
    xyz = motion.hidden([GAP]).xyz
    xyz[GAP.marker, GAP.start - 1] += wrong_mm / np.sqrt(3)
    done = fill(trial(motion._replace(xyz=xyz)), method=method, limit_mm=np.inf)
    (found,) = done.gaps
    d = done.trajectories.xyz[GAP.marker, GAP.start : GAP.stop] - motion.xyz[GAP.marker, GAP.start : GAP.stop]
    cov = done.trajectories[found.marker].cov[GAP.start : GAP.stop]
    return found, d, np.sqrt(np.diagonal(cov, axis1=1, axis2=2)), xyz, done


@pytest.mark.parametrize("method", [None, Body(), LocalRegression()], ids=["auto", "body", "local_regression"])
def test_the_error_said_is_true_although_the_edge_is_wrong(method):
    found, d, sd, xyz, done = filled_beside(60.0, method)
    assert found.suspicious == (GAP.start - 1,)
    assert found.expected_mm > 0.5 * np.linalg.norm(d, axis=1).mean() > 1.0
    assert (np.abs(d) < 2 * sd).mean() > 0.9
    seen = ~np.isnan(xyz)
    assert np.array_equal(done.trajectories.xyz[seen], xyz[seen])  # what was measured stays


def test_a_fill_beside_good_samples_is_not_doubted():
    found, d, *_ = filled_beside(0.0)
    assert not found.suspicious and found.expected_mm < 1.0 and np.linalg.norm(d, axis=1).mean() < 1.0


def test_a_fill_that_suspicious_samples_pull_away_stays_open():
    motion = moving(300, soft=3.0, noise=0.2)
    xyz = motion.hidden([GAP]).xyz
    xyz[GAP.marker, GAP.start - 1] += 150.0
    (found,) = fill(trial(motion._replace(xyz=xyz))).gaps
    assert found.state == "above_limit" and found.suspicious == (GAP.start - 1,)


def test_a_slow_drift_to_the_gap_is_told_by_the_other_markers():
    """Its own motion shows nothing of a millimetre a frame; where nothing drifts, nothing is listed."""
    motion = moving(300, soft=3.0, noise=0.2)
    xyz = motion.hidden([GAP]).xyz
    xyz[GAP.marker, GAP.start - 10 : GAP.start] += np.linspace(0.5, 10.0, 10)[:, None] / np.sqrt(3)
    done = fill(trial(motion._replace(xyz=xyz)), limit_mm=np.inf)
    (found,) = done.gaps
    d = done.trajectories.xyz[GAP.marker, GAP.start : GAP.stop] - motion.xyz[GAP.marker, GAP.start : GAP.stop]
    assert len(found.suspicious) >= 5 and max(found.suspicious) == GAP.start - 1
    assert found.expected_mm > 0.5 * np.linalg.norm(d, axis=1).mean() > 0.5
    seen = ~np.isnan(xyz)
    assert np.array_equal(done.trajectories.xyz[seen], xyz[seen])


def test_nobody_who_wants_no_check_gets_one():
    motion = moving(300, soft=3.0, noise=0.2)
    xyz = motion.hidden([GAP]).xyz
    xyz[GAP.marker, GAP.start - 10 : GAP.start] += np.linspace(1.0, 10.0, 10)[:, None]
    (found,) = fill(trial(motion._replace(xyz=xyz)), edges=GapEdges(most_trimmed=0)).gaps
    assert not found.suspicious
