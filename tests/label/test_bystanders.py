"""Markers that nobody named, in the static trial and in the walk, tell which of two neighbours bears a name."""

from dataclasses import replace
from functools import cache

import numpy as np

from kinemark.data import MarkerTrajectory, make_finding
from kinemark.io.marker_sets import read_marker_set
from kinemark.io.records import load_any, save_any
from kinemark.label import Labels, SubjectTemplate, label, static_template
from kinemark.label.bystanders import among_bystanders
from kinemark.label.from_set import static_bystanders
from support.wearing import body_of, moving, standing

BESIDE = ("LTHI", "RTHI", "LTIB", "RTIB", "LTOE", "RTOE")
"""That have nameless neighbours beside them, fixed to them and the next two markers of the leg."""

BESIDE_MM = 100.0


@cache
def trials():
    worn = read_marker_set("plug-in-gait-full")
    body = body_of(worn, 3)
    still, walk = standing(worn, body), moving(worn, body, 23, duration_s=2.0)
    return worn, with_neighbours(still, "*1{}"), with_neighbours(walk, "*2{}")


def with_neighbours(trial, called):
    """With a marker beside each of some, which has another number in each trial."""
    more = []
    for k, name in enumerate(BESIDE):
        side, x = name[0], trial[name].xyz
        along, across = trial[f"{side}KNE"].xyz - x, trial[f"{side}ANK"].xyz - x
        out = np.cross(along, across)
        more += [
            MarkerTrajectory.measured(called.format(k), x + BESIDE_MM * out / np.linalg.norm(out, axis=1)[:, None])
        ]
    return replace(trial, paths=(*trial.paths, *more))


def test_who_stands_beside_a_marker_in_both_trials_makes_its_name_sure():
    worn, still, walk = trials()
    by, wider = static_template(still, worn), static_bystanders(still, worn)
    alone = label(walk, by)
    found = among_bystanders(walk, alone, by, wider)
    truth = [name if name in by.names else None for name in walk.names]
    sure = [state == "sure" for state in found.state]
    assert found.names == tuple(truth)
    assert sum(sure) == len(by) > alone.state.count("sure")
    assert all(
        s == "unknown" and p == 0 for s, p, t in zip(found.state, found.probability, truth, strict=True) if t is None
    )
    assert all(name is None or name in by.names for name in found.runner_up)


def test_markers_that_have_names_but_none_of_the_set_stand_beside_as_well():
    worn, still, _ = trials()
    called = replace(still, paths=tuple(replace(p, name=p.name.replace("*1", "Extra")) for p in still))
    wider = static_bystanders(called, worn)
    assert len(wider) == len(static_template(still, worn)) + len(BESIDE)
    assert sum(name.startswith("Extra") for name in wider.names) == len(BESIDE)


def test_without_nameless_markers_in_the_static_trial_nothing_is_known_of_them():
    worn, still, _ = trials()
    assert static_bystanders(still.select(read_marker_set("plug-in-gait-full").moving), worn) is None
    brief = replace(still, paths=tuple(p.only(np.arange(len(p)) < 2) if p.name[0] == "*" else p for p in still))
    assert len(still.paths[0]) > 4 and static_bystanders(brief, worn) is None


def test_computed_points_of_the_static_trial_are_no_bystanders():
    worn, still, _ = trials()
    x = still["LASI"].xyz
    axes = zip(("PELO", "PELA", "PELL", "PELP"), np.vstack([np.zeros(3), 200 * np.eye(3)]), strict=True)
    points = tuple(MarkerTrajectory.measured(name, x + np.array([0, 0, 150]) + tip) for name, tip in axes)
    wider = static_bystanders(replace(still, paths=(*still.paths, *points)), worn)
    assert wider.names == static_bystanders(still, worn).names


def test_what_is_known_for_sure_or_was_refused_stays_as_it_was():
    worn, still, walk = trials()
    by, wider = static_template(still, worn), static_bystanders(still, worn)
    truth = tuple(name if name in by.names else None for name in walk.names)
    p = np.array([float(name is not None) for name in truth])
    state = tuple("unknown" if name is None else "sure" for name in truth)
    settled = Labels(truth, p, state, (None,) * len(p), p, 1.0, 1.0)
    assert among_bystanders(walk, settled, by, wider) is settled
    refused = replace(
        settled, probability=0.5 * p, refused=make_finding("labels_refused", fit_share=0.1, placed_share=0.1)
    )
    assert among_bystanders(walk, refused, by, wider) is refused


def test_a_kept_template_keeps_them(tmp_path):
    worn, still, _ = trials()
    own = SubjectTemplate(static_template(still, worn), wider=static_bystanders(still, worn))
    save_any(tmp_path / "a.template.h5", own)
    back = load_any(tmp_path / "a.template.h5", {"SubjectTemplate": SubjectTemplate})
    assert back.wider.names == own.wider.names and len(own.wider) == len(own.template) + len(BESIDE)
    np.testing.assert_array_equal(back.wider.distance, own.wider.distance)
