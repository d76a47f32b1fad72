"""How errors travel, to first order, against simulation; with an arm it is `studies/test_um2as_experiment`."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import Rig
from kinemark.geometry import project as camera_project
from kinemark.geometry import refine
from kinemark.sensitivity import angle_spread, cycle_weights, rig_points
from support.captures import ring

SD = np.array([1, 1, 0.5, 0.5, 1e-4, 0, 0, 0, 0, 3e-4, 3e-4, 3e-4, 0.5, 0.5, 0.5])


def drawn(camera, rng):
    """A camera as it may really be, by its covariance."""
    d = SD * rng.standard_normal(15)
    K = camera.K + np.array([[d[0], 0, d[2]], [0, d[1], d[3]], [0, 0, 0]])
    turn = Rotation.from_rotvec(d[9:12]).as_matrix()
    return replace(camera, K=K, R=turn @ camera.R, t=camera.t + d[12:], distortion=camera.distortion + d[4:9])


def test_a_rig_with_lenses_agrees_with_simulation():
    rig = Rig(tuple(replace(camera, cov=np.diag(SD**2)) for camera in ring(4)))
    rng, n = np.random.default_rng(4), 800
    xyz = rng.uniform(-300, 300, (3, 4, 3)) + np.array([0, 0, 1000])
    points = rig_points(rig, xyz, centroid_sd=0.2)
    flat = xyz.reshape(-1, 3)
    uv = np.array([[camera_project(drawn(camera, rng), flat) for camera in rig] for _ in range(n)])
    uv = (uv + 0.2 * rng.standard_normal(uv.shape)).transpose(0, 2, 1, 3).reshape(-1, 4, 2)
    cov = np.broadcast_to(0.04 * np.eye(2), (*uv.shape, 2))
    found = refine(rig, np.tile(flat, (n, 1)), uv, cov).xyz.reshape(n, *xyz.shape)
    assert np.abs(found.std(0) / np.sqrt(np.diagonal(points.cov, axis1=2, axis2=3)) - 1).max() < 0.1
    gap = found[:, 0] - found[:, 1]  # what both markers share cancels
    J = np.zeros((4, 3, 3, 3))
    J[:, :, 0], J[:, :, 1] = np.eye(3), -np.eye(3)
    predicted = np.sqrt(angle_spread(points, J).cov[..., 0, 0])
    assert np.abs(gap.std(0) / predicted - 1).max() < 0.1
    apart = np.sqrt(np.diagonal(points.cov[0] + points.cov[1], axis1=1, axis2=2))
    assert (predicted < 0.9 * apart).any()


def test_weights_of_cycles():
    W = cycle_weights([2, 10.5, 19], 21, points=5)
    assert np.allclose(W.sum(1), 1)
    assert np.allclose(W @ np.arange(21.0), np.linspace((2 + 10.5) / 2, (10.5 + 19) / 2, 5))
    for starts in ([3], [5, 5], [-1, 4], [0, 21]):
        with pytest.raises(ValueError, match="starts"):
            cycle_weights(starts, 21)
