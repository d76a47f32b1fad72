"""The body that walks through the volume while cameras are planned for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from ..data import KinemarkError
from ..data.array_types import Floats
from ..synth import Subject, walking, with_markers
from ..synth.subjects import Capsules
from .room import Room

MOST_MARKERS = 100
"""On the body; chosen: whole-body sets have 39 to 60, and finding places for many more takes long."""
FRAMES = 12
"""Instants of each passage that are looked at; chosen."""
SPEED_MM_S = 1100.0
"""Of the pelvis; chosen: that of `synth.walking`."""


def walks(
    room: Room, *, diameter_mm: float, height_mm: float = 1730.0, markers: int = 15, frames: int = FRAMES
) -> tuple[Subject, Subject]:
    """A person who walks along the longer side of the volume, in its middle, once in each direction.

    Args:
        room: the volume; its bottom is the floor.
        diameter_mm: of the markers.
        height_mm: of the person.
        markers: how many: the first of the fifteen of the lower limbs, or these and more on all limbs.
        frames: of each passage, spread over the volume.

    Raises:
        KinemarkError: a measure is not positive, or so many markers do not fit on the body.
    """
    if not (diameter_mm > 0 and height_mm > 0 and 1 <= markers <= MOST_MARKERS and frames >= 1):
        raise KinemarkError(
            f"The marker's diameter is {diameter_mm:g} mm, the subject {height_mm:g} mm high with {markers} markers; "
            f"wanted more than nothing of each, and at most {MOST_MARKERS} markers."
        )
    low, high = room.volume
    duration = (high - low)[room.longer] / SPEED_MM_S
    walker = walking(
        duration_s=duration, rate=frames / duration, speed_mm_s=SPEED_MM_S, height_mm=height_mm,
        marker_radius_mm=diameter_mm / 2, middle=(0.0, 0.0),
    )  # fmt: skip
    try:
        walker = with_markers(walker, markers)
    except ValueError as error:
        raise KinemarkError(f"{error}. Ask for fewer markers.") from error
    floor = np.array([*((low + high) / 2)[:2], low[2]])
    turn = 90.0 * room.longer
    return _moved(walker, turn, floor, room), _moved(walker, turn + 180.0, floor, room)


def _moved(subject: Subject, turn_deg: float, floor: Floats, room: Room) -> Subject:
    """Turned about the vertical and put on the floor (3) mm; markers outside the volume are not there."""
    R = scipy.spatial.transform.Rotation.from_euler("z", turn_deg, degrees=True).as_matrix()
    xyz = subject.xyz @ R.T + floor
    inside = ((xyz >= room.volume[0]) & (xyz <= room.volume[1])).all(-1)
    limbs = subject.capsules
    placed = Capsules(limbs.names, limbs.a @ R.T + floor, limbs.b @ R.T + floor, limbs.radius)
    return replace(subject, xyz=np.where(inside[..., None], xyz, np.nan), capsules=placed)
