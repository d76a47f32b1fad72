"""Which detected dot is which point of a known body or target, from a few that were picked by hand.

A camera sends the point x of the body, as coordinates about the middle of those used, to

    u = (a · x + a0) / (1 + c · x),    v = (b · x + b0) / (1 + c · x)     (1)

Times the denominator this is linear in the eleven unknowns (with x in the plane, if all points used lie in one: eight).
Three or four points do not tell them all, nor do six on two lines; so with u, v and x scaled to unit size

    Σ (a · x + a0 − u (1 + c · x))² + (b · x + b0 − v (1 + c · x))² + λ² |c|²   (2)

is made least: what the points leave open of the perspective c is zero, and (1) then an affine map; where they are many,
λ has no weight. The picked points give a first map. Then, again and again: all points are sent into the image; each
takes the dot nearest to it, if it also is that dot's nearest point and lies within a reach; and the map is found anew
from all of these. The reach is half the way to the next point at first, so that neighbours are not mistaken, and in the
end twenty times the median distance, at most `tolerance` (3): a dot measured badly is still that dot. The map knows no
lens, so `tolerance` must leave room for one.

Points picked in one plane say nothing of how far others stand out of it. From close by, a level of the target may then
be taken for its neighbour, with small residuals for all that is named; but the points at the rim find no dot. So a
target of which more than a tenth is not found is refused (4).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data import KinemarkError
from ..data.array_types import Floats, Ints

Map = Callable[[Floats], Floats]

FLAT = 1e-3  # of the greatest spread; points thinner than this lie on a line or in a plane; chosen
ROUNDS = 12  # of assigning and fitting in turn, at most; chosen
NEAR = 0.5  # of the distance to the next target point; chosen: farther off, an image is nearer to another one
OFF = 20.0  # times the median distance that counts as near; chosen, wide, as the first fit is rough
LEAST = 1.0  # px; the least that counts as near, however well all fits; chosen
FOUND = 0.9  # of the target's points that must be found; chosen, lest one be taken for another
PERSPECTIVE = 0.1
"""λ of (2); chosen."""


def assign_points(uv: Floats, xyz: Floats, *, picked: NDArray[np.integer], at: Floats, tolerance: float = 5.0) -> Ints:
    """Which dot (n, 2) px is which point (M, 3) mm of a target: (M) row of `uv`, −1 where none.

    Args:
        uv: (n, 2) detected dots, any others among them.
        xyz: (M, 3) the target's points.
        picked: (m) rows of `xyz` that were picked by hand, at least three.
        at: (m, 2) where, px; nearer to the right dot than to any other.
        tolerance: how far from its place by the map from all dots a dot may be, px.

    Raises:
        ValueError: the arrays do not fit each other, or `tolerance` is not positive.
        KinemarkError: the picked points are too few or lie on a line, or more than a tenth of the target is not found.
    """
    if uv.ndim != 2 or uv.shape[1] != 2 or xyz.ndim != 2 or xyz.shape[1] != 3 or at.shape != (len(picked), 2):
        raise ValueError(
            f"uv, xyz and at have shapes {uv.shape}, {xyz.shape}, {at.shape}, wanted (n, 2), (M, 3), (m, 2)"
        )
    if not tolerance > 0:
        raise ValueError(f"tolerance is {tolerance}, wanted a positive number of px")
    to_image = _map(xyz[picked], at)
    index, before = np.full(len(xyz), -1, np.int64), None
    for turn in range(ROUNDS):
        places = to_image(xyz)
        reach = (
            NEAR * _to_next(places) if turn < ROUNDS // 2 else np.full(len(xyz), _close(places, uv, index, tolerance))
        )
        index = _mutual(places, uv, reach)
        if turn > ROUNDS // 2 and before is not None and (index == before).all():
            break
        before = index
        if (index >= 0).sum() >= len(picked):
            to_image = _map(xyz[index >= 0], uv[index[index >= 0]])
    if (index >= 0).sum() < FOUND * len(xyz):  # (4)
        raise KinemarkError(
            f"{(index >= 0).sum()} of the target's {len(xyz)} points are found among {len(uv)} dots, wanted at "
            f"least {FOUND:.0%}, lest one be taken for another. Pick more points, off one plane if the target is not "
            "flat, and check which were picked, and where, and the threshold."
        )
    return index


def _map(xyz: Floats, uv: Floats) -> Map:
    """(1) from points (m, 3) at (m, 2) px by (2)."""
    centre = xyz.mean(0) if len(xyz) else np.zeros(3)
    _, s, axes = np.linalg.svd(xyz - centre) if len(xyz) else (None, np.zeros(3), np.eye(3))
    if len(xyz) < 3 or s[1] < FLAT * s[0]:
        raise KinemarkError(
            f"{len(xyz)} points of the target are picked, wanted at least three that are not on one line. Pick more."
        )
    k = 2 if len(xyz) == 3 or s[2] < FLAT * s[0] else 3
    size, origin, reach = np.sqrt((s**2).sum() / len(xyz)), uv.mean(0), uv.std()
    x, at = (xyz - centre) @ axes[:k].T / size, (uv - origin) / reach
    whole = np.column_stack([x, np.ones(len(x))])
    zero = np.zeros_like(whole)
    rows = [
        np.hstack([whole, zero, -at[:, :1] * x]),
        np.hstack([zero, whole, -at[:, 1:] * x]),
        np.hstack([np.zeros((k, 2 * k + 2)), PERSPECTIVE * np.eye(k)]),
    ]
    found = np.linalg.lstsq(np.concatenate(rows), np.concatenate([at.T.ravel(), np.zeros(k)]))[0]  # (2)

    def to_image(points: Floats) -> Floats:
        x = (points - centre) @ axes[:k].T / size
        above = np.column_stack([x, np.ones(len(x))]) @ found[: 2 * k + 2].reshape(2, k + 1).T
        return np.asarray(origin + reach * above / (1 + x @ found[2 * k + 2 :])[:, None])  # (1)

    return to_image


def _close(places: Floats, uv: Floats, index: Ints, tolerance: float) -> float:
    """What is near in the end: some times as far as most dots are off, at most `tolerance`, px."""
    seen = index >= 0
    distance = np.linalg.norm(places[seen] - uv[index[seen]], axis=1)
    return float(min(tolerance, max(OFF * np.median(distance), LEAST))) if seen.any() else tolerance


def _to_next(places: Floats) -> Floats:
    """(M) px from each place to the nearest other one."""
    return np.asarray(scipy.spatial.KDTree(places).query(places, k=2)[0])[:, 1]


def _mutual(places: Floats, uv: Floats, reach: Floats) -> Ints:
    """(M) the dot (n, 2) nearest to each place (M, 2), if each is the other's nearest and within reach (M); or −1."""
    if len(uv) == 0:
        return np.full(len(places), -1, np.int64)
    distance, dot = scipy.spatial.KDTree(uv).query(places)
    place = np.asarray(scipy.spatial.KDTree(places).query(uv)[1])
    good = (distance <= reach) & (place[dot] == np.arange(len(places)))
    return np.where(good, dot, -1).astype(np.int64)
