"""Why a wand's cameras fit nothing: one was moved meanwhile, as cameras of the first part, or of the last, tell.

Cameras of all frames that had to please both positions of one may be none at all. Of two parts of the frames that do
not touch, one is without the moment of the move, and gives cameras to look at all frames with (`camera_step`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...data import Detections, KinemarkError, Rig
from ...data.array_types import Ints
from ..bundle.camera_step import CameraStep, camera_step
from .identify import at_rows

PART = 0.45
"""Of the frames, at the beginning and at the end; chosen: a move is in one of them at most."""


def step_of_part(detections: Detections, rows: Ints, few: Ints, first_rig: Callable[[Ints], Rig]) -> CameraStep | None:
    """The move of one of a few cameras by their rig from a part of rows (C, F, K); None where no part shows one."""
    n = rows.shape[1]
    uv = at_rows(detections, rows[few])[0]
    for part in (np.arange(n) < PART * n, np.arange(n) >= (1 - PART) * n):
        try:
            rig = first_rig(np.where(part[:, None], rows, -1))
        except KinemarkError:  # this part is no calibration either
            continue
        if (step := camera_step(rig, uv)) is not None:
            return step
    return None


def step_words(step: CameraStep) -> str:
    """What was found, for an error and `Rig.method`; frames are counted from 1 in words."""
    since = f"from about frame {step.frame + 1} on"
    if not step.alone:
        return f"The cameras do not fit each other as before {since}: one of them was moved, by {step.px:.1f} px or so."
    return f"Camera {step.camera} was probably moved: {since} its images lie {step.px:.1f} px beside."
