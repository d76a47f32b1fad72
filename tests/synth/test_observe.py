"""Truth and quick observations: noise of the asked size, honest labels, and every fault on request only."""

import numpy as np
import pytest

from kinemark.data import same
from kinemark.geometry import project, triangulate, undistort
from kinemark.synth import (
    Capsules,
    Optics,
    Subject,
    control_frame,
    from_trajectories,
    look_at,
    observe,
    render,
    ring,
    rods_subject,
    stationary,
    truth,
    walking,
)
from kinemark.synth.occlusion import line_distance

RIG = ring(6, distortion=(-0.12, 0.04, 0.0005, -0.0005, 0.0))
WALK = walking(duration_s=0.6)


def rows_truth(observed):
    """(D, 2) true pixels of the rows that are markers, and which rows those are."""
    d = observed.detections
    true = observed.marker >= 0
    return observed.sight.uv[d.camera[true], observed.marker[true], d.frame[true]], true


def test_truth_is_the_projection():
    sight = truth(RIG, WALK)
    for c, camera in enumerate(RIG):
        assert same(sight.uv[c], project(camera, WALK.xyz))
    assert sight.visible.shape == (6, 15, 30)
    assert ((sight.visible >= 0) & (sight.visible <= 1)).all()


def test_without_faults_every_visible_marker_is_one_exact_row():
    observed = observe(RIG, WALK, noise_px=0.0)
    expected, true = rows_truth(observed)
    assert true.all() and np.array_equal(observed.detections.uv, expected)
    assert len(true) == (observed.sight.visible >= 0.5).sum()
    assert (observed.merged == 1).all()


def test_perfect_observations_triangulate_to_the_truth():
    observed = observe(RIG, WALK, noise_px=0.0)
    d = observed.detections
    uv = np.full((15, 30, 6, 2), np.nan)
    uv[observed.marker, d.frame, d.camera] = d.uv
    ideal = np.stack([undistort(camera, uv[:, :, c]) for c, camera in enumerate(RIG)], 2)
    found = triangulate(ideal.reshape(-1, 6, 2), RIG.P).reshape(15, 30, 3)
    seen = np.isfinite(found).all(-1)
    assert seen.mean() > 0.95
    assert np.abs(found - WALK.xyz)[seen].max() < 1e-4


def test_noise_has_the_asked_standard_deviation_and_is_noted():
    observed = observe(RIG, WALK, noise_px=0.3, seed=8)
    expected, true = rows_truth(observed)
    off = observed.detections.uv[true] - expected
    assert off.std(0) == pytest.approx(0.3, rel=4 / np.sqrt(2 * len(off)))
    assert np.abs(off.mean(0)).max() < 4 * 0.3 / np.sqrt(len(off))
    assert np.allclose(observed.detections.cov, 0.09 * np.eye(2))


def test_false_points_come_at_the_asked_rate_and_are_labelled():
    observed = observe(RIG, WALK, false_per_frame=3.0, seed=1)
    false = observed.marker < 0
    n = 6 * WALK.n_frames
    assert false.sum() / n == pytest.approx(3.0, abs=4 * np.sqrt(3 / n))
    assert (observed.merged[false] == 0).all() and (observed.merged[~false] == 1).all()
    size = RIG[0].size
    assert ((observed.detections.uv[false] >= -0.5) & (observed.detections.uv[false] <= size - 0.5)).all()


def test_dropout_takes_its_share():
    full, some = observe(RIG, WALK), observe(RIG, WALK, dropout=0.25, seed=2)
    n = len(full.detections)
    assert len(some.detections) / n == pytest.approx(0.75, abs=4 * np.sqrt(0.1875 / n))


def test_near_images_run_together_at_the_mean_weighted_by_area():
    camera = look_at("c", (0, -3000, 0), (0, 0, 0), focal_px=1000)
    rig = type(RIG)((camera,))
    pair = stationary(("far", "near", "other"), [[0, 0, 0], [3, -600, 0], [300, 0, 0]], radius_mm=[20, 8, 8])
    observed = observe(rig, pair, noise_px=0.0, merge_px=5.0)
    assert sorted(zip(observed.marker, observed.merged, strict=True)) == [(1, 2), (2, 1)]
    uv, area = observed.sight.uv[0, :2, 0], observed.sight.area[0, :2, 0]
    row = observed.detections.uv[observed.marker == 1][0]
    assert np.allclose(row, (uv * area[:, None]).sum(0) / area.sum())
    assert len(observe(rig, pair, merge_px=1.0).detections) == 3


