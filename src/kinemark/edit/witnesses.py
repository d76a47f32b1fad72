"""Stretches of paths, with the witnesses by which they are found again."""

from __future__ import annotations

import numpy as np

from ..data import Detections, MarkerTrajectory, Trajectories
from ..data.array_types import Ints
from ..data.edits import MOST_WITNESSES, Stretch, Witness

DECIMALS = 3
"""Of mm and px in a witness: a thousandth, far below any noise; chosen."""


def stretch_of(
    trajectories: Trajectories,
    name: str,
    *,
    first: int | None = None,
    last: int | None = None,
    at: int | None = None,
    within: tuple[int, int] | None = None,
    detections: Detections | None = None,
    world: str = "",
) -> Stretch:
    """A stretch of one trajectory, with witnesses spread evenly over its samples, always one at each end.

    Args:
        trajectories: as somebody sees them.
        name: of the trajectory, such as "*12".
        first, last: frames, numbers in the recording; None where the stretch follows the path as far as that goes.
        at: a frame that somebody pointed at; the sample nearest to it is a witness as well.
        within: first and last frame that witnesses are taken from, where that is less than the stretch.
        detections: behind the samples; None for a file without its images.
        world: key of the cameras whose world the places are in.

    Raises:
        KeyError: there is no such trajectory.
        ValueError: it has no sample in these frames.
    """
    path = trajectories[name]
    frames = np.flatnonzero(np.isfinite(path.xyz).all(1))
    number = frames + trajectories.first_frame
    low, high = within or (first, last)
    inside = (number >= (-np.inf if low is None else low)) & (number <= (np.inf if high is None else high))
    if not inside.any():
        raise ValueError(f"{name} has no sample in frames {low or 'from the first'} to {high or 'the last'}")
    chosen = _spread(frames[inside], None if at is None else at - trajectories.first_frame)
    return Stretch(
        first, last, tuple(_witness(path, f, trajectories.first_frame, detections) for f in chosen.tolist()), world
    )


def _spread(frames: Ints, at: int | None) -> Ints:
    """At most so many of these frames, evenly by number of samples, with the first, the last and the one near `at`."""
    most = MOST_WITNESSES - (at is not None)
    chosen = frames[np.unique(np.linspace(0, len(frames) - 1, min(most, len(frames))).round().astype(np.int64))]
    near = frames[:0] if at is None else frames[[np.abs(frames - at).argmin()]]
    return np.union1d(chosen, near)


def _witness(path: MarkerTrajectory, f: int, first_frame: int, detections: Detections | None) -> Witness:
    """One sample."""
    images = () if detections is None else _images(path.detection[f].tolist(), detections)
    x, y, z = path.xyz[f].round(DECIMALS).tolist()
    return Witness(f + first_frame, (x, y, z), images)


def _images(rows: list[int], detections: Detections) -> tuple[tuple[str, float, float], ...]:
    """Camera, u and v of some rows, one a camera, −1 for none."""
    seen = [(camera, row) for camera, row in zip(detections.cameras, rows, strict=False) if row >= 0]
    return tuple((camera, *detections.uv[row].round(DECIMALS).tolist()) for camera, row in seen)
