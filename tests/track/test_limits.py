"""Where the limits of the trackers lie: just inside a track goes on, just outside it does not."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Tracks
from kinemark.signal import gain
from kinemark.synth.score import score
from kinemark.track import DistanceOnly, ExtrapolationLadder, KissTracking, Swamidas, blend, track
from kinemark.track.swamidas import Constraint, follow_points, initial_state, track_distance, track_swamidas, update
from kinemark.track.swamidas.active_tracks import advance, initiate, no_tracks
from kinemark.track.swamidas.constraints import PredictedPoints, match_points
from kinemark.track.swamidas.segments import LearnedSegments, allowed_points
from kinemark.track.two_cameras.paired_paths import residuals
from support.clouds import cloud_and_markers as swamidas_cloud
from support.clouds import cloud_of, numbered, pieces
from support.clouds import tracks as scored
from support.laboratory import ring
from support.motions import line, parabolas


def sure(points, rate=50.0, cov=1e-6):
    """A cloud of points whose covariance says next to nothing."""
    cloud = cloud_of(points, rate)
    return replace(cloud, cov=cloud.cov * cov)


def kept(points, *, rate, method, cov=1e-6):
    """Whether all points are one track."""
    return len(track(sure(points, rate, cov), method=method)) == 1


# The extrapolation ladder, (1) to (3)


@pytest.mark.parametrize("rate", [50.0, 200.0])
@pytest.mark.parametrize(("share", "whole"), [(0.98, True), (1.02, False)])
def test_a_track_bends_by_the_usual_acceleration_and_scatter(rate, share, whole):
    method = ExtrapolationLadder(min_points=1, max_coasting=0.0)
    limit = method.gate * (method.acceleration_sd / rate**2 / 2 + method.scatter)  # (1)
    points = line(12, (4.0, 0, 0))
    points[:, 11, 1] += share * limit
    assert kept(points, rate=rate, method=method) == whole


@pytest.mark.parametrize("missed", [1, 2])
@pytest.mark.parametrize(("share", "whole"), [(0.98, True), (1.02, False)])
def test_the_region_grows_with_every_frame_that_is_missed(missed, share, whole):
    method, rate = ExtrapolationLadder(min_points=1, max_coasting=0.1), 50.0
    limit = method.gate * (method.acceleration_sd * ((missed + 1) / rate) ** 2 / 2 + method.scatter)
    points = line(12 + missed, (4.0, 0, 0))
    points[:, 11 + missed, 1] += share * limit
    points[:, 11 : 11 + missed] = np.nan
    assert kept(points, rate=rate, method=method) == whole


@pytest.mark.parametrize("rate", [50.0, 200.0])
@pytest.mark.parametrize(("share", "whole"), [(0.98, True), (1.02, False)])
def test_a_single_point_may_move_as_fast_as_the_greatest_speed(rate, share, whole):
    method = ExtrapolationLadder(min_points=1, max_coasting=0.0)
    points = line(2, (share * method.max_speed / rate, 0, 0))
    assert kept(points, rate=rate, method=method) == whole


@pytest.mark.parametrize(("share", "whole"), [(0.98, True), (1.02, False)])
def test_the_region_has_the_covariance_of_the_last_point_in_it(share, whole):
    method, rate, sd = ExtrapolationLadder(min_points=1, max_coasting=0.0), 50.0, 10.0
    stray = method.acceleration_sd / rate**2 / 2 + method.scatter
    limit = method.gate * np.sqrt(sd**2 * (1 + gain(np.array([5]))[0]) + stray**2)  # (2)
    points = line(12, (4.0, 0, 0))
    points[:, 11, 1] += share * limit
    assert kept(points, rate=rate, method=method, cov=sd**2) == whole


# Blending


def cut(points, first, second):
    """Tracks of one path whose first `first` points are one piece, and those from `second` on another."""
    points = points.copy()
    points[:, first:second] = np.nan
    cloud = cloud_of(points)
    return Tracks(cloud, (cloud.frame >= second).astype(np.int64))


def test_pieces_of_successive_fields_are_blended():
    assert pieces(blend(cut(line(20, (5.0, 0, 0)), 10, 10)).id) == [20]


@pytest.mark.parametrize(("points", "whole"), [(5, True), (2, False)])
def test_blending_continues_the_parabola_of_five_points(points, whole):
    """Of two points only a line is known, and it misses."""
    t = np.arange(2 * points + 1)
    path = np.stack([8.0 * t**2, 0 * t, 0 * t], -1)[None].astype(float)
    both = cut(path, points, points + 1)
    assert (len(blend(both, search_radius=1e-6)) == 1) == whole


@pytest.mark.parametrize(("far", "whole"), [(190.0, True), (210.0, False)])
def test_a_track_of_one_point_may_be_its_reach_away_for_every_frame(far, whole):
    path = line(3, (far / 2, 0, 0))
    assert (len(blend(cut(path, 1, 2), search_radius=1.0, max_distance=100.0)) == 1) == whole


# Swamidas


def test_a_region_grows_by_the_velocity_in_the_frame_of_the_last_point():
    paths = parabolas(n=1, frames=20)
    seen = np.arange(20)[None] < 15
    cloud, _ = swamidas_cloud(paths, seen)
    expected = follow_points(cloud, method=Swamidas(measurement_sd=1.0, velocity_share=1.0)).expected
    true = (paths[0, 15] - paths[0, 13]) / 2  # of a parabola, exactly
    for f in (15, 16, 18):
        assert expected[f].half[0] == pytest.approx((f - 14) * (1.0 + np.abs(true)), rel=1e-6)


def test_after_a_gap_the_positions_before_are_no_measurements():
    active = initiate(no_tracks(), np.array([0]), np.zeros((1, 3)))
    here, nothing = np.array([0]), np.array([-1])
    for k in (1, 2, 3):
        active = advance(active, here, np.full((1, 3), 10.0 * k), sd=1.0, process_sd=0.1)
    assert (active.seen[0], active.going[0]) == (3, True)
    active = advance(active, nothing, np.zeros((0, 3)), sd=1.0, process_sd=0.1)
    for wanted in (1, 2, 3, 3):
        active = advance(active, here, np.full((1, 3), 50.0), sd=1.0, process_sd=0.1)
        assert (active.seen[0], active.missed[0]) == (wanted, 0)


def test_what_may_be_one_end_of_a_segment_is_not_the_other():
    points = np.array([[-49.0, 0, 0], [49.0, 0, 0], [0, 99.0, 0]])  # two near where track 1 is expected
    predicted = np.array([[0, 100.0, 0], [0, 0, 0]])
    one = LearnedSegments(np.array([[0, 1]]), np.array([100.0]))
    allowed = allowed_points(points, predicted, np.array([False, True]), one, 0.2)
    assert allowed[0].tolist() == [False, False, True]


@pytest.mark.parametrize(("follow", "method"), [(track_distance, DistanceOnly), (track_swamidas, Swamidas)])
@pytest.mark.parametrize(("hidden", "tracks"), [(3, 1), (4, 2)])
def test_patience_lasts_as_long_as_it_says(follow, method, hidden, tracks):
    path = line(30, (0.1, 0, 0))
    path[:, 10 : 10 + hidden] = np.nan
    assert len(follow(cloud_of(path, 30.0), method=method(max_coasting=0.1, initiate_from="any"))) == tracks


def test_the_velocity_is_that_since_the_last_point():
    """Three tracks are nearest to one point; of the others, each of two has come by its own velocity in four frames."""
    velocity = np.array([[0.0, 0, 0], [10.0, 0, 0], [40.0, 0, 0]])
    at = np.array([[1000.0, 0, 0], [1001.0, 0, 0], [1002.0, 0, 0]])
    expected = PredictedPoints(at, np.full((3, 3), np.nan), velocity, np.zeros((3, 3)), np.full(3, 4))
    points = np.array([[1000.0, 0, 0], [40.0, 0, 0], [160.0, 0, 0]])
    taken, by = match_points(expected, points, np.ones((3, 3), bool))
    assert taken.tolist() == [0, 1, 2]
    assert by.tolist() == [Constraint.DISTANCE, Constraint.VELOCITY, Constraint.VELOCITY]


@pytest.mark.parametrize(("first_seen", "tracks"), [(2, 2), (3, 1)])
def test_tracks_begin_in_the_first_three_frames(first_seen, tracks):
    paths = np.concatenate([line(10, (1.0, 0, 0)), line(10, (1.0, 0, 0), (0, 500.0, 0))])
    paths[1, :first_seen] = np.nan
    assert len(track_swamidas(cloud_of(paths, 30.0))) == tracks


def test_predictions_are_the_filters_with_the_jerk_of_a_frame():
    rate, method = 30.0, Swamidas(measurement_sd=2.0, jerk=20_000.0)
    paths = parabolas(n=1, frames=12) + np.random.default_rng(1).normal(scale=2.0, size=(1, 12, 3))
    cloud, _ = swamidas_cloud(paths, rate=rate)
    expected = follow_points(cloud, method=method).expected
    process_sd = method.jerk / rate**3  # U = jerk · T³
    state = initial_state(paths[:, [2, 1, 0]], 2.0, process_sd)
    for f in range(3, 12):
        assert expected[f].xyz == pytest.approx(state.x[:, 0], abs=1e-9)
        state = update(state, paths[:, [f, f - 1, f - 2]], np.array([True]), 2.0, process_sd)


@pytest.mark.parametrize(("within", "tracks"), [(0.04, 1), (0.0, 2)])
def test_the_method_of_kiss_blends_what_it_linked(within, tracks):
    path = line(30, (5.0, 0, 0))
    path[:, 15] = np.nan
    assert len(track(cloud_of(path), method=KissTracking(max_gap=within, min_points=1))) == tracks


# The score


@pytest.mark.parametrize(("gone_before", "there_before", "swaps"), [(40, 0, 1), (0, 40, 1), (0, 0, 0)])
def test_a_track_swaps_if_either_path_was_there_with_the_other(gone_before, there_before, swaps):
    """A track goes over from one path to the next in frame 30; the first goes on so long, or the second was there."""
    t = np.arange(100)
    truth = np.stack([np.stack([5.0 * t, 40.0 * k + 0 * t, 0 * t], -1) for k in range(2)]).astype(float)
    points = truth.copy()
    points[0, 30:], points[1, :30] = np.nan, np.nan
    truth[0, 30 + gone_before :] = np.nan
    truth[1, : max(30 - there_before, 0)] = np.nan
    result = score(scored(points, numbered(truth) * 0), truth)
    assert result.swaps == swaps


# The former method


def test_images_that_meet_behind_the_cameras_are_no_pair():
    """The algebra does not know where the cameras look: a point behind both has images that fit perfectly."""
    rig = ring(12, lens=np.zeros(5)).select(["c0", "c1"])
    before = np.array([100.0, 50.0, 900.0])
    behind = rig.centres.mean(0) + 2.0 * (rig.centres.mean(0) - before)
    for point, limit in ((before, 1e-6), (behind, np.inf)):
        h = rig.P @ np.append(point, 1.0)
        uv = h[:, :2] / h[:, 2:]
        (r,) = residuals(uv[0, None, None], uv[1, None, None], rig.P).ravel()
        assert (h[:, 2] > 0).all() == (limit < 1) and (r < limit if limit < 1 else r == limit)
