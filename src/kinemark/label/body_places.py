"""Where a marker is, by those that it moves with: the figure that it makes with them, learnt from the trial itself.

A template knows by how much the distance of two markers varies. Those of the NEIGHBOURS whose distance to marker m
varies least, and agrees with the template in this trial, are m's neighbours. Their places a_i and m's own x in one
figure follow from the frames in which they are seen, laid over each other by rotations. In a frame with n neighbours at
y_i, the rotation R of least squares (Kabsch 1976) foretells

    b = ȳ + R (x − ā)                                                                                             (1)

with weights against neighbours that are off. Where each lies off its place by s in each axis, so does m, and b by

    B = s² [ I (1 + 1/n) + K J⁻¹ Kᵀ ],   K = [R (x − ā)]×,   J = Σ |r_i|² I − r_i r_iᵀ,   r_i = R (a_i − ā)       (2)

and s is what makes the distances (p − b)ᵀ B⁻¹ (p − b) of the trial's own points p have the quantiles of χ² with three
degrees of freedom: the lower one, and the median and the high one as far as the template's distances vary as much. So
it holds soft tissue, joints between the neighbours and errors of points alike, and a marker that none keeps a distance
to has a B that says so.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from ..numerics.evenly import evenly_rounded
from .template import Template

NEIGHBOURS = 6
"""That foretell a place; chosen: two segments' worth on sets of 39 and more."""
LEAST = 3
"""Neighbours seen, below which nothing is foretold; by definition of a rotation."""
LEAST_S = 0.3
"""s in which a marker and a neighbour are seen together, at least, for the figure to be known; chosen."""
AGREE = 4.0
"""Standard deviations by which the trial's mean distance may differ from the template's; chosen."""
SLACK_MM = 5.0
"""mm more that it may differ: markers are put on anew, and templates are of other days; chosen."""
LEARNT_FRAMES = 200
"""From which a figure is learnt, evenly spread; chosen: as many as say its mean to a tenth of its spread."""
ROUNDS = 2
"""Of weights against neighbours that are off, and of figures laid over their mean; chosen."""
QUANTILES = {0.25: 1.213, 0.5: 2.366, 0.95: 7.815}
"""By which s is judged, and the same of χ² with three degrees of freedom, by definition: joints bend in a part of the
frames only; chosen."""
MAD = 0.6745
"""Median absolute deviation of a normal distribution, in standard deviations; by definition."""
OUTLIER = 5.0
"""Standard deviations at which a distance that is off counts no more; chosen."""
START_MM = 5.0
"""mm, s by which neighbours are first weighed; chosen."""
LEAST_MM = 0.5
"""mm, the least s; chosen: no marker keeps its place better."""
FLAT = 1e-4
"""Least share of the greatest eigenvalue of J that the least has; below it the neighbours lie on one line; chosen."""


class BodyPlaces(NamedTuple):
    """Where M markers are in F frames by the others: place (M, F, 3) mm, NaN where that is not known; cov
    (M, F, 3, 3) mm²; spread (M) mm, s of (2)."""

    place: Floats
    cov: Floats
    spread: Floats


class Figure(NamedTuple):
    """A marker, the neighbours (n) that foretell it, its own place and theirs (n + 1, 3) mm, and s of (2), mm."""

    marker: int
    near: Ints
    xyz: Floats
    spread: float


def body_places(xyz: Floats, index: Ints, template: Template, rate: float) -> BodyPlaces:
    """The places of markers xyz (M, F, 3) mm, NaN where not seen; see `figures`."""
    return places_by(figures(xyz, index, template, rate), xyz)


def places_by(known: list[Figure], xyz: Floats) -> BodyPlaces:
    """The places of markers xyz (M, F, 3) mm, NaN where not seen, by their figures."""
    M, F = xyz.shape[:2]
    place, cov = np.full((M, F, 3), np.nan), np.full((M, F, 3, 3), np.nan)
    spread = np.full(M, np.nan)
    for figure in known:
        m = figure.marker
        place[m], G = foretold(figure, xyz[figure.near])
        cov[m], spread[m] = figure.spread**2 * G, figure.spread
    return BodyPlaces(place, cov, spread)


