"""What an unstated error of the calibration leaves in the images: a field that is smooth over each camera's image.

A camera that stands or looks a little otherwise than its file says has its images off by δ(x), much the same for
neighbouring places x and in every frame, so no number of residuals averages it out. Each axis of δ is taken as

    δ(x) = θ₀ + Σ θ_k φ_k(x),   θ₀ ~ N(0, s₀²),   θ_k ~ N(0, s₁²),   Σ φ_k² = 1            (1)

where φ are cosines and sines of waves along four directions: everywhere of variance s₀² + s₁², and less alike the
farther apart places are (a Gaussian process; Rasmussen & Williams 2006, ch. 2). s₀ is of cameras that were turned or
moved, s₁ of focal lengths and lenses. The residual of two images (`epipolar_noise`) is

    e = Σ l δ + white noise = J θ + white noise                                            (2)

With g and v of the mixture that e − J θ is, A = Σ g J Jᵀ / v and b = Σ g J e / v. Parts of A and b that are of θ₀ and
of all θ_k have the indices 0 and 1. With D = s₁² / (1 + s₁² A₁₁), the residuals have, θ_k left open,

    A′ = A₀₀ − A₀₁ D A₁₀,   b′ = b₀ − A₀₁ D b₁
    ln L = ½ (b₁ᵀ D b₁ − ln |1 + s₁² A₁₁| + s₀² b′ᵀ (1 + s₀² A′)⁻¹ b′ − ln |1 + s₀² A′|)     (3)

Directions of which the images say nothing, as the rig moved as a whole, have the eigenvalue 0 and weigh nothing: the
few that a subject in one place shows are as many degrees of freedom as (3) has. With broad priors (4) it gives the
posterior of both variances. The variance V that images are given is that with which 95 % ellipsoids hold 95 % of
the errors, of all s² = s₀² + s₁² by their probabilities, beside white noise of σ²:

    Σ p(s²) P(χ²₃ < q (σ² + V) / (σ² + s²)) = 0.95,   P(χ²₃ < q) = 0.95                     (5)

Where a calibration states what it leaves, the mean of L by (4), which is 1 without a field, has to say as surely that
there is more (7): the priors alone would, of any calibration better than theirs.

V belongs to a place, not to a frame: no filter makes it less. A camera whose |θ₀|² is more than UNLIKE times the median
of all, as one that was knocked, would make V large for all; its residuals are left out (6), and are noise of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ....data.array_types import Bools, Floats, Ints
from ..detection_index import Images
from .epipolar_noise import Mixture, Residuals, mixture, pair_of, peaked

WAVES = np.pi * np.array([0.5, 1.0])
"""Phases of (1) from the middle of an image to its edge, rad; chosen: what focal lengths and lenses do."""

DIRECTIONS = np.array([[1.0, 0.0], [0.0, 1.0], [0.5**0.5, 0.5**0.5], [0.5**0.5, -(0.5**0.5)]])
"""Of the waves of (1), unit vectors; chosen: the fewest that are alike along and across."""

USUAL_SD, LOG_SD = (0.2, 0.1), 2.0
"""Of (4): s₀ and s₁ in px, and the standard deviation of their ln s²: calibrations are 0.03 to 1.5 px off.
Chosen of 1.5, 2 and 2.3 (see benchmarks/tracking_scenes.py --coverage)."""

LOG_VARIANCES = np.linspace(2 * np.log(0.005), 2 * np.log(6.0), 61)
"""ln s² in px² at which (3) is worked out; chosen: finer and wider than any posterior."""

MOST_RESIDUALS = 50.0
"""Residuals of two cameras that count, a number: what the waves do not fit is alike in neighbouring ones, and with more
it would be taken for large waves; chosen (see benchmarks/tracking_scenes.py --coverage)."""

UNLIKE = 8.0
"""Of (6), a ratio of squares; chosen: where cameras are alike, one of 250 is so by chance, and of four cameras one that
was knocked reaches 9."""

ROUNDS = 3
"""Of (2) and (3), in which the mixture narrows; chosen (see benchmarks/tracking_scenes.py)."""

HELD = 0.95
"""Of (5): the share of errors that the ellipsoid of this probability is to hold; by definition of the report."""


class CalibrationField(NamedTuple):
    """The posterior (n) of ln s² at LOG_VARIANCES, the mixture of what the field leaves of the residuals, and how many
    times likelier these are with a field than with none, a natural logarithm (7)."""

    posterior: Floats
    left: Mixture
    evidence: float

    def variance(self, white: float) -> float:
        """V px² of (5) beside white noise of a variance in px²."""
        s2 = np.exp(LOG_VARIANCES)
        half = scipy.special.gammaincinv(1.5, HELD) * (white + s2[:, None]) / (white + s2)
        held = scipy.special.gammainc(1.5, half) @ self.posterior
        return float(np.exp(np.interp(HELD, held, LOG_VARIANCES)))

    def exceeds(self, variance: float) -> bool:
        """Whether s² is more than a variance in px², 0 where nothing is stated, with a probability of HELD."""
        told = variance == 0 or self.evidence > np.log(HELD / (1 - HELD))
        return bool(told and self.posterior @ (np.exp(LOG_VARIANCES) > variance) > HELD)


def calibration_field(images: Images, some: Residuals) -> CalibrationField:
    """The field of the images' residuals, by (1) to (4); what a camera unlike the others leaves (6) is noise."""
    field, constant = _field(images, some, np.ones(len(some.off), bool))
    size = (constant**2).sum(1)
    unlike = size > UNLIKE * np.median(size)
    if not unlike.any() or (~unlike).sum() < 2:
        return field
    return _field(images, some, ~unlike[some.camera].any(0))[0]


