"""While the images of a recording are read in order, small pictures of them are made, and a mosaic is made of these."""

import numpy as np
import pytest

from kinemark import KinemarkError
from kinemark.engine.pictures.mosaics import Mosaics
from kinemark.engine.pictures.small_videos import FOLDER, small_images, watched
from kinemark.engine.session import Session
from kinemark.engine.simulate import Scene, simulate
from kinemark.engine.sources.excerpt import Excerpt
from kinemark.io.exact_frames import ExactImages
from kinemark.io.images import open_images
from kinemark.io.video import has_dependent_frames
from support.numbered_video import HEIGHT, WIDTH, bars, number, write_numbered

FRAMES = 120


def shifted(k):
    """Cameras differ: camera k has the number of frame n + 500 k."""
    return lambda n: bars(n + 500 * k)


@pytest.fixture(scope="module")
def images(tmp_path_factory):
    """Three cameras, one of which has key frames alone."""
    folder = tmp_path_factory.mktemp("videos")
    kinds = {"c0": ("c0.mkv", "libx264"), "c1": ("c1.mp4", "libx264"), "c2": ("c2.mkv", "mjpeg")}
    return {
        name: open_images(write_numbered(folder / file, FRAMES, group=60, image=shifted(k), codec=codec))
        for k, (name, (file, codec)) in enumerate(kinds.items())
    }


def read(sources):
    """All of each camera, as detection reads it."""
    return [np.concatenate(list(source.batches(16))) for source in sources]


def made(images, results, first=0, stop=FRAMES, **more):
    """Small videos of what is between two frames."""
    taken = {name: Excerpt(source, first, stop) for name, source in images.items()}
    return read(watched(images, taken, first, results, **more))


def shown(mosaics, n):
    """The number in each tile, of the small pictures themselves."""
    return [number(mosaics._small_image(tile.camera, n)) for tile in mosaics.layout.tiles]


def test_frames_that_need_others_are_told_from_those_that_do_not(images, tmp_path):
    assert [has_dependent_frames(source.paths[0]) for source in images.values()] == [True, True, False]
    alone = write_numbered(tmp_path / "alone.mkv", 20, group=1, reordered=0)
    damaged = tmp_path / "none.mkv"
    damaged.write_bytes(b"no video")
    assert not has_dependent_frames(alone) and not has_dependent_frames(damaged)


def test_what_is_read_is_what_it_was_and_every_small_picture_is_of_its_frame(images, tmp_path, monkeypatch):
    for found, source in zip(made(images, tmp_path), images.values(), strict=True):
        assert np.array_equal(found, np.stack(list(source.frames())))
    small = small_images(images, tmp_path)
    assert list(small) == ["c0", "c1"]  # of the third an image is as soon decoded
    with Opened(monkeypatch) as opened:
        mosaics = Mosaics(images, tmp_path / "mosaics", small=small)
        for n in (0, 119, 60, 59, 7):
            assert shown(mosaics, n) == [n, n + 500, n + 1000]
            assert mosaics._start(n) <= n
        assert opened.paths == {images["c2"].paths[0]}, "the others were not decoded"
    mosaics.close()


class Opened:
    """Which recordings are opened for their images."""

    def __init__(self, monkeypatch):
        self.paths, self.monkeypatch = set(), monkeypatch

    def __enter__(self):
        true = ExactImages.__init__

        def begin(self_, source):
            self.paths.add(source.paths[0])
            true(self_, source)

        self.monkeypatch.setattr(ExactImages, "__init__", begin)
        return self

    def __exit__(self, *_):
        self.monkeypatch.undo()


def test_of_a_stretch_there_are_small_pictures_and_the_rest_is_decoded(images, tmp_path):
    made(images, tmp_path, 30, 50)
    small = small_images(images, tmp_path)
    assert small["c0"].frames == range(30, 50)
    mosaics = Mosaics(images, tmp_path / "mosaics", small=small)
    for n in (29, 30, 49, 50, 0, 119):
        assert shown(mosaics, n) == [n, n + 500, n + 1000]
    mosaics.close()


