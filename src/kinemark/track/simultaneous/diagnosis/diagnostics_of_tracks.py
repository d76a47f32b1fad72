"""What tracks of any method show of their input, as the findings of `diagnose`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....data import Detections, Finding, Rig, Tracks
from ..detection_index import read_images
from ..following.candidate_points import fundamentals
from ..following.passes import Associations
from ..noise.measurement_noise import learn_noise
from ..simultaneous_method import DEFAULT
from ..tracker import CameraTimes, TrackingResult
from .diagnostics import diagnose


def diagnose_tracks(detections: Detections, rig: Rig, tracks: Tracks) -> list[Finding]:
    """What is odd about the input of a method that says nothing of it itself; nothing where nothing is.

    Args:
        detections: what the cameras saw.
        rig: the cameras, of the same names in the same order.
        tracks: what any method made of it; points without an identity say nothing.
    """
    images = read_images(detections, rig)
    images, noise = learn_noise(images, fundamentals(images.P), DEFAULT.gate)
    own = tracks.id >= 0
    tracks = Tracks(tracks.cloud.keep(own), tracks.id[own])
    result = TrackingResult(
        tracks,
        _not_known(len(rig)),
        np.zeros(0, np.int64),
        np.zeros(0),
        [],
        images,
        noise,
        np.zeros((0, 3)),
        CameraTimes(*np.zeros((5, len(rig)))),
        rig,
    )
    return [_nobody_left_out(found) for found in diagnose(detections, rig, result)]


def _nobody_left_out(found: Finding) -> Finding:
    """The same of methods other than `Simultaneous`, which match whatever they are given."""
    if "left_out" not in found.values:
        return found
    return replace(found, values={**found.values, "left_out": False})


def _not_known(C: int) -> Associations:
    """No associations: of other methods it is not known where they looked."""
    zero, none, detection = np.zeros(0, np.int64), np.zeros(0), np.zeros((C, 0), np.int64)
    return Associations(zero, zero, detection, detection > 0, none, none, np.zeros((3, 0)), np.zeros((3, 3, 0)))
