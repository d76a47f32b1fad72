"""CSV that Nexus and Motive export is read: places in mm, gaps, rates, channels, events, the axis that goes up."""

import json

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories
from kinemark.data.trial import UP
from kinemark.io.trial import read_trial
from support.exported_csv import motive, nexus


def walk(first=1, names=("LASI", "RASI", "LANK", "*1204"), frames=30):
    """Markers of somebody some 2 m from the corner, with gaps; whole micrometres."""
    rng = np.random.default_rng(7)
    xyz = np.round(rng.uniform(-2000, 2000, (len(names), 1, 3)) + rng.normal(0, 20, (len(names), frames, 3)), 3)
    xyz[1, 5:9] = xyz[-1, :3] = xyz[-1, -1:] = np.nan
    return Trajectories(tuple(map(MarkerTrajectory.measured, names, xyz)), 100.0, first)


def written(path, text, encoding="utf-8"):
    path.write_text(text, encoding)
    return path


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("first", [1, 101])
def test_trajectories_of_nexus(tmp_path, first, moving):
    before = walk(first)
    read = read_trial(written(tmp_path / "a.csv", nexus(before, devices=10, events=True, moving=moving)))
    of = read.trajectories
    assert (of.names, of.rate, of.first_frame) == (tuple(f"Anna:{n}" for n in before.names), 100.0, first)
    np.testing.assert_allclose(of.xyz, before.xyz, atol=1e-6, rtol=0)
    (channels,) = read.analog
    assert (channels.rate, channels.start, channels.values.shape) == (1000.0, 0.0, (8, 300))
    assert channels.names[5:] == ("AMTI #1 - Moment Mz", "EMG - Voltage LTA", "EMG - Voltage RTA")
    assert channels.units == ("N",) * 3 + ("N.mm",) * 3 + ("V",) * 2
    assert channels["AMTI #1 - Force Fy"][23] == 102.3
    assert (read.events.label, read.events.side) == (("Foot Strike", "Foot Off"), ("Left", "Right"))
    assert read.events.time.tolist() == [1.03, 1.14]
    assert UP not in read.about and read.notes == ("the block Model Outputs is not read",)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: "\n\n" + text,
        lambda text: text.replace("\n", "\r\n"),
        lambda text: "\n".join(
            line + "," * (14 - line.count(",")) if line else "," * 14 for line in text.split("\n")[:-1]
        ),
        lambda text: "\n".join(_european(line) for line in text.split("\n")),
    ],
    ids=["blank lines first", "Windows", "padded by a spreadsheet", "semicolons and decimal commas"],
)
def test_nexus_after_a_spreadsheet(tmp_path, change):
    before = walk()
    read = read_trial(written(tmp_path / "a.csv", change(nexus(before))))
    np.testing.assert_allclose(read.trajectories.xyz, before.xyz, atol=1e-6, rtol=0)


def _european(line):
    return line.replace(",", ";").replace(".", ",")


@pytest.mark.parametrize("unit", ["Meters", "Centimeters", "Millimeters"])
@pytest.mark.parametrize("form", [{}, {"words": False}, {"time_code": True}], ids=["new", "old", "time code"])
def test_markers_of_motive(tmp_path, unit, form):
    before = walk(0, ("Anna:LASI", "Anna:RASI", "Unlabeled 1204", "Unlabeled 1204"))
    read = read_trial(written(tmp_path / "a.csv", motive(before, unit=unit, **form)))
    of = read.trajectories
    assert (of.names, of.rate, of.first_frame) == (("Anna:LASI", "Anna:RASI", "*1204", "*1204 [2]"), 100.0, 0)
    np.testing.assert_allclose(of.xyz, before.xyz, atol=1e-3, rtol=0)
    assert read.about[UP] == "+Y"
    assert read.notes[:2] == (
        "Rigid Body (1) is not measured and is not read",
        "Rigid Body Marker (1) is not measured and is not read",
    )


