"""Masks: pixels within polygons, what they do to detections, how they are learned, and their file."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from kinemark.data import KinemarkError, Validity
from kinemark.data.masks import rasterised
from kinemark.detect import Centroids, Masks, combined_masks, detect, detect_frames, learn_masks
from kinemark.detect.masks import masked, rectangles
from kinemark.io.masks_toml import change_masks, read_masks, write_masks
from support.examples import examples
from support.films import Film

W, H = 90, 60


def spots(places, n=1, size=6):
    """(n, H, W) images with square spots whose first pixels are at these places (x, y)."""
    images = np.full((n, H, W), 10, np.uint8)
    for x, y in places:
        images[:, y : y + size, x : x + size] = 200
    return images


def masks(*polygons, name="a", size=(W, H)):
    return Masks((name,), np.array([size]), (tuple(np.array(p, float) for p in polygons),))


def within(x, y, polygon):
    """Whether a point lies in a polygon, by the angles under which it sees the sides."""
    a = np.array(polygon, float) - [x, y]
    b = np.roll(a, -1, axis=0)
    turn = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(1)).sum()
    return round(turn / (2 * np.pi)) % 2 == 1


@settings(max_examples=examples(40), deadline=None)
@given(seed=st.integers(0, 10**6), corners=st.integers(3, 8))
def test_pixels_are_those_whose_centres_lie_within(seed, corners):
    polygon = np.random.default_rng(seed).uniform(-8, 30, (corners, 2))  # may cross itself and leave the image
    mask = rasterised(polygon, 24, 18)
    expected = [[within(x, y, polygon) for x in range(24)] for y in range(18)]
    np.testing.assert_array_equal(mask, expected)


@settings(max_examples=examples(12), deadline=None)
@given(seed=st.integers(0, 10**6))
def test_rectangles_cover_exactly_what_is_masked(seed):
    rng = np.random.default_rng(seed)
    mask = ndimage.gaussian_filter(rng.normal(size=(H, W)), 2) > rng.uniform(-0.1, 0.3)
    whole = Masks(("a",), np.array([[W, H]]), (rectangles(mask),))
    np.testing.assert_array_equal(whole.pixels("a"), mask)
    number = [sum(rasterised(p, W, H)[y, x] for p in whole.polygons[0]) for y, x in ((5, 5), (30, 40), (50, 80))]
    assert max(number) <= 1  # none twice


def test_what_lies_in_a_mask_is_kept_with_its_reason():
    images = spots([(10, 10), (40, 30)])
    everywhere = detect_frames(images)
    found = masked(everywhere, masks([(5, 5), (25, 5), (25, 25), (5, 25)]).pixels("a"))
    assert found.validity.tolist() == [Validity.MASKED, Validity.VALID]
    np.testing.assert_array_equal(found.uv, everywhere.uv)
    assert not found.merged.any()


@pytest.mark.parametrize(
    ("edge", "validity", "merged"), [(9.4, 0, False), (11.5, 0, True), (14.6, 5, False), (20, 5, False)]
)
def test_what_a_mask_touches_is_merged_and_what_it_holds_is_masked(edge, validity, merged):
    """A spot over the columns 10 … 15, and a mask up to `edge`."""
    found = masked(detect_frames(spots([(10, 10)])), masks([(0, 0), (edge, 0), (edge, 50), (0, 50)]).pixels("a"))
    assert found.validity.tolist() == [validity] and found.merged.tolist() == [merged]


def flickering(seed, n=40):
    """An empty volume: a strobe in every third frame, a steady lamp, and a speck of noise once."""
    images = np.random.default_rng(seed).normal(12, 2, (n, H, W)).clip(0, 40).astype(np.uint8)
    images[::3, 10:20, 60:75] = 230
    images[:, 40:46, 20:24] = 180
    images[7, 50, 80] = 255
    return images


def test_an_empty_recording_shows_what_is_no_marker():
    empty, trial = flickering(0), flickering(1)
    trial[:, 25:31, 50:56] = 220  # the only marker
    learned = learn_masks([Film(empty)], cameras=["a"], grow=2.0)
    mask = learned.pixels("a")
    assert mask[10:20, 60:75].all() and mask[40:46, 20:24].all() and not mask[50, 80] and not mask[25:31, 50:56].any()
    assert mask[8, 65] and not mask[7, 65] and mask[9, 59] and not mask[8, 58]  # 2 px farther, round at corners
    found = detect([Film(trial)], cameras=["a"], rate=50.0, masks=learned)
    assert found.valid.sum() == len(trial)
    assert (found.validity == Validity.MASKED).sum() == len(trial) + len(trial[::3])
    np.testing.assert_allclose(found.uv[found.valid], [[52.5, 27.5]] * len(trial), atol=0.1)
    again = learn_masks([Film(empty)], cameras=["a"], grow=2.0, share=0.5)
    assert not again.pixels("a")[10:20, 60:75].any()  # the strobe is white in a third of the frames


def test_dark_markers_have_dark_masks():
    empty = np.invert(flickering(0))
    learned = learn_masks([Film(empty)], cameras=["a"], method=Centroids(threshold=150, inverted=True))
    assert learned.pixels("a")[10:20, 60:75].all() and learned.pixels("a").mean() < 0.2


def test_cameras_without_a_mask_see_everything():
    films = [Film(spots([(10, 10), (40, 30)], 20)) for _ in range(2)]
    found = detect(films, cameras=["a", "b"], rate=50.0, masks=masks([(5, 5), (25, 5), (25, 25)], name="b"))
    assert found.valid[found.camera == 0].all() and found.valid[found.camera == 1].sum() == 20


def test_masks_of_both_kinds_are_one():
    drawn, learned = masks([(0, 0), (20, 0), (20, 20)]), masks([(50, 5), (70, 5), (70, 30), (50, 30)])
    both = combined_masks(drawn, learned)
    np.testing.assert_array_equal(both.pixels("a"), drawn.pixels("a") | learned.pixels("a"))
    assert combined_masks(drawn, masks(name="b")).cameras == ("a", "b")
    with pytest.raises(KinemarkError, match="90 × 60 and 60 × 90"):
        combined_masks(drawn, masks(size=(H, W)))


def test_what_does_not_fit_is_refused():
    film = Film(spots([(10, 10)], 3))
    with pytest.raises(KinemarkError, match=r"masks of c.*recording has a"):
        detect([film], cameras=["a"], rate=50.0, masks=masks(name="c"))
    with pytest.raises(KinemarkError, match=r"Camera a: its mask is for images of 60 × 90"):
        detect([film], cameras=["a"], rate=50.0, masks=masks(size=(H, W)))
    with pytest.raises(KinemarkError, match="no frames"):
        learn_masks([Film(spots([], 0))], cameras=["a"])
    for wrong in (
        {"share": 0.0},
        {"share": 1.1},
        {"grow": -1.0},
        {"method": Centroids(relative_threshold=0.5)},
        {"cameras": []},
    ):
        with pytest.raises(ValueError, match="wanted"):
            learn_masks([film], **{"cameras": ["a"]} | wrong)
    for polygon in ([(0, 0), (1, 1)], [(0, 0, 0)] * 3, [(0, 0), (1, np.nan), (2, 2)]):
        with pytest.raises(ValueError, match="polygon"):
            masks(polygon)
    with pytest.raises(ValueError, match="each name once"):
        Masks(("a", "a"), np.array([[W, H]] * 2), ((), ()))
    with pytest.raises(ValueError, match="not among"):
        masks().pixels("b")


@settings(max_examples=examples(12), deadline=None)
@given(seed=st.integers(0, 10**6), names=st.lists(st.text(min_size=1, max_size=8), unique=True, max_size=3))
def test_the_file_reads_back_the_same(tmp_path_factory, seed, names):
    rng = np.random.default_rng(seed)
    polygons = tuple(
        tuple(rng.uniform(-5, 700, (rng.integers(3, 7), 2)) for _ in range(rng.integers(0, 3))) for _ in names
    )
    before = Masks(tuple(names), rng.integers(1, 2000, (len(names), 2)), polygons)
    path = tmp_path_factory.mktemp("m") / "masks.toml"
    write_masks(path, before)
    after = read_masks(path)
    assert after.cameras == before.cameras
    np.testing.assert_array_equal(after.sizes, before.sizes)
    for name, (width, height) in zip(names, before.sizes, strict=True):
        if width * height < 10**6:
            np.testing.assert_array_equal(after.pixels(name), before.pixels(name))
    assert [len(own) for own in after.polygons] == [len(own) for own in before.polygons]


WRITTEN = """# masks of the knee study
[[camera]] # by the window
name = "c1"
size = [240, 180]
# what shines there
polygons = [
    [[1.0, 2.0], [3.0, 4], [5, 6]],  # the lamp
    # the sign, since March
    [[10, 2], [3, 4], [5, 6]],
]

