"""Where the model puts a marker, seen from each of its neighbours (Swamidas 1997, 3.5.2), and how far off that is.

For a segment of length ℓ from marker i to marker k with the model's direction d(φ),

    x_k = x_i + ℓ R d(φ(t)),   x_i = x_k − ℓ R d(φ(t))                                           (1)

R turns the model's bank to the markers of it that are seen. With observed directions u_s and the model's d_s of the
pairs s seen, without those of k itself, it is the rotation that makes tr(Rᵀ B) greatest,

    B = Σ_s (ℓ_s / σ)² u_s d_sᵀ + I / a²                                                         (2)

(Wahba 1965.) σ is what markers on skin move within a bank, a the spread of the
model's angles: the second term asks for no turn. One formula serves all banks: with no pair seen R = I, which is the
thesis; with one, the bank is swung into its line, by the shortest way; with two or more R is the pose of a rigid
body.

Where the model is made of the trial itself, d(φ(t)) for the frame t is not the mean of all cycles but that of the
other ones, up to three
before and three after: with t_m the moment at which φ(t_m) = φ(t) + m,

    d(t) ∝ Σ_m≠0 w_m u(t_m)                                                                      (3)

A mean with t's own cycle in it would be pulled to what it is to be compared with. w is 1, and falls to 0 within a
tenth of a cycle where u is about to be missing, so that d has no steps. The error of (1) is known wherever k and i
are both seen:

    r(t) = x_k − x_i − ℓ R d                                                                     (4)

Its mean r̄, covariance S and how long it lasts are taken over the whole trial, in runs of frames where it is long. r is
likened to a process of
covariance S c(Δt), c(Δt) = (1 + Δt / τ) exp(−Δt / τ) (5); τ is where the correlation found at a tenth of a cycle puts
it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data import AngleModel
from ...geometry import nearest_rotations
from ...signal.phase import Phase, Template, phase_variance
from ...signal.smoother import noise_of
from .connect import directions
from .learn import Between, telling, template_of, weights

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]

SKIN = 3.0
"""σ of (2), mm."""
TURN = 0.1
"""a of (2), rad."""
OTHERS = 3
"""Cycles before, and after, of (3)."""
FEWEST = 10
"""Frames that must tell of r."""
MOST = 1500
"""Frames of a trial above which r is judged in runs of them, spread over the trial: neighbours say the same."""
RUN = 7
"""Frames in a row that tell its noise."""
APART = 6
"""Frames unknown that keep runs from being taken for one."""
FEW = 9
"""Frames of a gap at which the phase's variance is worked out."""
UNKNOWN = 0.05
"""Spread of (1) as a share of ℓ, where r is not known."""
LAGS = np.linspace(0.01, 6, 600)
FALLING = -(1 + LAGS) * np.exp(-LAGS)
"""−c of (5) at these Δt / τ, rising."""


class Errors(NamedTuple):
    """Of one segment and marker: r (N, 3) mm of (4) in the frames of the placing, NaN where not both are seen; mean
    (3) r̄; cov (3, 3) S, mm²; tau frames; noise mm, what of r differs from frame to frame."""

    r: Floats
    mean: Floats
    cov: Floats
    tau: float
    noise: float


class Placing(NamedTuple):
    """Marker k from its neighbour `source` in N frames, rising: way (N, 3) mm from there by (1), slope (N, 3) mm a
    cycle, and how far off it is."""

    source: int
    frames: Ints
    way: Floats
    slope: Floats
    errors: Errors


class _Bank(NamedTuple):
    """The R segments of a bank: rows of the model; curve, their directions by the phase; weighted (F, 3 R), the
    directions seen with the weights of (3); and in the frames from which errors are judged, d and alone of
    `_directions`."""

    rows: Ints
    curve: Template
    weighted: Floats
    d: Floats
    alone: Bools


