"""What is usual of cameras, of lens terms that the points need not determine.

A term that is held at zero moves images all the same, by little where the points were, which the fitted terms imitate,
and by more beyond them: points look surer there than they are. So such terms are fitted too, as far as the points tell
of them more than is known anyway: with the values

    v = (fy / fx, k1, k2, p1, p2, k3)                                    (1)

those of usual cameras differ from what is taken by σ (`USUAL`). That is one more residual a term,

    (v − v₀) / σ                                                         (2)

(a Gaussian prior). Image points have covariances that are right in proportion only, to a
factor s², so that s² / σ² is the precision (3). Where the points say anything of a term, (2) has no weight. Where they
say nothing it stays at v₀, and the covariance of the camera has its σ², or less where the lenses of the whole rig are
nearer to v₀ than that (`usual_terms`).

Few images may leave open even the radial terms that they are to tell: what then fits best is a lens that folds its
image over. So those too have (2), about an ideal lens whatever they begin with, and without being learned from the rig.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...data import Camera
from ...data.array_types import Bools, Floats

USUAL = np.array([1e-3, 0.2, 0.1, 1e-3, 1e-3, 0.05])
"""Standard deviations σ of (1), without unit; chosen: by judgement of usual lenses, before any was tried, p1 and p2 as
in `lens.plane_views`."""

RADIAL = np.isin(np.arange(6), (1, 2, 5))
"""Which of (1) are radial terms, without unit; by definition."""


class LensPrior(NamedTuple):
    """v₀ and precision of (1), each (6), 0 of what is not known beforehand; and which (6) the images are to tell."""

    usual: Floats
    precision: Floats
    told: Bools

    @classmethod
    def of(cls, terms: Bools, told: Bools) -> LensPrior:
        """Of some of (1), (6), and radial ones of `told`, about an ideal lens, for images of right covariances."""
        told = told & RADIAL
        return cls(np.array([1.0, 0, 0, 0, 0, 0]), np.where(terms | told, USUAL**-2, 0.0), told)

    @property
    def learned(self) -> Bools:
        """(6) what is known beforehand, of terms that the images need not tell."""
        return (self.precision > 0) & ~self.told

    @property
    def known(self) -> int:
        """How many of (1) something is known of."""
        return int(np.count_nonzero(self.precision))

    def about(self, camera: Camera, terms: Bools) -> LensPrior:
        """About this camera, of those `terms` (6) only."""
        usual = np.where(self.told, self.usual, values_of(camera))
        return self._replace(usual=usual, precision=np.where(terms, self.precision, 0.0))

    def weighed(self, scale: float) -> LensPrior:
        """For images whose standard deviations are to be multiplied by `scale`, (3)."""
        return self._replace(precision=np.where(self.precision > 0, (scale / USUAL) ** 2, 0.0))

    def cost(self, camera: Camera) -> float:
        """Squares of (2)."""
        return float(self.precision @ (values_of(camera) - self.usual) ** 2)

    def equations(self, camera: Camera) -> tuple[Floats, Floats]:
        """Share of the normal matrix (15, 15) of `data.PARAMETERS`, and of the right side (15)."""
        D = directions_of(camera)
        weighed = D.T * self.precision
        return weighed @ D, weighed @ (self.usual - values_of(camera))


def values_of(camera: Camera) -> Floats:
    """(1)."""
    return np.array([camera.K[1, 1] / camera.K[0, 0], *camera.distortion])


def directions_of(camera: Camera) -> Floats:
    """Derivatives (6, 15) of (1) by `data.PARAMETERS`."""
    fx, fy = camera.K[0, 0], camera.K[1, 1]
    D = np.zeros((6, 15))
    D[0, :2] = -fy / fx**2, 1 / fx
    D[1:, 4:9] = np.eye(5)
    return D


def with_values(camera: Camera, values: Floats) -> Camera:
    """The camera with other values (6) of (1)."""
    K = camera.K.copy()
    K[1, 1] = values[0] * K[0, 0]
    return replace(camera, K=K, distortion=values[1:])
