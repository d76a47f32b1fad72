"""A marker from the pose of the body part around it and from its own past and future: kriging in a local frame.

Three donors carry a local frame (R, c) (`triad`). In it the marker is a function of the pose φ, the donors' local
coordinates, and a remainder that drifts in time (soft tissue, what the donors do not tell):

    Rᵀ(y − c)(t) = a + f(φ(t)) + r(t) + noise                                                             (1)

All three are Gaussian processes, so that the marker in a gap given all that is seen is a matter of linear algebra
(Rasmussen & Williams 2006, 2.2 and 2.7; regression kriging: Hengl et al. 2007). With τ² in common the covariance of two
frames t, t' is

    k = λ P(φ, φ') + M(|t − t'|/ℓ) + C + ν δ                                                              (2)
    P = φ·φ' + 1/(1 + NARROW |φ − φ'|²/2)                                                                 (3)

P lets f be linear and bend, in short and long waves (a rational quadratic, R & W 4.19); M is Matérn's covariance of
order 3/2, which ties the fill to what is seen at the edges of the gap; C, great, leaves a free. Donor d, ranked by how
little its distance from the marker varies (0 the least), enters φ with its coordinates divided by their spread and by
√(1 + rank). How the part is turned in space matters too, as what is soft hangs: A = R̄ᵀR, R̄ the rotation nearest to the
mean of R, less its mean, enters with TURN of the size that the donors' coordinates have together. φ is scaled to about
unit mean square (4).

Left and right are alike. The mirrored trial (`mirror`) is a second source s of the same function, but not the same one,
as markers are never put on quite alike:

    k = λ P · ρ^[s ≠ s'] + (M + C)[s = s'] + ν δ                                                          (5)

with coordinates less the mean of their own source. λ, ℓ, ν, ρ are those of a small grid under which what is seen of
the marker is most likely (R & W 5.8), found one after the other; ρ = 0 sets the mirror aside. With K over the n frames
learnt from and the vectors k of the frames wanted

    τ² = yᵀK⁻¹y / n,     y* = kᵀK⁻¹y,     var y* = τ²(k* − kᵀK⁻¹k)                                        (6)

for each local coordinate. Which three donors carry the frame matters: several bases are tried, and the mean of the most
likely ones is taken, of their covariances too (7). A donor that is not seen throughout the gap is not used.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from .frames import local, triad
from .local_regression import ranked
from .mirror import REFLECTED, partners
from .motion import Floats, Gap, Motion, Prediction

Ints = NDArray[np.int64]
FEWEST = 8
"""Frames to learn from, at least."""
EDGE = 3
"""Frames beside a gap that are all used; further away they are thinned to `hz`."""
NARROW = 3.0
TURN = 0.3
STILL = 0.01
"""Turns, in radians, below which they are noise."""
FEW = 4
"""Gaps that λ, ℓ, ν and ρ of a trial are found from."""
SHARED = (-1, b"")
GRID = {"lam": (3.0, 50.0), "ell": (0.05, 0.3), "nu": (0.01, 0.1), "rho": (0.0, 0.5, 0.9, 0.98)}
"""What is tried for λ, ℓ (s), ν and ρ."""


@dataclass(frozen=True, slots=True)
class Body:
    """Kriging on the pose of the donors, in local frames, with the mirrored side as a second source.

    Attributes:
        donors: at most so many.
        bases: triples of the first donors that are tried as carriers of the local frame.
        kept: of them, how many of the likeliest are averaged.
        frames: to learn from at most; half of them beside the gap, half all over the trial.
        hz: how densely frames are taken.
        mirror: learn from the other side of the body too.
        shared: λ, ℓ, ν and ρ are those of the trial, found from a few of its gaps, not each marker's own.
    """

    donors: int = 16
    bases: int = 6
    kept: int = 3
    frames: int = 120
    hz: float = 30.0
    mirror: bool = True
    shared: bool = False

    def __post_init__(self) -> None:
        for name, least in (("donors", 3), ("bases", 1), ("kept", 1), ("frames", FEWEST)):
            if getattr(self, name) < least:
                raise ValueError(f"{name} is {getattr(self, name)}, wanted at least {least}")
        if not self.hz > 0:
            raise ValueError(f"hz is {self.hz}, wanted above 0")


class Hyper(NamedTuple):
    """λ, ℓ in seconds, ν and ρ of (2) and (5)."""

    lam: float = 50.0
    ell: float = 0.3
    nu: float = 0.01
    rho: float = 0.9


class Scene(NamedTuple):
    """What is looked at for one gap: n frames to learn from, then L to fill.

    Attributes:
        xyz: (1 + D, n + L, 3) mm, the marker first, then the donors.
        apart: (n + L, n) s between frames.
        same: (n + L, n) of the same source.
        n: frames to learn from.
        side: (n + L) source of each frame.
    """

    xyz: Floats
    apart: Floats
    same: NDArray[np.bool_]
    n: int
    side: Ints


class View(NamedTuple):
    """A scene in one local frame: R, c of all frames, y (n, 3) and its means by source, P (n + L, n), P of a frame
    with itself (n + L).
    """

    R: Floats
    c: Floats
    y: Floats
    mean: Floats
    P: Floats
    own: Floats


class Fit(NamedTuple):
    """What (6) needs: log-likelihood, k (n + L, n), prior variance (n + L), factor, K⁻¹y, τ² (3)."""

    likely: float
    k: Floats
    prior: Floats
    factor: tuple[Floats, bool]
    weights: Floats
    tau2: Floats


class _Trial(NamedTuple):
    motion: Motion
    seen: NDArray[np.bool_]
    partner: Ints
    ranks: dict[int, Ints]
    hypers: dict[tuple[int, bytes], Hyper]
    looks: list[tuple[Scene, View]]


def fill_body(motion: Motion, gaps: list[Gap], *, method: Body) -> list[Prediction]:
    """Each gap by (6); gaps of one marker with the same donors share λ, ℓ, ν, ρ."""
    partner = partners(motion.names) if method.mirror else np.arange(len(motion.names))
    trial = _Trial(motion, motion.seen, partner, {}, {}, [])
    return [_fill(trial, gap, method) for gap in gaps]


def _fill(trial: _Trial, gap: Gap, method: Body) -> Prediction:
    donors = _donors(trial, gap, method.donors)
    if len(donors) < 3:
        return Prediction.none(gap.length, f"only {len(donors)} other markers are seen throughout the gap; wanted 3")
    scene = _scene(trial, gap, donors, method)
    if scene is None:
        return Prediction.none(gap.length, f"fewer than {FEWEST} frames show the marker together with its donors")
    views = [view for base in _bases(len(donors), method.bases) if (view := _view(scene, base))]
    if not views:
        return Prediction.none(gap.length, "the donors stand on one line or in one point: they carry no local frame")
    hyper = _hyper(trial, (gap.marker, donors.tobytes()), scene, views[0], method)
    fits = [_fit(scene, view, hyper) for view in views]
    best = np.argsort([-fit.likely for fit in fits])[: method.kept]
    said = [_predict(scene, views[k], fits[k]) for k in best]
    xyz, cov = (np.mean([s[i] for s in said], axis=0) for i in (0, 1))  # (7)
    return Prediction(xyz, cov, donors=tuple(int(d) for d in donors))


def _donors(trial: _Trial, gap: Gap, most: int) -> Ints:
    """The first of the ranked markers that are seen throughout the gap, and leave most frames to learn from."""
    motion, marker = trial.motion, gap.marker
    if marker not in trial.ranks:
        trial.ranks[marker] = ranked(motion, marker)
    thin = trial.seen[:, :: max(1, trial.seen.shape[1] // 400)]
    chosen: list[int] = []
    together = thin[marker]
    ready: NDArray[np.bool_] = np.logical_and.reduce(trial.seen[:, gap.start : gap.stop], axis=1)
    n = np.count_nonzero(together)
    for donor in trial.ranks[marker][ready[trial.ranks[marker]]]:
        if len(chosen) == most:
            break
        both = together & thin[donor]
        if (left := np.count_nonzero(both)) >= 0.8 * n:
            together, n = both, left
            chosen.append(int(donor))
    return np.array(chosen, np.int64)


@cache
def _bases(donors: int, n: int) -> list[tuple[int, int, int]]:
    """n triples of donors, of the lowest ranks first; the marker itself is row 0 of the scene."""
    triples = combinations(range(1, donors + 1), 3)
    return sorted(triples, key=lambda t: (max(t), sum(t)))[:n]


def _scene(trial: _Trial, gap: Gap, donors: Ints, method: Body) -> Scene | None:
    motion, rows = trial.motion, np.array([gap.marker, *donors])
    own = _thin(np.flatnonzero(trial.seen[rows].all(0)), gap, motion.rate, method)
    if len(own) < FEWEST:
        return None
    other, twins = np.zeros(0, np.int64), trial.partner[rows]
    if (twins != rows).any():
        other = np.flatnonzero(trial.seen[twins].all(0))
        other = other[:: max(1, round(1.5 * motion.rate / method.hz), -(-2 * len(other) // method.frames))]
    wanted = np.arange(gap.start, gap.stop)
    xyz = np.concatenate(
        [
            motion.xyz[rows[:, None], own],
            motion.xyz[twins[:, None], other] * REFLECTED,
            motion.xyz[rows[:, None], wanted],
        ],
        axis=1,
    )
    n = len(own) + len(other)
    side = np.repeat([0, 1, 0], [len(own), len(other), len(wanted)])
    time = np.concatenate([own, other, wanted]) / motion.rate
    return Scene(xyz, np.abs(time[:, None] - time[:n]), side[:, None] == side[:n], n, side)


def _thin(frames: Ints, gap: Gap, rate: float, method: Body) -> Ints:
    """Frames to learn from: those at the edges, half of the rest beside the gap, half all over the trial."""
    away = np.maximum(gap.start - frames, frames - gap.stop + 1)
    step = max(1, round(rate / method.hz))
    kept = frames[(away <= EDGE) | (frames % step == 0)]
    if len(kept) <= method.frames:
        return kept
    away = np.maximum(gap.start - kept, kept - gap.stop + 1)
    order = np.argsort(away, kind="stable")
    near, far = order[: method.frames // 2], np.sort(order[method.frames // 2 :])
    spread = far[np.linspace(0, len(far) - 1, method.frames - len(near)).astype(int)]
    return np.sort(kept[np.concatenate([near, spread])])


def _view(scene: Scene, base: tuple[int, ...]) -> View | None:
    """A scene seen from one base; None where its markers ever stand on one line."""
    R, c = triad(scene.xyz[list(base)])
    if not np.isfinite(R).all():
        return None
    seen = local(R, c, scene.xyz)
    of = scene.side[: scene.n] == np.array([[0], [1]])
    mean = (of / np.maximum(of.sum(1, keepdims=True), 1)) @ seen[:, : scene.n]  # (1 + D, 2, 3)
    seen = seen - mean[:, scene.side]
    y, phi = seen[0, : scene.n], seen[1:]
    spread = np.sqrt(np.einsum("dni,dni->d", phi[:, : scene.n], phi[:, : scene.n]) / scene.n)
    weight = 1 / (np.maximum(spread, 1e-3) * np.sqrt(1 + np.arange(len(phi))))  # (4)
    phi = (phi * weight[:, None, None]).transpose(1, 0, 2).reshape(len(R), -1)
    size = np.sqrt((phi[: scene.n] ** 2).sum(1).mean()) or 1.0
    phi = np.concatenate([phi / size, TURN * _turned(R, scene)], axis=1) / np.sqrt(1 + TURN**2)
    dot, square = phi @ phi[: scene.n].T, (phi**2).sum(1)
    half = np.maximum((square[:, None] + square[: scene.n]) / 2 - dot, 0.0)
    P = dot + 1 / (1 + NARROW * half)  # (3)
    return View(R, c, y, mean[0, 0], P, square + 1)


def _turned(R: Floats, scene: Scene) -> Floats:
    """(n + L, 9) A of (4), less the mean of each source, in unit mean square over the frames to learn from."""
    out = np.empty_like(R)
    for s in np.unique(scene.side):
        mine = scene.side == s
        mean = R[: scene.n][mine[: scene.n]].mean(0)
        U, _, Vt = np.linalg.svd(mean)
        out[mine] = (U @ Vt).T @ (R[mine] - mean)
    flat = out.reshape(len(R), 9)
    return flat / max(np.sqrt((flat[: scene.n] ** 2).sum(1).mean()), STILL)


def _fit(scene: Scene, view: View, h: Hyper) -> Fit:
    """(2), (5) and τ² of (6), with how likely what is seen is."""
    n, free = scene.n, 10.0 * max(10.0, h.lam)
    r = np.sqrt(3) / h.ell * scene.apart
    k = np.exp(-r)
    k *= 1 + r
    k += free
    k *= scene.same
    k += view.P * np.where(scene.same, h.lam, h.lam * h.rho)
    factor = cho_factor(k[:n] + h.nu * np.eye(n), lower=True, check_finite=False)
    weights = cho_solve(factor, view.y, check_finite=False)
    tau2 = np.maximum((view.y * weights).sum(0) / n, 1e-8)
    likely = -0.5 * n * np.log(tau2).sum() - 3 * np.log(np.diag(factor[0])).sum()
    return Fit(float(likely), k, h.lam * view.own + 1 + free, factor, weights, tau2)


def _hyper(trial: _Trial, key: tuple[int, bytes], scene: Scene, view: View, method: Body) -> Hyper:
    """λ, ℓ, ν and ρ for a gap: its marker's, or the trial's by the first `FEW` scenes looked at."""
    if not method.shared:
        if key not in trial.hypers:
            trial.hypers[key] = _likeliest([(scene, view)])
        return trial.hypers[key]
    if len(trial.looks) < FEW:
        trial.looks.append((scene, view))
        trial.hypers[SHARED] = _likeliest(trial.looks)
    return trial.hypers[SHARED]


def _likeliest(looks: list[tuple[Scene, View]]) -> Hyper:
    """The best of the grid for all looks together, one parameter after the other."""

    def likely(h: Hyper) -> float:
        return sum(_fit(scene, view, h).likely for scene, view in known)

    known = [  # without the frames to fill
        (s._replace(apart=s.apart[: s.n], same=s.same[: s.n]), v._replace(P=v.P[: s.n], own=v.own[: s.n]))
        for s, v in looks
    ]
    best, at = Hyper(), likely(Hyper())
    for name in ("rho", "ell", "lam", "nu"):
        for value in GRID[name]:
            new = best._replace(**{name: value})
            if new != best and (found := likely(new)) > at:
                best, at = new, found
    return best


def _predict(scene: Scene, view: View, fit: Fit) -> tuple[Floats, Floats]:
    """(6), turned back into the laboratory."""
    n, k = scene.n, fit.k[scene.n :]
    inside = view.mean + k @ fit.weights
    half = solve_triangular(fit.factor[0], k.T, lower=True, check_finite=False)
    left = fit.prior[n:] - np.einsum("nf,nf->f", half, half)
    var = np.maximum(left, 1e-9)[:, None] * fit.tau2
    R = view.R[n:]
    xyz = view.c[n:] + np.einsum("fij,fj->fi", R, inside)
    return xyz, np.einsum("fij,fj,fkj->fik", R, var, R)
