"""What a camera will measure of markers: in its image, large enough, not behind a limb, and apart from others.

A marker of diameter D at the distance r is an image of f D / r px (1). Two images whose centres are nearer than the
mean of their diameters run together (2), and neither counts: a detector that separates them is a gain on top. A marker
counts when at least half of it is free of limbs, as in `synth.observe`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..calibrate.quality import visible
from ..data import Camera, Rig
from ..data.array_types import Bools, Floats
from ..geometry import project
from ..synth import Subject
from ..synth.occlusion import visible_fraction

LEAST_FREE = 0.5
"""Share of a marker that limbs must leave in sight; chosen, as in `synth.observe`."""


def image_diameter(camera: Camera, xyz: Floats, diameter_mm: float) -> Floats:
    """(…) px by (1) of markers at (…, 3) mm."""
    focal = float(np.sqrt(abs(camera.K[0, 0] * camera.K[1, 1])))
    return focal * diameter_mm / np.linalg.norm(xyz - camera.centre, axis=-1)


def seen_alone(camera: Camera, xyz: Floats, *, diameter_mm: float, least_px: float) -> Bools:
    """(N) whether a single marker at each place (N, 3) mm is in the image and large enough; false for NaN."""
    there = np.isfinite(xyz).all(1)
    seen = np.zeros(len(xyz), np.bool_)
    seen[there] = visible(Rig((camera,)), xyz[there])[0]
    large: Bools = image_diameter(camera, xyz, diameter_mm) >= least_px
    return seen & large


def free_of_limbs(centre: Floats, subject: Subject) -> Bools:
    """(M, F) whether limbs leave enough of each marker in sight of a camera at (3) mm, wherever it aims."""
    limbs = subject.capsules
    with np.errstate(invalid="ignore"):
        free = visible_fraction(centre, subject.xyz, subject.radius_mm, limbs.a, limbs.b, limbs.radius)
        return np.asarray(free >= LEAST_FREE)


def run_together(uv: Floats, across: Floats) -> Bools:
    """(M, F) by (2), of images at (M, F, 2) px, NaN where there is none, of diameters (M, F) px."""
    with np.errstate(invalid="ignore"):
        apart = np.linalg.norm(uv[:, None] - uv, axis=-1)
        near = apart < (across[:, None] + across) / 2
    near[np.arange(len(uv)), np.arange(len(uv))] = False
    return np.asarray(near.any(1))


def seen_on_body(camera: Camera, subject: Subject, free: Bools, *, least_px: float) -> Bools:
    """(M, F) which markers of a subject a camera measures, `free` (M, F) being those that no limb hides from it."""
    flat, diameter = subject.xyz.reshape(-1, 3), 2 * float(subject.radius_mm[0])
    seen = free & seen_alone(camera, flat, diameter_mm=diameter, least_px=least_px).reshape(free.shape)
    uv = np.where(seen[..., None], project(camera, subject.xyz), np.nan)
    return np.asarray(seen & ~run_together(uv, image_diameter(camera, subject.xyz, diameter)))


def seen_on_bodies(camera: Camera, bodies: Sequence[Subject], free: Sequence[Bools], *, least_px: float) -> Bools:
    """(N) the same of several subjects, one after the other."""
    each = [seen_on_body(camera, body, own, least_px=least_px).ravel() for body, own in zip(bodies, free, strict=True)]
    return np.concatenate([*each, np.zeros(0, np.bool_)])
