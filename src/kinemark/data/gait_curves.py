"""A quantity of gait over strides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from .array_types import Bools, Floats
from .subject_measures import Side

WHOLE = 0.9
"""Share of a stride's points that are known if it counts as whole; chosen: the last are in the next step."""


class GaitCurves(NamedTuple):
    """One quantity over n strides.

    Attributes:
        name: as "LKneeAngles"; side: of the foot that cuts it; unit; axes: (A) names.
        values: (n, 101, A); sd: (n, 101, A) of measurement.
        foot_off: (n) % of each stride.
    """

    name: str
    side: Side
    unit: str
    axes: tuple[str, ...]
    values: Floats
    sd: Floats
    foot_off: Floats

    @property
    def mean(self) -> Floats:
        """(101, A)."""
        return known_mean(self.values)

    @property
    def spread(self) -> Floats:
        """(101, A) standard deviation between strides; NaN with one alone."""
        n = np.isfinite(self.values).sum(0)
        squares = np.where(n > 1, np.nansum((self.values - self.mean) ** 2, 0), np.nan)
        return np.sqrt(squares / np.maximum(n - 1, 1))

    @property
    def measurement_sd(self) -> Floats:
        """(101, A)."""
        return np.sqrt(known_mean(self.sd**2))

    @property
    def whole(self) -> Bools:
        """(n) strides of which all but a few points are known."""
        return np.asarray(np.isfinite(self.values).all(2).mean(1) >= WHOLE)

    @property
    def consistency(self) -> Floats:
        """(A) coefficient of multiple correlation (Kadaba et al. 1989), of whole strides where all of them are known.

        NaN with one stride, or where strides differ more than the curve moves.
        """
        y = self.values[self.whole]
        y = y[:, np.asarray(np.isfinite(y).all((0, 2)))]
        n, t = y.shape[:2]
        if n < 2 or t < 2:
            return np.full(len(self.axes), np.nan)
        within = ((y - y.mean(0)) ** 2).sum((0, 1)) / (t * (n - 1))
        total = ((y - y.mean((0, 1))) ** 2).sum((0, 1)) / (t * n - 1)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.sqrt(1 - within / total)


class GaitReference(NamedTuple):
    """A band of reference curves of controls.

    Attributes:
        mean, sd: (101, A) by the name of the quantity without its side, as "KneeAngles"; SD between subjects.
        source: where they are from. subjects: how many.
        log_score: mean and standard deviation of the logarithms of the controls' own profile scores; None: unknown.
        numbers: mean and SD between subjects of time-distance parameters ("speed") and key values, by name, in the
            units of `gait.json`.
        axes: what the components of a quantity are called, where the band says it.
    """

    mean: Mapping[str, Floats]
    sd: Mapping[str, Floats]
    source: str
    subjects: int
    log_score: tuple[float, float] | None = None
    numbers: Mapping[str, tuple[float, float]] = {}
    axes: Mapping[str, tuple[str, ...]] = {}


class KeyValue(NamedTuple):
    """One value of one stride.

    Attributes:
        name: what it is, with its phase, without side. side: of the foot.
        first: s of the strike that begins the stride. unit: of value and sd.
        value: NaN where a part of the phase is missing. at: % of the stride where it is; NaN for means and ranges.
        sd: standard uncertainty of measurement; NaN of a range, whose ends share most of theirs.
    """

    name: str
    side: Side
    first: float
    unit: str
    value: float
    at: float
    sd: float


def known_mean(y: Floats, axis: tuple[int, ...] = (0,), *, keep: bool = False) -> Floats:
    """Mean of y (…) over some of its axes of what is known; NaN where nothing is."""
    n = np.isfinite(y).sum(axis, keepdims=keep)
    return np.asarray(np.where(n > 0, np.nansum(y, axis, keepdims=keep) / np.maximum(n, 1), np.nan))


def joined_curves(each: Sequence[Sequence[GaitCurves]]) -> tuple[GaitCurves, ...]:
    """Curves of one name of all trials together."""
    by_name: dict[str, list[GaitCurves]] = {}
    for curves in each:
        for one in curves:
            by_name.setdefault(one.name, []).append(one)
    return tuple(
        same[0]._replace(
            values=np.concatenate([c.values for c in same]), sd=np.concatenate([c.sd for c in same]),
            foot_off=np.concatenate([c.foot_off for c in same]),
        )
        for same in by_name.values()
    )  # fmt: skip
