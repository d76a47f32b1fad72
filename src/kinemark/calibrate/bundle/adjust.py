"""What a bundle adjustment fits, what comes out of it, and `bundle`, from near the truth.

Wrong points are held at bay and then left out (`robust_adjustment`), by Levenberg and Marquardt's method with the Schur
complement (`solver`); then follows the joint covariance of all cameras (`parameter_covariance`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...data import KinemarkError, Rig
from ...data.array_types import Bools, Floats, Ints
from ...data.method import ONE, Method, parameter
from ...geometry import joint_about, origin_near, rig_about
from ...numerics.small_sample import variance_factor
from .camera_step import CameraStep
from .common_errors import common_errors
from .initial.view_pairs import ENOUGH, weakest_link
from .lens_prior import LensPrior
from .lost_images import LostImages
from .misfit import Misfit
from .parameter_covariance import joint_covariance
from .parts import Part, all_points, complete
from .robust_adjustment import degrees_of_freedom, solve_robust, solve_without_outliers
from .solver import BundleState, Freedom, ImageObservations, cost, normal_equations, residuals
from .usual_terms import covariance_with, with_learned_terms

VAGUE = 0.1
"""A focal length is not known if its standard deviation is more than this share of it; chosen (see
benchmarks/bundle.py)."""
MOST_LOST = 0.3  # of a camera's points that may be left out; chosen (see benchmarks/bundle.py)
SUDDEN = 0.7  # change of the share of points left out that is said to begin at a frame; chosen
IMPLAUSIBLE = 0.01  # of the image's diagonal; chosen (see benchmarks/bundle.py)


@dataclass(frozen=True, slots=True)
class Bundle(Method):
    """All cameras, and all places of what they saw, at once: bundle adjustment."""

    radial: int = parameter(
        2, unit="lens terms", low=0, high=3, meaning="at most so many radial lens terms are fitted: k1, k2, k3"
    )
    tangential: bool = parameter(False, meaning="p1 and p2 are fitted as well")
    principal_point: bool = parameter(
        True, meaning="the principal point is fitted; else it stays at the image's centre"
    )
    square_pixels: bool = parameter(
        True, meaning="pixels keep their shape, fy / fx, which is aspect unless a start says otherwise; else both are "
        "fitted",
    )  # fmt: skip
    aspect: float | None = parameter(
        None, unit=ONE, low=0.1, high=10,
        meaning="height of a round marker's image by its width, fy / fx, where no lens is known; None: 0.5 for a "
        "session's interlaced video, else 1",
    )  # fmt: skip
    usual_lens: bool = parameter(
        True, meaning="lens terms that are not fitted, and the pixels' shape, may differ from what is taken as much as "
        "is usual of lenses; else, and where no lens term is fitted, they are exact",
    )  # fmt: skip
    reject: float = parameter(
        5.0, unit="standard deviations", low=3, high=math.inf, meaning="outliers: points so far off are left out"
    )
    seed: int = parameter(0, unit=ONE, meaning="of the random samples that the start draws")

    @property
    def freedom(self) -> Freedom:
        """The parameters of a camera of which nothing is known."""
        free = np.zeros(15, np.bool_)
        free[[0, 1, *range(9, 15)]] = True
        free[[2, 3]] = self.principal_point
        free[[4, 5, 8][: self.radial]] = True
        free[[6, 7]] = self.tangential
        if not (self.usual_lens and self.radial):
            return Freedom(free, self.square_pixels)
        known = np.append(self.square_pixels, ~free[4:9])
        free[4:9] = True
        return Freedom(free, False, prior=LensPrior.of(known, ~known))


class BundleFit(NamedTuple):
    """A calibrated rig and the points it was calibrated with.

    Attributes:
        rig: C cameras with covariances and residuals.
        xyz: (N, 3) the points, mm; sticks pose by pose, so that N = F K and `xyz.reshape(F, K, 3)`; NaN if not used.
        residual: (C, N, 2) seen minus reprojected, px; NaN where not seen or the point is not used.
        kept: (C, N) which image points took part.
        joint: (15 C, 15 C) covariance of all cameras' `data.PARAMETERS` together, camera by camera, zero rows for
            those held. `Camera.cov` are its blocks on the diagonal, `Camera.common` what is strongest
            of the others. Unless points or cameras were held, it is about the frame in which the points rest as a
            whole.
        chi2: Σ of the kept points' squared residuals by their covariances.
        freedom: ν, degrees of freedom of it.
        step: that a camera was probably moved meanwhile, and when; None where nothing says so, or it was not looked
            for.
        delay: (C) by how many images each camera took the film later than others; empty where it was not looked for.
        lost: images that cameras lost, or took twice, in the course of the film; the others were put in their frames.
    """

    rig: Rig
    xyz: Floats
    residual: Floats
    kept: Bools
    joint: Floats
    chi2: float
    freedom: int
    step: CameraStep | None = None
    delay: Floats = np.zeros(0)
    lost: tuple[LostImages, ...] = ()


def bundle(
    rig: Rig,
    parts: Sequence[Part],
    uv: Floats,
    *,
    cov: Floats | None = None,
    freedoms: Sequence[Freedom] | None = None,
    method: Bundle | None = None,
) -> BundleFit:
    """The rig near `rig`, and the points near `parts`, that fit best to pixels.

    Args:
        rig: C cameras to begin with.
        parts: sticks, single points and known points, with their first places; N markers in all, body by body.
        uv: (C, N, 2) where they are seen, px; NaN where not.
        cov: (C, N, 2, 2) covariance of `uv`, px²; right in proportion.
        freedoms: what may change in each camera; without it what `method` says.
        method: what to fit, and when to leave points out.

    Raises:
        ValueError: the arrays do not fit each other.
        KinemarkError: fewer equations than unknowns.
    """
    method = method or Bundle()
    parts = tuple(parts)
    free = tuple(freedoms or [method.freedom] * len(rig))
    n = len(all_points(parts))
    if uv.shape != (len(rig), n, 2) or len(free) != len(rig):
        raise ValueError(
            f"uv has shape {uv.shape} and there are {len(free)} freedoms, wanted ({len(rig)}, {n}, 2) and {len(rig)}"
        )
    seen, origin = observed(uv, cov), origin_near(all_points(parts))
    near = tuple(part.placed(np.eye(3), -origin, 1.0) for part in parts)
    found = adjusted(BundleState(rig_about(rig, origin).cameras, near), seen, free, reject=method.reject)
    fit = completed(found, seen, what="bundle adjustment")
    joint = joint_about(fit.rig, fit.joint, -origin)
    return fit._replace(rig=rig_about(fit.rig, -origin), xyz=fit.xyz + origin, joint=joint)


class Adjusted(NamedTuple):
    """The state that fits best to the points `kept` (C, N), the `freedoms` weighed by these, and M of `usual_terms`."""

    state: BundleState
    kept: Bools
    freedoms: tuple[Freedom, ...]
    terms: Floats | None = None


def adjusted(state: BundleState, seen: ImageObservations, freedoms: tuple[Freedom, ...], *, reject: float) -> Adjusted:
    """The state near `state` that fits best."""
    freedoms = tuple(freedom.about(camera) for freedom, camera in zip(freedoms, state.cameras, strict=True))
    state, scale = solve_robust(state, seen, freedoms)
    state, kept, freedoms = solve_without_outliers(state, seen, freedoms, reject=reject, scale=scale)
    if not any(freedom.prior for freedom in freedoms):
        return Adjusted(state, kept, freedoms)
    state, terms = with_learned_terms(state, seen, freedoms, kept)
    return Adjusted(state, kept, freedoms, terms)


def completed(adjusted: Adjusted, seen: ImageObservations, *, what: str) -> BundleFit:
    """A `BundleFit` of what has converged.

    Raises:
        KinemarkError: there are not more equations than unknowns, or they determine nothing.
    """
    state, kept, freedoms, terms = adjusted
    used = seen._replace(used=kept)
    with np.errstate(over="ignore", invalid="ignore"):  # of what fits nothing, refused below
        covariance, gauge = joint_covariance(
            state, normal_equations(state, used, freedoms), freedoms, np.asarray(kept.any(0))
        )
    if terms is not None:
        covariance = covariance_with(covariance, terms, state.cameras, freedoms)
    chi2 = cost(state, used, freedoms)
    nu = degrees_of_freedom(state, freedoms, kept) + gauge
    if nu < 1:
        raise KinemarkError(
            f"{int(kept.sum())} image points fit each other, and the cameras and places have more unknowns than they "
            f"give equations ({-nu + 1} too few). Record more, or fit fewer lens terms."
        )
    joint = covariance * chi2 / nu * variance_factor(nu)
    if not np.isfinite(joint).all():
        raise Misfit("What the cameras see fits each other so badly that nothing follows on where they are.")
    residual = residuals(state, seen.uv)
    xyz = np.where(np.asarray(kept.any(0))[:, None], all_points(state.parts), np.nan)
    residual = np.where(np.isnan(xyz[:, :1]), np.nan, residual)
    cameras = tuple(
        replace(
            camera,
            cov=joint[15 * c : 15 * c + 15, 15 * c : 15 * c + 15],
            residual=float(np.sqrt((residual[c, kept[c]] ** 2).sum(1).mean())) if kept[c].any() else float("nan"),
            common=common,
        )
        for c, (camera, common) in enumerate(zip(state.cameras, common_errors(joint), strict=True))
    )
    there = xyz[complete(xyz)]
    lost = int(seen.used.sum() - kept.sum())
    words = f"{what}: {int(kept.sum())} image points" + (f", {lost} left out" if lost else "")
    return BundleFit(Rig(cameras, words, np.stack([there.min(0), there.max(0)])), xyz, residual, kept, joint, chi2, nu)


def observed(uv: Floats, cov: Floats | None) -> ImageObservations:
    """Pixels (C, N, 2) with covariances (C, N, 2, 2), px²; all alike where one that is needed is not known.

    Raises:
        ValueError: a covariance is not positive definite, or its shape is not that of uv.
    """
    there = complete(uv)
    if cov is not None and cov.shape != (*uv.shape, 2):
        raise ValueError(f"cov has shape {cov.shape}, wanted {(*uv.shape, 2)}")
    if cov is None or not np.isfinite(cov[there]).all():
        return ImageObservations(uv, np.broadcast_to(np.eye(2), (*uv.shape, 2)), there)
    try:
        known = np.asarray(np.where(there[..., None, None], cov, np.eye(2)), np.float64)
        whiten = np.linalg.inv(np.linalg.cholesky(known))
    except np.linalg.LinAlgError:
        raise ValueError("cov has a covariance that is not positive definite") from None
    return ImageObservations(uv, whiten, there)


def check_calibration(fit: BundleFit, seen: Bools, frame: Ints, *, focus_held: bool = False) -> None:
    """Raises a KinemarkError where the fit to what was seen (C, N), in frames (N) that rise, is no calibration."""
    there = seen & complete(fit.xyz)
    for c, camera in enumerate(fit.rig):
        lost = 1 - fit.kept[c].sum() / max(there[c].sum(), 1)
        if not camera.residual < IMPLAUSIBLE * np.hypot(*camera.size) or lost > MOST_LOST:
            raise Misfit(
                f"Camera {camera.name} does not fit the others: {lost:.0%} of its points were left out"
                + (f", and the rest is {camera.residual:.2f} px off. " if lost < 1 else ". ")
                + (_weak_link(fit.rig.names, seen, frame) or _since(~fit.kept[c, there[c]], frame[there[c]]))
                + "Check that it is synchronous and did not move, that markers are not mixed up and lengths are right; "
                "a lens that bends lines strongly needs more lens terms.",
                camera.name,
            )
    sd = np.sqrt([max(camera.cov[0, 0], 0.0) for camera in fit.rig]) / [abs(camera.K[0, 0]) for camera in fit.rig]
    if not focus_held and not sd.max() <= VAGUE:
        least_certain = fit.rig[int(np.nanargmax(np.where(np.isnan(sd), np.inf, sd)))]
        raise KinemarkError(
            f"The focal length of camera {least_certain.name} is uncertain by {sd.max():.0%}: it saw too little. Wave "
            "nearer to it and farther away, in all its image, turn the stick in all directions, or linearise it first."
        )


def _weak_link(names: Sequence[str], seen: Bools, frame: Ints) -> str:
    """That all cameras hang together by few of the frames (N) of what is seen (C, N); nothing where by enough."""
    shown = np.array([np.isin(np.unique(frame), frame[each]) for each in seen], np.int64)
    a, b, shared = weakest_link(shown @ shown.T)
    if a == b or shared >= ENOUGH:
        return ""
    return (
        f"Cameras {names[a]} and {names[b]} share {shared} poses only, and nothing joins the cameras on their two "
        "sides better: wave more where both see it. "
    )


def _since(lost: Bools, frame: Ints) -> str:
    """From which of the frames (n) on, or up to which, points are lost; nothing where they are so all along."""
    excess = np.cumsum(lost - lost.mean())  # turns where the share of lost ones changes most
    first = int(np.abs(excess).argmax()) + 1
    if first >= len(lost):
        return ""
    before, after = lost[:first].mean(), lost[first:].mean()
    if abs(after - before) < SUDDEN:
        return ""
    when = (
        f"begin at about frame {frame[first] + 1}" if after > before else f"end at about frame {frame[first - 1] + 1}"
    )
    return f"Those {when}: it may have lost a frame there, or been moved. "
