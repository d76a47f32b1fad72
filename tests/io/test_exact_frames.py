"""A frame is the one of its number, in any container and order of asking: the number is drawn into the image."""

from fractions import Fraction

import av
import numpy as np
import pytest

from kinemark import KinemarkError
from kinemark.io import exact_video
from kinemark.io.exact_frames import ExactImages
from kinemark.io.exact_video import frame_index
from kinemark.io.images import open_images, write_png
from kinemark.io.video import opened, probe_video, stored_times
from support.numbered_video import bars, interlaced, number, write_numbered

FRAMES, SEEKS = 300, 100
NTSC = Fraction(30000, 1001)
VIDEOS = {
    "mp4, one group": ("a.mp4", {"reordered": 0}),
    "mp4, open groups": ("a.mp4", {"group": 40, "reordered": 3, "options": {"x264-params": "open-gop=1"}}),
    "mp4, odd rate": ("a.mp4", {"rate": NTSC}),
    "mkv, long groups": ("a.mkv", {"group": 150}),
    "mkv, rounded times": ("a.mkv", {"rate": Fraction(239760, 1001), "group": 60}),
    "mkv, lossless": ("a.mkv", {"codec": "ffv1", "group": 1}),
    "avi, reordered": ("a.avi", {"rate": NTSC}),
    "avi, in order": ("a.avi", {"reordered": 0, "group": 30}),
    "avi, still images": ("a.avi", {"codec": "mjpeg", "options": {"qmin": "2", "qmax": "3"}}),
    "mkv, uncompressed": ("a.mkv", {"codec": "rawvideo", "rate": Fraction(239760, 1001)}),
    "avi, uncompressed": ("a.avi", {"codec": "rawvideo", "rate": NTSC}),
    "mpeg stream": ("a.ts", {"group": 50}),
}


@pytest.mark.parametrize("kind", VIDEOS)
def test_every_seek_gives_the_frame_of_its_number(kind, tmp_path):
    name, options = VIDEOS[kind]
    if options.get("codec", "libx264") not in av.codecs_available:
        pytest.skip(f"this FFmpeg has no {options.get('codec', 'libx264')}")
    source = open_images(write_numbered(tmp_path / name, FRAMES, **options))
    assert source.n_frames == FRAMES
    images = ExactImages(source)
    there_and_back = [*range(120, 150), *range(150, 110, -1), FRAMES - 1, 0, FRAMES - 1]
    asked = [*np.random.default_rng(1).integers(0, FRAMES, SEEKS).tolist(), *there_and_back]
    assert [n for n in asked if number(images.frame(n)) != n] == []
    images.close()
    some = np.unique(asked[:20])
    assert [number(image) for image in source.frames_at(some)] == some.tolist()
    near, shown = source.frames_near(some)
    assert [number(image) for image in shown] == near.tolist()


@pytest.mark.parametrize("kind", ["mkv, uncompressed", "avi, uncompressed", "avi, still images"])
def test_the_containers_own_index_is_that_of_its_packets(kind, tmp_path, monkeypatch):
    """And spares reading them all, which of uncompressed video are as large as the film."""
    name, options = VIDEOS[kind]
    path = write_numbered(tmp_path / name, FRAMES, **options)
    info = probe_video(path)
    with opened(path) as container:
        assert len(stored_times(path, container)) == FRAMES
    own = frame_index(path, info)
    monkeypatch.setattr(exact_video, "stored_times", lambda path, container: None)
    listed = frame_index(path, info)
    np.testing.assert_array_equal(own.time, listed.time)
    np.testing.assert_array_equal(own.key, listed.key)


@pytest.mark.parametrize("first", ["top", "bottom"])
@pytest.mark.parametrize("name", ["a.mkv", "a.avi"])
def test_fields_are_frames_of_their_own(name, first, tmp_path):
    path = write_numbered(tmp_path / name, 100, codec="ffv1", image=interlaced)
    images = ExactImages(open_images(path, interlaced=first))
    rows = {"top": [0, 1], "bottom": [1, 0]}[first]
    for n in np.random.default_rng(2).integers(0, 200, 60).tolist():
        assert number(images.frame(n)) == n // 2 * 2 + rows[n % 2]


@pytest.mark.parametrize("codec", ["ffv1", "rawvideo"])
def test_uneven_times_do_not_move_frames(codec, tmp_path):
    """As of a camera that dropped frames, or a part that was cut out: the number counts what is there."""
    with av.open(str(tmp_path / "a.mkv"), "w") as container:
        stream = container.add_stream(codec, rate=Fraction(100))
        stream.height, stream.width = bars(0).shape
        stream.pix_fmt = "gray"
        for n in range(80):
            frame = av.VideoFrame.from_ndarray(bars(n), format="gray")
            frame.pts, frame.time_base = n * 10 + 500 * (n > 30) + 37 * (n > 60), Fraction(1, 1000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    with opened(tmp_path / "a.mkv") as container:
        assert stored_times("a.mkv", container) is None  # an index with holes may be one of some frames only
    images = ExactImages(open_images(tmp_path / "a.mkv"))
    assert [number(images.frame(n)) for n in (79, 31, 30, 32, 0, 61, 60)] == [79, 31, 30, 32, 0, 61, 60]
    some = np.array([0, 29, 31, 60, 61, 79])
    assert [number(image) for image in images.source.frames_at(some)] == some.tolist()


def test_files_are_read_by_number_and_there_are_no_others(tmp_path):
    for n in range(3):
        write_png(tmp_path / f"{n:03d}.png", bars(n))
    images = ExactImages(open_images(tmp_path / "%03d.png"))
    assert [number(images.frame(n)) for n in (2, 0, 1)] == [2, 0, 1]
    for n in (-1, 3):
        with pytest.raises(KinemarkError, match="frames 0 to 2"):
            images.frame(n)
