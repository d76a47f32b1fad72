"""What filling added to a trial, apart from it, so that it can be kept and put on again."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .arrays import column, set_columns
from .trajectories import Origin, Trajectories


@dataclass(frozen=True, slots=True, eq=False)
class Fills:
    """N filled samples of a trial's markers.

    Attributes:
        marker, frame: (N) which, both from 0.
        xyz: (N, 3) mm; cov: (N, 3, 3) mm².
        cameras: (N) bit c is set when camera c, which saw it alone, told of it.
        told: of each gap, filled or not, what is to be said, as JSON.
    """

    marker: NDArray[np.int64]
    frame: NDArray[np.int64]
    xyz: NDArray[np.float64]
    cov: NDArray[np.float64]
    cameras: NDArray[np.uint32]
    told: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.marker)
        set_columns(
            self,
            marker=column("marker", self.marker, np.int64, n),
            frame=column("frame", self.frame, np.int64, n),
            xyz=column("xyz", self.xyz, np.float64, n, 3),
            cov=column("cov", self.cov, np.float64, n, 3, 3),
            cameras=column("cameras", self.cameras, np.uint32, n),
            told=tuple(self.told),
        )

    @classmethod
    def between(cls, before: Trajectories, after: Trajectories, told: tuple[str, ...] = ()) -> Fills:
        """The samples that are filled in `after` and were not in `before`, trials of the same markers and frames."""
        pairs = zip(before, after, strict=True)
        new = np.array([(a.origin == Origin.FILLED) & (b.origin != Origin.FILLED) for b, a in pairs])
        marker, frame = np.nonzero(new.reshape(len(after), after.n_frames))
        return cls(
            marker,
            frame,
            np.array([after.paths[m].xyz[f] for m, f in zip(marker, frame, strict=True)]).reshape(-1, 3),
            np.array([after.paths[m].cov[f] for m, f in zip(marker, frame, strict=True)]).reshape(-1, 3, 3),
            np.array([after.paths[m].cameras[f] for m, f in zip(marker, frame, strict=True)], np.uint32),
            told,
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
            columns = {name: getattr(paths[m], name).copy() for name in ("xyz", "cov", "origin", "residual", "cameras")}
            at = self.frame[own]
            columns["xyz"][at], columns["cov"][at], columns["cameras"][at] = (
                self.xyz[own],
                self.cov[own],
                self.cameras[own],
            )
            columns["origin"][at], columns["residual"][at] = Origin.FILLED, np.nan
            paths[m] = replace(paths[m], **columns)
        return replace(trajectories, paths=tuple(paths))
