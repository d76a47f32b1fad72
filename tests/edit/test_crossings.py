"""Paths that step onto another's place: a claim goes on over it only where it has a witness."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.data.edits import Claim
from kinemark.edit import replay, stretch_of
from kinemark.edit.crossings import unbroken
from support.edited import entries, paths_without_images, samples

APART = 25.0  # mm: markers of one segment


def near(seed, frames=200):
    """Four markers of one segment."""
    some = paths_without_images(n=1, frames=frames, seed=seed)
    rng = np.random.default_rng(seed)
    xyz = [some.paths[0].xyz + APART * np.eye(3)[k % 3] * (k + 1) + rng.normal(0, 0.2, (frames, 3)) for k in range(4)]
    return of(xyz)


def of(xyz):
    return Trajectories(tuple(MarkerTrajectory.measured(f"*{k + 1}", path) for k, path in enumerate(xyz)), 100.0)


def exchanged(tracks, a, b, spans):
    """As a tracker leaves them that took one for the other in some frames."""
    xyz = [path.xyz.copy() for path in tracks]
    for first, stop in spans:
        xyz[a][first:stop], xyz[b][first:stop] = tracks.paths[b].xyz[first:stop], tracks.paths[a].xyz[first:stop]
    return of(xyz)


def spans(seed, n=4, frames=200):
    """Stretches of 2 to 6 frames, so far apart that there is a witness between them."""
    rng = np.random.default_rng(seed)
    starts = 16 + np.sort(rng.choice((frames - 32) // 24, n, replace=False)) * 24
    return [(int(f), int(f + rng.integers(2, 7))) for f in starts]


def wrong(edited, tracks, names):
    """Samples that are called by a name and are another marker's, and those that are rightly called so."""
    off = right = 0
    for k, name in enumerate(names):
        if name in edited.trajectories.names:
            path = edited.trajectories[name].xyz
            own = np.isfinite(path[:, 0])
            good = (path[own] == tracks.paths[k].xyz[own]).all(1)
            off, right = off + int((~good).sum()), right + int(good.sum())
    return off, right


@pytest.mark.parametrize("seed", range(5))
def test_a_claim_does_not_go_on_over_an_exchange_that_came_when_the_trial_was_tracked_otherwise(seed):
    tracks, names = near(seed), ["A", "B", "C", "D"]
    said = entries(*(Claim(stretch_of(tracks, f"*{k + 1}"), name) for k, name in enumerate(names)))
    assert wrong(replay(tracks, said), tracks, names) == (0, 4 * 200)
    a, b = np.random.default_rng(seed).choice(4, 2, replace=False).tolist()
    off, right = wrong(replay(exchanged(tracks, a, b, spans(seed)), said), tracks, names)
    assert off == 0, "samples of another marker are not called so, though no witness is among them"
    assert right >= 4 * 200 - 2 * sum(stop - first for first, stop in spans(seed))


@pytest.mark.parametrize("seed", range(5))
def test_what_was_said_of_a_path_with_exchanges_in_it_holds_for_all_of_that_path(seed):
    tracks = exchanged(near(seed), 0, 1, spans(seed))
    claim = Claim(stretch_of(tracks, "*1"), "A")
    frames = [witness.frame - 1 for witness in claim.where.witnesses]
    assert set(unbroken([tracks.paths[0]], tracks)[0][frames]) == set(range(2 * 4 + 1)), "each piece has a witness"
    again = replay(tracks, entries(claim)).trajectories
    assert np.array_equal(samples(again)["A"], np.arange(200))


def test_a_path_that_jumps_where_no_other_is_stays_whole():
    tracks = paths_without_images()  # 150 mm apart
    xyz = [path.xyz.copy() for path in tracks]
    xyz[0][60:63] += [0.0, 0.0, 40.0]
    again = of(xyz)
    assert len(np.unique(unbroken(again.paths, again)[0])) == 1
    said = entries(Claim(stretch_of(tracks, "*1"), "A"))
    assert len(samples(replay(again, said).trajectories)["A"]) == 200


def test_pieces_are_the_same_for_each_path_alone_and_however_the_trial_lies():
    tracks = exchanged(near(1), 1, 2, spans(1))
    whole = unbroken(tracks.paths, tracks)
    assert len(np.unique(whole[1])) == len(np.unique(whole[2])) == 2 * len(spans(1)) + 1
    for k, path in enumerate(tracks):
        assert np.array_equal(unbroken([path], tracks)[0], whole[k])
    moved = of([path.xyz @ np.diag([1.0, -1.0, -1.0]) + [500.0, -2000.0, 90.0] for path in tracks])
    assert np.array_equal(unbroken(moved.paths, moved), whole)
    late = replace(tracks, paths=tracks.paths[::-1])
    assert np.array_equal(unbroken(late.paths, late), whole[::-1])
    assert unbroken([], tracks).shape == (0, 200)
