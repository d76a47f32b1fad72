"""Which control points are not where the survey says, by the word of all cameras.

A point that took no part lies e_i from its surveyed place, with covariance C_i (`left_out`), and

    d_i² = e_iᵀ C_i⁻¹ e_i                                                (1)

follows χ² of three degrees of freedom if survey, images and camera model are right; C_i is scaled by the residuals, so
that one common scale says nothing. Wrong points pull the cameras towards themselves and make each other look right. So
the cameras are fitted to the three quarters of points with the least d, d is found anew for all, and so on (the
concentration steps of Rousseeuw & Van Driessen 1999) (2); then to all points with d < `FAR`, until these stay the same
(3). The others are wrong, if they are few. Of ten points or fewer one can be spared, and of more than `MOST_POINTS`
each alone does no harm: these are not searched. A wrong point is seen by all cameras at one and the same other
place, which leaves little of the squares of its residuals (5); where that does not help, an image is wrong and not the
survey.

A whole rod that hangs elsewhere can have small d, and its neighbours large ones. Leaving a group G of points out of a
camera's fit lowers its sum of squares by r_Gᵀ (1 − H_GG)⁻¹ r_G, H = J A⁻¹ Jᵀ (4). So a second start leaves out the
quarter of points next to each other for which (4) falls most; the start whose fit leaves the least squares goes on.

The largest d of 8 to 24 true points is below 3.8 in 95 of 100 calibrations and was never above 4.7 in 240.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data import KinemarkError
from ...data.array_types import Bools, Floats, Ints
from ...geometry import camera_about, origin_near, parameter_jacobian, project_all
from ...numerics.scaled import scaled_inverse
from .fit import ControlFit, refitted

FAR = 5.0  # standard deviations; a point so far off is wrong; chosen (see studies/calibration_quality.py)
SUSPICIOUS = 4.0
"""Standard deviations; from here on wrong points are looked for; chosen (see studies/calibration_quality.py)."""
KEPT = 0.75  # of the points, that each concentration step is made from (Rousseeuw & Van Driessen 1999 advise 0.75)
CONCENTRATIONS = 2  # steps from each start; two, as in Rousseeuw & Van Driessen 1999
ROUNDS = 4  # of adding what is near again, at most; chosen (see studies/calibration_quality.py)
MOST_WRONG = 0.4
"""Of the points; if more are, nobody can say which; chosen, below one half (see studies/calibration_quality.py)."""
FEWEST_RIGHT = 7  # points that must remain; chosen: one more than the six of a DLT (see studies/calibration_quality.py)
MOST_POINTS = 100  # above which points are not checked one by one; chosen for speed
NEARLY = 0.02  # of the greatest singular value; smaller ones are noise; chosen (see studies/calibration_quality.py)
UNEXPLAINED = 0.3  # of a point's residual that its move may leave; chosen (see studies/calibration_quality.py)


class Displaced(NamedTuple):
    """Points that are elsewhere: rows (n), offsets (n, 3) mm from the survey, and the calibration without them."""

    rows: Ints
    offset: Floats
    rest: ControlFit


def displaced_points(fit: ControlFit) -> Displaced | None:
    """The points whose surveyed places contradict the others, if the others agree.

    Images that a single camera left out are its own mistakes and take no part.
    """
    rejected = refused_everywhere(fit)
    fit = fit._replace(uv=np.where((~fit.kept & ~rejected)[..., None], np.nan, fit.uv))
    n = int(np.isfinite(fit.left_out_xyz[:, 0]).sum())
    if not FEWEST_RIGHT < n <= MOST_POINTS:
        return _named(fit, rejected, fit)
    try:
        wrong, rest = _contradicted_points(fit, rejected, n)
    except KinemarkError:  # the rest determines no camera
        return _named(fit, rejected, fit)
    return _named(fit, wrong, rest) if wrong.sum() <= MOST_WRONG * n else None


def _contradicted_points(fit: ControlFit, rejected: Bools, n: int) -> tuple[Bools, ControlFit]:
    """The points (N) that the others contradict, and the calibration without them."""
    many = round(KEPT * n) >= FEWEST_RIGHT + 1
    spared = n - round(KEPT * n) if many else 1
    starts = [refitted(fit, without=rejected | w) for w in (_farthest(fit, spared), _best_cluster(fit, spared))]
    rest = min(starts, key=_squares)
    for _ in range(CONCENTRATIONS if many else 0):  # (2)
        rest = refitted(fit, without=_farthest(rest, spared))
    wrong = rejected
    for _ in range(ROUNDS):  # (3)
        before, wrong = wrong, ~(distance(rest) < FAR)
        if (wrong == before).all() or wrong.sum() > MOST_WRONG * n:
            break
        rest = refitted(fit, without=wrong)
    return wrong, rest


def _farthest(fit: ControlFit, spared: int) -> Bools:
    """(N) the points with the greatest d, and those of which it is unknown."""
    d = np.nan_to_num(distance(fit), nan=np.inf)
    known = int(np.isfinite(d).sum())
    return np.asarray(d > np.sort(d)[max(known - spared, 1) - 1])


def _squares(fit: ControlFit) -> float:
    """Of all residuals, over the equations left over."""
    return float((fit.residual[fit.kept] ** 2).sum() / max(fit.freedom.sum(), 1))


def _best_cluster(fit: ControlFit, spared: int) -> Bools:
    """(N) so many points next to each other without which residuals fall most, by (4)."""
    near = np.argsort(np.linalg.norm(fit.xyz[:, None] - fit.xyz, axis=-1), axis=1)[:, :spared]
    near = near[np.isfinite(fit.xyz).all(1)]
    fall, origin = np.zeros(len(near)), origin_near(fit.xyz)
    for c, camera in enumerate(fit.rig):
        rows = np.flatnonzero(fit.kept[c])
        J = parameter_jacobian(camera_about(camera, origin), fit.xyz[rows] - origin)
        J = J[..., np.diag(camera.cov) > 0].reshape(2 * len(rows), -1)
        H = J @ scaled_inverse(J.T @ J) @ J.T
        r = fit.residual[c, rows].ravel()
        for g, group in enumerate(near):
            chosen = np.repeat(np.isin(rows, group), 2)
            left = np.eye(int(chosen.sum())) - H[np.ix_(chosen, chosen)]
            fall[g] += r[chosen] @ np.linalg.lstsq(left, r[chosen], rcond=NEARLY)[0]
    wrong = np.zeros(len(fit.xyz), np.bool_)
    wrong[near[fall.argmax()]] = True
    return wrong


def refused_everywhere(fit: ControlFit) -> Bools:
    """(N) which points were left out by most of the cameras that see them, two at least."""
    seen = np.isfinite(fit.uv[..., 0])
    out = (seen & ~fit.kept).sum(0)
    return (out >= 2) & (2 * out > seen.sum(0))


def distance(fit: ControlFit) -> Floats:
    """(1), (N); NaN where unknown."""
    e, C = fit.left_out_xyz, fit.left_out_cov
    d = np.full(len(e), np.nan)
    known = np.isfinite(e).all(1) & np.isfinite(C).all((1, 2))
    d[known] = np.sqrt(np.einsum("ni,ni->n", e[known], np.linalg.solve(C[known], e[known][..., None])[..., 0]))
    return d


def suspicious(fit: ControlFit) -> bool:
    """Whether `displaced_points` is worth its time."""
    return bool(refused_everywhere(fit).any() or np.nanmax(distance(fit), initial=0.0) > SUSPICIOUS)


def _named(fit: ControlFit, wrong: Bools, rest: ControlFit) -> Displaced | None:
    """Where the cameras that were fitted without the wrong points see these, if they see them at one place (5)."""
    wrong = wrong & np.isfinite(rest.left_out_xyz[:, 0])
    there = fit.uv - project_all(rest.rig, rest.xyz + rest.left_out_xyz)
    left = np.nansum(there**2, axis=(0, 2)) / np.maximum(np.nansum(rest.residual**2, axis=(0, 2)), 1e-12)
    rows = np.flatnonzero(wrong & (left < UNEXPLAINED))
    return Displaced(rows, rest.left_out_xyz[rows], rest) if len(rows) else None
