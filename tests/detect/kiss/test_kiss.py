"""KISS's detection: the grouping against its definition, each test on what it is for, errors, and the study."""

import importlib
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from kinemark.data import KinemarkError, Validity, same
from kinemark.detect import KissNearest, KissScanning, detect_frames
from kinemark.detect.kiss.neighbour_grouping import adaptive_limits, neighbour_groups
from kinemark.detect.kiss.overlapped_markers import kinds_of_overlap
from kinemark.detect.kiss.pixel_groups import numbered, rectangles, separated, white_pixels
from kinemark.detect.kiss.scanning import preliminary_groups
from kinemark.detect.kiss.submarkers import merge_sub_markers
from kinemark.detect.kiss.white import pixels_of, runs_of
from kinemark.detect.pixel_runs import Runs
from support.discs import blotches, disc, discs
from support.studies import STUDIES, printed

METHODS = [KissScanning(), KissNearest()]
BARE = KissScanning(
    isolated=False,
    one_wide=False,
    one_high=False,
    sub_markers=False,
    overlaps=False,
    long_wide=False,
    check_sizes=False,
)


def one_by_one(runs, near_x, near_y, height):
    """The rule of KISS 2.1 as it is written: each run in its turn, each group in the order of its number."""
    groups, label = [], []
    for y, first, last in zip(*runs, strict=True):
        x = (first + last) / 2
        near = (
            g
            for g, members in enumerate(groups)
            if any(abs(x - u) <= near_x and y - v <= near_y and y // height == v // height for u, v in members)
        )
        label.append(next(near, len(groups)))
        if label[-1] == len(groups):
            groups.append([])
        groups[label[-1]].append((x, y))
    return label


def labels(groups):
    """The group of every run, in scan order."""
    return groups.of[np.lexsort((groups.first, groups.y))]


@pytest.mark.parametrize(
    ("near_x", "near_y", "level", "at_least"),
    [(0.5, 1, 90, 10), (2.0, 1, 90, 10), (5.0, 2, 90, 10), (100.0, 3, 170, 5)],
)
def test_groups_are_those_of_the_rule_taken_run_by_run(near_x, near_y, level, at_least):
    images = blotches(3, (3, 40, 56))
    runs = runs_of(images, level)
    found = preliminary_groups(runs, near_x=near_x, near_y=near_y, height=40, width=56)
    expected = one_by_one(runs, near_x, near_y, 40)
    assert at_least <= len(set(expected)) < len(runs.y)
    assert labels(found).tolist() == expected
    assert (np.diff(found.frame) >= 0).all()


@pytest.mark.parametrize("neighbourhood", [1, 2, 4])
def test_neighbour_groups_are_connected_within_the_range(neighbourhood):
    images = blotches(5, (3, 30, 46))
    y, x = pixels_of(*runs_of(images, 150))
    found = neighbour_groups(y, x, neighbourhood=neighbourhood, height=30, width=46)
    pairs = cKDTree(np.stack([x, y + 100 * (y // 30)], -1)).query_pairs(neighbourhood, p=np.inf, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(x), len(x)))
    expected = connected_components(graph, directed=False)[1]
    assert expected.max() > 5
    assert (
        len(set(zip(labels(found).tolist(), expected.tolist(), strict=True))) == expected.max() + 1 == len(found.frame)
    )


def test_pixels_are_counted_and_bounded_as_in_an_image():
    images = blotches(7, (2, 40, 56))
    groups = preliminary_groups(runs_of(images, 90), near_x=5.0, near_y=1, height=40, width=56)
    brect, white = rectangles(groups), white_pixels(groups)
    for g in range(len(white)):
        part = slice(*groups.start[g : g + 2])
        y, x = pixels_of(groups.y[part], groups.first[part], groups.last[part])
        assert white[g] == len(x) and (images.reshape(-1, 56)[y, x] > 90).all()
        assert (x.min(), x.max(), y.min(), y.max()) == tuple(side[g] for side in brect)
        assert brect.total_pixels[g] == (np.ptp(x) + 1) * (np.ptp(y) + 1)
    assert white.sum() == (images > 90).sum()


def test_separated_parts_take_the_place_of_the_whole():
    """Cutting every group in two at a column keeps every pixel, its frame, and the order of frames."""
    groups = preliminary_groups(runs_of(blotches(9, (4, 40, 56)), 90), near_x=5.0, near_y=1, height=40, width=56)
    box, parent = rectangles(groups), np.repeat(np.arange(len(groups.frame)), 2)
    middle, even = ((box.left + box.right) // 2)[parent], np.arange(len(parent)) % 2 == 0
    left, right = np.where(even, box.left[parent], middle + 1), np.where(even, middle, box.right[parent])
    parts = separated(
        groups, parent, box._replace(left=left, right=right, top=box.top[parent], bottom=box.bottom[parent])
    )
    assert white_pixels(parts).sum() == white_pixels(groups).sum()
    assert parts.separated.all() and (np.diff(parts.frame) >= 0).all() and (np.diff(parts.of) >= 0).all()
    assert len(parts.frame) == 2 * len(groups.frame) - (box.width == 1).sum()
    assert (parts.frame == parts.y[parts.start[:-1]] // 40).all()


def drawn(*shapes, size=(80, 90)):
    """(1, H, W) rectangles (left, top, width, height) of grey level 200 on 10, and discs (u, v, diameter)."""
    image = np.full((1, *size), 10, np.uint8)
    y, x = np.mgrid[: size[0], : size[1]]
    for shape in shapes:
        if len(shape) == 3:
            image[0, (x - shape[0]) ** 2 + (y - shape[1]) ** 2 <= shape[2] ** 2 / 4] = 200
        else:
            image[0, shape[1] : shape[1] + shape[3], shape[0] : shape[0] + shape[2]] = 200
    return image


SPECKS = {
    "lonely": (5, 5, 1, 1),
    "one_wide": (20, 5, 1, 6),
    "one_high": (40, 5, 6, 1),
    "noise": (60, 5, 2, 3),
    "": (5, 40, 4, 5),
}


@pytest.mark.parametrize(
    ("switched", "removed"),
    [
        ({}, set()),
        ({"isolated": True}, {"lonely"}),
        ({"one_wide": True}, {"lonely", "one_wide"}),
        ({"one_high": True}, {"lonely", "one_high"}),
        ({"noise_width": 3, "noise_height": 4}, {"lonely", "noise"}),
        ({"noise_width": 3, "noise_height": 7}, {"lonely", "noise", "one_wide"}),
    ],
)
def test_each_criterion_of_noise_removes_its_own_kind(switched, removed):
    for method in (BARE, KissNearest(noise_width=0, noise_height=0, split=False)):
        found = detect_frames(drawn(*SPECKS.values()), method=replace(method, **switched))
        left = {(shape[2], shape[3]) for name, shape in SPECKS.items() if name not in removed}
        assert set(zip(found.width, found.height, strict=True)) == left


def test_a_small_group_joins_the_larger_one_in_whose_rectangle_it_lies():
    hook = ((20, 20, 12, 4), (20, 24, 4, 12))  # an angle; what lies inside it is in its rectangle
    cases = {"two rows inside": (27, 27, 5, 2), "three rows inside": (27, 27, 5, 3), "two rows outside": (38, 27, 5, 2)}
    found = {
        name: detect_frames(drawn(*hook, shape), method=replace(BARE, sub_markers=True))
        for name, shape in cases.items()
    }
    assert {name: len(b.uv) for name, b in found.items()} == {
        "two rows inside": 1,
        "three rows inside": 2,
        "two rows outside": 2,
    }
    assert found["two rows inside"].area[0] == 48 + 48 + 10
    almost = drawn(*hook, (28, 27, 5, 2))  # four of its five columns inside
    assert len(detect_frames(almost, method=replace(BARE, sub_markers=True, min_inside=0.8)).uv) == 1
    assert len(detect_frames(almost, method=replace(BARE, sub_markers=True, min_inside=0.9)).uv) == 2
    assert len(detect_frames(almost, method=replace(BARE, sub_markers=True, small_area=10)).uv) == 2


def test_overlaps_are_told_apart_by_side_and_put_where_the_markers_are():
    for mirror in (False, True):
        image = drawn((40, 30, 12), (49, 38, 12))[:, :, :: -1 if mirror else 1]
        groups = preliminary_groups(runs_of(image, 60), near_x=5.0, near_y=1, height=80, width=90)
        assert len(groups.frame) == 3  # what reaches beside the other marker has mid-points of its own
        groups = merge_sub_markers(groups, small_area=30, small_rows=2, inside=0.6, height=80)
        ul, ur = kinds_of_overlap(groups, fill=0.75, shift=3.0, row_overlap=3.0)
        assert (ul.tolist(), ur.tolist()) == (([False], [True]) if mirror else ([True], [False]))
        found = detect_frames(image, method=KissScanning())
        true = np.array([[40, 30], [49, 38]]) * [-1 if mirror else 1, 1] + [89 if mirror else 0, 0]
        assert found.merged.tolist() == [True, True]
        assert np.abs(found.uv[found.uv[:, 1].argsort()] - true).max() < 0.8
        assert len(detect_frames(image, method=KissScanning(overlaps=False, long_wide=False)).uv) == 1


@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize(
    ("moved", "row_overlap", "overlapped"),
    [
        (5, 100, False),  # by less than half of the top row, 5.5
        (6, 100, True),
        (9, 4, True),  # the rows reach over each other by 31 − 29 = 2 columns between their ends
        (9, 2, False),
        (3, 100, False),
    ],
)
def test_overlapped_groups_obey_all_three_conditions(moved, row_overlap, overlapped, mirror):
    image = drawn((20, 20, 12, 1), (31, 20, 1, 8), (20 + moved, 27, 12, 1))[:, :, :: -1 if mirror else 1]
    runs = runs_of(image, 60)
    groups = numbered(*runs, np.zeros(len(runs.y), np.int64), height=80)
    ul, ur = kinds_of_overlap(groups, fill=0.75, shift=3.0, row_overlap=row_overlap)
    assert (ul.tolist(), ur.tolist()) == ([overlapped and not mirror], [overlapped and mirror])


def test_a_lone_disc_is_never_divided():
    for diameter in (4, 5, 6, 8, 12, 20):
        images, _ = discs(60, diameter, 0.5, 3.0, np.random.default_rng(diameter))
        found = detect_frames(images, method=KissScanning())
        assert (found.counts == 1).all() and not found.merged.any()


@pytest.mark.parametrize("number", [2, 3, 4])
@pytest.mark.parametrize("turn", [False, True])
def test_rows_of_markers_are_broken_into_as_many_as_they_are(number, turn):
    row = np.zeros((1, 70, 70), np.uint8)
    row[0] = drawn(*((20, 15 + 11 * k, 12) for k in range(number)), size=(70, 70))
    # three rows lie above the notches of discs of 12 px side by side, and their mid-points are 11 px apart
    found = detect_frames(row.transpose(0, 2, 1) if turn else row, method=KissScanning(near_x=7.0, small_rows=3))
    uv = found.uv[found.uv[:, 1 - turn].argsort()]
    assert np.abs(uv[:, 1 - turn] - (15 + 11 * np.arange(number))).max() < 0.8 and found.merged.all()
    assert np.abs(uv[:, int(turn)] - 20).max() < 0.1


def test_parts_of_any_rectangle_have_ratios_between_the_limits():
    rng = np.random.default_rng(0)
    for w, h in rng.integers(4, 70, (60, 2)):
        found = detect_frames(drawn((5, 5, w, h)), method=replace(BARE, long_wide=True, near_x=50))
        assert found.area.sum() == w * h
        assert (found.height - 1 <= 1.5 * found.width).all() and (found.height + 1 >= 0.66 * (found.width - 1)).all()
        assert len(found.uv) == 1 or not 0.667 <= h / w <= 1.5
        off_middle = np.abs(np.abs(np.log(h / w / np.sqrt(0.667 * 1.5))) - np.log(np.arange(1, 40)))
        assert len(found.uv) == 1 or len(found.uv) == max(2, 1 + off_middle.argmin())  # the most suitable number


def test_strobes_and_specks_are_kept_undivided_with_their_reason():
    image = drawn((40, 40, 30), (10, 70, 6), (80, 10, 2, 2), (0, 20, 5, 5))
    found = detect_frames(image, method=KissScanning(max_area=300, min_area=6))
    assert dict(zip(found.area.tolist(), found.validity.tolist(), strict=True)) == {
        709.0: Validity.TOO_LARGE,
        29.0: Validity.VALID,
        4.0: Validity.TOO_SMALL,
        25.0: Validity.AT_EDGE,
    }
    assert (detect_frames(image, method=KissScanning(max_area=709, min_area=4, noise_width=1)).validity == 0).sum() == 3
    large = found.validity == Validity.TOO_LARGE
    assert (
        np.isnan(found.cov[large]).all() and np.isfinite(found.cov[~large]).all() and (found.peak[~large] == 200).all()
    )
    assert (detect_frames(image, method=KissScanning(max_area=300, check_sizes=False)).validity == 0).all()


def test_the_former_method_splits_by_the_average_of_the_field():
    image = drawn(*((10 + 20 * k, 10, 8) for k in range(4)), (20, 30, 30, 20))
    y, x = pixels_of(*runs_of(image, 60))
    groups = neighbour_groups(y, x, neighbourhood=2, height=80, width=90)
    wide, high = adaptive_limits(groups, factor=1.5, frames=1)
    brect = rectangles(groups)
    assert wide[0] == pytest.approx(1.5 * brect.width.mean()) and high[0] == pytest.approx(1.5 * brect.height.mean())
    found = detect_frames(image, method=KissNearest())
    cells = int(np.ceil(30 / wide[0]) * np.ceil(20 / high[0]))
    assert cells > 1 and len(found.uv) == 4 + cells and found.merged.sum() == cells
    assert found.area.sum() == (image > 60).sum()


def test_the_covariance_is_that_of_clean_discs():
    """For single diameters the error swings about the mean that (B) gives; over diameters it is met."""
    ratios = {method: [] for method in METHODS}
    for k, diameter in enumerate(np.arange(5, 12.1, 0.4)):
        images, truth = discs(40, diameter, (0.0, 0.6)[k % 2], 1.0, np.random.default_rng(k), peak=200.0)
        for method in METHODS:
            found = detect_frames(images, method=method)
            variance = np.diagonal(found.cov, axis1=1, axis2=2)
            ratios[method].append(((found.uv - truth) ** 2 / variance).mean(0))
    for each in ratios.values():
        assert (np.mean(each, 0) > 0.85).all() and (np.mean(each, 0) < 1.2).all()
        assert np.min(each) > 0.25 and np.max(each) < 2.1  # 0.35 to 1.75, and what 40 discs stray


def test_the_covariance_of_separated_markers_holds_on_average():
    rng, images, true = np.random.default_rng(2), [], []
    for _ in range(150):
        d, apart, turn = rng.uniform(8, 12), rng.uniform(0.75, 1.0), rng.uniform(0, np.pi)
        half = d * apart / 2 * np.array([np.cos(turn), np.sin(turn)])
        images.append(np.maximum(disc(*half, d, 0.0), disc(*-half, d, 0.0)))
        true.append([12 + half, 12 - half])
    found = detect_frames(np.array([10 + 190 * i for i in images]).astype(np.uint8), method=KissScanning(near_x=6.0))
    ends, ratios = np.cumsum(found.counts), []
    for f in np.flatnonzero(found.counts == 2):
        uv, cov = found.uv[ends[f] - 2 : ends[f]], found.cov[ends[f] - 2 : ends[f]]
        same_order = np.linalg.norm(uv - true[f]) < np.linalg.norm(uv[::-1] - true[f])
        off = uv - (true[f] if same_order else true[f][::-1])
        ratios.append((off**2 / np.diagonal(cov, axis1=1, axis2=2)).mean())
    assert len(ratios) > 100
    assert 0.4 < np.mean(ratios) < 1.6


@pytest.mark.parametrize("method", METHODS)
def test_frames_do_not_know_of_each_other(method):
    images = np.concatenate([blotches(1, (5, 40, 56)), np.zeros((2, 40, 56), np.uint8), blotches(2, (1, 40, 56))])
    together = detect_frames(images, method=method)
    alone = [detect_frames(image[None], method=method) for image in images]
    assert same(together, type(together)(*(np.concatenate(column) for column in zip(*alone, strict=True))))
    assert together.counts[5] == 0 < together.counts[7]


@pytest.mark.parametrize("method", METHODS)
def test_sixteen_bits_and_negatives_are_the_same_images(method):
    images = blotches(4, (2, 40, 56))
    plain = detect_frames(images, method=method)
    deep = detect_frames(images.astype(np.uint16) * 257, method=method)
    assert len(plain.uv) > 10
    negative = detect_frames(255 - images, method=replace(method, threshold=195.0, inverted=True))
    assert same(plain, deep._replace(peak=deep.peak / 257))
    assert same(plain, negative._replace(peak=255 - negative.peak))


@pytest.mark.parametrize("method", METHODS)
def test_a_relative_threshold_does_not_mind_the_lamp_or_the_ground(method):
    image = drawn((20, 20, 12), (50, 40, 10), (30, 65, 11))
    method = replace(method, relative_threshold=0.4)
    plain = detect_frames(image, method=method)
    dimmed = detect_frames((30 + image // 5).astype(np.uint8), method=method)
    negative = detect_frames(255 - image, method=replace(method, inverted=True))
    dark = detect_frames((255 - image) // 2, method=replace(method, inverted=True))
    assert len(plain.uv) == 3
    for other in (dimmed, negative, dark):
        assert same(plain._replace(peak=other.peak), other)
    assert len(detect_frames(np.full((2, 40, 50), 33, np.uint8), method=method).uv) == 0


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("shape", [(0, 8, 9), (1, 1, 1), (3, 1, 7), (2, 9, 1), (2, 30, 40)])
def test_empty_tiny_and_white_images_are_no_trouble(method, shape):
    for level in (0, 255):
        found = detect_frames(np.full(shape, level, np.uint8), method=method)
        assert len(found.counts) == shape[0] and found.counts.sum() == len(found.uv)
        assert len(found.uv) == 0 if level == 0 or (1 in shape[1:] and isinstance(method, KissScanning)) else True


@pytest.mark.parametrize("method", METHODS)
def test_a_threshold_in_the_noise_is_an_error(method):
    noise = np.random.default_rng(0).integers(0, 2, (1, 400, 600), np.uint8) * 120
    noise[:, ::2], noise[:, :, ::2] = 0, 0
    sparse = replace(method, **({"near_x": 0.5} if isinstance(method, KissScanning) else {"neighbourhood": 1}))
    with pytest.raises(KinemarkError, match="lies in the noise"):
        detect_frames(noise, method=sparse)


@pytest.mark.parametrize(
    "wrong",
    [
        {"threshold": 255},
        {"near_x": -1},
        {"near_y": 0},
        {"noise_width": -1},
        {"min_inside": 0},
        {"small_rows": 0},
        {"relative_threshold": 1.0},
        {"overlap_fill": 1.5},
        {"row_overlap": 0},
        {"min_ratio": 0.9, "max_ratio": 1.2},
        {"min_area": 10, "max_area": 9},
    ],
)
def test_impossible_parameters_are_refused(wrong):
    with pytest.raises(ValueError, match="wanted"):
        KissScanning(**wrong)
    if next(iter(wrong)) in ("threshold", "noise_width", "relative_threshold"):
        with pytest.raises(ValueError, match="wanted"):
            KissNearest(**wrong)
    with pytest.raises(ValueError, match="wanted"):
        KissNearest(split_factor=0.5)


def test_numbered_keeps_runs_in_scan_order_within_groups():
    runs = Runs(*(np.array(c) for c in ([0, 0, 1, 1, 2], [0, 5, 0, 5, 5], [1, 6, 1, 6, 6])))
    groups = numbered(*runs, np.array([7, 3, 7, 3, 3]), height=2)
    assert groups.of.tolist() == [0, 0, 1, 1, 1] and groups.y.tolist() == [0, 1, 0, 1, 2]


def test_the_study_has_the_papers_numbers(tmp_path):
    """All 148 fields; the paper's machine took less than 2 s for them, and half of the time of the former method."""
    text = printed("kiss_detection", "--pictures", tmp_path, "--figure", tmp_path / "steps.svg")
    lines = [line for line in text.splitlines()[1:] if line.strip()]
    table = {line[:56].strip(): line[63:].split() for line in lines}
    for what, count in (
        ("manual image, without advanced analysis", "10"),
        ("manual image, with sub-marker detection", "8"),
        ("manual image, with all tests but the size", "12"),
        ("with size limits: markers", "12"),
        ("of these invalid", "4"),
        ("calibration frame, valid", "24"),
        ("linearisation grid, invalid", "0"),
        ("calibration frame, invalid", "1"),
    ):
        assert table[what][0] == count, what
    assert table["linearisation grid, valid"] == ["300"] * 3
    for what in ("whole", "half hidden", "close or overlapping"):
        name = next(name for name in table if name.startswith(f"gait, 148 fields: {what}"))
        assert table[name][0] == name.split()[-1], name
    assert int(table["detections of no marker"][0]) <= 2
    assert float(table["seconds"][0]) < 1.0
    assert 0.2 < float(table["time by the time of the former method"][0]) < 0.9
    assert len(list(tmp_path.glob("*.png"))) == 5
    five = next(name for name in table if name.startswith("fig. 12, five fields"))
    assert table[five][0] == five.split()[-1]
    figure = (tmp_path / "gait.svg").read_text("utf-8")
    assert figure.count("<image") == 5 and figure.count("<rect") - 1 == sum(
        map(int, re.findall(r": (\d+) markers, \d+ invalid</text>", figure))
    )
    assert ElementTree.parse(tmp_path / "steps.svg").getroot().tag.endswith("svg")


def test_the_manual_image_has_twelve_markers_that_every_step_needs(monkeypatch):
    """Without any one of the three tests, or of the noise criteria, the number is not the paper's."""
    monkeypatch.syspath_prepend(STUDIES)
    image = importlib.import_module("kiss_detection").manual_image()[None]
    full = KissScanning(check_sizes=False)
    assert len(detect_frames(image, method=full).uv) == 12
    for step in ("sub_markers", "overlaps", "long_wide"):
        assert len(detect_frames(image, method=replace(full, **{step: False})).uv) != 12
    for line in ("one_wide", "one_high"):
        assert len(detect_frames(image, method=replace(full, **{line: False})).uv) > 12
