"""Detection: groups against SciPy's labels, centroids against truth, symmetries, and what is refused."""

import numpy as np
import pytest
from scipy import ndimage

from kinemark.data import KinemarkError, Validity, same
from kinemark.detect import Centroids, detect, detect_frames
from kinemark.detect.background_noise import background
from kinemark.detect.centroids_method import USUAL
from kinemark.detect.grouping import group_runs
from kinemark.detect.pixel_runs import Runs
from kinemark.native.pixel_runs import bright_cells, white_runs
from support.discs import SIDE, blotches, disc, discs
from support.films import Film


@pytest.mark.parametrize(("seed", "shape"), [(0, (3, 40, 56)), (1, (5, 37, 41)), (2, (1, 3, 200)), (3, (4, 9, 8))])
def test_groups_are_scipys_connected_components(seed, shape):
    images = blotches(seed, shape)
    n, height, width = shape
    tall = images.reshape(n * height, width)
    groups = group_runs(Runs(*white_runs(tall, bright_cells(tall, 90), 90)), height=height, width=width)
    found = {}
    for f, area, *box in zip(
        groups.frame, groups.area, groups.left, groups.right, groups.top, groups.bottom, strict=True
    ):
        found.setdefault(int(f), []).append((int(area), *map(int, box)))
    for f, image in enumerate(images):
        label = ndimage.label(image > 90, np.ones((3, 3)))[0]
        areas, top = np.bincount(label.ravel())[1:], f * height
        expected = [
            (int(a), x.start, x.stop - 1, top + y.start, top + y.stop - 1)
            for a, (y, x) in zip(areas, ndimage.find_objects(label), strict=True)
        ]
        assert expected and sorted(found[f]) == sorted(expected)


@pytest.mark.parametrize("diameter", [8, 12])
def test_the_area_is_that_of_the_disc(diameter):
    """Counts of white pixels go up and down with the place in the pixel; the area must not."""
    images, _ = discs(100, diameter, 0.5, 1.0, np.random.default_rng(8))
    area = detect_frames(images).area
    assert abs(area.mean() / (np.pi * diameter**2 / 4) - 1) < 0.04 and area.std() / area.mean() < 0.015


@pytest.mark.parametrize(("diameter", "limit"), [(5, 0.014), (8, 0.010), (12, 0.008)])
@pytest.mark.parametrize("blur", [0.0, 0.5, 0.8])
def test_the_error_is_small_and_as_large_as_the_covariance_says(diameter, limit, blur):
    images, truth = discs(300, diameter, blur, 3.0, np.random.default_rng(diameter))
    found = detect_frames(images, method=Centroids(noise_sd=3.0))
    assert (found.counts == 1).all()
    off = found.uv - truth
    assert np.sqrt(np.mean(off**2)) < limit * (1.1 if blur == 0.8 else 1.0)
    normalised = np.einsum("ni,nij,nj->n", off, np.linalg.inv(found.cov), off) / 2
    assert 0.8 < normalised.mean() < 1.25


@pytest.mark.parametrize(("blur", "noise", "shot"), [(1.2, 0.0, 0.0), (0.5, 2.0, 0.3), (0.0, 0.0, 0.0)])
def test_the_covariance_holds_for_blur_photon_noise_and_pixels_alone(blur, noise, shot):
    images, truth = discs(250, 8, blur, noise, np.random.default_rng(5), shot=shot)
    found = detect_frames(images, method=Centroids(noise_sd=noise, shot_noise=shot))
    off = found.uv - truth
    normalised = np.einsum("ni,nij,nj->n", off, np.linalg.inv(found.cov), off) / 2
    assert 0.6 < normalised.mean() < 1.4


