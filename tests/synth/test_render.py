"""Rendered spheres against the ellipse they must be, occlusion, blur, noise and speed of light."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.geometry import distort, project, to_camera
from kinemark.synth import Capsules, Optics, film, interlace, look_at, render, ring, sphere_ellipse, stationary, walking
from kinemark.synth.sphere_image import sphere_outline

DARK = Optics(background=0.0, read_noise=0.0, blur_px=0.0, brightness=200.0)
CAMERA = look_at("c", (0, -4000, 1000), (0, 0, 1000), focal_px=1100)


def centroid(image):
    image = image.astype(float)
    v, u = np.mgrid[: image.shape[0], : image.shape[1]]
    return np.array([(u * image).sum(), (v * image).sum()]) / image.sum()


def capsule(a, b, radius):
    return Capsules(("limb",), np.array([[a]], float), np.array([[b]], float), np.array([radius], float))


@pytest.mark.parametrize("place", [(0.3, 0, 1000.2), (900, 500, 400), (-1500, -300, 1500), (500, -2500, 600)])
@pytest.mark.parametrize("radius", [8.0, 12.5, 40.0, 150.0])
def test_sphere_is_its_ellipse(place, radius):
    xyz = np.array([place], float)
    outline = sphere_ellipse(CAMERA, xyz[0], radius)
    image = render(CAMERA, xyz, radius, optics=DARK)
    assert np.linalg.norm(centroid(image) - outline.centre) < 0.02
    assert image.sum() / 200 == pytest.approx(outline.area, rel=0.01)


def test_centre_of_a_large_sphere_lies_outside_its_projected_centre():
    xyz = np.array([[1000.0, -1500.0, 1600.0]])
    ellipse, point = sphere_ellipse(CAMERA, xyz[0], 200.0).centre, project(CAMERA, xyz[0])
    assert np.linalg.norm(ellipse - point) > 1.0  # or the next line would say nothing
    assert np.linalg.norm(centroid(render(CAMERA, xyz, 200.0, optics=DARK)) - ellipse) < 0.01


def test_outline_lies_on_the_ellipse():
    xyz, radius = np.array([[800.0, -2000.0, 1700.0]]), np.array([120.0])
    edge = sphere_outline(CAMERA, xyz, radius, 64)[0]
    ellipse = sphere_ellipse(CAMERA, xyz[0], 120.0)
    c = to_camera(CAMERA, xyz[0])
    along = c[:2] / np.linalg.norm(c[:2])
    x, y = np.array([along, [-along[1], along[0]]]) @ (edge - ellipse.centre).T
    assert np.allclose((x / ellipse.along) ** 2 + (y / ellipse.across) ** 2, 1.0, atol=1e-9)
    assert ellipse.area == pytest.approx(np.pi * ellipse.along * ellipse.across)


def test_area_scales_with_the_square_of_radius_and_of_nearness():
    far, near = np.array([[0, 0, 1000.0]]), np.array([[0, -2000, 1000.0]])
    one = render(CAMERA, far, 20.0, optics=DARK).sum(dtype=float)
    assert render(CAMERA, far, 40.0, optics=DARK).sum(dtype=float) / one == pytest.approx(4, rel=0.01)
    assert render(CAMERA, near, 20.0, optics=DARK).sum(dtype=float) / one == pytest.approx(4, rel=0.01)


def test_distorted_sphere_is_the_distorted_ellipse():
    lens = (-0.25, 0.08, 0.002, -0.001, 0.0)
    camera = look_at("c", (0, -4000, 1000), (0, 0, 1000), focal_px=1100, distortion=lens)
    xyz = np.array([[1500.0, -400.0, 1500.0]])
    edge = sphere_outline(camera, xyz, np.array([60.0]), 720)[0]
    x, y = (edge - edge.mean(0)).T
    x2, y2 = np.roll(x, -1), np.roll(y, -1)
    cross = x * y2 - x2 * y  # area and centroid of the polygon
    centre = edge.mean(0) + np.array([((x + x2) * cross).sum(), ((y + y2) * cross).sum()]) / (3 * cross.sum())
    image = render(camera, xyz, 60.0, optics=DARK)
    assert np.linalg.norm(centroid(image) - centre) < 0.01
    assert image.sum() / 200 == pytest.approx(abs(cross.sum()) / 2, rel=0.005)
    assert np.linalg.norm(centre - distort(camera, sphere_ellipse(camera, xyz[0], 60.0).centre)) < 0.2


def test_blur_keeps_centroid_and_light():
    xyz = np.array([[333.3, 100.0, 1222.2]])
    sharp = render(CAMERA, xyz, 40.0, optics=DARK)
    soft = render(CAMERA, xyz, 40.0, optics=Optics(background=0, read_noise=0, blur_px=1.5, brightness=200.0))
    assert np.linalg.norm(centroid(sharp) - centroid(soft)) < 0.01
    assert soft.sum(dtype=float) == pytest.approx(sharp.sum(dtype=float), rel=0.01)
    assert (soft > 0).sum() > (sharp > 0).sum()


def test_marker_cut_by_the_border_is_the_part_of_the_whole():
    def seen(column):
        K = np.array([[1100.0, 0, column], [0, 1100.0, 511.5], [0, 0, 1]])
        camera = replace(CAMERA, K=K)
        return render(camera, np.array([[5.0, 0, 1000]]), 40.0, optics=Optics(read_noise=0, blur_px=1.5))

    assert np.array_equal(seen(0)[:, :600], seen(639)[:, 639:1239])
    assert (seen(0)[:, 0] > 14).any()


def test_limb_between_camera_and_marker_hides_it_and_behind_does_not():
    xyz = np.array([[0.0, 0.0, 1000.0]])
    free = render(CAMERA, xyz, 12.5, optics=DARK)
    before = render(CAMERA, xyz, 12.5, optics=DARK, capsules=capsule((-300, -1000, 1000), (300, -1000, 1000), 30))
    behind = render(CAMERA, xyz, 12.5, optics=DARK, capsules=capsule((-300, 300, 1000), (300, 300, 1000), 30))
    assert free.any() and not before.any()
    assert np.array_equal(free, behind)


def test_limb_with_its_edge_on_the_marker_hides_half():
    xyz = np.array([[0.0, 0.0, 1000.0]])
    # A level limb whose silhouette, seen from the camera, ends at the line of sight to the marker's centre.
    half = render(CAMERA, xyz, 40.0, optics=DARK, capsules=capsule((-900, -1000, 950), (900, -1000, 950), 50))
    full = render(CAMERA, xyz, 40.0, optics=DARK)
    assert half.sum(dtype=float) / full.sum(dtype=float) == pytest.approx(0.5, abs=0.01)
    assert centroid(half)[1] < centroid(full)[1]  # the upper half stays


def test_nearer_marker_covers_the_farther_one():
    both = render(CAMERA, np.array([[0, 0, 1000.0], [0, -500, 1000.0]]), [10, 40], optics=DARK)
    assert np.array_equal(both, render(CAMERA, np.array([[0, -500, 1000.0]]), 40, optics=DARK))


def test_limb_darkening_dims_the_rim_only():
    xyz = np.array([[0.0, 0.0, 1000.0]])
    flat = render(CAMERA, xyz, 80.0, optics=DARK).astype(int)
    dim = render(CAMERA, xyz, 80.0, optics=Optics(0.0 + 200, 0, 0, 0, limb_darkening=1.0)).astype(int)
    v, u = np.round(project(CAMERA, xyz[0])).astype(int)[::-1]
    assert abs(dim[v, u] - flat[v, u]) <= 2
    assert dim.sum() == pytest.approx(flat.sum() * 2 / 3, rel=0.01)  # the mean of √(1 − ρ²) over a disc


def test_behind_outside_absent_and_folded_markers_are_not_drawn():
    camera = look_at("c", (0, -4000, 1000), (0, 0, 1000), focal_px=1100, distortion=(-0.35, 0.0, 0.0, 0.0, 0.0))
    places = np.array([[0, -9000, 1000], [0, -4005, 1000], [9e4, 0, 1000], [np.nan] * 3, [6800.0, 0, 1000]])
    assert (np.abs(project(camera, places[4]) - [639.5, 511.5]) < 640).all()  # the model folds back into the image
    assert not render(camera, places, 12.5, optics=DARK).any()


def test_noise_has_the_asked_level_and_saturation_holds():
    optics = Optics(background=40.0, read_noise=3.0, brightness=400.0)
    image = render(CAMERA, np.array([[0, 0, 1000.0]]), 40.0, optics=optics, rng=np.random.default_rng(3))
    assert image.max() == 255
    dark = image[:300]
    assert dark.mean() == pytest.approx(40, abs=0.05)
    assert dark.std() == pytest.approx(np.sqrt(9 + 1 / 12), rel=0.01)


def test_a_film_is_reproducible_and_its_noise_independent_between_frames():
    subject = stationary(("m",), [[0, 0, 1000.0]], radius_mm=80.0, n_frames=4)
    films = [np.array(list(film(CAMERA, subject, seed=seed))) for seed in (5, 5, 6)]
    assert np.array_equal(films[0], films[1]) and not np.array_equal(films[0], films[2])
    lit = films[0][:, 502:522, 630:650].reshape(4, -1).astype(float)
    dark = films[0][:, :200].reshape(4, -1).astype(float)
    for rows in (lit, dark):
        apart = np.corrcoef(rows)[np.triu_indices(4, 1)]
        assert (np.abs(apart) < 5 / np.sqrt(rows.shape[1])).all()


def test_strobes_of_facing_cameras_saturate_where_those_cameras_are():
    rig = ring(2, height=[1500], sweep_deg=360)
    image = render(rig[0], np.zeros((0, 3)), 1.0, strobes=rig.centres[1:], optics=Optics(read_noise=0))
    u, v = np.round(project(rig[0], rig[1].centre)).astype(int)
    assert image[v, u] == 255
    assert 14 < image[v, u + 14] < 255  # the glare
    hidden = render(
        rig[0],
        np.zeros((0, 3)),
        1.0,
        strobes=rig.centres[1:],
        capsules=capsule((1200, 700, 1300), (1200, 700, 1700), 300),
        optics=Optics(read_noise=0),
    )
    assert (hidden == 14).all()


def test_interlacing_weaves_two_fields():
    images = [np.full((6, 4), value, np.uint8) for value in (1, 2, 3, 4, 5)]
    woven = list(interlace(images))
    assert [frame[:2, 0].tolist() for frame in woven] == [[1, 2], [3, 4]]


def test_all_visible_markers_of_a_walker_are_lit():
    subject, camera = walking(duration_s=0.04), ring(6)[0]
    image = render(camera, subject.xyz[:, 0], 12.5, optics=DARK)
    uv = np.round(project(camera, subject.xyz[:, 0])).astype(int)
    assert (image[uv[:, 1], uv[:, 0]] == 200).all()


def test_a_camera_without_a_size_is_refused():
    with pytest.raises(ValueError, match="size"):
        render(look_at("c", (0, 0, 0), (0, 1, 0), size=(0, 0)), np.zeros((1, 3)), 1.0)
