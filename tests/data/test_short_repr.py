"""What an interpreter shows of a trial fits on a screen."""

from dataclasses import dataclass

import numpy as np
import pytest

from kinemark.data.short_repr import ShortRepr
from kinemark.io.trial import read_trial, write_trial
from support.trials import made_trial


@dataclass(repr=False)
class Anything(ShortRepr):
    """Data with one field."""

    x: object


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (np.zeros((100, 3)), "<float64 (100, 3)>"),
        (np.zeros((7, 0)), "<float64 (7, 0)>"),
        (np.array([1, 2]), "[1, 2]"),
        (np.zeros(0), "[]"),
        (b"0" * 200, "<200 bytes>"),
        ("a" * 200, "'" + "a" * 79 + "…"),
        (list("abcdef"), "<6 str: 'a', 'b', 'c', 'd', …>"),
        ((np.zeros((100, 3)),), "(<float64 (100, 3)>,)"),
        ({"a": np.zeros(99)}, "{'a': <float64 (99,)>}"),
        (Anything(1.5), "Anything(x=1.5)"),
    ],
)
def test_it_says_what_is_there_and_how_much(value, shown):
    assert repr(Anything(value)) == f"Anything(x={shown})"


def test_a_trial_and_its_parts_fit_on_a_screen(tmp_path):
    write_trial(made_trial(), tmp_path / "walk.c3d")
    trial = read_trial(tmp_path / "walk.c3d")
    assert trial.name in repr(trial)
    for part in (trial, trial.trajectories, trial.trajectories.paths[0], trial.signals, trial.events):
        assert len(repr(part)) < 1500, type(part)
