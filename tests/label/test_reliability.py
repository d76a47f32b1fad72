"""Whether stated probabilities are true, by labels of random shreds that `benchmarks/labelling_reliability.py` kept."""

import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

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


def test_each_bin_has_labels_of_many_shreds():
    bins = {one.low: one for one in benchmark().bins_of(kept())}
    assert all(bins[low].labels >= 25 and bins[low].shreds >= 15 for low in (0.5, 0.7, 0.9, 0.95, 0.99))
