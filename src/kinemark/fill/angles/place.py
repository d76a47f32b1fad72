"""Where the model puts a marker, seen from each of its neighbours (Swamidas 1997, 3.5.2), and how far off that is.

For a segment of length ℓ from marker i to marker k with the model's direction d(φ),

    x_k = x_i + ℓ R d(φ(t)),   x_i = x_k − ℓ R d(φ(t))                                           (1)

R turns the model's bank to the markers of it that are seen. With observed directions u_s and the model's d_s of the
pairs s seen, without those of k itself, it is the rotation that makes tr(Rᵀ B) greatest,

    B = Σ_s (ℓ_s / σ)² u_s d_sᵀ + I / a²                                                         (2)

(Wahba 1965; by singular value decomposition.) σ is what markers on skin move within a bank, a the spread of the
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

Its mean r̄, covariance S and how long it lasts are taken over the whole trial. r is likened to a process of
covariance S c(Δt), c(Δt) = (1 + Δt / τ) exp(−Δt / τ) (5); τ is where the correlation found at a tenth of a cycle puts
it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data import AngleModel
from ...signal.phase import Phase, Template, phase_variance
from ...signal.smoother import noise_of
from .connect import directions
from .learn import Between, template_of

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
FEW = 9
"""Frames of a gap at which the phase's variance is worked out."""
UNKNOWN = 0.05
"""Spread of (1) as a share of ℓ, where r is not known."""


class Errors(NamedTuple):
    """Of one segment and marker: r (F, 3) mm of (4), NaN where not both are seen; mean (3) r̄; cov (3, 3) S, mm²; tau
    frames; noise mm, what of r differs from frame to frame."""

    r: Floats
    mean: Floats
    cov: Floats
    tau: float
    noise: float


class Placing(NamedTuple):
    """Marker k from its neighbour `source`: way (F, 3) mm from there by (1), slope (F, 3) mm a cycle, and how far off
    it is."""

    source: int
    way: Floats
    slope: Floats
    errors: Errors