class Placer:
    """Places markers of a trial by a model.

    Attributes:
        xyz: (M, F, 3) mm, NaN where missing.
        model: with links between these markers.
        cycle: frames.
        phase: of the trial's frames.
    """

    def __init__(self, xyz: Floats, model: AngleModel, phase: Phase, *, cycle: float, own: bool) -> None:
        self.xyz, self.phase, self.cycle = xyz, phase, cycle
        self.model, self._moments = model, _moments(phase) if own else []
        self._seen = np.ascontiguousarray(directions(xyz, model.links).transpose(1, 0, 2))  # (F, S, 3)
        y = self._seen.reshape(len(self._seen), -1)
        self._telling = telling(y)
        self._telling_seen, self._spread = y[:, self._telling], template_of(model)[1][self._telling]
        self._curve = _rows_of(model, self._telling[::3] // 3)
        self._lag = max(round(cycle / 10), 1)
        self._usual = _runs(xyz.shape[1], self._lag)
        self._usual_others = self._others(self._usual)
        self._apart = np.arange(len(self._usual)) + APART * np.cumsum(np.diff(self._usual, prepend=self._usual[0]) > 1)
        then = np.searchsorted(self._usual, self._usual + self._lag).clip(max=len(self._usual) - 1)
        self._now = np.flatnonzero(self._usual[then] == self._usual + self._lag)
        self._then = then[self._now]
        self._banks: dict[int, _Bank] = {}

    def __call__(self, marker: int, frames: Ints) -> list[Placing]:
        """All neighbours from which a marker can be placed in these frames, rising, the surest first."""
        rows, others = np.flatnonzero((self.model.links == marker).any(1)), self._others(frames)
        banks = [self._bank(int(number)) for number in np.unique(self.model.bank[rows])]
        found = [p for bank in banks for p in self._placings(marker, bank, frames, others)]
        return sorted(found, key=lambda p: float(np.trace(p.errors.cov)))

    def phase_variance(self, frames: Ints) -> Floats:
        """(N) of the phase at frames in a row, cycles²; worked out at a few of them."""
        few = np.unique(np.linspace(frames[0], frames[-1], FEW).round().astype(np.int64))
        first = max(int(few[0] - self.cycle), 0)
        near = slice(first, int(few[-1] + self.cycle) + 1)
        y, cycles = self._telling_seen[near], self.phase.cycles[near]
        found = phase_variance(y, self._curve, self._spread, cycles, few - first, cycle=self.cycle)
        return np.interp(frames, few, found)

    def _bank(self, number: int) -> _Bank:
        """What is the same for all markers of a bank, worked out once."""
        if number not in self._banks:
            rows = np.flatnonzero(self.model.bank == number)
            seen = self._seen[:, rows]
            weight = np.stack([taper(~np.isnan(u[:, 0]), self.cycle / 10) for u in seen.swapaxes(0, 1)], 1)
            weighted = np.nan_to_num(weight[..., None] * seen).reshape(len(seen), -1)
            bank = _Bank(rows, _rows_of(self.model, rows), weighted, np.zeros(0), np.zeros(0, np.bool_))
            d, alone = self._directions(bank, self._usual, self._usual_others)
            self._banks[number] = bank._replace(d=d, alone=alone)
        return self._banks[number]

    def _placings(self, marker: int, bank: _Bank, frames: Ints, others: Any) -> list[Placing]:
        """From the neighbours of one bank; the frames of `_usual` come first, to tell how far off it is."""
        rows, at, n = bank.rows, np.concatenate([self._usual, frames]), len(self._usual)
        here = self._directions(bank, frames, others)
        d, alone = (np.concatenate(both) for both in zip((bank.d, bank.alone), here, strict=True))
        slopes = bank.curve.slope(self.phase.cycles[frames]).reshape(len(frames), -1, 3)
        R = self._turn(marker, rows, d, at)
        out = []
        for k in np.flatnonzero((self.model.links[rows] == marker).any(1)):
            a, b = self.model.links[rows[k]]
            source, sign = (int(a), 1.0) if b == marker else (int(b), -1.0)
            length = sign * float(self.model.length[rows[k]])
            way, slope = length * d[:, k], length * slopes[:, k]
            if R is not None:
                way, slope = (R @ way[..., None])[..., 0], (R[n:] @ slope[..., None])[..., 0]
            r = self.xyz[marker, at] - self.xyz[source, at] - way
            r[alone[:, k]] = np.nan  # the model there is this very cycle
            out.append(Placing(source, frames, way[n:], slope, self._errors(r[:n], r[n:], abs(length))))
        return out

    def _others(self, frames: Ints) -> Any:
        """Weights (N, F) of the sum of (3): a sparse matrix; None where the model is not made of the trial."""
        if not self._moments:
            return None
        place = Between.at(np.stack([m[frames] for m in self._moments]).ravel(), self.xyz.shape[1])
        weight = np.nan_to_num(np.where(np.isnan(place.cubic), place.line, place.cubic)).reshape(-1, len(frames))
        return weights(weight, place.frame.reshape(-1, len(frames)), self.xyz.shape[1])

    def _directions(self, bank: _Bank, frames: Ints, others: Any) -> tuple[Floats, Bools]:
        """d(φ) (N, R, 3) of the model, or by (3) of the trial; of the model, too, where no other cycle has it.

        And where (N, R) that is so although the segment is seen.
        """
        cycles, shape = self.phase.cycles[frames], (len(frames), len(bank.rows), 3)
        if others is None:
            return bank.curve(cycles).reshape(shape), np.zeros(shape[:2], np.bool_)
        d = (others @ bank.weighted).reshape(shape)
        size = np.sqrt(np.einsum("nri,nri->nr", d, d))
        alone = size < 1e-6
        d /= np.maximum(size, 1e-6)[..., None]
        at, row = np.nonzero(alone)
        some, at_some = np.unique(at, return_inverse=True)
        d[at, row] = bank.curve(cycles[some]).reshape(-1, *shape[1:])[at_some, row]
        alone[at, row] = ~np.isnan(self._seen[frames[at], bank.rows[row], 0])
        return d, alone

    def _turn(self, marker: int, rows: Ints, d: Floats, frames: Ints) -> Floats | None:
        """(N, 3, 3) R of (2) for a bank of these rows; None where it has no pair but those of the marker."""
        other = (self.model.links[rows] != marker).all(1)
        if not other.any():
            return None
        rows, d = rows[other], np.nan_to_num(d[:, other])
        u = np.nan_to_num(self._seen[frames[:, None], rows]) * (self.model.length[rows, None] / SKIN) ** 2
        return nearest_rotations(u.mT @ d + np.eye(3) / TURN**2)

    def _errors(self, usual: Floats, r: Floats, length: float) -> Errors:
        """Of r (N, 3), by what it is in the frames of `_usual`, or in all there are where these are too few."""
        there = ~np.isnan(usual).any(1)
        if there.sum() < FEWEST:
            return Errors(r, np.zeros(3), np.eye(3) * (UNKNOWN * length) ** 2, self.cycle / 10, 0.0)
        mean, cov = usual[there].mean(0), np.cov(usual[there].T) + 1e-6 * np.eye(3)
        spaced = np.full((3, self._apart[-1] + 1), np.nan)
        spaced[:, self._apart] = usual.T
        noise = float(np.sqrt((noise_of(spaced) ** 2).mean()))
        off = usual - mean
        return Errors(r, mean, cov, lasting(off[self._now], off[self._then], self._lag, noise), noise)


def _rows_of(model: AngleModel, rows: Ints) -> Template:
    """The directions of some of the model's segments as a template."""
    return Template(model.direction[rows].swapaxes(0, 1).reshape(model.direction.shape[1], -1))


def _runs(n_frames: int, lag: int) -> Ints:
    """The frames from which errors are judged: all of a short trial, else runs of `RUN`, in pairs `lag` apart."""
    if n_frames <= MOST:
        return np.arange(n_frames)
    first = np.linspace(0, n_frames - RUN - lag, MOST // (5 * RUN)).astype(np.int64)
    return np.unique(first[:, None, None] + np.array([0, lag])[:, None] + np.arange(RUN))


def _moments(phase: Phase) -> list[Floats]:
    """t_m (F) of (3) for the other cycles, frames; NaN where there is none."""
    rising = np.maximum.accumulate(phase.cycles)
    frames = np.arange(len(rising))
    others = [m for m in range(-OTHERS, OTHERS + 1) if m]
    return [np.interp(rising + m, rising, frames, left=np.nan, right=np.nan) for m in others]


def taper(there: Bools, reach: float) -> Floats:
    """(F) w of (3): 1, falling to 0 within `reach` frames of what is not there, and of the ends."""
    away = np.flatnonzero(np.concatenate([[True], ~there, [True]])) - 1
    frames = np.arange(len(there))
    after = np.searchsorted(away, frames)
    distance = np.minimum(away[after.clip(0, len(away) - 1)] - frames, frames - away[(after - 1).clip(0)])
    return np.where(there, np.clip(distance / max(reach, 1.0), 0.0, 1.0), 0.0)


def lasting(now: Floats, then: Floats, lag: int, noise: float) -> float:
    """τ of (5), frames, from the correlation of r (N, 3) with what it is `lag` frames on, its noise left out."""
    both = ~(np.isnan(now) | np.isnan(then)).any(1)
    if both.sum() < FEWEST:
        return 2.0 * lag
    product, square = float((now[both] * then[both]).sum()), float(((now[both] ** 2 + then[both] ** 2) / 2).sum())
    rho = np.clip(product / max(square - 3 * noise**2 * both.sum(), 1e-9), 0.05, 0.99)
    return lag / float(np.interp(-rho, FALLING, LAGS))


def correlation(frames: NDArray[Any], tau: float) -> Floats:
    """c of (5) for differences of time, frames."""
    x = np.abs(frames) / tau
    return np.asarray((1 + x) * np.exp(-x))
