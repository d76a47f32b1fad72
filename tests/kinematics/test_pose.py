"""Bodies from clusters of markers, the points that they carry, centres from motion, cycles."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import Angles, Events, KinemarkError, MarkerTrajectory, Trajectories
from kinemark.geometry import rigid_align
from kinemark.io.model_toml import load_model, model_from_toml
from kinemark.kinematics import (
    Axis,
    Centre,
    Cluster,
    Joint,
    JointMotion,
    Model,
    Pose,
    Segment,
    SignedAngles,
    body_pose,
    cycles,
    estimated_sd,
    joint_angles,
    joint_centre,
    joint_matrices,
    principal,
    resampled,
    rotation_covariance,
    spans_of,
    static_template,
    with_marker_sd,
)
from kinemark.kinematics.chain import points_of
from kinemark.kinematics.pose import carry

RNG = np.random.default_rng(8)
SHAPE = np.array([[0, 0, 0], [80, 5, 0], [20, 90, 10], [-10, 30, 60.0]])


def motion(n, seed=0):
    return Rotation.random(n, random_state=seed).as_matrix(), np.random.default_rng(seed).normal(size=(n, 3)) * 300


def laid(R, t, points):
    """(K, F, 3) of points (K, 3) of a body."""
    return np.einsum("fij,kj->kfi", R, points) + t


def test_a_pose_comes_back_and_is_the_least_squares_one():
    R, t = motion(40)
    pose = body_pose(SHAPE, laid(R, t, SHAPE))
    assert np.abs(pose.R - R).max() < 1e-9 and np.abs(pose.t - t).max() < 1e-9 and pose.residual.max() < 1e-9
    noisy = laid(R, t, SHAPE) + RNG.normal(size=(4, 40, 3))
    pose = body_pose(SHAPE, noisy)
    for f in range(40):
        want = rigid_align(SHAPE, noisy[:, f])
        assert np.abs(pose.R[f] - want[0]).max() < 1e-9 and np.abs(pose.t[f] - want[1]).max() < 1e-7


def test_markers_may_be_missing_down_to_three_off_a_line():
    R, t = motion(6)
    x = laid(R, t, SHAPE)
    x[0, 1] = x[0, 2] = x[1, 2] = np.nan
    pose = body_pose(SHAPE, x)
    assert pose.used.tolist() == [4, 3, 2, 4, 4, 4]
    assert np.isnan(pose.R[2]).all() and np.abs(np.delete(pose.R - R, 2, 0)).max() < 1e-9
    line = np.array([[0, 0, 0], [50, 0, 0], [120, 0, 0.0]])
    assert np.isnan(body_pose(line, laid(R, t, line)).R).all()
    with pytest.raises(ValueError, match="wanted"):
        body_pose(SHAPE, x[:3])


def test_rotation_error_and_residual_are_what_simulation_finds():
    R, t = (np.repeat(a, 6000, 0) for a in motion(1, seed=3))
    pose = body_pose(SHAPE, laid(R, t, SHAPE) + 1.5 * RNG.normal(size=(4, 6000, 3)))
    error = Rotation.from_matrix(pose.R @ R.transpose(0, 2, 1)).as_rotvec(degrees=True)
    want = rotation_covariance(SHAPE, Pose(R[0], t[0], np.zeros(1), np.zeros(1, int)), 1.5)
    assert np.abs(np.cov(error.T) - want).max() < 0.06 * np.abs(want).max()
    assert abs(np.sqrt(np.mean(pose.residual**2)) / 1.5 - 1) < 0.02


HINGE = Model(
    "two bodies",
    (
        Segment("first", Axis("y", ("A1", "B1")), Axis("x", ("A1", "B1", "A1", "C1"))),
        Segment("second", Axis("y", ("A2", "B2")), Axis("x", ("A2", "B2", "A2", "C2"))),
    ),
    (Joint("joint", "first", "second", "zxy", (JointMotion("a", "b"),) * 3),),
    clusters=(
        Cluster("one", ("M1", "M2", "M3", "M4"), ("A1", "B1", "C1")),
        Cluster("two", ("N1", "N2", "N3", "N4"), ("A2", "B2", "C2")),
    ),
)
LANDMARKS = np.array([[10, -40, 5], [15, 160, 20], [90, 30, -20.0]])


def pivoted(R, t, point):
    """(F, 3) of one point of a body."""
    return np.einsum("fij,j->fi", R, point) + t


def two_bodies(n, *, seed=0, sd=0.0, landmarks=True, centre=None):
    """Two bodies with clusters and landmarks; `centre` (3) in both makes a ball joint of them."""
    (R1, t1), (R2, t2) = motion(n, seed), motion(n, seed + 1)
    if centre is not None:
        t2 = pivoted(R1, t1, centre[0]) - np.einsum("fij,j->fi", R2, centre[1])
    paths = []
    for letter, mark, R, t in (("M", "1", R1, t1), ("N", "2", R2, t2)):
        x = laid(R, t, SHAPE) + sd * np.random.default_rng(seed + 5).normal(size=(4, n, 3))
        paths += [MarkerTrajectory.measured(f"{letter}{k}", v) for k, v in enumerate(x, 1)]
        if landmarks:
            paths += [
                MarkerTrajectory.measured(f"{a}{mark}", v) for a, v in zip("ABC", laid(R, t, LANDMARKS), strict=True)
            ]
    return Trajectories(tuple(paths), 100.0)


def test_clusters_carry_landmarks_from_the_static_trial():
    template = static_template(two_bodies(5), HINGE)
    moving = two_bodies(30, seed=7)
    bare = joint_angles(moving, model=HINGE)
    markers = replace(moving, paths=tuple(p for p in moving if p.name[0] in "MN"))
    carried = joint_angles(markers, model=HINGE, template=template)
    assert np.abs(np.remainder(carried.deg - bare.deg + 180, 360) - 180).max() < 1e-6
    with pytest.raises(KinemarkError, match="A static trial gives them"):
        joint_angles(markers, model=HINGE)
    hidden = replace(markers, paths=tuple(_hole(p, 10) if p.name == "M2" else p for p in markers))
    assert np.isfinite(joint_angles(hidden, model=HINGE, template=template).deg).all()


def _hole(path, f):
    xyz = path.xyz.copy()
    xyz[f] = np.nan
    return MarkerTrajectory.measured(path.name, xyz)


def test_sd_goes_through_the_pose_of_the_cluster():
    template = static_template(two_bodies(5), HINGE)
    trial = with_marker_sd(two_bodies(6, seed=2, landmarks=False), 0.5)
    found = joint_angles(trial, model=HINGE, template=template, method=SignedAngles(continuous=False))
    rng = np.random.default_rng(4)
    drawn = {n: x + 0.5 * rng.normal(size=(3000, *x.shape)) for n, x in points_of(trial).items()}
    deg = principal(joint_matrices(drawn, HINGE, template)[0], "zxy")
    spread = np.degrees(np.std(np.radians(np.remainder(deg - found.deg[0] + 180, 360) - 180), axis=0))
    assert np.abs(found.sd[0] / spread - 1).max() < 0.1


def test_a_static_trial_is_averaged_as_one_rigid_body():
    exact = static_template(two_bodies(3), HINGE)["one"]
    noisy = static_template(two_bodies(200, sd=1.0), HINGE)["one"]
    between = [np.linalg.norm(t.xyz[:, None] - t.xyz, axis=-1) for t in (exact, noisy)]
    assert np.abs(between[0] - between[1]).max() < 0.4  # a single frame is off by some 1.4 mm
    assert np.abs(exact.xyz.mean(0)).max() < 1e-9


def test_static_trials_that_cannot_serve_say_why():
    trial = two_bodies(4)
    blind = replace(trial, paths=tuple(_gone(p) if p.name == "N3" else p for p in trial))
    with pytest.raises(KinemarkError, match="No frame of the static trial has all of N1, N2, N3, N4"):
        static_template(blind, HINGE)
    unseen = replace(trial, paths=tuple(_gone(p) if p.name == "B2" else p for p in trial))
    with pytest.raises(KinemarkError, match="never shows B2"):
        static_template(unseen, HINGE)
    flat = replace(trial, paths=tuple(replace(trial["M1"], name=p.name) if p.name[0] == "M" else p for p in trial))
    with pytest.raises(KinemarkError, match="on a line"):
        static_template(flat, HINGE)
    with pytest.raises(KinemarkError, match="no clusters"):
        static_template(trial, load_model("um2as"))


def _gone(path):
    return MarkerTrajectory.measured(path.name, np.full_like(path.xyz, np.nan))


CENTRE = np.array([[12, -80, 40], [-5, 150, 22.0]])


def test_a_centre_comes_back_with_a_covariance_that_is_true():
    errors, stated = [], []
    for seed in range(40):
        trial = two_bodies(60, seed=10 * seed, sd=1.0, landmarks=False, centre=CENTRE)
        one, two = (body_pose(SHAPE, np.array([trial[f"{letter}{k}"].xyz for k in range(1, 5)])) for letter in "MN")
        found = joint_centre(one, two)
        errors.append(np.concatenate([found.first, found.second]) - CENTRE.ravel())
        stated.append(np.diag(found.cov))
    z = np.array(errors) / np.sqrt(stated)
    assert np.abs(errors).max() < 4 and 0.8 < z.std() < 1.25


def test_a_hinge_has_no_centre_and_too_few_frames_neither():
    turns = np.linspace(0, 1.5, 50)
    R = Rotation.from_rotvec(turns[:, None] * [0, 0, 1]).as_matrix()
    still = Pose(np.tile(np.eye(3), (50, 1, 1)), np.zeros((50, 3)), np.zeros(50), np.full(50, 4))
    with pytest.raises(KinemarkError, match="too little about one of its axes"):
        joint_centre(still, still._replace(R=R))
    with pytest.raises(KinemarkError, match="9 frames"):
        joint_centre(*(Pose(*(a[:9] for a in p)) for p in (still, still)))


def test_a_model_takes_its_centre_from_the_functional_trial():
    carried = HINGE.clusters[1].points[1:]
    model = replace(
        HINGE,
        clusters=(HINGE.clusters[0], replace(HINGE.clusters[1], points=carried)),
        centres=(Centre("A2", ("one", "two")),),
    )
    swinging = two_bodies(50, seed=3, centre=CENTRE)
    template = static_template(two_bodies(4), model, functional=swinging)
    there = carry(points_of(swinging), template)["A2"]
    assert np.abs(there - pivoted(*motion(50, 3), CENTRE[0])).max() < 1e-6
    with pytest.raises(KinemarkError, match="finds A2 from motion"):
        static_template(two_bodies(4), model)


def test_the_error_of_markers_is_found_in_their_unsteadiness():
    t = np.arange(1000) / 100
    smooth = np.stack([300 * np.sin(2 * np.pi * t), 200 * np.cos(4 * t), 50 * t], -1)
    assert abs(estimated_sd(smooth + 0.4 * RNG.normal(size=smooth.shape)) / 0.4 - 1) < 0.08
    assert estimated_sd(smooth) < 0.01 and np.isnan(estimated_sd(smooth[:10]))
    known = MarkerTrajectory.measured("a", smooth, cov=np.tile(4 * np.eye(3), (1000, 1, 1)))
    stated = with_marker_sd(Trajectories((known, MarkerTrajectory.measured("b", smooth)), 100.0), 2.0)
    assert (stated["a"].cov == known.cov).all() and np.allclose(stated["b"].cov, 4 * np.eye(3))
    with pytest.raises(ValueError, match="sd_mm"):
        with_marker_sd(stated, 0.0)


def angles_of(deg, rate=100.0, sd=1.0):
    deg = np.asarray(deg, float)[None]
    return Angles(("j",), ("zxy",), deg, np.broadcast_to(sd**2 * np.eye(3), (*deg.shape, 3)), rate)


def test_cycles_lie_on_each_other_whatever_their_length():
    def shape(x):
        return np.stack([50 * np.sin(2 * np.pi * x), 10 * x, np.cos(2 * np.pi * x)], -1)

    lengths = np.array([80, 120, 100])
    deg = np.concatenate([shape(np.arange(n) / n) for n in lengths] + [shape(np.ones(1))])
    ends = np.concatenate([[0], np.cumsum(lengths)]) / 100
    found = cycles(angles_of(deg), spans=list(pairwise(ends)))
    assert found.deg.shape == (3, 1, 101, 3)
    inside = slice(0, 99)  # at the very end of a cycle the next one begins
    assert np.abs(found.mean[0, inside] - shape(np.linspace(0, 1, 101))[inside]).max() < 0.1
    assert found.spread[0, inside].max() < 0.1 and np.allclose(found.noise, 1 / np.sqrt(3))


def test_mean_and_sd_over_repetitions():
    offsets = RNG.normal(size=6) * 3
    deg = np.concatenate([np.tile(o, (100, 3)) for o in offsets])
    spans = [(k, k + 0.99) for k in range(6)]
    found = cycles(angles_of(deg), spans=spans)
    assert np.allclose(found.mean, offsets.mean()) and np.allclose(found.spread, offsets.std(ddof=1))
    one = cycles(angles_of(deg), spans=spans[:1])
    assert np.isnan(one.spread).all() and np.allclose(one.noise, 1.0)
    turned = deg + 360 * (np.arange(600) // 100 % 2)[:, None]  # whole turns apart
    assert np.allclose(cycles(angles_of(turned), spans=spans).spread, offsets.std(ddof=1))


def test_resampling_keeps_gaps_and_refuses_what_is_not_there():
    y = np.arange(11.0)
    y[4] = np.nan
    out = resampled(y, rate=10, span=(0.0, 1.0))
    assert np.isnan(out[31:50]).all() and np.isfinite(out[[0, 30, 50, 100]]).all() and out[100] == 10
    with pytest.raises(ValueError, match="is not in 0 to 1 s"):
        resampled(y, rate=10, span=(0.5, 1.2))
    with pytest.raises(KinemarkError, match="Correct the cycles"):
        cycles(angles_of(np.zeros((50, 3))), spans=[(0.3, 0.2)])
    with pytest.raises(KinemarkError, match="No cycle"):
        cycles(angles_of(np.zeros((50, 3))), spans=[])


def test_cycles_from_events():
    events = Events(("On", "Off", "On", "On"), ("Left", "Left", "Left", "Right"), np.array([1.0, 1.5, 2.0, 4.0]))
    assert spans_of(events, label="On") == [(1.0, 2.0), (2.0, 4.0)]
    assert spans_of(events, label="On", side="Left", start_s=0.5) == [(0.5, 1.5)]
    with pytest.raises(KinemarkError, match="there are Off, On"):
        spans_of(events, label="Grasp")


CARRIED_BODY = """name = "carried"
[[segment]]
name = "body"
first = { axis = "y", vector = ["p", "q"] }
second = { axis = "x", vector = ["p", "r"] }
[[joint]]
name = "turn"
parent = "laboratory"
child = "body"
sequence = "zxy"
angles = [{ positive = "a" }, { positive = "b" }, { positive = "c" }]
[[cluster]]
name = "body"
markers = ["m1", "m2", "m3", "m4"]
points = ["p", "q", "r"]
"""
BODY_PLACES = {"m1": (0, 0, 0), "m2": (100, 0, 20), "m3": (0, 120, 10), "m4": (30, 40, 90)}
BODY_LANDMARKS = {"p": (0, 0, 0), "q": (60, 200, 45), "r": (150, 3, 40)}


def test_an_angle_has_its_deviation_where_a_marker_of_the_cluster_is_missing():
    """That of the three that are left, and more than that of four."""
    model = model_from_toml(CARRIED_BODY)

    def trial(places, gone=slice(0)):
        still = {name: np.tile(np.array(xyz, float), (9, 1)) for name, xyz in places.items()}
        if "m4" in still:
            still["m4"][gone] = np.nan
        return with_marker_sd(Trajectories(tuple(MarkerTrajectory.measured(n, x) for n, x in still.items()), 50.0), 0.5)

    template = static_template(trial(BODY_PLACES | BODY_LANDMARKS), model)
    whole, part, never = (
        joint_angles(trial(BODY_PLACES, gone), model=model, template=template).sd[0]
        for gone in (slice(0), slice(3, 6), slice(None))
    )
    np.testing.assert_allclose(part[3:6], never[3:6])
    np.testing.assert_allclose(part[:3], whole[:3])
    assert (part[3:6] > whole[3:6]).all()
