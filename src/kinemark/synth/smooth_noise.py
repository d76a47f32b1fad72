"""Smooth noise: what soft tissue, hands and attention add to a motion."""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats


def smooth_noise(shape: tuple[int, ...], rate: float, seed: int, *, cut_hz: float) -> Floats:
    """Gaussian noise of standard deviation 1 along axis 1 of `shape`, with nothing above `cut_hz`.

    It is a sum of sinusoids with seeded phases and amplitudes, their frequencies spread over all up to the cut, so
    that it is the same motion at any frame rate.
    """
    rng = np.random.default_rng(seed)
    others = (shape[0], *shape[2:])
    n = 24
    hz = cut_hz * (np.arange(n) + rng.uniform(0.2, 0.8, n)) / n
    amplitude = rng.normal(0.0, 1.0, (2, n, *others)) / np.sqrt(n)
    angle = 2 * np.pi * np.outer(np.arange(shape[1]) / rate, hz)
    waves = np.tensordot(np.cos(angle), amplitude[0], 1) + np.tensordot(np.sin(angle), amplitude[1], 1)
    return np.moveaxis(waves, 0, 1)
