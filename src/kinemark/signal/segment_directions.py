"""Directions of segments between markers, and their component angles (Swamidas 1997, 3.33 to 3.35)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats, Ints


class LinkedSegments(NamedTuple):
    """S segments: link (S, 2) markers, bank (S) number of the rigid body, length and spread (S) mm."""

    link: Ints
    bank: Ints
    length: Floats
    spread: Floats


def directions(xyz: Floats, link: Ints) -> Floats:
    """(S, F, 3) unit vectors of segments (S, 2) between paths (M, F, 3) (3.34), NaN where an end is missing."""
    way = np.empty((len(link), 3, xyz.shape[1]))  # each by itself, and axes as rows: small and fast
    with np.errstate(invalid="ignore", divide="ignore"):
        for own, (a, b) in zip(way, link, strict=True):
            np.subtract(xyz[b].T, xyz[a].T, out=own)
            own *= 1 / np.sqrt(own[0] ** 2 + own[1] ** 2 + own[2] ** 2)
    return way.swapaxes(1, 2)


def component_angles(direction: Floats) -> Floats:
    """The angles with the axes x, y and z (3.35) of unit vectors (…, 3), deg."""
    return np.degrees(np.arccos(np.clip(direction, -1.0, 1.0)))