class Placer:
    """Places markers of a trial by a model, and remembers what it has worked out for each.

    Attributes:
        xyz: (M, F, 3) mm, NaN where missing.
        model: with links between these markers.
        cycle: frames.
        phase: of the trial's frames.
    """

    def __init__(self, xyz: Floats, model: AngleModel, phase: Phase, *, cycle: float, own: bool) -> None:
        self.xyz, self.phase, self.cycle = xyz, phase, cycle
        self.model, self._moments = model, _moments(phase) if own else []
        self._curve = Template(model.direction.swapaxes(0, 1).reshape(model.direction.shape[1], -1))
        self._known: dict[int, list[Placing]] = {}
        self._directions: dict[int, Floats] = {}
        self._alone: dict[int, Bools] = {}
        self._seen = directions(xyz, model.links).transpose(1, 0, 2).reshape(xyz.shape[1], -1)
        self._spread = template_of(model)[1]

    def __call__(self, marker: int) -> list[Placing]:
        """All neighbours from which a marker can be placed, the surest first."""
        if marker not in self._known:
            rows = np.flatnonzero((self.model.links == marker).any(1))
            found = [p for row in rows if (p := self._placing(marker, int(row))) is not None]
            self._known[marker] = sorted(found, key=lambda p: float(np.trace(p.errors.cov)))
        return self._known[marker]

    def phase_variance(self, frames: Ints) -> Floats:
        """(N) of the phase at frames in a row, cycles²; worked out at a few of them."""
        few = np.unique(np.linspace(frames[0], frames[-1], FEW).round().astype(np.int64))
        found = phase_variance(self._seen, self._curve, self._spread, self.phase.cycles, few, cycle=self.cycle)
        return np.interp(frames, few, found)

    def _placing(self, marker: int, row: int) -> Placing | None:
        a, b = self.model.links[row]
        source, sign = (int(a), 1.0) if b == marker else (int(b), -1.0)
        length = sign * self.model.length[row]
        slope = length * self._own_curve(row).slope(self.phase.cycles)
        way = length * self._direction(row)
        R = self._turn(marker, int(self.model.bank[row]))
        if R is not None:
            way, slope = ((R @ v[..., None])[..., 0] for v in (way, slope))
        r = self.xyz[marker] - self.xyz[source] - way
        if row in self._alone:
            r[self._alone[row]] = np.nan  # the model there is this very cycle
        return Placing(source, way, slope, self._errors(r, abs(float(length))))

    def _direction(self, row: int) -> Floats:
        """(F, 3) d(φ) of the model, or by (3) of the trial; of the model, too, where no other cycle has it."""
        if row not in self._directions:
            self._directions[row] = self._of_others(row) if self._moments else self._of_model(row)
        return self._directions[row]

    def _of_model(self, row: int) -> Floats:
        return self._own_curve(row)(self.phase.cycles)

    def _own_curve(self, row: int) -> Template:
        return Template(self.model.direction[row])

    def _of_others(self, row: int) -> Floats:
        u = self._seen[:, 3 * row : 3 * row + 3]
        weight = taper(~np.isnan(u[:, 0]), self.cycle / 10)
        total, known = np.zeros_like(u), np.column_stack([u, weight])
        for moment in self._moments:
            there = np.nan_to_num(moment.read(known))
            total += there[:, 3:] * there[:, :3]
        size = np.linalg.norm(total, axis=1, keepdims=True)
        alone = size[:, 0] < 1e-6
        self._alone[row] = alone & (weight > 0)
        return np.where(alone[:, None], self._of_model(row), total / np.maximum(size, 1e-6))

    def _turn(self, marker: int, bank: int) -> Floats | None:
        """(F, 3, 3) R of (2); None where the bank has no pair but those of the marker."""
        rows = np.flatnonzero((self.model.bank == bank) & (self.model.links != marker).all(1))
        if not len(rows):
            return None
        d = np.nan_to_num(np.stack([self._direction(int(row)) for row in rows], 1))
        way = (self.xyz[self.model.links[rows, 1]] - self.xyz[self.model.links[rows, 0]]).swapaxes(0, 1)
        there = ~np.isnan(way).any(-1, keepdims=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            u = np.where(there, way / np.linalg.norm(way, axis=-1, keepdims=True), 0.0)
        u = np.nan_to_num(u) * (self.model.length[rows, None] / SKIN) ** 2
        B = np.einsum("fsi,fsj->fij", u, d) + np.eye(3) / TURN**2
        U, _, Vt = np.linalg.svd(B)
        U[..., -1] *= np.sign(np.linalg.det(U @ Vt))[:, None]
        return np.asarray(U @ Vt)

    def _errors(self, r: Floats, length: float) -> Errors:
        seen = r[~np.isnan(r).any(1)]
        if len(seen) < FEWEST:
            return Errors(r, np.zeros(3), np.eye(3) * (UNKNOWN * length) ** 2, self.cycle / 10, 0.0)
        mean, cov = seen.mean(0), np.cov(seen.T) + 1e-6 * np.eye(3)
        noise = float(np.sqrt((noise_of(r.T) ** 2).mean()))
        lag = max(round(self.cycle / 10), 1)
        return Errors(r, mean, cov, lasting(r - mean, lag, noise), noise)


def _moments(phase: Phase) -> list[Between]:
    """t_m (F) of (3) for the other cycles."""
    rising = np.maximum.accumulate(phase.cycles)
    frames = np.arange(len(rising))
    others = [m for m in range(-OTHERS, OTHERS + 1) if m]
    moments = (np.interp(rising + m, rising, frames, left=np.nan, right=np.nan) for m in others)
    return [Between.at(moment, len(rising)) for moment in moments]


def taper(there: Bools, reach: float) -> Floats:
    """(F) w of (3): 1, falling to 0 within `reach` frames of what is not there, and of the ends."""
    away = np.flatnonzero(np.concatenate([[True], ~there, [True]])) - 1
    frames = np.arange(len(there))
    after = np.searchsorted(away, frames)
    distance = np.minimum(away[after.clip(0, len(away) - 1)] - frames, frames - away[(after - 1).clip(0)])
    return np.where(there, np.clip(distance / max(reach, 1.0), 0.0, 1.0), 0.0)


def lasting(r: Floats, lag: int, noise: float) -> float:
    """τ of (5), frames, from the correlation of r (F, 3) with itself `lag` frames on, its noise left out."""
    now, then = r[:-lag], r[lag:]
    both = ~(np.isnan(now) | np.isnan(then)).any(1)
    if both.sum() < FEWEST:
        return 2.0 * lag
    product, square = float((now[both] * then[both]).sum()), float(((now[both] ** 2 + then[both] ** 2) / 2).sum())
    rho = np.clip(product / max(square - 3 * noise**2 * both.sum(), 1e-9), 0.05, 0.99)
    x = np.linspace(0.01, 6, 600)
    return lag / float(np.interp(-rho, -(1 + x) * np.exp(-x), x))


def correlation(frames: NDArray[Any], tau: float) -> Floats:
    """c of (5) for differences of time, frames."""
    x = np.abs(frames) / tau
    return np.asarray((1 + x) * np.exp(-x))
