"""Which end of a wand is which, in all cameras alike, where an image alone does not tell.

Each camera c and frame f has a sign s = ±1: whether the markers keep the order in which they were read. With the
fundamental matrix F of two cameras, a frame costs

    d² = Σ over markers of the squared epipolar distance                 (1)

for equal signs, and another sum for opposite ones. Half their difference, in units of their variance and
bounded so that one wrong point does not outweigh the rest, is the evidence of the pair,

    e_ij = bounded (d²(opposite) − d²(equal)) / 2σ²                      (2)

and the signs of a frame are those that maximise

    Σ_{i<j} e_ij s_i s_j + Σ_i u_i s_i                                   (3)

where u is what the gaps tell. u joins as one more camera, "the wand as made", with s = 1. The eigenvector of
the greatest eigenvalue of e starts (3), and changes of single signs that raise it end it. Without u, where the wand
looks the same from both ends, turning all signs of a frame changes nothing, and nothing has to.

F needs matched points, and those need the signs. Four frames have two markers each, the eight points that F asks for,
and sixteen ways of signs, of which one is right. So F is the one of all ways of many such samples for which the median
over the frames of the lesser d² is least (4). It decides the signs of most frames; from their markers follows a better
one, and so on.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product

import numpy as np

from ...data import Camera, KinemarkError
from ...data.array_types import Bools, Floats
from ...geometry import undistort
from ...geometry.epipolar import fundamental
from ...geometry.two_view import fit_fundamental, fundamentals, sampson_distance
from ...numerics.evenly import evenly

FEWEST = 16
"""Frames that two cameras must share to tell anything about each other; chosen (see benchmarks/bundle.py)."""
SAMPLED, SAMPLES, SCORED = 4, 30, 100
"""Frames of a sample, samples, and frames that (4) is taken of at most. The first by definition, the others chosen for
speed: with a third of the frames wrong six samples are right."""
WAYS = np.array(list(product((False, True), repeat=SAMPLED)))
"""(16, 4) the signs that a sample's frames may have; by definition."""
LEAST_SPREAD = 0.3
"""px; noise below which epipolar distances are not believed; chosen (see benchmarks/bundle.py)."""
ROUNDS = 6  # of signs and fundamental matrices in turn; chosen (see benchmarks/bundle.py)
STRONGEST = 20.0
"""Bound of (2); chosen (see benchmarks/bundle.py)."""
SURE = 3.0
"""Evidence below which a camera's sign is left open; chosen (see benchmarks/bundle.py)."""


def agreed_ends(uv: Floats, lead: Floats, cameras: Sequence[Camera] | None = None) -> tuple[Bools, Bools]:
    """Where the order of the markers (C, F, K, 2) px, NaN where not read, must be turned, and where that is open.

    Args:
        uv: the markers of each image in the order in which they were read.
        lead: (C, F) how much more likely that order is than the other, as 2 ln of odds.
        cameras: (C), where they are known already; F of two is theirs then.

    Returns:
        turned (C, F) and open (C, F).
    """
    n = len(uv)
    if cameras is not None:
        uv = np.stack([undistort(camera, each) for camera, each in zip(cameras, uv, strict=True)])
    evidence = np.zeros((uv.shape[1], n + 1, n + 1))
    for i, j in combinations(range(n), 2):
        F = None if cameras is None else fundamental(cameras[i].P, cameras[j].P)
        evidence[:, i, j] = evidence[:, j, i] = pair_evidence(uv[i], uv[j], F)
    known = np.clip(lead.T / 2, -STRONGEST, STRONGEST)
    evidence[:, :n, n] = evidence[:, n, :n] = known
    sign, support = best_signs(evidence)
    sign = sign[:, :n] * np.where(known.any(1), sign[:, n], 1.0)[:, None]
    return (sign < 0).T, (support[:, :n] < SURE).T


def nearer_ends(uv: Floats, known: Bools, cameras: Sequence[Camera]) -> Bools:
    """Where markers (C, F, K, 2) px, NaN where not read, are nearer to the epipolar lines of the others in the other
    order, however far that is; of images whose ends are not `known` (C, F), which are asked camera by camera."""
    uv = np.stack([undistort(camera, each) for camera, each in zip(cameras, uv, strict=True)])
    read: Bools = np.asarray(np.isfinite(uv).all((2, 3)))
    settled, turned = read & known, np.zeros(known.shape, np.bool_)
    for c in range(len(uv)):
        gain = np.zeros(uv.shape[1])
        for d in range(len(uv)):
            both = read[c] & ~known[c] & settled[d] & (c != d)
            equal, opposite = _costs(fundamental(cameras[c].P, cameras[d].P), uv[c, both], uv[d, both])
            gain[both] += equal - opposite
        turned[c] = gain > 0
        uv[c] = np.where(turned[c, :, None, None], uv[c, :, ::-1], uv[c])
        settled[c] = read[c]
    return turned