def _field(images: Images, some: Residuals, used: Bools) -> tuple[CalibrationField, Floats]:
    """The field of those residuals (H) that are used, and θ₀ (C, 2) px of the cameras."""
    C = len(images.P)
    group, own, index = pair_of(some, C), _jacobian(images, some), _index(C)
    columns = index[some.camera.T].reshape(len(own), -1)
    fit = mixture(some.off, group, C * C, some.window)
    for _ in range(ROUNDS):
        spread = fit.variance * np.maximum(fit.number / MOST_RESIDUALS, 1.0)
        weight = np.where(used & peaked(fit)[group], fit.weight / spread[group], 0.0)
        A, b = _normal_equations(own, some, weight, index)
        posterior, evidence = _posterior(A, b, 2 * C)
        s1, s0 = np.exp(LOG_VARIANCES[list(np.unravel_index(posterior.argmax(), posterior.shape))])
        expected = np.repeat([s0, s1], [2 * C, len(b) - 2 * C])
        theta = expected * np.linalg.solve(np.eye(len(b)) + A * expected, b)
        fit = mixture(some.off - (own * theta[columns]).sum(1), group, C * C, some.window)
    return CalibrationField(_of_sum(posterior), fit, evidence), theta[: 2 * C].reshape(C, 2)


def _of_sum(posterior: Floats) -> Floats:
    """(n) the posterior of ln (s₀² + s₁²) at the nearest of LOG_VARIANCES."""
    total = np.log(np.exp(LOG_VARIANCES)[:, None] + np.exp(LOG_VARIANCES))
    place = np.rint((total - LOG_VARIANCES[0]) / (LOG_VARIANCES[1] - LOG_VARIANCES[0])).astype(int)
    n = len(LOG_VARIANCES)
    return np.asarray(np.bincount(np.minimum(place, n - 1).ravel(), posterior.ravel(), n))


def _normal_equations(own: Floats, some: Residuals, weight: Floats, index: Ints) -> tuple[Floats, Floats]:
    """A and b of (2), two cameras after two, of all θ."""
    n, C = index.size, len(index)
    A, b, group = np.zeros((n, n)), np.zeros(n), pair_of(some, C)
    for pair in np.unique(group[weight > 0]):
        rows = np.flatnonzero((group == pair) & (weight > 0))
        J, which = own[rows], index[list(divmod(int(pair), C))].ravel()
        weighted = J.T * weight[rows]
        A[np.ix_(which, which)] += weighted @ J
        b[which] += weighted @ some.off[rows]
    return A, b


def _posterior(A: Floats, b: Floats, n: int) -> tuple[Floats, float]:
    """(n, n) the posterior of ln s₁² and ln s₀² by (3) and (4), the first n of θ being θ₀; and (7)."""
    size, along = np.linalg.eigh(A[n:, n:])
    size, between, part = np.maximum(size, 0.0), along.T @ A[n:, :n], along.T @ b[n:]
    log = np.empty((len(LOG_VARIANCES), len(LOG_VARIANCES)))
    for k, s1 in enumerate(np.exp(LOG_VARIANCES)):
        D = s1 / (1 + s1 * size)
        left = A[:n, :n] - between.T @ (D[:, None] * between)
        of_waves = (D * part**2 - np.log1p(s1 * size)).sum() / 2
        log[k] = of_waves + _log_likelihood(left, b[:n] - between.T @ (D * part))
    prior = -0.5 * ((LOG_VARIANCES[:, None] - 2 * np.log(USUAL_SD)) / LOG_SD) ** 2
    prior = prior[:, 1:] + prior[:, 0]
    log += prior
    evidence = np.logaddexp.reduce(log, axis=None) - np.logaddexp.reduce(prior, axis=None)
    both = np.exp(log - log.max())
    return np.asarray(both / both.sum()), float(evidence)


def _log_likelihood(A: Floats, b: Floats) -> Floats:
    """(n) of b and A at LOG_VARIANCES, as the last two terms of (3)."""
    size, along = np.linalg.eigh(A)
    size, part, s2 = np.maximum(size, 0.0), along.T @ b, np.exp(LOG_VARIANCES)[:, None]
    return np.asarray((s2 * part**2 / (1 + s2 * size) - np.log1p(s2 * size)).sum(1) / 2)


def _index(C: int) -> Ints:
    """(C, 2 K) where the θ of each camera are among all, θ₀ of all cameras first."""
    waves = 4 * WAVES.size * len(DIRECTIONS)
    first = np.arange(2 * C).reshape(C, 2)
    return np.hstack([first, 2 * C + np.arange(waves * C).reshape(C, waves)])


def _jacobian(images: Images, some: Residuals) -> Floats:
    """(H, 4 K) what of J of (2) is of the two cameras of each residual, px a px."""
    sides = zip(some.camera, some.detection, some.line, strict=True)
    return np.hstack(
        [
            (_functions(images, camera, detection)[:, :, None] * line[:, None]).reshape(len(line), -1)
            for camera, detection, line in sides
        ]
    )


def _functions(images: Images, camera: Ints, detection: Ints) -> Floats:
    """1 and φ (H, K) of (1) at images of cameras (H)."""
    place = 2 * images.uv[detection] / images.size[camera] - 1
    phase = place @ (WAVES[:, None, None] * DIRECTIONS).reshape(-1, 2).T
    waves = np.hstack([np.cos(phase), np.sin(phase)]) / np.sqrt(WAVES.size * len(DIRECTIONS))
    return np.hstack([np.ones((len(phase), 1)), waves])
