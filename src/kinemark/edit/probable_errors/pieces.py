"""Loose pieces: two paths of which one ends where the other begins, and which may be one marker."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .paths import UNTOLD_MM, Paths, ends, meeting
from .places import REACH_MM, REACH_SPEED
from .probability import of_source, probability
from .shape import ENOUGH, distances, misfit

LONGEST_S = 1.5
"""s between two pieces, at most; chosen: motion and shape tell little over more."""
OVERLAP_S = 0.04
"""s that they may overlap, at most; chosen: a few images that one marker had twice."""
END = 20.0
"""Nats that an end and a beginning cost; chosen, as in `changes`."""


class PieceEvidence(NamedTuple):
    """What tells that two pieces are one marker.

    Attributes:
        motion: nats for it. misfit: by shape, 0 where unknown; known: 1 where it is known, else 0.
        rival: nats by which no other piece fits as well. sd: ln of the standard deviation of their distance, mm.
    """

    motion: float
    misfit: float
    known: float
    rival: float
    sd: float


class Piece(NamedTuple):
    """Path `before` ends and `after` begins: how far apart they come, mm, and how likely they are one marker; the kind
    is that of its source (`probability.of_source`)."""

    before: int
    after: int
    last: int
    first: int
    evidence: PieceEvidence
    wrong: float
    join_mm: float
    kind: str


def pieces(paths: Paths) -> list[Piece]:
    """Those that may be one marker, each end and each beginning once, the likeliest first."""
    rows = [
        (p, q)
        for p, own in enumerate(paths.frames)
        for q, other in enumerate(paths.frames)
        if p != q and len(own) and len(other) and _near(paths, p, q)
    ]
    if not rows:
        return []
    p, q = (np.array(column, np.int64) for column in zip(*rows, strict=True))
    last = np.array([len(paths.frames[k]) - 1 for k in p], np.int64)
    met = meeting(ends(paths, p, last, -1), ends(paths, q, np.zeros_like(q), 1), paths.rate, paths.q)
    motion = END - 3.5 * np.log1p(met.squared / 4) - 1.5 * np.log(2 * np.pi * met.variance)
    found = []
    for n in range(len(p)):
        f, g = int(paths.frames[p[n]][-1]), int(paths.frames[q[n]][0])
        others = ((p == p[n]) | (q == q[n])) & (np.arange(len(p)) != n)
        rival = float(np.clip(motion[n] - motion[others].max(initial=-30.0), -30, 30))
        shape = misfit(
            distances(paths, int(p[n]), f, -1), distances(paths, int(q[n]), g - 1, 1), (int(p[n]), int(q[n]))
        )
        known = np.isfinite(shape)
        if met.variance[n] > UNTOLD_MM**2 and min(len(paths.frames[p[n]]), len(paths.frames[q[n]])) < ENOUGH:
            continue  # stray images of a few frames: neither motion nor shape tells
        evidence = PieceEvidence(
            float(np.clip(motion[n], -30, 30)), shape if known else 0.0, float(known), rival,
            float(np.log(met.variance[n]) / 2),
        )  # fmt: skip
        kind = of_source("piece", bool(paths.images[p[n], f] or paths.images[q[n], g]))
        wrong = probability(kind, evidence)
        found.append(Piece(int(p[n]), int(q[n]), f, g, evidence, wrong, float(met.off[n]), kind))
    return _each_once(found)


def _near(paths: Paths, p: int, q: int) -> bool:
    """Whether q begins soon after p ends, and where p may have come; of two that overlap, p is the one that begins."""
    f, g = paths.frames[p][-1], paths.frames[q][0]
    if (paths.frames[p][0], f, p) >= (g, paths.frames[q][-1], q):
        return False
    gap = (g - f) / paths.rate
    if not -OVERLAP_S <= gap <= LONGEST_S:
        return False
    apart = float(np.linalg.norm(paths.xyz[p, f] - paths.xyz[q, g]))
    return apart < REACH_MM + REACH_SPEED * abs(gap)


def _each_once(found: list[Piece]) -> list[Piece]:
    ended, begun, kept = set[int](), set[int](), []
    for one in sorted(found, key=lambda piece: -piece.wrong):
        if one.before not in ended and one.after not in begun:
            kept.append(one)
            ended.add(one.before)
            begun.add(one.after)
    return kept
