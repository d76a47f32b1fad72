"""Matching, reconstruction and tracking on scenes whose truth is known."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinemark.data import Cloud, Detections, KinemarkError, Tracks, Validity, same
from kinemark.match import EpipolarTriplets, match
from kinemark.reconstruct import LeastSquares, reconstruct
from kinemark.signal import LADDER, assign, extrapolate, gain, weights
from kinemark.synth.score import changes, score
from kinemark.track import ExtrapolationLadder, to_trajectories, track
from support.clouds import groups_of
from support.laboratory import observe, ring
from support.motions import swarm


@pytest.mark.parametrize("n_cameras", [3, 4, 6, 9])
def test_every_marker_is_matched_and_no_image_is_used_twice(n_cameras):
    rig, points = ring(n_cameras), swarm(n=15, frames=5)
    detections, truth = observe(rig, points, noise=0.1)
    matches = match(detections, rig, method=EpipolarTriplets(pairs="best"))
    groups = groups_of(matches, truth)
    right = [group for group in groups if len(group) == 1]
    assert len(right) >= 0.97 * 15 * 5
    used = matches.detection[matches.detection >= 0]
    assert len(np.unique(used)) == len(used)
    for c in range(n_cameras):
        own = matches.detection[:, c]
        assert (detections.camera[own[own >= 0]] == c).all()
        assert (detections.frame[own[own >= 0]] == matches.frame[own >= 0]).all()


def test_matching_does_not_depend_on_the_order_of_cameras_or_of_images():
    rig, points = ring(5), swarm(n=12, frames=3)
    a, truth_a = observe(rig, points, noise=0.0, seed=1)
    b, truth_b = observe(rig, points, noise=0.0, seed=2)
    turned = rig.select(rig.names[::-1])
    one, other = match(a, rig), match(b.select(turned.names), turned)
    rows = [b.start[c, 0] + np.arange(b.start[c, -1] - b.start[c, 0]) for c in (4, 3, 2, 1, 0)]
    truth_b = truth_b[np.concatenate(rows)]

    def found(matches, truth):
        return sorted(
            (int(f), *sorted(truth[v[v >= 0]])) for f, v in zip(matches.frame, matches.detection, strict=True)
        )

    assert found(one, truth_a) == found(other, truth_b)


def test_ghosts_of_two_cameras_are_fewer_with_three():
    points = swarm(n=25, frames=4)
    wrong = {}
    for n in (2, 3):
        rig = ring(6).select([f"c{i}" for i in range(n)])
        detections, truth = observe(rig, points, noise=0.1)
        wrong[n] = sum(len(group) > 1 for group in groups_of(match(detections, rig), truth))
    assert wrong[3] < wrong[2] / 2


def test_two_cameras_match_by_pairs_and_only_if_asked():
    rig = ring(6).select(["c0", "c2"])
    detections, truth = observe(rig, swarm(n=3, frames=2, seed=4), noise=0.0)
    assert len(match(detections, rig, method=EpipolarTriplets(pairs="none"))) == 0
    assert sum(group == {m} for group in groups_of(match(detections, rig), truth) for m in range(3)) == 6


def test_invalid_detections_are_left_out():
    rig = ring(4)
    detections, truth = observe(rig, swarm(n=5, frames=2))
    flagged = replace(detections, validity=np.where(truth == 3, Validity.TOO_LARGE, 0).astype(np.uint8))
    assert {3} not in groups_of(match(flagged, rig), truth)
    assert {3} in groups_of(match(detections, rig), truth)


def test_an_image_that_fits_no_marker_joins_none():
    """One image of a marker is moved by 6 px: the group loses that camera and nothing else."""
    rig, points = ring(5), swarm(n=1, frames=1)
    detections, _ = observe(rig, points)
    uv = detections.uv.copy()
    uv[2] += [4.0, 4.5]
    detection = match(replace(detections, uv=uv), rig).detection[0]
    assert (detection >= 0).tolist() == [True, True, False, True, True]


@pytest.mark.parametrize("frames", [0, 1])
def test_nothing_seen_is_no_error(frames):
    rig = ring(3)
    nothing = Detections.build(rig.names, 100.0, np.zeros((3, frames), int), np.zeros((0, 2)))
    cloud = reconstruct(match(nothing, rig), nothing, rig)
    tracks = track(cloud)
    assert len(cloud) == len(tracks) == len(to_trajectories(tracks, rig)) == 0
    assert cloud.n_frames == frames


def test_one_camera_or_other_cameras_are_refused():
    rig = ring(3)
    detections, _ = observe(rig, swarm(n=2, frames=1))
    with pytest.raises(KinemarkError, match="needs two"):
        match(detections.select(["c0"]), rig.select(["c0"]))
    with pytest.raises(KinemarkError, match="same cameras"):
        match(detections, rig.select(["c2", "c1", "c0"]))


def test_noise_that_files_do_not_state_is_found_in_the_data():
    rig, points = ring(6), swarm(n=20, frames=20)
    stated, _ = observe(rig, points, noise=0.3)
    unknown, _ = observe(rig, points, noise=0.3, cov=False)
    a = reconstruct(match(stated, rig), stated, rig)
    b = reconstruct(match(unknown, rig), unknown, rig)
    ratio = np.median(np.trace(b.cov, axis1=1, axis2=2)) / np.median(np.trace(a.cov, axis1=1, axis2=2))
    assert abs(ratio - 1) < 0.1


def test_points_outside_the_volume_are_dropped_if_there_is_one():
    points = swarm(n=10, frames=3)
    rig = ring(5)
    detections, _ = observe(rig, points, noise=0.05)
    volume = np.array([[-2000, -2000, 900], [2000, 2000, 3000]])
    cloud = reconstruct(
        match(detections, rig), detections, replace(rig, volume=volume), method=LeastSquares(volume_margin=0)
    )
    inside = (points[..., 2] >= 900).sum()
    assert abs(len(cloud) - inside) <= 1
    assert (cloud.xyz[:, 2] >= 900).all()


@pytest.mark.parametrize(("samples", "degree"), sorted(set(LADDER)))
def test_each_rung_continues_its_polynomial_exactly(samples, degree):
    t = np.arange(-samples + 1, 2)
    y = np.polyval(np.arange(1.0, degree + 2), t)
    assert abs(weights(samples, degree) @ y[:-1] - y[-1]) < 1e-9


def test_the_ladder_is_that_of_kiss():
    y = np.random.default_rng(0).normal(size=(1, 5, 3))
    assert np.allclose(extrapolate(y, np.array([1])), y[:, 4])
    assert np.allclose(extrapolate(y, np.array([2])), 2 * y[:, 4] - y[:, 3])
    for known, points, degree in ((3, 3, 1), (4, 3, 1), (5, 5, 2), (40, 5, 2)):
        t = np.arange(points)
        fit = [np.polyval(np.polyfit(t, y[0, -points:, k], degree), points) for k in range(3)]
        assert np.allclose(extrapolate(y, np.array([known]))[0], fit)


def test_the_variance_of_a_prediction_is_its_gain():
    noise = np.random.default_rng(1).normal(size=(200_000, 5, 1))
    for known in range(1, 6):
        n = np.full(len(noise), known)
        assert abs(extrapolate(noise, n).var() / gain(n[:1])[0] - 1) < 0.02


@given(st.integers(0, 5), st.integers(0, 5), st.integers(0, 1000))
def test_assignment_never_goes_beyond_the_limit_and_leaves_no_free_pair(n, m, seed):
    cost = np.random.default_rng(seed).random((n, m))
    limit = np.full(n, 0.5)
    rows, columns = assign(cost, limit)
    assert (cost[rows, columns] <= 0.5).all()
    assert len(set(rows)) == len(rows)
    assert len(set(columns)) == len(columns)
    free = np.delete(np.delete(cost, rows, 0), columns, 1)
    assert not (free <= 0.5).any()


def tracked(points, *, cameras=6, noise=0.1, rate=100.0, hide=None, method=None):
    """Tracks of points (M, F, 3), with some hidden from all cameras (M, F)."""
    rig = ring(cameras)
    seen = points if hide is None else np.where(hide[..., None], np.nan, points)
    detections, _ = observe(rig, seen, noise=noise, rate=rate)
    return track(reconstruct(match(detections, rig), detections, rig), method=method or ExtrapolationLadder())


@pytest.mark.parametrize("rate", [50.0, 100.0, 250.0])
def test_markers_are_tracked_whole_without_swaps_or_ghosts(rate):
    points = swarm(n=15, frames=80, rate=rate)
    result = score(tracked(points, rate=rate), points)
    assert result.recall > 0.995
    assert result.swaps == 0
    assert (result.fragments == 1).all()
    assert result.extra_per_frame < 0.1
    assert result.rmse < 0.5
    assert abs(result.coverage - 0.95) < 0.03


def test_a_short_gap_is_bridged_and_a_long_one_begins_another_track():
    points = swarm(n=3, frames=80)
    for length, pieces in ((3, 1), (20, 2)):
        hide = np.zeros((3, 80), bool)
        hide[1, 40 : 40 + length] = True
        result = score(tracked(points, hide=hide), points)
        assert result.fragments.tolist() == [1, pieces, 1]
        assert result.swaps == 0


def test_tracks_that_cross_keep_their_identity():
    t = np.linspace(-1, 1, 81)[:, None]
    a = np.hstack([300 * t, 0 * t, 900 + 0 * t])
    b = np.hstack([-300 * t, 25 + 0 * t, 900 + 0 * t])
    result = score(tracked(np.stack([a, b])), np.stack([a, b]))
    assert result.swaps == 0
    assert result.fragments.tolist() == [1, 1]


def test_short_tracks_lose_their_identity():
    points = swarm(n=2, frames=40)
    hide = np.zeros((2, 40), bool)
    hide[1, 8:] = True
    assert len(tracked(points, hide=hide)) == 1
    assert len(tracked(points, hide=hide, method=ExtrapolationLadder(min_points=5))) == 2


def test_tracking_twice_gives_the_same():
    points = swarm(n=8, frames=30)
    assert same(tracked(points), tracked(points))


def test_tracks_become_paths_with_all_they_know():
    points = swarm(n=2, frames=30)
    hide = np.zeros((2, 30), bool)
    hide[0, 10:12] = True
    tracks = tracked(points, hide=hide)
    trajectories = to_trajectories(tracks, ring(6))
    assert trajectories.names == ("*1", "*2")
    assert trajectories.xyz.shape == (2, 30, 3)
    path = next(p for p in trajectories if p.gaps)
    assert path.gaps == [(10, 12)]
    assert (path.cameras[[0, 10]] == [0b111111, 0]).all()
    for i, p in enumerate(trajectories):
        own = tracks.id == i
        assert (p.xyz[tracks.cloud.frame[own]] == tracks.cloud.xyz[own]).all()


def scored_tracks(points, identity):
    """Tracks that sit exactly on points (M, F, 3), with identities (M, F)."""
    m, f, _ = points.shape
    cloud = Cloud(
        100.0,
        np.arange(f + 1) * m,
        points.transpose(1, 0, 2).reshape(-1, 3),
        np.tile(np.eye(3), (m * f, 1, 1)),
        np.zeros(m * f),
        np.zeros((m * f, 2), int),
    )
    return Tracks(cloud, identity.T.ravel())


def test_the_score_counts_swaps_pieces_and_extra_points():
    points = swarm(n=3, frames=20)
    identity = np.repeat(np.arange(3)[:, None], 20, 1)
    perfect = score(scored_tracks(points, identity), points)
    assert (perfect.recall, perfect.swaps, perfect.extra_per_frame, perfect.rmse) == (1.0, 0, 0.0, 0.0)
    swapped = identity.copy()
    swapped[:2, 10:] = swapped[1::-1, 10:]
    assert score(scored_tracks(points, swapped), points).swaps == 2
    lost = identity.copy()
    lost[2, 5:] = -1
    assert score(scored_tracks(points, lost), points).recall == 45 / 60
    assert score(scored_tracks(points, identity), points[:2]).extra_per_frame == 1.0
    broken = identity.copy()
    broken[0, 10:] = 3
    assert score(scored_tracks(points, broken), points).fragments.tolist() == [2, 1, 1]


def test_going_over_to_a_path_that_begins_where_another_ends_is_no_swap():
    points = swarm(n=1, frames=20)
    truth = np.full((2, 20, 3), np.nan)
    truth[0, :10], truth[1, 10:] = points[0, :10], points[0, 10:]
    tracks = scored_tracks(points, np.zeros((1, 20), int))
    result = score(tracks, truth)
    assert (result.swaps, result.recall) == (0, 1.0)
    assert changes(tracks, result.owner, truth) == []


def spoiled(rig, points, shift, *, area=None, seed=0):
    """Detections of points (M, F, 3) in which the first camera's images are moved by `shift` px in any direction."""
    detections, _ = observe(rig, points, noise=0.05, seed=seed)
    first = slice(detections.start[0, 0], detections.start[0, -1])
    turn = np.random.default_rng(seed).uniform(0, 2 * np.pi, first.stop - first.start)
    uv = detections.uv.copy()
    uv[first] += shift * np.column_stack([np.cos(turn), np.sin(turn)])
    size = np.full(len(uv), np.nan) if area is None else apparent_area(rig, detections, 12.5)
    if area is not None:
        size[first] *= area
    return replace(detections, uv=uv, area=size)


