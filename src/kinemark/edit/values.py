"""Edits of values: samples erased, put, smoothed, or solved again with another image.

Each takes a marker as the claims and the edits before left it, and gives it back with what became of the edit. Frames
of edits are numbers in the recording; frames within are from 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..data import Detections, MarkerTrajectory, Origin, Rig
from ..data.array_types import Floats
from ..data.edit_outcomes import Outcome
from ..data.edits import Erase, ImagePoint, Put, Smooth
from ..geometry import project, refine, triangulate, undistort
from ..numerics.runs import true_runs
from ..signal.filters import averaged_samples, butterworth, edge_samples, moving_average
from ..signal.woltring import woltring
from .votes import FEWEST

USUAL_SD = 0.3
"""px, of images that state no noise; chosen, as in filling (see benchmarks/gaps.py)."""
FORESHOT_S = 1.0
"""s of a marker beside a stretch that filtering it looks at, so that it has no edges of its own; chosen."""

ImagesByHand: TypeAlias = dict[tuple[str, int], dict[str, tuple[float, float]]]
"""u, v px by camera, by marker and frame (from 0)."""

FEWEST_SMOOTHED = {"butterworth": edge_samples(2), "woltring": 6, "moving_average": 2}
"""Samples of a run, above which each function can smooth it; by definition of these."""


@dataclass(frozen=True, slots=True)
class Footage:
    """What is known of a trial besides its markers.

    Attributes:
        first_frame: number of its first frame. rate: Hz.
        detections, rig: behind its samples; None for a file without.
        world: key of the cameras whose world it is in.
        timed: the detections at the times of the frames, the same rows; None where all cameras are in time.
        left_out: camera's name, first and last frame, numbers in the recording, in which it fits the others no more.
        corrected: images by hand.
    """

    first_frame: int
    rate: float
    detections: Detections | None = None
    rig: Rig | None = None
    world: str = ""
    timed: Detections | None = None
    left_out: tuple[tuple[str, int, int], ...] = ()
    corrected: ImagesByHand = field(default_factory=dict)

    def late(self, camera: str, frame: int, uv: Floats) -> Floats:
        """(2) px by which what a picture shows at uv (2) in a frame, from 0, was elsewhere at the time of the frame.

        As the nearest detection was, as what is beside moves alike.
        """
        seen, timed = self.detections, self.timed
        if seen is None or timed is None or camera not in seen.cameras or not 0 <= frame < seen.n_frames:
            return np.zeros(2)
        own = seen.rows(seen.cameras.index(camera), frame)
        apart = np.linalg.norm(seen.uv[own] - uv, axis=1)
        if not np.isfinite(apart).any():
            return np.zeros(2)
        nearest = int(np.nanargmin(apart))
        return np.asarray(timed.uv[own][nearest] - seen.uv[own][nearest])

    def fits(self, camera: str, frame: int) -> bool:
        """Whether a camera shows places in a frame, a number in the recording."""
        return not any(name == camera and first <= frame <= last for name, first, last in self.left_out)

    def images_of(self, frame: int, xyz: Floats) -> Iterator[tuple[str, float, float]]:
        """Where the pictures of a frame, a number in the recording, show a place (3) mm, of cameras that look at it."""
        for camera in self.rig or ():
            if self.fits(camera.name, frame) and (camera.R @ xyz + camera.t)[2] > 0:
                uv = project(camera, xyz[None])[0]
                u, v = (uv - self.late(camera.name, frame - self.first_frame, uv)).tolist()
                yield camera.name, u, v


class Result(NamedTuple):
    """What became of an edit, of how many samples, and why where it does not stand."""

    outcome: Outcome
    samples: int = 0
    reason: str = ""


ALONE = Result("orphan", reason="one image alone is no place: give that of another camera too")
"""What becomes of an image of a marker that nothing else shows."""
Changed: TypeAlias = tuple[MarkerTrajectory, Result]
"""A marker after an edit, and what became of the edit."""


def erase(path: MarkerTrajectory, edit: Erase, of: Footage) -> Changed:
    """Samples of a stretch become missing."""
    at = _span(path, edit.first, edit.last, of)
    gone = np.zeros(len(path), bool)
    gone[at] = path.origin[at] != Origin.MISSING
    if not gone.any():
        return path, Result("moot", reason="there are no samples in these frames")
    return without(path, gone), Result("held", int(gone.sum()))


def put(path: MarkerTrajectory, edit: Put, of: Footage) -> Changed:
    """One sample is where somebody says."""
    f = edit.frame - of.first_frame
    if not 0 <= f < len(path):
        return path, Result("moot", reason="the trial does not have this frame")
    xyz, result = np.array(edit.xyz), Result("held", 1)
    if edit.world != of.world:
        images = dict(_named_images(edit.images))
        solved = solve(of, edit.frame, images)
        if solved is None:
            return path, Result("orphan", reason="it was said in the world of other cameras, without images of these")
        xyz = solved.xyz
        result = _of_two(of, images, xyz) or result
    cov = np.eye(3) * edit.sd_mm**2
    return with_sample(path, f, xyz, cov), result


def _of_two(of: Footage, images: Mapping[str, tuple[float, float]], xyz: Floats) -> Result | None:
    """Doubt of a place that is worked out again from two images alone, by cameras that say something else now."""
    seen = [(camera, images[camera.name]) for camera in of.rig or () if camera.name in images]
    off = max(float(np.hypot(*(project(camera, xyz[None])[0] - np.array(uv)))) for camera, uv in seen)
    if len(seen) > FEWEST or off <= USUAL_SD:
        return None
    return Result(
        "thin", 1, f"two images alone tell of it by other cameras than then, {off:.1f} px off: it may be mm off"
    )


def smooth(path: MarkerTrajectory, edit: Smooth, of: Footage) -> Changed:
    """A stretch is smoothed by the function that the edit names, without lag; what is missing stays missing."""
    at = _span(path, edit.first, edit.last, of)
    if not 0 < edit.cutoff_hz < of.rate / 2:
        return path, Result("orphan", reason=f"a cut-off of {edit.cutoff_hz:g} Hz is none at {of.rate:g} Hz")
    beside = round(FORESHOT_S * of.rate)
    xyz, origin = path.xyz.copy(), path.origin.copy()
    changed = np.zeros(len(path), bool)
    for first, stop in true_runs(path.origin != Origin.MISSING).tolist():
        first, stop = max(first, at.start - beside), min(stop, at.stop + beside)
        inside = slice(max(first, at.start), min(stop, at.stop))
        if inside.start >= inside.stop or stop - first <= FEWEST_SMOOTHED[edit.function]:
            continue
        origin_of = xyz[first]
        smoothed = _smoothed(path.xyz[first:stop] - origin_of, edit, of.rate) + origin_of
        xyz[inside] = smoothed[inside.start - first : inside.stop - first]
        changed[inside] = True
    if not changed.any():
        return path, Result("moot", reason="no run of samples in these frames is long enough to filter")
    origin[changed] = Origin.EDITED
    return replace(path, xyz=xyz, origin=origin), Result("held", int(changed.sum()))


def _smoothed(y: Floats, edit: Smooth, rate: float) -> Floats:
    """y (F, 3) by the function of the edit."""
    match edit.function:
        case "butterworth":
            return butterworth(y, rate=rate, cutoff_hz=edit.cutoff_hz)
        case "woltring":
            return woltring(y, cutoff=edit.cutoff_hz / rate).values
        case "moving_average":
            return moving_average(y, averaged_samples(rate=rate, cutoff_hz=edit.cutoff_hz))


def with_image(path: MarkerTrajectory, edit: ImagePoint, of: Footage) -> Changed:
    """A sample is solved again with an image where somebody says that the marker is."""
    f = edit.frame - of.first_frame
    if not 0 <= f < len(path):
        return path, Result("moot", reason="the trial does not have this frame")
    if of.rig is None or edit.camera not in of.rig.names:
        return path, Result("orphan", reason=f"there is no camera {edit.camera}")
    if not of.fits(edit.camera, edit.frame):
        return path, Result("orphan", reason=f"{edit.camera} was moved, and fits the other cameras no more there")
    by_hand = of.corrected.setdefault((path.name, f), {})
    by_hand[edit.camera] = edit.u, edit.v
    return _again(path, f, of, by_hand)


def without_image(path: MarkerTrajectory, f: int, camera: str, of: Footage) -> Changed:
    """A sample is solved again without the image of a camera, or becomes missing where that leaves one."""
    by_hand = of.corrected.setdefault((path.name, f), {})
    by_hand[camera] = np.nan, np.nan
    done = _again(path, f, of, by_hand)
    if done[1].outcome == "held":
        return done
    return without(path, np.arange(len(path)) == f), Result("held", 1)


class Solved(NamedTuple):
    """A place (3) mm and its covariance (3, 3) mm²."""

    xyz: Floats
    cov: Floats


def solve(
    of: Footage, frame: int, images: Mapping[str, tuple[float, float]], cov: Mapping[str, Floats] | None = None
) -> Solved | None:
    """The place that pictures show, u, v px by camera; None where fewer than two cameras of the rig have one.

    Args:
        of: has the rig. frame: number in the recording. images: by camera, NaN for none.
        cov: of each, px²; a usual one where not given.
    """
    if of.rig is None:
        return None
    uv = np.array([_in_time(of, name, frame, images.get(name, (np.nan, np.nan))) for name in of.rig.names])
    noise = np.array([(cov or {}).get(name, np.full((2, 2), np.nan)) for name in of.rig.names])
    noise = np.where(np.isfinite(noise).all((1, 2))[:, None, None], noise, np.eye(2) * USUAL_SD**2)
    if np.isfinite(uv[:, 0]).sum() < FEWEST:
        return None
    ideal = np.stack([undistort(camera, place[None])[0] for camera, place in zip(of.rig, uv, strict=True)])
    point = refine(of.rig, triangulate(ideal[None], of.rig.P), uv[None], noise[None])
    return Solved(point.xyz[0], point.cov[0]) if np.isfinite(point.xyz).all() else None


def _in_time(of: Footage, camera: str, frame: int, image: tuple[float, float]) -> Floats:
    """(2) px where what a picture shows was at the time of its frame; NaN where its camera shows no place."""
    uv = np.array(image) if of.fits(camera, frame) else np.full(2, np.nan)
    return uv + of.late(camera, frame - of.first_frame, uv)


def without(path: MarkerTrajectory, gone: np.ndarray) -> MarkerTrajectory:
    """The marker without some samples (F)."""
    columns: dict[str, Any] = {name: getattr(path, name).copy() for name in ("xyz", "cov", "residual", "origin")}
    for name in ("xyz", "cov", "residual"):
        columns[name][gone] = np.nan
    columns["origin"][gone] = Origin.MISSING
    return replace(path, **columns, **_unseen(path, gone))


def with_sample(path: MarkerTrajectory, f: int, xyz: Floats, cov: Floats) -> MarkerTrajectory:
    """The marker with a sample by hand in frame f."""
    columns: dict[str, Any] = {name: getattr(path, name).copy() for name in ("xyz", "cov", "residual", "origin")}
    columns["xyz"][f], columns["cov"][f] = xyz, cov
    columns["residual"][f], columns["origin"][f] = np.nan, Origin.EDITED
    return replace(path, **columns, **_unseen(path, np.arange(len(path)) == f))


def _unseen(path: MarkerTrajectory, gone: np.ndarray) -> dict[str, Any]:
    """The columns of cameras and images, with none in some samples (F)."""
    cameras, detection = path.cameras.copy(), path.detection.copy()
    cameras[gone], detection[gone] = 0, -1
    return {"cameras": cameras, "detection": detection}


def _again(path: MarkerTrajectory, f: int, of: Footage, by_hand: Mapping[str, tuple[float, float]]) -> Changed:
    """A sample solved from its images, some of them by hand."""
    images, cov = dict[str, tuple[float, float]](), dict[str, Floats]()
    if of.detections is not None:
        for name, row in zip(of.detections.cameras, path.detection[f].tolist(), strict=False):
            if row >= 0:
                images[name], cov[name] = tuple(of.detections.uv[row].tolist()), of.detections.cov[row]
    images |= by_hand
    solved = solve(of, f + of.first_frame, images, {name: c for name, c in cov.items() if name not in by_hand})
    if solved is None:
        return path, ALONE
    edited = with_sample(path, f, solved.xyz, solved.cov)
    detection = path.detection.copy()
    if of.detections is not None:
        left = [c for c, name in enumerate(of.detections.cameras) if name in by_hand]
        detection[f, [c for c in left if c < detection.shape[1]]] = -1
    return replace(edited, detection=detection), Result("held", 1)


def _named_images(images: tuple[tuple[str, float, float], ...]) -> list[tuple[str, tuple[float, float]]]:
    return [(name, (u, v)) for name, u, v in images]


def _span(path: MarkerTrajectory, first: int, last: int, of: Footage) -> slice:
    """Frames from 0 of numbers in the recording."""
    start = min(max(first - of.first_frame, 0), len(path))
    return slice(start, max(min(last - of.first_frame + 1, len(path)), start))
