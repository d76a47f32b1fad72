"""Tracks through impacts, which change the velocity of a marker at once."""

import numpy as np
import pytest

from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.joining.impacts import with_impacts
from kinemark.track.simultaneous.joining.stitch import CLEAR_MARGIN, Stitched
from kinemark.track.simultaneous.points.neighbouring_points import TrackPoints
from support.scenes import tally
from support.scenes.impacts import impact_scene

METHOD = Simultaneous()
T = 0.01


@pytest.mark.parametrize("seed", [22, 36, 26])  # a ball, a body that lands, limbs that are struck
def test_an_impact_ends_no_track(seed):
    made = impact_scene(seed)
    t = tally(made, track_detections(made.detections, made.rig))
    assert t.swaps == 0
    assert t.pieces <= 1.3 * t.markers  # 4.0, 4.1 and 2.2 where impacts end tracks
    assert t.two_found + t.more_found >= 0.999 * (t.two + t.more)


def kinked(*places, jump=3000.0, time=20.4, frames=40, off=0.0, noise=0.3):
    """Points of markers that go on from `places` at 500 mm/s and rise by `jump` mm/s from frame `time` on, where their
    tracks end and others begin, `off` mm beside them; and the tracks as they were stitched."""
    rng = np.random.default_rng(3)
    f = np.arange(frames)
    x = np.array(places, float)[:, None] + 0.5 * T * 1000 * f[:, None] * [1.0, 0, 0]
    x[:, f > time] += [0.0, off, 0.0]
    x = (
        x
        + jump * T * np.maximum(f - time, 0)[:, None] * [0.0, 0, 1.0]
        + noise * rng.normal(size=(len(places), frames, 3))
    )
    id = np.arange(len(places))[:, None] + len(places) * (f > time)
    order = np.argsort(np.tile(f, len(places)), kind="stable")
    cov = np.broadcast_to(np.eye(3) * noise**2, (x[..., 0].size, 3, 3))
    points = TrackPoints(np.tile(f, len(places))[order], id.ravel()[order], x.reshape(-1, 3)[order], cov)
    return points, Stitched(np.arange(2 * len(places)), [])


ROW = [(0.0, 60.0 * k, 900.0) for k in range(4)]


@pytest.mark.parametrize("time", [20.1, 20.5, 20.9])
def test_whenever_the_impact_was_between_two_frames(time):
    joined = with_impacts(*kinked(*ROW, time=time), T, METHOD)
    assert joined.id.tolist() == [0, 1, 2, 3] * 2
    assert all(one.margin > CLEAR_MARGIN and (one.last, one.first) == (20, 21) for one in joined.stitches)


def test_what_begins_beside_the_path_is_another_marker():
    assert with_impacts(*kinked(ROW[0], off=25.0), T, METHOD).id.tolist() == [0, 1]


def test_a_ball_is_told_by_its_other_markers():
    """An impact of 9 m/s is rare for one marker, and of many at once it is the same."""
    assert with_impacts(*kinked(*ROW, jump=9000.0), T, METHOD).id.tolist() == [0, 1, 2, 3] * 2


def test_stitches_of_before_are_kept():
    points, _ = kinked(*ROW)
    whole = Stitched(np.append(np.arange(8), 3), [])  # track 8 was stitched to track 3
    assert with_impacts(points, whole, T, METHOD).id.tolist() == [0, 1, 2, 3, 0, 1, 2, 3, 3]


def test_nothing_of_nothing():
    none = TrackPoints(np.zeros(0, int), np.zeros(0, int), np.zeros((0, 3)), np.zeros((0, 3, 3)))
    assert with_impacts(none, Stitched(np.zeros(0, int), []), T, METHOD).id.tolist() == []
