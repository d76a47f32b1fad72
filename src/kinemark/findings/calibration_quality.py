"""How good a calibration is, as plain data: the figures of calibration.json, of its page and of its verdict."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..calibrate.quality import (
    Change,
    Evidence,
    ImageCoverage,
    VolumeMap,
    block_diagonal,
    centroid_deviation,
    image_coverage,
    map_volume,
    points_of,
    view_volume,
)
from ..data import Camera, Rig
from ..data.array_types import Floats
from ..geometry.camera import pixels
from ..geometry.lens import distort
from ..version import __version__
from .calibration_findings import calibration_findings
from .calibration_verdict import calibration_verdict
from .cameras import upwards
from .plain import SCHEMA_VERSION, mean, plain, quantile, rms, share

CELLS = 3
"""Of the volume along each axis, in which the wand's length is judged."""
MANY = 20
"""Points from which the box around them is a volume."""
MOST_POINTS = 500
"""Points that are listed one by one."""


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
    places = points_of(grid.axes)
    covers = [image_coverage(camera, _used(evidence, c), places) for c, camera in enumerate(rig)]
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
            "fit": _fit(rig, evidence),
            "cameras": [_camera(rig, c, evidence, grid, covers[c]) for c in range(len(rig))],
            "points": _points(rig, evidence) if evidence.surveyed else [],
            "wand": _wand(evidence, volume),
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
    fit, precision = figures["fit"], figures["precision"]
    few = {
        "verdict": figures["verdict"]["grade"],
        "residual_rms_px": fit["residual_rms_px"],
        "left_out_rms_px": fit["left_out_rms_px"],
        "centroid_sd_px": precision["centroid_sd_px"],
        "sd_per_axis_median_mm": precision["sd_median_mm"],
        "sd_per_axis_95_mm": precision["sd_95_mm"],
    }
    return {key: value for key, value in few.items() if value is not None}


def _used(evidence: Evidence, c: int) -> Floats:
    """(N, 2) px of the points that camera c rests on; NaN for the others."""
    if not len(evidence.uv):
        return np.zeros((0, 2))
    return np.where(evidence.kept[c][:, None], evidence.uv[c], np.nan)


def _precision(grid: VolumeMap, sd: float, rig: Rig, evidence: Evidence) -> dict[str, Any]:
    joint = block_diagonal(rig) if evidence.joint is None else evidence.joint
    return {
        "centroid_sd_px": sd,
        "calibration_known": bool(joint.any()),
        "sd_median_mm": _over_all(grid.sd, 0.5),
        "sd_95_mm": _over_all(grid.sd, 0.95),
        "worst_direction_95_mm": _over_all(grid.worst, 0.95),
        "fewer_than_2_cameras_share": share((grid.seen < 2).sum(), grid.seen.size),
        "fewer_than_3_cameras_share": share((grid.seen < 3).sum(), grid.seen.size),
        "angle_median_deg": quantile(grid.angle, 0.5),
        "angle_below_20_deg_share": share((grid.angle < 20).sum(), grid.angle.size),
    }


def _over_all(values: Floats, at: float) -> float:
    """Quantile over all places, those that are not seen being infinitely wrong; NaN where it falls on one of them."""
    return float(np.quantile(np.where(np.isnan(values), np.inf, values), at, method="higher"))


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
        "left_out_worst_mm": quantile(evidence.left_out_mm, 1.0),
    }


