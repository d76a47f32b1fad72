"""What the channels of a force plate show while nothing stands on it: their drift since they were set to zero.

A drift of some newton or newton metres moves the centre of pressure, and with it every moment. While nobody stands on
a plate its vertical force v is light and steady, and beside a step it is neither. Unloaded are stretches of `STEADY_S`
and more in which v, averaged over `AVERAGED_S`, stays within `NOISE` of its range r, which holds 0, from the level

    b = median of v where |v| < LIGHT r                                                                     (1)

less `EDGE_S` at both ends, in which a foot may begin to load. Where the noise of v, which second differences of its
samples show, is more than that, it is `WITHIN` of its standard deviations (2). A plate that never carries a person's
weight is unloaded all the time, if it is steady, and shows less than half of that: who stands on two plates has the
half on each. A plate that is always loaded, as the belt of a walker with both feet on it, has none;
nor has one whose program writes 0 while nobody stands on it, for it has taken its own off.
"""

from __future__ import annotations

import numpy as np

from ..data import ForcePlate
from ..data.array_types import Bools, Floats
from ..numerics.runs import true_runs

STEADY_S = 0.2
"""Of an unloaded stretch, s; chosen: a foot loads a plate within 0.05 and leaves it within 0.15, a swing takes 0.35."""
AVERAGED_S = 0.02
"""Over which v is averaged before it is looked at, s; chosen: a period of the mains."""
EDGE_S = 0.05
"""Left out at both ends of a stretch, s; chosen."""
NOISE = 0.03
"""Of r, within which v is steady; chosen: noise is a hundredth, and a foot moves it by all of it."""
LIGHT = 0.25
"""Of r, which nobody who steps on a plate stays below; chosen: drifts of up to 60 N below a child."""
WITHIN = 4.0
"""Of (2); chosen: some hundred samples in a row are to be within."""
ONE_WAY = 0.1
"""Of how far v goes to one side, by which it may go to the other; chosen: plates with drifts of 80 to 210 N had 0.006,
who pushes off from standing adds a fifth."""
PERSON_N = 100.0
"""r of a plate that carries a person, N; chosen: a child of 10 kg."""


def unloaded(plate: ForcePlate, values: Floats, rate: float) -> Bools:
    """(N) samples in which nothing stands on a plate, by (1); none where that cannot be told.

    Args:
        plate: of type 1 to 5. values: (N, K) of its channels. rate: samples a second.
    """
    raw = _vertical(plate, values)
    n = max(1, round(AVERAGED_S * rate))
    v = _averaged(raw, n)
    none = np.zeros(len(v), np.bool_)
    span = _range(v)
    light = np.abs(v) < (LIGHT * span if span > PERSON_N else PERSON_N / 2)
    if not light.any():
        return none
    noise = max(NOISE * max(span, PERSON_N), WITHIN * _noise(raw) / np.sqrt(n))  # (2)
    edge = round(EDGE_S * rate)
    for first, stop in true_runs(np.asarray(np.abs(v - np.median(v[light])) < noise)).tolist():
        if stop - first >= STEADY_S * rate:
            none[first + edge * (first > 0) : stop - edge * (stop < len(v))] = True
    return none & (np.median(raw[none]) != 0) if none.any() else none


def loads_one_way(plate: ForcePlate, values: Floats, quiet: Bools, rate: float) -> bool:
    """Whether v goes from its mean in some samples to one side alone, as from those without a load it does; who stands
    there meanwhile leaves the plate, and loads it more.

    Args:
        plate: of type 1 to 5. values: (N, K) of its channels. quiet: (N) these samples. rate: samples a second.
    """
    v = _averaged(_vertical(plate, values), max(1, round(AVERAGED_S * rate)))
    level = float(np.nanmean(v[quiet]))
    ways = float(np.nanmax(v)) - level, level - float(np.nanmin(v))
    return min(ways) <= ONE_WAY * max(ways)


def _range(v: Floats) -> float:
    """N, of v (N) N and 0."""
    return float(np.nanmax(v, initial=0.0) - np.nanmin(v, initial=0.0))


def _noise(v: Floats) -> float:
    """N, the standard deviation of white noise in (N) N, by the median of its second differences; 0 of too few."""
    second = np.abs(np.diff(v, 2))
    known = second[np.isfinite(second)]
    return float(np.median(known)) / (0.6745 * np.sqrt(6.0)) if len(known) else 0.0


def _vertical(plate: ForcePlate, values: Floats) -> Floats:
    """(N) N of channels (N, K); NaN where one is missing."""
    values = np.where(np.isfinite(values), values, np.nan)
    if plate.type == 3:
        return np.asarray(values[:, 4:8].sum(1))
    if plate.type in (4, 5) and plate.calibration is not None:
        return np.asarray(values @ plate.calibration[2])
    return values[:, 2]


def _averaged(v: Floats, n: int) -> Floats:
    """(N) moving mean over n samples; NaN where one is missing, and the value itself nearer than that to the ends."""
    out = v.copy()
    if n > 1 and len(v) >= n:
        out[n // 2 : n // 2 + len(v) - n + 1] = np.convolve(v, np.full(n, 1 / n), "valid")
    return out
