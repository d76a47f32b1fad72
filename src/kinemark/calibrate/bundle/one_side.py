"""Cameras one of which was moved while they were calibrated, from what they saw on one side of the move.

Cameras that please all images settle between both positions of the one that was moved, and are off by more than they
state. What was recorded after the calibration was seen from where the camera then stood: so its images before the move
are left out (1). Where those after it are too few, the ones before are taken, and the camera's turn is uncertain by as
much as it was moved (2): its images lie beside by δ px, each axis of which has the variance δ² / 2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...data import PARAMETERS, Camera, KinemarkError, Rig
from ...data.array_types import Bools
from .adjust import BundleFit
from .camera_step import CameraStep

TURNS = [PARAMETERS.index(name) for name in ("ry", "rx")]
"""Which move an image along u and v; by definition."""


def from_one_side(
    step: CameraStep, names: Sequence[str], n_frames: int, again: Callable[[Bools], BundleFit]
) -> BundleFit | None:
    """The fit by (1) or (2), `again` from images (C, F) that are kept; None where neither side is a calibration."""
    for kept, images in step.parted(names, n_frames):
        try:
            found = again(images)
        except KinemarkError:  # too few, or what is wrong is another thing
            continue
        fit = found._replace(step=step._replace(kept=kept))
        return fit if kept == "after" and found.step is None else uncertain(fit, step)
    return None


def uncertain(fit: BundleFit, step: CameraStep) -> BundleFit:
    """The fit with the variance of (2) for the camera that was moved, or for each where nobody knows which."""
    cameras, joint, n = list[Camera](fit.rig.cameras), fit.joint.copy(), len(PARAMETERS)
    for c, camera in enumerate(fit.rig):
        if step.alone and camera.name != step.camera:
            continue
        more = np.zeros((n, n))
        more[TURNS, TURNS] = step.px**2 / 2 / np.diag(camera.K)[:2] ** 2
        own = slice(n * c, n * (c + 1))
        joint[own, own] += more
        cameras[c] = replace(camera, cov=camera.cov + more)
    return fit._replace(joint=joint, rig=Rig(tuple(cameras), fit.rig.method, fit.rig.volume))
