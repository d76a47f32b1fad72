"""Whether stated probabilities are true, by labels of random shreds that `benchmarks/labelling_reliability.py` kept."""

import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from labelling_shredded import Shredded

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import Labels
from kinemark.label.margin import Margins

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
ERRORS = 2.0
"""Standard errors by which a bin may differ besides `OFF`."""
OFF = 0.02
"""By which what is stated may differ in a bin from what is right."""
MOST_WRONG = 0.002
"""Share of the sure labels that may be wrong."""


@cache
def benchmark():
    sys.path.insert(0, str(BENCHMARKS))
    try:
        import labelling_reliability
    finally:
        sys.path.remove(str(BENCHMARKS))
    return labelling_reliability


@cache
def kept():
    return benchmark().kept_labels()


def untrue(labels):
    """The bins above one half in which what is stated is not what is right."""
    bins = [one for one in benchmark().bins_of(labels) if one.low >= 0.5]
    return [one for one in bins if abs(one.right - one.p) > OFF + ERRORS * one.error]


def stated(move):
    """The labels with another probability of each."""
    logit = np.log(np.clip(kept().p, 1e-9, 1 - 1e-9)) - np.log1p(-np.clip(kept().p, 1e-9, 1 - 1e-9))
    return kept()._replace(p=1 / (1 + np.exp(-move(logit))))


def test_names_are_right_as_often_as_their_probabilities_say():
    assert not untrue(kept())
    wrong, sure = benchmark().sure_wrong(kept())
    assert sure > 3000 and wrong <= MOST_WRONG * sure


@pytest.mark.parametrize("move", [lambda x: x + 2.0, lambda x: x - 2.0], ids=["too sure", "not sure enough"])
def test_probabilities_that_lie_are_seen(move):
    labels = stated(move)
    wrong, sure = benchmark().sure_wrong(labels)
    assert untrue(labels) or wrong > MOST_WRONG * sure


def test_of_the_sure_labels_of_a_shred_some_are_kept_and_count_for_as_many_as_there_are():
    """One of 20 counted for 20 also where there were five."""
    shred = benchmark()
    names = tuple(f"M{k:02}" for k in range(27))
    paths = tuple(MarkerTrajectory.measured(f"*{k}", np.zeros((3, 3))) for k in range(27))
    p = np.where(np.arange(27) < 25, 0.999, 0.9)
    found = Labels(names, p, ("sure",) * 27, (None,) * 27, np.ones(27), 1.0, 1.0)
    tracks = tuple(path.name for path in paths)
    about = Margins(*(np.ones(27) for _ in Margins._fields))
    known = shred.Known(tracks, names, p, about, np.ones(27), 0.0, False)
    parts = Shredded(Trajectories(paths, 100.0), names)
    lines = list(shred.lines_of("own:1", "row", names, found, parts, [known]))
    counts = [int(line[shred.FIRST.index("counts")]) for line in lines]
    assert sorted(counts) == [1, 1, 5, 20] and all(len(line) == len(shred.FIRST) + len(about) for line in lines)


def test_each_bin_has_labels_of_many_shreds():
    bins = {one.low: one for one in benchmark().bins_of(kept())}
    assert all(bins[low].labels >= 25 and bins[low].shreds >= 15 for low in (0.5, 0.7, 0.9, 0.95, 0.99))
