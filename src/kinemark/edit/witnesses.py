"""Stretches of paths, with the witnesses by which they are found again."""

from __future__ import annotations

import numpy as np

from ..data import Detections, MarkerTrajectory, Trajectories
from ..data.array_types import Ints
from ..data.edits import FEWEST_WITNESSES, MOST_WITNESSES, WITNESS_EVERY, Stretch, Witness
from ..numerics.evenly import evenly_rounded
from .crossings import unbroken

DECIMALS = 3
"""Of mm and px in a witness: a thousandth, far below any noise; chosen."""

MOST_PIECES = 100
"""Pieces of a path that have a witness of their own, the longest; chosen: a path with more is no marker's."""


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
    among: Trajectories | None = None,
    pieces: Ints | None = None,
) -> Stretch:
    """A stretch of one trajectory, with witnesses spread evenly over its samples, always one at each end.

    Where the path steps onto another's place (`crossings`), each of its pieces has a witness.

    Args:
        trajectories: as somebody sees them.
        name: of the trajectory, such as "*12".
        first, last: frames, numbers in the recording; None where the stretch follows the path as far as that goes.
        at: a frame that somebody pointed at; the sample nearest to it is a witness as well.
        within: first and last frame that witnesses are taken from, where that is less than the stretch.
        detections: behind the samples; None for a file without its images.
        world: key of the cameras whose world the places are in.
        among: the paths of the trial before all edits, on whose places it may step; `trajectories` where None.
        pieces: (F) of the path, where they are known (`crossings.unbroken`).

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
        span = "" if low is None and high is None else f" in frames {low or 'from the first'} to {high or 'the last'}"
        raise ValueError(f"{name} has no sample{span}")
    chosen = _spread(frames[inside], None if at is None else at - trajectories.first_frame)
    pieces = unbroken([path], among or trajectories)[0] if pieces is None else pieces
    chosen = _in_each_piece(chosen, frames[inside], pieces)
    return Stretch(first, last, witnesses_at(path, chosen, trajectories.first_frame, detections), world)


def _spread(frames: Ints, at: int | None) -> Ints:
    """At most so many of these frames, evenly by number of samples, with the first, the last and the one near `at`."""
    most = min(max(len(frames) // WITNESS_EVERY, FEWEST_WITNESSES), MOST_WITNESSES) - (at is not None)
    chosen = frames[evenly_rounded(len(frames), most)]
    near = frames[:0] if at is None else frames[[np.abs(frames - at).argmin()]]
    return np.union1d(chosen, near)


def _in_each_piece(chosen: Ints, frames: Ints, piece: Ints) -> Ints:
    """With the middle frame of each piece that has none of them, of the longest pieces."""
    numbers, first, count = np.unique(piece[frames], return_index=True, return_counts=True)
    order = np.argsort(-count, kind="stable")[:MOST_PIECES]
    left = order[~np.isin(numbers[order], piece[chosen])]
    return np.union1d(chosen, frames[first[left] + count[left] // 2])


def witnesses_at(
    path: MarkerTrajectory, frames: Ints, first_frame: int, detections: Detections | None
) -> tuple[Witness, ...]:
    """Samples of a path, in frames from 0, with the images behind each."""
    images = [()] * len(frames) if detections is None else _images(path.detection[frames], detections)
    places = path.xyz[frames].round(DECIMALS).tolist()
    numbers = (frames + first_frame).tolist()
    return tuple(Witness(f, (x, y, z), seen) for f, (x, y, z), seen in zip(numbers, places, images, strict=True))


def _images(rows: Ints, detections: Detections) -> list[tuple[tuple[str, float, float], ...]]:
    """Camera, u and v of rows (frames, cameras), one a camera, −1 for none."""
    if not len(detections.uv):
        return [()] * len(rows)
    uv = detections.uv[np.maximum(rows, 0)].round(DECIMALS).tolist()
    return [
        tuple((camera, *at) for camera, row, at in zip(detections.cameras, own, here, strict=False) if row >= 0)
        for own, here in zip(rows.tolist(), uv, strict=True)
    ]
