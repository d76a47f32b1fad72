"""Markers of a few pixels are found with what the recording teaches, errors are as stated, and lone pixels are none."""

import numpy as np
import pytest

from kinemark.detect import Centroids, detect, propose
from kinemark.detect.centroids_method import USUAL
from kinemark.detect.learning import learned_limits
from kinemark.geometry import project, sphere_offset
from kinemark.synth import Optics, look_at, render
from support.films import Film

FIELDS = 6


def filmed(diameter, *, seed, **optics):
    """Fields of 752 × 291 px of 56 spheres 4.2 m away, and the places of their images (F, 56, 2) in its lines."""
    rng, light = np.random.default_rng(seed), Optics(**optics)
    camera = look_at("a", (0, -4200, 1000), (0, 0, 1000), focal_px=770, size=(752, 582))
    grid = np.stack(np.meshgrid(np.arange(-700, 701, 200.0), [0.0], np.arange(400, 1601, 200.0)), -1).reshape(-1, 3)
    images, places = [], []
    for f in range(FIELDS):
        xyz = grid + rng.uniform(-20, 20, grid.shape)
        images.append(render(camera, xyz, diameter / 2, optics=light, rng=rng)[f % 2 :: 2])
        places.append((project(camera, xyz) + sphere_offset(camera, xyz, diameter=diameter)) / [1, 2])
    return Film(images, interlaced=True), np.array(places)


def judged(found, camera, places):
    """Share of the places with a valid detection within 1.5 px, mean normalised squared error, and false ones."""
    errors, n_found, false = [], 0, 0
    for f, true in enumerate(places):
        some = (found.camera == camera) & (found.frame == f) & (found.validity == 0)
        apart = np.linalg.norm(found.uv[some] - true[:, None], axis=-1)
        near, close = apart.argmin(1), apart.min(1) < 1.5
        off, cov = (found.uv[some][near] - true)[close], found.cov[some][near][close]
        errors.append(np.einsum("ni,nij,nj->n", off, np.linalg.inv(cov), off) / 2)
        n_found, false = n_found + close.sum(), false + (apart.min(0) > 3).sum()
    return n_found / places[..., 0].size, float(np.concatenate(errors).mean()), int(false)


@pytest.mark.parametrize(
    ("diameter", "optics"),
    [
        (10.0, {}),
        (14.0, {"read_noise": 4.0}),
        (14.0, {"brightness": 60.0, "background": 40.0, "read_noise": 1.0}),
        (19.0, {"blur_px": 0.9}),
        (25.0, {}),
    ],
)
def test_spheres_of_two_to_nine_pixels_are_found_and_their_errors_are_as_stated(diameter, optics):
    source, places = filmed(diameter, seed=int(diameter), **optics)
    recall, nees, false = judged(detect([source], cameras=["a"], rate=50.0), 0, places)
    assert recall >= 0.98 and false == 0
    assert 0.4 < nees < 1.8


def test_cameras_of_different_gain_work_side_by_side():
    made = [filmed(14.0, seed=k, brightness=b, background=g) for k, (b, g) in enumerate([(220, 5), (90, 90), (45, 20)])]
    found = detect([source for source, _ in made], cameras=["a", "b", "c"], rate=50.0)
    for c, (_, places) in enumerate(made):
        assert judged(found, c, places)[0] >= 0.98


def test_what_is_stated_is_not_learned():
    source, places = filmed(14.0, seed=3)
    assert judged(detect([source], cameras=["a"], rate=50.0, method=Centroids(**USUAL._asdict())), 0, places)[0] < 0.8
    found = detect([source], cameras=["a"], rate=50.0, method=Centroids(min_area=500))
    assert len(found.validity) and (found.validity != 0).all()


def test_lone_bright_pixels_are_no_markers():
    source, places = filmed(10.0, seed=4)
    rng = np.random.default_rng(5)
    for image in source.images:
        image[rng.integers(5, 40, 60), rng.integers(5, 740, 60)] = 200
    recall, _, false = judged(detect([source], cameras=["a"], rate=50.0), 0, places)
    assert recall >= 0.98 and false <= 0.03 * 60 * FIELDS  # two may be neighbours by chance


def test_recordings_without_markers_have_the_usual_limits():
    noise = np.clip(np.random.default_rng(6).normal(20, 3, (4, 60, 90)), 0, 255).astype(np.uint8)
    assert learned_limits(noise) == USUAL
    assert learned_limits(noise + 100).threshold > 130  # bright ground lies above the usual one
    assert learned_limits(255 - noise, inverted=True).threshold < 215


def test_dark_markers_are_learned_from_the_negative():
    source, places = filmed(14.0, seed=7, background=30.0)
    source.images = 255 - source.images
    found = detect([source], cameras=["a"], rate=50.0, method=Centroids(inverted=True))
    assert judged(found, 0, places)[0] >= 0.98
    proposed = propose(source.images, inverted=True)
    assert proposed.inverted and proposed.centroids.min_area <= 2 and proposed.centroids.min_width == 1


def test_the_usual_threshold_stays_where_it_parts_noise_from_markers():
    """A higher one, as many images would allow, cuts more of each marker away."""
    bright, _ = filmed(25.0, seed=7)
    assert learned_limits(np.stack(bright.images)).threshold == USUAL.threshold
    dim, _ = filmed(14.0, seed=8, brightness=60.0)
    assert learned_limits(np.stack(dim.images)).threshold < USUAL.threshold


def test_the_usual_threshold_stays_a_little_above_the_gap_too():
    """There even the dimmest marker has nearly twice the contrast."""
    source, places = filmed(19.0, seed=11, brightness=120.0)
    gap = propose(source.images).gap
    assert gap.threshold < gap.high < USUAL.threshold == learned_limits(source.images).threshold
    assert judged(detect([source], cameras=["a"], rate=50.0), 0, places)[0] == 1


@pytest.mark.parametrize(("near", "lowered"), [(1, False), (2, False), (4, True)])
def test_only_what_is_larger_in_every_other_frame_is_a_lamp(near, lowered):
    """Markers that come near in some frames are many larger things, and still markers."""
    images = filmed(19.0, seed=12)[0].images.copy()
    larger = filmed(44.0, seed=12)[0].images
    images[:near] = np.maximum(images[:near], np.where(np.arange(752) < 270, larger[:near], 0))
    assert (learned_limits(images).max_area < USUAL.max_area) == lowered
