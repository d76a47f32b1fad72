"""Bundle adjustment: derivatives, optimum and covariance against independent ones."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from kinemark.calibrate.bundle import Bundle, Freedom, FreePoints, KnownPoints, Sticks, bundle, sticks_through
from kinemark.calibrate.bundle.adjust import BundleFit, check_calibration, observed
from kinemark.calibrate.bundle.lens_prior import LensPrior
from kinemark.calibrate.bundle.misfit import Misfit
from kinemark.calibrate.bundle.parts import all_points, slices
from kinemark.calibrate.bundle.robust_points import robust_points
from kinemark.calibrate.bundle.solver import BundleState, cost, normal_equations, solve
from kinemark.calibrate.world_frame import fit_moved_to
from kinemark.data import Rig
from kinemark.geometry import project, project_all
from kinemark.numerics.schur import block_inverses, schur_complement
from kinemark.synth import ring
from support.waved import ALONG, MIDDLE, benchmark, waved


def small_state():
    """Three cameras, some of all kinds of parts, and noisy pixels of them."""
    rng = np.random.default_rng(0)
    rig = ring(3, distortion=(-0.1, 0.05, 1e-3, -1e-3, 0.01))
    ahead = rng.normal(size=(4, 3))
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    at = MIDDLE + 300 * rng.normal(size=(11, 3))
    parts = (
        Sticks(at[:4], ahead, np.array([-200.0, 0.0, 300.0])),
        FreePoints(at[4:7]),
        FreePoints(at[7:9], at[7:9] + rng.normal(size=(2, 3)), np.tile(np.eye(3) / 4, (2, 1, 1))),
        KnownPoints(at[9:]),
    )
    uv = np.stack([project(camera, all_points(parts)) for camera in rig]) + rng.normal(size=(3, 19, 2))
    uv[0, 3] = uv[2, 13] = np.nan
    cov = np.einsum("...ij,...kj->...ik", *(2 * [np.eye(2) + 0.3 * rng.normal(size=(3, 19, 2, 2))]))
    return BundleState(rig.cameras, parts), observed(uv, cov)


FREEDOMS = (
    Freedom(np.ones(15, bool), square=False, prior=LensPrior.of(np.ones(6, bool), np.zeros(6, bool)).weighed(1e-2)),
    Freedom(np.arange(15) != 6, square=True),
    Freedom(np.isin(np.arange(15), [0, 1, 9, 10, 11, 12, 13, 14]), square=True, lens_in_pixels=True),
)


def shifted(state, c, q, p, k):
    """The state with camera c or part p moved along its k-th unknown by q."""
    if c is not None:
        step = np.zeros(FREEDOMS[c].columns(state.cameras[c]).shape[1])
        step[k] = q
        cameras = list(state.cameras)
        cameras[c] = FREEDOMS[c].moved(cameras[c], step)
        return state._replace(cameras=tuple(cameras))
    parts, part = list(state.parts), state.parts[p]
    step = np.zeros(len(part.xyz) * part.degrees)
    step[k] = q
    parts[p] = part.moved(step.reshape(len(part.xyz), part.degrees))
    return state._replace(parts=tuple(parts))


@pytest.mark.parametrize("soft", [None, 1.5])
def test_the_derivatives_are_those_of_differences(soft):
    """Of the cost by every camera parameter and every coordinate of every piece: −2 g and −2 h."""
    state, seen = small_state()
    normal = normal_equations(state, seen, FREEDOMS, soft=soft)

    def slope(step, c=None, p=None, k=0):
        up, down = (cost(shifted(state, c, sign * step, p, k), seen, FREEDOMS, soft) for sign in (1, -1))
        return -(up - down) / (4 * step)

    at = 0
    for c, freedom in enumerate(FREEDOMS):
        columns = freedom.columns(state.cameras[c])
        size = 1e-4 / np.sqrt(np.diag(normal.U)[at : at + columns.shape[1]])
        found = [slope(s, c=c, k=k) for k, s in enumerate(size)]
        scale = np.sqrt(np.diag(normal.U)[at : at + len(found)])
        assert np.allclose(found / scale, normal.g[at : at + len(found)] / scale, atol=1e-4), c
        at += len(found)
    for p, h in enumerate(normal.h):
        found = [slope(1e-5, p=p, k=k) for k in range(h.size)]
        assert np.allclose(found, h.ravel(), rtol=1e-4, atol=1e-3), p


def test_the_schur_complement_solves_the_whole_system():
    state, seen = small_state()
    normal = normal_equations(state, seen, FREEDOMS)
    inverses = [block_inverses(V, 1e-3) for V in normal.V]
    S, b = schur_complement(normal, inverses, 1e-3)
    q = len(normal.g)
    n = q + sum(h.size for h in normal.h)
    A, right, at = np.zeros((n, n)), np.zeros(n), q
    A[:q, :q], right[:q] = normal.U, normal.g
    for V, W, h in zip(normal.V, normal.W, normal.h, strict=True):
        for piece in range(len(h)):
            rows = slice(at, at + h.shape[1])
            A[rows, rows], A[rows, :q], A[:q, rows] = V[piece], W[piece], W[piece].T
            right[rows] = h[piece]
            at += h.shape[1]
    A += 1e-3 * np.diag(np.diag(A))
    whole = np.linalg.solve(A, right)[:q]
    scale = np.sqrt(np.diag(normal.U))
    assert np.allclose(np.linalg.solve(S, b) * scale, whole * scale, atol=1e-6)


def test_the_optimum_is_that_of_another_program():
    """SciPy's least squares (MINPACK) from the same disturbed start, with the benchmark's derivatives, ends as low."""
    rig = ring(3, distortion=(-0.1, 0.05, 0, 0, 0))
    scene = waved(rig, 12, noise=0.3)
    begun, sticks = benchmark.disturbed(rig, scene.xyz, np.random.default_rng(1))
    uv, freedom = scene.uv.reshape(3, -1, 2), Bundle(radial=1, principal_point=False, usual_lens=False).freedom
    ours = solve(BundleState(begun.cameras, (sticks,)), observed(uv, None), (freedom,) * 3)
    rival = benchmark.Rival(begun, sticks, uv, freedom)
    start = np.zeros(3 * rival.q + 5 * 12)
    theirs = least_squares(rival.residual, start, jac=lambda x: rival.jacobian(x).toarray(), method="lm", x_scale="jac")
    assert cost(ours, observed(uv, None), (freedom,) * 3) == pytest.approx(2 * theirs.cost, rel=1e-5)


def test_the_rival_has_the_right_derivatives():
    """Far from its start, where turns are no longer small; else the comparison would be unfair."""
    rig = ring(2, distortion=(-0.1, 0.05, 0, 0, 0))
    scene = waved(rig, 3)
    begun, sticks = benchmark.disturbed(rig, scene.xyz, np.random.default_rng(1))
    rival = benchmark.Rival(begun, sticks, scene.uv.reshape(2, -1, 2), Bundle(usual_lens=False).freedom)
    x = np.zeros(2 * rival.q + 15)
    x[: 2 * rival.q] = np.tile([5, 1, 1, 0.01, 0.01, 0.2, 0.1, -0.3, 10, 5, 3], 2)
    x[2 * rival.q :] = 0.05 * np.random.default_rng(0).normal(size=15)
    steps = 1e-5 * np.eye(len(x))
    slopes = np.column_stack([rival.residual(x + h) - rival.residual(x - h) for h in steps]) / 2e-5
    size = np.abs(slopes).max(0)
    assert np.abs((rival.jacobian(x).toarray() - slopes) / size).max() < 1e-6


def errors(true, found):
    """All parameters of the found rig less the true ones (15 C)."""
    parts = []
    for a, b in zip(true, found, strict=True):
        turn = Rotation.from_matrix(b.R @ a.R.T).as_rotvec()
        inner = [b.K[0, 0] - a.K[0, 0], b.K[1, 1] - a.K[1, 1], *(b.K[:2, 2] - a.K[:2, 2])]
        parts.append(np.concatenate([inner, b.distortion - a.distortion, turn, b.t - a.t]))
    return np.concatenate(parts)


def normalised_square(off, cov, rank):
    """offᵀ cov⁺ off / rank, in the directions in which there is an error at all."""
    sd = np.sqrt(np.diag(cov))
    free = sd > 0
    values, vectors = np.linalg.eigh(cov[np.ix_(free, free)] / np.outer(sd[free], sd[free]))
    seen = vectors[:, -rank:].T @ (off[free] / sd[free])
    return float((seen**2 / values[-rank:]).sum() / rank)


def test_the_joint_covariance_is_true():
    """Errors of all cameras together, laid on the true points, over their covariance: χ² / n is 1 on average."""
    rig = ring(3, distortion=(-0.1, 0.02, 0, 0, 0), focal_px=1000.0)
    xyz, clean, _ = waved(rig, 60, noise=0.0, seed=3)
    parts = (sticks_through(xyz, np.asarray(ALONG)),)
    method, squares, rank = Bundle(usual_lens=False), [], 3 * 11 - 6
    for seed in range(8):
        uv = clean + 0.1 * np.random.default_rng(seed).normal(size=clean.shape)
        fit = bundle(rig, parts, uv.reshape(3, -1, 2), method=method)
        there = np.isfinite(fit.xyz).all(1)
        fit = fit_moved_to(fit, fit.xyz, np.where(there[:, None], xyz.reshape(-1, 3), np.nan))
        squares.append(normalised_square(errors(rig, fit.rig), fit.joint, rank))
    assert abs(np.mean(squares) - 1) < 4 * np.sqrt(2 / (8 * rank))


def test_covariances_need_be_right_in_proportion_only():
    rig = ring(3)
    xyz, uv, _ = waved(rig, 40)
    uv, parts = uv.reshape(3, -1, 2), (sticks_through(xyz, np.asarray(ALONG)),)
    one = bundle(rig, parts, uv, cov=np.broadcast_to(np.eye(2), (*uv.shape, 2)))
    other = bundle(rig, parts, uv, cov=np.broadcast_to(0.01 * np.eye(2), (*uv.shape, 2)))
    assert np.allclose(one.joint, other.joint, rtol=1e-3, atol=1e-12)
    assert other.chi2 / other.freedom == pytest.approx(1, abs=0.25)
    noisy = uv.copy()
    noisy[0] += 3 * np.random.default_rng(1).normal(size=noisy[0].shape)
    cov = np.broadcast_to(0.01 * np.eye(2), (*uv.shape, 2)).copy()
    cov[0] = 9.0 * np.eye(2)
    weighed, plain = (bundle(rig, parts, noisy, cov=c, method=Bundle(reject=np.inf)) for c in (cov, None))
    off = [np.linalg.norm(fit.xyz - xyz.reshape(-1, 3), axis=1).mean() for fit in (weighed, plain)]
    assert off[0] < 0.7 * off[1]


def test_what_is_held_stays_and_known_points_fix_the_world():
    rig = ring(4)
    rng = np.random.default_rng(0)
    at = MIDDLE + rng.uniform(-700, 700, (60, 3))
    uv = np.stack([project(camera, at) for camera in rig]) + 0.1 * rng.normal(size=(4, 60, 2))
    begun = Rig((rig[0], *(replace(c, t=c.t + rng.normal(size=3) * 20) for c in rig.cameras[1:])))
    pose = Freedom(np.arange(15) >= 9)
    held = bundle(begun, (FreePoints(at),), uv, freedoms=[Freedom(np.zeros(15, bool)), pose, pose, pose])
    assert np.array_equal(held.rig[0].P, rig[0].P)
    assert not held.joint[:15].any()
    surveyed = at[:8] + 2.0 * rng.normal(size=(8, 3))
    known = bundle(
        begun,
        (
            KnownPoints(at[:0]),
            FreePoints(surveyed, surveyed, np.tile(np.eye(3) / 4 * 0.01, (8, 1, 1))),
            FreePoints(at[8:]),
        ),
        uv,
        freedoms=[pose] * 4,
    )
    exact = bundle(begun, (KnownPoints(at[:8]), FreePoints(at[8:])), uv, freedoms=[pose] * 4)
    assert np.abs(exact.rig.centres - rig.centres).max() < 3
    assert np.abs(known.rig.centres - rig.centres).max() < 15
    assert (np.diag(exact.joint)[9:15] > 0).all()  # nothing is free to move as a whole, so all have an error


def test_parts_know_their_own_points():
    state, _ = small_state()
    assert [at.stop - at.start for at in slices(state.parts)] == [12, 3, 2, 2]
    sticks = state.parts[0]
    again = sticks_through(sticks.xyz, sticks.along)
    assert np.allclose(again.xyz, sticks.xyz)
    seen = sticks.xyz.copy()
    seen[0, 1], seen[1, 1:] = np.nan, np.nan
    found = sticks_through(seen, sticks.along).xyz
    assert np.allclose(found[0], sticks.xyz[0])  # two markers make a stick
    assert np.isnan(found[1]).all()


def test_points_are_placed_by_the_cameras_that_agree():
    rig, rng = ring(4, distortion=(-0.1, 0, 0, 0, 0)), np.random.default_rng(0)
    xyz = MIDDLE + 500 * rng.normal(size=(60, 3))
    uv = np.stack([project(camera, xyz) for camera in rig])
    uv[rng.integers(4, size=60), np.arange(60)] += 40 * rng.choice([-1, 1], (60, 2))
    assert np.abs(robust_points(rig, uv, limit=5.0) - xyz).max() < 1e-3
    uv[:2] = np.nan  # two cameras are left, and where one of them is wrong they disagree
    found, agreed = robust_points(rig, uv, limit=5.0), np.abs(uv - project_all(rig, xyz))[2:].max((0, 2)) < 1
    assert agreed.any()
    assert np.allclose(found[agreed], xyz[agreed], atol=1e-3)
    assert np.isnan(found[~agreed]).all(1).mean() > 0.8  # else wrong along the other one's epipolar line


@pytest.mark.parametrize(
    "shared, words",
    [(12, "Cameras cam2 and cam3 share 12 poses only.* wave more where both"), (60, "^Camera cam4 does not")],
)
def test_cameras_that_few_poses_join_are_named_where_one_does_not_fit(shared, words):
    rig = Rig(tuple(replace(camera, residual=0.1) for camera in ring(4)))
    frame = np.arange(300)
    seen = np.array([frame < 120, frame < 120 + shared, frame >= 120, frame >= 120])
    kept = seen & (np.arange(4) < 3)[:, None]
    fit = BundleFit(rig, np.ones((300, 3)), np.zeros((4, 300, 2)), kept, np.zeros((60, 60)), 1.0, 1)
    with pytest.raises(Misfit, match=words) as error:
        check_calibration(fit, seen, frame)
    assert ("wave more" in str(error.value)) == (shared < 40)


def test_a_fit_of_which_no_covariance_follows_is_refused(monkeypatch):
    """Of images that fit nothing its numbers may overflow."""
    rig = ring(3)
    xyz = MIDDLE + np.random.default_rng(0).uniform(-500, 500, (40, 3))
    overflown = (np.full((45, 45), np.inf), 0)
    monkeypatch.setattr("kinemark.calibrate.bundle.adjust.joint_covariance", lambda *_: overflown)
    with pytest.raises(Misfit, match="fits each other so badly"):
        bundle(rig, (FreePoints(xyz),), project_all(rig, xyz), method=Bundle(usual_lens=False))
