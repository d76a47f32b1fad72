"""The offset of a sphere's centroid: against exact outlines, rendered images, and points reconstructed from them."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Camera, Detections, Matches, Rig
from kinemark.detect import Centroids, detect_frames
from kinemark.geometry import project, sphere_offset
from kinemark.reconstruct import LeastSquares, reconstruct
from kinemark.synth.optics import Optics
from kinemark.synth.render import render
from kinemark.synth.sphere_image import sphere_ellipse, sphere_outline
from support.laboratory import camera as laboratory

LENS = np.array([-0.25, 0.08, 0.002, -0.001, 0.01])


def camera(lens=None):
    K = np.array([[900.0, 1.5, 640.0], [0.0, 910.0, 500.0], [0.0, 0.0, 1.0]])
    return Camera("a", np.array([1280, 1024]), K, np.eye(3), np.zeros(3), np.zeros(5) if lens is None else lens)


def spheres(n=60, seed=0):
    """(n, 3) mm, 0.4 to 1.5 m before the camera and up to 30° off its axis."""
    rng = np.random.default_rng(seed)
    z = rng.uniform(400, 1500, n)
    return np.stack([rng.uniform(-0.55, 0.55, n) * z, rng.uniform(-0.4, 0.4, n) * z, z], -1)


def polygon_centroid(p):
    """(N, 2) centroids of the area within outlines (N, k, 2)."""
    q = np.roll(p, -1, axis=1)
    cross = p[..., 0] * q[..., 1] - q[..., 0] * p[..., 1]
    return ((p + q) * cross[..., None]).sum(1) / (3 * cross.sum(1))[:, None]


@pytest.mark.parametrize("diameter", [10.0, 40.0, 120.0])
def test_without_a_lens_it_is_the_ellipses_centre(diameter):
    c, xyz = camera(), spheres()
    off = sphere_offset(c, xyz, diameter=diameter)
    np.testing.assert_allclose(off, sphere_ellipse(c, xyz, diameter / 2).centre - project(c, xyz), atol=1e-9)
    assert np.linalg.norm(off, axis=1).max() > 1e-4 * diameter


@pytest.mark.parametrize("diameter", [10.0, 40.0, 80.0])
def test_with_a_lens_it_is_the_centroid_of_the_drawn_outline(diameter):
    c, xyz = camera(LENS), spheres()
    outline = sphere_outline(c, xyz, np.full(len(xyz), diameter / 2), 4000)
    exact = polygon_centroid(outline - project(c, xyz)[:, None])
    assert np.abs(sphere_offset(c, xyz, diameter=diameter) - exact).max() < 0.001
    ideal = sphere_offset(camera(), xyz, diameter=diameter)
    assert diameter < 40 or np.abs(ideal - exact).max() > 0.02  # the lens is no small matter


def apart(c, xyz, by):
    """Those of the points whose projections are farther than `by` px from all that were taken before, and inside."""
    uv, taken = project(c, xyz), []
    for k, at in enumerate(uv):
        if (at > by).all() and (at < c.size - by).all() and all(np.linalg.norm(at - uv[j]) > by for j in taken):
            taken.append(k)
    return xyz[taken]


def test_it_is_what_rendered_images_show():
    """Without noise; what is left is what square pixels do to a centroid."""
    c, left, wrong = camera(LENS), [], []
    for seed in range(2):
        xyz = apart(c, spheres(40, seed), 100)
        image = render(c, xyz, 20.0, optics=Optics(read_noise=0, blur_px=0.6, subsamples=6))
        found = detect_frames(image[None], method=Centroids(max_area=10**5, correct_occlusion=False))
        nearest = np.linalg.norm(found.uv[:, None] - project(c, xyz), axis=2).argmin(1)
        assert len(nearest) == len(xyz)
        wrong.append(found.uv - project(c, xyz[nearest]))
        left.append(wrong[-1] - sphere_offset(c, xyz[nearest], diameter=40.0))
    assert len(np.concatenate(left)) > 18
    assert np.sqrt(np.mean(np.square(np.concatenate(wrong)))) > 0.03
    assert np.sqrt(np.mean(np.square(np.concatenate(left)))) < 0.002


@pytest.mark.parametrize("lens", [None, LENS])
def test_laws(lens):
    c, xyz = camera(lens), spheres()
    np.testing.assert_allclose(sphere_offset(c, xyz, diameter=0.0), 0, atol=1e-12)
    small, large = (sphere_offset(c, xyz, diameter=d) for d in (1.0, 2.0))
    np.testing.assert_allclose(large, 4 * small, rtol=1e-4, atol=1e-9)  # it grows as the square
    on_axis = sphere_offset(camera(), np.array([0.0, 0.0, 900.0]), diameter=50.0)
    np.testing.assert_allclose(on_axis, 0, atol=1e-12)
    both = sphere_offset(c, xyz.reshape(6, 10, 3), diameter=30.0)
    np.testing.assert_array_equal(both.reshape(-1, 2), sphere_offset(c, xyz, diameter=30.0))


def test_where_it_is_not_defined():
    places = np.array([[0.0, 0, -500], [0, 0, 15], [0, 0, 500]])
    assert np.isnan(sphere_offset(camera(), places, diameter=40.0)).any(1).tolist() == [True, True, False]
    for diameter in (-1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="diameter is"):
            sphere_offset(camera(), places, diameter=diameter)


def seen_spheres(rig, xyz, diameter, rng, sd=0.02):
    """Detections of spheres, at the centroids that cameras see, and the matches of each."""
    uv = np.stack([project(c, xyz) + sphere_offset(c, xyz, diameter=diameter) for c in rig])
    uv = uv + rng.normal(0, sd, uv.shape)
    n = len(xyz)
    detections = Detections.build(
        rig.names,
        50.0,
        np.full((len(rig), 1), n),
        uv.reshape(-1, 2),
        np.broadcast_to(np.eye(2) * sd**2, (uv.size // 2, 2, 2)),
    )
    detection = np.arange(len(rig) * n).reshape(len(rig), n).T
    return detections, Matches(np.zeros(n, np.int64), detection, np.zeros(n), 1)


def growth(found, true):
    """By what share of their distances from each other found points (N, 3) lie farther apart than true ones."""
    away = true - true.mean(0)
    return ((found - true) * away).sum() / (away**2).sum()


def test_points_of_large_near_spheres_are_unbiased():
    rig = Rig(tuple(laboratory(f"c{i}", [1000 * np.cos(i), 1000 * np.sin(i), 1200], focal=800.0) for i in range(4)))
    rng = np.random.default_rng(0)
    xyz = rng.uniform([-200, -200, 700], [200, 200, 1100], (400, 3))
    detections, matches = seen_spheres(rig, xyz, 60.0, rng)
    method = LeastSquares(model_sd=0.0, within_volume=False, degrees_of_freedom=0)
    plain = reconstruct(matches, detections, rig, method=method)
    right = reconstruct(matches, detections, rig, method=replace(method, marker_diameter=60.0))

    def normalised(cloud):
        off = cloud.xyz - xyz
        return np.einsum("ni,nij,nj->n", off, np.linalg.inv(cloud.cov), off).mean() / 3

    assert normalised(plain) > 2
    assert 0.9 < normalised(right) < 1.1
    assert abs(growth(right.xyz, xyz)) < 0.1 * abs(growth(plain.xyz, xyz))


@pytest.mark.parametrize("diameter", [0.0, -3.0, float("nan")])
def test_a_diameter_is_above_zero(diameter):
    with pytest.raises(ValueError, match="marker_diameter"):
        LeastSquares(marker_diameter=diameter)
