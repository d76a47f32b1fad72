"""What is different between two versions of a trial."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.edit import Changed, Renamed, difference
from kinemark.edit.values import without
from support.walked import clean, exchanged, with_xyz


def test_a_version_does_not_differ_from_itself():
    trial = clean()
    assert not difference(trial, trial)
    assert not difference(trial, exchanged(exchanged(trial, 0, 1, 50), 0, 1, 50)), "there and back, in new records"


def test_an_exchange_is_two_names_and_no_changed_sample():
    trial = clean()
    a, b = trial.names[2], trial.names[5]
    found = difference(trial, exchanged(trial, 2, 5, 100, 130))
    assert set(found.renamed) == {Renamed(a, b, 101, 130, 30), Renamed(b, a, 101, 130, 30)} and not found.changed


def test_erased_added_and_moved_samples_are_told_apart_with_their_frames_and_distance():
    trial = clean()
    gone = np.zeros(trial.n_frames, bool)
    gone[10:20] = True
    less = replace(trial, paths=(without(trial.paths[0], gone), *trial.paths[1:]))
    name = trial.names[0]
    assert difference(trial, less).changed == (Changed(name, "erased", 11, 20, 10, pytest.approx(np.nan, nan_ok=True)),)
    assert difference(less, trial).changed[0][:5] == (name, "added", 11, 20, 10)
    xyz = trial.paths[3].xyz.copy()
    xyz[40:43] += [3.0, 4.0, 0.0]
    moved = difference(trial, with_xyz(trial, {3: xyz})).changed
    assert [one[:5] for one in moved] == [(trial.names[3], "moved", 41, 43, 3)] and abs(moved[0].max_mm - 5) < 1e-6


def test_a_trimmed_version_has_fewer_frames_and_the_same_names():
    trial = clean()
    found = difference(trial, trial.frames(20, 300))
    assert not found.renamed and {one.what for one in found.changed} == {"erased"}
    assert {(one.first, one.last) for one in found.changed} == {(1, 20), (301, trial.n_frames)}
