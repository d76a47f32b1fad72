"""Cameras that lie beside the others by a few pixels, touched before the recording or within it, as tracks show them.

Their images are near enough to be associated, and take the points along: the others' noise does not say by how much. So
all is tracked again without them (`learned_delays`). Where the whole calibration is off, each camera lies beside by
something, and what one of them says of another is no better. So it counts where its images lie beside by

    d > CLEAR · max over the others of theirs                                              (1)
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...data import Detections, Finding, Rig
from .diagnostics import diagnose
from .shifted_cameras import PARTS, parts_of_recording
from .tracker import TrackingResult
from .unfitting_stretches import Stretch

CLEAR = 4.0
"""Of (1); chosen on scenes of the second generator: cameras that were knocked had 9 to 20 (481003, 482007, 491004,
492001 to 492003), those of files 1 px off that were called shifted 1.4 and 1.5 (493000, 493001)."""


def shifted_stretches(detections: Detections, rig: Rig, result: TrackingResult) -> dict[Stretch, Finding]:
    """Where cameras lie beside the others (`shifted_cameras` (1)), and what is to be said where they are left out.

    The part of the recording before the first that shows it may be the one in which the camera was moved.
    """
    n, found = detections.n_frames, dict[Stretch, Finding]()
    for one in diagnose(detections, rig, result):
        if one.kind == "camera_shifted" and not one.values["left_out"] and _is_clear(one, rig, result):
            first = max(int(one.frames[0][0]) - n // PARTS, 0) if one.frames else 0
            said = replace(one, values={**one.values, "left_out": True})
            found[Stretch(rig.names.index(one.cameras[0]), first, n)] = said
    return found


def _is_clear(one: Finding, rig: Rig, result: TrackingResult) -> bool:
    """Whether a camera lies beside by far more than any other (1)."""
    others = [parts_of_recording(result, c).usual for c, name in enumerate(rig.names) if name not in one.cameras]
    d = float(np.linalg.norm(np.array([one.values[f"offset_{axis}_px"] for axis in "uv"], np.float64)))
    return d > CLEAR * float(np.nanmax(others, initial=0.0))
