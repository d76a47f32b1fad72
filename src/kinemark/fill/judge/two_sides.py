"""Gaps after which a marker is elsewhere on its body: put on anew, or another marker.

No hold-out gap tells of it, as the marker is the same on both sides of each. The markers that keep their distance from
it best, on the side where that varies more, are its references. A rigid motion (R, c) lays their shape in one frame on
them in every other, and the marker x lies in them at

    q(t) = R(t)ᵀ (x(t) − c(t))                                                                             (1)

Skin and joints move q too. How much is usual, the trial itself tells. With a(n) the mean of q over the n frames after
an interval as long as the gap, and b(m) that over the m frames before it, the step over the gap is |a − b| (2). The
same of all intervals in which the marker is seen throughout has the greatest value u. The marker's place in the
references, and theirs in their own shape, change by (2) and by s. The two sides contradict each other where

    |a − b| > STEP d,    |a − b| > TIMES_OWN s    and    |a − b| > TIMES_USUAL u                          (3)

with d the distance within which a quarter of the other markers lie, so that animals of any size, and lengths in any
unit, are told alike (4). They do so in windows of one of two lengths: the short ones tell of short gaps, the long ones
average over a part of a stride, and the short ones must show half of their step. Where few intervals are seen
throughout, u is taken over all that the gap has no part in, and where the trial is too short for these, it is the
breadth of all window means of a side.

A reference may itself be elsewhere after the gap. So all of them are tried, and all but each. Of the set with the least
s the first and second of (3) must hold, for without the one that moved the marker's own step is small, and of one set
all three.

Where references are missing in the gap too, a whole segment may have been exchanged in it, or moved: they went along,
and (3) does not hold. A marker that is seen throughout the gap cannot have been exchanged in it. So references
are the one of these that keeps its distance best, of whatever segment, and those that move with it. Three are enough,
as none of them moved (5). Parts move far against each other, but not in all directions: a leg swings to the front and
to the back, and hardly ever to the other side. So for the last of (3) a step r counts

    |r|² = rᵀ (C + (NOISE STEP d)² I)⁻¹ r,    C the mean of u uᵀ over all usual steps u                      (6)

and must be TIMES_LIMB times that of the greatest. Usual steps must begin in as many frames as a window has: one place
of a stride says little.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...geometry import rigid_poses
from ..marker_array import Gap, MarkerArray
from ..methods.rigid_body import on_line

WINDOWS_S = (0.1, 0.5)
"""s of the two lengths of windows; chosen: see docs/theory/fill.md."""
AROUND_S = 4.0
"""s before and after a gap that are looked at, besides its own length; chosen: some strides."""
FEWEST = 3
"""Frames without a gap that a side must have; chosen: fewer are a ghost more often than a marker."""
REFERENCES, LEAST = 5, 4
"""Reference markers, at most and at least: three must be left where one moved; by definition."""
WITNESSES = 3
"""Of (5), at least: three define a frame; by definition."""
NOISE = 1 / 3
"""Share of the least step that usual steps vary by in any direction (6); chosen."""
RANKED = 20
"""Frames of each side in which distances are compared; chosen for time."""
SHAPED = 32
"""Frames of which the middle one that shows all references gives their shape; chosen for time."""
LOOKED = 6
"""Frames of a window that are looked at before anything is worked out in full; chosen for time."""
FLAT = 0.1
"""Least breadth of the references' shape over its length; chosen, as in `rigid_body`."""
STEP = 0.04
"""Share of d of (3), below which a step is none; chosen: about a marker's diameter, 15 mm on an adult. A quarter of all
markers are within 0.2 to 0.6 m of one, on trunk and limbs alike, also where there are two subjects."""
QUARTER = 0.25
"""Of the other markers, those that are within d of (4); by definition."""
TIMES_OWN = 4.5
"""Times s of (3), without unit; chosen: references that are out of shape turn what they carry."""
SCREEN = 0.8
"""Share of the least step: where the marker is off by less in the first frame after the gap, no more is asked; chosen
for time."""
HALF = 0.5
"""Share of the step that is there right beside the gap; chosen: what grows over half a second is a movement."""
ENOUGH = 0.5
"""Share of the intervals without the gap in which the marker must be seen throughout; chosen: fewer do not show how it
moves."""
TIMES_USUAL = 1.5
"""Times u of (3), without unit; chosen: see docs/theory/fill.md."""
TIMES_LIMB = 2.0
"""Times the greatest usual step by (6), without unit; chosen: see docs/theory/fill.md."""


