"""The aspect ratio by the rotating bar, from images: by the command, into the flow of UM²AS."""

import json
from dataclasses import replace
from datetime import date

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError
from kinemark.detect import Centroids
from kinemark.engine.bar_aspect import along, bar_aspect_of_file
from kinemark.engine.session import Session
from kinemark.engine.session_changes import change_session
from kinemark.engine.um2as.files import Um2asFiles
from kinemark.engine.um2as.flow import calibrated
from kinemark.geometry import to_dlt
from kinemark.io.images import write_png
from kinemark.io.um2as import read_cp, read_da, read_rf, read_tdc, write_cp, write_da
from kinemark.io.video import write_video
from kinemark.synth import Optics, look_at, render
from support.boxed import BALLS, seen_balls, seen_meal
from support.command_line import command
from support.eating import footage
from support.feeding import feeding_in

BRIGHT = Centroids(threshold=60)


def bar_in(folder, *, aspect, angles, markers=14, seed=0, lamp=False):
    """Images of a bar that is turned before a camera whose pixels are `aspect` as high as wide."""
    folder.mkdir()
    rng = np.random.default_rng(seed)
    camera = look_at("cam", np.array([0.0, 0.0, 3000.0]), np.zeros(3), focal_px=1000.0, size=(512, 512))
    camera = replace(camera, K=np.diag([1.0, 1 / aspect, 1.0]) @ camera.K)
    at = np.linspace(-450, 450, markers)
    for k, angle in enumerate(np.radians(angles)):
        bar = np.outer(at, [np.cos(angle), np.sin(angle), 0.0]) + rng.normal(0, 8, 3) * [1, 1, 0]
        balls = np.vstack([bar, [[300.0, 420.0, 0.0]]]) if lamp and k == 1 else bar
        write_png(folder / f"{k:04d}.png", render(camera, balls, 9.0, optics=Optics(subsamples=2), rng=rng))
    return folder / "%04d.png"


@pytest.mark.parametrize(("aspect", "markers", "seed"), [(0.8509, 14, 1), (1.12, 6, 2), (1.0, 7, 3)])
def test_a_turned_bar_gives_the_aspect_ratio(tmp_path, aspect, markers, seed):
    """Of an odd number of markers, too; and one image with something else in it is left out."""
    images = bar_in(
        tmp_path / "bar", aspect=aspect, angles=np.arange(0, 180, 15), markers=markers, seed=seed, lamp=True
    )
    found = bar_aspect_of_file(images, method=BRIGHT)
    assert found.ratio.factor == pytest.approx(aspect, abs=4e-3) and (found.used, found.markers) == (11, markers)
    before, after = found.ratio.spread
    assert after < 0.6 and (before > 5 * after or aspect == 1.0)


def test_markers_are_ordered_along_the_bar():
    rng = np.random.default_rng(4)
    line = np.linspace(0, 300, 9)[:, None] * [np.cos(2.0), np.sin(2.0)] + 200
    found = along(rng.permutation(line))
    assert np.allclose(found, line) or np.allclose(found, line[::-1])


def test_what_is_no_turned_bar_is_refused(tmp_path):
    images = bar_in(tmp_path / "still", aspect=0.9, angles=[30] * 5)
    with pytest.raises(KinemarkError, match=r"%04d.png: The bar's distances do not change"):
        bar_aspect_of_file(images, method=BRIGHT)
    images = bar_in(tmp_path / "few", aspect=0.9, angles=[0, 60])
    with pytest.raises(KinemarkError, match="2 of 2 images show a bar: 14 markers in 2"):
        bar_aspect_of_file(images, method=BRIGHT)


def test_the_command_says_it(tmp_path, capsys):
    images = bar_in(tmp_path / "bar", aspect=0.8509, angles=np.arange(0, 180, 20))
    command("aspect", images, "--threshold", 60)
    assert "makes pixels square: a bar of 14 markers in 9 of 9 images" in capsys.readouterr().out
    command("aspect", images, "--threshold", 60, "--json")
    figures = json.loads(capsys.readouterr().out)[str(images)]
    assert figures["factor"] == pytest.approx(0.8509, abs=4e-3) and figures["sd"] < 2e-3


def test_files_of_a_session_are_corrected_and_places_stay(tmp_path):
    """V × CF in every file: L parameters and markers belong together, so that places are the same."""
    session = Session.open(feeding_in(tmp_path / "feeding", 3))
    plain = Um2asFiles(session, "feeding")
    plain.process_parameters(made=date(2026, 1, 2))
    uv = seen_meal(seconds=0.2)[2]
    for c, path in enumerate(plain.das()):
        write_da(path, uv[c])
    before = read_tdc(plain.process_coordinates(()))
    marks, L = read_rf(plain.folder / "box.rf1"), read_cp(plain.folder / "box.cp1").L
    change_session(session.root, {("cameras", "aspect_ratio"): 0.85})
    square = Um2asFiles(Session.open(session.root), "feeding")
    square.process_parameters(made=date(2026, 1, 2))
    assert read_rf(square.folder / "box.rf1") == pytest.approx(marks * [1, 0.85], abs=1e-6)
    scale = np.array([1, 1, 1, 1, 0.85, 0.85, 0.85, 0.85, 1, 1, 1])
    assert pytest.approx(L * scale, abs=1e-5) == read_cp(square.folder / "box.cp1").L
    for c, path in enumerate(square.das()):
        write_da(path, uv[c] * square.square)
    assert np.nanmax(np.abs(read_tdc(square.process_coordinates(())) - before)) < 0.2


def test_commands_correct_what_they_write_and_ask_other_cameras_in_images_pixels(tmp_path, monkeypatch, capsys):
    """With corrected parameters and data of two cameras, all of the third is proposed where it is."""
    monkeypatch.chdir(tmp_path)
    _, balls = seen_balls()
    rig = calibrated(["cam1", "cam2", "cam3"], BALLS, balls * [1, 0.85])
    _, _, sight, images = footage(3 / 30)
    for c in range(3):
        write_cp(f"box.cp{c + 1}", to_dlt(rig.select([rig.names[c]]).P)[0], made=date(2026, 1, 2))
        write_da(f"feed.da{c + 1}", sight.uv[c] * [1, 0.85])
    write_video(tmp_path / "cam1.mkv", images[0][:3], 30.0)
    known = ("--calibration", *[f"box.cp{c}" for c in (1, 2, 3)], "--others", "feed.da2", "feed.da3")
    more = ("--take-proposals", "--save-all", "--aspect-ratio", 0.85, "--json")
    command("um2as", "digitise", "cam1.mkv", "own.da1", "--markers", "8", *known, *more)
    assert json.loads(capsys.readouterr().out)["proposals_taken_unasked"] >= 16
    off = read_da("own.da1") - sight.uv[0] * [1, 0.85]
    assert np.nanmedian(np.abs(off)) < 0.2
    with pytest.raises(KinemarkError, match="0 is no aspect ratio"):
        app(["um2as", "digitise", "cam1.mkv", "other.da1", "--markers", "8", "--aspect-ratio", "0"])
