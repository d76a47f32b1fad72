"""A session's cameras on the screen: their calibration, and control balls that are pointed at."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...data import KinemarkError, Rig
from ...digitise import find_markers, threshold_of
from ...engine.calibration import EarlierCalibration, LastCalibration, earlier_calibrations, last_calibration
from ...engine.digitising.control_balls import REFERENCE, ControlBalls, snapped
from ...engine.session import Session
from ...engine.session_changes import change_session
from ...engine.settings import Settings
from ...findings.verdict import grade_shown
from ...geometry import to_dlt
from ...io.control_points import PointedPoints
from ...report.calibration_tables import (
    calibration_tiles,
    change_table,
    fit_table,
    lens_table,
    loss_table,
    place_table,
    point_table,
)
from ...report.formatting import measure
from ...report.tables import Table
from ...report.words.calibration_ways import NUMBERS, WAYS
from . import camera_messages as c
from .header import camera_row
from .shelf import Place


def session_cameras(key: str, folder: Path) -> c.SessionCameras:
    """A session's cameras; raises a KinemarkError where the session cannot be read."""
    session = Session.open(folder)
    settings, last = session.settings, last_calibration(folder, session.results, session.settings)
    return c.SessionCameras(
        id=key,
        title=settings.name,
        way=settings.calibration.way,
        way_words=WAYS[settings.calibration.way],
        names=list(last.rig.names if last and not settings.cameras.names else settings.cameras.names),
        numbers=stated_numbers(settings),
        control=_has_balls(folder, settings),
        calibration=None if last is None else shown(last),
        earlier=[] if last is None else [_earlier(one) for one in earlier_calibrations(session.results, last)],
        trials=[Place(folder, name).id for name in session.names],
    )


def shown(last: LastCalibration) -> c.CalibrationShown:
    """A calibration with the words, figures and tables of its page."""
    figures, rig = last.figures, last.rig
    verdict = figures["verdict"]
    return c.CalibrationShown(
        made=last.made.isoformat(sep=" ", timespec="minutes"),
        way=figures["way"],
        current=last.current,
        grade=grade_shown(verdict),
        headline=verdict["headline"],
        sentences=verdict["sentences"],
        findings=[finding(one) for one in figures["findings"]],
        tiles=[c.TileRow(**tile._asdict()) for tile in calibration_tiles(figures)],
        cameras=[camera_row(camera) for camera in rig],
        residual_px={one["name"]: one["residual_rms_px"] for one in figures["cameras"]},
        volume=figures["volume"]["corners_mm"],
        map=error_map(figures),
        tables=[one for one in _tables(figures, rig) if one.rows],
    )


def finding(one: dict[str, Any]) -> c.FindingRow:
    """A finding that has its words."""
    cameras = [str(name) for name in one["cameras"]]
    return c.FindingRow(severity=one["severity"], words=one["text"], advice=one["advice"], cameras=cameras)


def error_map(figures: dict[str, Any]) -> c.ErrorMap:
    """The map of the figures, flat."""
    found, names = figures["map"], [camera["name"] for camera in figures["cameras"]]
    lost = found["lost"]
    return c.ErrorMap(
        x=found["x_mm"],
        y=found["y_mm"],
        z=found["z_mm"],
        sd_mm=[sd for plane in found["sd_mm"] for row in plane for sd in row],
        axis=lost["axis"],
        level_mm=lost["level_mm"],
        lost={
            name: [sd for row in rows for sd in row] for name, rows in zip(names, lost["without_sd_mm"], strict=True)
        },
    )


def table(title: str, about: str, of: Table) -> c.TableRows:
    """A table of the report."""
    rows = [list(map(str, row)) for row in of.shown]
    return c.TableRows(
        title=title, about=about, head=list(of.head), rows=rows, marked=[of.is_marked(k) for k in range(len(rows))]
    )


def _tables(figures: dict[str, Any], rig: Rig) -> list[c.TableRows]:
    """Those of the calibration's page, and the parameters of UM²AS."""
    return [
        table("Residuals", "Left out: the same for points that the fit did not know, which counts.",
              fit_table(figures["cameras"])),
        table("When a camera is lost", "σ is the standard deviation per axis; tinted: much rests on it.",
              loss_table(figures)),
        table("Control points", "The largest residual first; tinted: not used by some camera.",
              point_table(figures["points"])),
        table("The wand by place", "Poses that took no part in the fit.", place_table(figures["wand"])),
        table("Lenses", "k1 k2 k3 and p1 p2 bend the image.", lens_table(figures)),
        table("L parameters", "The eleven of each camera, px and mm; lenses are not in them.", dlt_table(rig)),
    ]  # fmt: skip


def dlt_table(rig: Rig) -> Table:
    """The eleven parameters of each camera; no rows where the world's origin gives a camera none."""
    try:
        L = to_dlt(rig.P)
    except KinemarkError:
        return Table([], [])
    rows = [[camera.name, *(f"{value:.6g}" for value in row)] for camera, row in zip(rig, L.tolist(), strict=True)]
    return Table(["camera", *(f"L{k}" for k in range(1, 12))], rows)


