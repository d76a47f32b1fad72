"""Runs of pieces in which two or three markers have each other's names."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import label, learn_template, solve
from kinemark.label.evidence import PairScore
from kinemark.label.exchange import Exchanger
from kinemark.label.runs import runs_put_right
from kinemark.label.stretches import stretches_of
from kinemark.synth import walking

TWO = ("LANK", "LHEE")
THREE = ("LANK", "LHEE", "LTOE")
SHANK = ("LHEE", "LTIB", "LTOE")
"""These no exchange of two puts right, nor two such."""


@pytest.fixture(scope="module")
def shreds():
    """Stretches, right labels (T), and the exchanger; all markers are cut at frames 30 and 60, and elsewhere."""
    template = learn_template(walking(duration_s=2.0, rate=50.0, seed=1, wobble_mm=1.0).trajectories)
    walk = walking(duration_s=2.0, rate=50.0, seed=2, wobble_mm=1.0).trajectories
    rng, paths, truth = np.random.default_rng(3), [], []
    for path in walk:
        ends = [0, *sorted({30, 60, *rng.choice(np.arange(1, 100), 12).tolist()}), walk.n_frames]
        for first, stop in pairwise(ends):
            xyz = np.full_like(path.xyz, np.nan)
            xyz[first:stop] = path.xyz[first:stop]
            paths.append(MarkerTrajectory.measured(f"*{len(paths)}", xyz))
            truth.append(template.names.index(path.name))
    stretches = stretches_of(Trajectories(tuple(paths), walk.rate), template.size)
    return stretches, np.array(truth), template, Exchanger.of(template, PairScore.of_template(template))


def exchanged(stretches, truth, template, first, stop):
    a, b = (template.names.index(name) for name in TWO)
    run = (stretches.start >= first) & (stretches.stop <= stop) & np.isin(truth, (a, b))
    return np.where(run, a + b - truth, truth), run


@pytest.mark.parametrize(("first", "stop"), [(30, 60), (0, 30), (60, 101)])
def test_a_run_of_exchanged_pieces_is_put_right(shreds, first, stop):
    stretches, truth, template, exchanger = shreds
    label, run = exchanged(stretches, truth, template, first, stop)
    assert run.sum() > 2 and (runs_put_right(stretches, label, exchanger) == truth).all()


@pytest.mark.parametrize("way", [THREE, THREE[::-1], SHANK, SHANK[::-1]])
@pytest.mark.parametrize(("first", "stop"), [(30, 60), (60, 101)])
def test_a_run_of_three_that_have_each_others_names_is_put_right(shreds, first, stop, way):
    stretches, truth, template, exchanger = shreds
    a, b, c = (template.names.index(name) for name in way)
    new = np.arange(len(template))
    new[[a, b, c]] = b, c, a
    run = (stretches.start >= first) & (stretches.stop <= stop)
    label = np.where(run, new[truth], truth)
    assert (label != truth).sum() > 3 and (runs_put_right(stretches, label, exchanger) == truth).all()


def test_what_is_named_has_its_runs_put_right(shreds, monkeypatch):
    """Seen by what comes of it if all of them lose their names there."""
    walk, template = walking(duration_s=2.0, rate=50.0, seed=2, wobble_mm=1.0).trajectories, shreds[2]
    assert label(walk, template).names == walk.names
    monkeypatch.setattr(solve, "runs_put_right", lambda _, names, __: np.full_like(names, -1))
    assert set(label(walk, template).names) == {None}


def test_right_names_stay_and_so_does_what_was_stated(shreds):
    stretches, truth, template, exchanger = shreds
    assert (runs_put_right(stretches, truth, exchanger) == truth).all()
    label, run = exchanged(stretches, truth, template, 30, 60)
    stated = replace(stretches, fixed=np.where(run, label, stretches.fixed))
    assert (runs_put_right(stated, label, exchanger) == label).all()