def test_of_several_stretches_the_longest_is_taken(images, tmp_path):
    made(images, tmp_path, 5, 100)
    made(images, tmp_path, 30, 50)
    made(images, tmp_path, 70, 90)
    assert small_images(images, tmp_path)["c0"].frames == range(5, 100)


def test_what_was_not_read_to_its_end_leaves_nothing(images, tmp_path):
    reading = watched(images, images, 0, tmp_path)[0].batches(16)
    next(reading)
    assert list(tmp_path.rglob("*.part"))
    reading.close()
    assert not [path for path in tmp_path.rglob("*") if path.is_file()] and not small_images(images, tmp_path)


def test_a_small_video_is_not_made_beyond_the_limit_or_where_nothing_can_be_written(images, tmp_path):
    made(images, tmp_path, most=2000)
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]
    (tmp_path / "file").write_text("in the way")
    for found, source in zip(made(images, tmp_path / "file"), images.values(), strict=True):
        assert np.array_equal(found, np.stack(list(source.frames())))
    assert not small_images(images, tmp_path / "file")


def test_those_of_another_recording_go_and_are_not_taken(images, tmp_path):
    made(images, tmp_path)
    first = {path.name for path in (tmp_path / FOLDER).iterdir()}
    others = {name: images[name] for name in ("c0", "c1")}
    assert not small_images(others, tmp_path)
    made(others, tmp_path)
    assert len(first) == 1 and not first & {path.name for path in (tmp_path / FOLDER).iterdir()}
    assert list(small_images(others, tmp_path)) == ["c0", "c1"]


def test_a_damaged_small_video_is_made_do_without(images, tmp_path):
    made(images, tmp_path)
    one, two = sorted((tmp_path / FOLDER).rglob("*.mkv"))
    content = bytearray(one.read_bytes())
    content[len(content) // 2 : len(content) // 2 + 400] = bytes(400)
    one.write_bytes(content)
    two.write_bytes(b"no video")
    mosaics = Mosaics(images, tmp_path / "mosaics", small=small_images(images, tmp_path))
    assert all(shown(mosaics, n) == [n, n + 500, n + 1000] for n in range(FRAMES))
    mosaics.close()


def test_fields_become_small_pictures_of_their_true_height(tmp_path):
    field = {"c0": open_images(write_numbered(tmp_path / "c0.mp4", 20), interlaced="top", every=2)}
    made(field, tmp_path, 0, 20)
    small = small_images(field, tmp_path)["c0"]
    assert small.frame(3).shape == (HEIGHT, WIDTH) and number(small.frame(3)) == 3


def test_of_sixteen_bits_those_are_taken_that_a_camera_uses(tmp_path):
    """The first image is dark."""
    source = {"c0": open_images(write_numbered(tmp_path / "c0.mp4", 20))}
    read(watched(source, {"c0": Deep(source["c0"])}, 0, tmp_path))
    assert [number(small_images(source, tmp_path)["c0"].frame(n)) for n in (1, 5, 19)] == [1, 5, 19]
    with pytest.raises(KinemarkError):
        small_images(source, tmp_path)["c0"].frame(20)


class Deep:
    """The same images in twelve bits."""

    def __init__(self, source):
        self.source, self.n_frames = source, source.n_frames

    def batches(self, n):
        return (images.astype(np.uint16) << 4 for images in self.source.batches(n))


def test_a_run_leaves_them_for_its_recording(tmp_path):
    scene = Scene(cameras=3, seconds=0.6, focal_px=500.0, size_px=(488, 378), noise=1.0)
    simulate(tmp_path, scene=scene)
    Session.open(tmp_path).run(to="detect")
    found = {name: open_images(tmp_path / "walk01" / f"{name}.mkv") for name in ("cam1", "cam2", "cam3")}
    small = small_images(found, tmp_path / "results" / "walk01")
    assert {name: len(one.frames) for name, one in small.items()} == {name: s.n_frames for name, s in found.items()}
