"""Markers on each other, partly hidden or at the edge: found where they are, and single markers left alone."""

import numpy as np
import pytest
from scipy import ndimage

from kinemark.data import Validity
from kinemark.detect import Centroids, detect_frames
from kinemark.detect import discs as fits
from kinemark.detect.grouping import group_runs
from kinemark.detect.patches import cut_out, pixels_of
from kinemark.detect.pixel_runs import find_runs
from kinemark.native import shape_images as shapes

SIDE, FINE = 37, 4
MIDDLE = SIDE // 2
AT = (np.arange(SIDE * FINE) + 0.5) / FINE - 0.5 - MIDDLE


def light(discs, *, blur=0.5, aspect=1.0, motion=(0.0, 0.0), steps=1, cut=None):
    """(SIDE, SIDE) light of discs (u, v, diameter) from the middle, v of the outline squeezed by `aspect`.

    `motion` is what they move by while the shutter is open; `cut` = (x, y, h) leaves only x u + y v < h.
    """
    total = np.zeros((SIDE, SIDE))
    for t in (np.arange(steps) + 0.5) / steps - 0.5:
        s = np.full((SIDE * FINE, SIDE * FINE), -9.0)
        for u, v, d in discs:
            far = np.hypot(AT - u - t * motion[0], (AT[:, None] - v - t * motion[1]) / aspect)
            s = np.maximum(s, d / 2 - far)
        if cut is not None:
            s = np.minimum(s, cut[2] - cut[0] * AT - cut[1] * AT[:, None])
        fine = ndimage.gaussian_filter(np.clip(s * FINE + 0.5, 0, 1), blur * FINE)
        total += fine.reshape(SIDE, FINE, SIDE, FINE).mean((1, 3)) / steps
    return total


def photo(shares, rng, *, noise=3.0, peak=190.0, ground=12.0):
    """uint8 images of light (n, H, W)."""
    shares = np.asarray(shares)
    return np.clip(np.rint(ground + peak * shares + noise * rng.normal(size=shares.shape)), 0, 255).astype(np.uint8)


def within(rng):
    return rng.uniform(-0.5, 0.5, 2)


def pair(rng, d, apart, *, ratio=1.0, aspect=1.0):
    """Two discs with centres `apart` diameters from each other, in any direction and at any place in the pixel."""
    a, (u, v) = rng.uniform(0, 2 * np.pi), within(rng)
    c, s = np.cos(a) * apart * d / 2, np.sin(a) * apart * d / 2 * aspect
    return [(u + c, v + s, d), (u - c, v - s, d * ratio)]


def three(rng, d):
    """Three discs, each 0.7 diameters or more from the others, and at most 0.9 from the nearest."""
    while True:
        p = rng.uniform(-d, d, (3, 2))
        far = np.linalg.norm(p[:, None] - p, axis=2)[np.triu_indices(3, 1)]
        if far.min() > 0.7 * d and np.sort(far)[1] < 0.9 * d:
            return [(u, v, d) for u, v in p - p.mean(0) + within(rng)]


def split(blobs, *columns):
    """One array a frame of each column."""
    ends = np.cumsum(blobs.counts)[:-1]
    return zip(*(np.split(getattr(blobs, column), ends) for column in columns), strict=True)


def offsets(blobs, truth):
    """For each frame with as many detections as discs, each at another: how far they are off (k, 2), and cov."""
    found = []
    for (uv, cov), discs in zip(split(blobs, "uv", "cov"), truth, strict=True):
        centres = MIDDLE + np.array(discs)[:, :2]
        nearest = np.linalg.norm(uv[:, None] - centres, axis=2).argmin(1)
        if len(set(nearest)) == len(nearest) == len(centres):
            found.append((uv - centres[nearest], cov))
    return found


def normalised(found):
    """Mean squared error over what the covariance says, an axis."""
    off, cov = (np.concatenate(column) for column in zip(*found, strict=True))
    return np.einsum("ni,nij,nj->n", off, np.linalg.inv(cov), off).mean() / 2


def share_near(found, number, reach=0.1):
    return sum(np.linalg.norm(off, axis=1).max() < reach for off, _ in found) / number


# ---- The models ----


