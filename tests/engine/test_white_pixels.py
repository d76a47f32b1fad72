"""Recordings of white pixels: detection of them is that of the recording that they were taken from."""

import json

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError
from kinemark.detect import Centroids, KissScanning, detect_frames
from kinemark.engine.white_pixels import write_white_pixels
from kinemark.io.images import open_images
from kinemark.io.video import write_video
from support.discs import discs


@pytest.fixture
def film(tmp_path):
    """Twelve frames of a disc each, in a video."""
    images, _ = discs(12, 9, 0.6, 3.0, np.random.default_rng(4))
    write_video(tmp_path / "cam1.mkv", images, 50.0)
    return tmp_path / "cam1.mkv", images


@pytest.mark.parametrize("threshold", [60.0, 110.5])
@pytest.mark.parametrize("method", [KissScanning(), Centroids(centroid="white", max_discs=1, correct_occlusion=False)])
def test_detection_is_that_of_the_recording(film, threshold, method):
    path, images = film
    white = path.with_name("white.mkv")
    said = write_white_pixels(path, white, threshold=threshold)
    kept = np.stack(list(open_images(white)))
    assert set(np.unique(kept)) == {0, 255} and said.n_frames == 12 and said.rate == 50
    assert said.mean_white == pytest.approx((images > threshold).sum() / 12)
    of_grey = detect_frames(images, method=type(method)(**{**fields(method), "threshold": threshold}))
    of_white = detect_frames(kept, method=type(method)(**{**fields(method), "threshold": 128.0}))
    for name in ("counts", "uv", "area", "width", "height", "validity"):
        np.testing.assert_array_equal(getattr(of_white, name), getattr(of_grey, name))


def fields(method):
    return {name: getattr(method, name) for name in method.__dataclass_fields__}


def test_dark_markers(film):
    path, images = film
    write_video(path.with_name("dark.mkv"), 255 - images, 50.0)
    write_white_pixels(path.with_name("dark.mkv"), path.with_name("white.mkv"), threshold=195, inverted=True)
    np.testing.assert_array_equal(np.stack(list(open_images(path.with_name("white.mkv")))) > 0, images > 60)


def test_the_command_and_what_it_refuses(film, capsys):
    path, _ = film
    white = path.with_name("white.mkv")
    app(["white-pixels", str(path), str(white), "--json"], result_action="return_value")
    assert json.loads(capsys.readouterr().out)["n_frames"] == 12
    for target, threshold, said in (
        (white, 60.0, "exists"),
        (path.with_name("a.avi"), 60.0, "mkv"),
        (path.with_name("a.mkv"), 300.0, "255"),
    ):
        with pytest.raises(KinemarkError, match=said):
            write_white_pixels(path, target, threshold=threshold)
