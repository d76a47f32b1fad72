"""Where the model puts a marker, seen from each of its neighbours (Swamidas 1997, 3.5.2), and how far off that is.

For a segment of length ℓ from marker i to marker k with the model's direction d(φ),

    x_k = x_i + ℓ R d(φ(t)),   x_i = x_k − ℓ R d(φ(t))                                           (1)

R turns the model's bank to the markers of it that are seen. With observed directions u_s and the model's d_s of the
pairs s seen, without those of k itself, it is the rotation that makes tr(Rᵀ B) greatest,

    B = Σ_s (ℓ_s / σ)² u_s d_sᵀ + I / a²                                                         (2)

(Wahba 1965.) σ is what markers on skin move within a bank, a the spread of the model's angles: the second term asks for
no turn. One formula serves all banks: with no pair seen R = I, which is the thesis; with one, the bank is swung into
its line, by the shortest way; with two or more R is the pose of a rigid body.

Where the model is made of the trial itself, d(φ(t)) for the frame t is not the mean of all cycles but that of the other
ones, up to three before and three after: with t_m the moment at which φ(t_m) = φ(t) + m,

    d(t) ∝ Σ_m≠0 w_m u(t_m)                                                                      (3)

A mean with t's own cycle in it would be pulled to what it is to be compared with. w is 1, and falls to 0 within a
tenth of a cycle where u is about to be missing, so that d has no steps. The error of (1) is known wherever k and i
are both seen:

    r(t) = x_k − x_i − ℓ R d                                                                     (4)

Its mean r̄, covariance S and how long it lasts are taken over the whole trial, in runs of frames where it is long. r is
likened to a process of covariance S c(Δt), c(Δt) = (1 + Δt / τ) exp(−Δt / τ) (5); τ is where the correlation found at a
tenth of a cycle puts it.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....data import AngleModel
from ....data.array_types import Bools, Floats, Ints
from ....geometry import polar_rotations
from ....signal.learn_angle_model import LONG, CycleInterpolation, columns, most_moving, template_of, weights
from ....signal.phase import CyclePhase, CycleTemplate, information, variance_at
from ....signal.smoother import measurement_sd_of

SKIN = 3.0
"""σ of (2), mm; chosen (see studies/missing_markers.py)."""
TURN = 0.1
"""a of (2), rad; chosen (see studies/missing_markers.py)."""
OTHERS = 3
"""Cycles before, and after, of (3); chosen (see studies/missing_markers.py)."""
SURE = 0.2
"""Least sum of the weights of (3) for which d is taken from it. The sum is 1 or more where one other cycle shows the
segment, and falls to 0 at its holes. A moment within a hole is not worth 0, though: the interpolation gives the seen
frames beside the hole its outer weights, of −0.07 to 0 each. Their sum is negative, and no direction. By dividing by
0.2 or more what six other cycles leave of this stays small beside what one of them shows.
Chosen (see studies/missing_markers.py)."""
FEWEST = 10
"""Frames that must tell of r; chosen (see studies/missing_markers.py)."""
MOST = 1500
"""Frames of a trial above which r is judged in runs of them, spread over the trial: neighbours say the same.
Chosen (see studies/missing_markers.py)."""
RUN = 7
"""Frames in a row that tell its noise; chosen (see studies/missing_markers.py)."""
APART = 6
"""Frames unknown that keep runs from being taken for one; chosen (see studies/missing_markers.py)."""
FEW = 9
"""Frames of a gap at which the phase's variance is worked out; chosen (see studies/missing_markers.py)."""
UNKNOWN = 0.05
"""Spread of (1) as a share of ℓ, where r is not known; chosen (see studies/missing_markers.py)."""
LAGS = np.linspace(0.01, 6, 600)  # lags over τ at which (5) is tabulated; chosen (see studies/missing_markers.py)
FALLING = -(1 + LAGS) * np.exp(-LAGS)
"""−c of (5) at these Δt / τ, rising; by definition."""


