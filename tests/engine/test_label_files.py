"""A file is labelled by labelled files, and its names are checked."""

from dataclasses import replace

import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.engine.label_files import check_file, check_text, label_file, label_text, template_of
from kinemark.io.trial import read_trial, write_trial
from kinemark.synth import walking, with_markers


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
    assert check_file(files / "right.c3d", template) == ()
    found = check_file(files / "turned.c3d", template)
    assert [set(one.markers) for one in found] == [{a, b}]
    assert abs(found[0].first - 100) < 30 and found[0].stop > 180
    assert "exchanged in frames" in check_text(files / "turned.c3d", found)


def test_what_is_missing_is_said(files):
    with pytest.raises(KinemarkError, match="--template"):
        template_of([])
    with pytest.raises(KinemarkError, match="scale"):
        template_of([files / "known.c3d"], scale=0.0)
    with pytest.raises(KinemarkError, match="four or more"):
        check_file(files / "new.c3d", template_of([files / "known.c3d"]))
