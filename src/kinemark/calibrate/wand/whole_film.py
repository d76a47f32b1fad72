"""A wand's film within which a camera lost images, or took some twice: put into the frames that they show.

A camera that shows other moments from some frame on looks like one that was moved, or as if it fitted no other. Cameras
that are nearly right tell which it is (`bundle.lost_images`): those found by all frames, unless they were found by two
cameras alone or seem moved; else those of the first or of the last part of the film, one of which lacks no image.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from ...data import Detections, KinemarkError, Rig
from ...data.array_types import Bools, Floats, Ints
from ..bundle import BundleFit
from ..bundle.lost_images import LostImages, changes, images_ahead, in_place
from .identify import at_rows, read_wand, wanted

ROUNDS = 2
"""Of cameras and the images that they miss, in turn; chosen: the first cameras tell a change to some frames only."""


def with_lost_images(
    detections: Detections,
    along: Floats,
    late: Floats,
    rigs: Iterable[Rig],
    again: Callable[[Detections], BundleFit],
) -> BundleFit | None:
    """The fit of a film whose images are put in their frames; None where no images miss.

    Args:
        detections: as recorded. along: (K) places of the markers, mm.
        late: (C) images by which cameras are late all the time.
        rigs: cameras, or some of them, that may be nearly right, asked in turn.
        again: the fit of a film that lacks no images.
    """
    uv = at_rows(detections, read_wand(detections, wanted(detections), along).rows)[0]
    for rig in rigs:
        if (ahead := _ahead(rig, detections, uv, late)) is None:
            continue
        try:
            return _in_place(detections, uv, ahead, again)
        except KinemarkError:  # these cameras were not right, or something else is wrong too
            continue
    return None


def _in_place(
    detections: Detections, uv: Floats, ahead: Ints, again: Callable[[Detections], BundleFit]
) -> BundleFit | None:
    """The fit with images that are `ahead` (C, F), or as its cameras then say; None where they say of none."""
    for _ in range(ROUNDS):
        fit = again(in_place(detections, ahead))
        used, told = ahead, _ahead(fit.rig, detections, uv, fit.delay)
        if told is None:
            return None
        if (told == used).all():
            break
        ahead = told
    seen: Bools = np.asarray(np.isfinite(uv).all((2, 3)))
    lost = tuple(changes(detections.cameras, used, seen))
    text = "; ".join(_words(one) for one in lost)
    return fit._replace(rig=replace(fit.rig, method=f"{fit.rig.method}; {text}"), lost=lost)


def _words(one: LostImages) -> str:
    """What is said of it in a rig's method."""
    n, how = abs(one.images), "lost" if one.images > 0 else "took twice"
    said = f"{one.camera} {how}" if one.alone else "one of the two cameras lost or took twice"
    return f"{said} {n} image{'s' * (n > 1)} before image {one.last + 1} of {one.camera}"


def _ahead(rig: Rig, detections: Detections, uv: Floats, late: Floats) -> Ints | None:
    """By how many images (C, F) cameras are ahead of their first, by some cameras; the others never are."""
    few = [detections.cameras.index(name) for name in rig.names]
    if (found := images_ahead(rig, uv[few], late[few])) is None:
        return None
    ahead = np.zeros(uv.shape[:2], np.int64)
    ahead[few] = found - found[:, :1]
    return ahead
