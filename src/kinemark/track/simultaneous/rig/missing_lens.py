"""Lenses of a rig that are not those of its images: radial terms that its file does not state, or that are taken out.

Calibrations without lens terms leave images at the edge several px off, and points there far off or missing. Where a
rig states no term of any camera, the radial terms k of all (`adjusted_rig` (3)) are fitted to the epipolar residuals e
of some frames, together with what turns and focal lengths explain. The fit begins with, and leaves to cameras
that say nothing, the k that is the same in all cameras and of which

    n(k) = Σ exp(−e² / 2 s²)                                                              (1)

is greatest, as far-off images make no peak of residuals. A rig without lenses, or images whose distortion was taken out
before, gains nothing: lenses are missing where k leaves clearly less variance than turns and focal lengths alone, in as
many rounds, and clearly more images meet by (1) (2): a few of a calibration that is off fit any k.
Where the rig as the file has it, with k and no other change, is clearly better in both ways as well (3), the terms were
lost on the way, and all is tracked and solved with them. Else the cameras were calibrated as if they had no lens: where
they stand and how long their lenses are makes up for a part of it, and k alone would make positions worse.

The other way round, images may be free of distortion when they come, as some programs and cameras take it out before.
Where a rig states lens terms and is clearly better in both ways without them and with no other change (4), they are
left out, and all is tracked and solved without them: they would bend straight images. A calibration that is off may
be so by chance; with turns and focal lengths fitted to either, its own lenses are then the better ones (5). Terms that
move images by less than `BENT` were not taken out of them, whatever fits better (6): of a long lens they are hardly
determined, and large by chance.

Most rigs that state no lenses have none, and k need not be fitted to say so: where turns and focal lengths alone leave
a narrow peak of residuals in all pairs of cameras, and one more step with k would take little of them (7), no lens is
missing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data import Detections, Rig
from ....data.array_types import Floats
from ....geometry import undistort
from ....numerics.finite import finite_mean, finite_median
from ..detection_index import Images, read_images
from ..following.candidate_points import fundamentals
from ..noise.epipolar_noise import camera_noise, mixture, pair_of, residuals
from ..noise.measurement_noise import sampled_frames
from .adjusted_rig import USUAL_ERROR, fitted_rig, rig_step, with_radial

USUAL_RADIAL = 0.06
"""θ₀ of k, without unit; chosen: lenses of laboratories have some -0.12 to 0.04."""

USUAL = np.append(USUAL_ERROR, USUAL_RADIAL)
"""θ₀ of turns, focal lengths and k; by definition."""

LITTLE, CLOSE = 0.03, 1.0
"""Of (7), a share of the sum of squares, and px, a standard deviation of the widest peak; chosen on scenes 147000 to
147023, 301000 to 301035 and 303000 to 303015 of the second generator, 0 to 3 px off: where lenses are missing in all
cameras or some, and peaks are as narrow, 0.058 and more would be taken, where none is mostly less than 0.02."""

LIKELY = np.arange(-0.3, 0.16, 0.03)
"""k that (1) is looked at with, without unit; chosen: wide lenses have -0.3."""

NARROW = 0.5
"""s of (1), px; chosen, as centroids are noisy."""

LESS = 0.8
"""Of (2) and (3), a ratio of variances; chosen on 20 scenes of the second generator (147000 to 147023): by (2) cameras
without a lens leave 0.88 to 1.04, those whose terms are left out 0.01 to 0.85 where images are less noisy than .4 px;
by (3) lost terms 0.04 to 0.98, and 15 of 16 rigs that were calibrated without terms 0.78 and more."""

MORE = 2.0
"""Of (2) and (3), what n of (1) gains by each camera's k, a number; chosen on scenes 148000 to 148003 of the second
generator, 0 to 3 px off: lost lenses that are known to .15 gain 2.2 and more, cameras without a lens 0.8 at most."""

BENT = 0.5
"""px by which lens terms move images of the median camera, RMS (6); chosen: wrong ones of lenses of 600 mm did by up to
0.3, those of seven scenes of the second generator by 0.3 to 1.1."""

ROUNDS = 12
"""Of the fit, chosen: a camera whose images make a peak late is as it should be after ten."""


class MissingLenses(NamedTuple):
    """Radial terms (C) of lenses of which the file states none, or 0 where the images are without those that it states
    (4); whether the rig is better with these alone, (3) or (4); the standard deviation in px that images have by the
    rig as given."""

    radial: Floats
    lost: bool
    sd: float

    def on(self, rig: Rig) -> Rig:
        """The rig by which all is tracked: with these lenses where they were lost."""
        return with_radial(rig, self.radial) if self.lost else rig


def missing_lenses(detections: Detections, rig: Rig) -> MissingLenses | None:
    """What the images tell of lenses that are not as the file states them; None where nothing is.

    Args:
        detections: of the whole recording. rig: as given.
    """
    if len(rig) < 2 or not len(detections):
        return None
    images = read_images(detections, rig)
    frames = sampled_frames(images)
    if any(camera.distortion.any() for camera in rig):
        return _taken_out(detections, images, rig, frames)
    flat = _turned(images, rig, frames)
    if _no_more_by_lenses(images, flat, frames):  # (7)
        return None
    bent = _fitted(detections, images, rig, frames)
    k = np.array([camera.distortion[0] for camera in bent])
    if not _better(detections, images, bent, flat, frames):  # (2)
        return None
    flat = _turned(images, with_radial(bent, np.zeros(len(rig))), frames)  # as the other fit may not come there
    if not _better(detections, images, bent, flat, frames):  # (2)
        return None
    lost = _better(detections, images, with_radial(rig, k), rig, frames)  # (3)
    before = _variance(images, rig, frames)
    return MissingLenses(k, lost, float(np.sqrt(before)))


def _taken_out(detections: Detections, images: Images, rig: Rig, frames: list[int]) -> MissingLenses | None:
    """No lenses, where images agree clearly better without those that the file states; else None."""
    none = np.zeros(len(rig))
    plain = with_radial(rig, none)
    if _bent(detections, rig) < BENT or not _better(detections, images, plain, rig, frames):  # (6), (4)
        return None
    straight = images.seen_by(detections, plain, frames)
    own, others = _turned(images, rig, frames), _turned(straight, plain, frames)
    if not _better(detections, images, others, own, frames, 1.0, 0.0):  # (5)
        return None
    return MissingLenses(none, True, float(np.sqrt(_variance(images, rig, frames))))


def _bent(detections: Detections, rig: Rig) -> float:
    """px by which the lens terms of the median camera move its images, RMS."""
    seen = [(camera, detections.uv[detections.camera == c]) for c, camera in enumerate(rig)]
    moved = [np.linalg.norm(undistort(camera, uv) - uv, axis=1) for camera, uv in seen if len(uv)]
    return finite_median(np.array([np.sqrt(finite_mean(off**2)) for off in moved]), 0.0)


def _fitted(detections: Detections, images: Images, rig: Rig, frames: list[int]) -> Rig:
    """The rig, its lenses fitted together with turns and focal lengths."""

    def meeting(k: float) -> float:
        return _meeting(images.seen_by(detections, _alike(rig, k), frames), rig, frames)

    likely = max(LIKELY.tolist(), key=meeting)
    begin = np.column_stack([np.zeros((len(rig), 4)), np.full(len(rig), likely)])
    return fitted_rig(lambda moved: images.seen_by(detections, moved, frames), rig, frames, begin, USUAL, ROUNDS)


def _turned(images: Images, rig: Rig, frames: list[int]) -> Rig:
    """The rig, its turns and focal lengths fitted, its lenses as they are."""
    return fitted_rig(lambda _: images, rig, frames, np.zeros((len(rig), 4)), USUAL_ERROR, ROUNDS)


def _no_more_by_lenses(images: Images, flat: Rig, frames: list[int]) -> bool:
    """(7), of a rig whose turns and focal lengths are fitted."""
    step = rig_step(images, flat, frames, np.zeros((len(flat), len(USUAL))), USUAL)
    return step.gain < LITTLE and step.sd < CLOSE


def _better(
    detections: Detections,
    images: Images,
    bent: Rig,
    flat: Rig,
    frames: list[int],
    less: float = LESS,
    more: float = MORE,
) -> bool:
    """Whether images agree better by a rig of other lenses, by variance and by (1); clearly, where nothing is said."""
    seen = images.seen_by(detections, bent, frames)
    fewer = _variance(seen, bent, frames) < less * _variance(images, flat, frames)
    return bool(fewer and _meeting(seen, bent, frames) > _meeting(images, flat, frames) + more * len(flat))


def _alike(rig: Rig, k: float) -> Rig:
    """The rig with the same radial term in all cameras."""
    return with_radial(rig, np.full(len(rig), k))


def _meeting(images: Images, rig: Rig, frames: list[int]) -> float:
    """n of (1)."""
    off = residuals(images, fundamentals(rig.P), frames).off
    return float(np.exp(-(off**2) / (2 * NARROW**2)).sum())


def _variance(images: Images, rig: Rig, frames: list[int]) -> float:
    """px², of images of the median camera by their epipolar residuals; NaN where that is not known."""
    C, some = len(rig), residuals(images, fundamentals(rig.P), frames)
    variance = camera_noise(some, mixture(some.off, pair_of(some, C), C * C, some.window), C).variance
    return finite_median(variance)
