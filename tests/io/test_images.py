"""Single frames of a recording."""

import numpy as np
import pytest

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
