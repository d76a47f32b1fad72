"""The tables and tiles of the calibration page."""

from __future__ import annotations

from typing import Any

from .formatting import count, measure, millimetres, number, percent
from .tables import Table, Tile


def calibration_tiles(figures: dict[str, Any]) -> list[Tile]:
    """The key figures."""
    fit, precision, wand = figures["fit"], figures["precision"], figures["wand"]
    left = measure(fit["left_out_rms_px"], 3, "px")
    cells = [
        Tile(millimetres(precision["sd_95_mm"]), "σ per axis in 95 % of the volume",
         f"half of it {millimetres(precision['sd_median_mm'])}"),
        Tile(measure(fit["residual_rms_px"], 3, "px"), "residual RMS", f"of {count(fit['images'], 'image')}"),
        Tile(left, "RMS on points left out", f"in space {millimetres(fit['left_out_rms_mm'])}"),
        Tile(percent(1 - precision["fewer_than_3_cameras_share"]), "seen by three cameras or more",
         f"by two {percent(1 - precision['fewer_than_2_cameras_share'])}"),
    ]  # fmt: skip
    if figures["room"]:
        room = figures["room"]
        cells.append(
            Tile(
                millimetres(room["sd_95_mm"]),
                "σ of the room per axis, common to all positions",
                f"half of the volume {millimetres(room['sd_median_mm'])}",
            )
        )
    if wand:
        error = millimetres(wand["error_abs_mean_mm"])
        cells[2] = Tile(error, "wand's length, mean error", f"{count(wand['poses'], 'pose')} left out")
    return cells


def fit_table(cameras: list[dict[str, Any]]) -> Table:
    """A row a camera: how it fits, and how its image is covered."""
    head = ["camera", "points", "not used", "residual (px)", "left out (px)", "image within points"]
    head += ["volume within points", "uncertain: centre (px)", "corner (px)"]
    return Table(head, [_fit(camera) for camera in cameras])


def _fit(camera: dict[str, Any]) -> list[str]:
    return [
        camera["name"],
        *(number(camera[key]) for key in ("points", "points_left_out")),
        *(number(camera[key], 3) for key in ("residual_rms_px", "left_out_rms_px")),
        *(percent(camera[key]) for key in ("image_share", "volume_share")),
        *(number(camera[key], 3) for key in ("aim_centre_px", "aim_corner_px")),
    ]


def lens_table(figures: dict[str, Any]) -> Table:
    """A row a camera: what it is."""
    straight = {row["name"]: row for row in figures["straightness"]}
    head = ["camera", "image (px)", "position x, y, z (mm)", "focal length x, y (px)", "± (px)", "principal point (px)"]
    head += ["k1", "k2", "p1", "p2", "k3", *(["rows bent before, after (px)"] if straight else [])]
    return Table(head, [_lens(camera, straight) for camera in figures["cameras"]])


def _lens(camera: dict[str, Any], straight: dict[str, dict[str, Any]]) -> list[str]:
    row = straight.get(camera["name"])
    bent = [f"{number(row['before_px'], 2)}, {number(row['after_px'], 3)}" if row else "–"] if straight else []
    return [
        camera["name"],
        " × ".join(map(str, camera["size_px"])) if camera["size_px"] else "–",
        ", ".join(number(x, 0) for x in camera["position_mm"]),
        ", ".join(number(x, 1) for x in camera["focal_px"]),
        number(camera["focal_sd_px"], 2),
        ", ".join(number(x, 1) for x in camera["principal_point_px"]),
        *(number(k, 4) if k else "–" for k in camera["distortion"]),
        *bent,
    ]


def loss_table(figures: dict[str, Any]) -> Table:
    """A row a camera: what remains without it; those on which much rests are tinted."""
    head = ["camera that is lost", "σ median (mm)", "σ in 95 % (mm)", "error: times as large", "no longer measured"]
    precision = figures["precision"]
    whole = ["none", number(precision["sd_median_mm"], 3), number(precision["sd_95_mm"], 3), "1", "–"]
    rows = [_loss(camera) for camera in figures["cameras"]]
    ratios = [camera["without"]["ratio_median"] or 0 for camera in figures["cameras"]]
    return Table(head, [whole, *rows], marked=[False, *(ratio > 2 for ratio in ratios)])


def _loss(camera: dict[str, Any]) -> list[str]:
    left = camera["without"]
    return [
        camera["name"],
        number(left["sd_median_mm"], 3),
        number(left["sd_95_mm"], 3),
        number(left["ratio_median"], 2),
        percent(left["newly_unseen_share"]),
    ]


def point_table(points: list[dict[str, Any]]) -> Table:
    """A row a control point, the largest residual first."""
    head = [
        "point",
        "x, y, z (mm)",
        "cameras",
        "residual RMS (px)",
        "largest residual (px)",
        "left out (px)",
        "left out (mm)",
    ]
    head += ["not used by"]
    rows = [
        [
            p["name"],
            ", ".join(number(x, 1) for x in p["xyz_mm"]),
            number(p["cameras"]),
            number(p["residual_rms_px"], 3),
            f"{p['max_camera'] or '–'} {number(p['max_px'], 3)}",
            number(p["left_out_rms_px"], 3),
            number(p["left_out_mm"], 2),
            ", ".join(p["not_used_by"]) or "–",
        ]
        for p in points
    ]
    return Table(head, rows, marked=[bool(p["not_used_by"]) for p in points], kept_in="calibration.json")


def place_table(wand: dict[str, Any] | None) -> Table:
    """A row a part of the volume: the wand's length there."""
    head = ["about x, y, z (mm)", "poses", "mean error (mm)", "SD (mm)", "95 % (mm)"]
    rows = [
        [
            ", ".join(number(x, 0) for x in cell["middle_mm"]),
            number(cell["poses"]),
            *(number(cell[key], 2) for key in ("error_mean_mm", "error_sd_mm", "error_95_mm")),
        ]
        for cell in (wand["by_place"] if wand else [])
    ]
    return Table(head, rows)


def change_table(change: dict[str, Any] | None) -> Table:
    """A row a camera: how it differs from the calibration before."""
    head = ["camera", "moved (mm)", "turned (°)", "focal length (%)", "image shifted (px)"]
    rows = [
        [
            c["name"],
            number(c["moved_mm"], 2),
            number(c["turned_deg"], 3),
            number(None if c["focal_share"] is None else 100 * c["focal_share"], 2),
            number(c["image_px"], 2),
        ]
        for c in (change["cameras"] if change else [])
    ]
    return Table(head, rows)
