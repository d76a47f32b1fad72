"""A wand's film by cameras that did not take their images at the same moments: from it follow delays, then the rig.

Where all cameras together are no calibration, delays are looked for by pairs of cameras (`delays`), and the detections
are moved to common times (`signal.common_time`). Of a rig that was found, points tell what delays are left
(`left_delays`); while these are more than chance, the rig is made again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...data import Detections, KinemarkError
from ...data.array_types import Floats, Ints
from ...signal.common_time import at_common_time, image_flow
from ..bundle import BundleFit
from .delays import delays_between
from .identify import at_rows, read_wand, wanted
from .left_delays import left_delays

ROUNDS = 3
"""Of rigs and what delays they leave; chosen: the second left 0.0005 images in simulated films."""


class WandFit(NamedTuple):
    """A fit, and the rows (C, F, K) that it was made from."""

    fit: BundleFit
    rows: Ints


def with_delays(
    detections: Detections, along: Floats, calibrated: Callable[[Detections], WandFit], *, rounds: int = ROUNDS
) -> BundleFit:
    """The fit of cameras that may be late, with their delays.

    Args:
        detections: as recorded. along: (K) places of the markers, mm.
        calibrated: the fit of synchronous cameras.

    Raises:
        KinemarkError: as `calibrated` of the detections as recorded, where no delays make a calibration of them.
    """
    delay, seen = np.zeros(len(detections.cameras)), detections
    try:
        found = calibrated(detections)
    except KinemarkError as error:
        between = delays_between(at_rows(detections, read_wand(detections, wanted(detections), along)[0])[0])
        if between is None:
            raise
        try:
            delay, seen = between, _in_time(detections, between)
            found = calibrated(seen)
        except KinemarkError:
            raise error from None
    for _ in range(rounds):
        left = left_delays(found.fit, _flow(seen, found.rows))
        if not left.any():
            break
        try:
            seen = _in_time(detections, delay + left)
            found, delay = calibrated(seen), delay + left
        except KinemarkError:
            break
    return found.fit._replace(delay=delay)


def _in_time(detections: Detections, delay: Floats) -> Detections:
    """Detections of cameras that are late by so many images (C), at the times of the frames.

    Those that no motion tells where they were then are left out: a calibration has enough others.
    """
    moved, row = at_common_time(detections, delay / detections.rate)
    known = np.isfinite(image_flow(detections)).all(1) | (delay == np.rint(delay))[detections.camera]
    return moved.keep(known[row])


def _flow(detections: Detections, rows: Ints) -> Floats:
    """(C, N, 2) px an image of markers in rows (C, F, K)."""
    flow = np.where((rows >= 0)[..., None], image_flow(detections)[rows], np.nan)
    return flow.reshape(len(rows), -1, 2)
