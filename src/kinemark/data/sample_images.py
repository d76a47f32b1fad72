"""From a marker's sample back to the images that it was made of, to show it there or to solve it again."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .detections import Detections
from .matches import Matches
from .trajectories import Trajectories


class SampleImages(NamedTuple):
    """The images of one sample.

    Attributes:
        row: (C) detection index: the row in `Detections` of each camera's image, −1 for none.
        uv: (C, 2) px where they are, as the lens drew them; NaN for none.
        cov: (C, 2, 2) px², NaN where unknown.
    """

    row: NDArray[np.int64]
    uv: NDArray[np.float64]
    cov: NDArray[np.float64]


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
    row = _views(trajectories, marker, detections)[frame]
    seen = row >= 0
    uv, cov = np.full((len(row), 2), np.nan), np.full((len(row), 2, 2), np.nan)
    uv[seen], cov[seen] = detections.uv[row[seen]], detections.cov[row[seen]]
    return SampleImages(row, uv, cov)


def matches_of(trajectories: Trajectories, marker: str, detections: Detections) -> Matches:
    """All samples of a marker that two or more cameras see, as matched images, ready to be reconstructed again.

    Raises:
        KeyError: there is no such marker.
        ValueError: the detections are others.
    """
    view = _views(trajectories, marker, detections)
    several = np.flatnonzero((view >= 0).sum(1) >= 2)
    first = view[several].max(1)
    return Matches(detections.frame[first], view[several], np.full(len(several), np.nan), detections.n_frames)


def _views(trajectories: Trajectories, marker: str, detections: Detections) -> NDArray[np.int64]:
    """(F, C) a marker's images; all −1 where they are not known.

    Raises:
        ValueError: there are other cameras in the detections, or fewer rows than the trajectories name.
    """
    view, n = trajectories[marker].view, len(detections.cameras)
    if not view.shape[1]:
        return np.full((len(view), n), -1, np.int64)
    if view.shape[1] != n or view.max(initial=-1) >= len(detections):
        raise ValueError(
            f"marker {marker} has images of {view.shape[1]} cameras up to row {view.max(initial=-1)}; the detections "
            f"have {n} cameras and {len(detections)} rows. Give those that the trajectories were made of"
        )
    return view
