"""Markers that a whole trial lacks, placed from a static trial in which they are seen.

The neighbours (reference markers) that both trials show are a rigid body, as they lie in the static trial, s (N, 3). In
each frame it is laid on those of them that are seen (Söderkvist & Wedin 1993), and carries the lost marker at p in it:

    x̂(t) = R(t) (p − s̄) + c(t),        e_n(t) = x_n(t) − R(t) (s_n − s̄) − c(t)                          (1)

A body that bends or a skin that slides shows in e: the reference markers' mean square error, of 3 N − 6 degrees of
freedom,

    σ²(t) = Σ |e_n(t)|² / (3 N − 6)                                                                     (2)

is small where their distances are those of the static trial. The lost marker is taken to be off its place by as much as
a reference marker is, and besides by what the pose is off at q = R (p − s̄), from the inertia J of the reference
markers about their centre:

    cov(t) = σ² [ I + I / N + [q]ₓ J⁻¹ [q]ₓᵀ ],       J = Σ (|r_n|² I − r_n r_nᵀ),  r_n = R (s_n − s̄)     (3)

σ² is the mean over the trial, or (2) where that is more. Whether the lost marker itself belongs to the reference
markers' body no frame of the trial can say, but its neighbours can: placed in the same way from the reference markers,
neighbour k is off by E_k² on average, and the nearer it was to the lost marker (δ_k in the static trial), the more it
says:

    s² = Σ E_k² / δ_k⁴ / Σ 1 / δ_k⁴,       in (3) σ² I becomes max(σ², s² / 3) I                        (4)

over all candidates; a reference marker's own E_k² is that of the body of the other reference markers, or of (2), (3) if
there are three. The candidates are the markers nearest to the lost one in the static trial, within `reach`; of all
threes and fours of them that are seen together in at least `share` of the frames, the reference markers are those of
the least s² + σ² (1 + 1 / N + lever). The expected error is the mean length of an error with (4).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats, Ints
from ..data.method import ONE, Method, parameter
from ..geometry import rigid_poses
from ..numerics.vectors import cross_matrix
from .known_samples import KnownSamples
from .marker_array import MarkerArray
from .methods.rigid_body import on_line
from .static_shape import StaticShape

JUDGE = 40
"""Frames in which sets of reference markers are compared; chosen (see benchmarks/gaps.py)."""


@dataclass(frozen=True, slots=True)
class FromStatic(Method):
    """A marker that the trial never shows, placed from its place among others in a static trial."""

    reference_markers: tuple[str, ...] = parameter(
        (), meaning="reference markers: names of markers on the same body; empty: chosen"
    )
    nearest: int = parameter(6, unit="markers", low=3, meaning="the nearest, among which reference markers are chosen")
    most_markers: int = parameter(4, unit="markers", low=3, meaning="most reference markers, when they are chosen")
    reach: float = parameter(
        600.0, unit="mm", above=0, meaning="farthest reference marker from the missing marker in the static trial"
    )
    share: float = parameter(
        0.5, unit=ONE, above=0, meaning="share of the frames that show any reference marker in which all must be shown"
    )
    min_breadth: float = parameter(
        0.1, unit=ONE, meaning="least ratio of breadth to length of the reference markers; below it they lie on a line"
    )

    def check_together(self) -> None:
        """Refuse fewer than three reference markers."""
        if self.reference_markers and len(set(self.reference_markers)) < 3:
            raise ValueError(
                f"reference_markers are {list(self.reference_markers)}, wanted at least three different ones, or none"
            )


class PlacedMarker(NamedTuple):
    """A marker that a trial lacks.

    Attributes:
        name: of the marker.
        xyz: (F, 3) mm, NaN where fewer than three reference markers are seen, or all of them where there is a reason.
        cov: (F, 3, 3) mm² of (3).
        expected_mm: mean distance from the truth that (3) lets expect; NaN where there is a reason.
        references: names.
        reason: why it could not be placed, in words for the user; empty where it could.
    """

    name: str
    xyz: Floats
    cov: Floats
    expected_mm: float
    references: tuple[str, ...]
    reason: str = ""


def place_absent(motion: MarkerArray, static: StaticShape, *, method: FromStatic = FromStatic()) -> list[PlacedMarker]:
    """Every marker of the static trial that the trial nowhere shows, or does not have at all.

    Args:
        motion: the trial.
        static: `StaticShape.of` the static trial.
        method: parameters.

    Raises:
        ValueError: a reference marker named is not in both trials.
    """
    known = KnownSamples.of(motion)
    shown = {name for name, seen in zip(known.names, known.seen, strict=True) if seen.any()}
    if lost := [name for name in method.reference_markers if name not in shown or name not in static.names]:
        raise ValueError(f"no reference markers {', '.join(lost)} in both trials")
    return [_place(known, static, k, method) for k, name in enumerate(static.names) if name not in shown]


def _place(known: KnownSamples, static: StaticShape, lost: int, method: FromStatic) -> PlacedMarker:
    place = static.xyz[lost]
    candidates = _candidates(known, static, place, method)
    if len(candidates) < 3:
        reason = f"{len(candidates)} markers of both trials lie within {method.reach:g} mm of it, wanted three"
        return _nowhere(known, static.names[lost], reason)
    references, s2 = _chosen(known, static, place, candidates, method)
    if not len(references):
        return _nowhere(known, static.names[lost], "no three of its neighbours are seen together and off one line")
    return _carried(known, static, lost, references, s2)


def _nowhere(known: KnownSamples, name: str, reason: str) -> PlacedMarker:
    F = known.n_frames
    return PlacedMarker(name, np.full((F, 3), np.nan), np.full((F, 3, 3), np.nan), np.nan, (), reason)


def _candidates(known: KnownSamples, static: StaticShape, place: Floats, method: FromStatic) -> Ints:
    """Rows of the static trial that may be reference markers, the nearest first."""
    far = np.sqrt(((static.xyz - place) ** 2).sum(1))
    shown = {name for name, seen in zip(known.names, known.seen, strict=True) if seen.any()}
    order = [int(k) for k in np.argsort(far) if static.names[k] in shown]
    if method.reference_markers:
        return np.array([k for k in order if static.names[k] in method.reference_markers])
    return np.array([k for k in order if far[k] <= method.reach][: method.nearest], np.int64)


def _points(known: KnownSamples, static: StaticShape, references: Ints, frames: Ints) -> Floats:
    """(F, N, 3) mm of reference markers, given as rows of the static trial."""
    return known.x[known.places([static.names[k] for k in references])][:, frames].swapaxes(0, 1)


def _chosen(
    known: KnownSamples, static: StaticShape, place: Floats, candidates: Ints, method: FromStatic
) -> tuple[Ints, float]:
    """The reference markers, empty if there are none, and s² of (4)."""
    x, shape = _points(known, static, candidates, known.thin(JUDGE)), static.xyz[candidates]
    any_seen = int((~np.isnan(x[..., 0])).any(1).sum())
    K = range(len(candidates))
    sizes = [len(candidates)] if method.reference_markers else range(3, min(method.most_markers, len(candidates)) + 1)
    best, score, best_s2 = candidates[:0], np.inf, np.inf
    for some in (list(c) for n in sizes for c in combinations(K, n)):
        there = ~np.isnan(x[:, some, 0]).any(1)
        if there.sum() < max(1, method.share * any_seen) or on_line(shape[some], method.min_breadth):
            continue
        sigma2, off2 = _neighbours(shape, x[there], some)
        near = 1 / np.maximum(((shape - place) ** 2).sum(1), 1.0) ** 2
        near[np.isnan(off2)] = 0.0
        s2 = float((np.nan_to_num(off2) * near).sum() / near.sum())
        away = place - shape[some].mean(0)
        lever = (away @ away) / ((shape[some] - shape[some].mean(0)) ** 2).sum()
        value = s2 + sigma2 * (1 + 1 / len(some) + lever)
        if value < score:
            best, score, best_s2 = candidates[some], value, s2
    return best, best_s2


def _neighbours(shape: Floats, x: Floats, some: list[int]) -> tuple[float, Floats]:
    """Mean (2) of the body of some candidates, and E_k² (K) of all, NaN where one is not seen with them."""
    sigma2, off2 = _fit(shape, x, some)
    if len(some) > 3:
        for k in some:
            rest = [j for j in some if j != k]
            off2[k] = np.nan if on_line(shape[rest], 0.02) else _fit(shape, x, rest)[1][k]
    else:
        off2[some] = 3 * sigma2 * (1 + 1 / 3)
    return sigma2, off2


def _fit(shape: Floats, x: Floats, some: list[int]) -> tuple[float, Floats]:
    """Mean (2) of a body, and the mean square error (K) of all candidates carried by it."""
    R, c = rigid_poses(shape[some], x[:, some])
    e = x - c[:, None] - (shape - shape[some].mean(0)) @ R.mT
    square = (e * e).sum(-1)
    n = (~np.isnan(square)).sum(0)
    off2 = np.divide(np.nansum(square, axis=0), n, out=np.full(len(shape), np.nan), where=n > 0)
    return float(square[:, some].sum(1).mean() / (3 * len(some) - 6)), off2


def _errors(shape: Floats, x: Floats) -> Floats:
    """e (F, N, 3) of (1)."""
    R, c = rigid_poses(shape, x)
    return x - c[:, None] - (shape - shape.mean(0)) @ R.mT


def _sigma2(e: Floats) -> Floats:
    """(2), mm² (F)."""
    return np.asarray((e * e).sum((1, 2)) / (3 * e.shape[1] - 6))


def _carried(known: KnownSamples, static: StaticShape, lost: int, references: Ints, s2: float) -> PlacedMarker:
    frames = np.arange(known.n_frames)
    x = _points(known, static, references, frames)
    there = ~np.isnan(x[..., 0]).any(1)
    shape = static.xyz[references] - static.xyz[references].mean(0)
    R, c = rigid_poses(shape, x[there])
    q = R @ (static.xyz[lost] - static.xyz[references].mean(0))
    sigma2 = _sigma2(_errors(shape, x[there]))
    sigma2 = np.maximum(sigma2, sigma2.mean())
    inertia = (shape**2).sum() * np.eye(3) - shape.T @ shape
    turn = cross_matrix(q) @ (R @ np.linalg.inv(inertia) @ R.mT) @ cross_matrix(q).mT
    own = np.maximum(sigma2, s2 / 3)[:, None, None]
    cov = own * np.eye(3) + sigma2[:, None, None] * (np.eye(3) / len(references) + turn)  # (4)
    nowhere = _nowhere(known, static.names[lost], "")
    nowhere.xyz[there], nowhere.cov[there] = q + c, cov
    expected = float(_mean_length(cov).mean())
    return nowhere._replace(expected_mm=expected, references=tuple(static.names[k] for k in references))


def _mean_length(cov: Floats) -> Floats:
    """Mean length of errors of these covariances (F, 3, 3): √(8/3π) of their RMS where all axes are alike."""
    return np.asarray(np.sqrt(8 / (3 * np.pi) * np.trace(cov, axis1=1, axis2=2)))
