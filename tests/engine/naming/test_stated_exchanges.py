"""Two markers that a person gave each other's names: it is kept, said where it is, and by a template not learnt."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory
from kinemark.engine.naming.stated_exchanges import stated_exchanges
from kinemark.engine.naming.templates import SessionTemplate
from kinemark.engine.session import Session
from kinemark.label import learn_template
from kinemark.synth import walking, with_markers
from support.named_sessions import motion, session_of

TWO = ("LKNE", "LTHI")


@cache
def walk(seed):
    return with_markers(walking(duration_s=3.0, rate=100.0, seed=seed, wobble_mm=1.0), 39, seed=1).trajectories


def exchanged(trial, first, stop):
    a, b = (trial.names.index(name) for name in TWO)
    xyz = trial.xyz.copy()
    xyz[[a, b], first:stop] = xyz[[b, a], first:stop]
    paths = (MarkerTrajectory.measured(name, one) for name, one in zip(trial.names, xyz, strict=True))
    return replace(trial, paths=tuple(paths))


def by(subject=""):
    return {subject: SessionTemplate(learn_template(walk(1)), ("earlier",))}


@pytest.mark.parametrize(("first", "stop"), [(0, 300), (0, 100), (150, 300)])
def test_by_a_template_it_is_said_and_nobody_learns_it(first, stop):
    found = stated_exchanges(exchanged(walk(7), first, stop), by(), [*TWO, None])
    (said,) = found.findings
    assert said.kind == "stated_names_exchanged" and set(said.markers) == set(TWO) and said.values["template"]
    np.testing.assert_allclose(said.frames, [(first, stop - 1)], atol=50)  # windows of half a second
    for name in TWO:
        learnt = np.isfinite(found.learnt[name].xyz[:, 0])
        assert (
            not learnt[first + 50 : stop - 50].any()
            and learnt[: max(first - 50, 0)].all()
            and learnt[stop + 50 :].all()
        )


def test_without_a_template_the_trial_itself_says_that_names_change():
    done = exchanged(walk(7), 0, 100)
    found = stated_exchanges(done, {}, TWO)
    (said,) = found.findings
    assert set(said.markers) == set(TWO) and not said.values["template"]
    assert stated_exchanges(exchanged(walk(7), 0, 300), {}, TWO).findings == ()  # nothing tells it


def test_nothing_is_said_of_right_names_nor_of_what_nobody_stated():
    assert stated_exchanges(walk(7), by(), walk(7).names).findings == ()
    assert stated_exchanges(walk(7), {}, walk(7).names).findings == ()
    for stated in ([], [None], ["RANK"]):
        found = stated_exchanges(exchanged(walk(7), 0, 300), by(), stated)
        assert found.findings == () and np.isfinite(found.learnt["LKNE"].xyz).all()


def test_a_subjects_markers_are_said_with_its_name():
    done = exchanged(walk(7), 0, 300)
    done = replace(done, paths=tuple(replace(path, name=f"A:{path.name}") for path in done))
    (said,) = stated_exchanges(done, by("A"), ["A:LKNE"]).findings
    assert set(said.markers) == {"A:LKNE", "A:LTHI"}


def test_a_trial_whose_names_were_exchanged_by_hand_keeps_them_says_so_and_spoils_no_other(tmp_path):
    truth, turn = motion("walk01"), {"LANK": "LTOE", "LTOE": "LANK"}
    rows = [
        f"walk01,20,{x},{y},{z},{turn.get(name, name)}"
        for name, (x, y, z) in zip(truth.names, truth.xyz[:, 19].tolist(), strict=True)
    ]
    (tmp_path / "names.csv").write_text("\n".join(["trial,frame,x_mm,y_mm,z_mm,name", *rows]))
    folder = session_of(tmp_path, "walk01", "walk02", label='template = ["earlier.c3d"]\nnames = "names.csv"')
    done = Session.open(folder).run(to="quality")
    kinds = [one["kind"] for one in done["walk01"].quality["findings"]]
    assert kinds.count("stated_names_exchanged") == 1
    for trial, names in (("walk01", turn), ("walk02", {})):
        own, there = done[trial].trajectories, motion(trial)
        for name in turn:
            away = np.linalg.norm(own[name].xyz - there.xyz[there.names.index(names.get(name, name))], axis=1)
            assert np.nanmedian(away) < 15.0
