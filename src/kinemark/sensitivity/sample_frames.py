"""Some frames of a recording as arrays: markers, and the images that they were found from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import Detections, KinemarkError, Tracks, Trajectories
from ..data.array_types import Bools, Floats
from ..numerics.evenly import evenly_rounded

SAME_MM = 20.0
"""A point nearer to a named marker than this is that marker; chosen."""
MOST_TRACKS = 60
"""The longest tracks, which are looked at, at most; chosen."""


class SampledFrames(NamedTuple):
    """M markers in F frames: xyz (M, F, 3) mm and uv (M, F, C, 2) px, both NaN where missing; time (F) s."""

    names: tuple[str, ...]
    xyz: Floats
    uv: Floats
    time_s: Floats

    @property
    def seen(self) -> Bools:
        """(M, F, C)."""
        return np.isfinite(self.uv[..., 0])


def gather(tracks: Tracks, detections: Detections, *, frames: int) -> SampledFrames:
    """The longest tracks of a recording in some of its frames, with the images that they were found from.

    Raises:
        KinemarkError: there are no tracks.
    """
    cloud = tracks.cloud
    lengths = tracks.lengths
    chosen = np.argsort(-lengths, kind="stable")[:MOST_TRACKS]
    chosen = np.sort(chosen[lengths[chosen] >= max(0.1 * lengths.max(initial=0), 10)])
    if not len(chosen):
        raise KinemarkError("The trial has no marker seen in ten frames or more: there is nothing to judge by.")
    at = evenly_rounded(cloud.n_frames, frames)
    place = np.full(cloud.n_frames, -1)
    place[at] = np.arange(len(at))
    row = np.full(len(tracks), -1)
    row[chosen] = np.arange(len(chosen))
    own = np.flatnonzero((tracks.id >= 0) & (place[cloud.frame] >= 0))
    own = own[row[tracks.id[own]] >= 0]
    m, f = row[tracks.id[own]], place[cloud.frame[own]]
    xyz = np.full((len(chosen), len(at), 3), np.nan)
    uv = np.full((len(chosen), len(at), cloud.detection.shape[1], 2), np.nan)
    xyz[m, f] = cloud.xyz[own]
    detection = cloud.detection[own]
    uv[m, f] = np.where((detection >= 0)[..., None], detections.uv[detection], np.nan)
    return SampledFrames(tuple(f"*{t + 1}" for t in chosen), xyz, uv, at / cloud.rate)


def gather_named(named: Trajectories, tracks: Tracks, detections: Detections, *, frames: int) -> SampledFrames:
    """The markers of a file with names, and the images of the points of this recording that lie where they are.

    Raises:
        KinemarkError: the file is of another rate or length, or its markers are not where those of the recording are.
    """
    cloud = tracks.cloud
    first = named.first_frame - 1 if named.n_frames < cloud.n_frames else 0
    if abs(named.rate - cloud.rate) > 0.01 * cloud.rate or first + named.n_frames > cloud.n_frames:
        raise KinemarkError(
            f"The named markers have {named.n_frames} frames at {named.rate:g} Hz and the recording "
            f"{cloud.n_frames} at {cloud.rate:g} Hz. Name a file of the same recording."
        )
    at = evenly_rounded(named.n_frames, frames)
    xyz = named.xyz[:, at]
    uv = np.full((*xyz.shape[:2], cloud.detection.shape[1], 2), np.nan)
    for i, f in enumerate(at + first):
        rows = np.arange(cloud.start[f], cloud.start[f + 1])
        if not len(rows):
            continue
        away = np.linalg.norm(xyz[:, i, None] - cloud.xyz[rows], axis=2)
        near = np.nan_to_num(away, nan=np.inf)
        own = near.min(1) < SAME_MM
        detection = cloud.detection[rows[near.argmin(1)[own]]]
        uv[own, i] = np.where((detection >= 0)[..., None], detections.uv[detection], np.nan)
    there = SampledFrames(named.names, xyz, uv, (at + first) / cloud.rate)
    share = there.seen.any(2).sum() / max(np.isfinite(xyz[..., 0]).sum(), 1)
    if share < 0.5:
        raise KinemarkError(
            f"Only {100 * share:.0f} % of the named markers lie within {SAME_MM:g} mm of a marker of the recording. "
            "Name a file of the same recording, in the same world."
        )
    return there
