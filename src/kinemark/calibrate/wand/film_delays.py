"""A wand's film by cameras that did not take their images at the same moments: from it follow delays, then the rig.

Where cameras seem late, or all together are no calibration, delays are looked for by pairs of cameras (`delays`), and
the detections are moved to common times (`signal.common_time`). Of a rig that was found, points tell what delays are
left (`left_delays`); while these are more than chance, the rig is fitted again, from the one that was found.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from ...data import Detections, KinemarkError
from ...data.array_types import Floats, Ints
from ...signal.common_time import at_common_time, image_flow
from ..bundle import BundleFit
from ..bundle.camera_step import CameraStep
from .delays import delays_between, seem_late
from .identify import at_rows, read_wand, wanted
from .left_delays import left_delays

ROUNDS = 3
"""Of rigs and what delays they leave; chosen: the second left 0.0005 images in simulated films."""


class WandFit(NamedTuple):
    """A fit, and the rows (C, F, K) that it was made from."""

    fit: BundleFit
    rows: Ints


class InTime(NamedTuple):
    """A fit with the delays of its cameras, and the move of a camera that showed before small delays were fitted."""

    fit: BundleFit
    step: CameraStep | None


Calibrated: TypeAlias = Callable[[Detections, BundleFit | None], WandFit]
"""The fit of synchronous cameras, from a fit that is nearly right where there is one."""


def with_delays(
    detections: Detections, along: Floats, calibrated: Calibrated, *, pairs: bool = True, rounds: int = ROUNDS
) -> InTime:
    """The fit of cameras that may be late, with their delays.

    Args:
        detections: as recorded. along: (K) places of the markers, mm.
        calibrated: the fit of synchronous cameras.
        pairs: whether pairs of cameras are asked first, or only where there is no fit without.

    Raises:
        KinemarkError: as `calibrated` of the detections as recorded, where no delays make a calibration of them.
    """
    found, delay = _first_fit(detections, along, calibrated, pairs)
    step = found.fit.step
    for _ in range(rounds):
        left = left_delays(found.fit, _flow(_in_time(detections, delay), found.rows))
        if not left.any():
            break
        try:
            found = calibrated(_in_time(detections, delay + left), found.fit)
            delay = delay + left
        except KinemarkError:
            break
    return InTime(found.fit._replace(delay=delay), step)


def _first_fit(detections: Detections, along: Floats, calibrated: Calibrated, pairs: bool) -> tuple[WandFit, Floats]:
    """A fit, and the delays (C) with which it was made: those of pairs first, where cameras seem late by images."""
    uv = at_rows(detections, read_wand(detections, wanted(detections), along).rows)[0]
    late = pairs and seem_late(uv)
    if late and (found := _with_pair_delays(detections, uv, calibrated)):
        return found
    try:
        return calibrated(detections, None), np.zeros(len(uv))
    except KinemarkError:
        if late or not (found := _with_pair_delays(detections, uv, calibrated)):
            raise
    return found


def _with_pair_delays(detections: Detections, uv: Floats, calibrated: Calibrated) -> tuple[WandFit, Floats] | None:
    """The fit with the delays that pairs tell of markers uv (C, F, K, 2), and these; None where there is none."""
    if (delay := delays_between(uv)) is None:
        return None
    try:
        return calibrated(_in_time(detections, delay), None), delay
    except KinemarkError:
        return None


def _in_time(detections: Detections, delay: Floats) -> Detections:
    """Detections of cameras that are late by so many images (C), at the times of the frames.

    Those that no motion tells where they were then are left out: a calibration has enough others.
    """
    if not delay.any():
        return detections
    moved, row = at_common_time(detections, delay / detections.rate)
    known = np.isfinite(image_flow(detections)).all(1) | (delay == np.rint(delay))[detections.camera]
    return moved.keep(known[row])


def _flow(detections: Detections, rows: Ints) -> Floats:
    """(C, N, 2) px an image of markers in rows (C, F, K)."""
    flow = np.where((rows >= 0)[..., None], image_flow(detections)[rows], np.nan)
    return flow.reshape(len(rows), -1, 2)
