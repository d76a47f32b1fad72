"""Markers told by height, side and front, whatever way the subject goes and wherever the laboratory is."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories
from kinemark.label import label_by_location
from kinemark.synth import walking


def walk(seed=0, speed=1100.0, phase=0.8, seconds=2.4):
    return walking(duration_s=seconds, rate=50.0, seed=seed, wobble_mm=3.0, speed_mm_s=speed, phase=phase).trajectories


def placed(trial, turn, by=(0.0, 0.0, 0.0)):
    """The trial turned, and carried away."""
    paths = tuple(replace(path, xyz=path.xyz @ turn.T + np.array(by)) for path in trial)
    return replace(trial, paths=paths)


def right(found, names):
    return sum(one.name == name for one, name in zip(found, names, strict=True))


@pytest.mark.parametrize("deg", [0, 90, 200])
def test_another_walk_names_all_that_stand_apart_in_any_direction(deg):
    shown, trial = walk(1, 900.0, 0.3), walk(2)
    turn = Rotation.from_euler("z", deg, degrees=True).as_matrix()
    found = label_by_location(placed(trial, turn, (3e5, -2e5, 400.0)), shown)
    assert right(found, trial.names) >= len(trial) - 2
    assert all(one.name == name for one, name in zip(found, trial.names, strict=True) if one.sure)
    sides = [one.name[0] == name[0] for one, name in zip(found, trial.names, strict=True) if name[0] in "LR"]
    assert all(sides)  # left is never right


def test_the_vertical_may_be_any_axis():
    shown, trial = walk(1, 900.0, 0.3), walk(2)
    turn = Rotation.from_euler("x", -90, degrees=True).as_matrix()  # z becomes y
    usual = label_by_location(trial, shown)
    over = label_by_location(placed(trial, turn), placed(shown, turn), up="y")
    assert [one.name for one in over] == [one.name for one in usual]
    with pytest.raises(ValueError, match="wanted x, y or z"):
        label_by_location(trial, shown, up="up")


def test_pieces_of_one_marker_may_both_have_its_name_and_ghosts_none():
    shown, trial = walk(1, 900.0, 0.3), walk(2)
    sacrum = trial["SACR"].xyz
    first, second = sacrum.copy(), sacrum.copy()
    first[60:], second[:62] = np.nan, np.nan
    ghost = np.tile([1200.0, 2500.0, 2300.0], (len(sacrum), 1))
    others = tuple(path for path in trial if path.name != "SACR")
    more = [MarkerTrajectory.measured(name, xyz) for name, xyz in (("*1", first), ("*2", second), ("*3", ghost))]
    found = label_by_location(Trajectories((*more, *others), trial.rate), shown)
    assert [one.name for one in found[:3]] == ["SACR", "SACR", None]


def test_who_stays_in_place_has_height_alone_and_nothing_is_nobody():
    shown = walk(1)
    still = replace(shown, paths=tuple(replace(p, xyz=np.repeat(p.xyz[:1], len(p), 0)) for p in shown))
    found = label_by_location(still, shown)
    sides = {one.name[0] for one in found if one.sure and one.name}
    assert not sides & set("LR")  # left and right are at one height
    empty = Trajectories((MarkerTrajectory.measured("A", np.full((9, 3), np.nan)),), 50.0)
    with pytest.raises(KinemarkError, match="no samples"):
        label_by_location(empty, shown)
