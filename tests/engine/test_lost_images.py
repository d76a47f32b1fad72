"""Images that one camera lost: the numbers of its files tell it, also where every camera lost as many."""

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.engine.session import Session
from kinemark.io.images import write_png
from kinemark.io.rig_toml import write_rig_toml
from support.laboratory import ring

SESSION = """\
name = "lost"
rate_hz = 50.0
[calibration]
file = "rig.toml"
[[trials]]
name = "walk"
images = "walk/{camera}/img_*.png"
"""


def run(folder, numbers):
    """A session whose cameras have images of these numbers, run as far as the detections."""
    rig = ring(len(numbers), focal=60.0, size=(64, 48))
    write_rig_toml(folder / "rig.toml", rig)
    (folder / "session.toml").write_text(SESSION)
    for camera, own in zip(rig, numbers, strict=True):
        (folder / "walk" / camera.name).mkdir(parents=True)
        width, height = camera.size
        for k in own:
            write_png(folder / "walk" / camera.name / f"img_{k}.png", np.zeros((height, width), np.uint8))
    opened = Session.open(folder)
    return opened.trial("walk").source(rig).detections()


def but(first, last, *lost):
    return [k for k in range(first, last + 1) if k not in lost]


def test_as_many_images_lost_in_every_camera_are_told(tmp_path):
    """Equal numbers of images are not the same images."""
    with pytest.raises(KinemarkError, match=r"Camera .* has no image 8 in .*black image"):
        run(tmp_path, [but(1, 14, 8), but(1, 14, 11)])


def test_numbers_are_of_the_camera_that_lacks_them(tmp_path):
    with pytest.raises(KinemarkError, match="has no image 107, 108 in"):
        run(tmp_path, [but(1, 14), but(100, 113, 107, 108)])


@pytest.mark.parametrize(
    "numbers",
    [
        [but(1, 12), but(0, 11)],
        [but(1, 14, 8), but(101, 114, 108)],
        [range(10, 130, 10), but(1, 12)],
        [
            [0, 19, 41, 60, 80, 101, 119, 140, 161, 180, 199],
            [0, 20, 40, 61, 79, 100, 121, 141, 160, 181, 200],
        ],
        [[int(k / 0.9 + late) for k in range(50)] for late in (0.0, 0.37)],
    ],
    ids=["begin apart", "gaps that all share", "every tenth", "times in ms", "times in ms at 900 Hz"],
)
def test_names_that_tell_no_loss_are_taken_in_order(tmp_path, numbers):
    assert run(tmp_path, numbers).n_frames == len(numbers[0])
