"""Training frames of one gap, and the pose of the body part in them.

Frames are those at the edges of the gap, half of the rest beside it, half all over the trial; those of the other side,
mirrored, are a second source. In the local frame (R, c) of three reference markers, marker d of the references, ranked
by how little its distance from the marker varies (0 the least), has coordinates x_d. The pose is

    φ = ( x_d / (s_d √(1 + rank_d)) for all d,  θ A ) / √(1 + θ²)                                         (1)

s_d being the spread of x_d, the reference markers' part scaled to unit mean square, as is A = R̄ᵀR, R̄ the rotation
nearest to the mean of R: how the part is turned in space matters by θ, as what is soft hangs. x_d and A are taken less
their mean in their own source, and as the reference markers are seen in the gap too, over all frames of it: what is
left of a trial beside a long gap may be another part of the stride than the mean of the other side is of (2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...numerics.evenly import evenly
from ..local_frames import local, triad
from ..marker_array import Gap, MarkerArray
from ..mirrored_markers import REFLECTED
from .kriging import FramePairs

FEWEST = 8
"""Frames to learn from, at least; chosen (see benchmarks/gaps.py)."""
EDGE = 3
"""Frames beside a gap that are all used; further away they are thinned; chosen (see benchmarks/gaps.py)."""
SEARCH = 100
"""Frames from which models are judged, of those to learn from; chosen (see benchmarks/gaps.py)."""
BLOCKS = 12
"""At most so many are left out, the nearest to the gap; chosen (see benchmarks/gaps.py)."""
STILL = 0.01
"""Turns, in radians, below which they are noise; chosen (see benchmarks/gaps.py)."""


class TrainingFrames(NamedTuple):
    """Of one gap n training frames, then the L frames to fill.

    Attributes:
        xyz: (1 + D, n + L, 3) mm, the marker first, then the reference markers.
        time: (n + L) s.
        n: training frames.
        side: (n + L) source of each frame; of those learnt from, the marker's own (0) come first.
        shares: (sources, n + L) what each frame counts for the mean of its source (2), 1 in all.
        judged: those of the n that models are judged by.
        blocks: of these, the frames of each block that is left out.
    """

    xyz: Floats
    time: Floats
    n: int
    side: Ints
    shares: Floats
    judged: Ints
    blocks: list[Ints]


class LocalView(NamedTuple):
    """The training frames in one local frame.

    Attributes:
        R, c: the frame, in all n + L frames.
        y: (n, 3) mm, the marker in it, less the mean of its source.
        mean: (3) mm, of the marker's own source.
        pose, turned: the reference markers' part of φ and A (1), in all frames.
        square: (2, n + L) |·|² of both.
    """

    R: Floats
    c: Floats
    y: Floats
    mean: Floats
    pose: Floats
    turned: Floats
    square: Floats


def training_frames_of(
    motion: MarkerArray, seen: Bools, gap: Gap, references: Ints, *, partner: Ints, most: int, rate_hz: float
) -> TrainingFrames | None:
    """The training frames; None where fewer than `FEWEST` frames show the marker and its references.

    Args:
        motion: of the trial.
        seen: (M, F) of it.
        gap: to fill.
        references: their indices.
        partner: (M) each marker's partner on the other side, itself where there is none.
        most: training frames.
        rate_hz: at which they are taken.
    """
    rows, step = np.array([gap.marker, *references]), max(1, round(motion.rate / rate_hz))
    own = _thin(np.flatnonzero(np.logical_and.reduce(seen[rows])), gap, most, step)
    if len(own) < FEWEST:
        return None
    other, mirrored = np.zeros(0, np.int64), partner[rows]
    if (mirrored != rows).any():
        other = np.flatnonzero(np.logical_and.reduce(seen[mirrored]))
        other = other[:: max(1, round(1.5 * motion.rate / rate_hz), -(-2 * len(other) // most))]
    wanted = np.arange(gap.start, gap.stop)
    xyz = np.concatenate(
        [
            motion.xyz[rows[:, None], own],
            motion.xyz[mirrored[:, None], other] * REFLECTED,
            motion.xyz[rows[:, None], wanted],
        ],
        axis=1,
    )
    n = len(own) + len(other)
    side = np.repeat([0, 1, 0], [len(own), len(other), len(wanted)])
    time = np.concatenate([own, other, wanted]) / motion.rate
    counts = np.repeat([1.0, 1 / step], [n, len(wanted)]) * (side == np.arange(2 if len(other) else 1)[:, None])
    judged = _frames_to_judge(n)
    blocks = _blocks(own[judged[judged < len(own)]], gap)
    return TrainingFrames(xyz, time, n, side, counts / counts.sum(1, keepdims=True), judged, blocks)


def _frames_to_judge(n: int) -> Ints:
    """About SEARCH of n frames, the same ones from both ends."""
    half = evenly(n, SEARCH)[: (min(n, SEARCH) + 1) // 2]
    return np.unique(np.concatenate([half, n - 1 - half]))


def _blocks(frames: Ints, gap: Gap) -> list[Ints]:
    """Frames by blocks of the gap's length on either side of it, or of half of what is seen where that is less."""
    before = frames < gap.start
    away = np.where(before, gap.start - 1 - frames, frames - gap.stop)
    length = max(1, min(gap.length, (int(away[before].max(initial=-1)) + int(away[~before].max(initial=-1)) + 2) // 2))
    number = 2 * (away // length) + before
    return [np.flatnonzero(number == b) for b in np.unique(number)[:BLOCKS]]


def _thin(frames: Ints, gap: Gap, most: int, step: int) -> Ints:
    """Training frames: those at the edges, half of the rest beside the gap, half all over the trial."""
    wanted = frames % step == 0
    wanted[slice(*np.searchsorted(frames, [gap.start - EDGE, gap.stop + EDGE]))] = True
    kept = frames[wanted]
    if len(kept) <= most:
        return kept
    away = np.maximum(gap.start - kept, kept - gap.stop + 1)
    order = np.argsort(away, kind="stable")
    near, far = order[: most // 2], np.sort(order[most // 2 :])
    spread = far[evenly(len(far), most - len(near))]
    return np.sort(kept[np.concatenate([near, spread])])


def local_view(training: TrainingFrames, base: tuple[int, ...]) -> LocalView | None:
    """The training frames seen from one base; None where its markers ever stand on one line."""
    R, c = triad(training.xyz[list(base)])
    if not np.isfinite(R).all():
        return None
    seen, n, side = local(R, c, training.xyz), training.n, training.side
    y, pose = seen[0, :n], seen[1:]
    mean = np.array([y[side[:n] == s].mean(0) for s in range(len(training.shares))])
    pose = pose - (training.shares @ pose)[:, side]  # (2)
    spread = np.sqrt((pose[:, :n] ** 2).sum(-1).mean(1))
    weight = 1 / (np.maximum(spread, 1e-3) * np.sqrt(1 + np.arange(len(pose))))  # (1)
    pose = (pose * weight[:, None, None]).transpose(1, 0, 2).reshape(len(R), -1)
    pose /= np.sqrt((pose[:n] ** 2).sum(1).mean()) or 1.0
    turned = _turned(R, training)
    square = np.stack([(pose**2).sum(1), (turned**2).sum(1)])
    return LocalView(R, c, y - mean[side[:n]], mean[0], pose, turned, square)


def _turned(R: Floats, training: TrainingFrames) -> Floats:
    """(n + L, 9) A of (1), less the mean of each source, in unit mean square over the training frames."""
    mean = (training.shares @ R.reshape(len(R), 9)).reshape(-1, 3, 3)
    U, _, Vt = np.linalg.svd(mean)
    flat = ((U @ Vt).swapaxes(1, 2)[training.side] @ (R - mean[training.side])).reshape(len(R), 9)
    return np.asarray(flat / max(np.sqrt((flat[: training.n] ** 2).sum(1).mean()), STILL))


def pairs_of(training: TrainingFrames, view: LocalView, rows: Ints | slice, columns: Ints | slice) -> FramePairs:
    """Of some of all frames with some of the training frames."""
    dot = np.stack([part[rows] @ part[columns].T for part in (view.pose, view.turned)])
    apart = np.abs(training.time[rows][:, None] - training.time[columns])
    own = int((training.side[rows] == 0).sum()), int((training.side[columns] == 0).sum())
    return FramePairs(dot, view.square[:, rows], view.square[:, columns], apart, own)
