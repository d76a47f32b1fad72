"""Laws of the tracker that matches and tracks at once, and of its parts."""

import sys
from itertools import permutations

import numpy as np
import pytest

from kinemark.data import Detections, KinemarkError, Rig
from kinemark.geometry import project
from kinemark.native import inverse
from kinemark.synth import observe as seen_by
from kinemark.synth import ring as synth_ring
from kinemark.synth import walking, with_markers
from kinemark.synth.score import score
from kinemark.track.simultaneous import Simultaneous, track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.associate import associate, predict_images
from kinemark.track.simultaneous.following.candidate_points import batches, fundamentals, intersect, near_lines
from kinemark.track.simultaneous.following.kalman_states import (
    KalmanStates,
    back,
    initial_states,
    predict,
    reversed_time,
    update,
)
from kinemark.track.simultaneous.points.neighbouring_points import (
    LOOK,
    RowsByTrack,
    TrackPoints,
    motion_from,
    rows_near,
    smoothed,
)
from support.laboratory import observe, ring
from support.motions import dance


def partition(tracks, *, digits=6):
    """A set of tracks, each a set of its points, so that numbering and order play no part."""
    keys = [
        (int(f), *map(float, np.round(x, digits) + 0.0))
        for f, x in zip(tracks.cloud.frame, tracks.cloud.xyz, strict=True)
    ]
    return {frozenset(keys[p] for p in np.flatnonzero(tracks.id == i)) for i in range(len(tracks))}


def shuffled(detections, seed=0):
    """The same detections, in another order within each camera and frame."""
    rng = np.random.default_rng(seed)
    order = np.lexsort([rng.random(len(detections)), detections.frame, detections.camera])
    return Detections.build(
        detections.cameras, detections.rate, detections.counts, detections.uv[order], detections.cov[order]
    )


def test_finds_all_points_of_a_dance():
    xyz = dance()
    detections, _ = observe(ring(5), xyz, noise=0.1)
    result = score(track_detections(detections, ring(5)), xyz)
    assert result.recall == 1 and result.extra_per_frame == 0 and result.swaps == 0
    assert (result.fragments == 1).all() and 0.92 < result.coverage < 0.98


def test_order_of_detections_does_not_matter():
    rig = ring(5)
    detections, _ = observe(rig, dance(), noise=0.1)
    assert partition(track_detections(detections, rig)) == partition(track_detections(shuffled(detections), rig))


def test_order_of_cameras_does_not_matter():
    rig = ring(6)
    xyz = dance()
    detections, _ = observe(rig, xyz, noise=0.1)
    names = [rig.names[i] for i in (3, 0, 5, 1, 4, 2)]
    one, other = track_detections(detections, rig), track_detections(detections.select(names), rig.select(names))
    assert len(one) == len(other) == len(xyz)
    assert partition(one, digits=2) == partition(other, digits=2)


def test_time_reversed_gives_the_same_tracks():
    rig, xyz = ring(5), dance(frames=50)
    forward, _ = observe(rig, xyz, noise=0.1)
    last = forward.n_frames - 1
    order = np.concatenate(
        [np.arange(forward.start[c, f], forward.start[c, f + 1]) for c in range(len(rig)) for f in range(last, -1, -1)]
    )
    backward = Detections.build(rig.names, 100.0, forward.counts[:, ::-1], forward.uv[order], forward.cov[order])
    one, other = track_detections(forward, rig), track_detections(backward, rig)
    turned = {frozenset((last - f, *x) for f, *x in track) for track in partition(other, digits=1)}
    both = partition(one, digits=1)
    assert len(both) == len(turned)
    for track in both:  # rounding at .05 mm may differ
        assert max(len(track & twin) for twin in turned) > 0.95 * len(track)


def test_runs_of_any_length_and_nothing_at_all():
    rig = ring(4)
    for frames in (1, 2, 3, 5):
        detections, _ = observe(rig, dance(frames=frames), noise=0.1)
        assert len(track_detections(detections, rig)) in (0, 8)
    assert len(track_detections(detections.keep(np.zeros(len(detections), bool)), rig)) == 0
    assert len(track_detections(detections.frames(0, 0), rig)) == 0
    one = rig.select(rig.names[:1])
    with pytest.raises(KinemarkError, match="needs two"):
        track_detections(detections.select(one.names), one)
    with pytest.raises(KinemarkError, match="same order"):
        track_detections(detections, Rig(rig.cameras[::-1]))