def grid(n=1):
    y, x = (a.reshape(-1).astype(float) for a in np.mgrid[-12:13, -12:13])
    rows = np.tile(x, (n, 1)), np.tile(y, (n, 1)), np.zeros((n, 625)), np.ones((n, 625)), np.full(n, np.inf)
    return shapes.Patches(*rows)


SHAPES = {
    "one": (shapes.discs, [0.3, -0.2, 4.1]),
    "two": (shapes.discs, [2.0, 0.3, 4.1, -2.2, -0.4, 3.9]),
    "three": (shapes.discs, [2.0, 0.3, 4.1, -2.2, -0.4, 3.9, 0.5, 3.0, 3.5]),
    "ellipse": (shapes.ellipse, [0.2, 0.1, 0.2, 0.02, 0.3]),
    "motion": (shapes.motion, [0.1, 0.2, 4.0, 3.0, 1.0]),
    "cut": (shapes.cut, [0.1, 0.2, 5.0, 0.7, 2.0]),
}


EXACT = ("one", "motion")  # the others hold what changes little: the outlines' angle, the steepness of q


@pytest.mark.parametrize("name", SHAPES)
def test_derivatives_are_those_of_differences(name):
    shape, start = SHAPES[name]
    p, patches = np.array([[*start, 0.6, 180.0, 12.0]]), grid()
    J = shapes.image(shape, p, patches)[1]
    for k in range(p.shape[1]):
        step = np.zeros_like(p)
        step[:, k] = 1e-5
        change = (shapes.image(shape, p + step, patches)[0] - shapes.image(shape, p - step, patches)[0]) / 2e-5
        assert np.abs(change - J[:, k]).max() < (0.001 if name in EXACT else 0.15) * np.abs(change).max(), k


@pytest.mark.parametrize("name", ["one", "two", "three", "cut"])
def test_the_models_are_what_blurred_outlines_look_like(name):
    """Fitted to images without noise, they leave little and are where the outlines are."""
    shape, true = SHAPES[name]
    if name == "cut":
        x, y, r, turn, h = true
        image = light([(x, y, 2 * r)], cut=(np.cos(turn), np.sin(turn), h))
    else:
        image = light([(x, y, 2 * r) for x, y, r in np.reshape(true, (-1, 3))])
    grey = 200 * image[MIDDLE - 12 : MIDDLE + 13, MIDDLE - 12 : MIDDLE + 13].reshape(1, -1)
    fit = fits.fit(shape, np.array([[*(p + 0.2 for p in true), 0.6, 190.0, 3.0]]), grid()._replace(grey=grey))
    assert np.sqrt(np.mean((fit.model - grey)[(grey > 6) & (grey < 194)] ** 2)) < 0.015 * 200
    centres = [k for k in range(len(true)) if k % 3 < 2] if name != "cut" else [0, 1]
    np.testing.assert_allclose(fit.parameters[0, centres], np.array(true)[centres], atol=0.02)


# ---- Markers on each other ----


def test_discs_seven_tenths_of_a_diameter_apart_are_found():
    """Within 0.1 px in 95 of 100 cases, with covariances that are true."""
    rng, truth = np.random.default_rng(0), []
    for d in (8.0, 10.0, 12.0, 16.0):
        truth += [pair(rng, d, 0.7) for _ in range(75)]
    blobs = detect_frames(photo([light(discs) for discs in truth], rng), method=Centroids(noise_sd=3.0))
    found = offsets(blobs, truth)
    assert share_near(found, len(truth)) >= 0.95
    assert 0.8 < normalised(found) < 1.2
    assert blobs.merged.mean() > 0.95 and (blobs.validity == Validity.VALID).all()


def test_three_discs_on_each_other_are_found():
    rng = np.random.default_rng(1)
    truth = [three(rng, d) for d in (8.0, 11.0) for _ in range(40)]
    blobs = detect_frames(photo([light(discs) for discs in truth], rng), method=Centroids(noise_sd=3.0))
    found = offsets(blobs, truth)
    assert share_near(found, len(truth)) >= 0.95
    assert 0.75 < normalised(found) < 1.3


