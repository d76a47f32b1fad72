"""Where cameras may stand, and what they look at.

The floor is the bottom of the control volume. A camera stands at a height above it, at a level distance d from the
volume's outline, in a direction θ seen from its middle: at the place q = m + t (cos θ, sin θ) with t such that

    √(max(|q_x − m_x| − a, 0)² + max(|q_y − m_y| − b, 0)²) = d           (1)

for a volume of 2a × 2b. It is level (its sides upright) and looks at one of a few points inside the volume. All such
cameras together are the candidates, from which `placement` chooses.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..data import Camera, KinemarkError
from ..data.array_types import Floats
from ..synth import look_at

DIRECTIONS = 36
"""Directions from the middle of the volume in which a camera may stand; chosen: 10° apart."""
LEVELS = 3
"""Heights, and distances, that are tried between the limits; chosen."""
ALONG = (0.25, 0.5, 0.75)
"""Where a camera aims, as shares of the volume's longer level side; chosen."""
UP = (0.25, 0.5)
"""The same, of its height; chosen: most markers of a person are in the lower half of what a person needs."""
BISECTIONS = 50
"""Steps that solve (1) to rounding; by definition: 2⁻⁵⁰ of the farthest."""


@dataclass(frozen=True, slots=True)
class Sensor:
    """The lens and sensor of each camera to be placed.

    Attributes:
        focal_px: focal length, px.
        size: width and height of the image, px.
        least_px: diameter of a marker's image below which it is not detected, px.
    """

    focal_px: float = 1300.0
    size: tuple[int, int] = (1280, 1024)
    least_px: float = 2.5

    def __post_init__(self) -> None:
        if not (self.focal_px > 0 and min(self.size) >= 16 and self.least_px >= 0):
            raise KinemarkError(
                f"The focal length is {self.focal_px} px, the image {self.size} px and the least image of a marker "
                f"{self.least_px} px; wanted a positive focal length, at least 16 px a side, and no negative number."
            )


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """What cameras look at, and where they may stand.

    Attributes:
        volume: (2, 3) least and greatest corner of the control volume, mm; its bottom is the floor.
        height_mm: least and greatest height of a camera above the floor.
        distance_mm: least and greatest level distance of a camera from the volume's outline.
        walls: (2, 2) least and greatest x and y of the room, mm; infinite where there is no limit.
    """

    volume: NDArray[np.float64]
    height_mm: tuple[float, float] = (1000.0, 2600.0)
    distance_mm: tuple[float, float] = (1500.0, 4000.0)
    walls: NDArray[np.float64] = field(default_factory=lambda: np.array([[-np.inf] * 2, [np.inf] * 2]))

    def __post_init__(self) -> None:
        object.__setattr__(self, "volume", np.asarray(self.volume, np.float64).reshape(2, 3))
        object.__setattr__(self, "walls", np.asarray(self.walls, np.float64).reshape(2, 2))
        low, high = self.volume
        if not (np.isfinite(self.volume).all() and (high > low).all()):
            raise KinemarkError(
                f"The volume from {low.tolist()} to {high.tolist()} mm is empty. Give its least corner first, then the "
                "greatest: x y z x y z."
            )
        for name, (least, most) in (("height", self.height_mm), ("distance", self.distance_mm)):
            if not (0 <= least <= most < np.inf):
                raise KinemarkError(
                    f"The {name} of cameras is {least:g} to {most:g} mm. Give two lengths, the lesser first, none "
                    "negative."
                )
        if not (self.walls[1] > self.walls[0]).all():
            raise KinemarkError(
                f"The room's walls are {self.walls.tolist()} mm. Give least x and y, then the greatest."
            )

    @property
    def longer(self) -> int:
        """The level axis along which the volume is longer: 0 for x, 1 for y."""
        width = self.volume[1] - self.volume[0]
        return int(width[1] > width[0])

    def places(self) -> Floats:
        """(P, 3) mm where a camera may stand; none twice.

        Raises:
            KinemarkError: the walls leave no place.
        """
        turn = np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS
        heights = self.volume[0, 2] + np.unique(np.linspace(*self.height_mm, LEVELS))
        rings = [self._ring(turn, d) for d in np.unique(np.linspace(*self.distance_mm, LEVELS))]
        level = np.concatenate(rings)
        level = level[((level >= self.walls[0]) & (level <= self.walls[1])).all(1)]
        if not len(level):
            raise KinemarkError(
                f"No camera can stand {self.distance_mm[0]:g} mm or more outside the volume within the walls "
                f"{self.walls.tolist()} mm. Let cameras be nearer, or move the walls."
            )
        return np.array([[x, y, z] for (x, y), z in itertools.product(level, heights)])

    def _ring(self, turn: Floats, d: float) -> Floats:
        """(T, 2) mm by (1)."""
        middle, half = self.volume[:, :2].mean(0), (self.volume[1, :2] - self.volume[0, :2]) / 2
        ahead = np.stack([np.cos(turn), np.sin(turn)], -1)
        low, high = np.zeros(len(turn)), np.full(len(turn), float(np.hypot(*half)) + d)
        for _ in range(BISECTIONS):
            t = (low + high) / 2
            inside = np.linalg.norm(np.maximum(np.abs(t[:, None] * ahead) - half, 0.0), axis=1) < d
            low, high = np.where(inside, t, low), np.where(inside, high, t)
        return np.asarray(middle + high[:, None] * ahead)

    def targets(self) -> Floats:
        """(T, 3) mm the points that a camera may aim at."""
        low, width = self.volume[0], self.volume[1] - self.volume[0]
        found = []
        for along, up in itertools.product(ALONG, UP):
            part = np.array([0.5, 0.5, up])
            part[self.longer] = along
            found.append(low + part * width)
        return np.array(found)


def candidates(room: Room, sensor: Sensor) -> Iterator[tuple[int, Camera]]:
    """The cameras that may be chosen, each with the index of its place in `room.places()`."""
    targets = room.targets()
    for p, place in enumerate(room.places()):
        for target in targets:
            if np.linalg.norm(target - place) > 0:
                yield p, look_at("candidate", place, target, focal_px=sensor.focal_px, size=sensor.size)
