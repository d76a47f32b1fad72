"""Images of one frame that are one marker, without knowledge of other frames.

Two images of different cameras whose rays pass each other meet in a point; it takes in every other camera the likeliest
image where it is expected. A group of n images at distances d from the projections of the point that fits them best,
their noise s, has

    χ² = Σ d² / s²,   merit = n w − χ²,   w = 2 ln(p / ((1 − p) 2π b s²))                (1)

where w is what an image is worth by (3) of `claims`. The groups with the greatest merit take their images first, those
of three and more before pairs; those that lost images are weighed again without them.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..geometry import fundamental, triangulate
from .claims import Claims, candidates, expect, information
from .images import Images
from .motion import Bools, Floats, Ints, Motion, inverse

AT_ONCE = 300
"""Images of all frames that are paired in one go: fewer waste time on overhead, more on pairs of different frames."""

MOST = 1500
"""Images of a frame that are looked at; more than these are noise."""


class Groups(NamedTuple):
    """G points: frame (G), xyz (3, G) mm, cov (3, 3, G) mm², row (C, G) of their images or −1; χ² and merit (G)."""

    frame: Ints
    xyz: Floats
    cov: Floats
    row: Ints
    squared: Floats
    merit: Floats

    def take(self, which: Ints | Bools) -> Groups:
        """Only these."""
        return Groups(
            self.frame[which],
            self.xyz[:, which],
            self.cov[..., which],
            self.row[:, which],
            self.squared[which],
            self.merit[which],
        )


class Placed(NamedTuple):
    """Points of views: xyz (3, H) mm, cov (3, 3, H) mm², squared (C, H) d²/s², −1 unseen."""

    xyz: Floats
    cov: Floats
    squared: Floats


def fundamentals(P: Floats) -> Floats:
    """(C, C, 3, 3): line in camera s = F[r, s] (u, v, 1) of camera r."""
    C = len(P)
    return np.array([[fundamental(P[r], P[s]) if r != s else np.zeros((3, 3)) for s in range(C)] for r in range(C)])


def groups_of(images: Images, free: Bools, F: Floats, frames: list[int], gate: float) -> Groups:
    """The groups of the free images of some frames, sorted by frame.

    Most images belong to markers that four and more cameras see, and these are found from pairs of cameras that stand
    side by side; all pairs of cameras are only tried on what is then left, which keeps the work in step with C.
    """
    free, C = free.copy(), len(images.P)
    between = np.abs(np.arange(C) - np.arange(C)[:, None])
    won = []
    for most, least in ((2, (4,)), (C, (3, 2))):
        tried = np.minimum(between, C - between) <= most
        rows = [rows[free[rows]] for rows in images.in_frames(frames)]
        view = np.concatenate([_near_lines(images, part, F, gate, tried) for part in _together(rows)], -1)
        if view.shape[-1]:
            view = _distinct(_completed(images, free, view, gate))
        won += _chosen(images, free, view, gate, least)
    groups = Groups(*(np.concatenate(columns, -1) for columns in zip(*won, strict=True)))
    return groups.take(np.argsort(groups.frame, kind="stable"))


def _together(rows: list[Ints]) -> list[Ints]:
    """The rows of frames of at most MOST in parts of about AT_ONCE, those of one frame never apart."""
    rows = [own for own in rows if 2 <= len(own) <= MOST]
    part = np.cumsum([len(own) for own in rows]) // AT_ONCE
    return [np.concatenate([own for own, p in zip(rows, part, strict=True) if p == k]) for k in np.unique(part)] or [
        np.zeros(0, np.int64)
    ]


def _near_lines(images: Images, rows: Ints, F: Floats, gate: float, tried: Bools) -> Ints:
    """Views (C, H) of two images, of one frame and of cameras to be tried, each near the epipolar line of the other."""
    rows = rows[np.argsort(images.camera[rows], kind="stable")]
    camera, frame, sd = images.camera[rows], images.frame[rows], np.sqrt(images.variance[rows])
    h = np.column_stack([images.uv[rows], np.ones(len(rows))])
    lines = (F.swapaxes(0, 1)[:, camera] @ h[:, :, None])[..., 0]  # (C, N, 3): of each image in each camera
    slope = np.hypot(lines[..., 0], lines[..., 1])
    cuts = np.searchsorted(camera, np.arange(len(F) + 1)).tolist()
    views = [np.zeros((len(F), 0), np.int64)]
    for c, (start, stop) in enumerate(pairwise(cuts)):
        first, second = np.nonzero((frame[:start, None] == frame[start:stop]) & tried[camera[:start], c, None])
        second += start
        product = np.abs((lines[c, first] * h[second]).sum(1))  # images of the cameras before c with those of c
        least = np.minimum(slope[c, first], slope[camera[first], second])
        near = np.flatnonzero(product < gate * least * np.hypot(sd[first], sd[second]))
        view = np.full((len(F), len(near)), -1)
        view[camera[first[near]], np.arange(len(near))] = rows[first[near]]
        view[c] = rows[second[near]]
        views.append(view)
    return np.concatenate(views, -1)


def _completed(images: Images, free: Bools, view: Ints, gate: float) -> Ints:
    """The views (C, H), each with the likeliest images where its point is expected in the other cameras."""
    point = placed(images, view)
    expected = expect(images.P, Motion(point.xyz, point.cov))
    expected.uv[np.broadcast_to((view >= 0)[:, None], expected.uv.shape)] = np.nan
    pairs = candidates(images, free, images.frame[view.max(0)], expected, gate)
    order = np.argsort(-pairs.squared, kind="stable")  # of several, the nearest is written last
    view = view.copy()
    view.reshape(-1)[pairs.own[order]] = pairs.row[order]
    return view


def _distinct(view: Ints) -> Ints:
    """The different views."""
    order = np.lexsort(view)
    new = np.ones(len(order), bool)
    new[1:] = (view[:, order[1:]] != view[:, order[:-1]]).any(0)
    return view[:, np.sort(order[new])]


def _chosen(images: Images, free: Bools, view: Ints, gate: float, leasts: tuple[int, ...]) -> list[Groups]:
    """The groups that win their images, weighed by (1), those of more images first; theirs are free no longer."""
    left = _weighed(images, view, gate)
    won = []
    for least in leasts:
        left = left.take(np.argsort(-left.merit, kind="stable"))
        kept, robbed = _award(left, free, least)
        won.append(left.take(kept))
        if least != leasts[-1]:
            view = np.where(free[left.row[:, robbed]], left.row[:, robbed], -1)
            left = _weighed(images, _distinct(view[:, (view >= 0).sum(0) >= 2]), gate)
    return won


def _award(groups: Groups, free: Bools, least: int) -> tuple[Ints, Ints]:
    """Places of the groups of `least` and more images, all free, which they are then no longer; and of the others."""
    kept, robbed = [], []
    for g, own in enumerate(groups.row.T.tolist()):
        own = [row for row in own if row >= 0]
        if len(own) >= least and free[own].all():
            free[own] = False
            kept.append(g)
        else:
            robbed.append(g)
    return np.array(kept, int), np.array(robbed, int)


def _weighed(images: Images, view: Ints, gate: float) -> Groups:
    """Points of views (C, H), without images that are too far off, and their merit."""
    point = placed(images, view)
    while (bad := point.squared.max(0, initial=0.0) > gate**2).any():
        which = np.flatnonzero(bad)
        view = view.copy()
        view[point.squared[:, which].argmax(0), which] = -1
        view = view[:, (view >= 0).sum(0) >= 2]
        point = placed(images, view)
    has = view >= 0
    worth = images.prior[:, None] - 2 * np.log(images.variance[view])
    squared = np.where(has, point.squared, 0.0).sum(0)
    merit = np.where(has, worth, 0.0).sum(0) - squared
    sure = np.flatnonzero(np.isfinite(point.xyz).all(0) & np.isfinite(point.cov).all((0, 1)))
    return Groups(images.frame[view.max(0, initial=0)], point.xyz, point.cov, view, squared, merit).take(sure)


def placed(images: Images, view: Ints) -> Placed:
    """Where the views (C, H) meet: the linear solution, and from it one step of least squares by the noise."""
    seen = view >= 0
    guess = triangulate(np.where(seen[..., None], images.uv[view], np.nan).swapaxes(0, 1), images.P).T
    expected = expect(images.P, Motion(guess, np.zeros((3, 3, 1))))
    variance = np.where(seen, images.variance[view], np.inf)
    none = np.zeros(view.shape)
    N, g = information(images, expected, Claims(view, variance, none, none > 0))
    with np.errstate(divide="ignore", invalid="ignore"):  # rays that are parallel
        cov = inverse(N)
    moved = np.einsum("ijt,jt->it", cov, g)
    off = images.uv[view].swapaxes(1, 2) - expected.uv - (expected.J * moved).sum(2)
    squared = np.where(seen, (off * off).sum(1) / variance, -1.0)
    return Placed(guess + moved, cov, np.nan_to_num(squared, nan=np.inf))
