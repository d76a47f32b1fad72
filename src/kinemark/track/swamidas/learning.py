"""What the first frames teach: the error of measurement and the segments (Swamidas 1997, 3.4.2 and 3.5)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...data import Cloud
from ...data.array_types import Floats, Ints
from .segments import LearnedSegments, learn_segments, no_segments
from .swamidas_method import SENSORS, Swamidas


@dataclass(slots=True)
class LearnedParameters:
    """What the first frames teach: error (3) mm, segments, and the points (id, xyz) of these frames until then."""

    error: Floats
    segments: LearnedSegments
    learning_frames: list[tuple[Ints, Floats]] = field(default_factory=list)

    @property
    def sd(self) -> float:
        """σ of the predictor, mm: one for all coordinates."""
        return float(np.sqrt((self.error**2).mean()))

    def learn(self, identity: Ints, points: Floats, n_frames: int, method: Swamidas) -> None:
        """Points (n, 3) mm of one more frame, with identities (n); after `n_frames` of them all is learned."""
        if len(self.learning_frames) < n_frames and (self.learning_frames or len(points)):
            self.learning_frames.append((identity, points))
            if len(self.learning_frames) == n_frames:
                self._learn(method)

    def _learn(self, method: Swamidas) -> None:
        n_tracks = max(int(identity.max(initial=-1)) for identity, _ in self.learning_frames) + 1
        paths = np.full((n_tracks, len(self.learning_frames), 3), np.nan)
        for f, (identity, points) in enumerate(self.learning_frames):
            paths[identity[identity >= 0], f] = points[identity >= 0]
        if method.measurement_sd is None:
            self.error = learn_error(paths, self.error)
        if method.segment_tolerance and not method.lengths:
            self.segments = learn_segments(paths, tolerance=method.segment_tolerance, links=method.links)


def stated_parameters(cloud: Cloud, method: Swamidas) -> LearnedParameters:
    """What is known before any frame; an unknown error is at first the cloud's own, or the document's."""
    if method.measurement_sd is not None:
        error = np.full(3, method.measurement_sd)
    else:
        variance = np.diagonal(cloud.cov, axis1=1, axis2=2)
        variance = variance[np.isfinite(variance).all(1)]
        error = np.sqrt(np.median(variance, axis=0)) if len(variance) else np.full(3, SENSORS)
    given = LearnedSegments(np.array(method.links, np.int64).reshape(-1, 2), np.array(method.lengths))
    return LearnedParameters(error, given if method.lengths else no_segments())


def learn_error(paths: Floats, otherwise: Floats) -> Floats:
    """(3) mm the scatter of points (M, F, 3) mm about smooth paths.

    The third difference of a path of constant acceleration is that of its errors alone: of variance (1 + 9 + 9 + 1) σ².
    """
    jumps = np.diff(paths, 3, axis=1).reshape(-1, 3)
    jumps = jumps[np.isfinite(jumps).all(1)]
    if not len(jumps):
        return otherwise
    return np.maximum(np.sqrt((jumps**2).mean(0) / 20), 1e-6)
