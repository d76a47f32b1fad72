"""The former two-camera method (KISS section 4): each camera followed on its own, then brought together in space."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinemark.data import Detections, KinemarkError, same
from kinemark.geometry import epipolar_lines, fundamental, project, to_dlt
from kinemark.synth.score import score
from kinemark.track.two_cameras.former_two_cameras import FormerTwoCameras, track_two_cameras
from kinemark.track.two_cameras.image_paths import Paths, paths_of, start_of
from kinemark.track.two_cameras.paired_paths import best_interval, paired, residuals, without_swaps
from support.laboratory import observe, ring
from support.motions import swarm

IDEAL = np.zeros(5)
SIZE = np.array([1000, 800])
METHOD = FormerTwoCameras()


def two_cameras(**options):
    """Neighbours of a ring of twelve: they see all from one side, beside each other."""
    return ring(12, **options).select(["c0", "c1"])


def images_of(paths, order=None):
    """Images (D, 2) and rows (F) of each field from paths (T, F, 2), those that are NaN left out."""
    t, f, _ = paths.shape
    turn = [np.arange(t) if order is None else order.permutation(t) for _ in range(f)]
    fields = [paths[turn[k], k] for k in range(f)]
    fields = [field[~np.isnan(field[:, 0])] for field in fields]
    edges = np.cumsum([0, *map(len, fields)])
    return np.concatenate(fields), [np.arange(a, b) for a, b in pairwise(edges)]


def straight(frames, *lines):
    """(T, F, 2) paths that begin at (u, v) and move by (du, dv) px a field."""
    return np.array([[[u + du * f, v + dv * f] for f in range(frames)] for u, v, du, dv in lines], float)


def test_markers_that_both_cameras_see_are_followed_whole():
    rig, points = two_cameras(), swarm(n=15, frames=60)
    detections, _ = observe(rig, points, noise=0.1)
    tracks = track_two_cameras(detections, rig, method=METHOD)
    result = score(tracks, points)
    assert (len(tracks), result.recall, result.swaps, result.extra_per_frame) == (15, 1.0, 0, 0.0)
    assert (result.fragments == 1).all()
    assert abs(result.coverage - 0.95) < 0.03
    assert tracks.cloud.residual.max() < 0.5


def test_the_order_of_the_two_cameras_does_not_matter():
    rig, points = two_cameras(), swarm(n=12, frames=40)
    detections, _ = observe(rig, points, noise=0.1)
    turned = rig.select(["c1", "c0"])
    one, other = (
        track_two_cameras(detections, rig, method=METHOD),
        track_two_cameras(detections.select(turned.names), turned, method=METHOD),
    )
    lines = [sorted(map(tuple, np.round(t.cloud.xyz[t.id == i], 3))) for t in (one, other) for i in range(12)]
    for a, b in zip(sorted(lines[:12]), sorted(lines[12:]), strict=True):
        assert np.allclose(a, b, atol=1e-2)


@pytest.mark.parametrize("names", [["c0"], ["c0", "c1", "c2"], ["c0", "c1", "c2", "c3", "c4", "c5"]])
def test_it_takes_two_cameras_and_says_what_to_do_otherwise(names):
    rig = ring(6).select(names)
    detections, _ = observe(rig, swarm(n=3, frames=4))
    with pytest.raises(KinemarkError, match=rf"two cameras, found {len(names)} .*Choose two"):
        track_two_cameras(detections, rig, method=METHOD)
    if len(names) == 3:
        with pytest.raises(KinemarkError, match="Choose two"):
            track_two_cameras(detections, rig.select(names[:2]), method=METHOD)


def test_it_starts_where_all_markers_are_seen_and_move_least():
    speed = np.abs(np.arange(30) - 17.3) + 0.1  # least between fields 17 and 18
    u = np.concatenate([[0.0], np.cumsum(speed)])
    paths = np.stack([np.stack([100 + u, 100 * k + 50 + 0 * u], -1) for k in range(4)])
    assert start_of(*images_of(paths), None)[0] == 17
    paths[2, 15:20] = np.nan  # one is hidden then
    first, before, after = start_of(*images_of(paths), None)
    assert first == 20
    assert len(before) == len(after) == 4
    assert start_of(*images_of(paths), 3)[0] == 17


def test_a_camera_that_never_shows_all_markers_is_refused():
    rig, points = two_cameras(), swarm(n=3, frames=20)
    points[0, ::2] = np.nan
    points[1, 1::2] = np.nan
    detections, _ = observe(rig, points)
    with pytest.raises(KinemarkError, match=r"Camera c0 shows at most 2 of 3 markers.*another camera"):
        track_two_cameras(detections, rig, method=FormerTwoCameras(n_markers=3))
    assert len(track_two_cameras(detections, rig, method=FormerTwoCameras(min_fields=5))) <= 2  # so many are followed


def test_paths_go_forward_and_backward_and_do_not_depend_on_the_order_of_images():
    rng = np.random.default_rng(0)
    paths = straight(30, (100, 100, 8, 2), (150, 400, -3, -5), (600, 200, 1, 9)) + rng.normal(0, 0.3, (3, 30, 2))
    expected = sorted(map(tuple, paths.reshape(3, -1)))
    for order in (None, rng, rng):
        found = paths_of(*images_of(paths, order), size=SIZE, window=10.0, markers=None)
        assert sorted(map(tuple, found.uv.reshape(3, -1))) == expected
        assert (found.detection >= 0).all()


@pytest.mark.parametrize(("known", "weights"), [(2, (2, -1)), (3, (4 / 3, 1 / 3, -2 / 3)), (9, (4 / 3, 1 / 3, -2 / 3))])
def test_a_hidden_marker_is_where_the_line_through_two_or_three_points_leads(known, weights):
    rng = np.random.default_rng(1)
    path = straight(known + 1, (100, 100, 5, 3)) + rng.normal(0, 0.5, (1, known + 1, 2))
    path[0, 1] = path[0, 0] + 0.01  # so that it starts with the first two fields
    path[0, -1] = np.nan
    found = paths_of(*images_of(path), size=SIZE, window=20.0, markers=None)
    expected = sum(w * path[0, known - 1 - k] for k, w in enumerate(weights))
    assert found.uv[0, known] == pytest.approx(expected)
    assert found.detection[0].tolist() == [*range(known), -1]


@pytest.mark.parametrize(
    ("off", "taken"), [((9.9, 0), True), ((10.1, 0), False), ((9.9, 9.9), True), ((0, -10.1), False)]
)
def test_an_image_is_taken_within_the_association_window(off, taken):
    path = straight(8, (100, 100, 5, 3))
    path[0, -1] += off
    assert (paths_of(*images_of(path), size=SIZE, window=10.0, markers=1).detection[0, -1] >= 0) == taken


def test_the_proximal_of_two_images_is_taken():
    paths = np.concatenate([straight(8, (100, 100, 5, 3)), np.full((1, 8, 2), np.nan)])
    paths[0, 1] = paths[0, 0]  # it starts there
    paths[1, 6] = paths[0, 6] + [3, 3]
    paths[0, 6] += [-2, -1]
    found = paths_of(*images_of(paths), size=SIZE, window=20.0, markers=1)
    assert found.uv[0, 6] == pytest.approx(paths[0, 6])


def test_a_path_ends_where_it_leaves_the_image():
    path = straight(40, (700, 100, 20, 0))
    path[0, path[0, :, 0] > 999] = np.nan
    found = paths_of(*images_of(path), size=SIZE, window=10.0, markers=None)
    last = int(np.flatnonzero(found.detection[0] >= 0)[-1])
    assert last == 14
    assert np.isnan(found.uv[0, last + 1 :]).all()


def test_gaps_are_filled_by_prediction_and_the_points_say_so():
    rig, points = two_cameras(), swarm(n=6, frames=60)
    detections, truth = observe(rig, points, noise=0.1)
    frame = detections.frame
    hidden = (detections.camera == 1) & (truth == 2) & (frame >= 30) & (frame < 34)
    filled = track_two_cameras(detections.keep(~hidden), rig, method=METHOD)
    assert score(filled, points).recall == 1.0
    assert (score(filled, points).fragments == 1).all()
    guessed = (filled.cloud.detection < 0).any(1)
    assert sorted(filled.cloud.frame[guessed]) == [30, 31, 32, 33]
    assert (filled.cloud.detection[guessed, 0] >= 0).all()
    sd = np.sqrt(np.trace(filled.cloud.cov, axis1=1, axis2=2))
    assert sd[guessed].min() > 5 * sd[~guessed].max()


def test_where_both_cameras_lose_a_marker_there_is_no_point():
    rig, points = two_cameras(), swarm(n=6, frames=60)
    detections, truth = observe(rig, points, noise=0.05)
    hidden = (truth == 2) & (detections.frame == 30)
    tracks = track_two_cameras(detections.keep(~hidden), rig, method=METHOD)
    assert len(tracks.cloud) == 6 * 60 - 1
    assert (score(tracks, points).fragments == 1).all()


def test_the_residual_is_what_the_fourth_equation_leaves():
    """Against three of the four DLT equations of KISS eq. 7 written out and solved."""
    rig, rng = two_cameras(lens=IDEAL), np.random.default_rng(4)
    L, uv = to_dlt(rig.P), rng.uniform(300, 700, (2, 3, 5, 2))
    r = residuals(uv[0], uv[1], rig.P)
    assert r.shape == (3, 3, 5)
    for a, b, f in np.ndindex(3, 3, 5):
        A, y = [], []
        for own, (u, v) in ((L[0], uv[0, a, f]), (L[1], uv[1, b, f])):
            A += [[own[k] - own[8 + k] * u for k in range(3)], [own[4 + k] - own[8 + k] * v for k in range(3)]]
            y += [u - own[3], v - own[7]]
        X = np.linalg.solve(A[:3], y[:3])
        depth = L[1, 8:11] @ X + 1
        if np.isfinite(r[a, b, f]):
            assert r[a, b, f] == pytest.approx(abs((A[3] @ X - y[3]) / depth), rel=1e-6)


def test_the_residual_is_the_distance_from_the_epipolar_line_along_v():
    rig, points = two_cameras(lens=IDEAL), swarm(n=8, frames=5)
    one, other = (project(camera, points) for camera in rig)
    r = residuals(one, other, rig.P)
    assert r[np.arange(8), np.arange(8)].max() < 1e-6
    lines = epipolar_lines(fundamental(*rig.P), one)
    along = np.abs((lines[:, None, :, :2] * other).sum(-1) + lines[:, None, :, 2]) / np.abs(lines[:, None, :, 1])
    there = np.isfinite(r)
    assert r[there] == pytest.approx(along[there], abs=1e-6)
    assert there.mean() > 0.9


def crossing(rig, camera):
    """Paths of two markers whose images cross in one camera in field 20, and in the other they are far apart."""
    middle, away = np.array([0.0, 0, 900]), np.array([0.0, 0, 900]) - rig[camera].centre
    away /= np.linalg.norm(away)
    across, t = np.cross(away, [0, 0, 1.0]), np.arange(40.0)[:, None] - 20
    points = np.stack([middle + 8 * t * across, middle + 250 * away - 8 * t * across + (6 * t + 0.5) * [0, 0, 1]])
    return points, [Paths(project(c, points), np.arange(80).reshape(2, 40)) for c in rig]


@pytest.mark.parametrize("camera", [0, 1])
@pytest.mark.parametrize("stretch", [slice(20, 40), slice(0, 20), slice(20, 30)])
def test_paths_that_branched_wrongly_are_set_right(camera, stretch):
    rig = two_cameras(lens=IDEAL)
    _, true = crossing(rig, camera)
    if stretch.stop == 30:  # two crossings, made by going back
        true = [Paths(np.concatenate([p.uv[:, :25], p.uv[:, 24:9:-1]], 1), p.detection) for p in true]
    wrong = [Paths(p.uv.copy(), p.detection.copy()) for p in true]
    for part in wrong[camera]:
        part[:, stretch] = part[::-1, stretch]
    found = without_swaps(*wrong, rig.P, limit=2.0, window=10.0)
    r = residuals(found[0].uv, found[1].uv, rig.P)
    assert min(r[[0, 1], [0, 1]].max(), r[[0, 1], [1, 0]].max()) < 1.0
    assert same(found[1 - camera], true[1 - camera])  # set right where it was wrong
    assert any(np.allclose(found[camera].uv, true[camera].uv[order], atol=1e-6) for order in ([0, 1], [1, 0]))
    untouched = without_swaps(*true, rig.P, limit=2.0, window=10.0)
    assert same([*untouched], [*true])


def test_only_paths_that_came_near_each_other_can_be_exchanged():
    rig = two_cameras(lens=IDEAL)
    points = np.array([[0.0, -300, 700], [0, 300, 1200]])[:, None].repeat(40, 1)
    wrong = [Paths(project(c, points), np.arange(80).reshape(2, 40)) for c in rig]
    for part in wrong[0]:
        part[:, 20:] = part[::-1, 20:].copy()
    assert same([*without_swaps(*wrong, rig.P, limit=2.0, window=10.0)], wrong)
    split = paired(residuals(wrong[0].uv, wrong[1].uv, rig.P), limit=2.0, shortest=10)
    assert np.bincount(split.id).tolist() == [20, 20, 20, 20]  # so they are split instead
    assert len(split.frame) == 80


def test_crossing_markers_come_out_whole():
    rig = two_cameras()
    points, _ = crossing(rig, 0)
    detections, _ = observe(rig, points, noise=0.05)
    result = score(track_two_cameras(detections, rig, method=METHOD), points)
    assert (result.swaps, result.fragments.tolist()) == (0, [1, 1])


@given(st.lists(st.integers(-5, 5), min_size=1, max_size=12))
def test_the_best_stretch_is_the_best_of_all(values):
    total, first, stop = best_interval(np.array(values, float))
    sums = [sum(values[a:b]) for a in range(len(values) + 1) for b in range(a, len(values) + 1)]
    assert total == max(sums) == sum(values[int(first) : int(stop)])


def test_a_path_has_one_partner_at_a_time_the_best_first():
    """One path of the second camera and two of the first, of which the one fits better, but ends."""
    r = np.full((2, 1, 40), 0.5)
    r[0, 0] = 0.1
    r[0, 0, 25:] = np.inf
    found = paired(r, limit=2.0, shortest=10)
    assert found.frame.tolist() == list(range(40))
    assert found.one.tolist() == [1] * 40  # the longer is the better
    r[1, 0, :8] = r[1, 0, 36:] = np.inf
    found = paired(r, limit=2.0, shortest=10)
    assert found.one.tolist() == [1] * 28 or found.one.tolist() == [0] * 25 + [1] * 11
    assert len(np.unique(found.frame)) == len(found.frame)


def test_each_image_is_in_one_track_at_most():
    rig, points = two_cameras(), swarm(n=30, frames=30)
    detections, _ = observe(rig, points, noise=0.8)
    tracks = track_two_cameras(detections, rig, method=METHOD)
    used = tracks.cloud.detection[tracks.cloud.detection >= 0]
    assert len(np.unique(used)) == len(used) > 1000
    assert (tracks.lengths >= 10).all()
    assert same(track_two_cameras(detections, rig, method=METHOD), tracks)


@pytest.mark.parametrize("frames", [0, 1, 3])
def test_nothing_seen_is_no_error(frames):
    rig = two_cameras()
    nothing = Detections.build(rig.names, 100.0, np.zeros((2, frames), int), np.zeros((0, 2)))
    tracks = track_two_cameras(nothing, rig, method=METHOD)
    assert (len(tracks), len(tracks.cloud), tracks.cloud.n_frames) == (0, 0, frames)


@pytest.mark.parametrize("name", ["window", "n_markers", "max_residual", "min_fields"])
def test_parameters_that_make_no_sense_are_refused(name):
    with pytest.raises(ValueError, match=name):
        FormerTwoCameras(**{name: 0})
