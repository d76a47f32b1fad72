"""Laws of the filling methods: what each reproduces, how all turn with the laboratory, what they do with bad input."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.fill import (
    PCA,
    Cubic,
    Cyclic,
    Gap,
    Linear,
    LowRankKalman,
    MarkerArray,
    Pattern,
    Quintic,
    Relational,
    RigidBody,
    StaticShape,
    find_gaps,
)
from kinemark.fill.methods.low_rank_kalman import solve
from kinemark.fill.methods.polynomials import lagrange
from kinemark.fill.methods.stage import filler_of
from kinemark.geometry import nearest_rotations
from kinemark.io.c3d.to_trial import read_c3d
from kinemark.signal import smoothing_spline
from support.shared import shared_data

METHODS = {
    "linear": Linear(),
    "cubic": Cubic(),
    "quintic": Quintic(),
    "pattern": Pattern(),
    "rigid body": RigidBody(),
    "cyclic": Cyclic(),
    "relational": Relational(),
    "pca R1": PCA(strategy="R1"),
    "pca R2": PCA(),
    "pca alone": PCA(bridge_residuals=False),
    "low rank": LowRankKalman(),
}
OF_OTHERS = ["pattern", "rigid body", "relational", "pca R1", "pca R2", "pca alone", "low rank"]
every = pytest.mark.parametrize("name", METHODS)


def fill(name, motion, gaps, **parameters):
    method = replace(METHODS[name], **parameters)
    return filler_of(method)(motion, gaps, method=method)


def named(xyz, rate=100.0):
    return MarkerArray(np.asarray(xyz, float), rate, tuple(f"M{k}" for k in range(len(xyz))))


@cache
def body(markers=6, frames=400, noise=0.0):
    """One rigid body that turns and travels."""
    rng = np.random.default_rng(3)
    t = np.arange(frames) / 100
    turn = Rotation.from_rotvec(np.stack([np.sin(t), 0.5 * np.cos(1.7 * t), 0.8 * t], 1)).as_matrix()
    path = np.stack([1000 * t, 50 * np.sin(6 * t), 900 + 20 * np.cos(12 * t)], 1)
    shape = rng.normal(0, 80, (markers, 3))
    return named(np.einsum("fij,mj->mfi", turn, shape) + path + rng.normal(0, noise, (markers, frames, 3)))


@cache
def walker(noise=0.3, frames=500):
    """Four segments of four markers, whose motion repeats every 1.07 s while they travel."""
    rng = np.random.default_rng(5)
    t = np.arange(frames) / 100
    phase = 2 * np.pi * t / 1.07
    out = []
    for segment in range(4):
        swing = np.outer(np.sin(phase + segment), rng.normal(0, 0.3, 3)) + np.outer(
            np.sin(2 * phase), rng.normal(0, 0.1, 3)
        )
        turn = Rotation.from_rotvec(swing).as_matrix()
        centre = np.array([0, 150 * (segment % 2), 300 + 250 * segment]) + np.stack(
            [1200 * t, 20 * np.sin(phase), 15 * np.sin(2 * phase + segment)], 1
        )
        out += list(np.einsum("fij,mj->mfi", turn, rng.normal(0, 70, (4, 3))) + centre)
    return named(np.array(out) + rng.normal(0, noise, (16, frames, 3)))


def errors(motion, gaps, predictions):
    return [
        np.linalg.norm(p.xyz - motion.xyz[g.marker, g.start : g.stop], axis=1)
        for g, p in zip(gaps, predictions, strict=True)
    ]


@pytest.mark.parametrize("name", ["rigid body", "relational"])
def test_a_rigid_body_in_motion_is_filled_exactly(name):
    motion, gaps = body(), [Gap(2, 100, 250), Gap(0, 300, 340), Gap(5, 0, 30)]
    found = fill(name, motion.hidden(gaps), gaps)
    assert max(e.max() for e in errors(motion, gaps, found)) < 1e-6
    assert all(len(p.references) >= 3 and g.marker not in p.references for g, p in zip(gaps, found, strict=True))


def test_named_reference_marker_are_the_ones_used():
    motion, gap = walker(), Gap(1, 100, 160)
    hidden = motion.hidden([gap])
    assert fill("rigid body", hidden, [gap], reference_markers=("M0", "M2", "M3"))[0].references == (0, 2, 3)
    assert set(fill("relational", hidden, [gap], reference_markers=("M3", "M0", "M2"))[0].references) == {0, 2, 3}
    assert fill("pattern", hidden, [gap], reference_markers=("M9",))[0].references == (9,)


@pytest.mark.parametrize("name", ["pattern", "rigid body", "relational", "low rank", "pca R2"])
def test_reference_marker_are_those_of_the_own_segment(name):
    motion, gap = walker(), Gap(5, 200, 260)
    references = fill(name, motion.hidden([gap]), [gap])[0].references
    assert {4, 6, 7} & set(references)
    assert name in ("low rank", "pca R2") or set(references) <= {4, 6, 7}


@pytest.mark.parametrize(("name", "degree"), [("linear", 1), ("cubic", 3), ("quintic", 2)])
def test_a_polynomial_of_the_order_is_reproduced(name, degree):
    t = np.arange(120) / 100
    coefficients = np.random.default_rng(1).normal(0, 300, (2, degree + 1, 3))
    motion = named(np.einsum("fd,mdk->mfk", np.vander(t, degree + 1), coefficients))
    gaps = [Gap(0, 40, 80), Gap(1, 10, 12)]
    found = fill(name, motion.hidden(gaps), gaps)
    assert max(e.max() for e in errors(motion, gaps, found)) < 1e-5


def test_lagrange_weights_sum_to_one_and_are_unit_at_the_samples():
    known = np.array([3, 4, 20, 25])
    assert np.allclose(lagrange(known, np.arange(30)).sum(1), 1)
    assert np.allclose(lagrange(known, known), np.eye(4))


def test_a_pattern_with_a_drifting_offset_is_reproduced():
    rng = np.random.default_rng(2)
    reference = np.cumsum(rng.normal(0, 5, (200, 3)), 0)
    motion, gap = named([reference, reference + np.linspace([0, 50, 9], [70, 20, 9], 200)]), Gap(1, 60, 140)
    assert errors(motion, [gap], fill("pattern", motion.hidden([gap]), [gap]))[0].max() < 1e-9


@pytest.mark.parametrize("period", [100, 97.3])
def test_cyclic_motion_with_a_steady_walk_is_reproduced(period):
    phase = 2 * np.pi * np.arange(600) / period
    wave = np.stack([30 * np.sin(phase), 20 * np.cos(2 * phase), 40 * np.sin(phase + 1) ** 2], 1)
    walk = np.arange(600)[:, None] * np.array([9.0, 0, 0])
    motion, gaps = named([wave + walk, np.roll(wave, 30, 1) + walk]), [Gap(0, 250, 330), Gap(1, 20, 60)]
    found = fill("cyclic", motion.hidden(gaps), gaps)
    assert max(e.max() for e in errors(motion, gaps, found)) < (
        0.02 if period == 100 else 0.3
    )  # of 40 mm; between frames it is read linearly


def test_motion_without_a_cycle_is_left_to_others():
    motion, gap = named(np.cumsum(np.random.default_rng(4).normal(0, 3, (5, 400, 3)), 1)), Gap(0, 100, 150)
    assert "cycle" in fill("cyclic", motion.hidden([gap]), [gap], min_correlation=0.8)[0].reason


@pytest.mark.parametrize("name", ["pca R1", "pca R2", "pca alone", "low rank"])
def test_motion_of_low_rank_is_reproduced(name):
    rng = np.random.default_rng(6)
    t = np.arange(500) / 100
    scores = np.stack([np.sin(5 * t), np.cos(3 * t), np.sin(9 * t + 1)], 1)
    shape = rng.normal(0, 150, (10, 1, 3))
    motion = named(shape + np.einsum("fr,mrk->mfk", scores, rng.normal(0, 30, (10, 3, 3))))
    gaps = [Gap(2, 100, 250), Gap(7, 400, 460)]
    tight = {"tolerance": 1e-9} if name == "low rank" else {"component_share": 1 - 1e-9, "missing_weight": 1e-3}
    found = fill(name, motion.hidden(gaps), gaps, **tight)
    worst = max(e.max() for e in errors(motion, gaps, found))
    assert worst < (0.5 if name == "low rank" else 0.1)  # of an amplitude of 100 mm: g₀ and r are not 0


@every
def test_methods_turn_and_shift_with_the_laboratory(name):
    motion, gaps = walker(), [Gap(1, 100, 130), Gap(6, 100, 120), Gap(9, 300, 380)]
    R = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix()
    moved = motion._replace(xyz=motion.xyz @ R.T + [2000.0, -700.0, 300.0])
    here, there = (fill(name, m.hidden(gaps), gaps) for m in (motion, moved))
    for a, b in zip(here, there, strict=True):
        assert np.allclose(a.xyz @ R.T + [2000.0, -700.0, 300.0], b.xyz, atol=1e-3)
        assert np.allclose(R @ a.cov @ R.T, b.cov, rtol=1e-3, atol=1e-4, equal_nan=True)


@every
def test_the_covariance_is_least_at_the_edges_and_a_covariance(name):
    motion, gap = walker(), Gap(5, 200, 280)
    p = fill(name, motion.hidden([gap]), [gap])[0]
    assert not p.reason
    assert np.linalg.eigvalsh(p.cov).min() > -1e-6
    size = np.trace(p.cov, axis1=1, axis2=2)
    assert name == "pca alone" or (size[0] <= 1.001 * size[40] and size[-1] <= 1.001 * size[40])
    if name in ("linear", "cubic", "pattern", "relational"):
        assert size[0] < 0.1 * size[40]


@every
def test_a_gap_is_filled_the_same_alone_and_with_others(name):
    """Learning is shared among the gaps of a call; the answer is not."""
    motion, gaps = walker(), [Gap(1, 100, 130), Gap(1, 300, 330), Gap(6, 110, 120)]
    hidden = motion.hidden(gaps)
    together = fill(name, hidden, gaps)
    for gap, p in zip(gaps, together, strict=True):
        alone = fill(name, hidden, [gap])[0]
        assert np.allclose(alone.xyz, p.xyz, atol=1e-9) and np.allclose(alone.cov, p.cov, atol=1e-9, equal_nan=True)


@every
def test_hidden_samples_play_no_part(name):
    motion, gap = walker(), Gap(3, 200, 240)
    other = motion.xyz.copy()
    other[3, 200:240] += 500
    a, b = (fill(name, m.hidden([gap]), [gap])[0] for m in (motion, motion._replace(xyz=other)))
    assert np.array_equal(a.xyz, b.xyz)


@pytest.mark.parametrize("name", ["linear", "cubic", "pattern", "rigid body", "relational", "pca R2"])
def test_the_fill_joins_what_is_seen(name):
    motion, gap = walker(noise=0.0), Gap(5, 200, 260)
    filled = motion.hidden([gap]).xyz[5].copy()
    filled[200:260] = fill(name, motion.hidden([gap]), [gap])[0].xyz
    steps = np.linalg.norm(np.diff(filled, axis=0), axis=1)
    assert steps[[199, 259]].max() < 1.6 * steps[:190].max()


def degenerate():
    ordinary = walker().xyz
    nan = np.nan * ordinary
    one = nan[:4].copy()
    one[0, [0, 40]] = 5.0
    spikes = ordinary[:6].copy()
    spikes[1, ::7] = 1e9
    spikes[2] = -1e9
    early = ordinary[:5].copy()
    early[:, 100:110] = np.nan
    alternate = ordinary[:5].copy()
    alternate[0, 1::2] = np.nan
    return {
        "two markers only": ordinary[:2],
        "no reference markers": ordinary[:1],
        "one frame": ordinary[:4, :1],
        "two frames": ordinary[:4, :2],
        "three frames": ordinary[:4, :3],
        "everything missing": nan[:4],
        "two samples in all": one,
        "constant": np.broadcast_to(ordinary[:4, :1], (4, 100, 3)),
        "one place": np.zeros((4, 100, 3)),
        "on a line": np.arange(4)[:, None, None] * np.ones(3) * 40 + ordinary[:1, :100],
        "spikes of 1e9": spikes,
        "1e200": np.full((4, 60, 3), 1e200),
        "all missing at once": early,
        "never seen in two frames running": alternate,
    }


@every
@pytest.mark.parametrize("case", degenerate())
@pytest.mark.parametrize("place", ["inside", "start", "end", "whole"])
def test_degenerate_input_gives_values_or_a_reason(name, case, place):
    """Never an exception, never a NaN without a reason; warnings are errors here."""
    motion = named(degenerate()[case])
    F = motion.xyz.shape[1]
    start, stop = {"inside": (F // 4, F // 2), "start": (0, F // 3), "end": (2 * F // 3, F), "whole": (0, F)}[place]
    gap = Gap(0, start, max(stop, start + 1))
    for p in fill(name, motion.hidden([gap]), [gap]):
        assert p.xyz.shape == (gap.length, 3) and p.cov.shape == (gap.length, 3, 3)
        assert bool(p.reason) == np.isnan(p.xyz).any()
        assert not np.isinf(p.xyz).any() and not np.isinf(p.cov).any()
        assert np.isnan(p.xyz).all() or np.nanmax(np.abs(p.xyz)) < 1e7


@every
def test_no_gaps_no_predictions(name):
    assert fill(name, walker(), []) == []


@pytest.mark.parametrize("name", OF_OTHERS)
def test_neighbours_that_come_and_go_in_the_gap(name):
    motion = walker()
    gaps = [Gap(5, 200, 280), Gap(4, 190, 230), Gap(6, 225, 290), Gap(7, 100, 201), Gap(0, 270, 280)]
    p = fill(name, motion.hidden(gaps), [gaps[0]])[0]
    assert p.reason or np.median(errors(motion, gaps[:1], [p])[0]) < 60


@pytest.mark.parametrize(
    ("method", "wrong"),
    [
        (Cubic, {"margin": 0}),
        (Quintic, {"margin": -1}),
        (RigidBody, {"reference_markers": ("A", "B")}),
        (RigidBody, {"most_markers": 2}),
        (Relational, {"reference_markers": ("A", "B", "A")}),
        (Cyclic, {"most_cycles": 0}),
        (PCA, {"strategy": "R3"}),
        (PCA, {"component_share": 1.5}),
        (LowRankKalman, {"tolerance": 1.0}),
    ],
)
def test_impossible_parameters_are_refused(method, wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        method(**wrong)


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("pattern", {"reference_markers": ("X",)}),
        ("rigid body", {"reference_markers": ("X", "M1", "M2")}),
        ("relational", {"reference_markers": ("X", "M1", "M2")}),
    ],
)
def test_a_reference_marker_that_is_not_there_is_the_callers_mistake(name, parameters):
    with pytest.raises(ValueError, match="X"):
        fill(name, walker(), [Gap(0, 10, 20)], **parameters)


def test_a_static_shape_serves_where_the_trial_does_not_show_the_body():
    motion = body()
    static = StaticShape.of(motion._replace(xyz=motion.xyz[:, :1] @ Rotation.from_rotvec([0, 0, 1]).as_matrix().T))
    gap, rest = (
        Gap(2, 100, 200),
        [Gap(2, 0, 100), Gap(0, 200, 400), Gap(1, 200, 400), Gap(3, 200, 400), Gap(4, 200, 400)],
    )
    hidden = motion.hidden([gap, *rest])
    assert fill("rigid body", hidden, [gap])[0].reason
    p = fill("rigid body", hidden, [gap], static=static)[0]
    assert errors(motion, [gap], [p])[0].max() < 1e-6


def test_nearest_rotations_are_those_of_the_singular_value_decomposition():
    rng = np.random.default_rng(0)
    H = rng.normal(size=(50, 3, 3))
    H[:20] = rng.normal(size=(20, 3, 2)) @ rng.normal(size=(20, 2, 3))  # flat shapes
    U, _, Vt = np.linalg.svd(H)
    sign = np.sign(np.linalg.det(U @ Vt))
    U[..., 2] *= sign[:, None]
    assert np.allclose(nearest_rotations(H), U @ Vt, atol=1e-6)
    assert np.isnan(nearest_rotations(np.zeros((3, 3)))).all()


def test_the_spline_finds_the_noise_and_its_own_error():
    """Over many simulated curves the noise is found, and errors are as large as stated."""
    rng = np.random.default_rng(8)
    t, at = np.arange(60.0), np.arange(0.5, 59, 3)
    z2, sigma = [], []
    for _ in range(60):
        a, b = rng.uniform(0.05, 0.2, 2)
        f = [lambda s, a=a, b=b, k=k: 30 * np.sin(a * s + k) + 10 * np.cos(b * s) for k in range(3)]
        y = np.stack([g(t) for g in f], 1) + rng.normal(0, 0.5, (60, 3))
        s = smoothing_spline(t, y, at)
        z2.append(((s.values - np.stack([g(at) for g in f], 1)) ** 2).mean(1) / s.variance)
        sigma.append(s.noise)
    assert np.median(sigma) == pytest.approx(0.5, rel=0.1)
    assert 0.6 < np.mean(z2) < 1.4


def test_the_spline_without_smoothing_passes_through_its_samples():
    t = np.array([0.0, 1, 2, 5, 6, 8, 9])
    y = np.random.default_rng(1).normal(size=(7, 2))
    assert np.allclose(smoothing_spline(t, y, t, smoothing=1e-13).values, y, atol=1e-6)
    with pytest.raises(ValueError, match="3 samples"):
        smoothing_spline(t[:3], y[:3], t)


@pytest.mark.parametrize("sides", [(True, True), (True, False), (False, True)])
def test_the_closed_form_is_the_kalman_smoother(sides):
    """Against the Gaussian posterior of all frames at once, from the inverse of its information matrix."""
    rng = np.random.default_rng(0)
    L, information = 12, np.array([0.0, 0.3, 7.0])
    i, before, after = rng.normal(size=(L, 3)), rng.normal(size=3), rng.normal(size=3)
    u, variance = solve(information, i, before if sides[0] else None, after if sides[1] else None)
    for k, lam in enumerate(information):
        A = (2 + lam) * np.eye(L) - np.eye(L, k=1) - np.eye(L, k=-1)
        A[0, 0] -= not sides[0]
        A[-1, -1] -= not sides[1]
        rhs = i[:, k].copy()
        rhs[0] += sides[0] * before[k]
        rhs[-1] += sides[1] * after[k]
        assert np.allclose(u[:, k], np.linalg.solve(A, rhs), atol=1e-8)
        assert np.allclose(variance[:, k], np.diag(np.linalg.inv(A)), rtol=1e-4)


def test_a_real_walk_is_filled_to_a_few_millimetres():
    """Hidden gaps of 1 s, raw data with measured residuals; the bounds are the field's best known figures."""
    trial = read_c3d(shared_data("mocap3d/qualisys_gait/Gait - CGM2 1.c3d")).trajectories
    motion = MarkerArray.of(getattr(trial, "trajectories", trial))
    rng = np.random.default_rng(1)
    whole = np.flatnonzero(motion.seen.all(1))
    gaps = [Gap(int(rng.choice(whole)), s, s + 100) for s in (int(rng.integers(5, 235)) for _ in range(30))]
    median = {}
    for name in ("cubic", "pattern", "rigid body", "pca R2"):
        each = [errors(motion, [g], fill(name, motion.hidden([g]), [g]))[0].mean() for g in gaps]
        median[name] = np.median(each)
    assert median["pca R2"] < 4.3 and median["rigid body"] < 10 and median["pattern"] < 45
    assert median["pca R2"] < median["rigid body"] < median["pattern"] < median["cubic"]


def test_all_gaps_of_a_trial_with_gaps_are_answered():
    motion = MarkerArray.of(read_c3d(shared_data("mocap3d/arm_box_lift_gaps/Vicon.c3d")).trajectories)
    gaps = find_gaps(motion)
    for name in METHODS:
        assert all(p.reason or not np.isnan(p.xyz).any() for p in fill(name, motion, gaps))
