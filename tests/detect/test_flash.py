"""Recordings that were started apart are put together by the image that a flash lights, and by nothing else."""

import json

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError
from kinemark.detect.flash import Flash, find_flash, flash_offsets
from kinemark.engine.camera_checks.start_files import starts_by_flash
from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.video import write_video
from kinemark.synth import Optics, film, ring, walking
from support.films import Film

SIZE, N = (160, 120), 70


def view(seed, n=N, *, noise=3.0):
    """A dim room with a bright thing that moves, and noise."""
    rng = np.random.default_rng(seed)
    room = 20 + 15 * rng.random((6, 8)).repeat(20, 0).repeat(20, 1)
    images = room + rng.normal(0, noise, (n, SIZE[1], SIZE[0]))
    for f in range(n):
        images[f, 30:110, 2 * f : 2 * f + 40] += 80  # a person in white
    return images


def recorded(images):
    return Film(images.clip(0, 255).astype(np.uint8))


@pytest.mark.parametrize(
    ("seed", "at", "length", "rise"), [(0, 31, 1, 60.0), (1, 8, 2, 12.0), (2, 60, 5, 3.0), (3, 40, 1, 250.0)]
)
def test_a_flash_is_found_to_the_image(seed, at, length, rise):
    images = view(seed)
    images[at : at + length] += rise * (0.6 + 0.8 * np.random.default_rng(seed).random(SIZE[::-1]))
    found = find_flash(recorded(images))
    assert (found.frame, found.n_frames) == (at, length) and 0.3 * rise < found.rise < 1.2 * rise


def test_deeper_images_are_the_same():
    images = view(0)
    images[20] += 50
    deep = Film((images.clip(0, 255) * 257).astype(np.uint16))
    assert find_flash(deep).frame == find_flash(recorded(images)).frame == 20
    assert find_flash(deep).rise == pytest.approx(find_flash(recorded(images)).rise, rel=0.02)


def lamp_of_half_the_view(images):
    images[30:32, :, :80] += 120


def switched_on(images):
    images[30:] += 60


def two_flashes(images):
    images[[20, 50]] += 40


def flicker(images):
    images += 6 * np.sin(2.4 * np.arange(len(images)))[:, None, None]


def nothing(images):
    pass


def at_the_very_end(images):
    images[-1] += 90


@pytest.mark.parametrize(
    ("what", "words"),
    [
        (nothing, "no flash"), (lamp_of_half_the_view, "no flash"), (switched_on, "no flash"), (flicker, "no flash"),
        (at_the_very_end, "no flash"), (two_flashes, "2 flashes light the whole image, in frames 21, 51"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("seed", [4, 5])
def test_what_is_no_flash_or_more_than_one_is_refused(what, words, seed):
    images = view(seed)
    what(images)
    with pytest.raises(KinemarkError, match=words):
        find_flash(recorded(images))


def test_the_later_start_sees_the_flash_earlier():
    assert flash_offsets([Flash(40, 1, 9.0), Flash(25, 1, 9.0), Flash(52, 1, 9.0)]).tolist() == [0, 15, -12]
    with pytest.raises(KinemarkError, match="2 frames are too few"):
        find_flash(recorded(view(0, 2)))


LATE, FLASH, RATE = (0, 9, 4), 30, 50.0


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """A walk before three cameras that were started apart, with a flash that is not as bright in each."""
    folder = tmp_path_factory.mktemp("flash")
    rig = ring(3, size=(188, 145), focal_px=195.0)
    walk = walking(duration_s=1.4, rate=RATE, seed=3)
    for c, camera in enumerate(rig):
        images = np.stack(list(film(camera, walk, optics=Optics(read_noise=3.0), seed=c))).astype(float)
        images[FLASH] += (70, 9, 25)[c]
        write_video(folder / f"{camera.name}.mkv", images.clip(0, 255).astype(np.uint8)[LATE[c] :], RATE)
    write_rig_toml(folder / "rig.toml", rig)
    (folder / "session.toml").write_text(
        'name = "flashed"\n[cameras]\nnames = ["cam1", "cam2", "cam3"]\n[calibration]\nfile = "rig.toml"\n'
        '[[trials]]\nname = "walk"\nimages = "{camera}.mkv"\n',
        "utf-8",
    )
    return folder


def test_the_command_says_when_each_camera_was_started(session, capsys):
    app(["starts", str(session), "--flash", "--json"], result_action="return_value")
    found = json.loads(capsys.readouterr().out)
    assert found["images"] == {"cam1": 0, "cam2": 9, "cam3": 4}
    assert found["flash"] == {"cam1": 31, "cam2": 22, "cam3": 27}
    app(["starts", str(session), "--flash"], result_action="return_value")
    assert "delays_ms = { cam1 = 0, cam2 = 180, cam3 = 80 }" in capsys.readouterr().out


def test_what_cannot_be_told_is_said(session, tmp_path):
    with pytest.raises(KinemarkError, match="no trial run with images"):
        starts_by_flash(session, "run")
    with pytest.raises(KinemarkError, match="by markers, or SESSION --flash"):
        app(["starts", str(session)], result_action="return_value")
    for path in session.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    write_video(tmp_path / "cam2.mkv", recorded(view(0)).images, RATE)
    with pytest.raises(KinemarkError, match="cam2: no flash lights the whole image; the greatest rise"):
        starts_by_flash(tmp_path)
