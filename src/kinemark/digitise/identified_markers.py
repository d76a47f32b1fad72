"""Detections whose markers an operator has named: matching and tracking have nothing left to do.

Rows are in order of camera, frame and marker, so that the marker of each row, (D), says with its camera and frame what
it is; a group of matched rows is all that cameras saw of one marker in one frame (1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..data import Cloud, Detections, MarkerTrajectory, Matches, Tracks, Trajectories
from ..data.array_types import Floats, Ints


class Identified(NamedTuple):
    """Detections (D rows) and the marker that each is, (D)."""

    detections: Detections
    marker: Ints


def identified(uv: Floats, *, cameras: Sequence[str], rate: float) -> Identified:
    """Digitised places (C, M, F, 2) px, NaN where not present, as detections at `rate` Hz.

    Raises:
        ValueError: uv has another shape, or is NaN in one coordinate only.
    """
    if uv.ndim != 4 or uv.shape[0] != len(cameras) or uv.shape[3] != 2:
        raise ValueError(f"uv has shape {uv.shape}, wanted ({len(cameras)} cameras, markers, frames, 2)")
    if (np.isnan(uv[..., 0]) != np.isnan(uv[..., 1])).any():
        raise ValueError("uv is NaN in one coordinate of a marker only, wanted both or none")
    places = uv.transpose(0, 2, 1, 3)  # (C, F, M, 2)
    seen = ~np.isnan(places[..., 0])
    marker = np.broadcast_to(np.arange(uv.shape[1]), seen.shape)[seen]
    return Identified(Detections.build(tuple(cameras), rate, seen.sum(2), places[seen]), marker)


def identified_matches(detections: Detections, marker: Ints) -> Matches:
    """The groups of (1) that two or more cameras see, in order of frame and marker; rows of marker −1 are in none.

    Raises:
        ValueError: not one marker a row, or a camera has a marker twice in a frame.
    """
    if len(marker) != len(detections):
        raise ValueError(f"marker has {len(marker)} entries, wanted one for each of {len(detections)} detections")
    rows = np.flatnonzero((marker >= 0) & detections.valid)
    n = int(marker.max(initial=-1)) + 1
    group, of = np.unique(detections.frame[rows] * max(n, 1) + marker[rows], return_inverse=True)
    detection = np.full((len(group), len(detections.cameras)), -1, np.int64)
    detection[of, detections.camera[rows]] = rows
    if (detection >= 0).sum() != len(rows):
        raise ValueError("a camera has one marker twice in a frame, wanted once")
    several = (detection >= 0).sum(1) >= 2
    frame = group[several] // max(n, 1)
    return Matches(frame, detection[several], np.full(int(several.sum()), np.nan), detections.n_frames)


def identified_tracks(cloud: Cloud, marker: Ints) -> Tracks:
    """The points with the markers (D) that their rows are."""
    return Tracks(cloud, marker[cloud.detection.max(1)] if len(cloud) else np.zeros(0, np.int64))


def called(trajectories: Trajectories, names: Sequence[str], n_frames: int) -> Trajectories:
    """The first paths with these names (M), and empty ones for markers that nothing was reconstructed of.

    Raises:
        ValueError: there are more paths than names.
    """
    if len(trajectories) > len(names):
        raise ValueError(f"there are {len(trajectories)} trajectories, wanted at most the {len(names)} that have names")
    paths = [replace(path, name=name) for path, name in zip(trajectories.paths, names, strict=False)]
    missing = names[len(paths) :]
    none = [MarkerTrajectory.measured(name, np.full((n_frames, 3), np.nan)) for name in missing]
    return replace(trajectories, paths=(*paths, *none))
