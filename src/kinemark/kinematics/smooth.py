"""Smoothing of markers before angles are taken.

Each marker is smoothed by itself, its three axes alike, so that the result turns with the laboratory. A Butterworth
filter works through each run of seen frames; Woltring's spline sees the whole path, gaps and all, but only frames that
were seen are kept: filling is another stage. White noise of covariance C leaves g C behind (1), with g of
`filters` (2) or `woltring`; at the ends of a run somewhat more.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np

from ..data import MarkerTrajectory, Trajectories
from ..data.array_types import Bools
from ..data.method import ONE, Method, parameter
from ..numerics.runs import true_runs
from ..signal.filters import butterworth, butterworth_gain, edge_samples, residual_analysis
from ..signal.woltring import woltring
from .stage import SMOOTH


@dataclass(frozen=True, slots=True)
class Butterworth(Method):
    """A Butterworth low-pass filter run forwards and backwards, without lag."""

    cutoff_hz: float | None = parameter(
        None, unit="Hz", above=0,
        meaning="cut-off, where both passes together fall to 1/√2; None: by residual analysis, marker by marker",
    )  # fmt: skip
    order: int = parameter(2, unit=ONE, low=1, meaning="of one pass")


@dataclass(frozen=True, slots=True)
class WoltringSpline(Method):
    """A natural smoothing spline, quintic unless said otherwise."""

    cutoff_hz: float | None = parameter(
        None, unit="Hz", above=0,
        meaning="cut-off, where it falls to 1/√2; None: by generalised cross-validation, marker by marker",
    )  # fmt: skip
    half_order: int = parameter(3, unit=ONE, low=1, meaning="3 is quintic, 2 cubic")


def smooth(trajectories: Trajectories, *, method: Method) -> Trajectories:
    """Smoothed markers, with what is left of their covariance (1); runs too short to smooth are kept as they are.

    Raises:
        ValueError: the method is none of `SMOOTH`, or the cut-off is not below half the rate.
    """
    one = SMOOTH.function(method)
    return replace(trajectories, paths=tuple(one(path, trajectories.rate, method=method) for path in trajectories))


_CUTOFFS: WeakKeyDictionary[MarkerTrajectory, dict[tuple[float, int], float | None]] = WeakKeyDictionary()
"""Of markers, by rate and order, as long as these live: 60 filters each, and gait asks three times."""


def residual_cutoff(path: MarkerTrajectory, *, rate: float, order: int = 2) -> float | None:
    """The cut-off, Hz, that residual analysis gives a marker from its longest run; None from fewer than 30 frames."""
    known = _CUTOFFS.setdefault(path, {})
    if (rate, order) not in known:
        known[rate, order] = _residual_cutoff(path, rate, order)
    return known[rate, order]


def _residual_cutoff(path: MarkerTrajectory, rate: float, order: int) -> float | None:
    """See `residual_cutoff`."""
    runs = true_runs(_seen(path)).tolist()
    first, stop = max(runs, key=lambda run: run[1] - run[0], default=(0, 0))
    if stop - first < 30:
        return None
    return residual_analysis(path.xyz[first:stop], rate=rate, order=order)[0]


def _seen(path: MarkerTrajectory) -> Bools:
    """(F) frames that have a sample."""
    return np.asarray(np.isfinite(path.xyz).all(1))


@SMOOTH.method("butterworth", Butterworth, source="Winter 2009")
def smooth_butterworth(path: MarkerTrajectory, rate: float, *, method: Butterworth) -> MarkerTrajectory:
    """A marker, each run of seen frames filtered by itself; runs that are too short stay as they are."""
    order = method.order
    cutoff = method.cutoff_hz or residual_cutoff(path, rate=rate, order=order)
    if cutoff is None:
        return path
    xyz, cov = path.xyz.copy(), path.cov.copy()
    gain = butterworth_gain(rate=rate, cutoff_hz=cutoff, order=order)
    for first, stop in true_runs(_seen(path)):
        if stop - first > edge_samples(order):
            xyz[first:stop] = butterworth(path.xyz[first:stop], rate=rate, cutoff_hz=cutoff, order=order)
            cov[first:stop] *= gain  # (1)
    return replace(path, xyz=xyz, cov=cov)


@SMOOTH.method("woltring", WoltringSpline, source="Woltring 1986")
def smooth_woltring(path: MarkerTrajectory, rate: float, *, method: WoltringSpline) -> MarkerTrajectory:
    """A marker under one spline through all frames in which it is seen; gaps stay open."""
    seen = _seen(path)
    if seen.sum() <= 2 * method.half_order:
        return path
    cutoff = None if method.cutoff_hz is None else method.cutoff_hz / rate
    found = woltring(path.xyz, half_order=method.half_order, cutoff=cutoff)
    return replace(path, xyz=np.where(seen[:, None], found.values, np.nan), cov=path.cov * found.gain)  # (1)