def apparent_area(rig, detections, radius):
    """Area (D) px² of spheres of this radius, mm, at the distance of the volume's middle."""
    scale = np.array([c.K[0, 0] / np.linalg.norm(c.centre - [0, 0, 900]) for c in rig])
    return np.pi * (radius * scale[detections.camera]) ** 2


def errors(detections, rig, points, **method):
    """Distances mm of the reconstructed points from the nearest truth, and their χ²."""
    cloud = reconstruct(match(detections, rig), detections, rig, method=LeastSquares(**method))
    off = cloud.xyz[:, None] - points[:, cloud.frame].transpose(1, 0, 2)
    off = off[np.arange(len(off)), np.linalg.norm(off, axis=-1).argmin(1)]
    return np.linalg.norm(off, axis=1), (off * np.linalg.solve(cloud.cov, off[..., None])[..., 0]).sum(1)


def test_one_wild_camera_hardly_moves_a_point():
    rig, points = ring(6), swarm(n=6, frames=20)
    clean = errors(spoiled(rig, points, 0.0), rig, points)[0]
    plain = errors(spoiled(rig, points, 1.2), rig, points, degrees_of_freedom=0.0)[0]
    robust, squared = errors(spoiled(rig, points, 1.2), rig, points)
    assert np.median(plain) > 3 * np.median(clean)
    assert np.median(robust) < 1.3 * np.median(clean)
    assert (squared < 7.8).mean() > 0.85