def figures(xyz: Floats, index: Ints, template: Template, rate: float, wanted: Ints | None = None) -> list[Figure]:
    """The figure of each marker that has LEAST neighbours and more.

    Args:
        xyz: (M, F, 3) mm, NaN where not seen. index: (M) the label of each in the template. rate: Hz.
        wanted: rows of the markers whose figures are learnt; all where None.
    """
    seen = np.isfinite(xyz[..., 0])
    together = seen.astype(np.float32) @ seen.T.astype(np.float32)
    looseness = _looseness(xyz, index, template)
    looseness[together < max(LEAST_S * rate, LEAST + 1)] = np.inf
    np.fill_diagonal(looseness, np.inf)
    found = []
    pick = np.ix_(index, index)
    D, spread = template.distance[pick], np.hypot(template.spread, np.asarray(template.doubt))[pick]
    for m in range(len(xyz)) if wanted is None else np.unique(wanted).tolist():
        near = np.argsort(looseness[m], kind="stable")[:NEIGHBOURS]
        near = near[np.isfinite(looseness[m, near])]
        if len(near) >= LEAST:
            group = [m, *near.tolist()]
            found += _figure(group, xyz[group], D[np.ix_(group, group)], spread[np.ix_(group, group)])
    return found


def _looseness(xyz: Floats, index: Ints, template: Template) -> Floats:
    """(M, M) mm by which distances vary, in the template or the trial; infinite where the two contradict each other."""
    rows = _spread_frames(np.arange(xyz.shape[1]))
    d = np.linalg.norm(xyz[:, None, rows] - xyz[None, :, rows], axis=-1)
    n = np.isfinite(d).sum(-1)
    middle = _median(d, n)
    own = _median(np.abs(d - middle[..., None]), n) / MAD
    D, spread = (one[np.ix_(index, index)] for one in (template.distance, template.spread))
    doubt = np.asarray(template.doubt)[np.ix_(index, index)]
    agrees = np.abs(middle - D) <= AGREE * np.hypot(np.hypot(spread, own), doubt) + SLACK_MM
    return np.where(agrees & (n > 0), np.hypot(spread, own), np.inf)


