"""Mosaics show every camera at the frame of the number, and a part of an image is that part."""

import av
import numpy as np
import pytest

from kinemark import KinemarkError
from kinemark.engine.pictures.mosaics import BACK, Mosaics, layout_of
from kinemark.io.exact_video import ExactVideo
from kinemark.io.images import open_images
from support.numbered_video import WIDTH, bars, number, write_numbered

FRAMES = 120


def image_in(content, codec):
    return av.CodecContext.create(codec, "r").decode(av.Packet(content))[0].to_ndarray(format="gray")


def shifted(k):
    """Cameras differ: camera k has the number of frame n + 500 k."""
    return lambda n: bars(n + 500 * k)


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    folder = tmp_path_factory.mktemp("videos")
    kinds = {"c0": ("c0.mkv", 60), "c1": ("c1.mp4", 250), "c2": ("c2.avi", 30)}
    return {
        name: open_images(write_numbered(folder / file, FRAMES, group=group, image=shifted(k)))
        for k, (name, (file, group)) in enumerate(kinds.items())
    }


def shown(mosaics, n):
    whole = image_in(mosaics.jpeg(n), "mjpeg")
    assert whole.shape == (mosaics.layout.height, mosaics.layout.width)
    return [number(whole[t.y : t.y + t.height, t.x : t.x + t.width]) for t in mosaics.layout.tiles]


def test_all_tiles_are_of_the_frame_asked_for_made_or_kept(sources, tmp_path):
    mosaics = Mosaics(sources, tmp_path / "kept")
    asked = [*np.random.default_rng(0).integers(0, FRAMES, 40).tolist(), 5, 6, 7, 8, 7, 6, 5]
    for n in asked:
        assert shown(mosaics, n) == [n, n + 500, n + 1000]
    mosaics.close()
    again = Mosaics(sources, tmp_path / "kept")
    assert len(list((tmp_path / "kept").iterdir())) >= len(set(asked))
    assert all(shown(again, n) == [n, n + 500, n + 1000] for n in asked)
    again.close()


def test_what_is_decoded_on_the_way_to_a_frame_is_kept(sources, tmp_path):
    mosaics = Mosaics(sources, tmp_path / "kept")
    mosaics._ahead = lambda asked: None
    assert shown(mosaics, 100) == [100, 600, 1100]
    there = [n for n in range(FRAMES) if mosaics.ready(n)]
    assert there == [*range(100 - BACK, 101)]
    assert shown(mosaics, 103) == [103, 603, 1103] and mosaics.ready(101) and mosaics.ready(102)
    mosaics.close()