def test_heavy_tails_cost_nothing_where_all_cameras_agree():
    rig, points = ring(6), swarm(n=6, frames=20)
    plain, robust = (errors(spoiled(rig, points, 0.0), rig, points, degrees_of_freedom=t)[0] for t in (0.0, 4.0))
    assert robust.mean() < 1.05 * plain.mean()


def test_an_image_that_shows_half_a_marker_counts_less_and_says_so():
    """With three cameras no residual tells which is wrong, but the area does."""
    rig, points = ring(6).select(["c0", "c2", "c4"]), np.repeat([[[0.0, 0, 900]]], 200, 1)
    blind, blind_squared = errors(spoiled(rig, points, 0.8), rig, points, degrees_of_freedom=0.0)
    seeing, squared = errors(spoiled(rig, points, 0.8, area=0.5), rig, points, degrees_of_freedom=0.0)
    assert np.median(seeing) < 0.5 * np.median(blind)
    assert (blind_squared < 7.8).mean() < 0.5
    assert (squared < 7.8).mean() > 0.9


def test_whole_images_of_one_marker_are_believed():
    rig, points = ring(4), np.repeat([[[0.0, 0, 900]]], 50, 1)
    with_area, without = (errors(spoiled(rig, points, 0.0, area=a), rig, points)[1] for a in (1.0, None))
    assert np.allclose(with_area, without, rtol=1e-6)