class Errors(NamedTuple):
    """Of K neighbours of a marker: r (K, N, 3) mm of (4) in the frames of the placings, NaN where not both are seen;
    mean (K, 3) r̄; cov (K, 3, 3) S, mm²; tau (K) frames; noise (K) mm, what of r differs from frame to frame."""

    r: Floats
    mean: Floats
    cov: Floats
    tau: Floats
    noise: Floats


class Placings(NamedTuple):
    """Marker k from each of K neighbours, the surest first, in N frames, rising: source (K) markers, way (K, N, 3) mm
    from there by (1), slope (N, 3) mm a cycle of the first, and how far off they are."""

    source: Ints
    frames: Ints
    way: Floats
    slope: Floats
    errors: Errors


class _Bank(NamedTuple):
    """The R segments of a bank: rows of the model, link (R, 2) and curve; seen (F, R, 3) the directions, 0 where
    missing; weight (F, R) w of (3); weighted (F, 3 R), seen times w; and in the frames from which errors are judged, d
    and alone of `_directions`."""

    rows: Ints
    link: Ints
    curve: CycleTemplate
    seen: Floats
    weight: Floats
    weighted: Floats
    d: Floats
    alone: Bools


class _Ways(NamedTuple):
    """From the K neighbours of a marker in one bank: source (K) markers, length (K) mm, r (K, U + N, 3), in the U
    frames of `_usual` first, way and its slope (K, N, 3) of `Placings`."""

    source: Ints
    length: Floats
    r: Floats
    way: Floats
    slope: Floats


