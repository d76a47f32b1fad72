"""The rig turned and refocused a little, so that the images of each marker meet.

A calibration is off by some tenths of a pixel, often by one. Images of one marker then pass each other by the same
distance for as long as the marker stays where it is, while images of two markers may meet. For association, each
camera is turned about its centre by a small angle ω and its focal lengths changed by the factor 1 + s, which moves the
image of a point at normalised (x, y) by

    δx = −x y ω_x + (1 + x²) ω_y − y ω_z + s x
    δy = −(1 + y²) ω_x + x y ω_y + x ω_z + s y                                            (1)

and the epipolar residual e of two images (`epipolar_noise`) by − l δ − l′ δ′. The parameters of all cameras minimise

    Σ g (e − J θ)² / v + Σ (θ / θ₀)²                                                      (2)

with g and v of the mixture that the residuals are, of each two cameras about 0 or about where they are likelier
(`epipolar_noise` (5)), θ₀ what calibrations are usually off. What the images do not tell,
as a turn of the whole rig, stays as it was by the second term. Positions are solved with the rig as it was given.

Where a file states no lens terms (`missing_lens`), the radial one is a fifth parameter k, which moves the image by

    δx = k r² x,   δy = k r² y,   r² = x² + y²                                            (3)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy

from ....data import Camera, Rig
from ....data.array_types import Floats
from ..detection_index import Images
from ..following.candidate_points import fundamentals
from ..noise.epipolar_noise import Residuals, mixture, pair_of, peaked, residuals

USUAL_ERROR = np.array([1.5e-3, 1.5e-3, 1.5e-3, 1.5e-3])
"""θ₀ of (2): ω in rad and s, about two pixels; chosen (see benchmarks/tracking_scenes.py)."""

ROUNDS = 5
"""Of (2), in which the mixture narrows; chosen (see benchmarks/tracking_scenes.py)."""

SETTLED = 1e-4
"""Of the first sum of (2), what a round gains at least, or it is the last; chosen: fits of which cameras make a peak
late gain 2e-3 and more in each round before (scenes 147004 to 147023 of the second generator)."""


class RigStep(NamedTuple):
    """What one round of (2) finds.

    Attributes:
        change: (C, n) of θ; gain: what it takes of the first sum, a share, where residuals change as J says.
        sd: px, of the widest peak of two cameras' residuals; inf where some that have residuals have no peak.
    """

    change: Floats
    gain: float
    sd: float


def adjusted_rig(images: Images, rig: Rig, frames: list[int]) -> Rig:
    """The rig by (2), from the images of some frames, whose pixels are those of ideal lenses."""
    return fitted_rig(lambda _: images, rig, frames, np.zeros((len(rig), 4)), USUAL_ERROR)


def fitted_rig(
    seen_by: Callable[[Rig], Images],
    rig: Rig,
    frames: list[int],
    begin: Floats,
    usual: Floats,
    rounds: int = ROUNDS,
) -> Rig:
    """The rig by (2), from the images of some frames, as a rig sees them, in so many rounds.

    Args:
        seen_by: the images with the ideal pixels of a rig. begin: (C, 4) that θ of (2) is likely, or (C, 5) with (3).
        usual: θ₀, as many.
    """
    theta = begin
    for _ in range(rounds):
        moved = _moved(rig, theta)
        step = rig_step(seen_by(moved), moved, frames, theta - begin, usual)
        theta = theta + step.change
        if step.gain <= SETTLED:
            break
    return _moved(rig, theta)


def rig_step(images: Images, rig: Rig, frames: list[int], likely: Floats, usual: Floats) -> RigStep:
    """One round of (2), from the images of some frames, as this rig sees them.

    Args:
        likely: (C, 4) how far θ is from what is likely, or (C, 5) with (3). usual: θ₀, as many.
    """
    C, n = likely.shape
    some = residuals(images, fundamentals(rig.P), frames)
    group = pair_of(some, C)
    fit = mixture(some.off, group, C * C, some.window, each=True)
    clear = peaked(fit)[group]
    weight = np.where(clear, np.sqrt(fit.weight / fit.variance[group]), 0.0)
    off = some.off * weight
    J = _jacobian(images, rig, some, n) * weight[:, None]
    prior = 1 / np.tile(usual, C)
    pull = J.T @ off - prior**2 * likely.ravel()
    change = np.linalg.solve(J.T @ J + np.diag(prior**2), pull)
    gain = float(pull @ change / max(off @ off, np.finfo(float).tiny))
    sd = float(np.sqrt(fit.variance[group].max(initial=0.0))) if clear.all() else np.inf
    return RigStep(np.asarray(change.reshape(C, n), np.float64), gain, sd)


def _jacobian(images: Images, rig: Rig, some: Residuals, n: int) -> Floats:
    """J (H, n C) of (2), px, of n parameters a camera."""
    J = np.zeros((len(some.off), len(rig), n))
    K = np.array([camera.K for camera in rig])
    for camera, detection, line in zip(some.camera, some.detection, some.line, strict=True):
        fx, fy = K[camera, 0, 0], K[camera, 1, 1]
        y = (images.uv[detection, 1] - K[camera, 1, 2]) / fy
        x = (images.uv[detection, 0] - K[camera, 0, 2] - K[camera, 0, 1] * y) / fx
        r2 = x * x + y * y
        dx = np.stack([-x * y, 1 + x * x, -y, x, x * r2], -1)[:, :n] * fx[:, None]  # (1), (3)
        dy = np.stack([-1 - y * y, x * y, x, y, y * r2], -1)[:, :n] * fy[:, None]
        J[np.arange(len(detection)), camera] += line[:, :1] * dx + line[:, 1:] * dy
    return J.reshape(len(some.off), n * len(rig))


def _moved(rig: Rig, theta: Floats) -> Rig:
    """The rig with each camera changed by its θ (C, 4), or (C, 5) with the radial term of its lens."""
    moved = [turned(camera, own) for camera, own in zip(rig, theta, strict=True)]
    moved_rig = replace(rig, cameras=tuple(moved))
    return with_radial(moved_rig, theta[:, 4]) if theta.shape[1] > 4 else moved_rig


def with_radial(rig: Rig, k: Floats) -> Rig:
    """The rig with lenses of the radial terms k (C), and no others."""
    bent = [replace(one, distortion=np.array([own, 0, 0, 0, 0])) for one, own in zip(rig, k, strict=True)]
    return replace(rig, cameras=tuple(bent))


def turned(camera: Camera, theta: Floats) -> Camera:
    """The camera turned about its centre by ω rad, its focal lengths times 1 + s."""
    turn = scipy.spatial.transform.Rotation.from_rotvec(theta[:3]).as_matrix()
    K = camera.K * np.array([[1 + theta[3]] * 2 + [1.0]] * 2 + [[1.0] * 3])
    return replace(camera, K=K, R=turn @ camera.R, t=turn @ camera.t)
