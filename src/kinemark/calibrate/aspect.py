"""The aspect ratio of a camera's pixels, from a bar that is turned before it (UM²AS 4.1).

A bar carries 2 m markers, symmetric about its middle (the thesis: 14), and is turned in steps in a plane that faces the
camera. The distance between marker i and its opposite, k = 1 … S being the steps,

    d_ik = √((U_{2m+1−i,k} − U_ik)² + (V_{2m+1−i,k} − V_ik)²)             UM²AS eq. 4.1   (1)

is the same at every step for a camera with square pixels. Otherwise V must be multiplied by a factor (eq. 4.2). With
the bar level, V has no part in (1), so that the true distance is (eq. 4.3)

    d_i = |U_{2m+1−i} − U_i|     at the level step                                        (2)

and at all others, with ΔU and ΔV the differences in (1), (CF ΔV)² + ΔU² = d_i² gives

    CF² = (d_i² − ΔU²) / ΔV²                                                              (3)

UM²AS prints this as eq. 4.4 with CF on the left, not CF². Taken as printed, with eq. 4.2, distances would remain
unequal: for true pixels of 0.8407 they would be scaled by 0.7068. As the thesis reports equal distances to 0.5 px and a
factor near 485/570 = 0.8509, its authors must have taken the root. `cf_printed` and `cf` give both. The mean over
markers and steps (eq. 4.5) also counts steps where ΔV is small and (3) all but undetermined, and leans on one step
being level. So `aspect_ratio` fits all at once, least squares in the squared distances,

    ΔU² + q ΔV² = D_i,      q = CF²                                                       (4)

linear in q and one D_i for each pair, with the weights w = 1 / (ΔU² + q² ΔV²) that equal noise of all coordinates
gives the squares. With M̄_i the weighted mean over the steps of pair i, the D_i drop out:

    q = − Σ w (ΔV² − ΔV̄²_i)(ΔU² − ΔŪ²_i) / Σ w (ΔV² − ΔV̄²_i)²                         (5)

No step need be level, no angle known; the bar's plane must face the camera: turned by α about an axis, its distances
along one direction shrink by cos α, which looks the same.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats

STEPS = 20  # Gauss-Newton steps at most; chosen: a few settle it
TURNED = 1e-3
"""Least change of ΔV² with the angle, of the whole: a bar that is not turned tells nothing; chosen."""


class AspectRatio(NamedTuple):
    """What V must be multiplied by, and what that does.

    Attributes:
        factor: CF by (4).
        sd: its standard deviation, from the residuals of (4).
        cf: the mean of the roots of (3), eq. 4.5; NaN if no step is level.
        cf_printed: the mean of (3) without the root, as eq. 4.4 is printed.
        before: (S, m) distances (1) as seen, px.
        after: (S, m) distances with V multiplied by `factor`, px.
    """

    factor: float
    sd: float
    cf: float
    cf_printed: float
    before: Floats
    after: Floats

    @property
    def spread(self) -> tuple[float, float]:
        """Before and after: the largest less the smallest distance of the pair for which that is most, px."""
        before, after = (float(_range(d).max()) for d in (self.before, self.after))
        return before, after


def aspect_ratio(uv: Floats, *, level: float = 2.0) -> AspectRatio:
    """The factor for V from pictures (S, 2 m, 2) px of a bar at S angles, markers in order along it; NaN where unseen.

    Args:
        uv: (S, 2 m, 2) px, as seen.
        level: a bar that slopes less than this counts as level in (2), deg.

    Raises:
        ValueError: `uv` has another shape.
        KinemarkError: the bar does not turn far enough for its distances to tell.
    """
    if uv.ndim != 3 or uv.shape[1] < 2 or uv.shape[1] % 2 or uv.shape[2] != 2:
        raise ValueError(f"uv has shape {uv.shape}, wanted (angles, an even number of markers, 2)")
    m = uv.shape[1] // 2
    across = uv[:, : m - 1 : -1] - uv[:, :m]
    q, var = _fitted(across[..., 0] ** 2, across[..., 1] ** 2)
    factor = float(np.sqrt(q))
    cf, printed = _printed(across, level)
    before = np.linalg.norm(across, axis=-1)
    after = np.linalg.norm(across * [1.0, factor], axis=-1)
    return AspectRatio(factor, float(np.sqrt(var)) / (2 * factor), cf, printed, before, after)


def _fitted(u2: Floats, v2: Floats) -> tuple[float, float]:
    """q of (4) and its variance from ΔU² and ΔV² (S, m)."""
    seen = np.isfinite(u2 + v2)
    pairs = int(seen.any(0).sum())
    if seen.sum() < pairs + 2:
        raise KinemarkError(f"{seen.sum()} distances are seen, wanted at least {max(pairs, 1) + 2}. Turn the bar.")
    u2, v2 = np.where(seen, u2, 0.0), np.where(seen, v2, 0.0)
    q, var = 1.0, np.inf
    for _ in range(STEPS):
        w = seen / np.maximum(u2 + q**2 * v2, 1e-12)
        U, V = _from_mean(u2, w), _from_mean(v2, w)
        known = float((w * V**2).sum())
        now = -float((w * U * V).sum()) / known if known > TURNED**2 * float((w * (u2 + v2) ** 2).sum()) else 0.0  # (5)
        if not now > 0:
            raise KinemarkError(
                "The bar's distances do not change as those of one bar that is turned, so the aspect ratio is unknown. "
                "Turn it by at least 90° in several steps, and check the order of the markers."
            )
        var = float((w * (U + now * V) ** 2).sum()) / (seen.sum() - pairs - 1) / known
        settled, q = abs(now - q) < 1e-12, now
        if settled:
            break
    return q, var


def _range(d: Floats) -> Floats:
    """(m) the largest of d (S, m) less the smallest; −∞ where all are NaN."""
    return np.nan_to_num(d, nan=-np.inf).max(0) - np.nan_to_num(d, nan=np.inf).min(0)


def _from_mean(x: Floats, w: Floats) -> Floats:
    """x (S, m) less its mean over the steps by weights w (S, m)."""
    return np.asarray(x - (w * x).sum(0) / np.maximum(w.sum(0), 1e-300))


def _printed(across: Floats, level: float) -> tuple[float, float]:
    """Means over markers and steps (eq. 4.5) of the root of (3), and of (3) itself; NaN if no step is level."""
    slope = np.degrees(np.arctan2(np.abs(across[..., 1]), np.abs(across[..., 0])))
    flat = slope < level
    with np.errstate(invalid="ignore", divide="ignore"):
        d = np.where(flat, np.abs(across[..., 0]), 0.0).sum(0) / flat.sum(0)  # (2)
        cf2 = (d**2 - across[..., 0] ** 2) / across[..., 1] ** 2  # (3)
    cf2 = cf2[~flat & np.isfinite(cf2) & (cf2 > 0)]
    return (float(np.sqrt(cf2).mean()), float(cf2.mean())) if len(cf2) else (float("nan"), float("nan"))