@pytest.mark.parametrize(("apart", "ratio", "aspect"), [(0.5, 1.0, 1.0), (0.9, 1.5, 1.0), (0.8, 1.0, 0.5)])
def test_closer_and_unequal_discs_and_those_in_fields(apart, ratio, aspect):
    rng = np.random.default_rng(2)
    truth = [pair(rng, 10.0, apart, ratio=ratio, aspect=aspect) for _ in range(60)]
    images = photo([light(discs, aspect=aspect) for discs in truth], rng)
    found = offsets(detect_frames(images, method=Centroids(noise_sd=3.0, aspect=aspect)), truth)
    assert share_near(found, len(truth)) >= 0.95
    assert (0.75 if aspect == 1 else 0.5) < normalised(found) < 1.3


def test_saturated_discs_are_told_apart_too():
    rng = np.random.default_rng(3)
    truth = [pair(rng, 10.0, 0.7) for _ in range(60)]
    images = photo([light(discs) for discs in truth], rng, peak=400.0)
    assert np.mean((images == 255).sum((1, 2))) > 80
    found = offsets(detect_frames(images, method=Centroids(noise_sd=3.0)), truth)
    assert share_near(found, len(truth)) >= 0.95
    assert 0.7 < normalised(found) < 1.4


@pytest.mark.parametrize(("number", "most"), [(3, 2), (4, 3)])
def test_what_cannot_be_told_apart_says_so(number, most):
    """More discs than are looked for: one centroid, as far from each of them as its covariance says."""
    rng, d, ratios = np.random.default_rng(4), 10.0, []
    for _ in range(20):
        a = rng.uniform(0, 2 * np.pi) + np.arange(number) * 2 * np.pi / number
        p = 0.75 * d / (2 * np.sin(np.pi / number)) * np.stack([np.cos(a), np.sin(a)], -1)
        images = photo([light([(u, v, d) for u, v in p])], rng)
        blob = detect_frames(images, method=Centroids(noise_sd=3.0, max_discs=most))
        assert len(blob.uv) == 1 and blob.merged.all()
        ratios.append(((p + MIDDLE - blob.uv) ** 2).sum(1).mean() / np.trace(blob.cov[0]))
    assert 0.6 < np.mean(ratios) < 1.8


# ---- Single markers ----


def singles(kind, rng, n):
    for _ in range(n):
        (u, v), a, d = within(rng), rng.uniform(0, np.pi), rng.uniform(5, 16)
        if kind == "discs":
            yield light([(u, v, d)], blur=rng.choice([0.3, 0.5, 0.9]))
        elif kind == "ellipses":
            turned = light([(u, v, max(d, 7))], aspect=rng.uniform(0.5, 0.9))
            yield turned if rng.random() < 0.5 else turned.T
        elif kind == "in motion":
            by = rng.uniform(0.2, 1.0) * d
            yield light([(u, v, d)], motion=(by * np.cos(a), by * np.sin(a)), steps=13)
        else:
            side = 1 + 0.06 * (
                np.cos(a) * np.arange(-MIDDLE, MIDDLE + 1) + np.sin(a) * np.arange(-MIDDLE, MIDDLE + 1)[:, None]
            )
            yield light([(u, v, d)], aspect=rng.uniform(0.7, 1.0)) * np.clip(side, 0.3, 1.3)


@pytest.mark.parametrize("kind", ["discs", "ellipses", "in motion", "lit from a side"])
def test_single_markers_are_not_split(kind):
    rng = np.random.default_rng(5)
    images = photo(list(singles(kind, rng, 25 if kind == "in motion" else 200)), rng)
    blobs = detect_frames(images, method=Centroids(noise_sd=3.0))
    plain = detect_frames(images, method=Centroids(noise_sd=3.0, max_discs=1, correct_occlusion=False))
    assert len(blobs.uv) == len(plain.uv) == len(images)
    assert not blobs.merged.any()
    np.testing.assert_array_equal(blobs.uv, plain.uv)  # nor are they taken for hidden ones


