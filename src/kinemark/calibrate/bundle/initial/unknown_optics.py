"""What is assumed of cameras of which only the image size is known: centre, shape of pixels, and how far lines bend.

The optical axis meets the image at its centre and pixels have a stated shape, or both are as a linearisation found
them. A lens that bends lines is undone, before anything else is known, by one number a camera (Fitzgibbon 2001): with
the place d from the centre and h half the image's diagonal, both in px of a camera with square pixels,

    ideal = d / (1 + λ |d|² / h²)                                        (1)

which to first order is k1 = λ f² / h² (2). λ is found together for all cameras: it is the one with which points of
two cameras fit a fundamental matrix best. Starting with one for all, each camera's is changed by ever smaller steps
while the sum over all pairs of ln(mean square Sampson distance) falls (3).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data import Camera
from ....data.array_types import Bools, Floats, Ints
from ....geometry import undistort
from ....geometry.two_view import fit_fundamental, sampson_distance
from ....numerics.evenly import evenly
from ..solver import POWERS

COMMON = (0.0, -0.05, -0.1, -0.16, -0.24, 0.06)
"""k1 that all cameras may have, tried first; chosen to span usual lenses (see benchmarks/bundle.py)."""
STEPS = (0.06, 0.03, 0.015)  # of k1, tried about the best one after the other; chosen (see benchmarks/bundle.py)
ENOUGH = 200  # points of a pair at most; chosen for speed
SHARPEST = 0.05  # px; a finer fit is chance; chosen (see benchmarks/bundle.py)


class UnknownOptics(NamedTuple):
    """One camera before it is calibrated.

    Attributes:
        camera: name, size, K with the centre and fy / fx, and the lens where a linearisation found it.
        bend: λ of (1).
        lens: whether `camera` has a lens that was found.
    """

    camera: Camera
    bend: float
    lens: bool

    @property
    def half(self) -> float:
        """h of (1), px."""
        return float(np.hypot(*(self.camera.size / self._stretch)) / 2)

    @property
    def _stretch(self) -> Floats:
        """(2) a pixel's sides of a camera with square pixels, in pixels of this one."""
        K = self.camera.K
        return np.array([1.0, K[1, 1] / K[0, 0]])

    def ideal(self, uv: Floats, bend: float | None = None) -> Floats:
        """Pixels (…, 2) as px from the centre, of a camera with square pixels and no lens."""
        d = ((undistort(self.camera, uv) if self.lens else uv) - self.camera.K[:2, 2]) / self._stretch
        bend = self.bend if bend is None else bend
        return np.asarray(d / (1 + bend * (d**2).sum(-1, keepdims=True) / self.half**2))  # (1)

    def with_focus(self, f: float, R: Floats, t: Floats) -> Camera:
        """The camera with a focal length of f px, at R (3, 3), t (3) mm."""
        K = self.camera.K.copy()
        ratio = f / K[0, 0]
        K[0, 0], K[1, 1] = f, K[1, 1] * ratio
        k = self.camera.distortion * ratio**POWERS if self.lens else np.zeros(5)
        if not self.lens:
            k[0] = self.bend * f**2 / self.half**2  # (2)
        return Camera(self.camera.name, self.camera.size, K, R, t, k)


def unknown_optics(name: str, size: Ints, aspect: float = 1.0) -> UnknownOptics:
    """A camera of which only the image size (2) px is known, and fy / fx."""
    f = max(size[0], size[1] / aspect)
    K = np.array([[f, 0.0, (size[0] - 1) / 2], [0.0, f * aspect, (size[1] - 1) / 2], [0.0, 0.0, 1.0]])
    return UnknownOptics(Camera(name, size, K, np.eye(3), np.zeros(3)), 0.0, False)


def straightened(optics: list[UnknownOptics], uv: Floats, pairs: dict[tuple[int, int], Bools]) -> list[UnknownOptics]:
    """The optics with λ by (3), from pixels uv (C, N, 2) and, for pairs of cameras, which points (N) fit each other."""
    free = [c for c, o in enumerate(optics) if not o.lens]
    chosen = {pair: _thinned(np.flatnonzero(good)) for pair, good in pairs.items()}
    bends = np.array([o.bend for o in optics])

    def misfit(bends: Floats, camera: int | None = None) -> float:
        """(3), of the pairs of one camera."""
        total = 0.0
        for (a, b), rows in chosen.items():
            if camera in (None, a, b):
                x, y = optics[a].ideal(uv[a, rows], bends[a]), optics[b].ideal(uv[b, rows], bends[b])
                d = sampson_distance(fit_fundamental(x, y), x, y)
                total += float(np.log((d**2).mean() + SHARPEST**2))
        return total

    if free:
        common = [np.where(np.isin(np.arange(len(bends)), free), bend, bends) for bend in COMMON]
        bends = min(common, key=misfit)
    for step in STEPS:
        for c in free:
            tries = [bends + sign * step * (np.arange(len(bends)) == c) for sign in (0, -1, 1)]
            bends = min(tries, key=lambda tried: misfit(tried, c))
    return [o._replace(bend=float(bend)) for o, bend in zip(optics, bends, strict=True)]


def _thinned(rows: Ints) -> Ints:
    """At most `ENOUGH` of them, evenly."""
    return rows[evenly(len(rows), ENOUGH)]
