"""The marker that made an angle leap is found, whichever it is, wherever the click was."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories
from kinemark.engine.angles.spikes import NEAR, spike_cause
from kinemark.io.model_toml import load_model
from kinemark.kinematics import joint_angles, named_angles
from kinemark.synth.arm import arm

UM2AS = load_model("um2as")


def leaping(marker, at, *, seed, mm=60.0, wide=1, sd=0.3):
    """A feeding arm of which one marker leaps."""
    subject, rng = arm(duration_s=3.0, seed=seed), np.random.default_rng(seed)
    xyz = subject.xyz + sd * rng.normal(size=subject.xyz.shape)
    way = rng.normal(size=3)
    xyz[subject.names.index(marker), at : at + wide] += mm * way / np.linalg.norm(way)
    paths = tuple(MarkerTrajectory.measured(n, x) for n, x in zip(subject.names, xyz, strict=True))
    return Trajectories(paths, 50.0, 11)


def worst_angle(trajectories, at):
    """Joint and turn of the named angle that leaps most."""
    deg = joint_angles(trajectories, model=UM2AS).deg
    leap = np.abs(deg[:, at] - (deg[:, at - 4] + deg[:, at + 4]) / 2)
    return max(((one.joint, one.turn) for one in named_angles(UM2AS)), key=lambda place: leap[place])


@pytest.mark.parametrize("marker", UM2AS.markers)
@pytest.mark.parametrize("seed, wide", [(1, 1), (2, 3)])
def test_the_marker_is_found_from_a_click_beside(marker, seed, wide):
    """Checked with seeds 1 and 2; the click is up to NEAR frames off."""
    at = 60 + 7 * seed
    found = leaping(marker, at, seed=seed, wide=wide)
    joint, turn = worst_angle(found, at)
    for beside in (-NEAR, 0, NEAR):
        cause = spike_cause(found, model=UM2AS, joint=joint, turn=turn, index=at + beside)
        assert cause.marker == marker and at <= cause.at < at + wide
        assert cause.change_deg > 3 * max(change for _, change in cause.others)


def test_the_trials_own_names_are_said():
    """A file's numbers, which the model knows as aliases, after a subject's name."""
    found = leaping("WRU5", 70, seed=4)
    paths = tuple(replace(path, name=f"anna:{path.name}") for path in found)
    joint, turn = worst_angle(found, 70)
    cause = spike_cause(replace(found, paths=paths), model=UM2AS, joint=joint, turn=turn, index=70)
    assert cause.marker == "anna:WRU5"


def test_where_nothing_is_known_it_says_so():
    found = leaping("WRU5", 70, seed=5)
    gone = tuple(
        MarkerTrajectory.measured(path.name, np.full_like(path.xyz, np.nan)) if path.name == "ELB4" else path
        for path in found
    )
    with pytest.raises(KinemarkError, match="missing"):
        spike_cause(replace(found, paths=gone), model=UM2AS, joint=0, turn=0, index=70)
    for wrong in ({"joint": 9}, {"turn": 3}, {"index": 10_000}, {"index": -1}):
        with pytest.raises(KinemarkError, match="no angle"):
            spike_cause(found, model=UM2AS, **({"joint": 0, "turn": 0, "index": 70} | wrong))