def pair_evidence(uv1: Floats, uv2: Floats, F: Floats | None = None) -> Floats:
    """(2) of two cameras that see markers (F, K, 2): (F), 0 where one of them does not or nothing is known; by their
    fundamental matrix F of ideal pixels where it is known."""
    seen = np.isfinite(uv1).all((1, 2)) & np.isfinite(uv2).all((1, 2))
    evidence = np.zeros(len(uv1))
    if seen.sum() < FEWEST:
        return evidence
    a, b = uv1[seen], uv2[seen]
    try:
        equal, opposite = epipolar_costs(a, b) if F is None else _costs(F, a, b)
    except KinemarkError:
        return evidence  # the cameras are in one place, or the wand was held still
    evidence[seen] = _evidence(equal, opposite, a.shape[1])
    return evidence


def epipolar_costs(a: Floats, b: Floats, samples: int = SAMPLES) -> tuple[Floats, Floats]:
    """(1) of two cameras that see markers (n, K, 2) for equal and for opposite signs, (n) px² each, by the best F.

    Raises:
        KinemarkError: no F fits.
    """
    F, before = _first_guess(a, b, samples), None
    for _ in range(ROUNDS):
        equal, opposite = _costs(F, a, b)
        turned = opposite < equal
        if before is not None and (turned == before).all():
            break
        F = _from_markers(a, np.where(turned[:, None, None], b[:, ::-1], b), equal, opposite)
        before = turned
    return _costs(F, a, b)


def _first_guess(a: Floats, b: Floats, samples: int) -> Floats:
    """F by (4) from markers (n, K, 2) of two cameras."""
    rng = np.random.default_rng(0)
    sample = rng.random((samples, len(a))).argpartition(SAMPLED - 1, axis=1)[:, :SAMPLED]
    x, y = a[sample][:, None, :, [0, -1]], b[sample][:, None, :, [0, -1]]  # the ends (SAMPLES, 1, SAMPLED, 2, 2)
    y = np.where(WAYS[..., None, None], y[..., ::-1, :], y)
    F = fundamentals(np.broadcast_to(x, y.shape).reshape(-1, 8, 2), y.reshape(-1, 8, 2))
    some = evenly(len(a), SCORED)
    lesser = np.minimum(*_costs(F[:, None, None], a[some], b[some]))
    return np.asarray(F[np.median(lesser, axis=1).argmin()])


def _costs(F: Floats, a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """(1) for equal and for opposite signs, (…, n) px² each."""
    return (sampson_distance(F, a, b) ** 2).sum(-1), (sampson_distance(F, a, b[:, ::-1]) ** 2).sum(-1)


def _from_markers(a: Floats, b: Floats, equal: Floats, opposite: Floats) -> Floats:
    """F from the markers of frames that fit well; those that fit either way tell as much."""
    cost = np.minimum(equal, opposite)
    good = cost <= 9 * max(np.median(cost), LEAST_SPREAD**2)
    return fit_fundamental(a[good].reshape(-1, 2), b[good].reshape(-1, 2))


def _evidence(equal: Floats, opposite: Floats, K: int) -> Floats:
    """(2): frames that fit neither way tell nothing."""
    variance = max(np.median(np.minimum(equal, opposite)) / K, LEAST_SPREAD**2)
    most = 2 * STRONGEST
    return (np.minimum(opposite / variance, most) - np.minimum(equal / variance, most)) / 2


def best_signs(evidence: Floats) -> tuple[Floats, Floats]:
    """Signs (F, n) that maximise (3) for symmetric evidence (F, n, n) with zero diagonal, and their support (F, n).

    The support of a sign is by how much (3) would fall, halved, were it turned.
    """
    sign = np.where(np.linalg.eigh(evidence)[1][..., -1] < 0, -1.0, 1.0)
    for _ in range(evidence.shape[-1]):
        before = sign.copy()
        for i in range(evidence.shape[-1]):
            pull = np.einsum("fj,fj->f", evidence[:, i], sign)
            sign[:, i] = np.where(pull == 0, sign[:, i], np.sign(pull))
        if (sign == before).all():
            break
    return sign, np.einsum("fij,fi,fj->fi", evidence, sign, sign)
