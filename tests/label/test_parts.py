"""Bodies that move by themselves, and limbs in postures that the template never showed, are named part by part."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy
from labelling_scores import score_labels
from labelling_shredded import shredded

from kinemark.data import MarkerTrajectory
from kinemark.io.marker_sets import read_marker_set
from kinemark.label import Labels, label, learn_template
from kinemark.label.parts import Found, _rivalled, _score, part_of, stiff_parts, with_parts
from support.tools import tools
from support.wearing import body_of, moving

SET = read_marker_set("plug-in-gait-full")
ARM = ("UPA", "ELB", "FRM", "WRA", "WRB", "FIN")


@cache
def worn():
    """A template of a walk, and another walk with the arms raised sideways, which the first never shows."""
    body = body_of(SET, 4)
    trial, new = moving(SET, body, 41), {}
    for side, angle in (("L", 1.9), ("R", -1.9)):
        joint = trial[f"{side}SHO"].xyz - [0.0, 0.0, 30.0]
        turn = scipy.spatial.transform.Rotation.from_rotvec([angle, 0.0, 0.0]).as_matrix()
        for name in (side + end for end in ARM):
            new[name] = MarkerTrajectory.measured(name, (trial[name].xyz - joint) @ turn.T + joint)
    return learn_template(moving(SET, body, 40)), replace(trial, paths=tuple(new.get(p.name, p) for p in trial))


@pytest.mark.parametrize("seed", [1, 3, 4, 6])
def test_tools_are_named_whatever_their_places_to_each_other(seed):
    template, parts = learn_template(tools(seed, 1)), shredded(tools(seed, 2), 2, 1.0, seed)
    score = score_labels(label(parts.tracks, template), parts, template.names)
    least = 0.8 if seed == 1 else 0.9  # of 1 half of a track, which is right, is 0.97 likely; 1: .65, 4: .75 before
    assert score.best_right > 0.99 and score.right > least and score.wrong == 0 and score.ghosts == 0


def test_arms_in_a_new_posture_are_named():
    template, trial = worn()
    parts = shredded(trial, 1, 1.0, 5)
    score = score_labels(label(parts.tracks, template), parts, template.names)
    assert score.best_right > 0.85 and score.wrong == 0 and score.ghosts == 0  # by the body as a whole .79


def test_a_part_is_what_keeps_all_its_distances():
    template = learn_template(tools(1, 1))
    found = {tuple(template.names[a] for a in part) for part in stiff_parts(template, np.ones(len(template), bool))}
    assert found == {tuple(f"{body}{m}" for m in (1, 2, 3, 4)) for body in "ABCD"}


def test_a_part_that_another_fits_as_well_is_doubted():
    left, right, other = (
        Found(dict.fromkeys(at, 0), None, score)
        for at, score in (([1, 2, 3, 4], 40.0), ([2, 3, 4], 35.0), ([5, 6, 7], 50.0))
    )
    assert _rivalled(left, [left, right, other]) and not _rivalled(other, [left, right, other])
    assert not _rivalled(left, [left, right._replace(score=20.0), other])


def test_other_tools_are_refused():
    found = label(shredded(tools(8, 2), 1, 1.0, 1).tracks, learn_template(tools(7, 1)))
    assert found.refused is not None and not any(found.names)


def test_a_mirrored_part_is_none():
    """All its distances hold; the orientation of its four markers does not."""
    template, trial = part_of(learn_template(tools(4, 1)), np.arange(4)), tools(4, 2)
    trial = trial.select(template.names)
    mirrored = replace(trial, paths=tuple(replace(p, xyz=p.xyz * [-1.0, 1.0, 1.0]) for p in trial))
    four = Labels(template.names, np.ones(4), ("sure",) * 4, (None,) * 4, np.ones(4), 1.0, 1.0)
    assert _score(trial, four, template, 700.0) > 0 > _score(mirrored, four, template, 700.0)


def test_parts_are_not_looked_for_again_among_the_same_tracks():
    """Two arms that fit the same tracks equally well are doubted, and found in no other way a second time."""
    trial, template, asked = tools(4, 2), learn_template(tools(4, 1)), []
    none = Labels((None,) * 16, np.zeros(16), ("unknown",) * 16, (None,) * 16, np.full(16, np.nan), 0.0, 0.0)

    def half(tracks, by, stated):
        asked.append((tracks.names, by.names))
        names = tuple(name if name in by.names else None for name in tracks.names)
        p = np.array([0.4 if name else 0.0 for name in names])
        state = tuple("unsure" if name else "unknown" for name in names)
        return Labels(names, p, state, (None,) * len(names), p, 1.0, 1.0)

    with_parts(trial, none, template, half)
    assert len(asked) == len(set(asked)) == 4