class _Window(NamedTuple):
    """The m frames before an interval, those in it, and the n after it."""

    before: int
    inside: int
    after: int

    def beside(self, gap: Gap) -> Ints:
        """Some of its frames on both sides of a gap, those before it first, as many of each."""
        before = np.linspace(gap.start - self.before, gap.start - 1, LOOKED)
        return np.append(before, np.linspace(gap.stop, gap.stop + self.after - 1, LOOKED)).round().astype(np.int64)


class _Steps(NamedTuple):
    """mm by which references are elsewhere in their shape after the gap, at most (s), and the marker in them (2)."""

    references: float
    marker: float
    apart: Floats = np.zeros(3)
    """(3) mm, that of the marker, in the references' frame."""


class _Body(NamedTuple):
    """Reference markers and their shape (N, 3) mm, about its mean."""

    references: Ints
    shape: Floats

    @classmethod
    def shown(cls, x: Floats, references: Ints) -> _Body | None:
        """From one frame of the trial (M, F, 3) that shows all; None where there is none, or they lie on a line."""
        points = x[references, :: max(1, x.shape[1] // SHAPED)].swapaxes(0, 1)
        points = points[np.isfinite(points).all((1, 2))]
        if not len(points) or on_line(middle := points[len(points) // 2], FLAT):
            return None
        return cls(references, middle - middle.mean(0))

    def places(self, x: Floats, marker: int, frames: Ints | slice) -> Floats:
        """(F, N + 1, 3) mm, (1) of the references and of the marker, which is last; NaN where one is missing."""
        points = x[np.append(self.references, marker)][:, frames].swapaxes(0, 1)
        out = np.full_like(points, np.nan)
        there = np.isfinite(points).all((1, 2))
        R, c = rigid_poses(self.shape, points[there, :-1])
        out[there] = (points[there] - c[:, None]) @ R
        return out


def apart_on_the_body(motion: MarkerArray, gap: Gap) -> float:
    """By how many mm a marker is elsewhere on its body after a gap, where (3) holds; else 0."""
    reach = round(AROUND_S * motion.rate) + gap.length
    first = max(gap.start - reach, 0)
    x, gap = motion.xyz[:, first : gap.stop + reach], Gap(gap.marker, gap.start - first, gap.stop - first)
    windows = _windows(x, gap, motion.rate)
    if not windows:
        return 0.0
    references, least = _references(x, gap, windows[-1]), STEP * _extent(x, gap)
    return _marker_apart(x, references, gap, windows, least) or _segment_apart(x, references, gap, windows, least)


def _marker_apart(x: Floats, references: Ints, gap: Gap, windows: list[_Window], least: float) -> float:
    """The step (2), mm, of a marker on its own segment; 0 where it is none."""
    if len(references) < LEAST or _carried(x, references, gap, least):
        return 0.0
    every = _Body.shown(x, references)
    if every is not None and _steps(x, every, gap, windows[0]).marker < least:
        return 0.0
    fewer = [_Body.shown(x, np.delete(references, k)) for k in range(len(references))]
    bodies = [body for body in (every, *fewer) if body is not None]
    return _apart(x, bodies, gap, windows, least)


def _segment_apart(x: Floats, references: Ints, gap: Gap, windows: list[_Window], least: float) -> float:
    """The same against (5), where some of its references are missing in the gap too, or there are too few."""
    lost = np.logical_or.reduce(np.isnan(x[:, gap.start - 1 : gap.stop + 1, 0]), axis=1)
    if len(references) >= LEAST and not lost[references].any():
        return 0.0
    witnesses = _witnesses(x, lost, gap, windows[-1])
    body = _Body.shown(x, witnesses) if len(witnesses) >= WITNESSES else None
    if body is None:
        return 0.0
    for window in windows:
        step = _steps(x, body, gap, window)
        if step.marker > max(least, TIMES_OWN * step.references) and _beyond_usual(x, body, gap, window, step, least):
            return step.marker
    return 0.0


def _witnesses(x: Floats, lost: Bools, gap: Gap, window: _Window) -> Ints:
    """(5): of the markers that are not lost (M) the one that keeps its distance best, and those that move with it."""
    seen = np.where(lost[:, None, None], np.nan, x)
    seen[gap.marker] = x[gap.marker]
    nearest = _references(seen, gap, window)[:1]
    seen[gap.marker] = np.nan
    others = [_references(seen, gap._replace(marker=k), window) for k in nearest.tolist()]
    return np.concatenate([nearest, *others])[:REFERENCES]


def _beyond_usual(x: Floats, body: _Body, gap: Gap, window: _Window, step: _Steps, least: float) -> bool:
    """(6)."""
    usual = _usual_steps(body.places(x, gap.marker, slice(None))[:, -1], x, gap, window)
    if len(usual) < sum(window):
        return False
    L = np.linalg.cholesky(usual.T @ usual / len(usual) + (NOISE * least) ** 2 * np.eye(3))
    own, most = (np.linalg.norm(np.linalg.solve(L, r.T), axis=0).max() for r in (step.apart[None], usual))
    return bool(own > TIMES_LIMB * most)


def _extent(x: Floats, gap: Gap) -> float:
    """d of (4), mm, in the last frame before the gap and the first after it."""
    beside = x[:, [gap.start - 1, gap.stop]]
    difference = np.delete(beside - beside[gap.marker], gap.marker, axis=0).reshape(-1, 3)
    square = np.einsum("ni,ni->n", difference, difference)
    square = square[np.isfinite(square)]
    k = int(QUARTER * len(square))
    return float(np.sqrt(np.partition(square, k)[k])) if len(square) else 0.0


def _apart(x: Floats, bodies: list[_Body], gap: Gap, windows: list[_Window], least: float) -> float:
    """The step (2), mm, where (3) holds with steps from `least` mm; else 0."""
    near = [_steps(x, body, gap, windows[0]) for body in bodies]
    for window in windows if bodies else ():
        steps = near if window is windows[0] else [_steps(x, body, gap, window) for body in bodies]
        off = [
            far.marker > max(least, TIMES_OWN * far.references) and beside.marker > HALF * far.marker
            for beside, far in zip(near, steps, strict=True)
        ]
        if not off[int(np.argmin([step.references for step in steps]))]:
            continue
        for body, step, is_off in zip(bodies, steps, off, strict=True):
            if is_off and step.marker > TIMES_USUAL * _usual(
                body.places(x, gap.marker, slice(None))[:, -1], x, gap, window
            ):
                return step.marker
    return 0.0


def _carried(x: Floats, references: Ints, gap: Gap, least: float) -> bool:
    """Whether the references carry the marker from the last frame before the gap to about where it is in the first.

    By less than a share of `least` mm.
    """
    last, first = x[np.append(references, gap.marker)][:, [gap.start - 1, gap.stop]].swapaxes(0, 1)
    if not np.isfinite(last + first).all():
        return False
    R, c = rigid_poses(last[:-1], first[None, :-1])
    return bool(np.linalg.norm(R[0] @ (last[-1] - last[:-1].mean(0)) + c[0] - first[-1]) < SCREEN * least)


def _windows(x: Floats, gap: Gap, rate: float) -> list[_Window]:
    """Of both lengths, within what is seen beside the gap without another; none where that is too little."""
    seen = np.isfinite(x[gap.marker, :, 0])
    before, after = ~seen[: gap.start][::-1], ~seen[gap.stop :]
    m = int(before.argmax()) if before.any() else len(before)
    n = int(after.argmax()) if after.any() else len(after)
    if min(m, n) < FEWEST:
        return []
    longest = [max(FEWEST, round(s * rate)) for s in WINDOWS_S]
    return list(dict.fromkeys(_Window(min(m, most), gap.length, min(n, most)) for most in longest))


def _references(x: Floats, gap: Gap, window: _Window) -> Ints:
    """Markers seen on both sides that keep their distance best, by the side on which it varies more."""
    beside = np.isfinite(x[:, window.beside(gap), 0])
    there = beside[:, :LOOKED].any(1) & beside[:, LOOKED:].any(1)
    own = np.isfinite(x[gap.marker, :, 0])
    varies = np.zeros(len(x))
    for frames in (np.flatnonzero(own[: gap.start]), gap.stop + np.flatnonzero(own[gap.stop :])):
        frames = frames[:: max(1, len(frames) // RANKED)]
        difference = x[:, frames] - x[gap.marker, frames]
        distance = np.sqrt(np.einsum("mfi,mfi->mf", difference, difference))
        known = np.isfinite(distance)
        count = np.maximum(known.sum(1), 1)
        mean = np.where(known, distance, 0.0).sum(1) / count
        spread = np.sqrt((np.where(known, distance - mean[:, None], 0.0) ** 2).sum(1) / count)
        varies = np.maximum(varies, np.where(known.sum(1) >= max(2, len(frames) // 2), spread, np.inf))
    varies[~there] = np.inf
    varies[gap.marker] = np.inf
    order = np.argsort(varies, kind="stable")[:REFERENCES]
    return order[np.isfinite(varies[order])]


def _steps(x: Floats, body: _Body, gap: Gap, window: _Window) -> _Steps:
    """(2) over the gap; none where a side does not show all."""
    q = body.places(x, gap.marker, window.beside(gap))
    known = np.isfinite(q[:, -1, 0])
    if not (known[:LOOKED].any() and known[LOOKED:].any()):
        return _Steps(0.0, 0.0)
    apart = q[LOOKED:][known[LOOKED:]].mean(0) - q[:LOOKED][known[:LOOKED]].mean(0)
    step = np.linalg.norm(apart, axis=1)
    return _Steps(float(step[:-1].max()), float(step[-1]), apart[-1])


def _usual(q: Floats, x: Floats, gap: Gap, window: _Window) -> float:
    """u of (3), from the marker in its references (F, 3)."""
    steps = _usual_steps(q, x, gap, window)
    if len(steps):
        return float(np.linalg.norm(steps, axis=1).max())
    b, a = _means(q, window.before), _means(q, window.after)
    return max(_breadth(b[: gap.start - window.before + 1]), _breadth(a[gap.stop :]))


def _usual_steps(q: Floats, x: Floats, gap: Gap, window: _Window) -> Floats:
    """(K, 3) mm, (2) of all intervals, from the marker in its references (F, 3); none where none is known."""
    b, a = _means(q, window.before), _means(q, window.after)
    first = np.arange(len(q) - sum(window) + 1)
    steps = a[first + window.before + window.inside] - b[first]
    missing = np.append(0, np.cumsum(np.isnan(x[gap.marker, :, 0])))
    known = np.isfinite(steps[:, 0])
    whole = known & (missing[first + sum(window)] == missing[first])
    elsewhere = known & ((first + sum(window) <= gap.start) | (first >= gap.stop))
    return np.asarray(steps[whole] if whole.sum() > ENOUGH * elsewhere.sum() else steps[elsewhere])


def _means(q: Floats, n: int) -> Floats:
    """(F − n + 1, 3) means of all windows of n frames, from the first frame of each; NaN where half is missing."""
    known = np.isfinite(q[:, 0])
    sums = np.vstack([np.zeros(3), np.cumsum(np.where(known[:, None], q, 0.0), axis=0)])
    counts = np.append(0, np.cumsum(known))
    count = counts[n:] - counts[:-n]
    mean = (sums[n:] - sums[:-n]) / np.maximum(count, 1)[:, None]
    return np.where((2 * count >= n)[:, None], mean, np.nan)


def _breadth(means: Floats) -> float:
    """mm, diagonal of the box about places (K, 3) of which some are known; 0 of none."""
    known = means[np.isfinite(means[:, 0])]
    return float(np.linalg.norm(np.ptp(known, axis=0))) if len(known) else 0.0