@pytest.mark.parametrize("diameter", [5, 8, 12])
@pytest.mark.parametrize("inverted", [False, True])
def test_white_centroids_are_the_means_of_the_white_pixels(diameter, inverted):
    images, truth = discs(300, diameter, 0.5, 3.0, np.random.default_rng(20 + diameter))
    shown = 255 - images if inverted else images
    method = Centroids(threshold=195 if inverted else 60, inverted=inverted, centroid="white")
    found = detect_frames(shown, method=method)
    assert (found.counts == 1).all()
    means = np.array([ndimage.center_of_mass(image > 60)[::-1] for image in images])
    np.testing.assert_allclose(found.uv, means, atol=1e-12)
    assert found.area.tolist() == (images > 60).sum((1, 2)).tolist()
    normalised = np.einsum("ni,nij,nj->n", found.uv - truth, np.linalg.inv(found.cov), found.uv - truth) / 2
    assert 0.3 < normalised.mean() < 1.8  # 0.35 to 1.75 times the mean over radii


def test_white_centroids_take_grey_levels_for_nothing():
    images, _ = discs(50, 8, 0.5, 0.0, np.random.default_rng(3))
    method = Centroids(threshold=60, centroid="white")
    shaded = np.where(images > 60, np.minimum(images, 61 + np.arange(images.shape[2]) % 90), images).astype(np.uint8)
    np.testing.assert_array_equal(detect_frames(images, method=method).uv, detect_frames(shaded, method=method).uv)
    assert (detect_frames(images).uv != detect_frames(shaded).uv).all()


def test_no_phase_of_the_pixel_grid_biases_the_centroid():
    """A threshold cutting the rim pulls a centroid towards the pixel's middle: error against phase has a slope."""
    images, truth = discs(300, 8, 0.5, 0.0, np.random.default_rng(1))
    part = truth - SIDE // 2
    slope = np.polyfit(part.ravel(), (detect_frames(images).uv - truth).ravel(), 1)[0]
    assert abs(slope) < 0.003


def scene(seed=4):
    """(2, 70, 90) noisy images with four discs each, none at the edge."""
    rng = np.random.default_rng(seed)
    images = rng.normal(12, 2, (2, 70, 90))
    for image in images:
        for y, x in ((2, 3), (2, 40), (40, 8), (43, 60)):
            image[y : y + SIDE, x : x + SIDE] += 190 * disc(*rng.uniform(-0.5, 0.5, 2), rng.uniform(5, 10), 0.6)
    return np.clip(np.rint(images), 0, 255).astype(np.uint8)


METHOD = Centroids(noise_sd=2.0)


def sorted_rows(uv, cov):
    order = np.lexsort(np.round(uv.T, 6))
    return uv[order], cov[order]


@pytest.mark.parametrize("flip", ["u", "v", "transpose"])
def test_centroids_turn_with_the_image(flip):
    images = scene()[:1]
    before = detect_frames(images, method=METHOD)
    turned = {"u": images[:, :, ::-1], "v": images[:, ::-1], "transpose": images.transpose(0, 2, 1)}[flip]
    after = detect_frames(turned, method=METHOD)
    T = {"u": np.diag([-1.0, 1.0]), "v": np.diag([1.0, -1.0]), "transpose": np.array([[0.0, 1.0], [1.0, 0.0]])}[flip]
    shift = {"u": [images.shape[2] - 1, 0], "v": [0, images.shape[1] - 1], "transpose": [0, 0]}[flip]
    expected = sorted_rows(before.uv @ T.T + shift, T @ before.cov @ T.T)
    found = sorted_rows(after.uv, after.cov)
    np.testing.assert_allclose(found[0], expected[0], atol=1e-9)
    np.testing.assert_allclose(found[1], expected[1], atol=1e-12)


def test_frames_do_not_know_of_each_other():
    images = np.concatenate([scene(4), scene(5), np.zeros((3, 70, 90), np.uint8), scene(6)])
    together = detect_frames(images)
    alone = [detect_frames(image[None]) for image in images]
    assert same(together, type(together)(*(np.concatenate(column) for column in zip(*alone, strict=True))))
    assert list(together.counts) == [4, 4, 4, 4, 0, 0, 0, 4, 4]