def _median(values: Floats, n: Ints) -> Floats:
    """Of the n (…) values (…, K) that are not NaN, the lower one of two in the middle; NaN of none."""
    at = np.maximum((n - 1) // 2, 0)[..., None]
    return np.asarray(np.take_along_axis(np.sort(values, axis=-1), at, axis=-1)[..., 0])


def _spread_frames(frames: Ints) -> Ints:
    """At most LEARNT_FRAMES of some frames."""
    at = evenly_rounded(len(frames), LEARNT_FRAMES)
    return frames[np.unique(at)] if len(frames) else frames


def _figure(group: list[int], points: Floats, D: Floats, spread: Floats) -> list[Figure]:
    """The figure of a marker and its neighbours (n + 1, F, 3), in a list that is empty where they have too few frames.

    It is learnt from the half of the frames that agrees best with the template's distances D ± spread (n + 1, n + 1),
    as in the others markers may be exchanged. Half of the frames, and rare ones, may raise s to what the template knows
    of the distances at most: where a quarter of them holds more tightly, the others are exchanged, not soft.
    """
    seen = np.isfinite(points[..., 0])
    frames = _spread_frames(np.flatnonzero(seen[0] & (seen[1:].sum(0) >= LEAST)))
    d = np.linalg.norm(points[:, None, frames] - points[None, :, frames], axis=-1)
    off = np.minimum(np.abs(d - D[..., None]) / (spread[..., None] + LEAST_MM), OUTLIER)
    off = np.nansum(off, axis=(0, 1)) / np.maximum(np.isfinite(off).sum((0, 1)), 1)
    agreeing = frames[off <= np.median(off)] if len(frames) else frames
    whole = agreeing[seen[:, agreeing].all(0)]
    if not len(whole):
        return []
    mean = points[:, whole[len(whole) // 2]]
    for _ in range(ROUNDS):
        mean = _mean_figure(mean, points[:, agreeing])
    figure = Figure(group[0], np.array(group[1:]), mean, START_MM)
    known = float(np.nanmax(spread[0, 1:]))
    for _ in range(ROUNDS):
        square = distance(points[0, frames], *foretold(figure, points[1:, frames]))
        square = square[np.isfinite(square)]
        if not len(square):
            return []
        core, middle, rare = np.sqrt(np.quantile(square, list(QUANTILES)) / list(QUANTILES.values()))
        s = max(core, min(max(middle, rare), known))
        figure = figure._replace(spread=max(float(s), LEAST_MM))
    return [figure]


def _mean_figure(mean: Floats, points: Floats) -> Floats:
    """(n, 3) the median of points (n, K, 3) laid over their mean (n, 3) so far."""
    y = points.transpose(1, 0, 2)
    there = np.isfinite(y[..., 0])
    R, own, other = _laid(mean, np.where(there[..., None], y, 0.0), there.astype(float))
    back = (y - other[:, None]) @ R.swapaxes(-1, -2) + own[:, None]
    middle = np.nanmedian(np.where(there[..., None], back, np.nan), axis=0)
    return np.where(np.isfinite(middle), middle, mean)


def foretold(figure: Figure, y: Floats) -> tuple[Floats, Floats]:
    """(F, 3) places by (1) from neighbours y (n, F, 3), NaN where too few are seen, and (F, 3, 3) of (2) without s²."""
    return turned(figure, y)[:2]


def turned(figure: Figure, y: Floats) -> tuple[Floats, Floats, Floats]:
    """The same, and rotations (F, 3, 3) that turn a row of the figure's axes to the world's."""
    seen = y.transpose(1, 0, 2)
    there: Bools = np.isfinite(seen[..., 0])
    seen = np.where(there[..., None], seen, 0.0)
    a, weight = figure.xyz[1:], there.astype(float)
    for _ in range(1 + ROUNDS):
        R, own, other = _laid(a, seen, weight)
        off = (a - own[:, None]) @ R + other[:, None] - seen
        weight = there / (1.0 + (off**2).sum(-1) / (3 * max(figure.spread, LEAST_MM) ** 2))
    arm = ((figure.xyz[0] - own)[:, None] @ R)[:, 0]
    G, turns = _uncertainty(arm, (a - own[:, None]) @ R, weight)
    known: Bools = np.asarray((there.sum(1) >= LEAST) & turns)
    return np.where(known[:, None], arm + other, np.nan), np.where(known[:, None, None], G, np.nan), R


def _uncertainty(arm: Floats, r: Floats, weight: Floats) -> tuple[Floats, Bools]:
    """(F, 3, 3) of (2) without s², and whether (F) the neighbours determine a rotation."""
    square = (weight * (r**2).sum(-1)).sum(1)
    J = square[:, None, None] * np.eye(3) - np.einsum("fn,fni,fnj->fij", weight, r, r)
    value = np.linalg.eigvalsh(J)
    turns: Bools = np.asarray(value[:, 0] > FLAT * np.maximum(value[:, 2], 1e-9))
    inverse = np.linalg.inv(np.where(turns[:, None, None], J, np.eye(3)))
    K = np.cross(arm[:, None], np.eye(3))
    n = np.maximum(weight.sum(1), 1e-9)
    return np.eye(3) * (1 + 1 / n)[:, None, None] + K.swapaxes(-1, -2) @ inverse @ K, turns


def _laid(a: Floats, y: Floats, weight: Floats) -> tuple[Floats, Floats, Floats]:
    """(F, 3, 3) rotations R, a row times R turns it, and both centres that lay a (n, 3) over y (F, n, 3)."""
    share = weight / np.maximum(weight.sum(-1, keepdims=True), 1e-12)
    own, other = share @ a, (share[..., None] * y).sum(1)
    H = np.einsum("fn,fni,fnj->fij", share, a - own[:, None], y - other[:, None])
    U, _, V = np.linalg.svd(H)
    U[..., :, 2] *= np.sign(np.linalg.det(U @ V))[..., None]
    return U @ V, own, other


def distance(p: Floats, place: Floats, cov: Floats) -> Floats:
    """(N) squared distances of points (N, 3) from places (N, 3) with covariances (N, 3, 3); NaN where either is."""
    off = p - place
    known: Bools = np.asarray(np.isfinite(off).all(-1) & np.isfinite(cov).all((-1, -2)))
    N = np.linalg.inv(np.where(known[..., None, None], cov, np.eye(3)))
    off = np.where(known[..., None], off, 0.0)
    return np.where(known, np.einsum("...i,...ij,...j->...", off, N, off), np.nan)
