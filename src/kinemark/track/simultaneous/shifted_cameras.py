"""Cameras that lie beside the others by a few pixels, touched before the recording or within it, as tracks show them.

Their images are near enough to be associated, and take the points along: the others' noise does not say by how much. So
all is tracked again without them (`learned_delays`).
"""

from __future__ import annotations

from dataclasses import replace

from ...data import Detections, Finding, Rig
from .diagnostics import PARTS, diagnose
from .tracker import TrackingResult
from .unfitting_stretches import Stretch


def shifted_stretches(detections: Detections, rig: Rig, result: TrackingResult) -> dict[Stretch, Finding]:
    """Where cameras lie beside the others (`diagnostics` (1)), and what is to be said where they are left out.

    The part of the recording before the first that shows it may be the one in which the camera was moved.
    """
    n, found = detections.n_frames, dict[Stretch, Finding]()
    for one in diagnose(detections, rig, result):
        if one.kind == "camera_shifted" and not one.values["left_out"]:
            first = max(int(one.frames[0][0]) - n // PARTS, 0) if one.frames else 0
            said = replace(one, values={**one.values, "left_out": True})
            found[Stretch(rig.names.index(one.cameras[0]), first, n)] = said
    return found