def test_chains_of_near_images_are_one():
    camera = look_at("c", (0, -1000, 0), (0, 0, 0), focal_px=1000)
    row = stationary(tuple("abcd"), [[0, 0, 0], [4, 0, 0], [8, 0, 0], [30, 0, 0]], radius_mm=1.0)
    observed = observe(type(RIG)((camera,)), row, merge_px=5.0)
    assert sorted(observed.merged) == [1, 3]
    np.testing.assert_array_equal(observed.detections.merged, observed.merged > 1)


def test_merging_loses_no_marker():
    observed = observe(RIG, WALK, merge_px=12.0)
    assert observed.merged.sum() == (observed.sight.visible >= 0.5).sum()
    assert observed.merged.max() > 1
    d = observed.detections
    for c in range(6):
        for f in range(d.n_frames):
            apart = np.linalg.norm(d[c, f][:, None] - d[c, f], axis=-1) + 1e3 * np.eye(len(d[c, f]))
            assert len(d[c, f]) < 2 or apart.min() > 3  # a blob's mean may near another's, but not by much


def test_order_within_a_frame_tells_nothing():
    observed = observe(RIG, WALK)
    steps = [np.diff(observed.marker[observed.detections.rows(c, f)]) for c in range(6) for f in range(30)]
    rising = np.concatenate(steps) > 0
    assert rising.mean() == pytest.approx(0.5, abs=4 * 0.5 / np.sqrt(len(rising)))


def test_same_seed_same_detections():
    asked = {"false_per_frame": 1.0, "merge_px": 4.0, "dropout": 0.1}
    assert same(observe(RIG, WALK, seed=3, **asked), observe(RIG, WALK, seed=3, **asked))
    assert not same(observe(RIG, WALK, seed=3, **asked), observe(RIG, WALK, seed=4, **asked))


def test_limb_in_the_way_hides():
    camera = look_at("c", (0, -3000, 0), (0, 0, 0))
    a, b = np.array([[[-100.0, -500, 0]]]), np.array([[[100.0, -500, 0]]])

    def seen(z, radius=60.0):
        up = np.array([0.0, 0.0, z])
        limb = Capsules(("l",), a + up, b + up, np.array([radius]))
        subject = Subject(("m",), 50.0, np.zeros((1, 1, 3)), np.array(12.5), limb)
        return truth(type(RIG)((camera,)), subject).visible.item()

    assert seen(0.0) == 0 and seen(200.0) == 1
    assert 0 < seen(58.0) < 1
    assert seen(-58.0) == seen(58.0)


def test_visible_share_agrees_with_rendered_light():
    optics = Optics(background=0, read_noise=0, blur_px=0, subsamples=4, brightness=200.0)
    camera, f = RIG[1], 12
    sight = truth(RIG, WALK)
    for m in range(15):
        alone = render(camera, WALK.xyz[m : m + 1, f], 12.5, capsules=WALK.capsules, frame=f, optics=optics)
        free = render(camera, WALK.xyz[m : m + 1, f], 12.5, optics=optics)
        share = alone.sum(dtype=float) / free.sum(dtype=float)
        assert share == pytest.approx(sight.visible[1, m, f], abs=0.22)  # seven lines of sight say no more


def test_absent_outside_and_behind_are_not_seen():
    camera = look_at("c", (0, -3000, 0), (0, 0, 0))
    places = stationary(tuple("abcd"), [[0, 0, 0], [np.nan] * 3, [5000, 0, 0], [0, -4000, 0]], radius_mm=10.0)
    assert truth(type(RIG)((camera,)), places).visible[0, :, 0].tolist() == [1, 0, 0, 0]
    gone = from_trajectories(places.trajectories)
    assert observe(type(RIG)((camera,)), gone).marker.tolist() == [0]


def test_control_frame_is_wholly_seen():
    observed = observe(RIG, rods_subject(control_frame()))
    assert (observed.detections.counts == 24).all()


def test_distance_of_lines_against_a_search():
    rng = np.random.default_rng(0)
    o, d, a, b = rng.normal(0, 100, (4, 50, 3))
    s, t = np.meshgrid(np.linspace(0, 1, 201), np.linspace(0, 1, 201), indexing="ij")
    on = (o[:, None, None] + s[..., None] * d[:, None, None]) - (
        a[:, None, None] + t[..., None] * (b - a)[:, None, None]
    )
    assert np.allclose(line_distance(o, d, a, b), np.linalg.norm(on, axis=-1).min((1, 2)), atol=1.5)
    assert (line_distance(o, d, a, b) <= np.linalg.norm(on, axis=-1).min((1, 2)) + 1e-9).all()
    assert line_distance(o[0], d[0], o[0] + 2 * d[0] + [3, 0, 0], o[0] + 3 * d[0] + [3, 0, 0]) > 0  # parallel


def test_mistakes_are_named():
    with pytest.raises(ValueError, match="dropout"):
        observe(RIG, WALK, dropout=1.5)