@pytest.mark.parametrize(("n", "step"), [(60, 1), (60, -1), (60, 10), (0, -1), (FRAMES - 1, 1)])
def test_frames_about_the_one_asked_for_are_made_behind(sources, tmp_path, n, step):
    mosaics = Mosaics(sources, tmp_path / "kept")
    mosaics._ahead((n, step))
    assert not mosaics.ready(n) and not any(mosaics.ready(k) for k in range(FRAMES))  # nobody asked for it
    mosaics._asked = n, step
    mosaics._ahead((n, step))
    near = {k for k in range(n - BACK // 2, n + BACK) if 0 <= k < FRAMES and k != n}
    assert near <= {k for k in range(FRAMES) if mosaics.ready(k)}
    mosaics.close()


def test_where_nothing_can_be_kept_they_are_made_again(sources, tmp_path):
    (tmp_path / "file").write_text("in the way")
    mosaics = Mosaics(sources, tmp_path / "file" / "kept")
    assert shown(mosaics, 9) == [9, 509, 1009] == shown(mosaics, 9)
    mosaics.close()


def test_no_more_is_kept_than_the_limit_and_what_was_used_stays(sources, tmp_path):
    one = len(Mosaics(sources, tmp_path / "probe").jpeg(0))
    mosaics = Mosaics(sources, tmp_path / "kept", recording="a", most=10 * one)
    mosaics._ahead = lambda asked: None
    for n in range(30):
        assert shown(mosaics, n) == [n, n + 500, n + 1000]
        mosaics.jpeg(3)
    files = {file.name: file.stat().st_size for file in (tmp_path / "kept" / "a").iterdir()}
    assert 8 * one < sum(files.values()) <= 10 * one
    assert "0000003.jpg" in files and "0000029.jpg" in files and "0000005.jpg" not in files
    mosaics.close()
    other = Mosaics(sources, tmp_path / "kept", recording="b", most=4 * one)  # the trial was recorded anew
    other._ahead = lambda asked: None
    for n in range(5):
        other.jpeg(n)
    assert sum(file.stat().st_size for file in (tmp_path / "kept").rglob("*.jpg")) <= 4 * one
    assert not list((tmp_path / "kept" / "a").iterdir())
    other.close()


def test_tiles_lie_beside_each_other_within_the_whole(sources):
    for n in range(1, 13):
        layout = layout_of({f"c{k}": sources["c0"] for k in range(n)})
        covered = np.zeros((layout.height, layout.width), int)
        for tile in layout.tiles:
            covered[tile.y : tile.y + tile.height, tile.x : tile.x + tile.width] += 1
        assert len(layout.tiles) == n and covered.max() == 1


def test_a_part_is_exactly_that_part_or_refused(sources, tmp_path):
    mosaics = Mosaics(sources, tmp_path)
    part = image_in(mosaics.crop("c0", 37, 8, 4, 40, 10), "png")
    assert part.shape == (10, 40) and np.abs(part.astype(int) - bars(37)[4:14, 8:48]).max() < 40  # as H.264 left it
    for wrong in (
        ("c9", 1, 0, 0, 4, 4),
        ("c0", 1, 0, 0, WIDTH + 1, 4),
        ("c0", 1, 90, 0, 9, 4),
        ("c0", FRAMES, 0, 0, 4, 4),
    ):
        with pytest.raises(KinemarkError):
            mosaics.crop(*wrong)
    mosaics.close()


def test_the_first_frames_are_begun_unless_one_was_asked_for(sources, tmp_path):
    mosaics = Mosaics(sources, tmp_path / "kept")
    mosaics.begin()
    mosaics._behind.submit(lambda: None).result()
    assert all(mosaics.ready(n) for n in range(FRAMES))
    assert shown(mosaics, 7) == [7, 507, 1007]
    mosaics.close()


class Decoded:
    """Counts images as they are decoded, and asks for a frame in the midst of what is made behind."""

    def __init__(self, monkeypatch):
        self.count, self.at, self.then = 0, -1, None
        true = ExactVideo._keep

        def keep(video, n, image):
            self.count += 1
            if self.count == self.at:
                self.then()
            true(video, n, image)

        monkeypatch.setattr(ExactVideo, "_keep", keep)


@pytest.mark.parametrize("at", [1, 2, 40, 100])
def test_no_more_is_decoded_behind_once_a_frame_was_asked_for(sources, tmp_path, monkeypatch, at):
    mosaics = Mosaics(sources, tmp_path / "kept")
    decoded = Decoded(monkeypatch)
    decoded.at, decoded.then = at, lambda: setattr(mosaics, "_asked", (7, 1))  # as `jpeg` begins
    mosaics._asked = asked = 100, -1
    mosaics._ahead(asked)
    assert at <= decoded.count < at + len(sources)  # no camera more than the image that it was at
    monkeypatch.undo()
    assert all(shown(mosaics, n) == [n, n + 500, n + 1000] for n in (7, 99, 50, 51, 8))
    mosaics.close()


def test_a_step_on_decodes_one_image_of_each_camera(sources, tmp_path, monkeypatch):
    mosaics = Mosaics(sources, tmp_path / "kept")
    mosaics._ahead = lambda asked: None
    assert shown(mosaics, 40) == [40, 540, 1040]
    decoded = Decoded(monkeypatch)
    for n in range(41, 59):
        assert shown(mosaics, n) == [n, n + 500, n + 1000]
    assert decoded.count == 18 * len(sources)
    mosaics.close()


def test_what_was_decoded_on_the_way_is_a_picture_as_soon_as_the_answer_is_there(sources, tmp_path):
    mosaics = Mosaics(sources, tmp_path / "kept")
    for n in (0, 10, 20):
        assert shown(mosaics, n) == [n, n + 500, n + 1000]
        assert all(mosaics.ready(k) for k in range(n))
    mosaics._behind.submit(lambda: None).result()
    assert not mosaics._drawn
    mosaics.close()


def test_cameras_that_took_their_images_at_other_times_are_shown_in_time(sources, tmp_path):
    late = {"c0": 0, "c1": 3, "c2": -2}
    mosaics = Mosaics(sources, tmp_path / "kept", image_at=lambda camera, n: n - late[camera])
    for n in (60, 61, 100, 3, FRAMES - 3):
        assert shown(mosaics, n) == [n, n - 3 + 500, n + 2 + 1000]
    assert shown(mosaics, 1) == [1, 0, 1003], "no image was taken then: black"
    assert shown(mosaics, FRAMES - 1) == [FRAMES - 1, FRAMES - 4 + 500, 0]
    part = image_in(mosaics.crop("c1", 40, 8, 4, 40, 10), "png")
    assert np.abs(part.astype(int) - bars(537)[4:14, 8:48]).max() < 40
    assert not image_in(mosaics.crop("c1", 1, 8, 4, 40, 10), "png").any()
    for wrong in (-1, FRAMES):
        with pytest.raises(KinemarkError, match="was asked for"):
            mosaics.jpeg(wrong)
    mosaics.close()