def test_stretches_side_by_side_are_one_track():
    xyz = dance(frames=260)
    detections, _ = observe(ring(4), xyz, noise=0.1)
    result = score(track_detections(detections, ring(4)), xyz)
    assert result.recall == 1 and (result.fragments == 1).all() and result.swaps == 0


@pytest.mark.parametrize("per_frame", [10, 25])
def test_noise_alone_makes_no_tracks(per_frame):
    rig, rng = ring(6), np.random.default_rng(3)
    counts = rng.poisson(per_frame, (len(rig), 60))
    uv = rng.uniform(0, 1, (counts.sum(), 2)) * rig[0].size
    detections = Detections.build(rig.names, 100.0, counts, uv, np.broadcast_to(np.eye(2) * 0.01, (len(uv), 2, 2)))
    assert len(track_detections(detections, rig)) == 0


def test_a_stretch_of_one_camera_is_bridged():
    rig, xyz = ring(4), dance(n=5, frames=60)
    detections, truth = observe(rig, xyz, noise=0.1)
    hidden = (truth == 2) & (detections.frame >= 28) & (detections.frame < 34) & (detections.camera > 0)
    tracks = track_detections(detections.keep(~hidden), rig)
    result = score(tracks, xyz)
    assert len(tracks) == 5 and result.swaps == 0 and (result.fragments == 1).all()
    at = tracks.cloud.frame[tracks.id == tracks.id[np.flatnonzero(result.owner == 2)[0]]]
    assert not np.isin(np.arange(28, 34), at).any()  # no point is given of one image


def test_a_merged_image_serves_two_tracks():
    rig, frames = ring(5), 70
    x = np.linspace(-200, 200, frames)
    z = np.full(frames, 1000.0)
    xyz = np.stack([np.column_stack([x, 0 * x, z]), np.column_stack([-x, 0 * x + 60, z + 3])])
    detections, truth = observe(rig, xyz, noise=0.05)
    merged, drop, uv, area = (
        np.zeros(len(truth), bool),
        np.zeros(len(truth), bool),
        detections.uv.copy(),
        np.full(len(truth), 60.0),
    )
    for c in range(len(rig)):
        for f in range(frames):
            rows = np.arange(detections.start[c, f], detections.start[c, f + 1])
            if len(rows) == 2 and np.linalg.norm(uv[rows[0]] - uv[rows[1]]) < 9:
                uv[rows[0]], merged[rows[0]], drop[rows[1]], area[rows[0]] = uv[rows].mean(0), True, True, 130.0
    assert drop.sum() > 10
    seen = Detections.build(rig.names, 100.0, detections.counts, uv, detections.cov, merged=merged, area=area).keep(
        ~drop
    )
    tracks = track_detections(seen, rig)
    result = score(tracks, xyz)
    assert len(tracks) == 2 and result.swaps == 0 and result.recall > 0.99
    shared = tracks.cloud.detection[seen.merged[tracks.cloud.detection] & (tracks.cloud.detection >= 0)]
    assert np.bincount(shared).max() == 2


def test_a_body_that_hides_its_markers():
    subject = with_markers(walking(duration_s=0.7, rate=100.0, seed=1, middle=(1200.0, 700.0)), 39, seed=1)
    rig = synth_ring(6)
    seen = seen_by(rig, subject, noise_px=0.1, false_per_frame=2.0, merge_px=8.0, least_visible=0.3, seed=1)
    tracks = track_detections(seen.detections, rig)
    truth = subject.xyz.copy()
    own = (seen.marker >= 0) & (seen.merged == 1)
    views = np.zeros(truth.shape[:2], int)
    np.add.at(views, (seen.marker[own], seen.detections.frame[own]), 1)
    everywhere = score(tracks, truth)
    truth[views < 2] = np.nan
    result = score(tracks, truth)
    assert result.recall > 0.99 and everywhere.extra_per_frame < 0.02 and result.swaps == 0
    assert result.fragments.mean() < 1.2 and 0.92 < result.coverage < 0.98


