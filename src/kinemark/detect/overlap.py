"""What a group of white pixels shows: one marker, several on each other, or one of which a part is hidden.

A suspected group may be an ellipse, k discs on each other, a disc with a part cut off along a line, or a disc that
moved. These are fitted to its grey levels (`discs`). An ellipse, if need be lit from one side, ends the matter where it
leaves no more at the outline than noise, the texture that the marker's inside has, and `WHOLE` of its brightness: that
is so for nearly all markers, also for such that no shape explains well. Discs on each other and cut discs follow, until
one explains the group to within noise; motion is tried where one of these is much better than the ellipse, save where
two plausible discs stand so far apart that the outline has a waist. With χ² over n pixels, N of them at the outline,
and p parameters, the information criterion is

    E = χ² / s + p ln N,    s = max(1, (least χ² − (n − N)) / N)          (1)

(Schwarz 1978; s forgives what no shape explains), and the least is best. But discs on each other and cut discs must be
plausible (`plausible`), win by `EVIDENCE` against every whole shape and all that came before them, and leave less than
a `CLEAR`th of what whole shapes leave beyond noise,

    χ² (whole) − n > CLEAR max(0, χ² − n − 3 √(2 N))                      (2)

as real markers are no perfect shapes, and some other shape will always fit one of them somewhat better. A group that
several discs, one more than are told apart among them, explain better by `EVIDENCE` and (2) with `SURE`, though not
plausibly, is more than one marker surely and keeps its centroid. From there its markers have the variance

    Σ − r² / 4 1,    no eigenvalue below 0                               (3)

with Σ the second moments of the white pixels and r the radius of the largest disc within them: k equal discs have Σ =
r² / 4 1 + the scatter of their centres.

The covariance of a disc's centre is that of least squares, times s, and what the model itself leaves: square pixels of
a sharp image (`discs.FLOOR`), and corners that are rounder than those of straight outlines where the blur w is wide

    C s + (FLOOR / (π r²) + (CORNER w²)²) 1                              (4)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Floats
from ..native import shape_images
from ..native.shape_images import Patches
from ..numerics.robust import SD_PER_MEDIAN
from ..numerics.row_quantiles import row_medians
from . import discs
from .discs import DiscFit
from .edge import discs_at_edge
from .patches import CutOut
from .plausible import SMALLEST, apart, plausible_cut, plausible_discs, rim
from .starts import cut_start, disc_start, ellipse_start, motion_start, second_moments

EVIDENCE = 25.0  # of χ², by which an explanation must win; studies/overlapping_markers.py judges it
CLEAR, SURE = 8.0, 4.0
"""Shares of what whole shapes leave beyond noise, 1 / 8 and 1 / 4; studies/overlapping_markers.py judges them."""
ONE, CUT, UNCLEAR = 1, 0, -1  # codes of the kinds; by definition
INSIDE, MANY = 0.97, 40  # of the brightness; pixels; chosen (see studies/overlapping_markers.py)
WHOLE = 0.045
"""Of the brightness; two discs of 8 px that are 0.3 diameters apart leave that much; chosen (see
studies/overlapping_markers.py)."""
ODD = 0.1  # of the brightness; three discs in a ring leave 0.24; chosen (see studies/overlapping_markers.py)
MODEL = 0.01
"""Of the brightness; what the models themselves are off by at the rim; chosen (see studies/overlapping_markers.py)."""
CORNER = 0.005  # px at a blur of 1 px; chosen (see studies/overlapping_markers.py)


class ObservedGroup(NamedTuple):
    """What n groups show.

    Attributes:
        kind: (n) number of discs on each other; `ONE` for a whole marker of any form, `CUT` for a disc that is cut,
            `UNCLEAR` for several that cannot be told apart.
        circles: (n, k, 3) x, y, r of each disc, NaN where there are fewer or the marker is whole.
        cov: (n, k, 2, 2) px² of their centres.
        spread: (n, 2, 2) px² of (3) for `UNCLEAR` ones, else 0.
    """

    kind: NDArray[np.int64]
    circles: Floats
    cov: Floats
    spread: Floats


class GroupExplanation(NamedTuple):
    """One shape fitted to n groups, or to some of them: `chi2` is inf for the others.

    Attributes:
        kind: as in `ObservedGroup`.
        size: parameters.
        chi2: (n); plausible: (n); blur: (n) w, px; circles: (n, k, 3); cov: (n, k, 2, 2) without s.
    """

    kind: int
    size: int
    chi2: Floats
    plausible: NDArray[np.bool_]
    blur: Floats
    circles: Floats
    cov: Floats


def explain(cut: CutOut, *, most: int, hidden: bool, at_edge: NDArray[np.bool_] | None = None) -> ObservedGroup:
    """What n groups show, with at most this many discs on each other, and cut discs where `hidden`.

    Those `at_edge` (n) of the image are discs that it cuts, if they can be (`edge`).
    """
    n = len(cut.peak)
    one, rest = _whole(cut)
    number = np.maximum(rim(cut.patches, one.model).sum(1), 12)
    wanted = _wanted(one, cut, number)
    tried = [_noted(ONE, one, np.arange(n), n, np.ones(n, np.bool_))]
    may_move = np.zeros(n, np.bool_)
    for kind in [2, CUT, *range(3, most + 2)]:  # the likely and the simple ones first
        if kind == 3:  # so many leave much
            rest = rest[~_explained(_some(one, rest), cut.patches.take(rest), model=ODD)]
        if kind > most:  # only to know whether there are more than are told apart
            rest = rest[~may_move[rest]]
        if not len(rest) or (kind == CUT and not hidden):
            continue
        part = cut.take(rest)
        best = _best(kind, part, wanted[rest])
        good = _plausible(kind, best, part) & (kind <= most)
        tried.append(_noted(kind, best, rest, n, good))
        done = good & _explained(best, part.patches)
        much = best.chi2 <= wanted[rest]
        may_move[rest] |= much
        if kind == 2:
            may_move[rest[good & apart(best, 2)]] = False  # no disc in motion has such a waist
            done |= much  # two explain three, or a part of one, hardly better than an ellipse does
        rest = rest[~done]
    if len(moving := np.flatnonzero(may_move)):
        patches = cut.patches.take(moving)
        moved = discs.fit(shape_images.motion, motion_start(_some(one, moving)), patches, wanted=wanted[moving])
        tried.append(_noted(ONE, moved, moving, n, np.ones(len(moving), np.bool_)))
    seen = _chosen(tried, cut, number)
    edge = np.flatnonzero((seen.kind == ONE) & at_edge) if hidden and at_edge is not None else rest[:0]
    if len(edge):
        sure, circle, cov = discs_at_edge(cut.take(edge))
        edge = edge[sure]
        seen.kind[edge], seen.circles[edge, 0], seen.cov[edge, 0] = CUT, circle[sure], cov[sure]
    return seen


def _whole(cut: CutOut) -> tuple[DiscFit, NDArray[np.int64]]:
    """An ellipse in each group, lit from a side where that helps, and the groups (index) that this does not explain."""
    weight, start = cut.patches.weight, ellipse_start(cut)
    small = 1 + (WHOLE * start[:, -2]) ** 2 * weight.max(1) / 4  # a pixel, as fewer than a quarter lie at the rim
    never, enough = np.zeros(len(start)), small * (weight > 0).sum(1)
    one = discs.fit(shape_images.ellipse, start, cut.patches, wanted=never, enough=enough)
    rest = np.flatnonzero(~_explained(one, cut.patches, model=WHOLE))
    part = cut.patches.take(rest)
    lit = discs.lit_from_a_side(shape_images.ellipse, _some(one, rest), part)
    one.chi2[rest], one.model[rest] = lit.chi2, lit.model
    return one, rest[~_explained(lit, part, model=WHOLE, texture=_texture(lit, part))]


def _texture(fit: DiscFit, patches: Patches) -> Floats:
    """(n) how much the grey levels inside a shape scatter, as standard deviation; 0 where few pixels are inside.

    It is that of a normal distribution with their median distance from their median.
    """
    A, b = fit.parameters[:, -2, None], fit.parameters[:, -1, None]
    off = np.where((fit.model > b + INSIDE * A) & (patches.weight > 0), patches.grey - fit.model, np.nan)
    enough = (~np.isnan(off)).sum(1) >= MANY
    off = off[enough]
    scatter = np.zeros(len(enough))
    scatter[enough] = SD_PER_MEDIAN * row_medians(np.abs(off - row_medians(off)[:, None]))
    return scatter


def _wanted(one: DiscFit, cut: CutOut, number: NDArray[np.int64]) -> Floats:
    """(n) the χ² from which on an explanation is that much better than an ellipse, by (2) with `SURE`."""
    pixels = (cut.patches.weight > 0).sum(1)
    return np.asarray(pixels + 3 * np.sqrt(2 * number) + np.maximum(one.chi2 - pixels, 0.0) / SURE)


def _best(kind: int, cut: CutOut, wanted: Floats) -> DiscFit:
    """The best of a kind."""
    if kind == CUT:
        return discs.fit(shape_images.cut, cut_start(cut), cut.patches, wanted=wanted)
    return discs.fit(shape_images.discs, disc_start(cut, kind), cut.patches, wanted=wanted)


def _plausible(kind: int, fit: DiscFit, cut: CutOut) -> NDArray[np.bool_]:
    return plausible_cut(fit, cut) if kind == CUT else plausible_discs(fit, cut, kind)


def _explained(
    fit: DiscFit, patches: Patches, *, model: float = MODEL, texture: Floats | float = 0.0
) -> NDArray[np.bool_]:
    """(n) whether the grey levels at the rim differ from the model's by noise alone, within three deviations of χ².

    What the model may be off by, a share of the brightness, counts as noise, and so does a texture (n), grey levels.
    """
    at_rim = rim(patches, fit.model)
    number = np.maximum(at_rim.sum(1), 12)
    noise = np.maximum(1 / np.maximum(patches.weight, 1e-12), np.square(texture)[..., None])
    variance = noise + (model * fit.parameters[:, -2, None]) ** 2
    chi2 = (at_rim * (patches.grey - fit.model) ** 2 / variance).sum(1)
    return np.asarray(chi2 < number * (1 + 3 * np.sqrt(2 / number)))


def _noted(kind: int, fit: DiscFit, index: NDArray[np.int64], n: int, good: NDArray[np.bool_]) -> GroupExplanation:
    """The fit of the groups of this index among n."""
    k = 1 if kind == CUT else kind if kind > ONE else 0
    chi2, plausible, blur = np.full(n, np.inf), np.zeros(n, np.bool_), np.zeros(n)
    circles, cov = np.full((n, k, 3), np.nan), np.full((n, k, 2, 2), np.nan)
    chi2[index], plausible[index], blur[index] = fit.chi2, good, fit.parameters[:, -3]
    for i in range(k):
        circles[index, i] = fit.parameters[:, 3 * i : 3 * i + 3]
        cov[index, i] = fit.cov[:, 3 * i : 3 * i + 2, 3 * i : 3 * i + 2]
    return GroupExplanation(kind, fit.parameters.shape[1], chi2, plausible, blur, circles, cov)


def _chosen(tried: list[GroupExplanation], cut: CutOut, number: NDArray[np.int64]) -> ObservedGroup:
    """The best of all explanations by (1)."""
    n = len(number)
    chi2 = np.array([t.chi2 for t in tried])
    pixels = (cut.patches.weight > 0).sum(1)
    s = np.maximum(1.0, (chi2.min(0) - (pixels - number)) / number)
    E = chi2 / s + np.array([t.size for t in tried])[:, None] * np.log(number)  # (1)
    whole = np.array([t.kind == ONE for t in tried])
    least, best, beyond = E[whole].min(0), np.full(n, -1), chi2[whole].min(0) - pixels
    simple = least - EVIDENCE
    left = np.maximum(chi2 - pixels - 3 * np.sqrt(2 * number), 0.0)
    for i in np.flatnonzero(~whole).tolist():
        wins = tried[i].plausible & (E[i] < least - EVIDENCE) & (beyond > CLEAR * left[i])  # (2)
        least, best = np.where(wins, E[i], least), np.where(wins, i, best)
    surely = np.zeros(n, np.bool_)
    for j, t in enumerate(tried):
        if t.kind > ONE:
            large = (t.circles[:, :, 2].min(1) > SMALLEST) | (t.kind == 2)
            surely |= large & (E[j] < simple) & (beyond > SURE * left[j])
    wins = best >= 0
    kind = np.where(wins, np.array([t.kind for t in tried])[best], np.where(surely, UNCLEAR, ONE))
    most = max(t.circles.shape[1] for t in tried)
    circles, cov = np.full((n, max(most, 1), 3), np.nan), np.full((n, max(most, 1), 2, 2), np.nan)
    for j, t in enumerate(tried):
        mine, k = wins & (best == j), t.circles.shape[1]
        circles[mine, :k] = t.circles[mine]
        floor = discs.FLOOR / (np.pi * t.circles[mine, :, 2] ** 2) + (CORNER * t.blur[mine, None] ** 2) ** 2
        cov[mine, :k] = t.cov[mine] * s[mine, None, None, None] + floor[..., None, None] * np.eye(2)  # (4)
    spread = np.zeros((n, 2, 2))
    unclear = np.flatnonzero(kind == UNCLEAR)
    spread[unclear] = _spread(cut.take(unclear))
    return ObservedGroup(kind, circles, cov, spread)


def _spread(cut: CutOut) -> Floats:
    """(3) in px² of the patches."""
    value, vector = np.linalg.eigh(second_moments(cut)[1])
    used = cut.patches.weight > 0
    each = zip(cut.patches.x, cut.patches.y, cut.white, used & ~cut.white, strict=True)
    r = np.array([_inscribed(x, y, white, dark) for x, y, white, dark in each])
    beyond = np.maximum(value - r.reshape(-1, 1) ** 2 / 4, 0.0)
    return np.asarray((vector * beyond[:, None]) @ vector.transpose(0, 2, 1))


def _inscribed(x: Floats, y: Floats, white: NDArray[np.bool_], dark: NDArray[np.bool_]) -> float:
    """Radius of the largest disc within the white ones of some pixels, px; dark are those round them."""
    if not white.any() or not dark.any():
        return 0.0
    far = np.hypot(x[white, None] - x[dark], y[white, None] - y[dark]).min(1)
    return float(far.max()) - 0.25


def _some(fit: DiscFit, index: NDArray[np.int64]) -> DiscFit:
    return DiscFit(*(column[index] for column in fit))
