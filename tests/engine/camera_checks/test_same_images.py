"""One camera's file given for two is told, whatever else the images do."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Detections, make_finding
from kinemark.engine.camera_checks.same_images import same_images
from kinemark.report.words import text_of
from support.laboratory import observe, ring
from support.motions import dance

RIG = ring(5)
SEEN, _ = observe(RIG, dance(n=8, frames=20), noise=0.1)


def given(files):
    """The detections where each camera is given the file of another."""
    uv = np.concatenate([SEEN.uv[SEEN.camera == c] for c in files])
    return Detections.build(RIG.names, SEEN.rate, SEEN.counts[files], uv)


@pytest.mark.parametrize("camera", ["c2", "c4", None])
def test_a_file_given_twice_is_red_unless_one_of_the_two_was_left_out(camera):
    diagnosed = [make_finding("camera_fits_nothing", cameras=[camera], left_out=True)] if camera else []
    (found,) = same_images(given([0, 1, 2, 3, 2]), diagnosed)
    assert (found.cameras, found.severity) == (("c2", "c4"), "amber" if camera else "red")
    assert text_of(found).startswith("Cameras c2 and c4 have the same images")


def test_images_of_cameras_of_their_own_differ_in_whole_pixels_too_and_none_is_no_image():
    assert not list(same_images(SEEN, []))
    assert not list(same_images(replace(SEEN, uv=np.round(SEEN.uv)), []))
    assert not list(same_images(SEEN.keep(SEEN.camera > 1), []))
