"""From a marker's sample back to the images that it was made of, to show it there or to solve it again."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .array_types import Floats, Ints
from .detections import Detections
from .matches import Matches
from .trajectories import Trajectories


class SampleImages(NamedTuple):
    """The images of one sample.

    Attributes:
        detection: (C) index in `Detections` of each camera's image, −1 for none.
        uv: (C, 2) px where they are, as the lens drew them; NaN for none.
        cov: (C, 2, 2) px², NaN where unknown.
    """

    detection: Ints
    uv: Floats
    cov: Floats


def images_of(trajectories: Trajectories, marker: str, frame: int, detections: Detections) -> SampleImages:
    """The images behind one sample, a row each camera of `detections`.

    Args:
        trajectories: of the trial. marker: its name.
        frame: of the trajectories, from 0.
        detections: those that the trajectories were made of.

    Raises:
        KeyError: there is no such marker.
        IndexError: there is no such frame.
        ValueError: the detections are others.
    """
    detection = _detection(trajectories, marker, detections)[frame]
    seen = detection >= 0
    uv, cov = np.full((len(detection), 2), np.nan), np.full((len(detection), 2, 2), np.nan)
    uv[seen], cov[seen] = detections.uv[detection[seen]], detections.cov[detection[seen]]
    return SampleImages(detection, uv, cov)


def matches_of(trajectories: Trajectories, marker: str, detections: Detections) -> Matches:
    """All samples of a marker that two or more cameras see, as matched images, ready to be reconstructed again.

    Raises:
        KeyError: there is no such marker.
        ValueError: the detections are others.
    """
    detection = _detection(trajectories, marker, detections)
    several = np.flatnonzero((detection >= 0).sum(1) >= 2)
    first = detection[several].max(1)
    return Matches(detections.frame[first], detection[several], np.full(len(several), np.nan), detections.n_frames)


def _detection(trajectories: Trajectories, marker: str, detections: Detections) -> Ints:
    """(F, C) a marker's images; all −1 where they are not known.

    Raises:
        ValueError: there are other cameras in the detections, or fewer rows than the trajectories name.
    """
    detection, n = trajectories[marker].detection, len(detections.cameras)
    if not detection.shape[1]:
        return np.full((len(detection), n), -1, np.int64)
    if detection.shape[1] != n or detection.max(initial=-1) >= len(detections):
        raise ValueError(
            f"marker {marker} has images of {detection.shape[1]} cameras up to {detection.max(initial=-1)}; there "
            f"are {len(detections)} detections of {n} cameras. Give those that the trajectories were made of"
        )
    return detection
