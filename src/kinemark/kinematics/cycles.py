"""Cycles of a motion on one scale of 0 to 100 %, and their mean.

A cycle from time t₀ to t₁ is read at t₀ + (t₁ − t₀) k / 100, k = 0 … 100 (1), by straight lines between frames; a point
beside a missing frame is missing. Over N cycles the mean of n values known at a per cent has the standard deviation

    SD = √ Σ (y − ȳ)² / (n − 1)                                                                         (2)

which is how much the motion varies; what the measurement adds is the root mean square of the propagated SD (3), and
√(3)² / n (4) is that of the mean, if errors of different cycles are independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..data import Angles, Events, KinemarkError
from ..data.angles import Cycles
from ..data.array_types import Floats

POINTS = 101  # of a cycle, 0 to 100 %; conventional in gait analysis


def resampled(values: Floats, *, rate: float, span: tuple[float, float], points: int = POINTS) -> Floats:
    """(points, …) of values (F, …) between two times, s (1).

    Raises:
        ValueError: the span is empty or reaches beyond the recording.
    """
    first, last = span[0] * rate, span[1] * rate
    if not -1e-6 <= first < last <= len(values) - 1 + 1e-6:
        raise ValueError(f"the cycle from {span[0]:g} to {span[1]:g} s is not in 0 to {(len(values) - 1) / rate:g} s")
    at = np.clip(np.linspace(first, last, points), 0, len(values) - 1)  # (1)
    near = np.minimum(np.floor(at).astype(np.int64), max(len(values) - 2, 0))
    w = (at - near).reshape(-1, *[1] * (values.ndim - 1))
    after = values[np.minimum(near + 1, len(values) - 1)]
    return np.where(w == 0, values[near], np.where(w == 1, after, (1 - w) * values[near] + w * after))


def cycles(angles: Angles, *, spans: Sequence[tuple[float, float]]) -> Cycles:
    """Every cycle of a trial's angles, their mean and spread.

    Args:
        angles: of one trial.
        spans: beginning and end of each cycle, s from the first frame.

    Raises:
        KinemarkError: no cycle, or one that is not in the recording.
    """
    if not len(spans):
        raise KinemarkError("No cycle is given. Say where each begins and ends.")
    try:
        deg, sd = (
            np.array([resampled(y.swapaxes(0, 1), rate=angles.rate, span=span).swapaxes(0, 1) for span in spans])
            for y in (angles.deg, angles.sd)
        )
    except ValueError as error:
        raise KinemarkError(f"{error}. Correct the cycles.") from None
    return Cycles(deg, sd, *averaged(deg, sd), np.array(spans, np.float64))


def averaged(deg: Floats, sd: Floats) -> tuple[Floats, Floats, Floats]:
    """Mean, spread (2) and noise of the mean (4) over the first axis; missing values are left out.

    Cycles may be whole turns apart where a joint went round; each is laid by whole turns next to the first.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        n = np.isfinite(deg).sum(0)
        start = np.nansum(deg, axis=2, keepdims=True) / np.isfinite(deg).sum(2, keepdims=True)
        deg = deg - 360 * np.round(np.nan_to_num((start - start[:1]) / 360))
        mean = np.nansum(deg, 0) / n
        spread = np.where(n > 1, np.sqrt(np.nansum((deg - mean) ** 2, 0) / (n - 1)), np.nan)  # (2)
        noise = np.where(np.isfinite(mean), np.sqrt((sd**2).sum(0)) / n, np.nan)  # (4)
    return mean, spread, noise


def spans_of(events: Events, *, label: str, side: str | None = None, start_s: float = 0.0) -> list[tuple[float, float]]:
    """Spans, s, between consecutive events of one label, such as "Foot Strike".

    Args:
        events: of the trial.
        label: of the events that begin a cycle.
        side: "Left", "Right", …; any where None.
        start_s: time of the first frame on the clock of the events.

    Raises:
        KinemarkError: fewer than two such events.
    """
    pairs = zip(events.label, events.side, events.time, strict=True)
    times = sorted(float(t) - start_s for name, s, t in pairs if name == label and side in (None, s))
    if len(times) < 2:
        known = ", ".join(sorted(set(events.label))) or "none"
        raise KinemarkError(f"{len(times)} events are called {label!r}, wanted two or more; there are {known}.")
    return list(pairwise(times))
