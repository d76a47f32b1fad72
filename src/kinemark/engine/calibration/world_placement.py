"""The world of cameras that know none: an L-frame on the floor, control points, or a known distance for the scale."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...calibrate.bundle import BundleFit
from ...calibrate.l_frame import RestingLFrame, resting_l_frame
from ...calibrate.quality import Check, WorldPose, world_pose
from ...calibrate.quality.calibration_evidence import residual_deviation
from ...calibrate.world_frame import fit_moved_to, fit_scaled
from ...data import Detections, Finding, KinemarkError, Rig, make_finding
from ...data.array_types import Floats
from ...geometry import triangulate, undistort
from ...match import EpipolarTriplets, match
from ...reconstruct import LeastSquares, reconstruct
from ..settings import Distance, LFrame
from .from_known_points import digitised
from .task import Task

TOLERANCE = 0.05
"""How far an L-frame's distances may be from what they should be, as a share of the longest; smaller ones are said.
Chosen."""


class PlacedRig(NamedTuple):
    """A fit in the world that was wanted; checks of lengths that took no part; findings; how well the room is known."""

    fit: BundleFit
    checks: tuple[Check, ...] = ()
    findings: tuple[Finding, ...] = ()
    world: WorldPose | None = None


def placed_in_world(task: Task, fit: BundleFit, *, unscaled: bool) -> PlacedRig:
    """The fit where the session's `l_frame`, `world_points` or `distance` put it.

    Raises:
        KinemarkError: these are not seen, or the control volume is given in a world that is not.
    """
    calibration = task.settings.calibration
    findings: tuple[Finding, ...] = ()
    distance = calibration.single_marker.distance if calibration.single_marker else None
    if distance is not None:
        fit, unscaled = fit_scaled(fit, distance.mm / _apart(task, fit.rig, distance)), False
    frames = 1
    if calibration.l_frame:
        frame = _l_frame(task, fit.rig, calibration.l_frame, unscaled)
        what, seen, known = "The long arm of the L-frame", frame.seen, frame.known
        findings, frames = _moved(frame), frame.frames - frame.moved
    elif calibration.world_points:
        what, seen, known = _world_points(task, fit.rig)
    elif task.settings.volume_mm is not None:
        raise KinemarkError(
            "volume_mm is in the laboratory's frame, and a wand or marker knows none. Give l_frame or world_points in "
            "[calibration], or remove volume_mm."
        )
    else:
        return PlacedRig(fit, findings=(make_finding("world_of_first_camera"),))
    checks = () if unscaled else _checks(what, seen, known)
    fit = fit_moved_to(fit, seen, known, scale=unscaled)
    sd = residual_deviation(fit.residual[fit.kept], fit.freedom)
    world = world_pose(fit.rig, fit.joint, known, centroid_sd=sd, frames=frames, grows=unscaled)
    return PlacedRig(fit, checks, findings, world)


def _moved(frame: RestingLFrame) -> tuple[Finding, ...]:
    """Says in how many frames the L-frame did not rest."""
    if not frame.moved:
        return ()
    return (make_finding("l_frame_moved", frame_count=frame.moved, read_frames=frame.frames, off_mm=frame.off),)


def _apart(task: Task, rig: Rig, way: Distance) -> float:
    """The distance of two markers by a rig without scale: the median over the frames that show just two."""
    frames = _markers(task.recorded(way, "distance").detections, rig)
    apart = [float(np.linalg.norm(xyz[1] - xyz[0])) for xyz in frames if len(xyz) == 2]
    if not apart:
        most = max(map(len, frames), default=0)
        raise KinemarkError(
            f"No frame of the recording of the known distance shows two markers that two cameras see; the fullest one "
            f"shows {most}. Mask reflections, see [masks]."
        )
    return float(np.median(apart))


def _l_frame(task: Task, rig: Rig, way: LFrame, unscaled: bool) -> RestingLFrame:
    """The L-frame's markers as found and as known."""
    frames = _markers(task.recorded(way, "world").detections, rig)
    try:
        return resting_l_frame(
            rig, frames, long=max(way.arms_mm), short=min(way.arms_mm), height=way.height_mm, scale=unscaled,
            tolerance=TOLERANCE,
        )  # fmt: skip
    except KinemarkError as error:
        raise KinemarkError(f"The L-frame of [calibration] is not recognised. {error}") from error


def _world_points(task: Task, rig: Rig) -> tuple[str, Floats, Floats]:
    """Control points in words, where the rig sees them and where they are, (M, 3) mm."""
    way = task.settings.calibration.world_points
    assert way is not None
    points = digitised(task, way)
    ideal = np.stack([undistort(camera, points.uv[c]) for c, camera in enumerate(rig)], 1)
    seen = triangulate(ideal, rig.P)
    good = np.asarray(np.isfinite(seen).all(1))
    if good.sum() < 3:
        raise KinemarkError(f"{good.sum()} of the world's points are seen by two cameras, and three are needed.")
    apart = np.linalg.norm(points.xyz - points.xyz[good][0], axis=1)
    first, last = int(good.argmax()), int(np.where(good, apart, -1.0).argmax())
    return f"From {points.names[first]} to {points.names[last]}", seen[good], points.xyz[good]


def _checks(what: str, seen: Floats, known: Floats) -> tuple[Check, ...]:
    """The longest distance from the first point, as measured in the laboratory and as the rig has it."""
    apart = np.linalg.norm(known - known[0], axis=1)
    n = int(apart.argmax())
    return (Check(what, float(apart[n]), float(np.linalg.norm(seen[n] - seen[0]))),)


def _markers(detections: Detections, rig: Rig) -> list[Floats]:
    """The markers (n, 3) of every frame, as far as two cameras see them."""
    matches = match(detections, rig, method=EpipolarTriplets(pairs="best"))
    cloud = reconstruct(matches, detections, rig, method=LeastSquares(within_volume=False))
    return [np.asarray(cloud[f]) for f in range(cloud.n_frames)]
