"""Static masks: parts of a camera's images in which nothing is a marker, such as opposite strobes and reflections.

A mask is polygons; a pixel is masked when its centre lies within one, that is, when a ray from there to the left
crosses the outline an odd number of times (1). A side from (x₁, y₁) to (x₂, y₂) is crossed by line y when y₁ ≤ y < y₂,
at x = x₁ + (y − y₁) (x₂ − x₁) / (y₂ − y₁) (2), so that corners count once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .array_types import Bools, Floats, Ints
from .short_repr import ShortRepr


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Masks(ShortRepr):
    """Masks of C cameras.

    Attributes:
        cameras: (C) names.
        sizes: (C, 2) width and height of their images, px; of a field where interlaced.
        polygons: for each camera its polygons, (n, 2) px each, closed by themselves.
    """

    cameras: tuple[str, ...]
    sizes: Ints
    polygons: tuple[tuple[Floats, ...], ...]

    def __post_init__(self) -> None:
        sizes = np.array(self.sizes, np.int64).reshape(-1, 2)
        polygons = tuple(tuple(_polygon(p) for p in own) for own in self.polygons)
        if len(set(self.cameras)) != len(self.cameras):
            raise ValueError(f"cameras are {list(self.cameras)}, wanted each name once")
        if not len(self.cameras) == len(sizes) == len(polygons):
            raise ValueError(
                f"there are {len(self.cameras)} cameras, {len(sizes)} sizes and {len(polygons)} lists of polygons, "
                "wanted one each"
            )
        if (sizes < 1).any():
            raise ValueError(f"sizes are {sizes.tolist()}, wanted a width and height of at least 1 px")
        sizes.flags.writeable = False
        for name, value in (("cameras", tuple(self.cameras)), ("sizes", sizes), ("polygons", polygons)):
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        """How many cameras have a mask."""
        return len(self.cameras)

    def pixels(self, camera: str) -> Bools:
        """(H, W) whether each pixel of a camera is masked.

        Raises:
            ValueError: there is no mask of that camera.
        """
        if camera not in self.cameras:
            raise ValueError(f"camera {camera!r} is not among those with a mask, {list(self.cameras)}")
        c = self.cameras.index(camera)
        width, height = (int(n) for n in self.sizes[c])
        mask = np.zeros((height, width), np.bool_)
        for polygon in self.polygons[c]:
            mask |= rasterised(polygon, width, height)
        return mask


def rasterised(polygon: Floats, width: int, height: int) -> Bools:
    """(height, width) whether the centre of each pixel lies in a polygon (n, 2) px, by (1)."""
    crossed = np.zeros((height, width + 1), np.bool_)
    for (x1, y1), (x2, y2) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if y1 > y2:
            x1, y1, x2, y2 = x2, y2, x1, y1
        y = np.arange(max(int(np.ceil(y1)), 0), min(int(np.ceil(y2)), height))
        if len(y):
            x = np.ceil(x1 + (y - y1) * (x2 - x1) / (y2 - y1))  # (2)
            crossed[y, np.clip(x, 0, width).astype(np.int64)] ^= True
    return np.logical_xor.accumulate(crossed[:, :width], axis=1)


def _polygon(points: ArrayLike) -> Floats:
    polygon = np.array(points, np.float64)
    if polygon.ndim != 2 or polygon.shape[1] != 2 or len(polygon) < 3 or not np.isfinite(polygon).all():
        raise ValueError(f"a polygon has shape {polygon.shape}, wanted three or more finite corners (x, y), px")
    polygon.flags.writeable = False
    return polygon
