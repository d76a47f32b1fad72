"""Tracks that likely continue earlier ones are said, and not joined."""

import numpy as np
import pytest

from kinemark.data import Cloud, Tracks
from kinemark.track.simultaneous.joining.continuations import continuations
from support.motions import dance

RATE = 100.0


def with_a_break(xyz, hidden, rate=RATE):
    """Tracks of markers (M, F, 3) mm of which those in `hidden` are away from their frame to their frame, and come back
    as tracks M, M + 1, … in this order; and the pairs that are one marker."""
    M, F = xyz.shape[:2]
    ids, frames = np.meshgrid(np.arange(M), np.arange(F), indexing="ij")
    there = np.ones((M, F), bool)
    for k, (m, (first, stop)) in enumerate(hidden.items()):
        there[m, first:stop] = False
        ids[m, stop:] = M + k
    order = np.argsort(frames[there], kind="stable")
    n = len(order)
    start = np.searchsorted(frames[there][order], np.arange(F + 1))
    cov = np.broadcast_to(np.eye(3) * 0.25, (n, 3, 3))
    cloud = Cloud(rate, start, xyz[there][order], cov, np.zeros(n), np.zeros((n, 2), np.int64))
    return Tracks(cloud, ids[there][order]), [[m, M + k] for k, m in enumerate(hidden)]


def bodies(seed, F=400):
    """(12, F, 3) mm: three stiff bodies of four markers, each with a path of its own."""
    rng = np.random.default_rng(seed)
    t = np.arange(F) / RATE
    out = []
    for _ in range(3):
        place = rng.uniform(-800, 800, 3) + 400 * np.sin(2 * np.pi * 0.4 * t[:, None] + rng.uniform(0, 6, 3))
        turn = 0.8 * np.sin(2 * np.pi * 0.5 * t + rng.uniform(0, 6))
        R = np.array(
            [[np.cos(turn), -np.sin(turn), 0 * t], [np.sin(turn), np.cos(turn), 0 * t], [0 * t, 0 * t, 0 * t + 1]]
        )
        arms = rng.uniform(-150, 150, (4, 3))
        out += [place + np.einsum("ijf,j->fi", R, arm) for arm in arms]
    return np.array(out) + rng.normal(0, 0.5, (12, F, 3))


@pytest.mark.parametrize("seed", range(4))
def test_markers_that_come_back_after_a_second_are_said_to_continue(seed):
    tracks, pairs = with_a_break(bodies(seed), {1: (120, 260), 6: (140, 270), 9: (150, 280)})
    assert continuations(tracks).tolist() == pairs


def test_nothing_is_said_of_markers_that_hold_no_distance():
    tracks, _ = with_a_break(dance(n=12, frames=400, rate=RATE), {1: (120, 260), 6: (140, 270)})
    assert len(continuations(tracks)) <= 2


@pytest.mark.parametrize("seed", range(3))
def test_a_new_marker_continues_none(seed):
    xyz = bodies(seed)
    tracks, pairs = with_a_break(xyz, {1: (120, 260)})
    elsewhere = tracks.cloud.xyz.copy()
    elsewhere[tracks.id == 12] += [60.0, 90.0, -70.0]
    moved = Tracks(
        Cloud(RATE, tracks.cloud.start, elsewhere, tracks.cloud.cov, tracks.cloud.residual, tracks.cloud.detection),
        tracks.id,
    )
    assert continuations(tracks).tolist() == pairs and not len(continuations(moved))
