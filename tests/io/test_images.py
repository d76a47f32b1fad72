"""Single frames of a recording."""

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.io.exact_frames import ExactImages
from kinemark.io.images import open_images, write_png
from kinemark.io.video import write_video


@pytest.mark.parametrize("interlaced", [False, "top", "bottom"])
def test_single_frames_are_those_of_the_whole_recording(tmp_path, interlaced):
    """Of a video, sought by their time, and of image files; by the index of its fields where interlaced."""
    film = np.random.default_rng(0).integers(0, 255, (23, 8, 12), np.uint8)
    write_video(tmp_path / "a.mkv", film, rate=29.97)
    for k, image in enumerate(film):
        write_png(tmp_path / f"{k:03}.png", image)
    for pattern in ("a.mkv", "*.png"):
        source = open_images(tmp_path / pattern, interlaced=interlaced)
        frames, wanted = np.stack(list(source.frames())), np.array([0, 3, 4, 11, 22])
        np.testing.assert_array_equal(source.frames_at(wanted), frames[wanted])


@pytest.mark.parametrize("interlaced", [False, "top", "bottom"])
def test_frames_near_those_wanted_are_what_their_numbers_say(tmp_path, interlaced):
    """Key frames of a video, each cheap to decode; the wanted ones of image files."""
    film = np.random.default_rng(1).integers(0, 255, (100, 8, 12), np.uint8)
    write_video(tmp_path / "a.mkv", film, rate=29.97)
    for k, image in enumerate(film[:20]):
        write_png(tmp_path / f"{k:03}.png", image)
    for pattern in ("a.mkv", "*.png"):
        source = open_images(tmp_path / pattern, interlaced=interlaced)
        frames = np.stack(list(source.frames()))
        wanted = np.linspace(0, len(frames) - 1, 12).astype(int)
        numbers, near = source.frames_near(wanted)
        np.testing.assert_array_equal(near, frames[numbers])
        assert (np.diff(numbers) > 0).all() and len(numbers) >= 6
        assert np.abs(numbers[:, None] - wanted).min(1).max() <= 24  # FFmpeg's FFV1 has a key frame every 12
        if pattern == "*.png":
            np.testing.assert_array_equal(numbers, wanted)


def test_a_video_with_a_single_key_frame_gives_the_wanted_frames(tmp_path):
    film = np.random.default_rng(2).integers(0, 255, (12, 8, 12), np.uint8)
    write_video(tmp_path / "a.mkv", film, rate=25)
    numbers, near = open_images(tmp_path / "a.mkv").frames_near(np.arange(0, 12, 2))
    np.testing.assert_array_equal(numbers, np.arange(0, 12, 2))
    np.testing.assert_array_equal(near, film[::2])


@pytest.mark.parametrize("every", [1, 2, 3, 30])
@pytest.mark.parametrize("interlaced", [False, "top", "bottom"])
def test_one_frame_of_so_many_is_taken_however_it_is_asked_for(tmp_path, interlaced, every):
    """All numbers are then of those, fields lie where they did, and there are so many fewer a second."""
    film = np.random.default_rng(3).integers(0, 255, (23, 8, 12), np.uint8)
    write_video(tmp_path / "a.mkv", film, rate=30)
    for k, image in enumerate(film):
        write_png(tmp_path / f"{k:03}.png", image)
    for pattern in ("a.mkv", "*.png"):
        all_of_it = open_images(tmp_path / pattern, interlaced=interlaced)
        source = open_images(tmp_path / pattern, interlaced=interlaced, every=every)
        wanted = np.stack(list(all_of_it.frames()))[::every]
        np.testing.assert_array_equal(np.stack(list(source.frames())), wanted)
        np.testing.assert_array_equal(np.concatenate(list(source.batches(4))), wanted)
        some = np.unique([0, len(source) // 2, len(source) - 1])
        np.testing.assert_array_equal(source.frames_at(some), wanted[some])
        numbers, near = source.frames_near(some)
        np.testing.assert_array_equal(near, wanted[numbers])
        np.testing.assert_array_equal([ExactImages(source).frame(int(f)) for f in some], wanted[some])
        assert len(source) == source.n_frames == len(wanted)
        assert [source.v_offset(f) for f in range(len(source))] == [
            all_of_it.v_offset(f) for f in range(0, len(all_of_it), every)
        ]
        assert source.rate == (None if all_of_it.rate is None else all_of_it.rate / every)


def test_no_frame_of_so_many_cannot_be_taken(tmp_path):
    write_png(tmp_path / "a.png", np.zeros((4, 4), np.uint8))
    with pytest.raises(KinemarkError, match="Of every 0 frames none"):
        open_images(tmp_path / "a.png", every=0)
