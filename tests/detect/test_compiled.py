"""The compiled kernel of detection against NumPy, bit by bit, and what it refuses."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from kinemark import native
from kinemark.detect import Centroids, centroids, detect_frames, sums
from kinemark.detect.blobs import Blobs
from kinemark.detect.grouping import group_runs
from kinemark.detect.pixel_runs import Runs, find_runs
from kinemark.detect.sums import pixel_sums
from kinemark.native import PLAIN, pixel_runs
from support.examples import examples
from support.plain import plainly

needs_kernel = pytest.mark.skipif(native.library() is None, reason="detection was installed without a compiler")
SINGLE = Centroids(
    max_discs=1, correct_occlusion=False
)  # what is done with overlapping markers knows nothing of the kernel
some = settings(max_examples=examples(60), deadline=None)


@st.composite
def films(draw):
    """Frames (n, H, W) of either type, with specks, blotches or neither on a ground, and a grey level among theirs."""
    n, height = draw(st.integers(0, 3)), draw(st.integers(1, 24))
    width = draw(st.one_of(st.integers(1, 40), st.sampled_from([255, 256, 257, 300, 515])))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    grey = rng.normal(30, draw(st.sampled_from([0, 3, 20])), (n, height, width))
    kind = draw(st.sampled_from(["empty", "white", "specks", "blotches"]))
    if kind == "specks":
        grey[rng.random(grey.shape) < draw(st.sampled_from([0.001, 0.05, 0.5]))] += 150
    elif kind == "blotches" and grey.size:
        grey += 400 * ndimage.gaussian_filter(rng.normal(size=grey.shape), (0, 1.5, 1.5))
    elif kind == "white":
        grey += 300
    dtype, scale = draw(st.sampled_from([(np.uint8, 1), (np.uint16, 257)]))
    return np.clip(np.rint(grey * scale), 0, 255 * scale).astype(dtype), draw(st.sampled_from([0, 60, 90, 254])) * scale


def tall(images):
    return images.reshape(-1, images.shape[2])


def naive_runs(lines, level):
    """Runs by their definition, line by line."""
    found = []
    for y, line in enumerate(lines):
        edge = np.flatnonzero(np.diff(np.concatenate([[0], line > level, [0]]).astype(int)))
        found += [(y, a, b - 1) for a, b in zip(edge[::2], edge[1::2], strict=True)]
    return np.array(found, np.int64).reshape(-1, 3).T


@some
@given(films(), st.integers(0, 50))
def test_runs_are_what_they_are_defined_to_be(film, most):
    images, level = film
    expected = naive_runs(tall(images), level)
    for found in (find_runs(tall(images), level), plainly(find_runs, tall(images), level)):
        np.testing.assert_array_equal(found, expected)
    few = [find_runs(tall(images), level + 0.5, most=most), plainly(find_runs, tall(images), level + 0.5, most=most)]
    for found in few:
        np.testing.assert_array_equal(found, expected[:, :most])


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize(("level", "count"), [(-1, 8), (-1e9, 8), (65535, 0), (70000, 0)])
def test_levels_beyond_the_scale(dtype, level, count):
    black = np.zeros((8, 300), dtype)
    assert len(find_runs(black, level).y) == len(plainly(find_runs, black, level).y) == count


def test_bright_images_take_no_more_memory_at_a_time(monkeypatch):
    """A comb is one group of very many runs; parts of it give what the whole gives."""
    comb = np.zeros((5, 40, 64), np.uint8)
    comb[:, 2:4] = comb[:, 4:38, 2:62:2] = 200
    whole, many = plainly(detect_frames, comb, method=SINGLE), find_runs(tall(comb), 60)
    assert len(many.y) > 5 * 30 * 30 and list(whole.counts) == [1] * 5
    monkeypatch.setattr(pixel_runs, "FEW", 7)
    np.testing.assert_array_equal(find_runs(tall(comb), 60), many)
    monkeypatch.setattr(pixel_runs, "MOST_CELLS", 9)
    np.testing.assert_array_equal(plainly(find_runs, tall(comb), 60), many)
    monkeypatch.setattr(centroids, "MOST_RUNS", 1500)
    assert_alike(detect_frames(comb, method=SINGLE), whole)


def assert_alike(found: Blobs, expected: Blobs):
    for name, a, b in zip(Blobs._fields, found, expected, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9, err_msg=name)


@needs_kernel
@some
@given(films())
def test_groups_and_sums_are_those_of_numpy_to_the_last_bit(film):
    images, level = film
    height, width = images.shape[1:]
    found = find_runs(tall(images), level)
    groups = group_runs(found, height=height, width=width)
    expected = plainly(group_runs, found, height=height, width=width)
    for a, b in zip(
        (groups.start, *groups.runs, *groups[2:]), (expected.start, *expected.runs, *expected[2:]), strict=True
    ):
        np.testing.assert_array_equal(a, b)
        assert a.dtype == b.dtype == np.int64
    some_groups = groups.keep(np.arange(len(groups.area)) % 3 != 1)
    ours, numpys = pixel_sums(images, some_groups), plainly(pixel_sums, images, some_groups)
    np.testing.assert_array_equal(np.vstack(ours[:2]), np.vstack(numpys[:2]))
    np.testing.assert_array_equal(np.array(ours[2:]), np.array(numpys[2:]))
    assert (ours.ones.one >= some_groups.area).all() and (ours.peak > level).all()


@needs_kernel
@some
@given(films(), st.sampled_from([0.0, 0.4]), st.integers(1, 2))
def test_detections_are_those_of_numpy(film, shot, min_width):
    images, level = film
    threshold = level / (257 if images.dtype == np.uint16 else 1)
    method = replace(SINGLE, threshold=threshold, shot_noise=shot, min_area=2, min_width=min_width)
    assert_alike(detect_frames(images, method=method), plainly(detect_frames, images, method=method))


@needs_kernel
def test_images_in_any_memory_layout():
    images = np.clip(
        400 * ndimage.gaussian_filter(np.random.default_rng(0).normal(size=(2, 60, 70)), (0, 2, 2)), 0, 255
    )
    images = np.asfortranarray(images.astype(np.uint8))
    groups = group_runs(find_runs(tall(images)[::-1], 60), height=60, width=70)
    assert len(groups.area) > 3
    np.testing.assert_array_equal(
        pixel_sums(images[::-1, ::-1], groups).grey, plainly(pixel_sums, images[::-1, ::-1].copy(), groups).grey
    )


@needs_kernel
def test_threads_do_not_disturb_each_other():
    rng = np.random.default_rng(3)
    grey = 400 * ndimage.gaussian_filter(rng.normal(size=(8, 2, 200, 300)), (0, 0, 2, 2))
    cameras = np.clip(grey, 0, 255).astype(np.uint8)
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda film: detect_frames(film, method=SINGLE), np.concatenate([cameras] * 4)))
    for k, found in enumerate(together):
        assert_alike(found, plainly(detect_frames, cameras[k % 8], method=SINGLE))


IMAGE = np.zeros((2, 10, 20), np.uint8)
ONE = {"start": [0, 2], "y": [12, 13], "first": [3, 3], "last": [5, 6]}


@pytest.mark.parametrize("plain", ["", "1"])
@pytest.mark.parametrize(
    "wrong",
    [
        {"start": [0, 3]},
        {"start": [1, 1]},
        {"start": [-1, 1]},
        {"start": [0, 1 << 62]},
        {"start": [0, 1]},
        {"y": [-1, 0]},
        {"y": [9, 10]},
        {"y": [19, 20]},
        {"y": [13, 12]},
        {"y": [1 << 61, 13]},
        {"y": [12, 12]},
        {"first": [-1, 3]},
        {"first": [3, 8]},
        {"last": [5, 20]},
        {"last": [5, -(1 << 61)]},
    ],
)
def test_groups_of_other_images_are_refused_and_not_read(monkeypatch, plain, wrong):
    monkeypatch.setenv(PLAIN, plain)

    def summed(columns):
        arrays = {name: np.array(values, np.int64) for name, values in columns.items()}
        return native.sum_pixels(IMAGE, *arrays.values())

    assert summed(ONE)[0, 0] == 5 + 6 + 6 + 6
    with pytest.raises(ValueError, match="group 0 of 1 does not lie in one of the 2 frames of 20 × 10 px"):
        summed(ONE | wrong)


def test_columns_of_unequal_length_and_frames_without_lines_are_refused():
    y, x = np.zeros(3, np.int64), np.zeros(2, np.int64)
    with pytest.raises(ValueError, match=r"first has shape \(2,\), wanted \(R,\), R = 3"):
        group_runs(Runs(y, x, x), height=4, width=4)
    with pytest.raises(ValueError, match="4 × 0 px"):
        group_runs(Runs(x, x, x), height=0, width=4)


@pytest.mark.parametrize("plain", ["", "1"])
@pytest.mark.parametrize(
    ("run", "value"),
    [
        (0, (-1, 3, 4)),
        (1, (12, -1, 2)),
        (1, (13, 5, 4)),
        (2, (14, 7, 20)),
        (1, (11, 3, 4)),
        (2, (13, 6, 9)),
        (0, (1 << 62, 1, 1)),
    ],
)
def test_runs_out_of_order_or_beyond_the_frames_are_refused(monkeypatch, plain, run, value):
    monkeypatch.setenv(PLAIN, plain)
    columns = np.array([(12, 3, 5), (13, 3, 6), (14, 3, 6)])
    assert len(group_runs(Runs(*columns.T), height=10, width=20).area) == 1
    columns[run] = value
    with pytest.raises(ValueError, match="out of order or not in frames 20 px wide"):
        group_runs(Runs(*columns.T), height=10, width=20)


def test_rows_of_the_sums_are_the_fields_of_the_record():
    none = np.zeros(0, np.int64)
    rows = native.sum_pixels(IMAGE, np.zeros(1, np.int64), none, none, none)
    assert len(rows) == 2 * len(sums.Sums._fields) + len(sums.PixelSums._fields) - 2
