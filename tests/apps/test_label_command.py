"""Marker sets, templates and labels as users meet them: what is printed, what is written, and the status."""

import json
from dataclasses import replace

import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError, Trial
from kinemark.io.marker_sets import read_marker_set
from kinemark.io.trial import read_trial, write_trial
from kinemark.synth import walking


def walk(seed):
    return walking(duration_s=2.0, rate=100.0, seed=seed, wobble_mm=1.0).trajectories


def renamed(trial, new):
    return replace(trial, paths=tuple(replace(path, name=new.get(path.name, path.name)) for path in trial))


@pytest.fixture
def files(tmp_path):
    """A labelled walk, one without names, and one whose legs are swapped."""
    legs = [name[1:] for name in walk(1).names if name[0] == "L" and name != "LASI"]
    swapped = {a + name: b + name for name in legs for a, b in ("LR", "RL")}
    bare = {name: f"*{k}" for k, name in enumerate(walk(1).names, 1)}
    for name, trial in (("known", walk(1)), ("bare", renamed(walk(2), bare)), ("swapped", renamed(walk(3), swapped))):
        write_trial(Trial(name, trial), tmp_path / f"{name}.c3d")
    return tmp_path


def run(*arguments):
    """The status with which a command ends."""
    with pytest.raises(SystemExit) as end:
        app([str(word) for word in arguments])
    return end.value.code or 0


def test_marker_sets_are_listed_shown_and_drawn(tmp_path, capsys):
    assert run("marker-set", "list") == 0
    assert "plug-in-gait-full     39 markers" in capsys.readouterr().out
    assert run("marker-set", "show", "kiss-15", "--figure", tmp_path / "set.svg", "--json") == 0
    assert len(json.loads(capsys.readouterr().out)["markers"]) == 15
    assert (tmp_path / "set.svg").read_text().startswith("<svg")
    with pytest.raises(KinemarkError, match="nothing is overwritten"):
        app(["marker-set", "show", "kiss-15", "--figure", str(tmp_path / "set.svg")])
    with pytest.raises(KinemarkError, match="endings"):
        app(["marker-set", "show", "kiss-15", "--figure", str(tmp_path / "set.png")])


def test_a_marker_set_is_learnt_from_a_file(files, capsys):
    assert run("marker-set", "FROM", files / "known.c3d", "-o", files / "own.toml") == 0
    said = capsys.readouterr().out
    assert "LASI/RASI" in said and "LHEE  left heel, back of the calcaneus" in said
    found = read_marker_set(files / "own.toml")
    assert len(found) == 15 and len(found.segments) == 7
    with pytest.raises(KinemarkError, match="no marker LASSI"):
        app(["marker-set", "from", str(files / "known.c3d"), "-o", str(files / "b.toml"), "--markers", "LASSI"])


def test_a_template_is_learnt_shown_and_labels(files, capsys):
    template = files / "anna.template.h5"
    words = ("--marker-set", "kiss-15", "--subject", "Anna", "--height-mm", "1730")
    assert run("template", "learn", files / "known.c3d", "-o", template, *words) == 0
    assert run("template", "show", template, "--json") == 0
    said = capsys.readouterr().out
    assert json.loads(said[said.index("{") :])["sources"][0]["file"] == "known.c3d"
    assert run("label", files / "bare.c3d", "-t", template, "-o", files / "out.c3d", "--json") == 0
    assert json.loads(capsys.readouterr().out)["missing"] == []
    assert set(read_trial(files / "out.c3d").trajectories.names) == set(walk(1).names)
    assert run("template", "grow", template, files / "out.c3d") == 0
    assert "out.c3d: labelled" in capsys.readouterr().out


def test_wrong_names_are_told_with_their_evidence_and_a_status_of_their_own(files, capsys):
    known = ("-t", files / "known.c3d", "--check")
    assert run("label", files / "known.c3d", *known) == 0
    assert "no wrong names" in capsys.readouterr().out
    assert run("label", files / "known.c3d", files / "swapped.c3d", *known) == 3
    text = capsys.readouterr().out
    assert "swapped.c3d: left and right are swapped in frames" in text and "LKNE/RKNE" in text
    assert run("label", files / "swapped.c3d", *known, "--json") == 3
    found = json.loads(capsys.readouterr().out)[str(files / "swapped.c3d")]
    assert not found["good"] and len(found["sides_swapped"][0]["pairs"]) >= 6
    assert found["sides_swapped"][0]["off_swapped_mm"] < found["sides_swapped"][0]["off_mm"]
    assert run("label", files / "swapped.c3d", files / "absent.c3d", *known) == 1


def test_stated_names_come_from_a_file(files):
    (files / "names.csv").write_text("track,name\n*1,WAND\n")
    known = ("-t", files / "known.c3d", "--names", files / "names.csv")
    assert run("label", files / "bare.c3d", *known, "-o", files / "out.c3d") == 0
    assert "WAND" in read_trial(files / "out.c3d").trajectories.names
    with pytest.raises(KinemarkError, match="several files"):
        app(["label", *map(str, (files / "bare.c3d", files / "known.c3d", *known, "-o", files / "folder"))])


def test_what_is_missing_is_said(files):
    with pytest.raises(KinemarkError, match="--template"):
        app(["label", str(files / "bare.c3d"), "-o", str(files / "out.c3d")])
    with pytest.raises(KinemarkError, match="--check"):
        app(["label", str(files / "bare.c3d"), "-t", str(files / "known.c3d")])


def test_tracks_are_named_by_height_side_and_front(files, capsys):
    """All that are sure are right, of another walk."""
    truth = dict(zip(read_trial(files / "bare.c3d").trajectories.names, walk(2).names, strict=True))
    assert (
        run("label", files / "bare.c3d", "--by-location", files / "known.c3d", "-o", files / "named.c3d", "--json") == 0
    )
    rows = json.loads(capsys.readouterr().out)["tracks"]
    sure = [row for row in rows if row["state"] == "sure"]
    assert len(sure) >= 8 and all(row["name"] == truth[row["track"]] for row in sure)
    written = read_trial(files / "named.c3d").trajectories
    assert {row["name"] for row in sure} == {name for name in written.names if not name.startswith("*")}
    assert (
        run("label", files / "bare.c3d", "--by-location", files / "known.c3d", "-o", files / "all.c3d", "--unsure") == 0
    )
    assert f"sure:     {len(sure)} of 15 tracks, by height, side and front" in capsys.readouterr().out
    for wrong, words in ((["--up", "w"], "wanted: x, y or z"), (["-o", str(files / "named.c3d")], "overwritten")):
        target = [] if "-o" in wrong else ["-o", str(files / "other.c3d")]
        with pytest.raises(KinemarkError, match=words):
            app(["label", str(files / "bare.c3d"), "--by-location", str(files / "known.c3d"), *target, *wrong])