def _earlier(one: EarlierCalibration) -> c.Earlier:
    change = one.change
    columns = zip(change.names, change.moved, change.turned, change.focal, change.image, strict=True)
    keys = ("name", "moved_mm", "turned_deg", "focal_share", "image_px")
    rows = change_table({"cameras": [dict(zip(keys, row, strict=True)) for row in columns]})
    about = f"Both worlds are laid on each other; the world as a whole moved by {measure(change.world, 1, 'mm')}."
    return c.Earlier(made=one.made, world_moved_mm=change.world, table=table(f"Since {one.made}", about, rows))


def _has_balls(folder: Path, settings: Settings) -> bool:
    """Whether there are control points to be pointed at."""
    try:
        return bool(ControlBalls.of(folder, settings).way.images)
    except KinemarkError:
        return False


def stated_numbers(settings: Settings) -> list[c.StatedNumbers]:
    """The numbers of `[calibration]` that its way has."""
    found = []
    for key, (words, least, most, optional) in NUMBERS.items():
        table: Any = settings.calibration
        *way, name = key.split(".")
        for part in way:
            table = None if table is None else getattr(table, part)
        if table is not None:
            value = getattr(table, name)
            values = [] if value is None else list(value) if isinstance(value, Sequence) else [value]
            found.append(
                c.StatedNumbers(key=key, words=words, least=least, most=most, values=values, optional=optional)
            )
    return found


def state_numbers(folder: Path, said: dict[str, list[float]]) -> None:
    """Write numbers into session.toml; raises a KinemarkError where they cannot be."""
    changes: dict[tuple[str, ...], Any] = {}
    known = {one.key: one for one in stated_numbers(Session.open(folder).settings)}
    for key, values in said.items():
        if key not in known:
            raise KinemarkError(f"This session's calibration has no number {key}.")
        one = known[key]
        if not (one.least <= len(values) <= one.most or (one.optional and not values)):
            raise KinemarkError(f"{one.words}: {len(values)} numbers are given, wanted {one.least} to {one.most}.")
        plain = [int(value) if value.is_integer() else value for value in values]
        single = one.most == 1
        changes["calibration", *key.split(".")] = None if not plain else plain[0] if single else plain
    change_session(folder, changes)


def balls_of(folder: Path) -> ControlBalls:
    """The control balls of a session; raises a KinemarkError where it has none."""
    return ControlBalls.of(folder, Session.open(folder).settings)


def control(balls: ControlBalls) -> c.Control:
    """The task as the page shows it."""
    points = balls.points
    places = [c.ControlPoint(name=name, xyz=xyz) for name, xyz in zip(points.names, points.xyz.tolist(), strict=True)]
    return c.Control(
        points=places,
        cameras=[_camera(balls, points, k) for k in range(len(points.cameras))],
        reference=REFERENCE,
        file=str(balls.way.points),
        reference_files=[path.name for path in balls.reference_files()],
    )


def white_pixels(balls: ControlBalls, camera: str, threshold: float | None, inverted: bool | None) -> c.WhitePixels:
    """What can be pointed at in a camera's image by a threshold; by the session's where none is given."""
    image, method = balls.image(camera), balls.method(camera, threshold, inverted)
    centroids = find_markers(image, method=method).uv.tolist()
    return c.WhitePixels(threshold=threshold_of(image, method), inverted=method.inverted, centroids=centroids)


def say(balls: ControlBalls, camera: str, body: c.BallBody) -> None:
    """What an operator says; raises a KinemarkError where nothing white is at the place, or there is no such ball."""
    if body.forget or not body.seen:
        balls.say(camera, body.point, None, asked=not body.forget)
    elif body.file is not None and body.point == REFERENCE:
        balls.say(camera, body.point, balls.reference_of_file(body.file))
    elif body.u is None or body.v is None or not np.isfinite([body.u, body.v]).all():
        raise KinemarkError("Say where the ball is, that it is not seen, or that the answer is taken back.")
    else:
        markers = balls.markers(camera, body.threshold, body.inverted)
        balls.say(camera, body.point, snapped(markers, body.u, body.v))


def set_threshold(folder: Path, body: c.ThresholdBody) -> None:
    """Write the threshold into session.toml; raises a KinemarkError where detection has none."""
    names = Session.open(folder).settings.cameras.names
    if body.camera is not None and body.camera not in names:
        raise KinemarkError(f"There is no camera {body.camera!r}. Look at the list again.")
    table = ("detect",) if body.camera is None else ("detect", "cameras", body.camera)
    change_session(folder, {(*table, "threshold"): body.threshold, (*table, "inverted"): body.inverted or None})


def _camera(balls: ControlBalls, points: PointedPoints, k: int) -> c.ControlCamera:
    name = points.cameras[k]
    width, height = balls.source(name).size
    method = balls.method(name)
    marks = (balls.settings.calibration.reference_marker or {}).get(name, ())
    reference = c.BallPlace(point=REFERENCE, u=marks[0][0], v=marks[0][1], seen=True) if marks else None
    return c.ControlCamera(
        name=name,
        width=width,
        height=height,
        threshold=method.threshold,
        inverted=method.inverted,
        balls=[_ball(points, k, n) for n in range(len(points.names))],
        reference=reference or c.BallPlace(point=REFERENCE),
    )


def _ball(points: PointedPoints, k: int, n: int) -> c.BallPlace:
    name, (u, v) = points.names[n], points.uv[k, n].tolist()
    if not points.asked[k, n]:
        return c.BallPlace(point=name)
    seen = bool(np.isfinite([u, v]).all())
    return c.BallPlace(point=name, u=u if seen else None, v=v if seen else None, seen=seen)
