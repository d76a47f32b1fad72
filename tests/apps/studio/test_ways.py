"""The routes of another way of calibration, and of the aspect ratio."""

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.engine.session import Session
from kinemark.io.images import write_png
from kinemark.synth import Optics, render
from support.boxed import BALLS
from support.eating import laboratory
from support.feeding import feeding_in
from support.studio import Studio


@pytest.fixture
def folder(tmp_path):
    folder = feeding_in(tmp_path / "feeding", 3)
    (folder / "points.csv").write_text(
        "name,x_mm,y_mm,z_mm\n" + "\n".join(f"{n},{n},{n},{n}" for n in range(8)), "utf-8"
    )
    return folder


def session_of(studio):
    return f"/api/sessions/{studio.page.get('/api/home').json()['sessions'][0]['id']}"


def test_the_ways_of_a_session_and_the_change(folder):
    studio = Studio(folder)
    at = session_of(studio)
    ways = {row["path"]: row for row in studio.page.get(f"{at}/ways").json()["ways"]}
    assert ways["rig.toml"]["now"] and not ways["points.csv"]["now"]
    asked = {one["key"] for one in ways["points.csv"]["questions"]}
    assert asked == {"calibration.control_points.marker_diameter_mm"}
    said = {"path": "points.csv", "role": "control_points", "answers": {next(iter(asked)): "17"}}
    assert studio.page.post(f"{at}/ways", said).json()["way"] == "control_points"
    assert Session.open(folder).settings.calibration.control_points.marker_diameter_mm == 17
    assert "# the arm study" in (folder / "session.toml").read_text("utf-8")
    refused = studio.page.post(f"{at}/ways", {"path": "cam1.mkv", "role": "wand", "answers": {}})
    assert refused.status == 422 and "cannot calibrate" in refused.json()["words"]


def test_the_bar_is_measured_in_each_camera_and_its_factor_stated(folder):
    """One camera's images show no bar; what is said of it is why, and the others count."""
    rng = np.random.default_rng(1)
    for c, camera in enumerate(laboratory()):
        (folder / f"bar_cam{c + 1}").mkdir()
        for k, angle in enumerate(np.radians(np.arange(0, 180, 20))):
            across, down = camera.R[0], camera.R[1]
            turned = np.outer(np.linspace(-250, 250, 6), np.cos(angle) * across + np.sin(angle) * down)
            bar = BALLS.mean(0) + turned if c < 2 else BALLS
            image = render(camera, bar, 17.0, optics=Optics(subsamples=2), rng=rng)
            write_png(folder / f"bar_cam{c + 1}" / f"{k:04d}.png", image)
    studio = Studio(folder)
    at = f"{session_of(studio)}/um2as/aspect"
    listed = studio.page.get(at).json()
    bar = next(one for one in listed["images"] if "bar" in one)
    assert listed["factor"] is None
    found = studio.page.post(at, {"images": bar, "threshold": 60}).json()
    assert [row["factor"] is None for row in found["cameras"]] == [False, False, True]
    assert found["factor"] == pytest.approx(1.0, abs=0.01) and "show a bar" in found["cameras"][2]["words"]
    assert studio.page.post(f"{at}/factor", {"factor": found["factor"]}).json()["factor"] == found["factor"]
    assert Session.open(folder).settings.cameras.aspect_ratio == found["factor"]
    assert studio.page.post(f"{at}/factor", {"factor": None}).json()["factor"] is None
    assert studio.page.post(f"{at}/factor", {"factor": 0}).status == 422
    assert studio.page.post(at, {"images": "../{camera}.mkv"}).status == 404
