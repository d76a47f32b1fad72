"""Control balls that are pointed at in a session's images."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...data import KinemarkError
from ...digitise import find_markers, threshold_of
from ...engine.digitising.control_balls import REFERENCE, ControlBalls, snapped
from ...engine.session import Session
from ...engine.session_changes import change_session
from ...io.control_points import PointedPoints
from . import camera_messages as c


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
