"""What an unstated error of the calibration leaves in the images: a field that is smooth over each camera's image.

A camera that stands or looks a little otherwise than its file says has its images off by δ(x), much the same for
neighbouring places x and in every frame, so no number of residuals averages it out. Each axis of δ is taken as

    δ(x) = Σ θ_k φ_k(x),   θ_k ~ N(0, s²),   Σ φ_k² = 1                                    (1)

where φ is a constant of weight w, and cosines and sines of one wave along four directions that share 1 − w: everywhere
of variance s², and less alike the farther apart places are (a Gaussian process; Rasmussen & Williams 2006, ch. 2). The
residual of two images (`epipolar_noise`) is

    e = Σ l δ + white noise = J θ + white noise                                            (2)

With g and v of the mixture that e − J θ is, A = Σ g J Jᵀ / v with eigenvalues λ, and c the part of Σ g J e / v along
each of its eigenvectors, the residuals have the likelihood

    ln L(s²) = ½ Σ (s² c² / (1 + s² λ) − ln(1 + s² λ))                                     (3)

and θ the mean s² c / (1 + s² λ) along them (4). Directions of which the images say nothing (the rig moved as a whole)
have λ = 0 and weigh nothing: the few that a subject in one place shows are as many degrees of freedom as (3) has. With
a broad prior of ln s² (5) it gives its posterior, and the variance V that images are given is that with which 95 %
ellipsoids hold 95 % of the errors of all s² by their probabilities,

    Σ p(s²) P(χ²₃ < q (σ² + V) / (σ² + s²)) = 0.95,   P(χ²₃ < q) = 0.95                     (6)

with σ² the white noise. V belongs to a place, not to a frame: no filter makes it less.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ...data.array_types import Floats, Ints
from .detection_index import Images
from .epipolar_noise import Mixture, Residuals, mixture, pair_of, peaked

CONSTANT_SHARE = 0.8
"""w of (1), a share of s²; chosen (see benchmarks/tracking_scenes.py)."""

WAVE = 1.2
"""Phase of (1) from the middle of an image to its edge, rad; chosen (see benchmarks/tracking_scenes.py)."""

USUAL_SD, LOG_SD = 0.2, 2.3
"""Of (5): s in px, and the standard deviation of ln s²: calibrations are 0.02 to 2 px off; chosen."""

LOG_VARIANCES = np.linspace(2 * np.log(0.005), 2 * np.log(6.0), 141)
"""ln s² in px² at which (3) is worked out; chosen: finer and wider than any posterior."""

DIRECTIONS = np.array([[1.0, 0.0], [0.0, 1.0], [0.5**0.5, 0.5**0.5], [0.5**0.5, -(0.5**0.5)]])
"""Of the waves of (1), unit vectors; chosen: the fewest that are alike along and across."""

ROUNDS = 4
"""Of (2) to (4), in which the mixture narrows; chosen (see benchmarks/tracking_scenes.py)."""

HELD = 0.95
"""Of (6): the share of errors that the ellipsoid of this probability is to hold; by definition of the report."""


class CalibrationField(NamedTuple):
    """The posterior (n) of ln s² at LOG_VARIANCES, and the mixture of what the field leaves of the residuals."""

    posterior: Floats
    left: Mixture

    def variance(self, white: float) -> float:
        """V px² of (6) beside white noise of a variance in px²."""
        s2 = np.exp(LOG_VARIANCES)
        half = scipy.special.gammaincinv(1.5, HELD) * (white + s2[:, None]) / (white + s2)
        held = scipy.special.gammainc(1.5, half) @ self.posterior
        return float(np.interp(HELD, held, s2))

    def exceeds(self, variance: float) -> bool:
        """Whether s² is more than a variance in px², with a probability of HELD."""
        return bool(self.posterior @ (np.exp(LOG_VARIANCES) > variance) > HELD)


def calibration_field(images: Images, some: Residuals) -> CalibrationField:
    """The field of the images' residuals, by (1) to (5)."""
    C = len(images.P)
    J, group = _jacobian(images, some), pair_of(some, C)
    left, posterior = some.off, _usual()
    for _ in range(ROUNDS):
        fit = mixture(left, group, C * C)
        weighted = J * np.where(peaked(fit)[group], fit.weight / fit.variance[group], 0.0)[:, None]
        size, along = np.linalg.eigh(weighted.T @ J)
        size, part = np.maximum(size, 0.0), along.T @ (weighted.T @ some.off)
        posterior = _posterior(size, part)
        s2 = np.exp(LOG_VARIANCES[posterior.argmax()])
        left = some.off - J @ (along @ (s2 * part / (1 + s2 * size)))  # (4)
    return CalibrationField(posterior, mixture(left, group, C * C))


def _usual() -> Floats:
    """The prior (5), not normalised."""
    return np.asarray(np.exp(-0.5 * ((LOG_VARIANCES - 2 * np.log(USUAL_SD)) / LOG_SD) ** 2))


def _posterior(size: Floats, part: Floats) -> Floats:
    """(5) from λ and c of (3)."""
    s2 = np.exp(LOG_VARIANCES)[:, None]
    log = (s2 * part**2 / (1 + s2 * size) - np.log1p(s2 * size)).sum(1) / 2  # (3)
    both = np.exp(log - log.max()) * _usual()
    return np.asarray(both / both.sum())


def _jacobian(images: Images, some: Residuals) -> Floats:
    """J (H, 2 C K) of (2), of θ in px."""
    J = np.zeros((len(some.off), len(images.P), 2, 9))
    for camera, detection, line in zip(some.camera, some.detection, some.line, strict=True):
        J[np.arange(len(detection)), camera] += line[:, :, None] * _functions(images, camera, detection)[:, None]
    return J.reshape(len(some.off), -1)


def _functions(images: Images, camera: Ints, detection: Ints) -> Floats:
    """φ (H, K) of (1) at images of cameras (H)."""
    phase = WAVE * (2 * images.uv[detection] / images.size[camera] - 1) @ DIRECTIONS.T
    share = np.sqrt((1 - CONSTANT_SHARE) / len(DIRECTIONS))
    constant = np.full((len(phase), 1), np.sqrt(CONSTANT_SHARE))
    return np.hstack([constant, share * np.cos(phase), share * np.sin(phase)])
