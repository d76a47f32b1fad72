"""Motions of points and bodies whose truth is known, for tests of matching, tracking and filling."""

import numpy as np


def dance(n=8, frames=60, *, rate=100.0, seed=0):
    """n points (n, F, 3) mm on circles of 100–300 mm, at one turn in one to two seconds, about places 500 mm apart."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames) / rate
    centre = np.column_stack([rng.permutation(n) * 150.0 - 600, rng.uniform(-400, 400, n), rng.uniform(500, 1500, n)])
    radius, turn, phase = rng.uniform(100, 300, n), rng.uniform(0.5, 1.0, n), rng.uniform(0, 2 * np.pi, n)
    angle = 2 * np.pi * turn[:, None] * t + phase[:, None]
    circle = np.stack([np.cos(angle), np.sin(angle), 0.5 * np.sin(2 * angle)], -1)
    return centre[:, None] + radius[:, None, None] * circle


def swarm(n=15, frames=60, rate=100.0, seed=0):
    """n markers (n, F, 3) mm on smooth closed paths through a gait volume."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None] / rate
    centre = rng.uniform([-500, -800, 100], [500, 800, 1700], (n, 1, 3))
    reach = rng.uniform(50, 200, (n, 1, 3))
    phase = rng.uniform(0, 2 * np.pi, (n, 1, 3))
    return centre + reach * np.sin(2 * np.pi * rng.uniform(0.4, 1.2, (n, 1, 1)) * t + phase)


def parabolas(n=4, frames=40, seed=0):
    """n paths (n, F, 3) of constant acceleration, per frame."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None]
    p, v, a = rng.normal(0, [[[300.0]], [[8.0]], [[0.4]]], (3, n, 3))[:, :, None]
    return p + v * t + a * t**2 / 2


def line(frames, velocity, start=(0.0, 0, 0)):
    """(1, F, 3) a point that moves by `velocity` mm a frame."""
    return np.asarray(start) + np.arange(frames)[None, :, None] * np.asarray(velocity, float)


def in_pieces(path, gap):
    """A path (F, 3) as two with a gap of frames between them, (2, F, 3)."""
    one, other = path.copy(), path.copy()
    half = len(path) // 2
    one[half:], other[: half + gap] = np.nan, np.nan
    return np.stack([one, other])


def body(frames=100):
    """Six points on something rigid that goes and turns, (6, F, 3) mm."""
    t = np.arange(frames) / 100
    angle = 1.5 * np.sin(2 * np.pi * 1.3 * t)
    R = np.array(
        [[np.cos(angle), -np.sin(angle), 0 * t], [np.sin(angle), np.cos(angle), 0 * t], [0 * t, 0 * t, 1 + 0 * t]]
    )
    shape = np.random.default_rng(4).uniform(-150, 150, (6, 3))
    return np.einsum("ijt,nj->nti", R, shape) + np.stack([900 * t, 50 * t, 1000 + 0 * t], -1)
