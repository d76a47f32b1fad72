"""Bodies that are one: seen at different times, by other tracks, but of one shape.

Three members that span much are laid on all threes of another body of which the sides agree; from there all members
take their nearest, and the fit is made again. Where ALIKE of the members of the smaller body, MEMBERS and more, lie
within reach of the other's, CLEARLY more than in any other way (1), the shapes are one. A body that is like two others,
or was seen beside the one that it is like, as clusters of one make are, stays by itself.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ....geometry import rigid_align
from ....signal import assign
from .rigid_bodies import MEMBERS, RigidBody

ALIKE, CLEARLY = 0.6, 2
"""Of (1), a share of the members, and how many; chosen (see studies/infrared_footage.py)."""

TRIPLES = 12
"""Threes of members that are laid on those of the other body, those of the largest area; chosen: one may be missing."""

TOGETHER = 0.05
"""Share of a body's frames that another has as well, which is then not the same one; chosen: pieces of one body overlap
where a track ends late."""


class Laid(NamedTuple):
    """A pose R, t that lays one shape on another, and which members are one (n) each."""

    R: Floats
    t: Floats
    one: Ints
    other: Ints


def joined_bodies(bodies: list[RigidBody], there: Bools) -> list[RigidBody]:
    """Bodies of one shape as one; `there` (N, F) where tracks are."""
    out: list[RigidBody] = []
    for body in bodies:
        like = [(i, laid) for i, other in enumerate(out) if (laid := laid_on(other, body)) is not None]
        if len(like) == 1 and not _together(out[like[0][0]], body, there):
            i, laid = like[0]
            out[i] = _both(out[i], body, laid)
        else:
            out.append(body)
    return out


def _together(one: RigidBody, other: RigidBody, there: Bools) -> bool:
    """Whether two bodies were seen at the same time."""
    seen = [(there[body.member >= 0].sum(0) >= MEMBERS - 1) for body in (one, other)]
    return bool((seen[0] & seen[1]).sum() > TOGETHER * min(seen[0].sum(), seen[1].sum()))


def laid_on(one: RigidBody, other: RigidBody) -> Laid | None:
    """The pose by which another body is one, by (1); None where it is none, or where there are several."""
    A, B, reach = one.shape, other.shape, float(min(one.reach.min(), other.reach.min()))
    least = max(MEMBERS, ALIKE * min(len(A), len(B)))
    found = [laid for pose in _starts(A, B, reach / 2) if (laid := _laid(A, B, *pose, reach))]
    if not found:
        return None
    best = max(found, key=lambda laid: len(laid.one))
    at = B @ best.R.T + best.t
    rival = max(
        (len(laid.one) for laid in found if np.linalg.norm(B @ laid.R.T + laid.t - at, axis=1).mean() > reach),
        default=0,
    )
    return best if len(best.one) >= least and len(best.one) - rival >= CLEARLY else None


def _starts(A: Floats, B: Floats, off: float) -> list[tuple[Floats, Floats]]:
    """Poses that lay three places of B (L, 3) on three of A (K, 3), the sides agreeing to `off` mm."""
    triples = np.array(list(combinations(range(len(B)), 3)))
    area = np.linalg.norm(np.cross(B[triples[:, 1]] - B[triples[:, 0]], B[triples[:, 2]] - B[triples[:, 0]]), axis=1)
    apart, poses = np.linalg.norm(A[:, None] - A, axis=-1), []
    for triple in triples[np.argsort(-area, kind="stable")[:TRIPLES]]:
        side = [np.linalg.norm(B[triple[k]] - B[triple[k - 1]]) for k in range(3)]
        fits = [np.abs(apart - length) < off for length in side]
        for three in np.argwhere(fits[1][:, :, None] & fits[2][None] & fits[0].T[:, None]):
            if len(set(three.tolist())) == 3:
                poses.append(rigid_align(B[triple], A[three]))
    return poses


def _laid(A: Floats, B: Floats, R: Floats, t: Floats, reach: float) -> Laid | None:
    """The fit of all places of B (L, 3) that lie near some of A (K, 3) by a pose."""
    for _ in range(2):
        one, other = assign(np.linalg.norm(A[:, None] - (B @ R.T + t), axis=-1), np.full(len(A), reach))
        if len(one) < 3:
            return None
        R, t = rigid_align(B[other], A[one])
    return Laid(R, t, one, other)


def _both(one: RigidBody, other: RigidBody, laid: Laid) -> RigidBody:
    """One body of two; members that only the other has are added."""
    number = np.full(len(other.shape), -1)
    number[laid.other] = laid.one
    new = np.flatnonzero(number < 0)
    number[new] = len(one.shape) + np.arange(len(new))
    member = np.where(other.member >= 0, number[other.member], one.member)
    shape = np.concatenate([one.shape, other.shape[new] @ laid.R.T + laid.t])
    return RigidBody(shape, np.concatenate([one.sd, other.sd[new]]), member)
