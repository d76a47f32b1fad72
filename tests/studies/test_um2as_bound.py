"""Bounds on the error of the eleven parameters hold for every perturbation, and where they say nothing they say so."""

import numpy as np
import pytest
from um2as_bound import first_order_bound, parameter_bound
from um2as_equations import fit_parameters, rows
from um2as_experiment import TABLE_4_2, LinearisedErrors, laboratory
from um2as_sampling import circle

from kinemark.data import KinemarkError

LAB = laboratory()
RADIUS = 0.5  # px


def moved(points, uv, n=2000, seed=0):
    """(n, 11) parameters of control points moved by RADIUS in random directions."""
    theta = np.random.default_rng(seed).uniform(0, 2 * np.pi, (n, len(points)))
    return fit_parameters(points, uv + circle(theta, RADIUS))


def test_the_condition_of_the_thesis_is_not_met_in_its_units():
    for cm in (1.0, 10.0):
        for uv in LAB.uv:
            bound = parameter_bound(LAB.points / cm, uv, RADIUS)
            assert bound.kappa > 100 and np.isnan(bound.percent)


def test_the_norm_of_the_change_does_not_depend_on_directions():
    uv, rng = LAB.uv[0], np.random.default_rng(1)
    back = np.linalg.norm(np.linalg.pinv(rows(LAB.points, uv).reshape(-1, 11)), 2)
    for _ in range(20):
        other = uv + circle(rng.uniform(0, 2 * np.pi, len(uv)), RADIUS)
        change = (rows(LAB.points, other) - rows(LAB.points, uv)).reshape(-1, 11)
        kappa = back * np.linalg.norm(change, 2)
        assert kappa == pytest.approx(parameter_bound(LAB.points, uv, RADIUS).kappa, rel=1e-6)


@pytest.mark.parametrize("camera", [LinearisedErrors.of_parameters(TABLE_4_2), LAB])
def test_with_unit_columns_the_bound_holds(camera):
    for uv, L in zip(camera.uv, camera.L, strict=True):
        size = np.linalg.norm(rows(camera.points, uv).reshape(-1, 11), axis=0)
        bound = parameter_bound(camera.points, uv, RADIUS, unit_columns=True)
        found = 100 * np.linalg.norm((moved(camera.points, uv) - L) * size, axis=1) / np.linalg.norm(L * size)
        assert bound.kappa < 1 and found.max() < bound.percent
        other = parameter_bound(camera.points / 10, uv, RADIUS, unit_columns=True)
        np.testing.assert_allclose(other, bound, rtol=1e-6)  # no matter which unit


def test_the_first_order_bound_is_reached_within_a_third():
    for uv, L in zip(LAB.uv, LAB.L, strict=True):
        found = 100 * np.linalg.norm(moved(LAB.points, uv, 20_000) - L, axis=1) / np.linalg.norm(L)
        bound = first_order_bound(LAB.points, uv, RADIUS)
        assert 0.66 * bound < found.max() < bound


def test_points_in_a_plane_are_refused():
    flat = LAB.points * [1.0, 1.0, 0.0]
    with pytest.raises(KinemarkError, match="plane"):
        parameter_bound(flat, LAB.uv[0], RADIUS)
