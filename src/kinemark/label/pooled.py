"""Templates put together: of several trials of one subject, and of several subjects scaled to one height.

Of two parts with n₁, n₂ frames, means D₁, D₂ and standard deviations S₁, S₂, all frames have

    D = (n₁ D₁ + n₂ D₂) / n,   S² = (n₁ (S₁² + (D₁ − D)²) + n₂ (S₂² + (D₂ − D)²)) / n,   n = n₁ + n₂             (1)

and what only another subject or a static trial told of the first part is doubted as far as that part counts: √(n₁ / n).

Subjects i of one height differ in their D_i by the standard deviation s, of which the k that there are tell, and which
is s₀ of (3) of `template` between subjects in general. κ more are taken to differ by s₀, lest few stand for all:

    s² = (κ s₀² + Σ (D_i − D)²) / (κ + k − 1),   doubt of a new subject √(1 + 1/k) s                              (2)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..data import KinemarkError, Trajectories, make_finding
from ..data.array_types import Bools, Floats, Ints
from ..data.finding import Finding
from ..data.nearest_word import some_names
from ..numerics.evenly import evenly_rounded
from .template import Template, between_subjects

SUBJECTS = 2.0
"""κ of (2); chosen."""
RIGID = 0.05
"""Spread over distance up to which a pair tells whether a trial is of the same markers; chosen: on one segment."""
T = TypeVar("T", bound=np.generic)
OFF, OFF_SIZE = 3.0, 0.006
"""A rigid pair contradicts where its mean is off by so many spreads, and by this share of the size; chosen."""
PEERS = 6
"""Steadiest distances of a marker that judge it; chosen: as many as a segment or two have."""
TURNED = 0.5
"""Share of the frames in which a quadruple must be turned to contradict; chosen."""
FEWEST_TURNED = 2
"""Quadruples of a marker that must be turned for it to be said, and more than half as many as of any; chosen."""
SELDOM = 0.02
"""Share of the frames in which one may be turned and still counts as never changing; chosen, for single bad frames."""


def pooled(own: Template, new: Template, trial: Trajectories) -> Template:
    """The template of all that two have seen; labels and their order are those of the first.

    Args:
        own: of the subject. new: of another trial, with some of the same labels. trial: that one, named.
    """
    at = np.array([own.names.index(name) for name in new.names], np.int64)
    part = np.ix_(at, at)
    n1, n2 = own.frames[part], new.frames
    D, S = _together(own.distance[part], own.spread[part], n1, new.distance, new.spread, n2)
    _, s = _together(own.distance[part], own.short_spread[part], n1, own.distance[part], new.short_spread, n2)
    kept = _turned(own, trial) <= SELDOM
    known = np.sqrt(n1 / np.maximum(n1 + n2, 1))
    return replace(
        own,
        doubt=_put(np.asarray(own.doubt), part, np.asarray(own.doubt)[part] * known),
        distance=_put(own.distance, part, D),
        spread=_put(own.spread, part, S),
        short_spread=_put(own.short_spread, part, s),
        frames=_put(own.frames, part, n1 + n2),
        handed=own.handed[kept],
        sign=own.sign[kept],
    )


def _together(D1: Floats, S1: Floats, n1: Ints, D2: Floats, S2: Floats, n2: Ints) -> tuple[Floats, Floats]:
    """D and S of (1); what one part has not seen has no weight."""
    n1, n2 = np.where(np.isfinite(D1), n1, 0), np.where(np.isfinite(D2), n2, 0)
    n = np.maximum(n1 + n2, 1)
    D = (n1 * np.nan_to_num(D1) + n2 * np.nan_to_num(D2)) / n
    S1, S2, off1, off2 = (np.nan_to_num(x) for x in (S1, S2, D1 - D, D2 - D))
    S = np.sqrt((n1 * (S1**2 + off1**2) + n2 * (S2**2 + off2**2)) / n)
    none = n1 + n2 == 0
    return np.where(none, np.nan, D), np.where(none, np.nan, S)


def _put(of: NDArray[T], part: tuple[Ints, ...], values: NDArray[T]) -> NDArray[T]:
    """A copy with a part replaced."""
    new = of.copy()
    new[part] = values
    return new


class Contradiction(NamedTuple):
    """Markers that sit elsewhere than the template says; share of the rigid pairs that are off; the most, mm."""

    markers: tuple[str, ...]
    pairs_share: float
    off_mm: float

    @property
    def finding(self) -> Finding:
        """The same for a report."""
        return make_finding(
            "trial_contradicts_template", markers=self.markers, pairs_share=self.pairs_share, off_mm=self.off_mm
        )


def contradiction(own: Template, new: Template, trial: Trajectories) -> Contradiction | None:
    """Where a named trial says otherwise than the template of its subject; None where it does not.

    Only what is rigid counts, as a posture that is new is no contradiction: the steadiest distances of each marker, and
    the orientation of quadruples. A marker contradicts where half of these are off: a single one may be of two markers
    that one motion happened not to move.
    """
    at = np.array([own.names.index(name) for name in new.names], np.int64)
    part = np.ix_(at, at)
    D, S = own.distance[part], np.hypot(own.spread, np.asarray(own.doubt))[part]
    rigid = (S <= RIGID * D) & np.isfinite(D) & np.isfinite(new.distance)
    np.fill_diagonal(rigid, False)
    rank = np.where(rigid, S, np.inf).argsort(axis=1, kind="stable").argsort(axis=1, kind="stable")
    rigid &= rank < PEERS
    off = np.abs(new.distance - D)
    wrong = rigid & (off > OFF * np.hypot(S, RIGID / 2 * D)) & (off > OFF_SIZE * own.size)
    counts = np.bincount(own.handed[_turned(own, trial) > TURNED].ravel(), minlength=len(own))
    turned = (counts >= FEWEST_TURNED) & (counts > counts.max() / 2)
    said: Bools = ((wrong.sum(1) >= rigid.sum(1) / 2) & wrong.any(1)) | turned[at]
    if not said.any():
        return None
    share = wrong.sum() / max(rigid.sum(), 1)
    most = float(off[wrong].max()) if wrong.any() else 0.0
    return Contradiction(tuple(name for name, yes in zip(new.names, said, strict=True) if yes), float(share), most)


def _turned(own: Template, trial: Trajectories) -> Floats:
    """(Q) of the frames that show a quadruple, the share in which it is turned the other way; 0 where none does."""
    if not len(own.handed):
        return np.zeros(0)
    xyz = np.full((len(own), trial.n_frames, 3), np.nan)
    for k, name in enumerate(own.names):
        if name in trial.names:
            xyz[k] = trial[name].xyz
    rows = evenly_rounded(trial.n_frames, 100)
    xyz = xyz[:, rows]
    a = xyz[own.handed[:, 0]]
    u, v, w = (xyz[own.handed[:, k]] - a for k in (1, 2, 3))
    volume = own.sign[:, None] * (u * np.cross(v, w)).sum(-1)
    return np.asarray((volume < 0).sum(1) / np.maximum(np.isfinite(volume).sum(1), 1))


def template_of_subjects(templates: Sequence[Template], heights_mm: Sequence[float], height_mm: float) -> Template:
    """The template of a subject by those of others who wear the same markers, scaled by body height.

    Args:
        templates: of the others. heights_mm: of theirs, in the same order. height_mm: of the subject.

    Raises:
        KinemarkError: there are none, or they share fewer than four labels.
        ValueError: there are other numbers of heights, or one is not above 0.
    """
    if len(templates) != len(heights_mm):
        raise ValueError(f"there are {len(templates)} templates and {len(heights_mm)} heights, wanted as many")
    if not templates:
        raise KinemarkError("There are no templates of other subjects. Give one or more.")
    names = tuple(name for name in templates[0].names if all(name in one.names for one in templates))
    if len(names) < 4:
        raise KinemarkError(f"The templates share {len(names)} markers. Wanted are four or more: the same marker set.")
    scaled = [part_of(one.scaled(height_mm / h), names) for one, h in zip(templates, heights_mm, strict=True)]
    k = len(scaled)
    D = np.mean([one.distance for one in scaled], axis=0)
    S = np.sqrt(np.mean([one.spread**2 for one in scaled], axis=0))
    short = np.sqrt(np.mean([one.short_spread**2 for one in scaled], axis=0))
    usual = between_subjects(D, scaled[0].size)
    between = (SUBJECTS * usual**2 + sum((one.distance - D) ** 2 for one in scaled)) / (SUBJECTS + k - 1)  # (2)
    handed, sign = _common_quadruples(scaled)
    frames, doubt = np.sum([one.frames for one in scaled], axis=0), np.sqrt((1 + 1 / k) * between)
    return replace(
        scaled[0], distance=D, spread=S, short_spread=short, frames=frames, handed=handed, sign=sign, doubt=doubt
    )


def _common_quadruples(templates: Sequence[Template]) -> tuple[Ints, Ints]:
    """(Q, 4) and (Q) quadruples that at least half of them have, and of which none has the other orientation."""
    signs: dict[tuple[int, ...], list[int]] = {}
    for one in templates:
        for quad, sign in zip(one.handed.tolist(), one.sign.tolist(), strict=True):
            signs.setdefault(tuple(quad), []).append(sign)
    kept = {quad: s for quad, s in sorted(signs.items()) if len(set(s)) == 1 and 2 * len(s) >= len(templates)}
    return np.array(list(kept), np.int64).reshape(-1, 4), np.array([s[0] for s in kept.values()], np.int64)


def part_of(template: Template, names: Sequence[str]) -> Template:
    """Of some of the labels, in this order.

    Raises:
        ValueError: the template has no such label.
    """
    if absent := [name for name in names if name not in template.names]:
        raise ValueError(f"the template has no {absent[0]}; it has {some_names(template.names)}")
    at = np.array([template.names.index(name) for name in names], np.int64)
    part = np.ix_(at, at)
    new = np.full(len(template), -1)
    new[at] = np.arange(len(at))
    kept = (new[template.handed] >= 0).all(1) if len(template.handed) else np.zeros(0, bool)
    handed, sign = _sorted_quadruples(new[template.handed[kept]], template.sign[kept])
    square = {key: getattr(template, key)[part] for key in ("distance", "spread", "short_spread", "frames", "doubt")}
    return replace(template, names=tuple(names), handed=handed, sign=sign, **square)


def _sorted_quadruples(quads: Ints, sign: Ints) -> tuple[Ints, Ints]:
    """Labels of each in rising order; every exchange of two turns the sign of (2) of `template`."""
    order = np.argsort(quads, axis=1, kind="stable") if len(quads) else np.zeros((0, 4), np.int64)
    odd = np.array([_is_odd(row) for row in order.tolist()], bool)
    return np.take_along_axis(quads, order, 1).reshape(-1, 4), np.where(odd, -sign, sign)


def _is_odd(order: list[int]) -> bool:
    return sum(order[i] > order[j] for i in range(4) for j in range(i + 1, 4)) % 2 == 1
