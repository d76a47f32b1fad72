"""Whether two pieces of path can be one marker."""

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory
from kinemark.edit import connection
from kinemark.synth import walking

RATE, SD = 100.0, 0.5


def piece(xyz, first, stop, seed=0):
    """A marker with noise, seen in frames first … stop − 1 alone."""
    noisy = np.full(xyz.shape, np.nan)
    noisy[first:stop] = xyz[first:stop] + np.random.default_rng(seed).normal(0, SD, (stop - first, 3))
    cov = np.where(np.isnan(noisy)[:, :1, None], np.nan, np.eye(3) * SD**2)
    return MarkerTrajectory.measured("*1", noisy, cov=cov)


@pytest.fixture(scope="module")
def walk():
    return walking(duration_s=2.0, rate=RATE, wobble_mm=1.0, seed=4).xyz


@pytest.mark.parametrize("gap", [0, 3, 8, 15])
def test_pieces_of_one_marker_connect_and_those_of_two_do_not(walk, gap):
    same, other = [], []
    for k in range(40):
        i, j = np.random.default_rng(k).permutation(len(walk))[:2]
        first = piece(walk[i], 0, 90, k)
        same.append(connection(first, piece(walk[i], 90 + gap, 200, 100 + k), rate=RATE).connectable)
        other.append(connection(first, piece(walk[j], 90 + gap, 200, 100 + k), rate=RATE).connectable)
    assert np.mean(same) > 0.85 and np.mean(other) < 0.1


def test_what_overlaps_must_be_at_one_place(walk):
    one = connection(piece(walk[0], 0, 110, 1), piece(walk[0], 90, 200, 2), rate=RATE)
    assert one.overlap == 20 and one.gap == 0 and one.connectable and one.off_mm < 4 * SD
    two = connection(piece(walk[0], 0, 110, 1), piece(walk[0] + [15.0, 0, 0], 90, 200, 2), rate=RATE)
    assert not two.connectable and two.off_mm == pytest.approx(15, abs=1.5) and two.deviations > 10


def test_a_piece_that_lies_in_a_gap_of_the_other_is_looked_at_from_both_sides(walk):
    holed = np.array(piece(walk[0], 0, 200, 1).xyz)
    holed[80:120] = np.nan
    whole = MarkerTrajectory.measured("A", holed)
    assert connection(whole, piece(walk[0], 83, 117, 2), rate=RATE).connectable
    away = connection(whole, piece(walk[0] + [0, 60.0, 0], 83, 117, 2), rate=RATE)
    assert not away.connectable and away.gap == 3


def test_the_order_does_not_matter_and_nothing_has_no_connection(walk):
    a, b = piece(walk[0], 0, 90, 1), piece(walk[0], 95, 200, 2)
    assert connection(a, b, rate=RATE) == connection(b, a, rate=RATE)
    with pytest.raises(ValueError, match="no sample"):
        connection(a, piece(walk[0], 0, 0), rate=RATE)