@pytest.mark.parametrize("uneven", ["texture", "lit from a side"])
def test_uneven_brightness_is_no_reason_to_fit_discs(monkeypatch, uneven):
    """Printed dots have patterns inside, lamps stand on one side; only ellipses are fitted, so that it costs little."""
    rng, looked, fit = np.random.default_rng(6), [], fits.fit
    rise = 1 + 0.08 * np.arange(-MIDDLE, MIDDLE + 1)
    images = photo(
        [
            light([(*within(rng), 20.0 if uneven == "texture" else 9.0)], aspect=0.8)
            * (rng.uniform(0.45, 1.0, (SIDE, SIDE)) if uneven == "texture" else np.clip(rise, 0.4, 1.3))
            for _ in range(30)
        ],
        rng,
    )
    monkeypatch.setattr(fits, "fit", lambda shape, p, *a, **k: looked.append((shape, len(p))) or fit(shape, p, *a, **k))
    detect_frames(images)
    assert sum(number for shape, number in looked if shape is shapes.ellipse) >= 20
    assert sum(number for shape, number in looked if shape is not shapes.ellipse) <= 2


def test_clean_discs_are_hardly_looked_at(monkeypatch):
    rng, looked, fit = np.random.default_rng(7), [], fits.fit
    images = photo([light([(*within(rng), d)]) for d in (6.0, 8.0, 12.0, 16.0) for _ in range(100)], rng)
    monkeypatch.setattr(fits, "fit", lambda shape, p, *a, **k: looked.append(len(p)) or fit(shape, p, *a, **k))
    detect_frames(images)
    assert sum(looked) < 0.03 * len(images)


def test_two_discs_with_a_waist_are_not_tried_as_one_in_motion(monkeypatch):
    """The rims of real ones are off by more than noise, and motion costs seven times as much as a disc."""
    rng, looked, fit = np.random.default_rng(14), [], fits.fit
    rough = [light(pair(rng, 10.0, 0.8)) ** 2 for _ in range(30)]
    monkeypatch.setattr(fits, "fit", lambda shape, p, *a, **k: looked.append(shape) or fit(shape, p, *a, **k))
    blobs = detect_frames(photo(rough, rng, noise=0.5), method=Centroids(noise_sd=0.5))
    assert blobs.merged.all() and len(blobs.uv) == 60
    assert shapes.discs in looked and shapes.motion not in looked


# ---- Partly hidden ----


@pytest.mark.parametrize("hidden", [0.25, 0.45])
def test_a_disc_behind_a_straight_limb_is_put_where_its_centre_is(hidden):
    """`hidden` is the part of the diameter that is behind the limb."""
    rng, truth, images = np.random.default_rng(8), [], []
    for d in (8.0, 10.0, 14.0):
        for _ in range(30):
            a, (u, v) = rng.uniform(0, 2 * np.pi), within(rng)
            truth.append([(u, v, d)])
            images.append(
                light(truth[-1], cut=(np.cos(a), np.sin(a), (0.5 - hidden) * d + u * np.cos(a) + v * np.sin(a)))
            )
    images = photo(images, rng)
    found = offsets(detect_frames(images, method=Centroids(noise_sd=3.0)), truth)
    plain = offsets(detect_frames(images, method=Centroids(noise_sd=3.0, correct_occlusion=False, max_discs=1)), truth)
    assert share_near(found, len(truth)) >= 0.95
    assert share_near(plain, len(truth)) < 0.05
    assert 0.7 < normalised(found) < 1.35


def test_a_disc_at_the_edge_is_valid_only_where_its_centre_is_known():
    rng = np.random.default_rng(9)
    truth = [[(u, v, 12.0)] for u, v in rng.uniform(-0.5, 0.5, (20, 2))]
    images = photo([light(discs) for discs in truth], rng)[:, :, MIDDLE - 2 :]
    usual = detect_frames(images, method=Centroids(noise_sd=3.0))
    assert (usual.validity == Validity.AT_EDGE).all()
    kept = detect_frames(images, method=Centroids(noise_sd=3.0, max_edge_sd=0.2))
    assert (kept.validity == Validity.VALID).mean() > 0.9
    off = kept.uv - [2, MIDDLE] - np.array(truth)[:, 0, :2]
    good = kept.validity == Validity.VALID
    assert np.linalg.norm(off[good], axis=1).max() < 0.2
    assert 0.5 < normalised([(off[good], kept.cov[good])]) < 1.6


# ---- Laws ----


