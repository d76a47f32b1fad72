"""Ghosts beside the place of a marker, in its gap."""

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import label, learn_template
from kinemark.label.beside_its_place import beside_their_places
from kinemark.label.stretches import stretches_of
from kinemark.synth import walking, with_markers

GAP = (110, 140)
"""Frames in which the marker is not seen."""


def walk(seed):
    return with_markers(walking(duration_s=3.0, rate=100.0, seed=seed, wobble_mm=1.0), 39, seed=4).trajectories


@pytest.fixture(scope="module")
def template():
    return learn_template(walk(1))


def tracks(beside_mm, by_m=0.0, name="LTHI", apart=3):
    """A walk, so many metres off; one marker has a gap, in which a ghost, the last, goes with it so many mm beside."""
    trial, (first, stop) = walk(2), GAP
    own, frames = trial[name].xyz, np.arange(trial.n_frames)
    parts = [(path.xyz, frames >= 0) for path in trial if path.name != name]
    parts += [(own, frames < first), (own, frames >= stop)]
    parts += [(own + beside_mm * np.array([0.0, 0.8, 0.6]), (frames >= first + apart) & (frames < stop - apart))]
    paths = (np.where(seen[:, None], xyz + 1000.0 * by_m, np.nan) for xyz, seen in parts)
    return Trajectories(tuple(MarkerTrajectory.measured(f"*{k}", xyz) for k, xyz in enumerate(paths)), trial.rate)


@pytest.mark.parametrize("name", ["LTHI", "LTIB"])
def test_a_ghost_beside_its_place_has_no_sure_name(template, name):
    found = label(tracks(40.0, name=name), template)
    assert (found.names[-1], found.state[-1]) == (name, "unsure")
    assert set(found.state[:-1]) == {"sure"}


@pytest.mark.parametrize(("name", "beside_mm"), [("LTHI", 25.0), ("LTIB", 15.0), ("LANK", 15.0), ("LHEE", 15.0)])
def test_a_ghost_that_lies_where_its_marker_is_at_other_times_has_no_sure_name(template, name, beside_mm):
    found = label(tracks(beside_mm, name=name, apart=8), template)
    assert (found.names[-1], found.state[-1]) == (name, "unsure")
    assert set(found.state[:-1]) == {"sure"}


def test_a_piece_at_its_place_is_sure(template):
    found = label(tracks(0.0), template)
    assert (found.names[-1], found.state[-1]) == ("LTHI", "sure")


@pytest.mark.parametrize("by_m", [0.0, 20_000.0])
def test_only_the_ghost_is_beside_wherever_the_world_begins(template, by_m):
    some = tracks(40.0, by_m)
    own = np.array([template.names.index(name) for name in label(tracks(0.0), template).names])
    assert np.flatnonzero(beside_their_places(stretches_of(some, template.size), own, template)).tolist() == [
        len(some) - 1
    ]


def test_without_names_nothing_is_beside(template):
    some = tracks(40.0)
    none = np.full(len(some), -1)
    assert not beside_their_places(stretches_of(some, template.size), none, template).any()
