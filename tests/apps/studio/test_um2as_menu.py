"""The menu of UM²AS over a session: what is done, what waits for what, and what is refused in words."""

import time

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.engine.digitising.files import digitise_trial
from kinemark.engine.session import Session
from kinemark.engine.um2as.flow import angles_files, coordinates_files
from kinemark.engine.um2as.menu import MENU
from kinemark.io.um2as import read_cp, read_da, write_da
from support.boxed import seen_meal
from support.eating import Knowing, footage
from support.feeding import feeding_in
from support.studio import Studio

THESIS = {
    "": ("Camera Information", "Data Calculation"),
    "camera": ("Calibration Parameters", "Marker Coordinate Digitizing"),
    "data": ("X, Y, Z Coordinate Calculation", "Calculate Euler Angles"),
    "calibration": ("Start Up Information", "Input & Output Data Files", "Image Threshold", "Snap Image",
                    "Reference Marker", "Digitize Image", "Process L Parameters", "View L Parameters"),
    "digitising": ("Start Up Information", "Output File", "Reference Marker", "Image Threshold", "Snap Image",
                   "Digitize Image", "Verify Digitization", "Save Data", "View Data"),
    "xyz": ("Start Up Information", "Calibration Input Files", "Marker Data Files", "Output File",
            "Process Coordinates", "Display Coordinates"),
    "euler": ("Input File", "Output Files", "Process"),
}  # fmt: skip
"""Entries of each level, figures 3.3 to 3.20 of the thesis."""


def menu_of(studio, **said):
    session = studio.page.get("/api/home").json()["sessions"][0]["id"]
    studio.address = f"/api/sessions/{session}/um2as"
    asked = "&".join(f"{key}={value}" for key, values in said.items() for value in values)
    answer = studio.page.get(f"{studio.address}?{asked}")
    assert answer.status == 200, answer.json()
    return answer.json()


def states(menu):
    return {row["key"]: row["state"] for row in menu["entries"]}


@pytest.fixture
def folder(tmp_path):
    return feeding_in(tmp_path / "feeding", 3)


def digitise_all(folder):
    """By an operator who knows where the markers are."""
    sight, cameras, session = footage(0.1)[2], iter(range(3)), Session.open(folder)
    task = session.digitising("feeding", session.calibrate().rig)
    digitise_trial(task, operator=lambda reel: Knowing(sight, next(cameras), reel))


def test_the_menu_has_the_entries_of_the_thesis_in_their_order():
    for above, titles in THESIS.items():
        own = [entry.title for entry in MENU if entry.above == above]
        assert tuple(own[: len(titles)]) == titles, above
    keys = {entry.key for entry in MENU}
    assert {entry.above for entry in MENU} - {""} <= keys and len(keys) == len(MENU)


def test_each_task_waits_for_what_it_needs_and_is_done_again_where_that_changed(folder):
    studio = Studio(folder)
    first = states(menu := menu_of(studio))
    assert not [row for row in menu["entries"] if f"{row['title']} first." in row["words"]], "no task waits for itself"
    assert first["calibration-process"] == "open", "cameras without lenses have L parameters, however calibrated"
    waiting = ("digitising-save", "xyz-data", "xyz-process", "xyz-display", "euler-input", "euler-process")
    assert {first[key] for key in waiting} == {"waits"} and first["xyz"] == "open"
    written = studio.page.post(f"{studio.address}/parameters", {"made": "1992-11-27"}).json()
    assert written["names"][:3] == ["box.cp1", "box.cp2", "box.cp3"] and "box.rf1" in written["names"]
    made = folder / "results" / "um2as"
    assert str(read_cp(made / "box.cp1").made) == "1992-11-27"
    uv = seen_meal(seconds=0.2)[2]
    for c in range(3):
        write_da(made / f"feeding.da{c + 1}", uv[c])
    then = states(menu_of(studio))
    assert then["calibration-process"] == "done" and then["xyz-data"] == "done" and then["xyz-process"] == "open"
    for cameras, name in ([], "feeding.tdc"), (["cam2", "cam3"], "feeding-23.tdc"):
        body = {"trial": "feeding", "cameras": cameras}
        assert studio.page.post(f"{studio.address}/coordinates", body).json()["names"] == [name]
    some = [made / f"box.cp{c}" for c in (2, 3)], [made / f"feeding.da{c}" for c in (2, 3)]
    coordinates_files(*some, made / "wanted.tdc", markers=8)
    assert (made / "wanted.tdc").read_bytes() == (made / "feeding-23.tdc").read_bytes()
    body = {"trial": "feeding", "tdc": "feeding-23.tdc", "inverse_cosines": True}
    assert studio.page.post(f"{studio.address}/angles", body).json()["names"][0] == "feeding-23.shd"
    angles_files(made / "wanted.tdc", signed=False)
    assert (made / "wanted.shd").read_bytes() == (made / "feeding-23.shd").read_bytes()
    chosen = menu_of(studio, camera=["cam2", "cam3"], tdc=["feeding-23.tdc"])
    assert states(chosen)["euler-process"] == "done" and chosen["chosen"] == ["cam2", "cam3"]
    time.sleep(0.02)
    write_da(made / "feeding.da2", uv[1])
    assert states(menu_of(studio))["xyz-process"] == "again"


