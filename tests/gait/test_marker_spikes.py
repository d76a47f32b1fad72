"""Samples that stand off their path for a frame or a few are left out, and the angles are those of the clean walk."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Origin
from kinemark.gait import analyse_gait, marker_points, with_static_offsets
from kinemark.gait.marker_spikes import MarkerSpikes, without_spikes
from kinemark.synth import WalkingBody, gait_laboratory
from support.shift_gait import MEASURES

AT = 130


@cache
def lab(rate):
    return gait_laboratory(WalkingBody(MEASURES), duration_s=2.6, rate=rate, noise_mm=0.3, seed=4)


def with_samples(trial, **moved):
    """The trial with markers (F, 3) mm of these names."""
    paths = tuple(MarkerTrajectory.measured(p.name, moved.get(p.name, p.xyz)) for p in trial.trajectories)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths))


def off(walk, name, mm, first, frames):
    xyz = walk.trajectories[name].xyz.copy()
    xyz[first : first + frames] += mm
    return with_samples(walk, **{name: xyz})


def knee(trial):
    measures = with_static_offsets(MEASURES, marker_points(lab(100.0).static), flat_foot=True)
    return analyse_gait(trial, measures).signals["LKneeAngles"].values


def test_a_clean_walk_is_the_same_trial():
    for rate in (50.0, 100.0):
        walk = lab(rate).walk
        assert without_spikes(walk) == (walk, MarkerSpikes())


@pytest.mark.parametrize("frames", [1, 3, 5])
@pytest.mark.parametrize("mm", [(0, 0, 30.0), (25.0, 20.0, 0), (0, 300.0, 0)])
def test_angles_are_those_without_the_spike(mm, frames):
    walk = lab(100.0).walk
    bent = off(walk, "LKNE", mm, AT, frames)
    mended, told = without_spikes(bent)
    assert told.markers == ("LKNE",) and told.frames == ((AT, AT + frames - 1),)
    assert told.samples == frames and told.most_mm == pytest.approx(np.linalg.norm(mm), abs=3.0)
    assert (mended.trajectories["LKNE"].origin[AT : AT + frames] == Origin.FILLED).all()
    wrong, right = (np.abs(knee(one) - knee(walk)).max() for one in (bent, mended))
    assert right < min(0.6, wrong / 8)


def test_markers_exchanged_for_a_frame_are_both_left_out():
    walk = lab(50.0).walk
    a, b = (walk.trajectories[name].xyz.copy() for name in ("RTIB", "RANK"))
    a[60], b[60] = b[60].copy(), a[60].copy()
    mended, told = without_spikes(with_samples(walk, RTIB=a, RANK=b))
    assert set(told.markers) == {"RTIB", "RANK"} and told.frames == ((60, 60),) and told.samples == 2
    for name in told.markers:
        assert np.linalg.norm(mended.trajectories[name].xyz[60] - walk.trajectories[name].xyz[60]) < 3.0


def test_a_long_stretch_stays_as_it_is():
    walk = off(lab(100.0).walk, "RANK", (0, 80.0, 0), AT, 10)
    assert without_spikes(walk) == (walk, MarkerSpikes())


def test_the_path_says_how_well_it_is_known_where_samples_do():
    walk = off(lab(100.0).walk, "RANK", (0, 80.0, 0), AT, 2)
    cov = np.broadcast_to(0.25 * np.eye(3), (walk.trajectories.n_frames, 3, 3))
    paths = tuple(replace(p, cov=cov) if p.name == "RANK" else p for p in walk.trajectories)
    mended, _ = without_spikes(replace(walk, trajectories=replace(walk.trajectories, paths=paths)))
    assert np.isfinite(mended.trajectories["RANK"].cov).all()
    assert np.isnan(mended.trajectories["LANK"].cov).all()


def with_gap(trial, name, first, frames):
    keep = ~np.isin(np.arange(trial.trajectories.n_frames), np.arange(first, first + frames))
    paths = tuple(p.only(keep) if p.name == name else p for p in trial.trajectories)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths))


@pytest.mark.parametrize("frames", [1, 2, 4])
@pytest.mark.parametrize("beside", ["first", "last", "before", "after"])
def test_samples_beside_a_gap_and_at_the_ends_are_left_out(beside, frames):
    clean = lab(100.0).walk
    n = clean.trajectories.n_frames
    first = {"first": 0, "last": n - frames, "before": AT - frames, "after": AT + 20}[beside]
    inside = beside in ("before", "after")
    right = with_gap(clean, "LKNE", AT, 20) if inside else clean
    wrong = off(clean, "LKNE", (40.0, 30.0, 0), first, frames)
    wrong = with_gap(wrong, "LKNE", AT, 20) if inside else wrong
    mended, told = without_spikes(wrong)
    assert told.markers == ("LKNE",) and told.frames == ((first, first + frames - 1),) and told.samples == frames
    assert told.most_mm > 40
    known = np.isfinite(mended.trajectories["LKNE"].xyz).all(1)
    assert (np.isfinite(right.trajectories["LKNE"].xyz).all(1) & ~known).sum() == frames
    np.testing.assert_array_equal(mended.trajectories["LKNE"].xyz[known], right.trajectories["LKNE"].xyz[known])
    bent, better = (np.nanmax(np.abs(knee(one) - knee(right))) for one in (wrong, mended))
    assert better < max(0.5, bent / 4)
