"""The tracking and the matching of Swamidas (1997) follow their own laws, on scenes whose truth is known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark.data import Detections, KinemarkError, Rig, Validity, same
from kinemark.match.nearest_epipolar import NearestEpipolar, match_nearest, nearest_pairs
from kinemark.synth import circle_over_cylinder, elbow_flexion, tilted_rectangle
from kinemark.track.swamidas import (
    Constraint,
    DistanceOnly,
    KalmanState,
    Swamidas,
    follow_points,
    initial_state,
    predict,
    track_distance,
    track_swamidas,
    update,
)
from kinemark.track.swamidas.constraints import PredictedPoints, half_size, match_points
from kinemark.track.swamidas.distance_only import shortest_first
from kinemark.track.swamidas.learning import learn_error
from kinemark.track.swamidas.reversal import reversed_cloud, reversed_rows
from kinemark.track.swamidas.segments import LearnedSegments, allowed_points, learn_segments
from support.clouds import cloud_and_markers as cloud_of
from support.examples import examples
from support.laboratory import observe, ring
from support.motions import parabolas, swarm

SD, JUMP = 2.0, 0.5


def three_points(xyz, k):
    """(n, 3, 3) positions at frames k, k − 1, k − 2 of paths (n, F, 3)."""
    return xyz[:, [k, k - 1, k - 2]]


def test_the_predictor_is_exact_for_constant_acceleration_and_over_gaps():
    xyz = parabolas()
    state = initial_state(three_points(xyz, 2), SD, JUMP)
    for k in range(3, 20):
        np.testing.assert_allclose(state.x[:, 0], xyz[:, k], atol=1e-8)
        state = update(state, three_points(xyz, k), np.ones(len(xyz), bool), SD, JUMP)
    for k in range(20, 40):
        np.testing.assert_allclose(state.x[:, 0], xyz[:, k], atol=1e-7)
        state = predict(state, JUMP)


def textbook(positions, seen, T, sd, jerk):
    """Predicted positions and covariances of one coordinate: a filter in mm and seconds, in two steps, after Joseph."""
    F = np.array([[1, T, T * T / 2], [0, 1, T], [0, 0, 1]])
    H = np.array([[1, 0, 0], [3 / (2 * T), -2 / T, 1 / (2 * T)], [1 / T**2, -2 / T**2, 1 / T**2]])
    Q = np.diag([0.0, 0.0, (jerk * T) ** 2])
    x, P = H @ positions[2::-1], sd**2 * H @ H.T
    found = []
    for k in range(3, len(positions)):
        x, P = F @ x, F @ P @ F.T + Q
        found.append((x[0], P[0, 0]))
        if not seen[k]:
            continue
        C = np.eye(3) if seen[k - 2 : k + 1].all() else np.eye(3)[:1]
        R = np.diag([sd**2, 6.5 * (sd / T) ** 2, 6 * (sd / T**2) ** 2])[: len(C), : len(C)]
        K = np.linalg.solve(C @ P @ C.T + R, C @ P).T
        x = x + K @ ((H @ positions[k - 2 : k + 1][::-1])[: len(C)] - C @ x)
        L = np.eye(3) - K @ C
        P = L @ P @ L.T + K @ R @ K.T
    return np.array(found)


def test_the_predictor_is_a_textbook_filter_written_otherwise():
    rate, sd, jerk = 30.0, 1.5, 9000.0
    rng = np.random.default_rng(1)
    xyz = np.cumsum(rng.normal(0, 1, (1, 60, 3)), 1) + rng.normal(0, sd, (1, 60, 3))
    seen = np.ones(60, bool)
    seen[[20, 21, 22, 40, 42]] = False
    state = initial_state(three_points(xyz, 2), sd, jerk / rate**3)
    found = []
    for k in range(3, 60):
        found.append((state.x[0, 0], state.P[0, 0, 0]))
        past, whole = three_points(xyz, k), seen[k - 2 : k + 1].all(keepdims=True)
        state = update(state, past, whole, sd, jerk / rate**3) if seen[k] else predict(state, jerk / rate**3)
    for c in range(3):
        expected = textbook(xyz[0, :, c], seen, 1 / rate, sd, jerk)
        np.testing.assert_allclose([x[c] for x, _ in found], expected[:, 0], rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose([P for _, P in found], expected[:, 1], rtol=1e-7)


@settings(max_examples=examples(30), deadline=None)
@given(st.lists(st.sampled_from([0, 1, 3]), max_size=60), st.floats(0.01, 20), st.floats(1e-3, 50))
def test_covariances_stay_symmetric_and_positive(steps, sd, process_sd):
    rng = np.random.default_rng(0)
    state = initial_state(rng.normal(size=(2, 3, 3)), sd, process_sd)
    for step in steps:
        past = rng.normal(size=(2, 3, 3))
        state = update(state, past, np.full(2, step == 3), sd, process_sd) if step else predict(state, process_sd)
        np.testing.assert_array_equal(state.P, state.P.transpose(0, 2, 1))
        root = np.sqrt(np.diagonal(state.P, axis1=1, axis2=2))
        assert (np.linalg.eigvalsh(state.P / (root[:, :, None] * root[:, None])) > 0).all()


def test_the_first_covariance_is_that_of_many_starts():
    rng = np.random.default_rng(2)
    state = initial_state(rng.normal(0, SD, (20000, 3, 3)), SD, 0.0)
    found = np.cov(state.x.transpose(1, 0, 2).reshape(3, -1))
    np.testing.assert_allclose(found, state.P[0], rtol=0.03)


def test_a_gap_widens_the_covariance():
    state = initial_state(np.zeros((1, 3, 3)), SD, JUMP)
    size = []
    for _ in range(30):
        size.append(state.P[0, 0, 0])
        state = predict(state, JUMP)
    assert (np.diff(size) > 0).all()


def test_regions_grow_with_time_error_and_velocity():
    one = np.ones((1, 3))
    size = [half_size(np.array([n]), np.full(3, e), v * one, p) for n, e, v, p in [(1, 2, 5, 0.2), (2, 2, 5, 0.2)]]
    np.testing.assert_allclose(size[1], 2 * size[0])
    np.testing.assert_allclose(size[0], 3.0)
    assert (half_size(np.array([1]), np.full(3, 2.0), 9 * one, 0.2) > size[0]).all()
    np.testing.assert_array_equal(
        half_size(np.array([3]), one[0], -4 * one, 0.1), half_size(np.array([3]), one[0], 4 * one, 0.1)
    )
    fast, slow = (follow_points(cloud_of(np.arange(20)[None, :, None] * [[[v, 0, 0]]] * 1.0)[0]) for v in (40.0, 4.0))
    assert fast.expected[10].half[0, 0] > slow.expected[10].half[0, 0] == pytest.approx(2.54 + 0.2 * 4, abs=1e-6)


def expected(xyz, half=1.0, velocity=0.0, last=None, steps=1):
    xyz = np.array(xyz, float)
    whole = np.zeros_like(xyz)
    last = xyz - velocity if last is None else np.array(last, float)
    half = np.broadcast_to(np.array(half, float).reshape(-1, 1), xyz.shape)
    return PredictedPoints(xyz, half, whole + velocity, last, np.full(len(xyz), steps))


def matched(e, points):
    taken, by = match_points(e, np.array(points, float).reshape(-1, 3), np.ones((len(e.xyz), len(points)), bool))
    return taken.tolist(), [Constraint(b).name for b in by]


def test_the_constraints_come_in_their_order():
    e = expected([[0, 0, 0], [100, 0, 0]])
    assert matched(e, [[100.5, 0, 0], [0.5, 0, 0]]) == ([1, 0], ["REGION", "REGION"])
    assert matched(e, [[130, 0, 0], [0.5, 0, 0]]) == ([1, 0], ["REGION", "DISTANCE"])
    assert matched(e, [[0.4, 0, 0], [-0.3, 0, 0]])[0] == [1, 0]
    assert matched(e, [[0.4, 0, 0], [-0.3, 0, 0], [99.5, 0, 0]])[0] == [1, 2]
    assert matched(e, []) == ([-1, -1], ["NONE", "NONE"])
    far = expected([[0, 0, 0], [10, 0, 0]], last=[[-40, 0, 0], [-3, 0, 0]])
    assert matched(far, [[12, 0, 0], [15, 0, 0]]) == ([1, 0], ["VELOCITY", "DISTANCE"])
    crowded = expected([[0, 0, 0], [10, 0, 0], [20, 0, 0]], half=0.01)
    assert matched(crowded, [[1, 0, 0], [2, 0, 0], [3, 0, 0]]) == ([0, 2, 1], ["DISTANCE", "VELOCITY", "ELIMINATION"])


def test_a_region_that_reaches_a_neighbour_takes_it_and_one_with_two_waits():
    e = expected([[0, 0, 0], [100, 0, 0]], half=[150.0, 1.0])
    assert matched(e, [[100.0, 0, 0]])[0] == [0, -1]
    assert matched(e, [[100.0, 0, 0], [60, 0, 0]]) == ([1, 0], ["DISTANCE", "REGION"])


@settings(max_examples=examples(50), deadline=None)
@given(st.integers(0, 6), st.integers(0, 6), st.integers(0, 10_000))
def test_no_point_serves_two_tracks_and_the_order_of_points_is_nothing(n_tracks, n_points, seed):
    rng = np.random.default_rng(seed)
    e = expected(rng.normal(0, 20, (n_tracks, 3)), half=rng.uniform(1, 30, n_tracks), velocity=1.0)
    points = rng.normal(0, 20, (n_points, 3))
    allowed = rng.random((n_tracks, n_points)) < 0.9
    taken, by = match_points(e, points, allowed)
    used = taken[taken >= 0]
    assert len(set(used.tolist())) == len(used)
    assert allowed[np.flatnonzero(taken >= 0), used].all()
    assert ((by > 0) == (taken >= 0)).all()
    turn = rng.permutation(n_points)
    again, why = match_points(e, points[turn], allowed[:, turn])
    np.testing.assert_array_equal(np.where(again >= 0, turn[again] if n_points else -1, -1), taken)
    np.testing.assert_array_equal(why, by)


@pytest.mark.parametrize("follow", [track_swamidas, track_distance])
def test_a_swarm_is_followed_in_any_order_of_its_points(follow):
    xyz = swarm(n=8, frames=60)
    rng = np.random.default_rng(3)
    tracks = [follow(cloud_of(xyz, rate=100.0)[0])]
    cloud, marker = cloud_of(xyz, rate=100.0, order=lambda f, own: rng.permutation(own) if f else own)
    np.testing.assert_array_equal(tracks[0].id, cloud_of(xyz)[1])
    np.testing.assert_array_equal(follow(cloud).id, marker)


def crossing(frames=80):
    """Two markers 100 mm apart that swing in 2.5 s, and one at rest, at 30 Hz; (3, F, 3) mm."""
    t = np.arange(frames)[:, None] / 30
    swing = 150 * np.sin(2 * np.pi * t / 2.5) * np.array([1.0, 0.3, 0.0])
    still = np.broadcast_to([0, 150.0, 0], (frames, 3))
    return np.array([swing, swing + np.array([100.0, 0, 0]), still])


def test_identities_go_on_over_a_gap_by_prediction():
    xyz = crossing()
    seen = np.ones(xyz.shape[:2], bool)
    seen[0, 30:38] = False
    cloud, marker = cloud_of(xyz, seen)
    followed = follow_points(cloud)
    np.testing.assert_array_equal(followed.tracks.id, marker)
    path = followed.path(0)
    assert np.isnan(path[0]).sum() == 0
    np.testing.assert_array_equal(path[seen[0]], xyz[0, seen[0]])
    assert 0 < np.abs(path[30:38] - xyz[0, 30:38]).max() < 60
    assert np.abs(xyz[0, 37] - xyz[0, 29]).max() > 60


def test_the_distance_alone_fails_where_a_neighbour_comes_by():
    """The document: markers close to each other and fast, and any with two missing (4.2.4)."""
    xyz = crossing()
    seen = np.ones(xyz.shape[:2], bool)
    seen[:2, 30:40] = False  # in the meantime the second comes to where the first was last seen
    cloud, marker = cloud_of(xyz, seen)
    assert np.linalg.norm(xyz[1, 40] - xyz[0, 29]) < np.linalg.norm(xyz[0, 40] - xyz[0, 29])
    assert (track_distance(cloud).id != marker).any()
    np.testing.assert_array_equal(track_swamidas(cloud).id, marker)
    slow = crossing() * [0.1, 1, 1] + np.array([0, 200, 0])[:, None, None] * [0, 1, 0]
    cloud, marker = cloud_of(slow, seen)
    np.testing.assert_array_equal(track_distance(cloud).id, marker)


def test_the_distance_takes_the_shortest_first():
    rows, columns = shortest_first(np.array([[3.0, 1.0], [2.0, 0.5], [9.0, 9.0]]))
    assert (rows.tolist(), columns.tolist()) == ([1, 0], [1, 0])
    assert shortest_first(np.zeros((0, 4)))[0].size == 0


@pytest.mark.parametrize(
    ("follow", "method"), [(track_swamidas, Swamidas), (track_distance, DistanceOnly)], ids=["kalman", "distance"]
)
def test_new_tracks_begin_and_old_ones_end_where_that_is_wanted(follow, method):
    xyz = crossing()
    seen = np.ones(xyz.shape[:2], bool)
    seen[2, :10] = False
    seen[0, 20:] = False
    cloud, marker = cloud_of(xyz, seen)
    tracks = follow(cloud, method=method(initiate_from="any", max_coasting=0.2))
    np.testing.assert_array_equal(tracks.id, marker)
    first = follow(cloud, method=method())
    assert len(first) == 2
    assert (first.id[(marker == 2) & (cloud.frame < 20)] == -1).all()  # discarded while no track is free
    empty, _ = cloud_of(xyz, np.zeros_like(seen))
    assert len(follow(empty, method=method())) == 0


def test_the_error_is_learned_from_the_first_frames():
    rng = np.random.default_rng(4)
    paths = parabolas(200, 12) + rng.normal(0, [0.5, 1.0, 2.0], (200, 12, 3))
    np.testing.assert_allclose(learn_error(paths, np.full(3, 9.0)), [0.5, 1.0, 2.0], rtol=0.08)
    np.testing.assert_array_equal(learn_error(paths[:, :3], np.full(3, 9.0)), 9.0)
    noisy = np.tile(parabolas(30, 30), 1) + rng.normal(0, 0.2, (30, 30, 3))
    cloud, _ = cloud_of(noisy)
    half = follow_points(cloud, method=Swamidas(measurement_sd=None, velocity_share=0.0)).expected[15].half
    np.testing.assert_allclose(half, 0.2, rtol=0.4)


def test_segments_are_learned_and_refuse_what_does_not_fit():
    xyz = crossing()
    found = learn_segments(xyz[:, :10], tolerance=0.05)
    assert (found.link.tolist(), found.length.tolist()) == ([[0, 1]], pytest.approx([100.0]))
    given = learn_segments(xyz[:, :10], tolerance=0.05, links=((0, 2), (1, 9)))
    assert given.link.tolist() == [[0, 2]]
    pair = LearnedSegments(np.array([[0, 1]]), np.array([100.0]))
    points = np.array([[0.0, 0, 0], [102, 0, 0], [120, 0, 0]])
    allowed = allowed_points(points, np.array([[1.0, 0, 0], [60, 0, 0]]), np.array([True, False]), pair, 0.05)
    assert allowed.tolist() == [[True, True, True], [False, True, False]]
    greedy = Swamidas(measurement_sd=12.0, learning_time=0.9)
    fit = replace(greedy, segment_tolerance=0.05)
    seen = np.ones(xyz.shape[:2], bool)
    seen[0, 30:60] = False  # its region grows over the other one
    cloud, marker = cloud_of(xyz, seen)
    assert (track_swamidas(cloud, method=greedy).id != marker).any()
    for method in (fit, replace(fit, links=((0, 1),)), replace(fit, links=((1, 0),), lengths=(100.0,))):
        np.testing.assert_array_equal(track_swamidas(cloud, method=method).id, marker)


@pytest.mark.parametrize(
    "wrong",
    [
        {"measurement_sd": 0.0},
        {"jerk": -1.0},
        {"velocity_share": -0.1},
        {"max_coasting": 0.0},
        {"links": ((1, 1),)},
        {"links": ((0, 1),), "lengths": (1.0, 2.0)},
        {"links": ((0, 1),), "lengths": (-1.0,)},
    ],
)
def test_parameters_are_checked(wrong):
    with pytest.raises(ValueError, match="wanted"):
        Swamidas(**wrong)


def test_a_state_is_plain_data():
    state = initial_state(three_points(parabolas(), 2), SD, JUMP)
    assert same(tuple(KalmanState(*state)), tuple(state))


# Matching of two cameras


def truth_of(matches, marker):
    return [tuple(marker[detection[detection >= 0]]) for detection in matches.detection]


def test_two_cameras_match_all_markers_without_noise():
    rig, xyz = ring(2), swarm(n=6, frames=20)
    detections, marker = observe(rig, xyz, noise=0.0)
    matches = match_nearest(detections, rig)
    assert len(matches) == 6 * 20
    assert all(a == b for a, b in truth_of(matches, marker))
    assert matches.cost.max() < 1e-6
    other, marker = observe(rig, xyz, noise=0.0, seed=5)
    assert sorted(truth_of(match_nearest(other, rig), marker)) == sorted([(m, m) for m in range(6) for _ in range(20)])


def test_unequal_numbers_never_pair_twice_and_the_rest_is_left():
    rig, xyz = ring(2), swarm(n=6, frames=30)
    detections, marker = observe(rig, xyz, noise=0.0)
    gone = (detections.camera == detections.frame % 2) & (marker == detections.frame % 6)
    some = detections.keep(~gone)
    matches = match_nearest(some, rig)
    assert len(matches) == 5 * 30
    assert all(a == b for a, b in truth_of(matches, marker[~gone]))
    used = matches.detection[matches.detection >= 0]
    assert len(np.unique(used)) == len(used)


@settings(max_examples=examples(60), deadline=None)
@given(st.integers(0, 7), st.integers(0, 7), st.integers(0, 10_000))
def test_pairs_are_those_of_rising_cost(n, m, seed):
    rng = np.random.default_rng(seed)
    cost = rng.random((n, m))
    cost[rng.random((n, m)) < 0.2] = np.inf
    rows, columns = nearest_pairs(cost.copy())
    left, wanted = cost.copy(), []
    while left.size and np.isfinite(left.min()):
        i, j = np.unravel_index(left.argmin(), left.shape)
        wanted.append((i, j))
        left[i], left[:, j] = np.inf, np.inf
    assert list(zip(rows, columns, strict=True)) == sorted(wanted)


def test_a_pair_is_named_among_more_cameras_and_the_base_may_be_either():
    rig, xyz = ring(4), swarm(n=5, frames=6)
    detections, marker = observe(rig, xyz, noise=0.0)
    matches = match_nearest(detections, rig, method=NearestEpipolar(cameras=("c3", "c1")))
    assert (matches.detection[:, [0, 2]] == -1).all()
    assert (matches.detection[:, [1, 3]] >= 0).all()
    assert all(a == b for a, b in truth_of(matches, marker))
    assert (detections.camera[matches.detection[:, 1]] == 1).all()
    assert (detections.frame[matches.detection[:, 3]] == matches.frame).all()
    with pytest.raises(KinemarkError, match="Name two of them"):
        match_nearest(detections, rig)
    with pytest.raises(KinemarkError, match="not among"):
        match_nearest(detections, rig, method=NearestEpipolar(cameras=("c1", "c9")))
    with pytest.raises(KinemarkError, match="same cameras"):
        match_nearest(detections, Rig(rig.cameras[::-1]))
    with pytest.raises(ValueError, match="two different"):
        NearestEpipolar(cameras=("c1", "c1"))


def test_the_band_and_validity_keep_points_out():
    rig, xyz = ring(2), swarm(n=4, frames=10)
    detections, _ = observe(rig, xyz, noise=3.0)
    assert len(match_nearest(detections, rig)) == 40
    near = match_nearest(detections, rig, method=NearestEpipolar(search_band=1.0))
    assert 0 < len(near) < 40
    assert near.cost.max() < 1.0
    none = replace(detections, validity=np.full(len(detections), Validity.TOO_SMALL, np.uint8))
    assert len(match_nearest(none, rig)) == 0
    with pytest.raises(ValueError, match="band"):
        NearestEpipolar(search_band=0.0)
    many = Detections.build(rig.names, 50.0, [[1], [1001]], np.zeros((1002, 2)))
    with pytest.raises(KinemarkError, match=r"c1 has 1001 points in frame 0, wanted at most 1000"):
        match_nearest(many, rig)


def arm(number=1, *, hide, seconds=6.0):
    """A motion of the arm with markers hidden: frames by marker; the cloud, and the marker of each point."""
    motion = {1: circle_over_cylinder, 2: tilted_rectangle, 3: elbow_flexion}[number]
    subject = motion(duration_s=seconds, seed=4)
    seen = np.ones(subject.xyz.shape[:2], bool)
    for marker, frames in hide.items():
        seen[marker, frames] = False
    return *cloud_of(subject.xyz, seen, rate=subject.rate), subject.xyz


def test_backwards_it_does_what_it_does_forwards_to_the_recording_reversed():
    cloud, _, _ = arm(hide={0: slice(40, 60), 1: slice(90, 100)})
    back = follow_points(cloud, method=Swamidas(direction="backward"))
    turned = reversed_cloud(cloud)
    forward = follow_points(turned, method=Swamidas())
    rows = reversed_rows(cloud)
    pairs = {(int(a), int(b)) for a, b in zip(back.tracks.id[rows], forward.tracks.id, strict=True)}
    assert len(pairs) == len({a for a, _ in pairs}) == 3  # the same but for the numbers
    np.testing.assert_array_equal(cloud.xyz, reversed_cloud(turned).xyz)
    own = dict(pairs)
    for k in range(3):
        np.testing.assert_allclose(back.path(k), forward.path(own[k])[::-1])


def test_the_thesis_predictor_is_wrong_after_a_second_where_predictions_that_meet_are_right():
    """Hand and elbow of the first motion hidden at once: forwards they are exchanged, by both ends they are not."""
    cloud, marker, _ = arm(hide={0: slice(60, 100), 1: slice(60, 100)})
    forward = follow_points(cloud, method=Swamidas())
    meeting = follow_points(cloud, method=Swamidas(direction="meeting"))
    assert (forward.tracks.id != marker).any()
    np.testing.assert_array_equal(meeting.tracks.id, marker)
    assert (meeting.by == Constraint.MEETING).sum() == 2


def test_predictions_that_meet_are_of_half_the_gap():
    cloud, marker, xyz = arm(hide={0: slice(60, 90)})
    off = {}
    for direction in ("forward", "backward", "meeting"):
        found = follow_points(cloud, method=Swamidas(direction=direction))
        np.testing.assert_array_equal(found.tracks.id, marker)
        off[direction] = np.linalg.norm(found.path(0) - xyz[0], axis=1)
    # Each to the middle of the gap is what it is alone, and there are no later frames of it.
    np.testing.assert_allclose(off["meeting"][60:75], off["forward"][60:75], rtol=1e-6)
    np.testing.assert_allclose(off["meeting"][76:90], off["backward"][76:90], rtol=1e-6)
    assert off["meeting"].max() < min(off["forward"].max(), off["backward"].max()) / 4
    assert not np.isnan(off["meeting"]).any()


def test_the_longest_gap_that_is_joined_is_said_and_late_beginnings_count_only_where_asked():
    cloud, marker, _ = arm(hide={0: slice(60, 75), 1: slice(0, 30)})
    found = follow_points(cloud, method=Swamidas(direction="meeting"))
    assert set(found.tracks.id[marker == 1]) == {-1} and len(set(found.tracks.id[marker == 0])) == 1
    found = follow_points(cloud, method=Swamidas(direction="meeting", max_coasting=0.3, initiate_from="any"))
    assert len(set(found.tracks.id[marker == 0])) == 2 and len(set(found.tracks.id[marker == 1])) == 1
