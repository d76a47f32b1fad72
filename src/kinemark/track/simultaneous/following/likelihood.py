"""Evidence: whether a track is a marker or a chance meeting of images.

The images of a marker lie about the projections of its point as their noise says, though now and then, as when a limb
hides a part of the marker, farther off: as Student's t with ν degrees of freedom. Those of a chance meeting lie
anywhere within the gate of g standard deviations. In a point of n images k = 2n − 3 distances are free, and with q the
sum of their squares in standard deviations its log-likelihood ratio is

    k ln(2g / √(2π)) − (ν + k)/2 ln(1 + q/ν)                                              (1)

which for g = 5 is 1.4 for two images that fit perfectly, 4.1 for three, and no point counts less than
ln WEAK (2), as errors that last, such as a calibration's, are no chance. The evidence for a track is the sum over its
points (3). Images that markers share or merge in say nothing. A track of less than `SURE` is dropped.

Images of two markers that move alike may meet for a while. So a track that three cameras never see counts as nothing
where its evidence is less than FAIR of what images that fit perfectly would give (4).
"""

from __future__ import annotations

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ....numerics.robust import student_log_likelihood
from ..detection_index import Images
from .candidate_points import intersect
from .passes import Associations

DEGREES_OF_FREEDOM = 4.0
"""ν, degrees of freedom of Student's t in (1); chosen (see benchmarks/tracking.py)."""

AT_ONCE = 20_000
"""Points that are worked out in one go; chosen: more would take memory and no less time."""

WEAK = 0.75
"""Of (2): then a chance meeting, uniform within the gate, gains nothing from being long.
Chosen (see benchmarks/tracking.py)."""

SURE = float(np.log(10.0))
"""A marker is then ten times likelier than chance, whatever its length; chosen."""

FAIR = 0.45
"""Of (4); markers have 0.5 to 0.9, as their images have noise; chosen (see benchmarks/tracking.py)."""


def point_evidence(seen: Associations, own: Bools, gate: float) -> Floats:
    """(S) by (1) and (2) for each sighting, whose own images are `own` (C, S)."""
    n = own.sum(0)
    free = 2 * np.maximum(n, 1.5) - 3
    said = free * _perfect(gate) + student_log_likelihood(seen.squared, DEGREES_OF_FREEDOM, free)  # (1)
    return np.where(n >= 2, np.maximum(said, np.log(WEAK)), 0.0)  # (2)


def disagreement(images: Images, detection: Ints) -> Floats:
    """(S) q of (1): how far detections (C, S) are off the points that fit them best, in standard deviations, squared.

    What the track's motion predicts has no say in it: it holds the place of the track, so that of two images more than
    the one distance would be free.
    """
    squared = np.zeros(detection.shape[1])
    for first in range(0, len(squared), AT_ONCE):
        part = detection[:, first : first + AT_ONCE]
        squared[first : first + AT_ONCE] = np.where(part >= 0, intersect(images, part).squared, 0.0).sum(0)
    return np.where((detection >= 0).sum(0) >= 2, np.nan_to_num(squared, nan=np.inf, posinf=np.inf), 0.0)


def evidence(seen: Associations, own: Bools, gate: float) -> Floats:
    """(N) by (3) and (4) for each track, whose own images are `own` (C, S)."""
    n, tracks = own.sum(0), int(seen.id.max(initial=-1)) + 1
    total = np.bincount(seen.id, point_evidence(seen, own, gate), minlength=tracks)
    pairs = np.bincount(seen.id, n == 2, minlength=tracks)
    only_pairs = np.bincount(seen.id, (seen.detection >= 0).sum(0) > 2, minlength=tracks) == 0
    return np.where(only_pairs & (total < FAIR * _perfect(gate) * pairs), 0.0, total)  # (4)


def _perfect(gate: float) -> float:
    """(1) of two images that fit perfectly."""
    return float(np.log(2 * gate / np.sqrt(2 * np.pi)))
