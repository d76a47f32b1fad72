"""Tracks as the labelling sees them: which are seen together, and what goes on from what."""

import numpy as np

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label.stretches import PART, stretches_of, together
from kinemark.label.sweeps import continuity, places


def pieces(T=40, F=2 * PART + 30, seed=1):
    """Tracks with gaps, some of them in two parts of the trial, one without a sample."""
    rng = np.random.default_rng(seed)
    xyz = np.cumsum(rng.normal(0, 2, (T, F, 3)), axis=1) + rng.normal(0, 300, (T, 1, 3))
    first, n = rng.integers(0, F, T), rng.integers(1, 90, T)
    frames = np.arange(F)
    seen = (frames >= first[:, None]) & (frames < (first + n)[:, None]) & (rng.random((T, F)) < 0.8)
    seen[0], seen[1], seen[2] = False, frames % 97 == 5, True
    xyz[~seen] = np.nan
    return Trajectories(tuple(MarkerTrajectory.measured(f"*{t}", one) for t, one in enumerate(xyz)), 100.0), seen


def test_tracks_are_together_where_one_frame_has_both_in_any_part_of_the_trial():
    _, seen = pieces()
    wanted = (seen[:, None] & seen[None]).any(2) & ~np.eye(len(seen), dtype=bool)
    np.testing.assert_array_equal(together(seen), wanted)
    assert wanted[1].any() and not wanted[0].any()


def test_what_goes_on_is_told_of_some_tracks_as_of_all():
    tracks, _ = pieces()
    stretches = stretches_of(tracks, 1500.0)
    label = np.random.default_rng(2).integers(-1, 5, len(tracks))
    every, some = continuity(stretches, label, 5), np.array([3, 17, 29])
    np.testing.assert_array_equal(continuity(stretches, label, 5, some), every[some])
    link = stretches.link.toarray()
    wanted = [[(link[t, label == a].sum() + link[label == a, t].sum()) for a in range(5)] for t in range(len(tracks))]
    np.testing.assert_allclose(every, wanted, atol=1e-9)


def test_places_are_those_of_the_tracks_that_have_the_label():
    tracks, _ = pieces()
    stretches = stretches_of(tracks, 1500.0)
    label = np.where(np.arange(len(tracks)) == 7, 3, -1)
    found = places(stretches, label, 4)
    np.testing.assert_array_equal(found[:, 3], stretches.xyz[7])
    assert np.isnan(found[:, :3]).all()
