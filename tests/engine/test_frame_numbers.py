"""One count of frames: what a person reads of a trial has the numbers of the C3D file and the studio."""

import json
import re

import pytest

from kinemark.data.edits import Trim
from kinemark.engine.editing.journal import Journal
from kinemark.engine.session import Session
from kinemark.io.c3d import read_c3d
from kinemark.io.detections_csv import write_detections_csv
from kinemark.io.rig_toml import write_rig_toml
from kinemark.report.tables import unsure_table
from support.laboratory import observe, ring
from support.motions import swarm

STOPS = 70
"""Number of the last frame of which the third camera has images."""
LOST = 30
"""Number of the frame of which a name is stated where no track is."""
SETTINGS = """\
name = "numbers"
rate_hz = 100.0
[calibration]
file = "rig.toml"
[label]
names = "names.csv"
[[trials]]
name = "one"
detections = "one.csv"
"""


@pytest.fixture(params=["", "frames = [11, 110]\n"], ids=["whole", "stretch"])
def folder(request, tmp_path):
    rig = ring(4)
    seen = observe(rig, swarm(n=5, frames=120), noise=0.1)[0]
    write_rig_toml(tmp_path / "rig.toml", rig)
    write_detections_csv(tmp_path / "one.csv", seen.keep((seen.camera != 2) | (seen.frame < STOPS)))
    (tmp_path / "names.csv").write_text(f"trial,frame,x_mm,y_mm,z_mm,name\none,{LOST},90000,0,0,A\n")
    (tmp_path / "session.toml").write_text(SETTINGS + request.param)
    return tmp_path


def read(folder):
    """Of results: first and last frame of the C3D file; quality.json; its findings by kind; the report's page."""
    paths = read_c3d(folder / "one.c3d").trajectories
    figures = json.loads((folder / "quality.json").read_text())
    found = {one["kind"]: one for one in figures["findings"]}
    return (
        (paths.first_frame, paths.first_frame + paths.n_frames - 1),
        figures,
        found,
        (folder / "report.html").read_text(),
    )


def test_sentences_page_and_c3d_count_alike(folder):
    (first, last), figures, found, page = read(Session.open(folder).run()["one"].folder)
    stopped, lost = found["camera_stopped"], found["stated_names_lost"]
    assert (first, last) in ((1, 120), (11, 110))
    assert f"no images after frame {STOPS}; the recording ends with frame {last}." in stopped["text"]
    assert stopped["frames"] == [[STOPS + 1, last]]  # values and words say the same
    assert f"frame {LOST}." in lost["text"]
    assert f"(frames {first}–{last})" in figures["verdict"]["sentences"][1]
    for said in (stopped["text"], lost["text"], f"(frames {first}–{last})", f"the first is frame {first}."):
        assert said in page
    shown = [int(number) for number in re.findall(r"c\d+, frame (\d+)", page)]
    assert shown and set(shown) == {first}  # all images have all markers, so that the earliest are shown
    assert figures["recording"]["first_frame"] == first


def test_where_edits_trim_the_trial_numbers_stay(folder):
    Journal.of(folder, "one").append([Trim(41, 90)], by="a person")
    span, figures, found, page = read(Session.open(folder).run()["one"].folder)
    assert span == (41, 90)
    assert f"after frame {STOPS}; " in found["camera_stopped"]["text"]
    assert "(frames 41–90)" in page
    assert figures["trajectories"]["first_frame"] == 41


def test_the_table_of_names_not_sure_has_numbers_of_the_recording():
    unsure = {"name": "A", "probability": 0.6, "runner_up": None, "first_frame": 0, "last_frame": 9, "samples": 10}
    for first, shown in ((1, "1–10"), (100, "100–109")):
        assert shown in unsure_table({"unsure": [unsure]}, first).rows[0]
