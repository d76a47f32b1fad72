"""Masks at work: learned from a recording of the empty volume, combined, and laid on detections.

The share of a detection within the mask is that of `PLACES` of the ellipse with its width and height. In interlaced
recordings masks, like detections, are in the lines of a field, so that they are half as high as in the whole image.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data import Detections, KinemarkError, Validity
from ..data.masks import Masks
from ..data.method import Method
from ..numerics.runs import equal_runs, true_runs_of_rows
from .blobs import Blobs
from .centroids_method import Centroids, check_images, grey_scale
from .frame_source import BATCH, FrameSource
from .kiss import KissNearest, KissScanning

MOSTLY = 0.5  # of a spot's area; masked above, half masked below; chosen
_TURN = np.arange(24) * 2 * np.pi / 24  # rad; directions round a disc; chosen
_RINGS = [r * np.stack([np.cos(_TURN), np.sin(_TURN)], -1)[::step] for r, step in ((0.33, 6), (0.67, 2), (1, 1))]
"""radii and directions of places in a unit disc; chosen to share out its area."""
PLACES = np.concatenate([np.zeros((1, 2)), *_RINGS])
"""Places that share out the area of the unit disc; by definition."""


def learn_masks(
    sources: Sequence[FrameSource],
    *,
    cameras: Sequence[str],
    method: Method | None = None,
    of_cameras: Mapping[str, Method] = MappingProxyType({}),
    share: float = 0.1,
    grow: float = 3.0,
) -> Masks:
    """The masks that an empty recording shows: what is white in it, with no marker there, is none.

    Args:
        sources: what each camera recorded of the empty volume.
        cameras: their names.
        method: says which pixels are white.
        of_cameras: methods of single cameras by their names, in its place.
        share: of the frames in which a pixel must be white, from above 0 to 1.
        grow: by how much masks reach farther than that, px.

    Raises:
        ValueError: not one name a source, a method of a camera that is not there, a parameter is out of range, or a
            method's threshold is relative, as it would be measured on strobes.
        KinemarkError: a recording has no frames.
    """
    if len(sources) != len(cameras):
        raise ValueError(f"there are {len(sources)} sources and {len(cameras)} camera names, wanted one each")
    if unknown := [name for name in of_cameras if name not in cameras]:
        raise ValueError(f"of_cameras names {', '.join(unknown)}, and the cameras are {', '.join(cameras)}")
    if not 0 < share <= 1 or not 0 <= grow < np.inf:
        raise ValueError(
            f"share and grow are {share} and {grow}, wanted a share above 0 and at most 1, and 0 px or more"
        )
    each = [of_cameras.get(name) or method or Centroids() for name in cameras]
    relative = [m.relative_threshold for m in each if isinstance(m, Centroids) and m.relative_threshold is not None]
    if relative:
        raise ValueError(
            f"relative_threshold is {relative[0]}, wanted None: an empty recording has no markers "
            "to measure it by. Say a threshold"
        )
    masks = [_often_white(*one, share, grow) for one in zip(sources, cameras, each, strict=True)]
    sizes = np.array([mask.shape[::-1] for mask in masks]).reshape(-1, 2)
    return Masks(tuple(cameras), sizes, tuple(rectangles(mask) for mask in masks))


def combined_masks(first: Masks, second: Masks) -> Masks:
    """What either masks.

    Raises:
        KinemarkError: a camera has images of one size in the one and of another in the other.
    """
    names = first.cameras + tuple(name for name in second.cameras if name not in first.cameras)
    sizes, polygons = [], []
    for name in names:
        places = [(m, m.cameras.index(name)) for m in (first, second) if name in m.cameras]
        found = [(m.sizes[c], m.polygons[c]) for m, c in places]
        if any((size != found[0][0]).any() for size, _ in found):
            raise KinemarkError(
                f"The masks of camera {name} are for images of {_by(found[0][0])} and {_by(found[1][0])} px. "
                "Draw or learn them for one size."
            )
        sizes.append(found[0][0])
        polygons.append(sum((own for _, own in found), ()))
    return Masks(names, np.array(sizes).reshape(-1, 2), tuple(polygons))


def masked(blobs: Blobs, mask: NDArray[np.bool_]) -> Blobs:
    """The detections, those mostly within the mask (H, W) MASKED and those that touch it merged.

    Their v counts in lines of the image that the mask is for, before fields are put on one plane.
    """
    if not len(blobs.uv) or not mask.any():
        return blobs
    half = np.stack([blobs.width, blobs.height], -1) / 2
    places = np.rint(blobs.uv[:, None] + half[:, None] * PLACES).astype(np.int64)
    u, v = (np.clip(places[..., i], 0, mask.shape[1 - i] - 1) for i in (0, 1))
    share = mask[v, u].mean(1)
    validity = np.where(share > MOSTLY, np.uint8(Validity.MASKED), blobs.validity)
    return blobs._replace(validity=validity, merged=blobs.merged | ((share > 0) & (share <= MOSTLY)))


def check_masks(masks: Masks | None, cameras: Sequence[str]) -> None:
    """Whether all masks are of cameras that the recording has.

    Raises:
        KinemarkError: one is not.
    """
    if masks and (unknown := [name for name in masks.cameras if name not in cameras]):
        raise KinemarkError(
            f"There are masks of {', '.join(unknown)}, and the recording has {', '.join(cameras)}. "
            "Give the cameras the same names in both, or leave those masks out."
        )


def rectangles(mask: NDArray[np.bool_]) -> tuple[NDArray[np.float64], ...]:
    """Rectangles (4, 2) px that cover exactly the masked pixels: equal runs of consecutive lines as one."""
    line, left, right = true_runs_of_rows(mask).T
    order = np.lexsort((line, right, left))
    line, left, right = line[order], left[order], right[order]
    ends = equal_runs(left, right, line - np.arange(len(line)))
    first, last = ends[:-1], ends[1:] - 1
    sides = zip(left[first] - 0.5, right[first] - 0.5, line[first] - 0.5, line[last] + 0.5, strict=True)
    return tuple(np.array([(x1, y1), (x2, y1), (x2, y2), (x1, y2)]) for x1, x2, y1, y2 in sides)


def masked_centroids(found: Detections, masks: Masks) -> Detections:
    """The same, those whose centroid lies on a masked pixel not valid: all that is known of spots in a table.

    Raises:
        KinemarkError: a mask is of a camera that is not among them.
    """
    check_masks(masks, found.cameras)
    validity = found.validity.copy()
    for c, name in enumerate(found.cameras):
        if name not in masks.cameras:
            continue
        own = slice(found.start[c, 0], found.start[c, -1])
        pixels = masks.pixels(name)
        u, v = np.floor(found.uv[own] + 0.5).T
        inside = (u >= 0) & (v >= 0) & (u < pixels.shape[1]) & (v < pixels.shape[0])
        inside[inside] = pixels[v[inside].astype(int), u[inside].astype(int)]
        validity[own][inside & (validity[own] == Validity.VALID)] = Validity.MASKED
    return replace(found, validity=validity)


def _often_white(source: FrameSource, name: str, method: Method, share: float, grow: float) -> NDArray[np.bool_]:
    """(H, W) the pixels that are white in at least this share of a camera's frames, grown."""
    white, frames = None, 0
    for images in source.batches(BATCH):
        check_images(images)
        assert isinstance(method, (Centroids, KissScanning, KissNearest))  # all methods of detection
        said = method.limits if isinstance(method, Centroids) else method
        level = said.threshold * grey_scale(images.dtype)
        now = (images < level if method.inverted else images > level).sum(0)
        white, frames = now if white is None else white + now, frames + len(images)
    if white is None:
        raise KinemarkError(f"Camera {name}: the recording of the empty volume has no frames. Record some.")
    mask = np.asarray(white >= max(share * frames, 1))
    return np.asarray(scipy.ndimage.distance_transform_edt(~mask) <= grow) if mask.any() else mask


def _by(size: NDArray[np.int64]) -> str:
    return f"{size[0]} × {size[1]}"
