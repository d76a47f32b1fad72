"""The figures of each camera of a calibration."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..calibrate.quality import Evidence, VolumeMap, image_coverage, points_of
from ..calibrate.quality.lens_trend import lens_trend
from ..data import Camera, Rig
from ..data.array_types import Floats
from ..geometry.camera import pixels
from ..geometry.lens import distort
from .cameras import camera_description
from .plain import over_volume, quantile, rms, share

OUTSIDE_PX = 1.0
"""How far beyond an image's outermost pixels a centroid may be; chosen: spheres' are corrected by less."""


def calibrated_camera(rig: Rig, c: int, evidence: Evidence, grid: VolumeMap) -> dict[str, Any]:
    """The figures of camera c: what it is, how it fits, how its image is covered, and what is left without it."""
    camera = rig[c]
    cover = image_coverage(camera, _used(evidence, c), points_of(grid.axes))
    return camera_description(camera) | {
        "focal_sd_px": float(np.sqrt(camera.cov[0, 0])) if camera.cov[0, 0] > 0 else None,
        "principal_point_px": camera.K[:2, 2],
        "distortion": camera.distortion,
        "lens_fitted": bool(camera.cov.diagonal()[4:9].any()),
        **_camera_fit(camera, c, evidence),
        "image_share": cover.image_share if cover.points else None,
        "volume_share": cover.volume_share if cover.points else None,
        "hull_px": cover.hull,
        "aim_u_px": cover.u,
        "aim_v_px": cover.v,
        "aim_px": cover.aim,
        "aim_centre_px": cover.aim[cover.aim.shape[0] // 2, cover.aim.shape[1] // 2],
        "aim_corner_px": np.max(cover.aim[[0, 0, -1, -1], [0, -1, 0, -1]]),
        "folded_share": cover.folded,
        "aim_volume_max_px": quantile(cover.aim_volume, 1.0),
        "bend": _bend(camera),
        "mirrored": bool(camera.K[0, 0] * camera.K[1, 1] < 0),
        "v_upwards": float(np.sign(camera.K[1, 1]) * camera.R[1, 2]),
        "without": _without(grid, c),
        "lens_trend": _trend(camera, c, evidence),
    }


def _camera_fit(camera: Camera, c: int, evidence: Evidence) -> dict[str, Any]:
    if not len(evidence.uv):
        keys = ("points", "points_left_out", "points_outside_share", "left_out_rms_px")
        return {"residual_rms_px": camera.residual, **dict.fromkeys(keys)}
    seen, kept = np.isfinite(evidence.uv[c, :, 0]), evidence.kept[c]
    return {
        "residual_rms_px": rms(np.linalg.norm(evidence.residual[c][kept], axis=-1)),
        "points": int(kept.sum()),
        "points_left_out": int((seen & ~kept).sum()),
        "points_outside_share": _outside(camera, evidence.uv[c, seen]),
        "left_out_rms_px": rms(evidence.left_out[c][kept]) if evidence.left_out.size else None,
    }


def _outside(camera: Camera, uv: Floats) -> float:
    """Share of points (n, 2) px that no image of the camera's size can show; 0 where that is not known."""
    if not (camera.size > 0).all() or not len(uv):
        return 0.0
    return float(((uv < -OUTSIDE_PX) | (uv > camera.size - 1 + OUTSIDE_PX)).any(1).mean())


def _trend(camera: Camera, c: int, evidence: Evidence) -> dict[str, Any] | None:
    """How residuals go with the place in the image; None where too few tell."""
    if not len(evidence.uv):
        return None
    kept = np.where(evidence.kept[c][:, None], evidence.residual[c], np.nan)
    found = lens_trend(camera, evidence.xyz, kept)
    return None if found is None else {"rms_px": found.px, "of_noise": found.ratio, "terms": found.terms}


def _without(grid: VolumeMap, c: int) -> dict[str, Any]:
    """What remains of the volume when a camera is lost."""
    lost = grid.without[c]
    both = np.isfinite(lost) & np.isfinite(grid.sd)
    unseen = np.isnan(lost) & np.isfinite(grid.sd)
    return {
        "sd_median_mm": over_volume(lost, 0.5),
        "sd_95_mm": over_volume(lost, 0.95),
        "ratio_median": quantile(lost[both] / grid.sd[both], 0.5),
        "ratio_95": quantile(lost[both] / grid.sd[both], 0.95),
        "newly_unseen_share": share(unseen.sum(), grid.sd.size),
    }


def _bend(camera: Camera) -> dict[str, Any]:
    """How far the lens moves points along a ray from its centre to the farthest corner: px by px."""
    width, height = camera.size if (camera.size > 0).all() else 2 * np.abs(camera.K[:2, 2])
    corners = np.array([[0, 0], [width, 0], [0, height], [width, height]], float) - camera.K[:2, 2]
    far = corners[np.linalg.norm(corners, axis=1).argmax()] / np.diag(camera.K)[:2]
    along = np.linspace(0, 1, 25)[:, None] * far
    ideal, drawn = (pixels(camera, xy) - camera.K[:2, 2] for xy in (along, distort(along, camera.distortion)))
    return {
        "from_centre_px": np.linalg.norm(ideal, axis=1),
        "moved_px": np.linalg.norm(drawn, axis=1) - np.linalg.norm(ideal, axis=1),
    }


def _used(evidence: Evidence, c: int) -> Floats:
    """(N, 2) px of the points that camera c rests on; NaN for the others."""
    if not len(evidence.uv):
        return np.zeros((0, 2))
    return np.where(evidence.kept[c][:, None], evidence.uv[c], np.nan)