def test_a_white_bar_through_two_frames_is_two_groups():
    images = np.zeros((2, 16, 16), np.uint8)
    images[0, 10:, 5:8] = images[1, :4, 5:8] = 200
    found = detect_frames(images)
    assert list(found.counts) == [1, 1] and (found.validity == Validity.AT_EDGE).all()


def test_sixteen_bits_are_a_finer_scale_of_the_same_grey():
    images = scene()
    eight, sixteen = detect_frames(images, method=METHOD), detect_frames(images.astype(np.uint16) * 257, method=METHOD)
    np.testing.assert_allclose(sixteen.uv, eight.uv, atol=1e-9)
    np.testing.assert_allclose(sixteen.cov, eight.cov, rtol=1e-9)
    np.testing.assert_array_equal(sixteen.peak, eight.peak * 257)


def test_a_brighter_ground_moves_nothing():
    images = np.minimum(scene(), 225)
    plain = detect_frames(images, method=METHOD)
    lit = detect_frames(images + np.uint8(30), method=Centroids(threshold=90, noise_sd=2.0))
    np.testing.assert_allclose(lit.uv, plain.uv, atol=1e-9)


def painted(*boxes):
    image = np.full((1, 120, 160), 10, np.uint8)
    for x, y, w, h in boxes:
        image[0, y : y + h, x : x + w] = 200
    return image


def test_every_reason_for_not_being_a_marker():
    image = painted((10, 10, 8, 8), (30, 10, 2, 2), (50, 10, 60, 60), (10, 40, 20, 4), (0, 80, 6, 6))
    found = detect_frames(image, method=Centroids(min_area=5, max_area=1000))
    names = {(w, h): Validity(v).name for w, h, v in zip(found.width, found.height, found.validity, strict=True)}
    assert names == {
        (8, 8): "VALID",
        (2, 2): "TOO_SMALL",
        (60, 60): "TOO_LARGE",
        (20, 4): "NOT_ROUND",
        (6, 6): "AT_EDGE",
    }
    large = found.validity == Validity.TOO_LARGE
    np.testing.assert_allclose(found.uv[large], [[79.5, 39.5]])
    assert np.isnan(found.cov[large]).all() and np.isfinite(found.cov[~large]).all()


def test_lone_pixels_and_single_lines_are_noise():
    assert detect_frames(painted((10, 10, 1, 1), (30, 10, 1, 9), (50, 10, 9, 1))).counts.sum() == 0
    assert detect_frames(painted((10, 10, 1, 9)), method=Centroids(min_width=1, max_aspect=9)).counts.sum() == 1


def test_a_group_darker_at_its_rim_than_beyond_keeps_a_centroid_in_its_rectangle():
    image = np.full((1, 20, 20), 59, np.uint8)
    image[0, 7:11, 7:11] = 0
    image[0, 8:10, 8:10] = 61
    found = detect_frames(image)
    np.testing.assert_allclose(found.uv, [[8.5, 8.5]])
    np.testing.assert_allclose(found.cov, [np.eye(2) * 4 / 12])


@pytest.mark.parametrize("grey", [0, 255])
@pytest.mark.parametrize("shape", [(3, 1024, 700), (2, 7, 5), (1, 1, 1), (0, 480, 640)])
def test_dark_and_white_images(grey, shape):
    found = detect_frames(np.full(shape, grey, np.uint8))
    assert len(found.counts) == shape[0]
    whole = grey and min(shape[1:]) > 1
    assert (found.counts == (1 if whole else 0)).all()
    np.testing.assert_allclose(found.uv, np.tile((np.array(shape[:0:-1]) - 1) / 2, (len(found.uv), 1)))
    assert not (found.validity == Validity.VALID).any()