[[camera]]  # nobody moves this one
name = "c2"
size = [240, 180]
polygons = [[[0, 0], [1, 0], [1, 1]]]
"""
LAMP, SIGN, BOX = [[1, 2], [3, 4], [5, 6]], [[10, 2], [3, 4], [5, 6]], [[0, 0], [1, 0], [1, 1]]
NEW = [[7.5, 7], [8, 8], [9, 7]]


@pytest.mark.parametrize("line", ["\n", "\r\n"])
@pytest.mark.parametrize(
    "wanted",
    [
        {"c1": [LAMP, SIGN], "c2": [BOX]},
        {"c1": [SIGN, NEW], "c2": [BOX]},
        {"c1": [LAMP, NEW, SIGN], "c2": []},
        {"c3": [NEW, LAMP]},
        {},
    ],
)
def test_a_file_that_is_changed_says_what_is_wanted_and_keeps_its_comments(tmp_path, wanted, line):
    path = tmp_path / "masks.toml"
    path.write_bytes(WRITTEN.replace("\n", line).encode())
    polygons = tuple(tuple(np.array(one, float) for one in own) for own in wanted.values())
    change_masks(path, Masks(tuple(wanted), np.array([[240, 180]] * len(wanted)).reshape(-1, 2), polygons))
    after = read_masks(path)
    said = {name: sorted(p.tolist() for p in own) for name, own in zip(after.cameras, after.polygons, strict=True)}
    assert said == {"c1": [], "c2": []} | {name: sorted(own) for name, own in wanted.items()}
    text = path.read_bytes().decode()
    for comment in ("# masks of the knee study", "# by the window", "# what shines there", "# nobody moves this one"):
        assert comment in text
    assert ("# the lamp" in text) == (LAMP in wanted.get("c1", []))
    if wanted == {"c1": [LAMP, SIGN], "c2": [BOX]}:
        assert text == WRITTEN.replace("\n", line)


def test_a_file_that_is_not_there_is_written_and_one_that_is_none_is_refused(tmp_path):
    one = Masks(("c1",), np.array([[9, 9]]), ((np.array(NEW),),))
    change_masks(tmp_path / "masks.toml", one)
    assert read_masks(tmp_path / "masks.toml").cameras == ("c1",)
    (tmp_path / "none.toml").write_text("camera = 3", "utf-8")
    with pytest.raises(KinemarkError, match="must be tables"):
        change_masks(tmp_path / "none.toml", one)
    (tmp_path / "empty.toml").write_text("# nothing yet\n", "utf-8")
    change_masks(tmp_path / "empty.toml", one)
    assert read_masks(tmp_path / "empty.toml").cameras == ("c1",)
    assert (tmp_path / "empty.toml").read_text("utf-8").startswith("# nothing yet")


GOOD = '[[camera]]\nname = "a"\nsize = [9, 9]\npolygons = [[[0, 0], [5, 0], [5, 5]]]\n'


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[[camera", "no TOML"),
        ("camera = 3", "must be tables"),
        (GOOD + "[other]\n", "has other"),
        (GOOD.replace("size = [9, 9]", "size = [9]"), "camera a has size"),
        (GOOD.replace("size = [9, 9]", "size = [9, 0]"), "camera a has size"),
        (GOOD.replace("[5, 5]]]", "[5, 5, 5]]]"), "polygons"),
        (GOOD.replace(", [5, 0], [5, 5]", ""), "polygon"),
        (GOOD.replace("name", "nam"), "wanted name, size and polygons"),
        (GOOD + GOOD, "each name once"),
    ],
)
def test_what_is_wrong_in_a_file_is_said(tmp_path, text, says):
    path = tmp_path / "masks.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(KinemarkError, match=says):
        read_masks(path)


def test_an_absent_file_is_named(tmp_path):
    with pytest.raises(KinemarkError, match=r"none\.toml"):
        read_masks(tmp_path / "none.toml")


def test_masks_are_learned_with_each_cameras_own_settings():
    """A dim lamp is masked where that camera's threshold is low, and nowhere else."""
    dim = np.full((10, H, W), 10, np.uint8)
    dim[:, 20:26, 30:36] = 60
    sources = [Film(dim), Film(dim)]
    low = {"b": Centroids(threshold=40)}
    learned = learn_masks(sources, cameras=("a", "b"), method=Centroids(threshold=100), of_cameras=low)
    assert not learned.pixels("a").any() and learned.pixels("b")[20:26, 30:36].all()
    with pytest.raises(ValueError, match="of_cameras names c, and the cameras are a, b"):
        learn_masks(sources, cameras=("a", "b"), of_cameras={"c": Centroids()})
    with pytest.raises(ValueError, match=r"relative_threshold is 0\.5"):
        learn_masks(sources, cameras=("a", "b"), of_cameras={"b": Centroids(relative_threshold=0.5)})
