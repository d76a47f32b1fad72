"""Where an absent marker leaves distances that tell nothing, feet and pelvis decide."""

from functools import cache

import numpy as np
import pytest

from kinemark.io.marker_sets import read_marker_set
from kinemark.label import static_template
from kinemark.label.decided_sides import decided_sides
from kinemark.label.evidence import PairScore
from kinemark.label.side_pairs import mirrored
from kinemark.label.solve import _settled
from kinemark.label.stretches import stretches_of
from support.wearing import body_of, moving

SEEDS = (1, 2, 5)


@cache
def known(seed):
    """The template of a static trial of 15 markers, and a walk."""
    worn = read_marker_set("kiss-15")
    body = body_of(worn, seed)
    static, walk = (moving(worn, body, k, duration_s=0.6) for k in (seed, seed + 10))
    return static_template(static.frames(0, 1), worn), walk


def without(seed, *absent):
    """A template, its pairs, stretches without some markers, and their true labels."""
    template, walk = known(seed)
    trial = walk.select([name for name in walk.names if name not in absent])
    truth = np.array([template.names.index(name) for name in trial.names])
    return template, PairScore.of_template(template), stretches_of(trial, template.size), truth


def turned(template, *names):
    """(L) labels of which these two change places."""
    a, b = (template.names.index(name) for name in names)
    turn = np.arange(len(template))
    turn[[a, b]] = b, a
    return turn


@pytest.mark.parametrize("seed", SEEDS)
def test_heel_and_toe_of_a_foot_without_its_ankle_are_put_right(seed):
    template, pairs, stretches, truth = without(seed, "LKNE", "LANK")
    found = _settled(stretches, turned(template, "LHEE", "LTOE")[truth], template, pairs, 0.3)
    assert (found == truth).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_a_body_turned_about_is_put_right_though_feet_lack_an_ankle_and_a_toe(seed):
    template, pairs, stretches, truth = without(seed, "LANK", "RTOE", "SACR")
    behind = turned(template, "RHEE", "RTOE")[mirrored(template.names)[truth]]
    found = decided_sides(stretches, behind, template, pairs)
    named = [template.names[a] for a, b in zip(found.label, truth, strict=True) if a != b]
    assert set(named) <= {"RTOE"}  # the one marker of a foot that has a heel or a toe
