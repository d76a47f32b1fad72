"""A survey that is wrong for all cameras at once: points have that error however many cameras there are."""

import numpy as np
import pytest

from kinemark.calibrate.control_points import ControlPoints, Dlt, calibrate_control_points
from kinemark.geometry import project_all, refine, triangulate
from kinemark.geometry.camera import undistort_all
from kinemark.synth import ring

MIDDLE = np.array([1200.0, 700.0, 1000.0])
INSIDE = 7.815  # χ² of three, 95 %
NOISE = 0.2  # px


def judged(seed, n, *, survey, cameras, method):
    """Share of 60 points within their 95 % ellipsoids, and their RMS standard deviation, mm."""
    rng = np.random.default_rng(seed)
    rig = ring(cameras)
    corners = np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), -1).reshape(-1, 3)
    inner = rng.uniform(-1, 1, (max(n - 8, 0), 3))
    xyz = MIDDLE + np.vstack([rng.permutation(corners)[:n], inner]) * [700, 700, 800] + rng.uniform(-60, 60, (n, 3))
    uv = project_all(rig, xyz) + NOISE * rng.normal(size=(cameras, n, 2))
    said = xyz + survey * rng.normal(size=xyz.shape)
    found = calibrate_control_points(rig.names, [c.size for c in rig], said, uv, method=method)
    places = MIDDLE + rng.uniform(-1, 1, (60, 3)) * [700, 700, 800]
    uv = (project_all(rig, places) + NOISE * rng.normal(size=(cameras, 60, 2))).transpose(1, 0, 2)
    cov = np.broadcast_to(np.eye(2) * NOISE**2, (*uv.shape, 2))
    point = refine(found, triangulate(undistort_all(found, uv), found.P), uv, cov)
    off = point.xyz - places
    d2 = np.einsum("ni,ni->n", off, np.linalg.solve(point.cov, off[..., None])[..., 0])
    return (d2 < INSIDE).mean(), np.sqrt(np.trace(point.cov, axis1=1, axis2=2).mean())


@pytest.mark.parametrize("method", [ControlPoints(), Dlt()])
@pytest.mark.parametrize("survey", [0.0, 2.0])
def test_points_are_within_what_is_stated(survey, method):
    inside = np.mean([judged(s, 12, survey=survey, cameras=6, method=method)[0] for s in range(40)])
    assert 0.87 < inside < 0.99


def test_more_cameras_do_not_make_a_survey_better():
    few, many = (
        np.mean([judged(s, 16, survey=3.0, cameras=c, method=ControlPoints())[1] for s in range(8)]) for c in (3, 12)
    )
    assert many > 0.75 * few


@pytest.mark.parametrize("n", [6, 8])
def test_few_points_of_a_linear_transformation_are_as_uncertain_as_they_say(n):
    assert np.mean([judged(s, n, survey=0.0, cameras=3, method=Dlt())[0] for s in range(40)]) > 0.92
