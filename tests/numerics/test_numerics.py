"""What is solved in many places: each law beside the plain way of NumPy or SciPy."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import least_squares

from kinemark.numerics.evenly import evenly, evenly_rounded
from kinemark.numerics.finite import finite_mean, finite_median
from kinemark.numerics.levenberg_marquardt import NIELSEN, Damping, Iterates, damped_step, minimise, minimise_many
from kinemark.numerics.robust import (
    MEDIAN_OF_NORMAL,
    SD_PER_MEDIAN,
    cauchy_loss,
    cauchy_weight,
    plane_scale,
    student_log_likelihood,
    student_widening,
)
from kinemark.numerics.row_quantiles import row_medians, row_quantiles
from kinemark.numerics.runs import begins, equal_runs, true_runs, true_runs_of_rows
from kinemark.numerics.scaled import scaled_inverse, scaled_solution
from kinemark.numerics.schur import BlockEquations, block_inverses, block_step, schur_complement
from kinemark.numerics.small_matrices import inverse2, inverse3, solve3
from kinemark.numerics.vectors import across, cross, cross_matrix, lengths, perpendicular_pair

T = np.linspace(0, 2, 40)


# ---- Levenberg–Marquardt ----


def decay(p):
    """Values (…, 40) of p0 exp(−p1 t) + p2, and their derivatives (…, 40, 3)."""
    a, b, c = np.moveaxis(np.asarray(p)[..., None], -2, 0)
    e = np.exp(np.minimum(-b * T, 100.0))  # tries may go far
    return a * e + c, np.stack([e, -a * T * e, np.ones_like(e)], -1)


class Decay(NamedTuple):
    """One curve fitted to data (40), for `minimise`; tries with a rate above `most` are impossible."""

    data: np.ndarray
    most: float = 50.0

    def cost(self, p):
        return float(((self.data - decay(p)[0]) ** 2).sum()) if abs(p[1]) < self.most else np.inf

    def equations(self, p):
        value, J = decay(p)
        return J.T @ J, J.T @ (self.data - value)

    def step(self, p, equations, damping):
        step, predicted = damped_step(*equations, damping)
        return (p + step if abs(p[1] + step[1]) < self.most else None), predicted


class Decays(NamedTuple):
    """Many of them (n, 40), for `minimise_many`."""

    data: np.ndarray

    def at(self, p, which):
        value, J = decay(p)
        off = self.data[which] - value
        return Iterates(p, (off**2).sum(1), (off, J))

    def step(self, which, now, damping):
        off, J = now.equations
        A, g = J.mT @ J, (J.mT @ off[..., None])[..., 0]
        D = np.einsum("nii->ni", A)
        step = np.linalg.solve(A + (damping[:, None] * D)[..., None] * np.eye(3), g[..., None])[..., 0]
        return self.at(now.parameters + step, which), (step * (g + damping[:, None] * D * step)).sum(1)

    def converged(self, which, now, tried):
        return now.cost - tried.cost <= 1e-14 * now.cost


def curves(n, seed=0):
    rng = np.random.default_rng(seed)
    truth = rng.uniform([1, 0.5, -1], [4, 3, 1], (n, 3))
    return decay(truth)[0] + 0.05 * rng.normal(size=(n, len(T)))


START = np.array([1.0, 0.2, 0.0])
DAMPINGS = pytest.mark.parametrize(
    "damping", [NIELSEN, Damping(1e-3, fixed=(0.2, 10.0)), Damping(fixed=(0.1, 10.0), hold=True)]
)


@DAMPINGS
@pytest.mark.parametrize("data", curves(8))
def test_one_problem_ends_where_scipy_does(data, damping):
    theirs = least_squares(lambda p: data - decay(p)[0], START, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    ours = minimise(Decay(data), START, steps=100, relative=1e-14, damping=damping)
    assert Decay(data).cost(ours) <= 2 * theirs.cost * (1 + 1e-9)
    assert ours == pytest.approx(theirs.x, rel=1e-5)


@DAMPINGS
def test_many_problems_end_where_each_does_alone(damping):
    data = curves(50, seed=1)
    many = Decays(data)
    found = minimise_many(many, many.at(np.tile(START, (50, 1)), np.arange(50)), steps=100, damping=damping)
    alone = [minimise(Decay(one), START, steps=100, relative=1e-14, damping=damping) for one in data]
    assert found.cost == pytest.approx([Decay(one).cost(p) for one, p in zip(data, alone, strict=True)], rel=1e-9)
    assert found.parameters == pytest.approx(np.array(alone), rel=1e-4)


def test_the_unit_of_a_parameter_changes_nothing():
    data = curves(1)[0]
    unit = np.array([1e6, 1.0, 1e-4])

    class Other(Decay):
        def cost(self, p):
            return Decay(self.data).cost(p * unit)

        def equations(self, p):
            A, g = Decay(self.data).equations(p * unit)
            return A * unit * unit[:, None], g * unit

        def step(self, p, equations, damping):
            step, predicted = damped_step(*equations, damping)
            return p + step, predicted

    for steps in (1, 3, 50):
        other = minimise(Other(data), START / unit, steps=steps)
        assert other * unit == pytest.approx(minimise(Decay(data), START, steps=steps), rel=1e-6)


@DAMPINGS
def test_the_cost_never_rises_and_an_impossible_start_is_left(damping):
    problem, p = Decay(curves(1)[0]), np.array([30.0, -3.0, 20.0])
    costs = [problem.cost(minimise(problem, p, steps=n, damping=damping)) for n in range(12)]
    assert (np.diff(costs) <= 0).all() and costs[-1] < 1e-3 * costs[0]
    nowhere = np.array([1.0, 60.0, 0.0])
    assert minimise(problem, nowhere, steps=5, damping=damping) is nowhere


def test_fixed_factors_change_the_damping_as_they_say():
    eager, held = (Damping(1.0, fixed=(0.1, 10.0), hold=hold) for hold in (False, True))
    found = []
    for damping in (eager, held):
        values = []
        for decrease in (1.0, -1.0, -1.0, 1.0, 1.0):
            damping = damping.after(decrease, 1.0)
            values.append(float(damping.value))
        found.append(values)
    assert found[0] == pytest.approx([0.1, 1, 10, 1, 0.1])
    assert found[1] == pytest.approx([0.1, 1, 10, 10, 1])
    many = held.of_many(3).after(np.array([1.0, -1.0, -1.0]), np.ones(3))
    assert many.take(np.array([False, True, True])).after(np.array([1.0, -1.0]), 1.0).value == pytest.approx([10, 100])


def test_nielsens_damping_follows_the_predicted_decrease():
    assert [
        float(NIELSEN.after(decrease, 1.0).value / NIELSEN.value) for decrease in (1.0, 0.75, 0.5, 0.0)
    ] == pytest.approx([0.1, 0.875, 1, 2])
    failed = NIELSEN.after(-1.0, 1.0)
    assert float(failed.after(-1.0, 1.0).value / NIELSEN.value) == pytest.approx(8)


def test_a_step_out_of_bounds_is_only_a_failed_try():
    data = curves(1)[0]
    free, bound = (minimise(Decay(data, most), START, steps=200, relative=1e-14) for most in (50.0, 2 * START[1]))
    assert abs(bound[1]) <= 2 * START[1] < abs(free[1])
    assert Decay(data).cost(bound) < Decay(data).cost(START)


def test_what_a_step_promises_a_quadratic_keeps():
    rng = np.random.default_rng(0)
    J, r = rng.normal(size=(20, 4)), rng.normal(size=20)
    for damping in (0.0, 0.1, 10.0):
        step, predicted = damped_step(J.T @ J, J.T @ r, damping)
        assert (r**2).sum() - ((r - J @ step) ** 2).sum() == pytest.approx(predicted, rel=1e-12)


# ---- Schur complement ----


def blocks(seed=0, n=7, D=3, Q=5):
    """Equations with blocks, and the same as one dense J (rows, Q + n D) and r."""
    rng = np.random.default_rng(seed)
    A, B, r = rng.normal(size=(n, 12, Q)), rng.normal(size=(n, 12, D)), rng.normal(size=(n, 12))
    J = np.zeros((n, 12, Q + n * D))
    J[..., :Q] = A
    for k in range(n):
        J[k, :, Q + D * k : Q + D * k + D] = B[k]
    V, W, h = B.mT @ B, B.mT @ A, (B.mT @ r[..., None])[..., 0]
    U, g = (A.mT @ A).sum(0), (A.mT @ r[..., None]).sum(0)[:, 0]
    return BlockEquations(U, g, [V[:3], V[3:]], [W[:3], W[3:]], [h[:3], h[3:]]), J.reshape(n * 12, -1), r.ravel()


@pytest.mark.parametrize("damping", [0.0, 1e-3, 5.0])
def test_blocks_give_the_step_of_the_whole(damping):
    equations, J, r = blocks()
    whole, predicted = damped_step(J.T @ J, J.T @ r, damping)
    delta, epsilon, mine = block_step(equations, damping)
    assert np.concatenate([delta, *(e.ravel() for e in epsilon)]) == pytest.approx(whole, rel=1e-9)
    assert mine == pytest.approx(predicted, rel=1e-10)


def test_the_schur_complement_inverts_to_the_covariance_of_what_is_shared():
    equations, J, _ = blocks()
    S, _ = schur_complement(equations, [block_inverses(V) for V in equations.V])
    assert np.linalg.inv(S) == pytest.approx(np.linalg.inv(J.T @ J)[:5, :5], rel=1e-8)


def test_a_block_that_nobody_sees_stays_where_it_is():
    equations, _, _ = blocks()
    for part in (equations.V, equations.W, equations.h):
        part[0][1] = 0.0
    _, epsilon, _ = block_step(equations, 1e-4)
    assert (epsilon[0][1] == 0).all() and (epsilon[0][0] != 0).all()


# ---- Matrices and vectors ----


def positive(n, *batch, seed=0):
    A = np.random.default_rng(seed).normal(size=(*batch, n, n))
    return A @ A.mT + 0.1 * np.eye(n)


def test_small_systems_are_those_of_lapack():
    A3, b3 = positive(3, 30), np.random.default_rng(1).normal(size=(30, 3))
    A2 = np.random.default_rng(2).normal(size=(30, 2, 2))
    x3 = np.linalg.solve(A3, b3[..., None])[..., 0]
    assert inverse3(A3) == pytest.approx(np.linalg.inv(A3), rel=1e-8)
    assert solve3(A3, b3) == pytest.approx(x3, rel=1e-8)
    assert inverse2(A2) == pytest.approx(np.linalg.inv(A2), rel=1e-8)


def test_singular_systems_have_no_solution():
    A = np.ones((2, 3, 3))
    A[1] = np.eye(3)
    assert np.isnan(inverse3(A)[0]).all() and np.isnan(solve3(A, np.ones((2, 3)))[0]).all()
    assert (inverse3(A)[1] == np.eye(3)).all()


def test_scaled_solutions_do_not_mind_units():
    A, b = positive(6), np.arange(6.0)
    unit = 10.0 ** np.arange(-12, 12, 4)
    scaled = A * unit * unit[:, None]
    assert scaled_solution(scaled, b * unit) * unit == pytest.approx(np.linalg.solve(A, b), rel=1e-8)
    assert scaled_inverse(scaled) * unit * unit[:, None] == pytest.approx(np.linalg.inv(A), rel=1e-8)
    empty = A.copy()
    empty[2] = empty[:, 2] = 0.0
    assert scaled_inverse(empty)[2] == pytest.approx(np.zeros(6), abs=1e-12)
    assert scaled_solution(empty, np.where(np.arange(6) == 2, 0.0, b))[2] == pytest.approx(0.0, abs=1e-12)


def test_vectors_across():
    a, b = np.random.default_rng(0).normal(size=(2, 20, 3))
    assert cross(a, b) == pytest.approx(np.cross(a, b))
    assert (cross_matrix(a) @ b[..., None])[..., 0] == pytest.approx(np.cross(a, b))
    ahead = a / np.linalg.norm(a, axis=1, keepdims=True)
    base = np.concatenate([ahead[..., None], perpendicular_pair(ahead)], -1)
    assert base.mT @ base == pytest.approx(np.tile(np.eye(3), (20, 1, 1)), abs=1e-12)


# ---- Robust weights ----


def test_the_weight_is_the_slope_of_the_loss():
    squared = np.geomspace(1e-3, 1e4, 50)
    step = 1e-6 * squared
    for c in (0.5, 2.5):
        slope = (cauchy_loss(squared + step, c) - cauchy_loss(squared - step, c)) / (2 * step)
        assert cauchy_weight(squared, c) == pytest.approx(slope, rel=1e-6)
    assert cauchy_loss(squared, 1e6) == pytest.approx(squared, rel=1e-6)  # of no errors that are wrong


def test_students_widening_is_the_slope_of_its_likelihood():
    squared, step = np.geomspace(1e-2, 1e3, 30), 1e-6
    for tails, k in ((4.0, 2), (1.0, 3)):
        up, down = (student_log_likelihood(squared + s, tails, np.float64(k)) for s in (step, -step))
        assert 1 / student_widening(squared, tails, k) == pytest.approx(-2 * (up - down) / (2 * step), rel=1e-4)
    assert student_widening(np.array([3.0]), 1e9) == pytest.approx(1.0)


def test_scales_are_those_of_the_normal_distribution():
    x = np.random.default_rng(0).normal(size=(200_000, 2))
    assert np.median(np.abs(x)) == pytest.approx(MEDIAN_OF_NORMAL, abs=0.005)
    assert pytest.approx(1.0, abs=1e-4) == MEDIAN_OF_NORMAL * SD_PER_MEDIAN
    assert plane_scale(3 * np.linalg.norm(x, axis=1)) == pytest.approx(3.0, rel=0.01)


# ---- Runs ----


@pytest.mark.parametrize("n", [0, 1, 2, 7, 40])
def test_runs_cover_what_is_true_and_nothing_else(n):
    rng = np.random.default_rng(n)
    for share in (0.0, 0.3, 0.7, 1.0):
        mask = rng.random(n) < share
        runs = true_runs(mask)
        covered = np.zeros(n, bool)
        for first, stop in runs:
            assert (
                mask[first:stop].all() and not mask[max(first - 1, 0) : first].any() and not mask[stop : stop + 1].any()
            )
            covered[first:stop] = True
        assert (covered == mask).all() and (np.diff(runs.ravel()) > 0).all()


def test_runs_of_rows_are_those_of_each_row():
    mask = np.random.default_rng(0).random((6, 30)) < 0.5
    each = [(k, *run) for k, row in enumerate(mask) for run in true_runs(row).tolist()]
    assert true_runs_of_rows(mask).tolist() == [list(run) for run in each]


def test_equal_runs_end_where_any_column_changes():
    a, b = np.random.default_rng(0).integers(0, 2, (2, 50))
    ends = equal_runs(a, b)
    assert ends[0] == 0 and ends[-1] == 50
    for first, stop in pairwise(ends):
        assert len({*zip(a[first:stop], b[first:stop], strict=True)}) == 1
    changed = (np.diff(a) != 0) | (np.diff(b) != 0)
    assert begins(a, b).tolist() == [True, *changed.tolist()]
    assert equal_runs(a[:0], b[:0]).tolist() == [0]


# ---- vectors ----


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("shape", [(3,), (1, 3), (7, 3), (12, 60, 60, 3)])
def test_lengths_are_those_of_numpy_to_the_last_digit(kind, shape):
    rng = np.random.default_rng(len(shape))
    v = (300 * rng.normal(size=shape)).astype(kind)
    v[rng.random(shape) < 0.01] = np.nan
    found = lengths(v)
    assert found.dtype == kind
    np.testing.assert_array_equal(found, np.sqrt((v**2).sum(-1)))


# ---- medians and quantiles of rows ----


@pytest.mark.parametrize("n", [1, 2, 3, 8, 41, 700])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.8, 1.0])
def test_medians_and_quantiles_of_rows_with_gaps_are_those_of_numpy_to_the_last_digit(n, share):
    rng = np.random.default_rng(n)
    rows = rng.normal(size=(5, 20, n))
    rows[rng.random(rows.shape) < 0.3] = np.nan
    rows[np.isnan(rows).all(-1), 0] = 1.0
    assert (row_medians(rows) == np.nanmedian(rows, axis=-1)).all()
    assert (row_medians(rows[0, :4]) == np.nanmedian(rows[0, :4], axis=-1)).all()  # few places, long rows
    assert (row_quantiles(rows, share) == np.nanquantile(rows, share, axis=-1)).all()


@pytest.mark.parametrize(("n", "most"), [(-3, 5), (0, 5), (1, 5), (5, 5), (6, 5), (99, 7), (1000, 300), (7, 1)])
@pytest.mark.parametrize("spread", [evenly, evenly_rounded])
def test_a_few_of_many_are_distinct_and_reach_both_ends(n, most, spread):
    few = spread(n, most)
    assert len(few) == max(min(n, most), 0) and (np.diff(few) > 0).all()
    assert n <= 0 or few[0] == 0
    assert min(n, most) < 2 or (few[-1] == n - 1 and np.ptp(np.diff(few)) <= 1)


def test_what_is_across_a_direction_has_nothing_along_it():
    d = np.random.default_rng(3).normal(size=(4, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    pair = perpendicular_pair(d)
    np.testing.assert_allclose(across(d), pair @ pair.mT, atol=1e-12)


@pytest.mark.parametrize("shape", [(0,), (7,), (4, 3)])
def test_mean_and_median_are_of_the_finite_values(shape):
    values = np.random.default_rng(3).normal(size=shape)
    holes = np.concatenate([values.ravel(), [np.nan, np.inf]])
    assert (
        np.isnan(finite_mean(values[:0])) and np.isnan(finite_median(values[:0])) and finite_median(holes[-2:], 0) == 0
    )
    if values.size:
        assert finite_mean(holes) == values.ravel().mean() and finite_median(holes) == np.median(values)
