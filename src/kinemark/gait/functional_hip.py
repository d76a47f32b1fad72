"""Where the hip joint is in the pelvis, by a motion that turns it: circling and swinging of the leg in all directions.

Markers of the thigh are taken in the pelvis of the gait model, v_k(t). With three or more that are not on a line the
thigh has a pose, and the hip is the point that stays fixed in both bodies (`kinematics.joint_centre`; Ehrig et al.
2006, SCoRE). With fewer, as of KISS's two, each marker stays on a sphere about the hip m:

    Σ_k Σ_t (|v_k(t) − m| − r_k)²   is least,                                                               (1)

begun where Gamage and Lasenby (2002) have it without iteration: A m = b / 2,

    A = Σ_k cov(v_k),   b = Σ_k mean(v_k |v_k|²) − mean(v_k) mean(|v_k|²)                                     (2)

Two things make the place uncertain. What differs between parts of the motion is seen by leaving out one of `PARTS`
parts of the trial after another (jackknife): u² = (n − 1)/n Σ (m_i − m̄)² (3). What skin does alike whenever the leg
is in the same posture is not seen so: each marker is moved along each axis in proportion to where the leg is, by
`tissue_mm` (RMS), and the changes of m are added as squares (4).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
import scipy

from ..data import KinemarkError
from ..data.array_types import Floats
from ..data.subject_measures import LETTER, Side, SubjectMeasures
from ..kinematics import Pose, body_pose, joint_centre
from .lower_limb import pelvis_of

THIGH_MARKERS = ("THI", "KNE", "KNM", "THAP", "THAD")
"""Of a thigh, after L or R, of which those that are there count; conventional (Plug-in Gait; CGM2)."""
PARTS = 10
"""Of the trial, for (3); chosen: a swing there and back is about a part."""
FEWEST = 50
"""Frames; chosen: a second at 50 Hz."""
FLAT = 0.05
"""Second greatest extent of the thigh's markers over the greatest, below which they have no pose; chosen."""
WORST_MM = 20.0
"""Standard uncertainty along an axis from which the motion has not shown the hip; chosen: regressions are surer, and
walks, which turn it about one axis, are refused."""
ENOUGH = 300
"""Frames, evenly over the trial, on which (4) is computed; chosen: it hangs on postures, not on noise."""


class FunctionalHip(NamedTuple):
    """A hip joint centre that a motion has shown.

    Attributes:
        side: of the leg. place: (3) mm forward, left and up in the pelvis. sd: (3) mm, standard uncertainty.
        residual: mm, RMS of what moves: the centre between both bodies, or (1). way: "score", or "spheres" (1).
    """

    side: Side
    place: Floats
    sd: Floats
    residual: float
    way: Literal["score", "spheres"]


