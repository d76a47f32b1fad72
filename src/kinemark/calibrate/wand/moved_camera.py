"""Why a wand's cameras fit nothing: one was moved meanwhile, as cameras of the first part, or of the last, tell.

What the cameras saw on one side of the move is a calibration (`bundle.one_side`).

Cameras of all frames that had to please both positions of one may be none at all. Of two parts of the frames that do
not touch, one is without the moment of the move, and gives cameras to look at all frames with (`camera_step`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...data import Detections, KinemarkError, Rig
from ...data.array_types import Bools, Ints
from ...data.detections import Validity
from ...numerics.later_frames import in_later_frames
from ..bundle import BundleFit
from ..bundle.camera_step import CameraStep
from ..bundle.one_side import from_one_side, uncertain
from .delays import delays_between
from .film_delays import InTime
from .identify import at_rows

HALVES, THIRDS = ((0.0, 0.45), (0.55, 1.0)), ((0.0, 0.32), (0.34, 0.66), (0.68, 1.0))
"""From and to which share of the frames; chosen: one change is in one half at most, and two are not in all thirds."""


def rigs_of_parts(
    detections: Detections,
    rows: Ints,
    first_rig: Callable[[Ints], Rig],
    parts: Sequence[tuple[float, float]] = HALVES,
) -> Iterator[Rig]:
    """Cameras from parts of rows (C, F, K), where these are calibrations.

    One that lost images before is late in a part by as many.
    """
    share = np.arange(rows.shape[1]) / rows.shape[1]
    for first, stop in parts:
        own = np.where(((share >= first) & (share < stop))[:, None], rows, -1)
        late = delays_between(at_rows(detections, own)[0])
        try:
            yield first_rig(own if late is None else _later(own, np.rint(late).astype(np.int64)))
        except KinemarkError:  # this part is no calibration either
            continue


def _later(rows: Ints, late: Ints) -> Ints:
    """Rows (C, F, K) of image f − late (C) in frame f, −1 where there is none."""
    return np.stack([in_later_frames(own, n, missing=-1) for own, n in zip(rows, late.tolist(), strict=True)])


def since_step(step: CameraStep, detections: Detections, one_side: Callable[[Detections], InTime]) -> BundleFit | None:
    """The fit of `one_side` of a move, which the rig's words name; None where neither side is a calibration."""

    def fitted(images: Bools) -> BundleFit:
        masked = ~images[detections.camera, detections.frame]
        validity = np.where(masked, np.uint8(Validity.MASKED), detections.validity)
        return one_side(replace(detections, validity=validity)).fit

    fit = from_one_side(step, detections.cameras, detections.n_frames, fitted)
    return fit and _said(fit, step)


def without_move(found: InTime, detections: Detections, one_side: Callable[[Detections], InTime]) -> BundleFit:
    """What was found where no camera was moved, else the fit of one side, or with the uncertainty of the move.

    A small delay of the camera may hide a move, and a late camera look like a moved one: then the images after the move
    tell, by whether they need a delay.
    """
    fit, step = found.fit, found.fit.step or found.step
    if step is None:
        return fit
    moved = since_step(step, detections, one_side)
    if fit.step:
        return moved or _said(uncertain(fit, step), step)
    sure = moved is not None and moved.step is not None and moved.step.kept == "after" and not moved.delay.any()
    return moved if moved and sure else fit


def _said(fit: BundleFit, step: CameraStep) -> BundleFit:
    """The fit of a rig whose words name the move."""
    return fit._replace(rig=replace(fit.rig, method=f"{fit.rig.method}; {step_words(step)}"))


def step_words(step: CameraStep) -> str:
    """What was found, for an error and `Rig.method`; frames are counted from 1 in words."""
    since = f"from about frame {step.frame + 1} on"
    if not step.alone:
        return f"The cameras do not fit each other as before {since}: one of them was moved, by {step.px:.1f} px or so."
    return f"Camera {step.camera} was probably moved: {since} its images lie {step.px:.1f} px beside."
