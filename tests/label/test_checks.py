"""Names that are wrong are found where they are, and nothing else: swapped sides, stretches of another marker."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory
from kinemark.io.marker_sets import read_marker_set
from kinemark.label import find_exchanges, find_mislabelled, find_side_swaps, learn_template
from kinemark.label.exchange import Exchanger
from support.tools import tools
from support.wearing import body_of, moving

SET = read_marker_set("plug-in-gait-full")
LEG = tuple(pair for pair in SET.pairs if pair[0][1:] in ["THI", "KNE", "TIB", "ANK", "HEE", "TOE"])
ARM = tuple(pair for pair in SET.pairs if pair[0][1:] in ["UPA", "ELB", "FRM", "WRA", "WRB", "FIN"])


@cache
def subject(seed):
    body = body_of(SET, seed)
    return learn_template(moving(SET, body, seed + 50)), moving(SET, body, seed)


def changed(trial, new):
    return replace(trial, paths=tuple(MarkerTrajectory.measured(p.name, new.get(p.name, p.xyz)) for p in trial))


def swapped(trial, pairs, first, stop):
    new = {name: trial[name].xyz.copy() for pair in pairs for name in pair}
    for left, right in pairs:
        new[left][first:stop], new[right][first:stop] = trial[right].xyz[first:stop], trial[left].xyz[first:stop]
    return changed(trial, new)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_right_names_are_left_in_peace(seed):
    template, trial = subject(seed)
    assert find_side_swaps(trial, template, SET.pairs) == () and find_mislabelled(trial, template) == ()


@pytest.mark.parametrize("pairs", [LEG, ARM, SET.pairs], ids=["legs", "arms", "body"])
@pytest.mark.parametrize(("first", "stop"), [(0, 300), (100, 250)])
@pytest.mark.parametrize("seed", [1, 5])
def test_swapped_sides_are_found_with_their_frames(pairs, first, stop, seed):
    template, trial = subject(seed)
    found = find_side_swaps(swapped(trial, pairs, first, stop), template, SET.pairs)
    assert len(found) == 1 and set(pairs) - set(found[0].pairs) == set() and len(found[0].pairs) <= len(pairs) + 1
    assert abs(found[0].first - first) < 10 and abs(found[0].stop - stop) < 10 and found[0].gain > 50
    assert found[0].off_swapped_mm < found[0].off_mm


@pytest.mark.parametrize(("first", "stop"), [(113, 241), (0, 77), (190, 300)])
@pytest.mark.parametrize("seed", [1, 5])
def test_wrong_names_are_found_to_the_frame(first, stop, seed):
    """They began and ended where half a second did, as long as that was looked at as a whole."""
    template, trial = subject(seed)
    (sides,) = find_side_swaps(swapped(trial, LEG, first, stop), template, SET.pairs)
    (two,) = find_exchanges(swapped(trial, [("LTHI", "LKNE")], first, stop), template)
    assert (sides.first, sides.stop) == (first, stop) == (two.first, two.stop)


@pytest.mark.parametrize(("name", "seed"), [("LBHD", 1), ("LBHD", 2), ("LBHD", 5), ("LWRA", 1), ("LWRA", 5)])
def test_one_pair_is_not_said_to_be_a_limb(name, seed):
    template, trial = subject(seed)
    pair = next(two for two in SET.pairs if name in two)
    found = find_side_swaps(swapped(trial, [pair], 113, 241), template, SET.pairs)
    assert [one.pairs for one in found] == [(pair,)]


@pytest.mark.parametrize("seed", [2, 3, 6])
def test_a_marker_called_by_a_free_name_is_found_with_its_own(seed):
    template, trial = subject(seed)
    xyz = trial["LWRA"].xyz.copy()
    xyz[100:250] = trial["LTOE"].xyz[100:250]
    bad = changed(trial, {"LWRA": xyz}).select([name for name in SET.names if name != "LTOE"])
    found = find_mislabelled(bad, template)
    assert [one.marker for one in found] == ["LWRA"] and found[0].instead == "LTOE"
    assert abs(found[0].first - 100) < 10 and abs(found[0].stop - 250) < 10
    assert found[0].off_mm > 100 and found[0].evidence < 0 < found[0].expected


def test_a_ghost_with_a_name_is_found_and_fits_none():
    template, trial = subject(4)
    xyz = trial["RFHD"].xyz.copy()
    xyz[150:] += np.array([0.0, 0.0, 250.0])
    found = find_mislabelled(changed(trial, {"RFHD": xyz}), template)
    assert [(one.marker, one.instead) for one in found] == [("RFHD", None)] and abs(found[0].first - 150) < 10
    besides = {"RFHD": np.arange(300)}
    assert find_mislabelled(changed(trial, {"RFHD": xyz}), template, besides=besides) == ()


def test_too_little_to_judge_by_is_no_error():
    template, trial = subject(4)
    assert find_mislabelled(trial.select(["LASI", "RASI"]), template) == ()
    assert find_side_swaps(trial.select(["LASI", "RASI", "C7"]), template, SET.pairs) == ()


@pytest.mark.parametrize("shape", [1, 2, 4])
def test_tools_that_stand_otherwise_to_each_other_are_not_exchanged_and_two_that_are_come_alone(shape):
    template, trial = learn_template(tools(shape, 1)), tools(shape, 2)
    assert find_exchanges(trial, template) == ()
    a, b = trial["B1"].xyz.copy(), trial["B2"].xyz.copy()
    a[80:], b[80:] = trial["B2"].xyz[80:], trial["B1"].xyz[80:]
    found = find_exchanges(changed(trial, {"B1": a, "B2": b}), template)
    assert {one.markers for one in found} == {("B1", "B2")} and found[-1].stop > 190


@pytest.mark.parametrize("seed", [1, 5])
def test_exchanges_that_are_not_looked_at_could_not_have_gained(seed, monkeypatch):
    template, trial = subject(seed)
    near = {"RFHD": trial["LFHD"].xyz, "LFHD": trial["RFHD"].xyz, "LTOE": trial["LHEE"].xyz, "LHEE": trial["LTOE"].xyz}
    wrong = changed(swapped(trial, LEG[:2], 100, 200), near)
    looked, real = [0, 0], Exchanger.may_gain

    def counted(self, y, moves):
        may = real(self, y, moves)
        looked[0] += int(may.sum())
        looked[1] += len(may)
        assert may[self.gains(y, moves) > 0].all()
        return may

    monkeypatch.setattr(Exchanger, "may_gain", counted)
    assert find_exchanges(trial, template) == () and looked[0] < looked[1] / 2
    found = find_exchanges(wrong, template)
    assert len(found) >= 2
    monkeypatch.setattr(Exchanger, "may_gain", lambda self, y, moves: np.ones(len(moves), bool))
    assert find_exchanges(wrong, template) == found
