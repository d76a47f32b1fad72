"""An image as an operator and a search see it: white pixels, and the marker that each belongs to.

An operator points at any white pixel of a marker, and its centroid is what they mean (UM²AS 3.4). The markers are those
of the stage `detect`, with its centroids; a white pixel belongs to the marker of the group of touching pixels that it
lies in, and where a group was separated into several markers, to that with the nearest centre (1).

A search looks at the pixels of a square about the place where a marker is expected, and the nearest white one that
belongs to a marker which is still free says which it is (2).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data import KinemarkError, Validity
from ..data.array_types import Bools, Floats
from ..detect import Blobs, Centroids, detect_frames
from ..detect.centroids_method import grey_scale
from ..detect.levels import levelled
from ..detect.masks import masked
from ..geometry.camera import in_image

TOUCHING = np.ones((3, 3))  # pixels that touch along a side or at a corner are one; by definition
AROUND = 6
"""px; a centroid that lies on a black pixel, as of a crescent, belongs to the white one nearest to it; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class ImageMarkers:
    """What can be pointed at in one image of H × W pixels with B markers.

    Attributes:
        owner: (H, W) index of the marker that a white pixel belongs to, −1 for black ones and specks.
        uv: (B, 2) centroids, px.
        usable: (B) whether a search may take it; what is too large to be a marker only an operator can mean.
    """

    owner: NDArray[np.int32]
    uv: Floats
    usable: Bools

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        return self.owner.shape[1], self.owner.shape[0]


def find_markers(
    image: NDArray[np.uint8 | np.uint16],
    *,
    method: Centroids | None = None,
    mask: Bools | None = None,
    v_offset: float = 0.0,
) -> ImageMarkers:
    """An image (H, W) of grey levels, ready to be pointed at.

    Args:
        image: of one frame.
        method: of detection; a relative threshold is measured in this image.
        mask: (H, W) where a search takes nothing; an operator may point there.
        v_offset: added to v of all centroids, px: half a line in every other field of interlaced video.

    Raises:
        ValueError: it is no such image.
        KinemarkError: it has thousands of white specks, so the threshold lies in its noise.
    """
    if image.ndim != 2:
        raise ValueError(f"image has shape {image.shape}, wanted (rows, columns)")
    method = replace(method or Centroids(), aspect=(method or Centroids()).aspect or 1.0)
    ready = levelled(method, image[None])
    blobs = detect_frames(image[None], method=method)
    if mask is not None:
        blobs = masked(blobs, mask)
    white = np.zeros(image.shape, np.bool_) if ready is None else _white(image, ready)
    usable = ~np.isin(blobs.validity, (Validity.TOO_LARGE, Validity.MASKED))
    return ImageMarkers(_owners(white, blobs), blobs.uv + np.array([0.0, v_offset]), usable)


def threshold_of(image: NDArray[np.uint8 | np.uint16], method: Centroids | None = None) -> float | None:
    """The grey level of 8 bits beyond which pixels of an image (H, W) are white; None where it has no marker."""
    method = replace(method or Centroids(), aspect=(method or Centroids()).aspect or 1.0)
    ready = levelled(method, image[None])
    return None if ready is None else float(ready.limits.threshold)


def _white(image: NDArray[np.uint8 | np.uint16], method: Centroids) -> Bools:
    """(H, W) which pixels are white."""
    level = method.limits.threshold * grey_scale(image.dtype)
    return np.asarray(image < level if method.inverted else image > level)


def _owners(white: Bools, blobs: Blobs) -> NDArray[np.int32]:
    """(H, W) by (1)."""
    found, n = scipy.ndimage.label(white, TOUCHING)
    group = np.asarray(found, np.int32)
    of = np.array([_group_at(group, uv) for uv in blobs.uv], np.int64)
    alone = np.full(n + 1, -1, np.int32)
    alone[of] = np.arange(len(of))
    alone[0] = -1
    owner = alone[group]
    for shared in np.flatnonzero(np.bincount(of, minlength=n + 1) > 1):
        members = np.flatnonzero(of == shared)
        if shared:
            v, u = np.nonzero(group == shared)
            distance = np.hypot(u[:, None] - blobs.uv[members, 0], v[:, None] - blobs.uv[members, 1])
            owner[v, u] = members[distance.argmin(1)]
    return owner


def _group_at(group: NDArray[np.int32], uv: Floats) -> int:
    """The group of the white pixel nearest to a centroid; 0 where none is near."""
    window, left, top = _window(group, uv, AROUND)
    v, u = np.nonzero(window)
    if not len(u):
        return 0
    near = int(np.hypot(u + left - uv[0], v + top - uv[1]).argmin())
    return int(window[v[near], u[near]])


def _window(values: NDArray[np.int32], uv: Floats, half: int) -> tuple[NDArray[np.int32], int, int]:
    """The pixels at most `half` from the one at uv, and the column and row of the first of them."""
    u, v = (int(x) for x in np.clip(np.rint(uv), -1e6, 1e6))
    left, top = max(u - half, 0), max(v - half, 0)
    return values[top : max(v + half + 1, 0), left : max(u + half + 1, 0)], left, top


def clicked(image_markers: ImageMarkers, uv: Floats) -> int:
    """The marker of the white pixel that an operator points at, (2,) px.

    Raises:
        KinemarkError: the place is outside the image, or no marker's.
    """
    width, height = image_markers.size
    u, v = (float(x) for x in uv)
    if not in_image((width, height), u, v):
        raise KinemarkError(f"({u:g}, {v:g}) is outside the image of {width} × {height} px. Point into it.")
    owner = int(image_markers.owner[round(v), round(u)])
    if owner < 0:
        raise KinemarkError(
            f"There is no white pixel of a marker at ({u:g}, {v:g}). Point at one, or say that the marker is not "
            "present; if it is there and dark, lower the threshold."
        )
    return owner


def nearest_free(image_markers: ImageMarkers, uv: Floats, *, free: Bools, side: int) -> tuple[float, int] | None:
    """The marker by (2) among those that are `free` (B), in a square of `side` px, and how far it is, px."""
    if not np.isfinite(uv).all():
        return None
    window, left, top = _window(image_markers.owner, uv, side // 2)
    v, u = np.nonzero(np.append(free, False)[window])
    if not len(u):
        return None
    distance = np.hypot(u + left - uv[0], v + top - uv[1])
    at = int(distance.argmin())
    return float(distance[at]), int(window[v[at], u[at]])