def test_motive_becomes_a_c3d_whose_axis_up_is_known(tmp_path, capsys):
    source = written(tmp_path / "a.csv", motive(walk(0)))
    app(["info", str(source), "--json"], result_action="return_value")
    assert "30" in json.dumps(json.loads(capsys.readouterr().out))
    app(["convert", str(source), str(tmp_path / "a.c3d")], result_action="return_value")
    back = read_trial(tmp_path / "a.c3d")
    assert back.about[UP] == "+Y"
    np.testing.assert_allclose(back.trajectories.xyz, walk(0).xyz, atol=1e-3, rtol=0)


def test_a_file_of_motive_counts_its_own_times(tmp_path):
    text = motive(walk(0)).replace("Export Frame Rate,100.000000", "Export Frame Rate,240.000000")
    read = read_trial(written(tmp_path / "a.csv", text))
    assert read.trajectories.rate == 240.0 and "the times go at 100 Hz" in read.notes[0]
    silent = text.replace("Export Frame Rate", "x").replace("Capture Frame Rate", "y")
    assert read_trial(written(tmp_path / "b.csv", silent)).trajectories.rate == pytest.approx(100.0)
    assert read_trial(tmp_path / "b.csv", rate_hz=50.0).trajectories.rate == 50.0


def test_the_unit_can_be_stated(tmp_path):
    text = motive(walk(0)).replace("Length Units,Meters", "Length Units,Furlongs")
    with pytest.raises(KinemarkError, match=r"Furlongs.*--length-unit"):
        read_trial(written(tmp_path / "a.csv", text))
    np.testing.assert_allclose(read_trial(tmp_path / "a.csv", length_unit="m").trajectories.xyz, walk(0).xyz, atol=1e-3)
    with pytest.raises(KinemarkError, match="Anna:LASI is in furlong"):
        read_trial(written(tmp_path / "b.csv", nexus(walk()).replace(",mm", ",furlong")))


def _without(text, word):
    return "\n".join(line for line in text.split("\n") if not line.startswith(word))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (nexus(walk()).split("Trajectories")[0], "holds Model Outputs, and no Trajectories"),
        (_without(nexus(walk()), "7,0"), "does not follow"),
        (nexus(walk()).replace("Trajectories\n100\n", "Trajectories\n"), "samples a second below Trajectories"),
        (nexus(walk())[:-9], "cells, wanted"),
        (nexus(walk()).replace("\n4,0,", "\n4,1,"), "sub frame"),
        (motive(walk(0)).replace(",Marker", ",Bone Marker"), "Bone Marker, and no measured markers"),
        (_without(motive(walk(0)), "7,"), "does not follow"),
        (motive(walk(0))[:-9], "cells, wanted"),
        (motive(walk(0)).replace("\n3,0.030000,", "\n3,half,"), "half"),
        ("\n".join(motive(walk(0)).split("\n")[:3]), "with its heading"),
    ],
)
def test_what_is_no_such_file_is_refused(tmp_path, text, says):
    with pytest.raises(KinemarkError, match=says):
        read_trial(written(tmp_path / "a.csv", text))


@pytest.mark.parametrize("made", [nexus, lambda walk: motive(walk, unit="Millimeters")], ids=["Nexus", "Motive"])
def test_rows_before_the_end_of_a_file_that_is_cut_off_are_read_when_asked(tmp_path, made):
    text = made(walk(1))
    path = written(tmp_path / "a.csv", text[: text.rindex("\n27,")] + "\n27,0,1.5")
    with pytest.raises(KinemarkError, match=r"is cut off.*--partial"):
        read_trial(path)
    read = read_trial(path, partial=True)
    assert any("is cut off and left out" in note for note in read.notes)
    np.testing.assert_allclose(read.trajectories.xyz, walk(1).xyz[:, :26], atol=1e-3, rtol=0)


def test_a_heading_of_motive_without_frames_is_refused(tmp_path):
    text = motive(walk(0))
    with pytest.raises(KinemarkError, match="no frames"):
        read_trial(written(tmp_path / "a.csv", text[: text.index("\n0,") + 1]))
