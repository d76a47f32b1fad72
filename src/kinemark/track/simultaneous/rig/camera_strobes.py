"""Images of the strobes of other cameras of the rig, which no tracker should take for a marker.

Cameras around a subject see each other, and the rings of light about the lenses are as bright as markers. Of two
cameras that see each other each image lies on the line through both, where all epipolar lines meet: any point between
the cameras fits both images, and they make a track that lasts as long as the recording. But the rig says where the
cameras are: an image is of a strobe where

    |u − project_c(C_k)| < f_c min(LIGHT_MM / Z, WIDE) + NEAR_PX                           (1)

with C_k the centre of another camera, and Z its depth, and where images are there from the beginning of the recording
to its end (`lasting_places`). Nothing is said of a camera of which more than MOST images stand: a marker of somebody
who stands still may be seen before another camera.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ....data import Camera, Detections, Finding, Rig, Validity, make_finding
from ....data.array_types import Floats, Ints
from ....geometry import project, to_camera
from ....numerics.lasting_places import lasting_places

LIGHT_MM = 100.0
"""From the centre of a camera to the middle of its light, at most: rings are around the lens, and housings hardly wider
than 200 mm; chosen."""

WIDE = 0.05
"""The same, of the distance between both cameras, where these stand nearer than 2 m, as about a hand; chosen."""

NEAR_PX = 2.0
"""Of one place: two centroids of noise 0.8 px lie within it four times in five; chosen."""

MOST = 0.5
"""Of the images of a camera, the share that stands at most where (1) is told; chosen, as in `standing_reflections`."""


class Strobe(NamedTuple):
    """The light of camera `of` in the images of camera `seen_by`, numbers, and its detections, rows (n)."""

    seen_by: int
    of: int
    rows: Ints


def camera_strobes(detections: Detections, rig: Rig) -> list[Strobe]:
    """The strobes that cameras of a rig see of each other; the rig's are those of the detections."""
    return [one for c in range(len(rig)) for one in _seen_by(c, detections, rig)]


def without_strobes(detections: Detections, rig: Rig) -> Detections:
    """The same, those of strobes of cameras not valid."""
    if not (found := camera_strobes(detections, rig)):
        return detections
    validity = detections.validity.copy()
    validity[np.concatenate([one.rows for one in found])] = Validity.MASKED
    return replace(detections, validity=validity)


def diagnose_strobes(detections: Detections, rig: Rig) -> list[Finding]:
    """Which cameras see the strobes of which others."""
    found = camera_strobes(detections, rig)
    seen_by = list(dict.fromkeys(rig.names[one.seen_by] for one in found))
    of = list(dict.fromkeys(rig.names[one.of] for one in found))
    return [make_finding("strobes_seen", cameras=seen_by, of_list=of)] if found else []


def _seen_by(c: int, detections: Detections, rig: Rig) -> Iterator[Strobe]:
    """The strobes in the images of camera c."""
    rows = int(detections.start[c, 0]) + np.flatnonzero(detections.valid[slice(*detections.start[c, [0, -1]])])
    near = [(k, *_place(rig[c], other)) for k, other in enumerate(rig) if k != c]
    uv, frame = detections.uv[rows], detections.frame[rows]
    if not any((np.linalg.norm(uv - place, axis=1) < reach).any() for _, place, reach in near):
        return
    spots = uv[lasting_places(uv, frame, detections.n_frames, NEAR_PX)]
    if not len(spots):
        return
    stands = np.asarray(cKDTree(spots).query(uv)[0]) < NEAR_PX
    if stands.mean() > MOST:
        return
    for k, place, reach in near:
        own = rows[stands & (np.linalg.norm(uv - place, axis=1) < reach)]
        if len(own):
            yield Strobe(c, k, own)


def _place(camera: Camera, other: Camera) -> tuple[Floats, float]:
    """Where a camera sees another, px (2), NaN where it does not, and how far beside its light may be, px: (1)."""
    depth = float(to_camera(camera, other.centre)[2])
    wide = min(LIGHT_MM / depth, WIDE) if depth > 0 else WIDE
    return project(camera, other.centre), float(abs(camera.K[0, 0])) * wide + NEAR_PX
