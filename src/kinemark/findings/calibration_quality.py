"""How good a calibration is, as plain data: the figures of calibration.json, of its page and of its verdict."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..calibrate.quality import (
    Change,
    Evidence,
    VolumeMap,
    centroid_deviation,
    joint_of,
    map_volume,
    view_volume,
)
from ..data import Rig
from ..data.array_types import Floats
from ..version import __version__
from .calibration_cameras import calibrated_camera
from .calibration_findings import calibration_findings
from .calibration_points import control_point_figures, wand_figures
from .calibration_verdict import calibration_verdict
from .cameras import upwards
from .plain import SCHEMA_VERSION, over_volume, plain, quantile, rms, share
from .room import room_figures

MANY = 20
"""Points from which the box around them is a volume; chosen (see studies/calibration_quality.py)."""


def calibration_figures(
    rig: Rig, evidence: Evidence, *, session: str = "", change: Change | None = None, since: str = ""
) -> dict[str, Any]:
    """All figures of a calibration as JSON-able data, units in the names of the keys, None where unknown.

    Args:
        rig: the calibrated cameras, at least two.
        evidence: what they were made from.
        session: its name.
        change: how they differ from those before, which were kept as `since`.

    Raises:
        KinemarkError: the control volume is empty, or no two cameras look at a common place.
    """
    given = bool(np.isfinite(rig.volume).all())
    volume = judged_volume(rig, evidence)
    sd = centroid_deviation(rig, evidence)
    grid = map_volume(rig, volume, centroid_sd=sd, joint=evidence.joint)
    figures: dict[str, Any] = plain(
        {
            "kinemark": __version__,
            "schema_version": SCHEMA_VERSION,
            "session": session,
            "way": evidence.way,
            "method": rig.method,
            "surveyed": evidence.surveyed,
            "volume": {"corners_mm": volume, "given": given},
            "precision": _precision(grid, sd, rig, evidence),
            "room": room_figures(evidence.world, volume),
            "fit": _fit(rig, evidence),
            "cameras": [calibrated_camera(rig, c, evidence, grid) for c in range(len(rig))],
            "points": control_point_figures(rig, evidence) if evidence.surveyed else [],
            "wand": wand_figures(evidence, volume),
            "checks": [_check(*check) for check in evidence.checks],
            "straightness": [{"name": n, "before_px": a, "after_px": b} for n, a, b in evidence.straight],
            "change": _change(change, since),
            "judged": _judgement(evidence),
            "map": _map(grid, upwards(rig)),
        }
    )
    findings = calibration_findings(figures, evidence.findings)
    figures["findings"] = [found.as_dict() for found in findings]
    figures["verdict"] = calibration_verdict(figures, findings).as_dict()
    return figures


def _judgement(evidence: Evidence) -> dict[str, Any] | None:
    if evidence.judged is None:
        return None
    return {
        "grade": evidence.judged.grade,
        "findings": [found.as_dict() for found in evidence.judged.findings],
    }


def judged_volume(rig: Rig, evidence: Evidence) -> Floats:
    """(2, 3) mm the control volume; where none is given, the box of what was waved about, or what the cameras look at.

    Raises:
        KinemarkError: no two cameras look at a common place.
    """
    if np.isfinite(rig.volume).all():
        return rig.volume
    known = evidence.xyz[np.isfinite(evidence.xyz).all(1)]
    if len(known) < MANY:
        return view_volume(rig)
    box = np.quantile(known, [0.01, 0.99], axis=0)
    return np.asarray(box if (box[1] > box[0]).all() else view_volume(rig))


def headline_figures(figures: Mapping[str, Any]) -> dict[str, Any]:
    """The few figures that go into the `[metadata]` of rig.toml, where other programs may read them."""
    fit, precision, room = figures["fit"], figures["precision"], figures["room"]
    few = {
        "verdict": figures["verdict"]["grade"],
        "residual_rms_px": fit["residual_rms_px"],
        "left_out_rms_px": fit["left_out_rms_px"],
        "centroid_sd_px": precision["centroid_sd_px"],
        "sd_per_axis_median_mm": precision["sd_median_mm"],
        "sd_per_axis_95_mm": precision["sd_95_mm"],
        "room_sd_per_axis_95_mm": room and room["sd_95_mm"],
    }
    return {key: value for key, value in few.items() if value is not None}


def _precision(grid: VolumeMap, sd: float, rig: Rig, evidence: Evidence) -> dict[str, Any]:
    joint = joint_of(rig) if evidence.joint is None else evidence.joint
    return {
        "centroid_sd_px": sd,
        "calibration_known": bool(joint.any()),
        "sd_median_mm": over_volume(grid.sd, 0.5),
        "sd_95_mm": over_volume(grid.sd, 0.95),
        "largest_axis_95_mm": over_volume(grid.sd_largest_axis, 0.95),
        "fewer_than_2_cameras_share": share((grid.seen < 2).sum(), grid.seen.size),
        "fewer_than_3_cameras_share": share((grid.seen < 3).sum(), grid.seen.size),
        "angle_median_deg": quantile(grid.angle, 0.5),
        "angle_below_20_deg_share": share((grid.angle < 20).sum(), grid.angle.size),
    }


def _fit(rig: Rig, evidence: Evidence) -> dict[str, Any]:
    residual = np.linalg.norm(evidence.residual, axis=-1)
    stated = np.array([camera.residual for camera in rig])
    observed = np.isfinite(evidence.uv[..., 0]) if len(evidence.uv) else np.zeros((0, 0), np.bool_)
    return {
        "points": int(observed.any(0).sum()),
        "images": int(observed.sum()),
        "images_left_out_share": share((observed & ~evidence.kept).sum(), observed.sum()),
        "residual_rms_px": rms(residual[evidence.kept]) if len(residual) else rms(stated),
        "left_out_rms_px": rms(evidence.left_out[evidence.kept]) if evidence.left_out.size else None,
        "left_out_rms_mm": rms(evidence.left_out_mm),
        "left_out_max_mm": quantile(evidence.left_out_mm, 1.0),
        "halves_ratio": quantile(evidence.halves, 1.0),
    }


def _check(what: str, known: float, found: float) -> dict[str, Any]:
    return {"what": what, "known_mm": known, "found_mm": found, "error_share": share(found - known, known)}


def _change(change: Change | None, since: str) -> dict[str, Any] | None:
    if change is None:
        return None
    columns = zip(change.names, change.moved, change.turned, change.focal, change.image, strict=True)
    keys = ("name", "moved_mm", "turned_deg", "focal_share", "image_px")
    return {
        "since": since,
        "world_moved_mm": change.world,
        "cameras": [dict(zip(keys, c, strict=True)) for c in columns],
    }


def _map(grid: VolumeMap, up: int) -> dict[str, Any]:
    """The places, and in the level cut through the middle what is left when a camera is lost."""
    x, y, z = grid.axes
    middle = len(grid.axes[up]) // 2
    return {
        "x_mm": x,
        "y_mm": y,
        "z_mm": z,
        "sd_mm": _short(grid.sd),
        "cameras": grid.seen,
        "angle_deg": _short(grid.angle),
        "lost": {
            "axis": up,
            "level_mm": grid.axes[up][middle],
            "sd_mm": _short(np.take(grid.sd, middle, axis=up)),
            "without_sd_mm": _short(np.take(grid.without, middle, axis=up + 1)),
        },
    }


def _short(values: Floats) -> NDArray[np.float64]:
    """Four digits are enough to draw."""
    with np.errstate(divide="ignore", invalid="ignore"):
        decimals = np.power(10.0, 3 - np.floor(np.log10(np.abs(values))))
        return np.where(np.isfinite(decimals), np.round(values * decimals) / decimals, values)
