"""What a person stated of a track is a fact of the search: it stands, and others are found by it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from labelling_shredded import shredded

from kinemark.label import label, learn_template
from kinemark.label.evidence import PairScore
from kinemark.label.key_frames import placings, search, settle
from kinemark.label.stated import fixed_labels
from kinemark.label.stretches import FREE, NO_MARKER, stretches_of
from kinemark.label.sweeps import outwards, sweep
from kinemark.synth import walking, with_markers


@cache
def walk(seed, n=15):
    return with_markers(walking(duration_s=2.0, rate=100.0, seed=seed, wobble_mm=1.0), n, seed=1).trajectories


def flat(seed):
    """A body without front or back and without heels and toes: all lies in one plane."""
    trial = walk(seed).select([n for n in walk(seed).names if n[1:] not in ("HEE", "TOE") and n != "SACR"])
    return replace(trial, paths=tuple(replace(path, xyz=path.xyz * [0.0, 1.0, 1.0]) for path in trial))


@pytest.mark.parametrize("side", ["L", "R"])
def test_one_stated_side_decides_all_of_them(side):
    """Without it nothing tells left from right, and no name with a side is sure."""
    trial, template = flat(7), learn_template(flat(1))
    plain = label(trial, template)
    assert plain.undecided is not None and "sure" not in plain.state
    other = {"L": "R", "R": "L"}[side] + "KNE"
    found = label(trial, template, stated={"LKNE": side + "KNE", "RKNE": other})
    turned = tuple({"L": "R", "R": "L"}[n[0]] + n[1:] for n in trial.names)
    assert found.undecided is None and found.names == (trial.names if side == "L" else turned)
    assert np.mean([state == "sure" for state in found.state]) > 0.7


def test_a_stated_name_stands_and_keeps_its_name_from_others():
    parts = shredded(walk(7), 3, 2.0, 3)
    ghost, real = parts.truth.index(None), parts.truth.index("LKNE")
    names = parts.tracks.names
    found = label(parts.tracks, learn_template(walk(1)), stated={names[ghost]: "RTOE", names[real]: None})
    assert found.names[ghost] == "RTOE" and found.state[ghost] == "sure" and found.names[real] is None
    seen = np.isfinite(parts.tracks.xyz[..., 0])
    assert not any(found.names[t] == "RTOE" and (seen[t] & seen[ghost]).any() for t in range(len(names)) if t != ghost)


def test_every_step_of_the_search_keeps_what_was_stated():
    trial, template = walk(7), learn_template(walk(1))
    pairs = PairScore.of_template(template)
    stated = {"LKNE": "RKNE", "LTOE": None, "RANK": "no marker of it"}
    fixed = fixed_labels(trial, template, stated)
    a, k = template.names.index("RKNE"), trial.names.index("LKNE")
    assert fixed[k] == a and sorted(fixed)[:2] == [NO_MARKER] * 2 and (fixed == FREE).sum() == 12
    stretches = stretches_of(trial, template.size, fixed)
    xyz = stretches.xyz[:, 0]
    for order in ([], [a]):
        turns = placings(pairs, template.handed, template.sign, order)
        point = settle(xyz, search(xyz, pairs, turns, 200, fixed), pairs, fixed)
        assert point[a] == k and not set(np.flatnonzero(fixed == NO_MARKER)) & set(point.tolist())
    labels = np.flatnonzero(point >= 0)
    first = outwards(stretches, 0, point[labels], labels, pairs)
    for done in (first, sweep(stretches, first, pairs, 0.3)):
        assert done[k] == a and (done == a).sum() == 1 and (done[fixed == NO_MARKER] == -1).all()