@pytest.mark.parametrize("noise", [0.5, 3.0, 10.0])
def test_noise_is_measured_in_spite_of_markers(noise):
    rng = np.random.default_rng(7)
    grey = rng.normal(40, noise, (20, 240, 320))
    grey[rng.random(grey.shape) < 1e-3] += 150
    level, variance = background(np.clip(np.rint(grey), 0, 255).astype(np.uint8))
    assert abs(np.sqrt(variance.mean()) - np.hypot(noise, 12**-0.5)) < 0.06 * noise
    assert np.abs(level - 40).max() < 0.5 + noise / 2


def test_a_threshold_in_the_noise_is_refused():
    rng = np.random.default_rng(0)
    with pytest.raises(KinemarkError, match=r"Frame 1 .* threshold 60.*noise"):
        detect_frames(np.stack([np.zeros((500, 600), np.uint8), rng.integers(0, 80, (500, 600), np.uint8)]))


@pytest.mark.parametrize(
    "images",
    [np.zeros((4, 4), np.uint8), np.zeros((1, 4, 4, 3), np.uint8), np.zeros((1, 4, 4)), np.zeros((1, 0, 4), "u1")],
)
def test_what_is_no_stack_of_grey_images(images):
    with pytest.raises(ValueError, match="images"):
        detect_frames(images)


@pytest.mark.parametrize(
    "wrong",
    [
        {"threshold": 255},
        {"threshold": -1},
        {"threshold": float("nan")},
        {"min_area": 0},
        {"min_area": 9, "max_area": 8},
        {"min_width": 0},
        {"max_aspect": 0.5},
        {"noise_sd": -1.0},
        {"shot_noise": -0.1},
    ],
)
def test_parameters_out_of_range(wrong):
    with pytest.raises(ValueError, match=r"wanted"):
        Centroids(**wrong)


SAID = Centroids(**USUAL._asdict())  # nothing is left to be learned


def test_a_recording_is_its_cameras_and_frames_in_order():
    films = [np.concatenate([scene(c), scene(c + 1)] * 9) for c in (1, 11)]
    done = []
    found = detect([Film(f) for f in films], cameras=["a", "b"], rate=50.0, method=SAID, progress=done.append)
    assert found.cameras == ("a", "b") and found.rate == 50.0 and found.counts.shape == (2, 36)
    assert done == sorted(done) and done[-1] == 72
    for c, f in ((0, 0), (1, 17), (1, 35)):
        np.testing.assert_array_equal(found[c, f], detect_frames(films[c][f : f + 1], method=SAID).uv)


def test_the_second_field_lies_half_a_line_lower():
    film = np.concatenate([scene(2)] * 10)
    plain = detect([Film(film)], cameras=["a"], rate=50.0)
    fields = detect([Film(film, interlaced=True)], cameras=["a"], rate=50.0)
    np.testing.assert_allclose(
        fields.uv - plain.uv, np.stack([0 * plain.frame, 0.5 * (plain.frame % 2)], -1), atol=1e-12
    )


def test_no_cameras_and_no_frames():
    assert detect([], cameras=[], rate=50.0).counts.shape == (0, 0)
    assert detect([Film(np.zeros((0, 8, 8), np.uint8))], cameras=["a"], rate=50.0).counts.shape == (1, 0)


def test_unequal_cameras_and_short_files_are_named():
    film = np.zeros((5, 8, 8), np.uint8)
    with pytest.raises(KinemarkError, match=r"left 5, right 4.*cut"):
        detect([Film(film), Film(film[1:])], cameras=["left", "right"], rate=50.0)
    with pytest.raises(KinemarkError, match=r"left: 5 frames .* 6"):
        detect([Film(film, announced=6)], cameras=["left"], rate=50.0)
    with pytest.raises(ValueError, match="1 sources and 2 camera names"):
        detect([Film(film)], cameras=["left", "right"], rate=50.0)
    noise = np.random.default_rng(0).integers(0, 80, (1, 500, 600), np.uint8)
    with pytest.raises(KinemarkError, match=r"Camera left.*threshold"):
        detect([Film(noise)], cameras=["left"], rate=50.0, method=SAID)
