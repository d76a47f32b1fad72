"""How noisy the cameras really are, learned from the recording.

The noise that detections state, and the covariance of a calibration, say nothing of a camera that was knocked since, of
a lens that its model does not fit, of strobes out of step; and many files state no noise at all. In some frames of the
recording the variance σ² of the images of each camera is found from their distances to the epipolar lines of the others
(`epipolar_noise`), and what is missing,

    a² = σ² − σ_stated²                                                                   (1)

is added to all images of the camera, where it is more than MIN_MISSING_SHARE of what is stated and three standard
errors (2). No camera is taken to lack less than the median of all (3). Where far more is stated than there is, as of
variances for standard deviations, it counts as unstated, and the images only keep what theirs is to the others' (4).
There must be more residuals at 0 than by chance: of noise of 3 px, no more are seen there than a few that meet so. What
is stated has a margin for association
(`detection_index`); whether the positions' errors have to be widened is judged by (2) without it, and the variance that
they are given then is that of `epipolar_noise` (6) and (7), less what the calibration states of itself.

Images are then grouped (`candidate_points`). Where three and more agree, each camera is compared with what the others
say without it. A camera of which hardly any image is where one is expected is `Noise.inconsistent`: its calibration
does not hold. One that has a partner among the others (`epipolar_noise` (7)) is not: it sees another side of the
subject.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data.array_types import Floats, Ints
from ....numerics.evenly import scattered
from ..detection_index import LEAST_SD, Images
from ..following.associate import predict_images
from ..following.candidate_points import CandidatePoints, find_candidate_points, intersect
from ..following.kalman_states import KalmanStates
from .calibration_field import CalibrationField, calibration_field
from .epipolar_noise import (
    CameraNoise,
    Mixture,
    camera_noise,
    mixture,
    pair_excess,
    pair_of,
    partners,
    peak_height,
    residuals,
)

MAX_DISTANCE = 10.0
"""px; no image that lies farther off is the one that is expected; chosen (see benchmarks/tracking.py)."""

MIN_MISSING_SHARE = 0.5
"""Variance of this share of what is stated is missing before any is added; chosen (see benchmarks/tracking.py)."""

MIN_FOUND_SHARE = 0.15
"""Share of the places expected in a camera's image at which it must have an image; occlusion leaves 0.3 and more.
Chosen (see benchmarks/tracking.py)."""

OVERSTATED = 3.0
"""Times as much as images disagree by, standard deviations, that their stated noise is no longer believed (4); chosen:
noise that is stated with a margin is still believed, and only makes errors of positions as much too large."""

CLEAR = 1.5
"""Times as many residuals at 0 as elsewhere, from which on noise is known to be overstated (4); chosen: right noise of
3 and 4 px made up to 1.4 on scenes 148000 to 148035 of the second generator, of up to 1 px mostly 1.5 and more."""

SAMPLED_IMAGES = 1500
"""Images that are looked at, about, in two frames at least and at most in one of FRAME_STEP.
Chosen (see benchmarks/tracking.py)."""

MISSED = 0.5
"""Of the images of a camera that are met in as many frames in the mean; chosen: of every second image none is met."""

FRAME_STEP = 5
"""Frames of which one is looked at at most; chosen: with few images, few frames hold too few pairs of them."""

MIN_PLACES = 20
"""Places from which something can be said of a camera; chosen (see benchmarks/tracking.py)."""


class Noise(NamedTuple):
    """What was learned of each of C cameras.

    Attributes:
        added: (C) a of (1), px.
        white: (C) px², the white noise that an image has at least, 0 where what is stated holds.
        lasting: (C) px², what the calibration leaves in the same places of the image, beyond what it states.
        found: (C) share of expected places with an image; NaN where not known, or low of a camera that has a partner.
        seen: (C) px², σ² as the residuals have it, whatever is stated, of no camera less than the median of all, as
            (3), or than LEAST_SD²; NaN where nothing is known.
        pairs: (C, C) as `pair_excess` has it: what a calibration leaves differs from one pair of cameras to another.
    """

    added: Floats
    white: Floats
    lasting: Floats
    found: Floats
    seen: Floats
    pairs: Floats

    @property
    def inconsistent(self) -> Ints:
        """Inconsistent cameras: their images fit nothing."""
        return np.flatnonzero(self.found < MIN_FOUND_SHARE)


def sampled_frames(images: Images) -> list[int]:
    """Frames all over the recording with about SAMPLED_IMAGES images, evenly spaced where that misses no camera."""
    n, C = images.n_frames, len(images.P)
    count = int(np.clip(SAMPLED_IMAGES * n // max(len(images.by_cell.order), 1), 2, max(n // FRAME_STEP, 2)))
    even = np.unique(np.linspace(0, n - 1, count + 2)[1:-1].astype(int)) if n else np.zeros(0, int)
    met = np.bincount(images.camera[images.usable & np.isin(images.frame, even)], minlength=C)
    usual = np.bincount(images.camera[images.usable], minlength=C) * len(even) / max(n, 1)
    return (scattered(n, count) if (met < MISSED * usual).any() else even).tolist()


def learn_noise(images: Images, F: Floats, gate: float) -> tuple[Images, Noise]:
    """The images with the noise that their cameras really have, and that noise."""
    C, frames = len(images.P), sampled_frames(images)
    zero, unknown = np.zeros(C), np.full(C, np.nan)
    nothing = Noise(zero, zero, zero, unknown, unknown, np.ones((C, C)))
    if not frames:
        return images, nothing
    stated = images if images.stated else images.noisier(np.full(C, LEAST_SD**2) - images.usual)
    some = residuals(stated, F, frames)
    fit = mixture(some.off, pair_of(some, C), C * C, some.window)
    seen = camera_noise(some, fit, C)
    if images.stated and _overstated(images.usual, seen, fit, len(some.off)):
        stated = stated.believed(LEAST_SD**2 / images.usual)._replace(stated=False)
    added = _missing(stated, seen)
    known = np.isfinite(added)
    if not known.any():
        return images, nothing
    noisy = stated.noisier(np.where(known, added, np.median(added[known])))
    groups = find_candidate_points(noisy, images.usable, F, frames, gate)
    groups = groups.take((groups.detection >= 0).sum(0) >= 3)
    found = np.array([_found_share(noisy, groups, c) for c in range(C)])
    low = found < MIN_FOUND_SHARE
    found[low & partners(some, C, len(frames))[:, ~low].any(1)] = np.nan
    field = calibration_field(stated, some)
    white = camera_noise(some, field.left, C)
    least = np.maximum(np.fmax(seen.variance, _median(seen.variance[known])), LEAST_SD**2)
    added = np.sqrt(np.where(known, added, 0.0))
    pairs = pair_excess(some, fit, _usual(noisy, margin=True))
    return noisy, Noise(added, _white(stated, white), _lasting(images, field, white), found, least, pairs)


def _overstated(usual: float, seen: CameraNoise, fit: Mixture, n: int) -> bool:
    """(4), of usually stated noise in px² and n residuals."""
    variance = _median(seen.variance[np.isfinite(seen.variance)])
    return bool(usual > OVERSTATED**2 * variance) and peak_height(fit, n) > CLEAR


def _white(images: Images, noise: CameraNoise) -> Floats:
    """(C) px², `Noise.white`."""
    total = np.nan_to_num(noise.variance, nan=np.nan_to_num(_median(noise.variance[np.isfinite(noise.variance)])))
    if not images.stated:
        return total
    missing = _missing_of(noise, _usual(images, margin=False))
    return np.where(np.maximum(missing, _median(missing[np.isfinite(missing)])) > 0, total, 0.0)  # (3)


def _lasting(images: Images, field: CalibrationField, noise: CameraNoise) -> Floats:
    """(C) px², `Noise.lasting`."""
    variance = field.variance(np.nan_to_num(_median(noise.variance[np.isfinite(noise.variance)])))
    beyond = np.array([field.exceeds(own) for own in images.calibration])
    return np.where(beyond, np.maximum(variance - images.calibration, 0.0), 0.0)


def _missing(images: Images, noise: CameraNoise) -> Floats:
    """(C) px² by (1) to (3), NaN where nothing is known."""
    stated = _usual(images, margin=True)
    a = _missing_of(noise, stated) if images.stated else np.maximum(noise.variance - stated, 0.0)
    return np.where(np.isfinite(noise.variance), np.maximum(a, _median(a[np.isfinite(a)])), np.nan)


def _missing_of(noise: CameraNoise, stated: Floats) -> Floats:
    """(C) px² by (1) and (2) beside what is stated (C) px²; NaN where nothing is known."""
    a = noise.variance - stated
    return np.where((a < MIN_MISSING_SHARE * stated) | (a < 3 * noise.error), 0.0, a)


def _usual(images: Images, *, margin: bool) -> Floats:
    """(C) px², the median variance of the images of each camera that are one marker's; with the margin, and what the
    calibration leaves open, or without."""
    out = np.empty(len(images.P))
    for c, own in enumerate(images.of_cameras):
        variance = images.variance[own]
        variance = variance if margin else variance - images.margin(own) - images.calibration[c]
        out[c] = _median(variance[images.usable[own] & ~images.merged[own]])
    return out


def _found_share(images: Images, groups: CandidatePoints, c: int) -> float:
    """Share of the places at which groups of three and more without camera c expect an image in it that have one, NaN
    where there are hardly any."""
    detection = groups.detection.copy()
    detection[c] = -1
    enough = (detection >= 0).sum(0) >= 2
    detection, frame = detection[:, enough], groups.frame[enough]
    point = intersect(images, detection)
    uv = predict_images(images.P[c : c + 1], KalmanStates(point.xyz, point.cov)).uv[0].T
    inside = np.isfinite(uv).all(1) & ((uv >= 0) & (uv < images.size[c])).all(1)
    uv, frame = uv[inside], frame[inside]
    own, detection = images.near(frame * len(images.P) + c, uv[:, 0], np.full(len(uv), MAX_DISTANCE))
    near = np.linalg.norm(images.uv[detection] - uv[own], axis=1) < MAX_DISTANCE
    near &= ~images.merged[detection]  # markers that run together are no measure
    return len(np.unique(own[near])) / len(uv) if len(uv) >= MIN_PLACES else np.nan


def _median(values: Floats) -> float:
    """NaN of nothing."""
    return float(np.median(values)) if len(values) else np.nan
