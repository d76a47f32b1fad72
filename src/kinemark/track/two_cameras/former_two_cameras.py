"""The former two-camera method of the Kiss system (Shafiq, Tümer and Güler 2001, section 4).

Each camera is followed on its own, in its image (`image_paths`), and afterwards the paths of the two cameras are
brought together in space (`paired_paths`). Made for one side of the body, with both cameras placed so that they see all
markers at all times. What its authors found is what it does: it works for well separated markers, and with markers that
come and go it fails, since only those that are seen at the start are followed at all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...data import Cloud, Detections, KinemarkError, Rig, Tracks
from ...data.method import Method, parameter
from ...geometry import distort, refine, triangulate, undistort
from ...geometry.weighted_points import FALLBACK_SD
from ..stage import DETECTIONS, TRACK
from .image_paths import Paths, paths_of
from .paired_paths import Paired, paired, residuals, without_swaps


@dataclass(frozen=True, slots=True)
class FormerTwoCameras(Method):
    """Markers followed in each of two images, the paths then paired in space: KISS's former two-camera method.

    The paper names the window and the residual, but no values.
    """

    window: float = parameter(
        10.0, unit="px", above=0, meaning="half width of the association window (gate) about a prediction"
    )
    n_markers: int | None = parameter(
        None, former="markers", unit="markers", low=1,
        meaning="how many there are; following starts in fields that show so many; None: the most that a camera "
        "shows in two successive fields",
    )  # fmt: skip
    max_residual: float = parameter(
        2.0, former="residual_limit", unit="px", above=0,
        meaning="greatest residual of the fourth DLT equation in a field in which two paths are one marker",
    )  # fmt: skip
    min_fields: int = parameter(
        10,
        former="shortest",
        unit="fields",
        low=1,
        meaning="in how many fields two paths must be one marker to become a track",
    )


@TRACK.method(
    "former_two_cameras", FormerTwoCameras, source="Shafiq, Tümer and Güler 2001, section 4", takes=DETECTIONS
)
def track_two_cameras(detections: Detections, rig: Rig, *, method: FormerTwoCameras) -> Tracks:
    """Tracks of all markers that both cameras show at the start of the following; called through `track_detections`.

    A point whose image in one camera was filled by prediction has no detection there (−1), and its covariance says that
    the image is anywhere in the association window. Where both were filled there is no point.

    Raises:
        KinemarkError: not exactly two cameras, or no field shows the stated number of markers.
    """
    if len(rig) != 2 or detections.cameras != rig.names:
        raise KinemarkError(
            f"The former two-camera method takes two cameras, found {len(rig)} calibrated ({', '.join(rig.names)}) and "
            f"{len(detections.cameras)} in the recording. Choose two, as with detections.select([…]) and "
            'rig.select([…]), or another method, as "simultaneous".'
        )
    paths = [_camera_paths(detections, rig, c, method) for c in range(2)]
    limit, P = method.max_residual, rig.P
    one, other = without_swaps(paths[0], paths[1], P, limit=limit, window=method.window)
    pairs = paired(residuals(one.uv, other.uv, P), limit=limit, shortest=method.min_fields)
    return _tracks(detections, rig, one, other, pairs, method.window)


def _camera_paths(detections: Detections, rig: Rig, c: int, method: FormerTwoCameras) -> Paths:
    """The paths of one camera."""
    start = detections.start[c]
    uv = undistort(rig[c], detections.uv[start[0] : start[-1]])
    rows = np.arange(len(uv))
    rows = rows[detections.valid[start[0] : start[-1]] & np.isfinite(uv).all(1)]
    fields = np.split(rows, np.searchsorted(rows, start[1:-1] - start[0]))
    try:
        paths = paths_of(uv, fields, size=rig[c].size, window=method.window, markers=method.n_markers)
    except ValueError as error:
        raise KinemarkError(f"Camera {rig.names[c]} shows {error}") from error
    return Paths(paths.uv, np.where(paths.detection >= 0, paths.detection + start[0], -1))


def _tracks(detections: Detections, rig: Rig, one: Paths, other: Paths, pairs: Paired, window: float) -> Tracks:
    """The points of the pairs with their identities."""
    detection = np.stack([one.detection[pairs.one, pairs.frame], other.detection[pairs.other, pairs.frame]], 1)
    ideal = np.stack([one.uv[pairs.one, pairs.frame], other.uv[pairs.other, pairs.frame]], 1)
    seen = detection >= 0
    drawn = np.stack([distort(camera, ideal[:, c]) for c, camera in enumerate(rig)], 1)
    stated = np.where(np.isfinite(detections.cov), detections.cov, np.eye(2) * FALLBACK_SD**2)
    cov = np.where(seen[..., None, None], stated[detection] if len(stated) else 0.0, np.eye(2) * window**2 / 3)
    point = refine(rig, triangulate(ideal, rig.P), drawn, cov)
    cloud = Cloud(
        rate=detections.rate,
        start=np.searchsorted(pairs.frame, np.arange(detections.n_frames + 1)),
        xyz=point.xyz,
        cov=point.cov,
        residual=np.sqrt(np.nansum(point.residual**2, axis=(1, 2)) / 2),
        detection=detection,
    )
    good = np.asarray(seen.any(1) & np.isfinite(point.xyz).all(1) & np.isfinite(point.cov).all((1, 2)))
    return Tracks(cloud.keep(good), np.unique(pairs.id[good], return_inverse=True)[1])
