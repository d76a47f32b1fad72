"""A file is labelled by labelled files, and its names are checked."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories, Trial, make_finding, same
from kinemark.engine.audit import audit_file
from kinemark.engine.naming.check_files import check_figures, check_file, check_text
from kinemark.engine.naming.files import label_file, label_files, label_text, template_of
from kinemark.engine.naming.subject_templates import Known, subject_template, with_trial
from kinemark.engine.naming.template_files import load_template, save_template
from kinemark.io.marker_sets import read_marker_set
from kinemark.io.track_names import TrackName
from kinemark.io.trial import read_trial, write_trial
from kinemark.label import learn_template
from kinemark.label.subject_template import SubjectTemplate
from kinemark.synth import walking, with_markers
from support.wearing import body_of, moving


def walk(seed):
    return with_markers(walking(duration_s=2.0, rate=100.0, seed=seed, wobble_mm=1.0), 15, seed=1).trajectories


@pytest.fixture
def files(tmp_path):
    """A labelled trial, and another one without names."""
    write_trial(Trial("known", walk(1)), tmp_path / "known.c3d")
    paths = tuple(replace(path, name=f"*{k}") for k, path in enumerate(reversed(walk(7).paths), 1))
    write_trial(Trial("new", Trajectories(paths, 100.0)), tmp_path / "new.c3d")
    return tmp_path


def test_the_file_that_is_written_has_the_names(files):
    target = files / "labelled.c3d"
    done = label_file(files / "new.c3d", target, template_of([files / "known.c3d"]))
    again = read_trial(target).trajectories
    assert set(again.names) == set(walk(7).names)
    for path in walk(7):
        assert abs(again[path.name].xyz - path.xyz).max() < 0.1
    assert "15 of 15 tracks" in label_text(done) and done.figures["missing"] == []
    with pytest.raises(KinemarkError, match="nothing is overwritten"):
        label_file(files / "new.c3d", target, template_of([files / "known.c3d"]))


def test_a_template_that_does_not_fit_writes_nothing(files):
    far = tuple(MarkerTrajectory.measured(p.name, p.xyz * [1.0, 2.0, 0.3]) for p in walk(1))
    write_trial(Trial("far", Trajectories(far, 100.0)), files / "far.c3d")
    with pytest.raises(KinemarkError, match="Nothing is named"):
        label_file(files / "new.c3d", files / "labelled.c3d", template_of([files / "far.c3d"]))
    assert not (files / "labelled.c3d").exists()


def test_names_exchanged_for_a_while_are_found_where_they_are(files):
    trial = walk(7)
    a, b = "LKNE", "LTIB"
    first, second = trial[a].xyz.copy(), trial[b].xyz.copy()
    first[100:], second[100:] = trial[b].xyz[100:], trial[a].xyz[100:]
    new = {a: first, b: second}
    paths = tuple(MarkerTrajectory.measured(p.name, new.get(p.name, p.xyz)) for p in trial)
    write_trial(Trial("turned", Trajectories(paths, 100.0)), files / "turned.c3d")
    write_trial(Trial("right", trial), files / "right.c3d")
    template = template_of([files / "known.c3d"])
    assert check_file(files / "right.c3d", template).good
    found = check_file(files / "turned.c3d", template)
    assert [set(one.markers) for one in found.exchanged] == [{a, b}] and not found.swapped and not found.mislabelled
    assert abs(found.exchanged[0].first - 100) < 30 and found.exchanged[0].stop > 180
    assert "exchanged in frames" in check_text(files / "turned.c3d", found)
    first, last = check_figures(found)["exchanged"][0]["frames"]
    assert first == found.exchanged[0].first + 1 and last == found.exchanged[0].stop


def test_names_are_not_judged_by_another_subjects_template(files):
    tall = tuple(MarkerTrajectory.measured(p.name, p.xyz * 1.4) for p in walk(1))
    write_trial(Trial("tall", Trajectories(tall, 100.0)), files / "tall.c3d")
    write_trial(Trial("right", walk(7)), files / "right.c3d")
    own, other = template_of([files / "known.c3d"]), template_of([files / "tall.c3d"])
    assert check_file(files / "right.c3d", own).off_share < 0.1
    with pytest.raises(KinemarkError, match=r"is not checked.*it is of another subject.*name the trial anew"):
        check_file(files / "right.c3d", other)
    with pytest.raises(KinemarkError, match="it is of another subject"):
        audit_file(files / "right.c3d", template=other.template, mend=True)
    strange = tuple(replace(path, name=f"P{k}") for k, path in enumerate(walk(7)))
    write_trial(Trial("strange", Trajectories(strange, 100.0)), files / "strange.c3d")
    with pytest.raises(KinemarkError, match="0 of the template's 15 markers are in the trial"):
        audit_file(files / "strange.c3d", template=own.template)
    assert not (files / "edits").exists() and not audit_file(files / "right.c3d", template=own.template).found.asked


def test_alike_subjects_templates_are_told_by_the_distances_that_should_keep(files):
    """Of two subjects of one height few names look exchanged, and each of these would be a false alarm."""
    marker_set = read_marker_set("plug-in-gait-full")
    own, other = (learn_template(moving(marker_set, body_of(marker_set, seed), 50 + seed)) for seed in (1, 2))
    trial = moving(marker_set, body_of(marker_set, 1), 1)
    write_trial(Trial("right", trial), files / "right.c3d")
    some = trial.select([name for name in trial.names if name[1:] not in {"FHD", "BHD", "SHO"}])
    write_trial(Trial("some", some), files / "some.c3d")
    for name in ("right", "some"):
        found = check_file(files / f"{name}.c3d", SubjectTemplate(own))
        assert found.good and found.holds > 0.95
        with pytest.raises(KinemarkError, match=r"is not checked.*it is of another subject"):
            check_file(files / f"{name}.c3d", SubjectTemplate(other))


def test_what_is_missing_is_said(files):
    with pytest.raises(KinemarkError, match="--template"):
        template_of([])
    with pytest.raises(KinemarkError, match="scale"):
        template_of([files / "known.c3d"], scale=0.0)
    with pytest.raises(KinemarkError, match="four or more"):
        check_file(files / "new.c3d", template_of([files / "known.c3d"]))


def saved(files, name, trial):
    write_trial(Trial(name, trial), files / f"{name}.c3d")
    return files / f"{name}.c3d"


def without_names(trial):
    return replace(trial, paths=tuple(replace(path, name=f"*{k}") for k, path in enumerate(trial.paths, 1)))


def test_a_template_that_was_kept_stands_for_the_trials(files):
    learnt = template_of([files / "known.c3d"], Known(read_marker_set("kiss-15"), subject="Anna", height_mm=1730.0))
    save_template(files / "anna.template.h5", learnt)
    kept = template_of([files / "anna.template.h5"])
    assert same(kept, learnt) and kept.subject == "Anna" and kept.marker_set == "kiss-15"
    done = label_file(files / "new.c3d", files / "out.c3d", kept)
    assert done.figures["missing"] == []
    grown = template_of([files / "anna.template.h5", saved(files, "other", walk(3))])
    assert [source.file for source in grown.sources] == ["known.c3d", "other.c3d"]
    assert grown.template.frames.max() == 2 * kept.template.frames.max()
    data = bytearray((files / "anna.template.h5").read_bytes())
    data[5000] ^= 1
    (files / "bad.template.h5").write_bytes(data)
    for bad in ("bad.template.h5", "absent.template.h5"):
        with pytest.raises(KinemarkError, match=bad):
            load_template(files / bad)
    with pytest.raises(KinemarkError, match="2 templates"):
        template_of([files / "anna.template.h5", files / "anna.template.h5"])
    with pytest.raises(KinemarkError, match=r"anna\.template\.h5"):
        save_template(files / "anna.h5", learnt)


def test_a_trial_of_another_body_or_with_wrong_names_is_not_added(files):
    own = template_of([files / "known.c3d"])
    tall = replace(walk(3), paths=tuple(replace(p, xyz=1.2 * p.xyz) for p in walk(3)))
    with pytest.raises(KinemarkError, match="says otherwise"):
        with_trial(own, saved(files, "tall", tall))
    other = {"LKNE": "LANK", "LANK": "LKNE"}
    turned = replace(walk(3), paths=tuple(replace(p, name=other.get(p.name, p.name)) for p in walk(3)))
    with pytest.raises(KinemarkError, match="LKNE"):
        with_trial(own, saved(files, "turned", turned))


def test_names_with_a_subjects_prefix_are_those_of_the_set(files):
    prefixed = replace(walk(1), paths=tuple(replace(p, name=f"Anna:{p.name}") for p in walk(1)))
    known = Known(read_marker_set("kiss-15"))
    assert set(subject_template([saved(files, "prefixed", prefixed)], known).template.names) == set(walk(1).names)


def test_the_set_and_a_height_name_what_they_can_and_are_never_sure(files):
    worn = read_marker_set("kiss-15")
    found = template_of([], Known(worn, height_mm=1730.0))
    assert found.figure_alone
    done = label_file(files / "new.c3d", files / "out.c3d", found)
    assert "sure" not in done.labels.state and "figure alone" in label_text(done)
    for known, says in (
        (Known(worn), "height"), (Known(), "--template"), (Known(worn, height_mm=1.73), "in mm"),
        (Known(worn, height_mm=1730.0, heights_mm=(1600.0,)), "1 heights of others and 0 files"),
    ):  # fmt: skip
        with pytest.raises(KinemarkError, match=says):
            template_of([], known)


def test_other_subjects_scaled_by_height_name_this_one(files):
    paths = []
    for k, height in enumerate((1500.0, 1850.0)):
        trial = walking(duration_s=2.0, rate=100.0, seed=k, wobble_mm=1.0, height_mm=height).trajectories
        paths.append(saved(files, f"other{k}", trial))
    found = template_of(paths, Known(height_mm=1730.0, heights_mm=(1500.0, 1850.0)))
    done = label_file(files / "new.c3d", files / "out.c3d", found)
    assert done.figures["missing"] == [] and not found.figure_alone
    assert {source.kind for source in found.sources} == {"other subject"}


def test_several_files_go_into_a_folder_and_one_that_fails_keeps_nobody_from_the_others(files):
    template = template_of([files / "known.c3d"])
    done = label_files([files / "new.c3d", files / "absent.c3d"], files / "out", template)
    assert (files / "out" / "new.c3d").is_file()
    assert isinstance(done[files / "absent.c3d"], KinemarkError)
    with pytest.raises(KinemarkError, match="Name a folder"):
        label_files([files / "new.c3d", files / "known.c3d"], files / "one.c3d", template)


def test_what_is_stated_of_tracks_stands(files):
    tracks = without_names(walk(7))
    source = saved(files, "tracks", tracks)
    truth = dict(zip(tracks.names, walk(7).names, strict=True))
    a, b = "*4", "*9"
    stated = (TrackName(a, "WAND"), TrackName(b, None), TrackName("*1", truth["*1"], 1, 50), TrackName("*1", "X", 51))
    done = label_file(source, files / "out.c3d", template_of([files / "known.c3d"]), stated=stated)
    names = set(done.trajectories.names)
    assert {"WAND", "X", truth["*1"]} <= names and truth[b] not in names and truth[a] not in names
    assert np.isfinite(done.trajectories["X"].xyz[:, 0]).sum() == 150
    for wrong, says in (
        ((TrackName("*99", "LASI"),), "no track"),
        ((TrackName("*1", "LASI"), TrackName("*2", "LASI")), "both said to be LASI"),
        ((TrackName("*1", "LASI", 500, 600),), "no sample"),
    ):
        with pytest.raises(KinemarkError, match=says):
            label_file(source, files / "other.c3d", template_of([files / "known.c3d"]), stated=wrong)


def test_another_subjects_trial_given_as_the_own_is_said_in_words_and_makes_no_name_sure(tmp_path):
    worn = read_marker_set("plug-in-gait-full")
    write_trial(Trial("other", moving(worn, body_of(worn, 11, misplaced=0.005), 1)), tmp_path / "other.c3d")
    new = moving(worn, body_of(worn, 12, misplaced=0.005), 2, duration_s=1.0)
    new = replace(new, paths=tuple(replace(p, name=f"*{k}") for k, p in enumerate(new.paths, 1)))
    write_trial(Trial("new", new), tmp_path / "new.c3d")
    done = label_file(tmp_path / "new.c3d", tmp_path / "out.c3d", template_of([tmp_path / "other.c3d"]))
    assert "the template is of another subject" in label_text(done) and "--scale" in label_text(done)
    assert done.figures["another_subject"] is not None and "sure" not in done.labels.state


def test_what_is_undecided_of_sides_is_said_in_words(files):
    done = label_file(files / "new.c3d", files / "labelled.c3d", template_of([files / "known.c3d"]))
    assert done.figures["undecided"] is None
    for kind, words in (("world_mirrored", "mirror image of the template"), ("sides_undecided", "cannot be told")):
        told = done._replace(labels=replace(done.labels, undecided=make_finding(kind, markers=["LKNE"])))
        assert words in label_text(told) and words not in label_text(done)


def test_a_marker_beside_its_place_in_the_template_is_named_and_told_with_what_to_do(files):
    trial = walk(7)
    up = trial["LASI"].xyz - trial["LKNE"].xyz
    moved = MarkerTrajectory.measured("LTHI", trial["LTHI"].xyz + 25 * up / np.linalg.norm(up, axis=1, keepdims=True))
    paths = (moved if path.name == "LTHI" else path for path in trial)
    write_trial(Trial("new", replace(trial, paths=tuple(paths))), files / "moved.c3d")
    done = label_file(files / "moved.c3d", files / "labelled.c3d", template_of([files / "known.c3d"]))
    [one] = done.figures["displaced"]
    assert one["name"] == "LTHI" and 20 < one["off_mm"] < 30 and done.figures["missing"] == []
    assert "sits beside its place in the template: LTHI by 2" in label_text(done)
    assert "state its name by hand" in label_text(done)
    some = [{"name": f"M{k}", "off_mm": 20.0 + k} for k in range(14)]
    many = label_text(done._replace(figures=done.figures | {"displaced": some}))
    assert "M0 by 20\u00a0mm, M1 by 21\u00a0mm" in many and "M11 by 31\u00a0mm and 2 more." in many
    assert "beside:" not in label_text(done._replace(figures=done.figures | {"displaced": []}))
