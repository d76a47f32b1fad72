"""Files with axes and joint centres beside the markers: these are left alone, said, and kept as they were."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import MarkerTrajectory, Trajectories, Trial, same
from kinemark.engine.naming import files as engine_files
from kinemark.engine.naming.check_files import check_file
from kinemark.engine.naming.files import label_file, label_text, template_of
from kinemark.engine.naming.marker_set_files import set_from_file
from kinemark.engine.naming.subject_templates import Known
from kinemark.engine.naming.templates import session_template
from kinemark.engine.put_aside import computed_in, put_aside, put_back
from kinemark.io.c3d import Parameter, modeled_points, read_document, with_parameters, write_document
from kinemark.io.trial import read_trial, write_trial
from kinemark.label import Labelling, label_switching, learn_template
from support.computed import computed, walker, with_computed
from support.shared import shared_data


@pytest.fixture
def files(tmp_path):
    """A walk of a program that computes, and another one whose markers are called otherwise; of 15 markers."""
    few = walker().names[:15]
    for name, seed in (("known", 1), ("new", 2)):
        own = with_computed(walker(seed, duration_s=1.0))
        write_trial(Trial(name, own.select([*few, *computed(walker(seed))])), tmp_path / f"{name}.c3d")
    return tmp_path


def test_markers_are_named_and_computed_points_are_kept_and_said(files):
    template = template_of([files / "known.c3d"])
    assert template.template.names == tuple(sorted(walker().names[:15]))
    done = label_file(files / "new.c3d", files / "out.c3d", template)
    assert set(done.labels.state) == {"sure"} and len(done.labels) == 15
    assert set(done.figures["computed"]) == set(computed(walker()))
    assert "26 computed points, such as LFEA" in label_text(done) and "--computed" in label_text(done)
    before, after = (read_trial(files / name).trajectories for name in ("new.c3d", "out.c3d"))
    assert set(before.names) == set(after.names)
    assert all(same(before[name], after[name]) for name in before.names)


def test_they_are_learnt_and_named_where_that_is_asked_for(files):
    template = template_of([files / "known.c3d"], Known(computed=True))
    assert set(template.template.names) == set(read_trial(files / "known.c3d").trajectories.names)
    one = template_of([files / "known.c3d"], Known(markers=(*walker().names[:15], "LFEO")))
    assert "LFEO" in one.template.names and "LFEA" not in one.template.names
    done = label_file(files / "new.c3d", files / "out.c3d", one)
    assert "LFEO" not in done.figures["computed"] and "LFEO" in done.labels.names
    with pytest.raises(SystemExit) as end:
        app(
            [
                "label",
                str(files / "new.c3d"),
                "-t",
                str(files / "known.c3d"),
                "--computed",
                "-o",
                str(files / "all.c3d"),
            ]
        )
    assert not end.value.code


def test_names_are_checked_and_sets_and_sessions_learnt_without_them(files):
    assert check_file(files / "new.c3d", template_of([files / "known.c3d"], Known(computed=True))).good
    assert set(set_from_file(files / "known.c3d", files / "own.toml").names) == set(walker().names[:15])
    session = SimpleNamespace(label=Labelling(template=("known.c3d",)), marker_set=None, gait=None)
    assert session_template(files, session, ()).template.names == tuple(sorted(walker().names[:15]))


def test_what_a_static_trial_does_not_show_to_be_computed_is_told_by_the_trials_to_be_named(files):
    """Nothing moves in it, so that a centre of mass keeps its distances as a marker does."""
    few = walker().names[:15]
    frame = walker(2).select(few).xyz[:, 50:51]
    still = frame + np.random.default_rng(0).normal(0, 0.1, (15, 60, 3))
    standing = Trajectories(tuple(map(MarkerTrajectory.measured, few, still)), 100.0)
    centre = standing.xyz.mean(0)
    more = {"CentreOfMass": centre, "CentreOfMassFloor": centre * [1.0, 1.0, 0.0]}
    paths = (MarkerTrajectory.measured(name, xyz) for name, xyz in more.items())
    write_trial(Trial("static", replace(standing, paths=(*standing.paths, *paths))), files / "static.c3d")
    alone = template_of([files / "static.c3d"], Known(static=True))
    assert "CentreOfMass" in alone.template.names
    named = (files / "damaged.c3d", files / "new.c3d")
    named[0].write_bytes(b"no trial")
    found = template_of([files / "static.c3d"], Known(static=True, to_name=named))
    assert sorted(found.template.names) == sorted(few)
    kept = template_of([files / "static.c3d"], Known(static=True, to_name=named, markers=(*few, "CentreOfMass")))
    assert "CentreOfMass" in kept.template.names


def test_a_marker_that_fell_off_in_one_trial_to_be_named_is_one_of_the_others(files):
    """It lies still on the floor there, as a computed point may; nor tell points without a name of another file's."""
    walk = read_trial(files / "new.c3d")
    fallen = walk.trajectories["LKNE"].xyz * 0.0 + [100.0, 200.0, 8.0]
    paths = [
        MarkerTrajectory.measured("LKNE", fallen) if path.name == "LKNE"
        else replace(path, name="*4") if path.name == "LFEA" else path
        for path in walk.trajectories
    ]  # fmt: skip
    write_trial(replace(walk, trajectories=replace(walk.trajectories, paths=tuple(paths))), files / "fallen.c3d")
    aside = {path.name for path in put_aside(read_trial(files / "fallen.c3d")).aside}
    told = computed_in([files / "fallen.c3d", files / "new.c3d"])
    assert {"LKNE", "*4", "LFEP"} <= aside and {"LFEA", "LFEP"} <= told and not {"LKNE", "*4"} & told
    known = Known(static=True, to_name=(files / "fallen.c3d", files / "new.c3d"))
    assert "LKNE" in template_of([files / "known.c3d"], known).template.names


