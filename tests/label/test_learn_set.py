"""A labelled trial shows its marker set: segments, links, left and right, whatever the unit and the names."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories
from kinemark.io.marker_sets import read_marker_set
from kinemark.label import learn_marker_set, sides_by_name
from kinemark.label.side_pairs import mirror_partners, sides_by_shape
from kinemark.synth import walking
from support.wearing import body_of, moving, standing

LEGS = {
    frozenset(f"{side}{marker}" for marker in markers.split())
    for side in "LR"
    for markers in ("THI KNE", "KNE TIB ANK", "ANK HEE TOE")
} | {frozenset({"SACR", "LASI", "RASI"})}


def segments(found):
    return {frozenset(markers) for markers in found.segments.values()}


def renamed(trial, new):
    return replace(trial, paths=tuple(replace(path, name=new(path.name)) for path in trial))


@pytest.mark.parametrize(("seed", "wobble"), [(1, 0.0), (2, 1.0), (3, 2.0), (4, 2.0)])
def test_a_walk_shows_the_segments_that_made_it(seed, wobble):
    found = learn_marker_set(walking(duration_s=3.0, rate=100.0, seed=seed, wobble_mm=wobble).trajectories)
    assert segments(found) == LEGS
    assert len(found.pairs) == 7 and all(left[0] == "L" and right[0] == "R" for left, right in found.pairs)
    assert {joint for two in found.joints.values() for joint in two} == set(found.segments)
    assert max(found.rigidity.values()) <= 0.03


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_whole_body_that_moves_shows_its_segments(seed):
    worn = read_marker_set("plug-in-gait-full")
    trial = moving(worn, body_of(worn, seed), seed, duration_s=5.0, wobble=1.0)
    found = learn_marker_set(trial)
    true, core = segments(worn), [set(s) for s in segments(found)]
    assert all(any(len(group & set(s)) >= 0.6 * len(s) for group in core) for s in true)
    assert all(any(group <= set(a) | set(b) for a in true for b in true) for group in core)
    for (a, b), length in zip(found.links.tolist(), found.length, strict=True):
        d = np.linalg.norm(trial[found.names[a]].xyz - trial[found.names[b]].xyz, axis=1)
        assert length == pytest.approx(d.mean(), abs=1e-6)


@pytest.mark.parametrize("factor", [0.001, 0.1, 1 / 25.4])
def test_the_unit_does_not_matter(factor):
    trial = walking(duration_s=3.0, rate=100.0, seed=2, wobble_mm=1.0).trajectories
    small = replace(trial, paths=tuple(replace(path, xyz=factor * path.xyz) for path in trial))
    one, other = learn_marker_set(trial), learn_marker_set(small)
    assert segments(one) == segments(other) and one.pairs == other.pairs and dict(one.places) == dict(other.places)
    np.testing.assert_allclose(factor * one.length, other.length)


def test_an_object_that_turns_is_one_segment():
    """A drone or a plate: all distances stay as they are, and it moves."""
    x, y, z = np.random.default_rng(0).uniform(-100, 100, (3, 5, 1))
    turn = np.linspace(0, 1.0, 60)
    xyz = np.stack([x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn), z + 0 * turn], -1)
    paths = tuple(MarkerTrajectory.measured(name, path) for name, path in zip("ABCDE", xyz, strict=True))
    assert segments(learn_marker_set(Trajectories(paths, 100.0))) == {frozenset("ABCDE")}


def test_a_trial_without_motion_is_refused():
    worn = read_marker_set("kiss-15")
    with pytest.raises(KinemarkError, match="hardly any motion"):
        learn_marker_set(standing(worn, body_of(worn, 1), n_frames=50))
    with pytest.raises(KinemarkError, match="three or more"):
        learn_marker_set(walking(duration_s=1.0).trajectories.select(["LASI", "RASI"]))


def test_gaps_and_markers_that_are_never_together():
    trial = walking(duration_s=3.0, rate=100.0, seed=2, wobble_mm=1.0).trajectories
    xyz = trial["LTOE"].xyz.copy()
    xyz[:200] = np.nan
    other = trial["RTOE"].xyz.copy()
    other[200:] = np.nan
    new = {"LTOE": xyz, "RTOE": other}
    paths = tuple(MarkerTrajectory.measured(p.name, new.get(p.name, p.xyz)) for p in trial)
    found = learn_marker_set(replace(trial, paths=paths))
    assert not any({"LTOE", "RTOE"} <= set(markers) for markers in found.segments.values())
    assert segments(found) == LEGS


SPELLINGS = [
    ("LASI", "RASI"), ("L_IAS", "R_IAS"), ("L.Heel", "R.Heel"), ("l knee 1", "r knee 1"), ("Anna:LTHI", "Anna:RTHI"),
    ("ASISl", "ASISr"), ("WheelL", "WheelR"), ("ScapulaL1", "ScapulaR1"), ("Left Ankle", "Right Ankle"),
    ("left_wrist", "right_wrist"), ("knee_L", "knee_R"), ("Skeleton_LHand1", "Skeleton_RHand1"), ("Lasi", "Rasi"),
    ("LFLL", "RFLL"), ("heelLeft", "heelRight"), ("lhee", "rhee"), ("WaistLFront", "WaistRFront"), ("PVUL", "PVUR"),
    ("ASIS.L.1", "ASIS.R.1"),
]  # fmt: skip


@pytest.mark.parametrize(("left", "right"), SPELLINGS)
def test_names_say_left_and_right(left, right):
    assert sides_by_name([right, "C7", left, "SACR", "LONE"]) == ((left, right),)


def test_no_name_is_in_two_pairs():
    names = [name for pair in SPELLINGS for name in pair] + ["LL", "RL", "LR", "RR"]
    pairs = sides_by_name(names)
    used = [name for pair in pairs for name in pair]
    assert len(set(used)) == len(used) and set(SPELLINGS) <= set(pairs)


def test_a_symmetric_body_that_walks_shows_its_sides_without_names():
    trial = walking(duration_s=3.0, rate=100.0, seed=2, wobble_mm=1.0).trajectories
    bare = renamed(trial, lambda name: f"M{trial.names.index(name)}")
    found = learn_marker_set(bare)
    at = trial.names.index
    wanted = {(f"M{at('L' + name)}", f"M{at('R' + name)}") for name in ("ASI", "KNE", "ANK", "HEE", "TOE")}
    assert wanted <= set(found.pairs) and len(found.pairs) == 7
    xyz = trial.xyz
    mean = np.array([[np.linalg.norm(a - b, axis=1).mean() for b in xyz] for a in xyz])
    partner = mirror_partners(mean)
    assert [partner[partner[k]] for k in range(15) if partner[k] >= 0] == [k for k in range(15) if partner[k] >= 0]
    standing_still = xyz - xyz.mean(0)
    assert sides_by_shape(trial.names, mean, standing_still) == ()
    rng = np.random.default_rng(1).normal(size=(15, 3)) * 400
    assert mirror_partners(np.linalg.norm(rng[:, None] - rng[None], axis=-1)) is None