def textbook(x, V, T, q, z, R):
    """Predict and update by the Kalman filter as every book has it, for one point; all three orders in one block."""
    A = np.kron(np.array([[1, T, T**2 / 2], [0, 1, T], [0, 0, 1]]), np.eye(3))
    G = np.array([[T**5 / 20, T**4 / 8, T**3 / 6], [T**4 / 8, T**3 / 3, T**2 / 2], [T**3 / 6, T**2 / 2, T]])
    x, V = A @ x, A @ V @ A.T + q**2 * np.kron(G, np.eye(3))
    H = np.eye(3, 9)
    K = V @ H.T @ np.linalg.inv(H @ V @ H.T + R)
    return x + K @ (z - H @ x), (np.eye(9) - K @ H) @ V


def test_the_filter_is_the_textbooks():
    rng = np.random.default_rng(0)
    n, T, q = 5, 0.01, 4e4
    M = rng.normal(size=(n, 3, 3))
    motion = initial_states(
        rng.normal(size=(3, n)) * 100,
        (M @ M.swapaxes(1, 2) + np.eye(3)).transpose(1, 2, 0),
        speed=1500.0,
        acceleration=1.5e4,
    )
    plain = [(motion.x[:, t], motion.V[..., t]) for t in range(n)]
    for _ in range(4):
        z, M = rng.normal(size=(n, 3)) * 100, rng.normal(size=(n, 3, 3))
        R = M @ M.swapaxes(1, 2) + np.eye(3)
        motion = predict(motion, T, q)
        N = inverse(R.transpose(1, 2, 0))
        motion = update(motion, N, np.einsum("ijt,jt->it", N, z.T - motion.position))
        plain = [textbook(x, V, T, q, z[t], R[t]) for t, (x, V) in enumerate(plain)]
    for t, (x, V) in enumerate(plain):
        np.testing.assert_allclose(motion.x[:, t], x, rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(motion.V[..., t], V, rtol=1e-6, atol=1e-6 * np.abs(V).max())


def test_a_smoothed_place_is_that_of_both_sides_and_its_own_images():
    """Against the textbook's form with all three kinds of information added up."""
    rng, T, method = np.random.default_rng(8), 0.01, Simultaneous()
    frame = np.arange(2 * LOOK + 3)
    xyz = dance(1, len(frame))[0] + rng.normal(0, 0.3, (len(frame), 3))
    root = rng.normal(0, 0.4, (len(frame), 3, 3)) + np.eye(3)
    points = TrackPoints(frame, np.zeros_like(frame), xyz, root @ root.swapaxes(1, 2))
    middle = frame == LOOK + 1
    found, cov = smoothed(points, middle, ~middle, T, method)
    rows = RowsByTrack.of(points.frame, points.id)
    near = [rows_near(rows, np.zeros(1, int), frame[middle], way) for way in (-1, 1)]
    for one in near:
        one[0] = -1  # not the point itself
    before, after = (motion_from(points, one, xyz[middle].T, T, method) for one in near)
    after = reversed_time(after)
    past, future = (np.linalg.inv(one.V[..., 0]) for one in (before, after))
    N = np.zeros((9, 9))
    N[:3, :3] = np.linalg.inv(points.cov[middle][0])
    V = np.linalg.inv(past + future + N)
    x = V @ (past @ before.x[:, 0] + future @ after.x[:, 0] + N[:, :3] @ xyz[middle][0])
    np.testing.assert_allclose(found[0], x[:3], atol=1e-6)
    np.testing.assert_allclose(cov[0], V[:3, :3], rtol=1e-5, atol=1e-9)


def test_forth_and_back_in_time_is_the_same_place():
    rng = np.random.default_rng(1)
    motion = initial_states(rng.normal(size=(3, 4)), np.eye(3)[..., None] * np.ones(4), speed=1000.0, acceleration=1e4)
    motion = KalmanStates(motion.x + rng.normal(size=(9, 4)), motion.V)
    again = back(predict(motion, 0.02, 1e4), 0.02, 1e4)
    np.testing.assert_allclose(again.x, motion.x, atol=1e-9)
    np.testing.assert_allclose(reversed_time(reversed_time(motion)).V, motion.V)


@pytest.mark.parametrize("seed", range(6))
def test_claims_are_the_best_of_all(seed):
    """Against all ways in which three tracks can have three images, in a crowd of one camera."""
    rng = np.random.default_rng(seed)
    rig = ring(2)
    middle = np.array([0.0, 0.0, 1000.0])
    xyz = middle + rng.normal(size=(3, 3)) * 4
    cov = np.eye(3)[..., None] * rng.uniform(1, 30, 3)
    uv = np.concatenate([project(rig[0], xyz + rng.normal(size=(3, 3)) * 4), [[5.0, 5.0]]])
    detections = Detections.build(rig.names, 100.0, [[3], [1]], uv, np.broadcast_to(np.eye(2) * 0.01, (4, 2, 2)))
    images = read_images(detections, rig)
    V = np.zeros((9, 9, 3))
    V[:3, :3] = cov
    expected = predict_images(images.P, KalmanStates(np.concatenate([xyz.T, np.zeros((6, 3))]), V))
    association = associate(images, images.usable, np.zeros(3, int), expected, 5.0)
    table = np.zeros((3, 6))  # the last three columns are none
    for t in range(3):
        S = (
            np.array([[expected.S[0, 0, t], expected.S[0, 1, t]], [expected.S[0, 1, t], expected.S[0, 2, t]]])
            + np.eye(2) * 0.01
        )
        off = images.uv[:3] - expected.uv[0, :, t]
        squared = (off * np.linalg.solve(S, off.T).T).sum(1)
        score = images.prior[0] - np.log(np.linalg.det(S)) - squared
        table[t, :3] = np.where((squared < 25) & (score > 0), score, -np.inf)
    best = max(table[[0, 1, 2], list(way)].sum() for way in permutations(range(6), 3))
    assert association.score[0].sum() == pytest.approx(best)
    taken = association.detection[0][association.detection[0] >= 0]
    assert len(set(taken.tolist())) == len(taken)


@pytest.mark.parametrize("at_once", [1, 40, 4000])
def test_pairs_near_lines_are_those_of_a_loop_over_all_pairs(at_once, monkeypatch):
    """Whatever the number of images in each frame and camera, and however many frames are looked at together."""
    monkeypatch.setattr(sys.modules["kinemark.track.simultaneous.following.candidate_points"], "AT_ONCE", at_once)
    rig, rng = ring(4), np.random.default_rng(3)
    xyz = dance(6, 9)
    xyz[:, 4] = np.nan  # nothing there
    xyz[1:, 5] = np.nan
    detections, _ = observe(rig, xyz + rng.normal(size=xyz.shape), noise=2.0)
    images = read_images(detections, rig)
    F, frames = fundamentals(images.P), [0, 1, 4, 5, 8]
    found = [near_lines(images, part, F, 5.0) for part in batches(images.in_frames(frames))]
    expected = set()
    for i, j in permutations(range(len(images.uv)), 2):
        a, b = images.camera[[i, j]]
        if a < b and images.frame[i] == images.frame[j] and images.frame[i] in frames:
            x, y = np.append(images.uv[i], 1.0), np.append(images.uv[j], 1.0)
            far = [abs(line @ p) / np.hypot(*line[:2]) for line, p in ((F[a, b] @ x, y), (F[b, a] @ y, x))]
            if max(far) < 5 * np.sqrt(images.variance[[i, j]].sum()):
                expected.add((i, j))
    assert len(expected) > 50
    assert sorted(map(tuple, np.concatenate(found, -1).T.tolist())) == sorted(expected)


def test_points_of_pairs_are_those_of_views():
    """`intersect` by the two images that there are and by a line for every camera is the same."""
    rig = ring(5)
    detections, truth = observe(rig, dance(8, 3), noise=0.1)
    images = read_images(detections, rig)
    pair = np.array([(i, j) for i, j in permutations(range(len(truth)), 2) if images.camera[i] < images.camera[j]]).T
    pair = pair[:, (truth[pair[0]] == truth[pair[1]]) & (images.frame[pair[0]] == images.frame[pair[1]])]
    detection = np.full((5, pair.shape[1]), -1)
    detection[images.camera[pair], np.arange(pair.shape[1])] = pair
    one, other = intersect(images, pair, images.camera[pair]), intersect(images, detection)
    assert np.abs(one.xyz - other.xyz).max() < 1e-6 and np.allclose(one.cov, other.cov, rtol=1e-6)
    assert np.allclose(one.squared, other.squared.T[detection.T >= 0].reshape(-1, 2).T, atol=1e-6)


def test_parameters_are_checked():
    for name in ("gate", "process_noise", "max_coasting", "max_sd"):
        with pytest.raises(ValueError, match=name):
            Simultaneous(**{name: -1.0})
