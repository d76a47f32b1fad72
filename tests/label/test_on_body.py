"""Chains of ghosts are no markers without a name; markers that nobody named are."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from labelling_shredded import shredded

from kinemark.data import MarkerTrajectory
from kinemark.label import learn_template
from kinemark.label.arrange import markers_of
from kinemark.label.claims import left_over
from kinemark.label.on_body import on_body
from kinemark.label.stretches import stretches_of
from kinemark.synth import walking, with_markers


@cache
def walk():
    return with_markers(walking(duration_s=2.0, rate=100.0, seed=7, wobble_mm=1.0), 39, seed=1).trajectories


def left(*extra, without=()):
    """What is left over where tracks (F, 3) without a name are there besides, and some markers have none."""
    tracks = tuple(MarkerTrajectory.measured(f"+{k}", xyz) for k, xyz in enumerate(extra))
    trial = replace(walk(), paths=(*walk(), *tracks))
    label = np.r_[np.arange(39), np.full(len(tracks), -1)]
    label[list(without)] = -1
    return left_over(stretches_of(trial, learn_template(walk()).size), label, 39)[1]


def ghost(seed, first, stop, step=3.0):
    """(F, 3) a point that wanders near the body in these frames."""
    rng, xyz = np.random.default_rng(seed), walk().xyz
    out = np.full((walk().n_frames, 3), np.nan)
    middle = np.nanmean(xyz[:, first], 0)
    out[first:stop] = middle + rng.normal(0, 200, 3) + np.cumsum(rng.normal(0, step, (stop - first, 3)), 0)
    return out


def beside(a, b, c):
    """(F, 3) a marker on the segment of three."""
    xyz = walk().xyz
    return xyz[a] + 0.4 * (xyz[b] - xyz[a]) + 0.3 * (xyz[c] - xyz[a])


@pytest.mark.parametrize("seed", range(5))
def test_a_ghost_that_is_seen_for_long_is_no_marker_whether_it_wanders_or_stands_still(seed):
    assert left(ghost(seed, 20, 180)) == 0
    assert left(ghost(seed, 20, 180, step=0.0)) == 0


def test_a_point_midway_between_two_limbs_is_no_marker():
    names = walk().names
    hand, foot = names.index("LKNE"), names.index("RHEE")
    assert left(0.5 * (walk().xyz[hand] + walk().xyz[foot])) == 0


@pytest.mark.parametrize("a", range(0, 39, 6))
def test_a_marker_that_nobody_named_is_left_over(a):
    assert left(without=[a]) == 1
    apart = np.nanmean(np.linalg.norm(walk().xyz - walk().xyz[a], axis=2), 1)
    assert left(beside(*np.argsort(apart)[:3])) == 1


@pytest.mark.parametrize(("n", "extra", "seed"), [(15, 0, 1), (15, 2, 1), (15, 1, 3), (39, 0, 3), (39, 2, 3)])
@pytest.mark.parametrize("pieces", [15, 25])
def test_a_nameless_marker_is_one_however_many_pieces_it_is_in(n, extra, seed, pieces):
    """A piece goes on into the next, and as well into the one after that; ghosts are beside. One counted as up to two
    of two, and of other children's walks in 25 and 40 pieces none was seen."""
    trial = with_markers(walking(duration_s=3.0, rate=100.0, seed=7, wobble_mm=1.0), n, seed=1).trajectories
    parts = shredded(trial, pieces, 2.0, seed, extra=extra)
    label = np.array([trial.names.index(name) if name in trial.names else -1 for name in parts.truth])
    assert left_over(stretches_of(parts.tracks, learn_template(trial).size), label, n) == (0, extra)


def test_ghosts_one_after_the_other_are_no_chain_where_nothing_says_that_the_one_goes_on_as_the_other():
    """Each is seen in a quarter of the frames, with a gap between them over which a marker could be anywhere."""
    one, two = np.full((2, 200, 3), np.nan)
    one[60:110], two[125:175] = beside(0, 1, 2)[60:110], beside(0, 1, 2)[125:175] + 60.0
    both = replace(walk(), paths=tuple(MarkerTrajectory.measured(n, x) for n, x in zip("ab", (one, two), strict=True)))
    stretches = stretches_of(both, 1600.0)
    assert stretches.link.toarray()[0, 1] > 0
    assert len(markers_of(stretches, np.full(2, -1), 39).label) == 0


def test_what_is_seen_too_little_to_tell_counts_as_a_marker_and_what_has_a_name_always_does():
    rng = np.random.default_rng(1)
    xyz = rng.normal(0, 500, (20, 6, 3)).astype(np.float32)
    xyz[2:, 5] = np.nan
    assert on_body(xyz, np.arange(6) < 5).all()
    assert on_body(xyz[:, :3], np.arange(3) < 2).all()