class Placer:
    """Places markers of a trial by a model.

    Attributes:
        xyz: (M, F, 3) mm, NaN where missing.
        model: with links between these markers.
        cycle: frames.
        phase: of the trial's frames.
    """

    def __init__(self, xyz: Floats, model: AngleModel, phase: CyclePhase, *, cycle: float, own: bool) -> None:
        self.xyz, self.phase, self.cycle = xyz, phase, cycle
        self.model, self._moments = model, _moments(phase) if own else []
        self._curve, self._spread = template_of(model)
        self._lag = max(round(cycle / 10), 1)
        self._usual = _runs(xyz.shape[1], self._lag)
        self._apart = np.arange(len(self._usual)) + APART * np.cumsum(np.diff(self._usual, prepend=self._usual[0]) > 1)
        then = np.searchsorted(self._usual, self._usual + self._lag).clip(max=len(self._usual) - 1)
        self._now = np.flatnonzero(self._usual[then] == self._usual + self._lag)
        self._then = then[self._now]
        self._banks: dict[int, _Bank] = {}

    def __call__(self, marker: int, frames: Ints) -> Placings | None:
        """From all neighbours from which a marker can be placed in these frames, rising; None where it has none."""
        numbers = np.unique(self.model.bank[(self.model.links == marker).any(1)])
        others, n = self._others[frames] if self._moments else None, len(self._usual)
        found = [self._ways(marker, self._bank(int(number)), frames, others) for number in numbers]
        if not found:
            return None
        source, length, r, way, slope = (np.concatenate(parts) for parts in zip(*found, strict=True))
        errors = self._errors(r[:, :n], r[:, n:], length)
        sure = np.argsort(np.trace(errors.cov, axis1=1, axis2=2), kind="stable")
        return Placings(source[sure], frames, way[sure], slope[sure[0]], Errors(*(each[sure] for each in errors)))

    def phase_variance(self, frames: Ints) -> Floats:
        """(N) of the phase at frames in a row, cycles²; worked out at a few of them."""
        few = np.linspace(frames[0], frames[-1], min(FEW, len(frames))).round().astype(np.int64)
        return np.interp(frames, few, variance_at(self._information, few, cycle=self.cycle))

    @cached_property
    def _information(self) -> Floats:
        """(F) what the segments that tell most say of the phase."""
        thin = self.xyz[:, :: max(1, self.xyz.shape[1] // LONG)]
        some = most_moving(columns(thin, self.model.links))
        gone = np.isnan(self.xyz[..., 0])[self.model.links[some // 3].T]
        there = ~(gone[0] | gone[1]).T
        return information(there, self._curve.select(some), self._spread[some], self.phase.cycles, cycle=self.cycle)

    @cached_property
    def _weight(self) -> Floats:
        """(M, F) w of (3) of markers; a segment's is the lesser of its ends'."""
        return taper(~np.isnan(self.xyz[..., 0]), self.cycle / 10)

    @cached_property
    def _usual_others(self) -> Any:
        return self._others[self._usual] if self._moments else None

    @cached_property
    def _others(self) -> Any:
        """Weights (F, F) of the sum of (3): a sparse matrix."""
        n_frames = self.xyz.shape[1]
        place = CycleInterpolation.at(np.concatenate(self._moments), n_frames)
        weight = np.nan_to_num(np.where(np.isnan(place.cubic), place.line, place.cubic))
        return weights(weight.reshape(-1, n_frames), place.frame.reshape(-1, n_frames), n_frames)

    def _bank(self, number: int) -> _Bank:
        """What is the same for all markers of a bank, worked out once."""
        if number not in self._banks:
            rows = np.flatnonzero(self.model.bank == number)
            link = self.model.links[rows]
            seen = columns(self.xyz, link)
            seen[np.isnan(seen)] = 0.0
            weight = np.ascontiguousarray(self._weight[link].min(1).T)
            weighted = seen * np.repeat(weight, 3, axis=1)
            curve, seen = self._curve.select(_columns_of(rows)), seen.reshape(len(seen), -1, 3)
            bank = _Bank(rows, link, curve, seen, weight, weighted, np.zeros(0), np.zeros(0, np.bool_))
            d, alone = self._directions(bank, self._usual, self._usual_others)
            self._banks[number] = bank._replace(d=d, alone=alone)
        return self._banks[number]

    def _ways(self, marker: int, bank: _Bank, frames: Ints, others: Any) -> _Ways:
        """From the neighbours of one bank."""
        at, n = np.concatenate([self._usual, frames]), len(self._usual)
        here = self._directions(bank, frames, others)
        d, alone = (np.concatenate(both) for both in zip((bank.d, bank.alone), here, strict=True))
        own = np.flatnonzero((bank.link == marker).any(1))
        last = bank.link[own, 1] == marker
        source, length = bank.link[own, np.where(last, 0, 1)], self.model.length[bank.rows[own]]
        ahead = np.where(last, length, -length)[:, None]
        curve = self._curve.select(_columns_of(bank.rows[own]))
        way = ahead * d[:, own]
        slope = ahead * curve.slope(self.phase.cycles[frames]).reshape(len(frames), -1, 3)
        R = self._turn(marker, bank, d, at)
        if R is not None:
            way, slope = way @ R.mT, slope @ R[n:].mT
        way = way.swapaxes(0, 1)
        r = self.xyz[marker, at] - self.xyz[source[:, None], at] - way
        r[alone[:, own].T] = np.nan  # the model there is this very cycle
        return _Ways(source, length, r, way[:, n:], slope.swapaxes(0, 1))

    def _directions(self, bank: _Bank, frames: Ints, others: Any) -> tuple[Floats, Bools]:
        """d(φ) (N, R, 3) of the model, or by (3) of the trial; of the model, too, where no other cycle has it.

        And where (N, R) that is so although the segment is seen.
        """
        cycles, shape = self.phase.cycles[frames], (len(frames), len(bank.rows), 3)
        if others is None:
            return bank.curve(cycles).reshape(shape), np.zeros(shape[:2], np.bool_)
        d = (others @ bank.weighted).reshape(shape)
        size = np.sqrt(np.einsum("nri,nri->nr", d, d))
        alone = np.minimum(others @ bank.weight, size) < SURE  # size: cycles that contradict each other, too
        d /= np.maximum(size, 1e-6)[..., None]
        some = np.flatnonzero(alone.any(1))
        d[some] = np.where(alone[some, :, None], bank.curve(cycles[some]).reshape(-1, *shape[1:]), d[some])
        alone[some] &= bank.seen[frames[some]].any(2)
        return d, alone

    def _turn(self, marker: int, bank: _Bank, d: Floats, frames: Ints) -> Floats | None:
        """(N, 3, 3) R of (2) for a bank; None where it has no pair but those of the marker."""
        other = (bank.link != marker).all(1)
        if not other.any():
            return None
        weight = np.where(other, (self.model.length[bank.rows] / SKIN) ** 2, 0.0)[:, None]
        return polar_rotations((weight * bank.seen[frames]).mT @ d + np.eye(3) / TURN**2)

    def _errors(self, usual: Floats, r: Floats, length: Floats) -> Errors:
        """Of r (K, N, 3), by what it is in the frames of `_usual`; a guess where these are too few."""
        usual = np.ascontiguousarray(usual.swapaxes(1, 2))  # (K, 3, U)
        there = ~np.isnan(usual[:, 0])
        n = there.sum(1)
        mean = np.where(there[:, None], usual, 0.0).sum(2) / np.maximum(n, 1)[:, None]
        deviation = np.where(there[:, None], usual - mean[..., None], 0.0)
        cov = deviation @ deviation.mT / np.maximum(n - 1, 1)[:, None, None] + 1e-6 * np.eye(3)
        spaced = np.full((len(usual), 3, self._apart[-1] + 1), np.nan)
        spaced[..., self._apart] = usual
        noise = np.sqrt((measurement_sd_of(spaced.reshape(3 * len(usual), -1)) ** 2).reshape(-1, 3).mean(1))
        both = there[:, self._now] & there[:, self._then]
        tau = correlation_time(deviation[..., self._now], deviation[..., self._then], both, self._lag, noise)
        few = n < FEWEST
        mean[few], cov[few] = 0.0, np.eye(3) * ((UNKNOWN * length[few]) ** 2)[:, None, None]
        tau[few], noise[few] = self.cycle / 10, 0.0
        return Errors(r, mean, cov, tau, noise)


def _columns_of(rows: Ints) -> Ints:
    """Of the model's curve."""
    return (3 * rows[:, None] + np.arange(3)).ravel()


def _runs(n_frames: int, lag: int) -> Ints:
    """The frames from which errors are judged: all of a short trial, else runs of `RUN`, in pairs `lag` apart."""
    if n_frames <= MOST:
        return np.arange(n_frames)
    first = np.linspace(0, max(n_frames - RUN - lag, 0), MOST // (5 * RUN)).astype(np.int64)
    frames = np.unique(first[:, None, None] + np.array([0, lag])[:, None] + np.arange(RUN))
    return frames[frames < n_frames]


def _moments(phase: CyclePhase) -> list[Floats]:
    """t_m (F) of (3) for the other cycles, frames; NaN where there is none."""
    rising = np.maximum.accumulate(phase.cycles)
    frames = np.arange(len(rising))
    others = [m for m in range(-OTHERS, OTHERS + 1) if m]
    return [np.interp(rising + m, rising, frames, left=np.nan, right=np.nan) for m in others]


def taper(there: Bools, reach: float) -> Floats:
    """(M, F) w of (3): 1, falling to 0 within `reach` frames of what is not there, and of the ends."""
    n = there.shape[1]
    frames = np.arange(n)
    before = np.maximum.accumulate(np.where(there, -1, frames), axis=1)
    after = np.minimum.accumulate(np.where(there, n, frames)[:, ::-1], axis=1)[:, ::-1]
    return np.minimum(np.minimum(frames - before, after - frames) / max(reach, 1.0), 1.0)


def correlation_time(now: Floats, then: Floats, both: Bools, lag: int, noise: Floats) -> Floats:
    """(K) τ of (5), frames, from the correlation of r (K, 3, N), 0 where unknown, with what it is `lag` frames on, both
    (K, N) known; its noise (K) left out."""
    n = both.sum(1)
    product = np.einsum("kin,kin->k", now, then)
    square = ((now**2 + then**2).sum(1) * both).sum(1) / 2
    rho = np.clip(product / np.maximum(square - 3 * noise**2 * n, 1e-9), 0.05, 0.99)
    return np.where(n < FEWEST, 2.0 * lag, lag / np.interp(-rho, FALLING, LAGS))


def correlation(frames: NDArray[Any], tau: Floats) -> Floats:
    """(K, …) c of (5) for differences of time (…), frames, and each τ (K)."""
    x = np.abs(frames) / tau.reshape(-1, *(1,) * frames.ndim)
    return np.asarray((1 + x) * np.exp(-x))
