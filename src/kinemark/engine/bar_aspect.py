"""The aspect ratio of a camera's pixels, from images of a bar of markers that is turned before it.

The markers of each image are put in their order along the bar, the line that fits them best. An image with another
number of markers than most have, or whose markers lie on no line, is left out. Which end of the bar is which does not
matter: only distances of markers from their opposites count. Of an odd number the middle one has none.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..calibrate.aspect import AspectRatio, aspect_ratio
from ..data import KinemarkError
from ..data.array_types import Floats
from ..detect import Centroids
from ..digitise import find_markers
from ..io.images import ImageSource, open_images

STRAIGHT = 0.02
"""Most that markers are off their line, RMS, of the bar's length; chosen: a lens bends the line of a bar by less."""
FEWEST = 3
"""Angles of the bar; by definition: two distances and their change, and one to see that they agree."""


class BarAspect(NamedTuple):
    """The aspect ratio, of how many images of how many it is, and how many markers the bar has."""

    ratio: AspectRatio
    used: int
    images: int
    markers: int

    def figures(self) -> dict[str, float | int]:
        """For a machine."""
        before, after = self.ratio.spread
        return {
            "factor": self.ratio.factor, "sd": self.ratio.sd, "images": self.images, "used": self.used,
            "markers": self.markers, "spread_before_px": before, "spread_after_px": after, "cf": self.ratio.cf,
        }  # fmt: skip

    def said(self) -> str:
        """In words."""
        f = self.figures()
        return (
            f"V × {f['factor']:.4f} ± {f['sd']:.4f} makes pixels square: a bar of {f['markers']} markers in "
            f"{f['used']} of {f['images']} images. Distances that should be equal differ by up to "
            f"{f['spread_before_px']:.2f} px before, {f['spread_after_px']:.2f} px after."
        )


def bar_aspect_of_file(images: Path | str, *, method: Centroids) -> BarAspect:
    """The aspect ratio from a camera's video, or its images as 'bar/%04d.png'; raises as `bar_aspect` does."""
    source = open_images(images)
    try:
        return bar_aspect(source, method=method)
    except KinemarkError as error:
        raise KinemarkError(f"{images}: {error}") from error


def bar_aspect(source: ImageSource, *, method: Centroids) -> BarAspect:
    """The aspect ratio from a camera's images of a bar at several angles, in a plane that faces the camera.

    Args:
        source: the images.
        method: of detection.

    Raises:
        KinemarkError: no images, or too few, show the same number of markers on a line, or see `aspect_ratio`.
    """
    seen = [find_markers(image, method=method).uv for image in source.frames()]
    counts = [len(uv) for uv in seen if len(uv) > 1]
    most = max(counts, key=counts.count, default=0)
    bars = [along(uv) for uv in seen if len(uv) == most and _straight(uv)]
    if len(bars) < FEWEST:
        found = ", ".join(f"{n} markers in {counts.count(n)}" for n in sorted(set(counts))) or "no markers"
        raise KinemarkError(
            f"{len(bars)} of {source.n_frames} images show a bar: {found}. Wanted: the same markers on a line "
            f"in {FEWEST} or more. Change the threshold, and take away what else is bright."
        )
    uv = np.stack(bars)
    if most % 2:
        uv = np.delete(uv, most // 2, axis=1)
    return BarAspect(aspect_ratio(uv), len(bars), source.n_frames, most)


def along(uv: Floats) -> Floats:
    """Markers (n, 2) px in their order along the line that fits them best."""
    return np.asarray(uv[np.argsort((uv - uv.mean(0)) @ _axes(uv)[0], kind="stable")])


def _straight(uv: Floats) -> bool:
    centred = uv - uv.mean(0)
    length = np.ptp(centred @ _axes(uv)[0])
    return bool(np.sqrt(((centred @ _axes(uv)[1]) ** 2).mean()) <= STRAIGHT * length)


def _axes(uv: Floats) -> Floats:
    """(2, 2) the direction of the line that fits best, and the one across it."""
    return np.asarray(np.linalg.svd(uv - uv.mean(0), full_matrices=False)[2])
