"""What is known of a subject's markers before a trial is labelled: how far they are from each other.

Over the frames of labelled trials, each pair of labels a, b has the distances d(t). The template keeps

    D = mean d,   S² = var d,   s² = mean over windows of 0.6 s of the variance in the window                    (1)

and, of quadruples a, b, c, d of labels, the sign of the triple product

    h = sign (b − a) · ((c − a) × (d − a))                                                                       (2)

where that is one and the same in all frames. (1) cannot tell a body from its mirror image, so left from right; (2) can.
Distances of two subjects of the same size H differ by where markers are placed, and by proportions, which a distance
shows the more the longer it is, up to that of a limb; their standard deviation is

    σ² = (0.004 H)² + (0.018 H)² D² / (D² + (0.2 H)²)                                                            (3)

Neither hangs on where the origin is, on how the axes lie, or on the order of the labels; lengths scale with the unit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ..data import KinemarkError, Trajectories
from ..data.array_types import Bools, Floats
from ..data.arrays import check_positive, column, set_columns
from ..data.computed_points import computed_points
from ..data.short_repr import ShortRepr
from ..numerics.evenly import evenly_rounded
from ..numerics.vectors import lengths
from .own_fit import own_fit

FRAMES = 300
"""Frames of a trial that a template looks at, evenly spread; chosen: a pair's mean and spread need no more."""
WINDOW_S = 0.6
"""Of the spread in short windows, s; chosen, about half a step."""
NEIGHBOURS = 8
"""Labels with which a label makes quadruples; chosen: 56 triples of them."""
QUADRUPLES = 12
"""That are kept of each label, the widest; chosen."""
PLACING, PROPORTION, LIMB = 0.004, 0.018, 0.2
"""Of (3), shares of the body's size; measured on five children who wear the same 59 markers, 1.2 to 1.5 m tall."""
KEEPS = 0.1
"""Spread of a distance that keeps, as a share of it, at most; chosen: sets state 0.03 within segments, and static
trials leave 0.18 open elsewhere."""
LEAST_VOLUME = 0.1
"""Least triple product over the product of its edges, in all frames: 6° out of one plane; chosen."""
IN_ONE_POSTURE = ((0.15, 0.5), (0.4, 0.6))
"""Of quadruples of a single posture the longest distance, as a share of the template's size, and the least volume as
`LEAST_VOLUME`, of the edges from the best of four corners; the second where a set has few such. Chosen on static trials
of eight subjects against their walks: 4 and 6 % of the samples of these turn, and 12 % of all of less than 0.4. As of a
trial that moves quadruples were those whose distances the static trial held best, a hand with the spine and a foot."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Template(ShortRepr):
    """L labels of one subject.

    Attributes:
        names: (L).
        distance: (L, L) mean distance, mm; NaN where two were never seen together.
        spread: (L, L) standard deviation of it over the motion, mm.
        short_spread: (L, L) the same in windows of 0.6 s, mm.
        handed: (Q, 4) labels whose orientation never changes.
        sign: (Q) of their triple product, 1 or −1.
        frames: (L, L) in how many frames both were seen.
        doubt: (L, L) standard uncertainty of the mean distance, mm, of another subject's template; 0 where None.
        own_fit: what parts of its own data score, as a share of what is expected, where the template is learnt from
            the others: the least of them; 1 where there are too few frames to tell. See `own_fit`.
    """

    names: tuple[str, ...]
    distance: Floats
    spread: Floats
    short_spread: Floats
    handed: NDArray[np.int64]
    sign: NDArray[np.int64]
    frames: NDArray[np.int64]
    doubt: Floats | None = None
    own_fit: float = 1.0

    def __post_init__(self) -> None:
        n, q = len(self.names), len(self.handed)
        doubt = np.zeros((n, n)) if self.doubt is None else self.doubt
        set_columns(
            self,
            names=tuple(self.names),
            distance=column("distance", self.distance, np.float64, n, n),
            spread=column("spread", self.spread, np.float64, n, n),
            short_spread=column("short_spread", self.short_spread, np.float64, n, n),
            handed=column("handed", self.handed, np.int64, q, 4),
            sign=column("sign", self.sign, np.int64, q),
            frames=column("frames", self.frames, np.int64, n, n),
            doubt=column("doubt", doubt, np.float64, n, n),
        )
        if len(set(self.names)) != n:
            raise ValueError(f"the names of a template must differ, found {self.names}")

    def __len__(self) -> int:
        return len(self.names)

    @property
    def size(self) -> float:
        """The greatest mean distance of two labels, mm."""
        return float(np.nanmax(self.distance))

    @property
    def keeps(self) -> Bools:
        """(L, L) whether the distance of two labels is known to keep; not of a label with itself."""
        return np.asarray(self.spread < KEEPS * self.distance)  # NaN is not, nor 0

    def scaled(self, ratio: float) -> Template:
        """Of a subject `ratio` times as tall.

        Raises:
            ValueError: the ratio is not above 0.
        """
        check_positive(ratio=ratio)
        D, spread, short_spread, doubt = (
            np.asarray(each) * ratio for each in (self.distance, self.spread, self.short_spread, self.doubt)
        )
        return replace(self, distance=D, spread=spread, short_spread=short_spread, doubt=doubt)

    def of_another(self, ratio: float) -> Template:
        """Of another subject, `ratio` times as tall, whose proportions and places of markers differ: (3).

        Raises:
            ValueError: the ratio is not above 0.
        """
        new = self.scaled(ratio)
        return replace(new, doubt=np.hypot(np.asarray(new.doubt), between_subjects(new.distance, new.size)))


def between_subjects(D: Floats, size: float) -> Floats:
    """Standard deviation (3) of distances D between subjects of one size, all in mm."""
    return size * np.hypot(PLACING, PROPORTION * D / np.hypot(D, LIMB * size))


def learn_template(
    *trials: Trajectories,
    names: Sequence[str] | None = None,
    relative_spread: float = 0.0,
    segments: Mapping[str, Sequence[str]] | None = None,
) -> Template:
    """The template of labelled trials of one subject.

    Args:
        trials: labelled; a marker's name means the same in all.
        names: of the markers to learn; where None, all names that have samples, without those that begin with "*".
        relative_spread: a further spread of each distance as a share of it; 0.14 suits a static trial, which shows no
            motion.
        segments: name → markers of one body, as `MarkerSet` has them: their distances have no such further spread.

    Raises:
        KinemarkError: there are fewer than four names with samples, no two of them are ever seen together, or all are
            at one place.
        ValueError: relative_spread is below 0.
    """
    if not 0 <= relative_spread < np.inf:
        raise ValueError(f"relative_spread is {relative_spread}, wanted 0 or more")
    known = tuple(names) if names is not None else names_in(trials)
    if len(known) < 4:
        raise KinemarkError(
            f"The template has {len(known)} named markers with samples. Wanted are four or more: give labelled trials."
        )
    parts = [_sampled(trial, known) for trial in trials]
    d = np.concatenate([_distances(xyz) for xyz, _ in parts], axis=2)
    n = np.isfinite(d).sum(2)
    if not (n[np.triu_indices(len(known), 1)] > 0).any():
        raise KinemarkError("No two markers of the template are ever seen in one frame.")
    if not (d > 0).any():
        raise KinemarkError("All markers of the template are at one place. Export its trials again.")
    sums = np.nansum(d, 2) / np.maximum(n, 1)
    mean = np.where(n > 0, sums, np.nan)
    spread = np.sqrt(np.nansum((d - sums[..., None]) ** 2, 2) / np.maximum(n, 1))  # (1)
    rigid = _rigid(known, segments or {})
    wide = np.where(rigid, spread, np.hypot(spread, relative_spread * mean))
    places = [xyz for xyz, _ in parts]
    handed, sign = (
        _handed_in_one_posture(places, mean) if relative_spread else _handed(np.concatenate(places, axis=1), spread, n)
    )
    whole = Template(known, mean, wide, _short_spread(parts, known), handed, sign, n)
    return replace(whole, own_fit=own_fit(places, whole))


def _rigid(names: tuple[str, ...], segments: Mapping[str, Sequence[str]]) -> NDArray[np.bool_]:
    """(L, L) whether two labels are on one segment."""
    on = np.array([[name in markers for name in names] for markers in segments.values()], int).reshape(-1, len(names))
    return np.asarray(on.T @ on > 0)


def names_in(trials: Sequence[Trajectories]) -> tuple[str, ...]:
    """Names of markers with samples in any of the trials, sorted; those that begin with "*" are of none."""
    seen = {path.name for trial in trials for path in trial if np.isfinite(path.xyz).any()}
    computed = {name for trial in trials for name in computed_points(trial)}
    return tuple(sorted(name for name in seen - computed if not name.startswith("*")))


def _sampled(trial: Trajectories, names: tuple[str, ...]) -> tuple[Floats, float]:
    """(L, K, 3) places about one of them in some frames, and how many frames a second these are."""
    F = trial.n_frames
    rows = evenly_rounded(F, FRAMES)
    xyz = np.full((len(names), len(rows), 3), np.nan)
    for path in trial:
        if path.name in names:
            xyz[names.index(path.name)] = path.xyz[rows]
    seen = xyz[np.isfinite(xyz).all(-1)]
    return xyz - (seen[0] if len(seen) else 0.0), trial.rate * len(rows) / max(F, 1)


def _distances(xyz: Floats) -> Floats:
    """(L, L, K) of each pair in each frame."""
    return lengths(xyz[:, None] - xyz[None])


def _short_spread(parts: Sequence[tuple[Floats, float]], names: tuple[str, ...]) -> Floats:
    """(L, L) root of the mean variance in windows."""
    total, count = np.zeros((len(names),) * 2), np.zeros((len(names),) * 2)
    for xyz, rate in parts:
        width = max(2, round(WINDOW_S * rate))
        for start in range(0, xyz.shape[1] - 1, width):
            d = _distances(xyz[:, start : start + width])
            n = np.isfinite(d).sum(2)
            mean = np.nansum(d, 2) / np.maximum(n, 1)
            total += np.nansum((d - mean[..., None]) ** 2, 2) * (n > 1)
            count += n * (n > 1)
    return np.sqrt(total / np.maximum(count, 1))


def _handed(xyz: Floats, spread: Floats, n: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(Q, 4) quadruples whose orientation (2) is the same in all frames, and (Q) its sign."""
    rank = np.where(n > 0, spread, np.inf)
    np.fill_diagonal(rank, np.inf)
    near = np.argsort(rank, axis=1, kind="stable")[:, :NEIGHBOURS]
    quads = np.unique(
        [sorted((a, *three)) for a, row in enumerate(near) for three in combinations(row.tolist(), 3)], axis=0
    )
    width = np.concatenate([triple_products(xyz, part) for part in np.array_split(quads, len(quads) // 500 + 1)])
    seen = np.isfinite(width)
    least = np.where(seen, np.abs(width), np.inf).min(1)
    one_sided = (np.nanmin(np.where(seen, width, 9), 1) > 0) | (np.nanmax(np.where(seen, width, -9), 1) < 0)
    good = np.flatnonzero(seen.any(1) & one_sided & (least > LEAST_VOLUME))
    kept = widest(quads, least, good, len(xyz))
    sign = [1 if width[q][seen[q]][0] > 0 else -1 for q in kept]
    return quads[kept].reshape(-1, 4), np.array(sign, np.int64)


def _handed_in_one_posture(parts: Sequence[Floats], mean: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The same of static trials, which do not show what turns: those that are small and far out of one plane in all.

    Args:
        parts: (L, K, 3) mm of each trial, in which subjects may face otherwise. mean: (L, L) distances, mm.
    """
    L, D = len(mean), np.where(np.isfinite(mean), mean, np.inf) / np.nanmax(mean)
    near = np.argsort(D + np.diag(np.full(L, np.inf)), axis=1, kind="stable")[:, :NEIGHBOURS]
    quads = np.unique(
        [sorted((a, *three)) for a, row in enumerate(near) for three in combinations(row.tolist(), 3)], axis=0
    )
    longest = np.max([D[quads[:, i], quads[:, j]] for i, j in combinations(range(4), 2)], axis=0)
    each = np.stack([widest_corner(_middle(xyz), quads) for xyz in parts])
    total, known = np.nan_to_num(each).sum(0), np.isfinite(each).sum(0)
    same = np.abs(total) == np.abs(np.nan_to_num(each)).sum(0)
    volume = np.where(same, total / np.maximum(known, 1), 0.0)
    kept: list[int] = []
    for most, least in IN_ONE_POSTURE:
        if len(kept) < L:
            kept = widest(quads, np.abs(volume), np.flatnonzero((longest < most) & (np.abs(volume) > least)), L)
    return quads[kept].reshape(-1, 4), np.where(volume[kept] > 0, 1, -1).astype(np.int64)


def _middle(xyz: Floats) -> Floats:
    """(L, 1, 3) the median place of each marker in a trial (L, K, 3), NaN where it is not seen."""
    seen, place = np.isfinite(xyz[..., 0]).any(1), np.full((len(xyz), 1, 3), np.nan)
    place[seen] = np.nanmedian(xyz[seen], axis=1, keepdims=True)
    return place


def widest_corner(xyz: Floats, quads: NDArray[np.int64]) -> Floats:
    """(Q) triple product of quadruples over its edges from that corner where it is greatest, with the sign as given.

    From the elbow a wrist and a hand lie in nearly one direction, though the four are far from one plane.

    Args:
        xyz: (L, 1, 3) mm. quads: (Q, 4).
    """
    corners = np.stack([triple_products(xyz, np.roll(quads, k, axis=1))[:, 0] for k in range(4)])
    return np.asarray(np.sign(corners[0]) * np.abs(corners).max(0))


def widest(quads: NDArray[np.int64], width: Floats, good: NDArray[np.int64], L: int) -> list[int]:
    """Of the good among quadruples (Q, 4), the widest, `QUADRUPLES` of each of L labels."""
    used, kept = np.zeros(L, int), []
    for q in good[np.argsort(-width[good], kind="stable")].tolist():
        if (used[quads[q]] < QUADRUPLES).any():
            used[quads[q]] += 1
            kept.append(q)
    return kept


def triple_products(xyz: Floats, quads: NDArray[np.int64]) -> Floats:
    """(Q, K) triple product of quadruples over the product of its edges."""
    a = xyz[quads[:, 0]]
    u, v, w = (xyz[quads[:, k]] - a for k in (1, 2, 3))
    edges = np.sqrt((u * u).sum(-1) * (v * v).sum(-1) * (w * w).sum(-1))
    with np.errstate(invalid="ignore", divide="ignore"):
        return (u * np.cross(v, w)).sum(-1) / edges