def test_the_command_tells_the_template_which_trials_are_to_be_named(files, monkeypatch):
    told = []
    monkeypatch.setattr(engine_files, "template_of", lambda paths, known, **how: told.append(known.to_name) or 1 / 0)
    with pytest.raises(ZeroDivisionError):
        app(["label", str(files), "-t", str(files / "known.c3d"), "--static"], result_action="return_value")
    assert told == [(files / "new.c3d",)]


def test_what_a_file_lists_as_its_programs_own_is_put_aside(files):
    doc = read_document(files / "known.c3d")
    said = [Parameter.text("TYPE_GROUPS", ["ANGLES", "ANGLE", "BONES", "BONE"])]
    said += [Parameter.text("MODELED_MARKERS", ["LTHI"]), Parameter.text("BONES", ["RTHI"])]
    write_document(files / "said.c3d", with_parameters(doc, "POINT", said))
    trial = read_trial(files / "said.c3d")
    assert modeled_points(trial.source) == ("LTHI", "RTHI") and modeled_points("no C3D") == ()
    names = {path.name for path in put_aside(trial).aside}
    assert names == {"LTHI", "RTHI", *computed(walker())}
    kept = put_aside(trial, keep=["LTHI", "PELO"]).rest
    assert {"LTHI", "PELO"} <= set(kept.names)


def test_points_without_a_name_get_another_number_where_theirs_is_taken():
    places = np.zeros((3, 3))
    some = [MarkerTrajectory.measured(name, places + k) for k, name in enumerate(("*1", "*2", "LFEO", "*2"))]
    done = replace(walker(), paths=tuple(some[:2]))
    assert put_back(done, some[2:]).names == ("*1", "*2", "LFEO", "*3")


def test_a_published_file_is_named_and_its_own_exchange_is_found():
    """Of 180 points 59 are markers; RNAV and RHLX go over into each other while they cross."""
    known, new = (put_aside(read_trial(shared_data(f"mocap3d/pig_gait_children/HC032A{k}.c3d"))) for k in ("03", "18"))
    assert len(known.aside) == len(new.aside) == 113
    right = [name for name in known.rest.names if name.startswith("R")]
    found = label_switching(new.rest.select(right).frames(120, 200), learn_template(known.rest, names=right))
    wrong = {one for one, name in zip(found.tracks.names, found.labels.names, strict=True) if one.split()[0] != name}
    assert wrong == {"RNAV (2)", "RHLX (2)"} and set(found.labels.state) == {"sure"}
    assert [(one.before, one.after, one.frame) for one in found.switches] == [
        ("RNAV", "RHLX", 37),
        ("RHLX", "RNAV", 37),
    ]