def test_a_ghost_that_shares_an_image_starts_no_track():
    """Two markers and the ghost of their crossed rays; the ghost would live as long as they do."""
    xyz = np.array([[0.0, 0, 900], [300, 0, 900], [150, 80, 900]])
    views = np.array([[0, 3, 6], [1, 4, 7], [0, 4, -1]])
    frames = 30
    cloud = Cloud(
        100.0,
        np.arange(frames + 1) * 3,
        np.tile(xyz, (frames, 1)),
        np.tile(0.01 * np.eye(3), (3 * frames, 1, 1)),
        np.zeros(3 * frames),
        np.concatenate([np.where(views >= 0, views + 8 * f, -1) for f in range(frames)]),
    )
    late = cloud.keep(~((cloud.frame == 0) & (np.arange(len(cloud)) % 3 == 2)))  # the markers are there first
    tracks = track(late)
    assert len(tracks) == 2
    assert tracks.lengths.tolist() == [frames, frames]


def test_a_track_does_not_take_a_ghost_of_an_older_one():
    """While marker B is hidden, a ghost beside its prediction shares an image with A, which is older."""
    frames, hidden = 30, range(15, 18)
    rows, views, counts = [], [], []
    for f in range(frames):
        here = [[0.0, 0, 900]] if f < 3 else [[0.0, 0, 900], [40.0, 0, 900]]  # A is there first
        images = [[2 * f, 100 + 2 * f], [2 * f + 1, 101 + 2 * f]][: len(here)]
        if f in hidden:
            here[1], images[1] = [41.0, 0, 900], [2 * f, 101 + 2 * f]
        rows += here
        views += images
        counts.append(len(here))
    n = len(rows)
    start = np.concatenate([[0], np.cumsum(counts)])
    cov = np.tile(0.01 * np.eye(3), (n, 1, 1))
    tracks = track(Cloud(100.0, start, np.array(rows), cov, np.zeros(n), np.array(views)))
    assert tracks.lengths.tolist() == [frames, frames - 3 - len(hidden)]


