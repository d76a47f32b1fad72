"""What laboratories calibrate with: hanging rods, a box of control balls, a wand, a grid of dots, a thrown ball."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ..data import Rods
from .camera_placement import VOLUME
from .smooth_noise import smooth_noise
from .subjects import Capsules, Subject, pairs, stationary

SPACINGS = ((550, 200, 150, 600, 250), (350, 250, 650, 150, 350), (150, 450, 550, 150, 450), (500, 550, 250, 150, 300))
"""Gaps between the markers of each rod from its top down, mm. Perspective keeps the cross-ratios of four markers in a
row; of all gaps in steps of 50 mm these four sets keep them well apart, upside down too (by 0.29 in the logarithm).
Chosen."""


def rods_subject(rods: Rods) -> Subject:
    """The markers of rods as a subject of one frame."""
    return stationary(rods.marker_names, rods.xyz.reshape(-1, 3), radius_mm=rods.marker_diameter / 2)


def control_frame(volume: ArrayLike = VOLUME, *, marker_diameter: float = 25.0, floor_gap: float = 125.0) -> Rods:
    """Four rods hung from the ceiling at the corners of a volume, six markers each: KISS's control frame.

    Args:
        volume: (2, 3) corners of the control volume, mm; its height scales the spacings.
        marker_diameter: mm.
        floor_gap: height of the lowest markers above the floor, mm.

    Raises:
        ValueError: the volume is not higher than twice the gap.
    """
    low, high = np.asarray(volume, np.float64)
    scale = (high[2] - low[2] - 2 * floor_gap) / sum(SPACINGS[0])
    if scale <= 0:
        raise ValueError(f"the volume is {high[2] - low[2]} mm high, wanted more than twice floor_gap, {floor_gap} mm")
    corners = ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))
    xyz = np.zeros((4, 6, 3))
    for rod, corner, gaps in zip(xyz, corners, SPACINGS, strict=True):
        rod[:, :2] = corner
        rod[:, 2] = high[2] - floor_gap - scale * np.concatenate([[0.0], np.cumsum(gaps)])
    return Rods(("A", "B", "C", "D"), xyz, marker_diameter)


def calibration_box(side: float = 1000.0, *, corner: ArrayLike = (0.0, 0.0, 0.0), diameter: float = 34.0) -> Subject:
    """Eight control balls CB1 … CB8 on the tubes of a welded box (UM²AS 2.3.3), none quite at a corner.

    Args:
        side: of the box, mm.
        corner: (3) its least corner, mm.
        diameter: of the balls, mm.
    """
    places = [(2, 5, 4), (96, 3, 10), (91, 97, 2), (6, 92, 7), (5, 8, 95), (94, 6, 88), (98, 93, 97), (3, 98, 90)]
    xyz = np.asarray(corner, np.float64) + side / 100 * np.array(places, np.float64)
    return stationary(tuple(f"CB{i + 1}" for i in range(8)), xyz, radius_mm=diameter / 2)


def dot_grid(
    rows: int = 15,
    columns: int = 20,
    *,
    pitch_mm: float = 50.0,
    middle: ArrayLike = (0.0, 0.0, 0.0),
    radius_mm: float = 9.0,
) -> Subject:
    """A plane grid for linearisation, facing −Y: `rows` along Z from the top, `columns` along X (KISS 3.2: 15 × 20).

    Names are "r1c1", … in reading order for a camera that looks along +Y.

    Args:
        rows: how many.
        columns: how many.
        pitch_mm: between neighbours.
        middle: (3) of the grid, mm.
        radius_mm: of the dots, drawn as spheres.

    Raises:
        ValueError: there is no row, or no column.
    """
    if rows < 1 or columns < 1:
        raise ValueError(f"rows and columns must be at least 1, found {rows} and {columns}")
    row, col = np.mgrid[:rows, :columns].reshape(2, -1)
    across, down = pitch_mm * (col - (columns - 1) / 2), pitch_mm * (row - (rows - 1) / 2)
    xyz = np.asarray(middle, np.float64) + np.stack([across, np.zeros_like(across), -down], -1)
    names = tuple(f"r{r + 1}c{c + 1}" for r, c in zip(row, col, strict=True))
    return stationary(names, xyz, radius_mm=radius_mm)


def wand(
    positions_mm: ArrayLike = (0.0, 502.5),
    *,
    duration_s: float = 4.0,
    rate: float = 50.0,
    seed: int = 0,
    volume: ArrayLike = VOLUME,
    radius_mm: float = 12.5,
) -> Subject:
    """A stick with markers in a row, waved through a volume and turned in all directions (KISS 5.1: 502.5 mm, 4 s).

    Args:
        positions_mm: (M) of the markers W1 … WM along the stick, mm.
        duration_s: of the waving, s.
        rate: frames a second, Hz.
        seed: of the motion.
        volume: (2, 3) that all markers stay in, mm.
        radius_mm: of the markers.

    Raises:
        ValueError: the stick is longer than the volume is wide.
    """
    along = np.asarray(positions_mm, np.float64)
    along = along - (along.max() + along.min()) / 2
    room = np.asarray(volume, np.float64) + np.outer([1.0, -1.0], np.full(3, along.max() + radius_mm))
    if (room[1] < room[0]).any():
        raise ValueError(f"a stick of {np.ptp(along)} mm cannot turn in the volume {np.asarray(volume).tolist()}")
    n = max(round(duration_s * rate), 1)
    chance = smooth_noise((5, n), rate, seed, cut_hz=0.4)
    share = 0.5 + 0.5 * np.tanh(1.2 * chance[:3].T)
    centre = room[0] + share * (room[1] - room[0])
    azimuth, height = 2.0 * chance[3], np.tanh(1.5 * chance[4])
    level = np.sqrt(1 - height**2)
    direction = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), height], -1)
    names = tuple(f"W{i + 1}" for i in range(len(along)))
    xyz = centre + along[:, None, None] * direction
    links = pairs(names, *pairwise(names))
    return Subject(names, rate, xyz, np.array(radius_mm), Capsules.none(n), links)


def thrown_ball(
    *,
    start: ArrayLike = (100.0, 700.0, 900.0),
    velocity: ArrayLike = (2900.0, 0.0, 3300.0),
    gravity: float = 9806.65,
    duration_s: float = 0.72,
    rate: float = 50.0,
    radius_mm: float = 12.5,
) -> Subject:
    """A marker in free flight without air, from `start` (3) mm at `velocity` (3) mm/s, gravity in mm/s² (KISS 5.1)."""
    t = np.arange(max(round(duration_s * rate), 1))[:, None] / rate
    path = np.asarray(start, np.float64) + t * np.asarray(velocity, np.float64)
    path = path - 0.5 * gravity * t**2 * np.array([0.0, 0.0, 1.0])
    return Subject(("ball",), rate, path[None], np.array(radius_mm), Capsules.none(len(t)))
