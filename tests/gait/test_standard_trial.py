"""A trial as the gait model wants it, whatever names, axes and marker sets its laboratory has."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, Origin, Trial
from kinemark.data.laboratory_axes import level_axes
from kinemark.data.model_markers import model_names, upper_body_names
from kinemark.gait import analyse_gait, marker_points, standard_trial, with_heels
from kinemark.synth import walking
from support.shift_gait import MEASURES, stepping

BTS = {
    "SACR": "sacrum", "LASI": "l asis", "RASI": "r asis", "LTHI": "l bar 1", "RTHI": "r bar 1", "LKNE": "l knee 1",
    "RKNE": "r knee 1", "LTIB": "l bar 2", "RTIB": "r bar 2", "LANK": "l mall", "RANK": "r mall", "LHEE": "l heel",
    "RHEE": "r heel", "LTOE": "l met", "RTOE": "r met",
}  # fmt: skip


def renamed(trial, names):
    paths = tuple(replace(p, name=names.get(p.name, p.name)) for p in trial.trajectories)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths))


def laid(trial, axes):
    """In a laboratory whose axes are the columns of `axes`."""
    paths = tuple(replace(p, xyz=p.xyz @ axes, cov=axes.T @ p.cov @ axes) for p in trial.trajectories)
    plates = tuple(replace(plate, corners=plate.corners @ axes) for plate in trial.plates)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths), plates=plates)


def without(trial, *names):
    kept = [n for n in trial.trajectories.names if n not in names]
    return replace(trial, trajectories=trial.trajectories.select(kept))


@pytest.mark.parametrize("change", [str, str.upper, lambda name: f"Anna:{name}", lambda name: name.replace(" ", "_")])
def test_names_of_other_laboratories_are_known(change):
    walk = renamed(stepping(), {ours: change(theirs) for ours, theirs in BTS.items()})
    found = standard_trial(walk)
    assert set(BTS) <= set(marker_points(found.trial))
    for name in BTS:
        np.testing.assert_array_equal(marker_points(found.trial)[name], marker_points(stepping())[name])


def test_the_wand_is_no_trochanter_and_stated_names_come_first():
    assert model_names(["r thigh", "r bar 1", "r knee 2", "r knee 1"])["RTHI"] == "r bar 1"
    assert model_names(["RHEE", "Mk19"], {"RHEE": "Mk19"})["RHEE"] == "Mk19"
    assert "LHEE" not in model_names(["RHEE"])
    with pytest.raises(KinemarkError, match="none of the gait model"):
        model_names(["a"], {"HEEL": "a"})
    with pytest.raises(KinemarkError, match="not in the trial"):
        model_names(["a"], {"RHEE": "b"})
    with pytest.raises(KinemarkError, match="two markers"):
        model_names(["a"], {"RHEE": "a", "LHEE": "a"})


@pytest.mark.parametrize("up", ["y", "-x"])
def test_angles_and_loads_are_those_of_a_laboratory_with_z_up(up):
    axis = (-1.0 if up[0] == "-" else 1.0) * np.eye(3)["xyz".index(up[-1])]
    walk = laid(stepping(), level_axes(axis).T)
    assert np.allclose(standard_trial(walk, up=up).turn, standard_trial(walk).turn)
    found, plain = (analyse_gait(standard_trial(t).trial, MEASURES).signals for t in (walk, stepping()))
    for signal in plain:
        if signal.kind == "angle":
            off = np.remainder(found[signal.name].values - signal.values + 180, 360) - 180
            if "Pelvis" in signal.name or "Progress" in signal.name:
                off = np.abs(off)  # the laboratory axis of progression may point the other way
                off = np.minimum(off, np.abs(180 - off))
            assert np.nanmax(np.abs(off)) < 1e-6, signal.name
        elif "GroundReaction" not in signal.name:
            np.testing.assert_allclose(found[signal.name].values, signal.values, atol=1e-6)


def test_a_laboratory_that_stands_askew_is_refused():
    c = np.sqrt(0.5)
    askew = np.array([[1.0, 0, 0], [0, c, -c], [0, c, c]])
    with pytest.raises(KinemarkError, match="no axis is up"):
        standard_trial(laid(stepping(), askew))
    assert standard_trial(laid(stepping(), askew), up="z").turn[2, 2] == 1


def test_a_trial_as_the_model_wants_it_is_left_alone():
    assert standard_trial(stepping()).trial.trajectories is stepping().trajectories


def test_heels_that_only_standing_wore_sit_on_the_feet():
    stood = Trial("stood", walking(duration_s=1.0, rate=100.0, seed=1, speed_mm_s=1.0).trajectories)
    walk = with_heels(standard_trial(without(stepping(), "LHEE", "RHEE")), marker_points(stood))
    assert walk.heels == ("LHEE", "RHEE")
    for name in walk.heels:
        found = next(p for p in walk.trial.trajectories if p.name == name)
        off = np.linalg.norm(found.xyz - marker_points(stepping())[name], axis=1)
        assert np.nanmedian(off) < 12.0 and (found.origin == Origin.FILLED).all()
    assert with_heels(standard_trial(stepping()), marker_points(stood)).heels == ()


@pytest.mark.filterwarnings("error")
def test_a_foot_that_is_never_seen_keeps_nobody_from_the_other_leg():
    walk = stepping()
    lost = tuple(
        replace(p, xyz=np.full_like(p.xyz, np.nan), origin=np.full_like(p.origin, Origin.MISSING))
        if p.name in ("LHEE", "LTOE") else p
        for p in walk.trajectories
    )  # fmt: skip
    found = analyse_gait(replace(walk, trajectories=replace(walk.trajectories, paths=lost)), MEASURES).loads
    whole = analyse_gait(walk, MEASURES).loads
    assert not np.isfinite(found["LAnkle"].moment).any()
    known = np.isfinite(found["RAnkle"].moment)  # not while somebody may stand on the plate
    assert known.any()
    np.testing.assert_array_equal(found["RAnkle"].moment[known], whole["RAnkle"].moment[known])


@pytest.mark.parametrize("change", [str.lower, lambda n: f"{n[0]}_{n[1:]}", lambda n: f"Anna:{n.title()}"])
def test_trunk_head_and_arms_are_known_in_small_letters_too(change):
    """They had no angles, and nothing said so."""
    names = ("LFHD", "CLAV", "STRN", "RSHO", "LWRA")
    assert upper_body_names([change(name) for name in names], ()) == {name: change(name) for name in names}
    assert upper_body_names([*names, "lfhd", "sho"], ()) == {}
