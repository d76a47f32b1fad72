"""What the tracks of a first pass tell of the cameras: a rig that fits them better."""

from __future__ import annotations

import numpy as np

from ....data import Detections, Tracks
from ..detection_index import Images, read_images
from ..following.candidate_points import fundamentals
from ..noise.measurement_noise import Noise, learn_noise
from ..points.solved_points import Working
from ..simultaneous_method import Simultaneous
from .images_beside import with_images_beside
from .rig_of_tracks import rig_of_tracks

OF_TRACKS_RATIO = 1.2
"""Of the variance that lines say with the rig before, the most that they say with the rig adjusted to tracks, where it
is used; chosen in rooms of an independent generator: of cameras in a row, or toed out, right rigs have 0.96 to 1.09, as
no two lines tell; in a ring of four one of 1.6 (seed 2216) loses samples."""

HEAVY_TAILS = 1.3
"""Times the learned variance that images have in it, as errors of centroids are not normally distributed; chosen:
gait9 has 97.8 % of the reference's samples, 97.0 without, and 97.5 with the rig as given."""


def with_noise(images: Images, method: Simultaneous) -> tuple[Images, Noise]:
    """The images with the noise that is learned of them."""
    return learn_noise(images, fundamentals(images.P), method.gate)


def of_tracks(
    detections: Detections, images: Images, held: list[Working], tracks: Tracks, method: Simultaneous
) -> tuple[Working, bool]:
    """With the rig adjusted to the points of the first pass, where the images agree better with it, which is also told.

    Lines of two cameras need not agree better, only not clearly worse: where cameras stand in a row, they do not tell.
    Noise that is stated, and that no pair of cameras contradicts, is no less by another rig. There the rig is adjusted
    where three images disagree by more than that: lines of two cameras do not tell how far one stands from the other,
    and where all stand in a row no pair of them does. So it is where points lack the images of a camera
    (`images_beside`).

    The list of the one before is empty afterwards, so that its places and the other ones are not in memory at once.
    """
    working = held.pop()
    usable, believed = working.images.usable, images.stated and not working.noise.added.any()
    before = float(np.median(working.images.variance[usable])) if len(tracks.cloud) else 0.0
    whole = with_images_beside(tracks, working.images)
    lines_tell = whole is tracks and not believed
    rig = rig_of_tracks(
        whole.cloud.detection.T, working.images, working.rig, least=np.sqrt(before) if believed else 0.0
    )
    if rig is working.rig:
        return working, False
    index, aside = working.images.by_cell, working.images.uv is not images.uv  # those of the rig as given are kept
    order, first = index.order, index.first
    del index
    working = working._replace(images=working.images.unplaced()) if aside else working
    moved, noise = with_noise(read_images(detections, rig, images.timing, other=images), method)
    if lines_tell and np.median(moved.variance[usable]) > OF_TRACKS_RATIO * before:
        del moved
        images = working.images.placed(detections, working.rig, order, first) if aside else working.images
        return working._replace(images=images), False
    del working
    of_camera = [moved.variance[usable & (moved.camera == c)] for c in range(len(rig))]
    usual = [np.median(own) if len(own) else 0.0 for own in of_camera]
    moved = moved.noisier((HEAVY_TAILS - 1) * np.array(usual))
    return Working(rig, moved.without(noise.inconsistent), noise), True
