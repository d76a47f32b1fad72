"""Trying detection in one frame: what would be found is what a run finds; why is said; what is chosen is written."""

from concurrent.futures import ThreadPoolExecutor
from time import sleep

import numpy as np
import pytest

from kinemark.data import KinemarkError, Validity
from kinemark.data.masks import Masks
from kinemark.detect import Centroids
from kinemark.engine.detection import open_detection
from kinemark.engine.detection.open_detection import Draft, OpenDetection
from kinemark.engine.detection.settings_file import apply
from kinemark.engine.detection.why import why
from kinemark.engine.session import Session
from kinemark.engine.sources import Recording
from kinemark.engine.sources.images import Images
from kinemark.io.masks_toml import read_masks, write_masks
from kinemark.io.video import write_video
from support.sessions import folder_of
from support.tried import FRAMES, SIZE, scene, session_in

NOTHING = Draft()


@pytest.fixture(scope="module")
def opened(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tried")
    return OpenDetection(session_in(folder, "[detect]\nthreshold = 90\nmin_area = 6\nmax_area = 400"), "one")


@pytest.mark.parametrize(
    ("more", "frames", "lines"),
    [
        ("", "", 180),
        ("[detect]\nthreshold = 40\n[detect.cameras.c1]\nmin_area = 30", "frames = [6, 15]", 180),
        ("[detect]\nbackground = 'subtract'", "frames = [4, 18]", 180),
        ("[detect]\nrelative_threshold = 0.4", "", 180),
        ("[detect]\nmethod = 'kiss_scanning'", "", 180),
        ("[cameras]\ninterlaced = true", "", 90),
        ("[cameras]\ninterlaced = true\n[detect]\nbackground = 'subtract'", "frames = [4, 31]", 90),
        ("[masks]\nfile = 'masks.toml'", "", 180),
    ],
)
def test_what_would_be_found_is_what_a_run_finds(tmp_path, more, frames, lines):
    write_masks(tmp_path / "masks.toml", Masks(("c1",), np.array([SIZE]), ([[[50, 30], [150, 30], [150, 80]]],)))
    session = Session.open(session_in(tmp_path, more, frames, size=(SIZE[0], lines)))
    opened, entry = OpenDetection(tmp_path, "one"), session.trial("one").entry
    found = Images(Recording(tmp_path, session.settings, entry, session.calibrate().rig, entry.frames, tmp_path))
    found = found.detections()
    assert opened.n_frames == found.n_frames and len(found) > 2 * FRAMES
    for f in (0, 3, found.n_frames - 1):
        for c in range(2):
            own = opened.detected(f"c{c}", opened.first + f, NOTHING)
            np.testing.assert_array_equal(own.blobs.uv, found.uv[found.rows(c, f)])
            np.testing.assert_array_equal(own.blobs.validity, found.validity[found.rows(c, f)])


def test_what_a_camera_leaves_open_is_learned_once_however_many_ask_meanwhile(tmp_path, monkeypatch):
    asked, real = [], open_detection.for_camera
    monkeypatch.setattr(open_detection, "for_camera", lambda *what: (asked.append(1), sleep(0.1), real(*what))[-1])
    opened = OpenDetection(session_in(tmp_path), "one")
    with ThreadPoolExecutor(4) as pool:
        found = [*pool.map(lambda frame: opened.detected("c0", frame, NOTHING).method, (1, 2, 3, 4))]
    assert len(asked) == 1 and len({*found}) == 1


def test_a_draft_changes_what_is_found_and_writes_nothing(opened):
    before = (opened.session.root / "session.toml").read_bytes()
    dim, lost = Draft({"threshold": 40.0}), opened.detected("c0", 5, NOTHING)
    found = opened.detected("c0", 5, dim)
    assert (found.blobs.validity == Validity.VALID).sum() == (lost.blobs.validity == Validity.VALID).sum() + 1
    one = Draft(cameras={"c1": {"threshold": 40.0}})
    assert opened.detected("c0", 5, one).method == lost.method and opened.detected("c1", 5, one).method.threshold == 40
    tried = Draft(masks={"c0": (np.array([[50, 40], [90, 40], [90, 60], [50, 60.0]]),)})
    assert (opened.detected("c0", 5, tried).blobs.validity == Validity.MASKED).sum() == 1
    assert {*opened.session.root.iterdir()} >= {opened.session.root / "c0.mkv"}
    assert (opened.session.root / "session.toml").read_bytes() == before
    with pytest.raises(KinemarkError, match="threshold is 300"):
        opened.detected("c0", 5, Draft({"threshold": 300.0}))
    with pytest.raises(KinemarkError, match="'thresold' is not a parameter"):
        opened.methods(Draft({"thresold": 30.0}))


@pytest.mark.parametrize(
    ("place", "draft", "words", "parameter"),
    [
        ((68, 50), {}, "A marker:", ""),
        ((176, 120), {}, "Not white: grey level 5", "threshold"),
        ((60, 100), {}, "as the ground of the whole image is", ""),
        ((68, 50), {"min_area": 200}, "Too small:", "min_area"),
        ((205, 150), {}, "Too large:", "max_area"),
        ((110, 21), {}, "Not round:", "max_aspect"),
        ((2, 90), {}, "At the edge", ""),
        ((30, 150), {}, "Noise:", "min_width"),
    ],
)
def test_why_a_place_is_a_marker_or_none(opened, place, draft, words, parameter):
    found = opened.detected("c0", 5, Draft(draft))
    said = why(found, *place)
    assert words in said.words and said.parameter == parameter
    if parameter:  # with the value that is named, it is another thing
        value = said.value
        again = why(opened.detected("c0", 5, Draft(draft | {parameter: value})), *place)
        assert again.parameter != parameter, again
        assert again.words.startswith("A marker:") or parameter in ("min_width", "max_area", "max_aspect"), again


def test_why_not_outside(opened):
    with pytest.raises(ValueError, match="outside the image of 240 × 180"):
        why(opened.detected("c0", 5, NOTHING), 240, 10)
    masked = Draft(masks={"c0": (np.array([[50, 40], [90, 40], [90, 60], [50, 60.0]]),)})
    assert why(opened.detected("c0", 5, masked), 68, 50).words.startswith("Masked:")


def test_dark_markers_are_explained_the_other_way_round(tmp_path):
    session_in(tmp_path, "[detect]\ninverted = true\nthreshold = 90")
    for c in range(2):
        write_video(tmp_path / f"c{c}.mkv", np.stack([255 - scene(f) for f in range(FRAMES)]), 100.0)
    opened = OpenDetection(tmp_path, "one")
    said = why(opened.detected("c0", 5, NOTHING), 176, 120)
    assert "at least" in said.words and "Raise it above" in said.words
    again = why(opened.detected("c0", 5, Draft({"threshold": said.value})), 176, 120)
    assert again.words.startswith("A marker:")


def test_what_is_chosen_is_written_and_comments_stay(tmp_path):
    session_in(
        tmp_path, "[detect] # as tried\nthreshold = 90 # too high?\nmax_area = 400\n[detect.cameras.c0]\nmin_area = 9"
    )
    chosen = Draft(
        {"threshold": 40.0, "max_area": None, "min_area": 3}, {"c0": {"min_area": None}, "c1": {"threshold": 35.5}},
        {"c1": (np.array([[0, 0], [20, 0], [20, 20], [0, 20.0]]),)},
    )  # fmt: skip
    before = OpenDetection(tmp_path, "one")
    tried = [before.detected(name, 5, chosen) for name in ("c0", "c1")]
    apply(before, chosen)
    text = (tmp_path / "session.toml").read_text("utf-8")
    for kept in ("# of the knee study", "# by hand", "# raw", "[detect] # as tried", "threshold = 40 # too high?"):
        assert kept in text
    assert "max_area" not in text and "cameras.c0" not in text and "[detect.cameras.c1]\nthreshold = 35.5" in text
    after = OpenDetection(tmp_path, "one")
    for one, name in zip(tried, ("c0", "c1"), strict=True):
        again = after.detected(name, 5, NOTHING)
        assert again.method == one.method
        np.testing.assert_array_equal(again.blobs.uv, one.blobs.uv)
        np.testing.assert_array_equal(again.blobs.validity, one.blobs.validity)
    apply(after, Draft(masks={"c0": (np.array([[1, 1], [2, 1], [2, 2.0]]),)}))
    assert read_masks(tmp_path / "masks.toml").cameras == ("c1", "c0"), "those of other cameras stay"
    apply(OpenDetection(tmp_path, "one"), Draft(masks={"c0": (), "c1": ()}))
    assert not any(read_masks(tmp_path / "masks.toml").polygons) and len(Session.open(tmp_path).names) == 1


def test_what_would_not_be_understood_is_not_written(tmp_path):
    session_in(tmp_path, "[digitise]\nmarkers = ['A']", 'answers = "{camera}.csv"')
    before = (tmp_path / "session.toml").read_bytes()
    opened = OpenDetection(tmp_path, "one")
    with pytest.raises(KinemarkError, match=r"leave out \[detect.cameras\]"):
        apply(opened, Draft(cameras={"c0": {"threshold": 40.0}}))
    assert (tmp_path / "session.toml").read_bytes() == before and not list(tmp_path.glob(".session*"))
    image = opened.image("c0", 3)
    assert opened.detected("c0", 3, NOTHING).method == Centroids(aspect=1.0), "as the operator's image is"
    np.testing.assert_array_equal(image, scene(2))


def test_a_trial_without_images_says_so(tmp_path):
    with pytest.raises(KinemarkError, match="one has no images"):
        OpenDetection(folder_of(tmp_path)[0], "one")