def functional_hip(points: Mapping[str, Floats], side: Side, *, tissue_mm: float = 5.0) -> FunctionalHip:
    """The hip of one leg.

    Args:
        points: (F, 3) mm by the model's names, of a motion that turns the hip in all directions.
        side: of the leg.
        tissue_mm: how far skin moves the thigh's markers over the bone, along each axis (RMS).

    Raises:
        KinemarkError: pelvis or thigh are not seen together for long, or the hip hardly turned about some axis.
    """
    v = thigh_in_pelvis(points, side)
    way: Literal["score", "spheres"] = "score" if _has_pose(v) else "spheres"
    find = _by_pose if way == "score" else _by_spheres
    try:
        place, residual = find(v)
        parts = np.array([find(np.delete(v, part, axis=1))[0] for part in np.array_split(np.arange(v.shape[1]), PARTS)])
    except KinemarkError as error:
        raise KinemarkError(f"The {side} hip cannot be found by motion: {error}") from None
    variance = (PARTS - 1) / PARTS * ((parts - parts.mean(0)) ** 2).sum(0)  # (3)
    few = v[:, :: -(-v.shape[1] // ENOUGH)]
    still = find(few)[0]
    for moved in _by_skin(few, tissue_mm):
        variance = variance + (find(moved)[0] - still) ** 2  # (4)
    sd = np.sqrt(variance)
    if not (sd < WORST_MM).all():
        raise KinemarkError(
            f"The {side} hip turned too little to show its centre: it would be known to ±{sd.max():.0f} mm. Record "
            "swings forward, backward and outward and circles, or leave the functional trial out."
        )
    return FunctionalHip(side, place, sd, residual, way)


def with_functional_hips(measures: SubjectMeasures, hips: Sequence[FunctionalHip]) -> SubjectMeasures:
    """The measures of a subject with these hips in place of what regressions say."""
    for hip in hips:
        (x, y, z), (sx, sy, sz) = hip.place.tolist(), hip.sd.tolist()
        leg = replace(measures.leg(hip.side), hip_mm=(x, y, z), hip_sd_mm=(sx, sy, sz))
        measures = measures.with_leg(hip.side, leg)
    return measures


def thigh_in_pelvis(points: Mapping[str, Floats], side: Side) -> Floats:
    """(K, F, 3) mm of the thigh's markers in the pelvis, of the frames that have all of them.

    Args:
        points: (F, 3) mm by the model's names. side: of the leg.

    Raises:
        KinemarkError: a marker is not there, or too few frames have all.
    """
    if absent := [name for name in ("LASI", "RASI", LETTER[side] + "KNE") if name not in points]:
        raise KinemarkError(
            f"The functional trial has no {', '.join(absent)}. It must have the markers of the pelvis and the thighs."
        )
    names = [LETTER[side] + name for name in THIGH_MARKERS if LETTER[side] + name in points]
    names = [name for name in names if np.isfinite(points[name]).any()]
    pelvis, _ = pelvis_of(points)
    v = np.stack([np.einsum("fji,fj->fi", pelvis.R, points[name] - pelvis.origin) for name in names])
    v = v[:, np.isfinite(v).all((0, 2))]
    if v.shape[1] < FEWEST:
        raise KinemarkError(
            f"{v.shape[1]} frames of the functional trial show the pelvis and {', '.join(names)} together, wanted "
            f"{FEWEST} or more. Fill their gaps, or record it anew."
        )
    return v


def _has_pose(v: Floats) -> bool:
    """Whether the markers are three or more that are not on a line."""
    if len(v) < 3:
        return False
    shape = v[:, 0] - v[:, 0].mean(0)
    extent = np.linalg.svd(shape, compute_uv=False)
    return bool(extent[1] > FLAT * extent[0])


def _by_pose(v: Floats) -> tuple[Floats, float]:
    """(3) mm of the centre, and the residual, by SCoRE."""
    shape = v[:, 0] - v[:, 0].mean(0)
    n = v.shape[1]
    for _ in range(2):  # to the mean of all frames laid upon it
        pose = body_pose(shape, v)
        shape = np.einsum("fji,kfj->kfi", pose.R, v - pose.t).mean(1)
        shape = shape - shape.mean(0)
    pelvis = Pose(np.broadcast_to(np.eye(3), (n, 3, 3)), np.zeros((n, 3)), np.zeros(n), np.full(n, 3))
    found = joint_centre(pelvis, body_pose(shape, v))
    return found.first, found.residual


def _by_spheres(v: Floats) -> tuple[Floats, float]:
    """(3) mm of the centre, and the residual, by (1) from (2)."""

    def residual(m: Floats) -> Floats:
        radius = np.linalg.norm(v - m, axis=-1)
        return np.asarray((radius - radius.mean(1, keepdims=True)).ravel())

    found = scipy.optimize.least_squares(residual, gamage(v), method="lm")
    return np.asarray(found.x), float(np.sqrt(np.mean(found.fun**2)))


def gamage(v: Floats) -> Floats:
    """(3) mm of the common centre of spheres by (2), from markers v (K, F, 3) mm.

    Raises:
        KinemarkError: they move in a plane.
    """
    mean = v.mean(1, keepdims=True)
    u = v - mean  # about the mean, so that nothing great is subtracted
    A = np.einsum("kfi,kfj->ij", u, u)
    # |m − v|² = r² with v = mean + u:  2 u·(m − mean) = |u|² − mean|u|²
    b = np.einsum("kfi,kf->i", u, (u**2).sum(-1)) / 2 + np.einsum("kfi,kfj,kj->i", u, u, mean[:, 0])
    if np.linalg.eigvalsh(A)[0] <= 1e-9 * np.trace(A):
        raise KinemarkError("the thigh's markers move in a plane. Record swings in all directions.")
    return np.linalg.solve(A, b)


def _by_skin(v: Floats, tissue_mm: float) -> list[Floats]:
    """The markers (K, F, 3), each moved along each axis in proportion to how far forward or outward the leg is."""
    where = v.mean(0)[:, :2]
    where = (where - where.mean(0)) / np.maximum(where.std(0), 1e-9) / np.sqrt(2)
    out = []
    for k in range(len(v) if tissue_mm > 0 else 0):
        for axis in range(3):
            for course in where.T:
                moved = v.copy()
                moved[k, :, axis] += tissue_mm * course
                out.append(moved)
    return out
