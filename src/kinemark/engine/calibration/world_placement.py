"""The world of cameras that know none: an L-frame on the floor, control points, or a known distance for the scale."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...calibrate.bundle import BundleFit
from ...calibrate.l_frame import RestingLFrame, resting_l_frame
from ...calibrate.quality import Check, WorldPose, world_pose
from ...calibrate.quality.calibration_evidence import residual_deviation
from ...calibrate.world_check import OddCamera, images_of_resting, odd_camera, seen_within, wrong_points
from ...calibrate.world_frame import fit_moved_to, fit_scaled, similarity
from ...data import Detections, Finding, KinemarkError, Rig, make_finding
from ...data.array_types import Floats
from ...data.finding import red_if
from ...geometry import triangulate, undistort
from ...match import EpipolarTriplets, match
from ...reconstruct import LeastSquares, reconstruct
from ..settings import Distance, LFrame
from .from_known_points import digitised
from .task import Task

TOLERANCE = 0.05
"""How far an L-frame's distances may be from what they should be, as a share of the longest; smaller ones are said.
Chosen."""
UPWARDS = 0.3
"""Cosine between the images' v and the room's Z from which a camera is upside down; chosen."""


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
        frame, findings = _l_frame(task, fit.rig, calibration.l_frame, unscaled)
        what, seen, known = "The long arm of the L-frame", frame.seen, frame.known
        frames = frame.frames - frame.moved
    elif calibration.world_points:
        what, seen, known, findings = _world_points(task, fit.rig, unscaled)
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


def _l_frame(task: Task, rig: Rig, way: LFrame, unscaled: bool) -> tuple[RestingLFrame, tuple[Finding, ...]]:
    """The L-frame's markers as found and as known, by the cameras that agree where it is."""
    seen = task.recorded(way, "world").detections
    frame = _resting(rig, seen, way, unscaled)
    odd = odd_camera(rig, images_of_resting(rig, seen, frame.seen))
    if odd is not None and odd.camera is not None:
        frame = _resting(rig, seen.keep(seen.camera != odd.camera), way, unscaled)
    from_file = way.detections is not None
    return frame, (*_moved(frame), *_odd(rig, odd), *(_upside_down(rig, frame) if from_file else ()))


def _upside_down(rig: Rig, frame: RestingLFrame) -> tuple[Finding, ...]:
    """Says that all cameras hang upside down above the L-frame: they do, or v is counted from the bottom."""
    A, _, _ = similarity(frame.seen, frame.known, scale=True)
    v_upwards = [float(camera.R[1] @ A[2]) for camera in rig]
    return (make_finding("cameras_upside_down"),) if min(v_upwards) > UPWARDS else ()


def _resting(rig: Rig, detections: Detections, way: LFrame, unscaled: bool) -> RestingLFrame:
    """The L-frame in a recording."""
    try:
        return resting_l_frame(
            rig, _markers(detections, rig), long=max(way.arms_mm), short=min(way.arms_mm), height=way.height_mm,
            scale=unscaled, tolerance=TOLERANCE,
        )  # fmt: skip
    except KinemarkError as error:
        raise KinemarkError(f"The L-frame of [calibration] is not recognised. {error}") from error


def _odd(rig: Rig, odd: OddCamera | None) -> tuple[Finding, ...]:
    """Says that cameras do not see what shows the world where the wand has put them."""
    if odd is None:
        return ()
    cameras = [] if odd.camera is None else [rig.names[odd.camera]]
    return (make_finding("world_seen_elsewhere", severity=red_if(not cameras), cameras=cameras, offset_px=odd.px),)


def _world_points(task: Task, rig: Rig, unscaled: bool) -> tuple[str, Floats, Floats, tuple[Finding, ...]]:
    """Control points in words, where the rig sees them and where they are, (M, 3) mm, without those that are wrong."""
    way = task.settings.calibration.world_points
    assert way is not None
    points = digitised(task, way)
    uv = points.uv.copy()
    odd = odd_camera(rig, uv)
    if odd is not None and odd.camera is not None:
        uv[odd.camera] = np.nan
    seen = triangulate(np.stack([undistort(camera, at) for camera, at in zip(rig, uv, strict=True)], 1), rig.P)
    good = np.flatnonzero(np.isfinite(seen).all(1))
    if len(good) < 3:
        raise KinemarkError(f"{len(good)} of the world's points are seen by two cameras, and three are needed.")
    within = seen_within(rig, seen[good], uv[:, good])
    checked = wrong_points(seen[good], points.xyz[good], scale=unscaled, within=within)
    findings = _odd(rig, odd)
    if checked.rms_mm > checked.limit_mm or not checked.kept.all():
        wrong = [points.names[i] for i in good[~checked.kept]]
        findings += (
            make_finding(
                "world_points_disagree",
                severity=red_if(checked.rms_mm > checked.limit_mm),
                points_list=wrong,
                off_mm=float(checked.off_mm.max()),
                rms_mm=checked.rms_mm,
            ),
        )
    good = good[checked.kept]
    last = int(np.linalg.norm(points.xyz[good] - points.xyz[good[0]], axis=1).argmax())
    what = f"From {points.names[good[0]]} to {points.names[good[last]]}"
    return what, seen[good], points.xyz[good], findings


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
