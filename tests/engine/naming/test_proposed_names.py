"""Names for a file without a session: by templates, labelled trials beside it, and the names that it has."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trial
from kinemark.engine.naming.proposed_names import propose_names
from kinemark.engine.naming.subject_templates import Known, subject_template
from kinemark.engine.naming.template_files import save_template
from kinemark.io.trial import write_trial
from support.walked import clean


def nameless(trial):
    """Tracks in another order without their names; and who they are."""
    order = np.random.default_rng(0).permutation(len(trial)).tolist()
    paths = [trial.paths[k] for k in order]
    called = [f"*{k + 1}" for k in range(len(paths))]
    renamed = tuple(replace(path, name=name) for path, name in zip(paths, called, strict=True))
    return replace(trial, paths=renamed), {name: path.name for name, path in zip(called, paths, strict=True)}


def written(folder, name, trial):
    write_trial(Trial("walk", trial), folder / name)
    return folder / name


def right(found, truth):
    """How many proposals are the marker's own name, and how many are not."""
    good = sum(one.name == truth[track] for track, one in found.names.items())
    return good, len(found.names) - good


@pytest.mark.parametrize("kind", ["trial", "template"])
def test_names_are_those_of_the_subject_beside_the_file(tmp_path, kind):
    tracks, truth = nameless(clean().frames(250, 400))
    file = written(tmp_path, "unknown.c3d", tracks)
    assert propose_names(file, tracks) == ("", {}, ()), "nothing is beside it"
    shown = written(tmp_path, "labelled.trc", clean().frames(0, 250))
    if kind == "template":
        save_template(tmp_path / "subject.template.h5", subject_template([shown], Known()))
        shown.unlink()
    found = propose_names(file, tracks)
    assert found.source == {"trial": "labelled.trc", "template": "subject.template.h5"}[kind]
    good, wrong = right(found, truth)
    assert good >= 0.8 * len(tracks) and wrong <= 1


def test_the_names_that_a_file_has_tell_whose_a_loose_piece_is(tmp_path):
    whole = clean().frames(0, 300)
    one = whole.paths[4]
    first, second = one.xyz.copy(), one.xyz.copy()
    first[140:], second[:150] = np.nan, np.nan
    pieces = (MarkerTrajectory.measured(one.name, first), MarkerTrajectory.measured("*9", second))
    tracks = replace(whole, paths=(*whole.paths[:4], *pieces, *whole.paths[5:]))
    found = propose_names(written(tmp_path, "mine.c3d", tracks), tracks)
    assert found.source == "mine.c3d" and found.names["*9"].name == one.name and set(found.names) == {"*9"}


def test_what_cannot_be_read_or_is_another_thing_proposes_nothing(tmp_path):
    tracks, _ = nameless(clean().frames(250, 400))
    file = written(tmp_path, "unknown.c3d", tracks)
    (tmp_path / "broken.c3d").write_bytes(b"no file")
    (tmp_path / "bad.template.h5").write_bytes(b"none either")
    (tmp_path / "notes.txt").write_text("a walk", "utf-8")
    assert propose_names(file, tracks) == ("", {}, ())
    assert propose_names(file, clean()) == ("", {}, ()), "all have names"