def _camera(rig: Rig, c: int, evidence: Evidence, grid: VolumeMap, cover: ImageCoverage) -> dict[str, Any]:
    camera = rig[c]
    known = bool((camera.size > 0).all())
    return {
        "name": camera.name,
        "size_px": camera.size if known else None,
        "position_mm": camera.centre,
        "focal_px": [abs(camera.K[0, 0]), abs(camera.K[1, 1])],
        "focal_sd_px": float(np.sqrt(camera.cov[0, 0])) if camera.cov[0, 0] > 0 else None,
        "principal_point_px": camera.K[:2, 2],
        "distortion": camera.distortion,
        "lens_fitted": bool(camera.cov.diagonal()[4:9].any()),
        **_camera_fit(camera, c, evidence),
        "image_share": cover.image_share,
        "volume_share": cover.volume_share if cover.points else None,
        "hull_px": cover.hull,
        "aim_u_px": cover.u,
        "aim_v_px": cover.v,
        "aim_px": cover.aim,
        "aim_middle_px": cover.aim[cover.aim.shape[0] // 2, cover.aim.shape[1] // 2],
        "aim_corner_px": np.max(cover.aim[[0, 0, -1, -1], [0, -1, 0, -1]]),
        "aim_volume_worst_px": quantile(cover.aim_volume, 1.0),
        "bend": _bend(camera),
        "without": _without(grid, c),
    }


def _camera_fit(camera: Camera, c: int, evidence: Evidence) -> dict[str, Any]:
    if not len(evidence.uv):
        keys = ("points", "points_left_out", "left_out_rms_px")
        return {"residual_rms_px": camera.residual, **dict.fromkeys(keys)}
    seen, kept = np.isfinite(evidence.uv[c, :, 0]), evidence.kept[c]
    return {
        "residual_rms_px": rms(np.linalg.norm(evidence.residual[c][kept], axis=-1)),
        "points": int(kept.sum()),
        "points_left_out": int((seen & ~kept).sum()),
        "left_out_rms_px": rms(evidence.left_out[c][kept]) if evidence.left_out.size else None,
    }


def _without(grid: VolumeMap, c: int) -> dict[str, Any]:
    """What remains of the volume when a camera is lost."""
    lost = grid.without[c]
    both = np.isfinite(lost) & np.isfinite(grid.sd)
    unseen = np.isnan(lost) & np.isfinite(grid.sd)
    return {
        "sd_median_mm": _over_all(lost, 0.5),
        "sd_95_mm": _over_all(lost, 0.95),
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


def _points(rig: Rig, evidence: Evidence) -> list[dict[str, Any]]:
    """The control points, the worst first."""
    off = np.linalg.norm(evidence.residual, axis=-1)
    out = evidence.left_out if evidence.left_out.size else np.full(off.shape, np.nan)
    rows = [_point(rig, evidence, off[:, n], out[:, n], n) for n in range(len(evidence.names))]
    return sorted(rows, key=lambda row: -np.nan_to_num(row["left_out_rms_px"], nan=row["residual_rms_px"]))[
        :MOST_POINTS
    ]


def _point(rig: Rig, evidence: Evidence, off: Floats, out: Floats, n: int) -> dict[str, Any]:
    known = np.isfinite(off)
    worst = int(np.nan_to_num(off, nan=-1.0).argmax())
    return {
        "name": evidence.names[n],
        "xyz_mm": evidence.xyz[n],
        "cameras": int(known.sum()),
        "residual_rms_px": rms(off),
        "worst_camera": rig.names[worst] if known.any() else None,
        "worst_px": off[worst],
        "left_out_rms_px": rms(out),
        "left_out_mm": evidence.left_out_mm[n] if len(evidence.left_out_mm) else None,
        "not_used_by": [name for c, name in enumerate(rig.names) if known[c] and not evidence.kept[c, n]],
    }


def _wand(evidence: Evidence, volume: Floats) -> dict[str, Any] | None:
    """The wand's lengths as poses that took no part give them, over all and by place."""
    if not len(evidence.known):
        return None
    off = evidence.lengths - evidence.known
    return {
        "known_mm": evidence.known,
        "poses": int(np.isfinite(off).any(1).sum()),
        **_length_errors(off),
        "by_place": _by_place(off, evidence.place, volume),
        "samples": _samples(off, evidence.place),
    }


def _length_errors(off: Floats) -> dict[str, Any]:
    finite = off[np.isfinite(off)]
    return {
        "error_mean_mm": mean(off),
        "error_sd_mm": float(finite.std()) if len(finite) else None,
        "error_rms_mm": rms(off),
        "error_abs_mean_mm": mean(np.abs(off)),
        "error_95_mm": quantile(np.abs(off), 0.95),
    }


def _by_place(off: Floats, place: Floats, volume: Floats) -> list[dict[str, Any]]:
    """Mean and RMS error in each of 3 × 3 × 3 cells of the volume in which the wand was."""
    inside = (place - volume[0]) / (volume[1] - volume[0])
    known = np.isfinite(inside).all(1) & np.isfinite(off).any(1)
    cell = np.clip(np.floor(np.nan_to_num(inside) * CELLS), 0, CELLS - 1).astype(int)
    rows = []
    for index in np.unique(cell[known], axis=0):
        here = known & (cell == index).all(1)
        middle = volume[0] + (index + 0.5) / CELLS * (volume[1] - volume[0])
        rows.append({"middle_mm": middle, "poses": int(here.sum()), **_length_errors(off[here])})
    return rows


def _samples(off: Floats, place: Floats) -> dict[str, Any]:
    """At most so many poses, for the figure: where the wand was and the error of its whole length."""
    whole = off.sum(1)
    known = np.flatnonzero(np.isfinite(place).all(1) & np.isfinite(whole))
    known = known[:: max(1, -(-len(known) // MOST_POINTS))]
    return {"place_mm": place[known], "error_mm": whole[known]}


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