@pytest.mark.parametrize("rate", [50.0, 100.0, 250.0])
def test_patience_is_a_time_whatever_the_rate(rate):
    points = np.repeat([[[0.0, 0, 900]]], round(rate), 1)
    for seconds, pieces in ((0.02, 1), (0.08, 2)):
        hide = np.zeros(points.shape[:2], bool)
        hide[0, 20 : 20 + round(seconds * rate)] = True
        assert len(tracked(points, rate=rate, hide=hide)) == pieces


def test_pairs_are_taken_within_their_band_only():
    """Two cameras whose images of one point are 1.5 px off their epipolar lines."""
    rig = ring(6).select(["c0", "c2"])
    detections, _ = observe(rig, np.array([[[0.0, 0, 900]]]))
    uv = detections.uv.copy()
    uv[1, 1] += 1.5
    off = replace(detections, uv=uv)
    assert len(match(off, rig, method=EpipolarTriplets(pair_band=1.0))) == 0
    assert len(match(off, rig, method=EpipolarTriplets(pair_band=2.0))) == 1


def test_blocks_of_frames_do_not_change_the_matches(monkeypatch):
    rig, points = ring(4), swarm(n=6, frames=20)
    detections, _ = observe(rig, points, noise=0.1)
    whole = match(detections, rig)
    monkeypatch.setattr(sys.modules["kinemark.match.epipolar_triplets"], "BLOCK", 7)
    assert same(match(detections, rig), whole)


def test_frames_full_of_noise_are_refused_before_memory_is():
    rig = ring(2)
    uv = np.random.default_rng(0).uniform(0, 1000, (2400, 2))
    with pytest.raises(KinemarkError, match="1200 points in frame 0"):
        match(Detections.build(rig.names, 100.0, [[1200], [1200]], uv), rig)


def test_camera_bits_and_residuals_of_paths_are_those_of_their_points():
    rig, points = ring(5), swarm(n=1, frames=20)
    detections, _ = observe(rig, points, noise=0.1)
    without = detections.keep(detections.camera != 1)
    cloud = reconstruct(match(without, rig), without, rig)
    (path,) = to_trajectories(track(cloud), rig)
    assert (path.cameras == 0b11101).all()
    span = np.mean([np.linalg.norm(c.centre - [0, 0, 900]) / c.K[0, 0] for c in rig])  # mm a pixel, about
    assert np.allclose(path.residual / cloud.residual, span, rtol=0.3)
    assert (path.cov == cloud.cov).all()


@pytest.mark.parametrize(
    ("method", "wrong"),
    [
        (ExtrapolationLadder, {"gate": 0.0}),
        (ExtrapolationLadder, {"scatter": float("nan")}),
        (ExtrapolationLadder, {"max_coasting": 1e300}),
        (ExtrapolationLadder, {"min_points": 0}),
        (EpipolarTriplets, {"search_radius": -1.0}),
        (EpipolarTriplets, {"candidates": 0}),
        (LeastSquares, {"degrees_of_freedom": -2.0}),
        (LeastSquares, {"centroid_sd": 0.0}),
        (LeastSquares, {"model_sd": float("nan")}),
    ],
)
def test_parameters_that_mean_nothing_are_refused(method, wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        method(**wrong)
