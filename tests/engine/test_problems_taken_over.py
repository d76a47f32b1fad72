"""A path that takes over another's samples leaves an end and a beginning, which are no two pieces of one marker."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.problems import problems
from support.walked import clean, every, nearest, walk, with_xyz


def taken_over(p, k, at):
    """From a frame on path p has the samples of the marker next to it, whose own path ends, and its own are a track
    without a name; one frame of k."""
    trial = every(clean(), k)
    q = nearest(walk()[1], p, at * k)
    mine, its, rest = (trial.paths[one].xyz.copy() for one in (p, q, p))
    rest[:at] = np.nan
    mine[at:], its[at:] = its[at:].copy(), np.nan
    trial = with_xyz(trial, {p: mine, q: its})
    return replace(trial, paths=(*trial.paths, MarkerTrajectory.measured("*1", rest))), trial.names[p], trial.names[q]


@pytest.mark.parametrize("p", [0, 3, 6])
def test_the_end_of_a_path_that_was_taken_over_is_not_joined_to_what_was_left(tmp_path, p):
    trial, mine, its = taken_over(p, 4, 50)
    found = problems(Editing("walk", Journal.of(tmp_path, "walk"), trial), one_by_one=True).items
    assert any(one.kind == "swap" and mine in one.tracks and one.wrong > 0.5 for one in found)
    assert not any(one.kind == "join" and one.tracks == (its, "*1") for one in found)
