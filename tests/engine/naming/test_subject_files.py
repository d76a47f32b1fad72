"""Two subjects in one file: each named by a template of its own, with its name before those of the markers."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError, Trajectories, Trial
from kinemark.engine.naming.marker_set_files import set_from_file
from kinemark.engine.naming.subject_templates import Known, of_subject, templates_of_subjects
from kinemark.io.c3d import Parameter, prefixes_of, read_document, with_parameters
from kinemark.io.c3d.about import with_prefixes
from kinemark.io.trial import read_trial, write_trial
from kinemark.synth import walking, with_markers


def walk(seed, size=1.0, beside=0.0, before=""):
    trial = with_markers(walking(duration_s=1.5, rate=50.0, seed=seed, wobble_mm=1.0), 15, seed=1).trajectories
    return tuple(replace(p, name=before + p.name, xyz=size * p.xyz + [0.0, beside, 0.0]) for p in trial)


@pytest.fixture
def files(tmp_path):
    """A labelled trial of both, one of the second alone, and another of both without names."""
    both = (*walk(1, before="Anna:"), *walk(2, 0.85, 800.0, "Ben:"))
    write_trial(Trial("known", Trajectories(both, 50.0)), tmp_path / "known.c3d")
    write_trial(Trial("ben", Trajectories(walk(2, 0.85), 50.0)), tmp_path / "ben.c3d")
    new = (*walk(8, 0.85, 800.0), *walk(7))
    numbered = tuple(replace(p, name=f"*{k}") for k, p in enumerate(new, 1))
    write_trial(Trial("new", Trajectories(numbered, 50.0)), tmp_path / "new.c3d")
    return tmp_path


def test_the_command_names_both_with_their_prefix(files):
    said = ["--subject", f"Anna={files / 'known.c3d'}", "--subject", f"Ben={files / 'ben.c3d'}"]
    with pytest.raises(SystemExit) as end:
        app(["label", str(files / "new.c3d"), *said, "-o", str(files / "out.c3d")])
    assert not end.value.code
    found = read_trial(files / "out.c3d").trajectories
    assert prefixes_of(read_document(files / "out.c3d")) == {"Anna": "Anna:", "Ben": "Ben:"}
    truth = (*walk(7, before="Anna:"), *walk(8, 0.85, 800.0, "Ben:"))
    assert {name for name in found.names if name[0] != "*"} == {path.name for path in truth}
    for path in truth:
        assert np.abs(found[path.name].xyz - path.xyz).max() < 0.1


def test_a_subject_s_markers_are_taken_by_what_stands_before_their_names(files):
    found = templates_of_subjects([f"{name}={files / 'known.c3d'}" for name in ("Anna", "Ben")], Known())
    assert found["Anna"].template.names == found["Ben"].template.names and len(found["Ben"].template) == 15
    assert found["Ben"].template.size == pytest.approx(0.85 * found["Anna"].template.size, rel=0.05)
    trial = read_trial(files / "known.c3d").trajectories
    other = replace(trial, paths=tuple(replace(p, name=p.name.replace("Ben:", "S2_")) for p in trial))
    assert len(of_subject(other, "Ben", {"Ben": "S2_"})) == 15 and len(of_subject(other, "Ben", {})) == 30
    for wrong in (["Anna"], ["=x.c3d"], [f"A={files / 'ben.c3d'}"] * 2):
        with pytest.raises(KinemarkError, match="no subject with a template"):
            templates_of_subjects(wrong, Known())


def test_prefixes_are_as_the_file_says_them(files):
    doc = read_document(files / "known.c3d")
    said = [Parameter.text("NAMES", ["Anna", "Ben"]), Parameter.text("LABEL_PREFIXES", ["S1_", "S2_"])]
    with_names = with_parameters(doc, "SUBJECTS", said)
    assert prefixes_of(with_names) == {} == prefixes_of("no C3D")
    names = ["Anna:LKNE", "Ben:LKNE", "*1"]
    stated = with_prefixes(doc, ("Anna", "Ben"), names)
    assert prefixes_of(stated) == {"Anna": "Anna:", "Ben": "Ben:"}
    assert with_prefixes(stated, ("Anna", "Ben"), names) is stated
    assert with_prefixes(doc, ("Anna",), ["LKNE"]) is doc
    used = with_parameters(with_names, "SUBJECTS", [Parameter.whole("USES_PREFIXES", 1)])
    assert prefixes_of(used) == {"Anna": "S1_", "Ben": "S2_"}


def test_a_name_that_stands_before_all_markers_of_a_subjects_own_file_is_left_out():
    """Programs write `Kid:LASI`; the name that is given here stands before it, not both."""
    bare = Trajectories(tuple(walk(1)), 100.0)
    called = replace(bare, paths=tuple(replace(path, name=f"Kid:{path.name}") for path in bare))
    assert of_subject(called, "B", {}).names == bare.names
    mixed = replace(called, paths=(*called.paths[:-1], bare.paths[-1]))
    assert of_subject(mixed, "B", {}) is mixed and of_subject(called, "", {}) is called


def test_a_marker_set_learnt_of_one_subject_has_the_names_of_no_one(tmp_path):
    """Another subject's file has another name before its markers, and the set named none of them."""
    trial = walking(duration_s=2.0, rate=50.0, seed=1).trajectories
    called = replace(trial, paths=tuple(replace(path, name=f"Kid:{path.name}") for path in trial))
    write_trial(Trial("walk", called), tmp_path / "walk.c3d")
    found = set_from_file(tmp_path / "walk.c3d", tmp_path / "set.toml")
    assert found.names == trial.names and found.meaning["LKNE"]
    few = set_from_file(tmp_path / "walk.c3d", tmp_path / "few.toml", names=["LASI", "RASI", "Kid:SACR", "LKNE"])
    assert few.names == ("LASI", "RASI", "SACR", "LKNE")
