"""Fewer samples and fewer markers for the eye, so that no trial makes a heavy page."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import Trajectories
from ..data.array_types import Floats
from ..findings.markers import present

MOST_MARKERS = 60
"""Drawn one by one in a figure, the fullest; more cannot be told apart; chosen (see benchmarks/pages.py)."""

FINE = 0.01
"""mm, or px: what no figure shows; chosen."""


def short(values: NDArray[np.float64]) -> NDArray[np.floating]:
    """The same in single precision, for a page of half the size, unless numbers are so great that it would show."""
    single = values.astype(np.float32)
    most = np.abs(single[np.isfinite(single)]).max(initial=np.float32(0))
    return single if np.spacing(most) < FINE else values


def blocks(values: NDArray[np.generic], most: int) -> NDArray[np.generic]:
    """The last axis (…, F) cut into at most `most` blocks (…, B, k), the last one filled up with the last sample."""
    n = values.shape[-1]
    k = max(1, -(-n // most))
    pad = [(0, 0)] * (values.ndim - 1) + [(0, -n % k)]
    padded = np.pad(values, pad, mode="edge") if n else values
    return padded.reshape(*values.shape[:-1], -1, k) if n else padded.reshape(*values.shape, 1)


def envelope(values: Floats, most: int) -> tuple[NDArray[np.int64], Floats]:
    """Frames and values of a signal (F) at no more than `most` samples, so that neither spikes nor long gaps are lost.

    Signals that are short enough come back whole. Of longer ones, each block gives its least and its greatest sample
    in the order of time; a block without any sample gives NaN.
    """
    if len(values) <= most:
        return np.arange(len(values)), values
    cut = np.asarray(blocks(values, most // 2), float)
    low = np.where(np.isnan(cut), np.inf, cut).argmin(1)
    high = np.where(np.isnan(cut), -np.inf, cut).argmax(1)
    within = np.sort(np.column_stack([low, high]), axis=1)
    frame = np.arange(len(cut))[:, None] * cut.shape[1] + within
    return np.minimum(frame.reshape(-1), len(values) - 1), np.take_along_axis(cut, within, 1).reshape(-1)


class Curve(NamedTuple):
    """Samples at equal steps, in frames: the first one's place, the step, and the values."""

    start: float
    step: float
    values: Floats

    def at(self, rate: float, first: float = 0.0) -> dict[str, float]:
        """Its time axis, s, as Plotly takes it, which is smaller than a time for each sample."""
        return {"x0": first + self.start / rate, "dx": self.step / rate}


def thinned(values: Floats, most: int) -> Curve:
    """`envelope` of values (F) at equal steps: a block's least and greatest sample are in its first and second half."""
    _, few = envelope(values, most)
    if len(few) == len(values):
        return Curve(0.0, 1.0, values)
    k = -(-len(values) // (most // 2))
    return Curve(k / 4 - 0.5, k / 2, few)


def fullest(trajectories: Trajectories, most: int = MOST_MARKERS) -> tuple[Trajectories, Trajectories]:
    """The markers with most samples, in the trial's order, and the others."""
    samples = present(trajectories).sum(1) if len(trajectories) else np.zeros(0, int)
    first = set(np.argsort(-samples, kind="stable")[:most].tolist())
    parts = [[path for m, path in enumerate(trajectories) if (m in first) == kept] for kept in (True, False)]
    some, others = (replace(trajectories, paths=tuple(paths)) for paths in parts)
    return some, others
