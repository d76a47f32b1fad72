"""What filling added to a trial, apart from it, so that it can be kept and put on again."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .array_types import Floats, Ints
from .arrays import column, set_columns
from .short_repr import ShortRepr
from .trajectories import MarkerTrajectory, Origin, Trajectories


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Fills(ShortRepr):
    """N filled samples of a trial's markers.

    Attributes:
        marker, frame: (N) which, both from 0.
        xyz: (N, 3) mm; cov: (N, 3, 3) mm².
        detection: (N, C) index in `Detections` of the image of a camera that saw the marker alone, where it was used;
            −1 for none.
        gaps: figures of each gap, filled or not, as JSON.
    """

    marker: Ints
    frame: Ints
    xyz: Floats
    cov: Floats
    detection: Ints
    gaps: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.marker)
        set_columns(
            self,
            marker=column("marker", self.marker, np.int64, n),
            frame=column("frame", self.frame, np.int64, n),
            xyz=column("xyz", self.xyz, np.float64, n, 3),
            cov=column("cov", self.cov, np.float64, n, 3, 3),
            detection=column("detection", self.detection, np.int64, n, None),
            gaps=tuple(self.gaps),
        )

    @classmethod
    def between(cls, before: Trajectories, after: Trajectories, gaps: tuple[str, ...] = ()) -> Fills:
        """The samples that are filled in `after` and were not in `before`, trials of the same markers and frames."""
        pairs = zip(before, after, strict=True)
        new = np.array([(a.origin == Origin.FILLED) & (b.origin != Origin.FILLED) for b, a in pairs])
        marker, frame = np.nonzero(new.reshape(len(after), after.n_frames))
        at = list(zip(marker.tolist(), frame.tolist(), strict=True))
        detection = np.full((len(at), max((path.detection.shape[1] for path in after), default=0)), -1, np.int64)
        for row, (m, f) in zip(detection, at, strict=True):
            row[: after.paths[m].detection.shape[1]] = after.paths[m].detection[f]
        return cls(
            marker,
            frame,
            np.array([after.paths[m].xyz[f] for m, f in at]).reshape(-1, 3),
            np.array([after.paths[m].cov[f] for m, f in at]).reshape(-1, 3, 3),
            detection,
            gaps,
        )

    def on(self, trajectories: Trajectories) -> Trajectories:
        """The trial with these samples in it.

        Raises:
            ValueError: it has no such marker or frame.
        """
        if len(self.marker) and (self.marker.max() >= len(trajectories) or self.frame.max() >= trajectories.n_frames):
            raise ValueError(f"fills reach beyond {len(trajectories)} markers and {trajectories.n_frames} frames")
        paths = list(trajectories.paths)
        for m in np.unique(self.marker).tolist():
            own = self.marker == m
            paths[m] = _filled(paths[m], self.frame[own], self.xyz[own], self.cov[own], self.detection[own])
        return replace(trajectories, paths=tuple(paths))


def _filled(path: MarkerTrajectory, frame: Ints, xyz: Floats, cov: Floats, detection: Ints) -> MarkerTrajectory:
    """One marker with its samples."""
    names = ("xyz", "cov", "origin", "residual", "cameras")
    columns = {name: getattr(path, name).copy() for name in names} | {
        "detection": detection_columns(path, detection.shape[1])
    }
    columns["xyz"][frame], columns["cov"][frame], columns["cameras"][frame] = xyz, cov, 0
    columns["origin"][frame], columns["residual"][frame] = Origin.FILLED, np.nan
    columns["detection"][frame, : detection.shape[1]] = detection
    return replace(path, **columns)


def detection_columns(path: MarkerTrajectory, cameras: int) -> Ints:
    """A copy (F, C) of a marker's images with columns for so many cameras, where it knows none."""
    known = path.detection.shape[1]
    return path.detection.copy() if known else np.full((len(path), cameras), -1, np.int64)
