"""Where cameras that lie beside the others by a few pixels (`shifted_cameras`) are put right, or left out.

Their images are near enough to be associated, and take the points along: the others' noise does not say by how much. So
all is tracked again without them (`simultaneous_tracking`). Where the whole calibration is off, each camera lies beside
by something, and what one of them says of another is no better. So one that lies beside in the whole recording counts
if its images lie beside by

    d > CLEAR · max over the others of theirs                                              (1)

One that was knocked within the recording is put back to where it was before, and what the calibration is off by stays.
It counts if the median of its images less the places where they are expected changes with the knock by

    d > CHANGED · max over the others of theirs                                            (2)
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....data import Detections, Finding, Rig
from ..diagnosis.diagnostics import diagnose
from ..tracker import TrackingResult
from .shifted_cameras import Parts, least_shifts, parts_of_recording, shifted
from .unfitting_stretches import Stretch

CLEAR = 8.0
"""Of (1); chosen on scenes of the second generator: cameras that were knocked had 9 to 20 (481003, 482007, 491004,
492001 to 492003) and 80 to 240 (860002, 860003, 860013, files that are right), where points are nearer without them. In
files 0.3 to 0.5 px off they had 4.1 to 7.4 (860004, 860007, 860009), and fewer ellipsoids held their points."""

CHANGED = 2.0
"""Of (2); chosen on scenes 990000 to 990202 of the second generator: cameras that were knocked by 1.3 to 4.9 px had 2.5
to 1000, as one takes the others along. Without knocks none is called shifted since a frame (970000 to 970057)."""


def shifted_stretches(detections: Detections, rig: Rig, result: TrackingResult) -> dict[Stretch, Finding]:
    """Where cameras lie beside the others (`shifted_cameras` (1)), and what is to be said where they are left out."""
    n, found = detections.n_frames, dict[Stretch, Finding]()
    clear = _clear(rig, result)
    for one in diagnose(detections, rig, result) if clear else []:  # which knows what else it may be: a delay, say
        if one.kind == "camera_shifted" and not one.values["left_out"] and one.cameras[0] in clear:
            first = int(one.frames[0][0]) if one.frames else 0
            said = replace(one, values={**one.values, "left_out": True})
            found[Stretch(rig.names.index(one.cameras[0]), first, n)] = said
    return found


def _clear(rig: Rig, result: TrackingResult) -> set[str]:
    """Names of cameras that lie beside by far more than any other (1), or changed by more than any other (2)."""
    parts = [parts_of_recording(result, c) for c in range(len(rig))]
    least = least_shifts(result, parts)
    found = [(c, one) for c, name in enumerate(rig.names) for one in shifted(result, c, name, parts[c], least[c])]
    return {rig.names[c] for c, one in found if one.kind == "camera_shifted" and _stands_out(c, one, parts)}


def _stands_out(c: int, one: Finding, parts: list[Parts]) -> bool:
    """Whether camera c, which was called shifted, does so among the others by (1), or by (2) since some frame."""
    if one.frames:
        far, times = np.array([each.change(int(one.frames[0][0])) for each in parts]), CHANGED
    else:
        far, times = np.array([each.usual for each in parts]), CLEAR
    return bool(far[c] > times * np.fmax.reduce(np.delete(far, c), initial=0.0))