def test_all_that_depends_on_the_aspect_ratio_or_the_calibration_is_to_be_done_again(folder):
    """However new the files are; and is done when it was."""
    studio = Studio(folder)
    menu_of(studio)
    digitise_all(folder)
    made = folder / "results" / "um2as"
    after = ("calibration-process", "digitising-save", "xyz-process", "euler-process")

    def process():
        studio.page.post(f"{studio.address}/parameters", {"made": "1992-11-27"})
        studio.page.post(f"{studio.address}/markers", {})
        studio.page.post(f"{studio.address}/coordinates", {"trial": "feeding", "cameras": []})
        studio.page.post(
            f"{studio.address}/angles", {"trial": "feeding", "tdc": "feeding.tdc", "inverse_cosines": False}
        )
        return {name: states(menu_of(studio))[name] for name in after}

    assert process() == dict.fromkeys(after, "done")
    cp, da = (made / "box.cp1").read_text("utf-8"), read_da(made / "feeding.da1")
    assert studio.page.post(f"{studio.address}/aspect/factor", {"factor": 0.9}).status == 200
    menu = menu_of(studio)
    assert {name: states(menu)[name] for name in after} == dict.fromkeys(after, "again")
    words = {row["key"]: row["words"] for row in menu["entries"]}
    assert words["calibration-process"] == "The aspect ratio was changed since: do it again."
    assert words["xyz-process"] == "box.cp1 is to be made again, and then this."
    assert process() == dict.fromkeys(after, "done") and (made / "box.cp1").read_text("utf-8") != cp
    np.testing.assert_allclose(read_da(made / "feeding.da1")[..., 1], 0.9 * da[..., 1], atol=1e-6)
    text = (folder / "rig.toml").read_text("utf-8")
    (folder / "rig.toml").write_text(f"# looked at again\n{text}", "utf-8")
    menu = menu_of(studio)
    assert {name: states(menu)[name] for name in after} == dict.fromkeys(after, "again")
    assert process() == dict.fromkeys(after, "done")
    (made / "made.json").write_text("{", "utf-8")  # nothing is known then
    assert states(menu_of(studio))["calibration-process"] == "done"


def test_a_file_is_shown_frame_by_frame_with_what_is_not_there(folder):
    studio = Studio(folder)
    menu_of(studio)
    made = folder / "results" / "um2as"
    made.mkdir(parents=True)
    uv = seen_meal(seconds=0.2)[2]
    uv[:, 2, 1] = float("nan")
    for c in range(2):
        write_da(made / f"feeding.da{c + 1}", uv[c])
    page = studio.page.get(f"{studio.address}/files/feeding.da2?frame=2").json()
    assert (page["frame"], page["frames"], page["head"]) == (2, 6, ["marker", "U", "V"])
    assert page["rows"][2] == [3.0, None, None] and page["rows"][0][1] == pytest.approx(uv[1, 0, 1, 0], abs=1e-6)
    assert studio.page.get(f"{studio.address}/files/feeding.da2?frame=99").json()["frame"] == 6
    assert studio.page.get(f"{studio.address}/files/session.toml").status == 404
    assert studio.page.get(f"{studio.address}/files/..%2F..%2Fsession.toml").status in (404, 405)


def test_what_cannot_be_done_is_said(folder):
    studio = Studio(folder)
    menu_of(studio)
    refused = studio.page.post(f"{studio.address}/markers", {})
    assert refused.status == 422 and "cam1 0 of 3" in refused.json()["words"]
    refused = studio.page.post(f"{studio.address}/coordinates", {"trial": "feeding", "cameras": ["cam9"]})
    assert refused.status == 422 and "no camera 'cam9'" in refused.json()["words"]
    text = (folder / "rig.toml").read_text("utf-8")
    bent = text.replace("distortions = [0.0", "distortions = [-0.2")
    assert bent != text
    (folder / "rig.toml").write_text(bent, "utf-8")
    refused = studio.page.post(f"{studio.address}/parameters", {"made": "2026-01-02"})
    assert refused.status == 422 and "L parameters have no lenses" in refused.json()["words"]