def crowd(rng):
    """(82, 82) four cut-outs: a pair, three, one behind a limb, and a single disc."""
    parts = [light(pair(rng, 9.0, 0.8)), light(three(rng, 9.0)), light([(0, 0, 10.0)], cut=(1, 0.3, 1.5))]
    a, b, c = parts
    return np.block([[a, b], [c, light([(0.2, 0.1, 8.0)])]])


def test_frames_do_not_know_of_each_other():
    rng = np.random.default_rng(10)
    images = photo([crowd(rng) for _ in range(3)], rng)
    together = detect_frames(images)
    for f, (uv, cov, merged) in enumerate(split(together, "uv", "cov", "merged")):
        alone = detect_frames(images[f : f + 1])
        np.testing.assert_allclose(alone.uv, uv, atol=1e-4)
        np.testing.assert_allclose(alone.cov, cov, rtol=1e-3)
        np.testing.assert_array_equal(alone.merged, merged)
    assert together.merged.sum() == 15


@pytest.mark.parametrize("turn", [lambda a: a[:, :, ::-1], lambda a: a[:, ::-1], lambda a: a.transpose(0, 2, 1)])
def test_the_result_turns_with_the_image(turn):
    rng = np.random.default_rng(11)
    images = photo([crowd(rng)], rng)
    places = np.zeros((*images.shape[1:], 2))
    places[..., 1], places[..., 0] = np.mgrid[: images.shape[1], : images.shape[2]]
    turned = np.stack([turn(places[None, ..., k])[0] for k in (0, 1)], -1)  # where each pixel comes from
    after = detect_frames(np.ascontiguousarray(turn(images)))
    back = np.stack([ndimage.map_coordinates(turned[..., k], after.uv.T[::-1], order=1) for k in (0, 1)], -1)
    before = detect_frames(images).uv
    assert len(back) == len(before) == 7
    assert np.linalg.norm(back[:, None] - before, axis=2).min(1).max() < 0.01


def test_sixteen_bits_are_a_finer_scale_of_the_same_grey():
    rng = np.random.default_rng(12)
    images = photo([crowd(rng)], rng)
    eight, sixteen = (
        detect_frames(i, method=Centroids(noise_sd=3.0)) for i in (images, images.astype(np.uint16) * 257)
    )
    np.testing.assert_allclose(sixteen.uv, eight.uv, atol=1e-3)
    np.testing.assert_array_equal(sixteen.merged, eight.merged)


def test_large_markers_and_many_discs_are_left_as_they_are():
    rng = np.random.default_rng(13)
    images = photo([light(pair(rng, 12.0, 0.7))], rng)
    strobe = detect_frames(images, method=Centroids(max_area=100))
    assert len(strobe.uv) == 1 and strobe.validity[0] == Validity.TOO_LARGE and not strobe.merged.any()
    for wrong in (0, 6):
        with pytest.raises(ValueError, match="max_discs"):
            Centroids(max_discs=wrong)


def test_what_a_group_shows_does_not_depend_on_what_is_fitted_beside_it():
    """Fits of small groups were judged by places far away, which larger groups beside them brought."""
    rng = np.random.default_rng(3)
    pairs = [light(pair(rng, d, 0.35 + 0.5 * rng.random())) for d in [6.0, 8.0, 7.0, 6.5] * 4]
    film = photo([*pairs, light(three(rng, 14.0)), light(three(rng, 12.0))], rng)
    together = detect_frames(film)
    alone = [detect_frames(image[None]) for image in film]
    np.testing.assert_array_equal(together.counts, [int(one.counts[0]) for one in alone])
    for name in ("uv", "cov", "area"):
        apart = np.concatenate([getattr(one, name) for one in alone])
        np.testing.assert_allclose(getattr(together, name), apart, rtol=1e-6, atol=1e-9)
    groups = group_runs(find_runs(film.reshape(-1, SIDE), 60.0), height=SIDE, width=SIDE)
    pixels = pixels_of(film, groups, threshold=60.0, variance=np.full(len(film), 9.0))
    patches = cut_out(pixels, np.arange(len(groups.area)), threshold=60.0, shot=0.0, aspect=1.0).patches
    for x, y, weight in zip(patches.x, patches.y, patches.weight, strict=True):
        used = set(zip(x[weight > 0], y[weight > 0], strict=True))
        assert set(zip(x, y, strict=True)) == used
