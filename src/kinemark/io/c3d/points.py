"""What the points of a file are: names, kinds, lengths, gaps.

Plug-in Gait stores its angles, forces, moments, powers and scalars among the points and lists their labels in
POINT:ANGLES, POINT:FORCES, …; only the others are lengths, and only these are converted to mm.

A sample is missing when its fourth number is negative or NaN, when a coordinate is not finite, or, as some programs
code a gap, when a length or an angle is exactly (0, 0, 0), a length is 10^9 units away, or all integers of a point are
−32 768. (A force of exactly zero is
a foot in the air.) Where a file marks each and every sample as missing and still holds coordinates, its writer did
not know the mark, and it is ignored.

Cameras say more: where a file states which cameras saw a marker, a sample whose fourth number is 0, which no camera
saw, was filled. Where no camera is stated, a group of our own may tell (`provenance`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data import KinemarkError, Origin
from ...data.array_types import Bools, Floats
from ..units import USUAL_UNITS, mm_per
from .document import C3D, HALF
from .provenance import stated_filled

OUTPUTS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS")
LENGTH = "LENGTH"
MODELED = "MODELED_MARKERS"
FARTHEST = 1e9  # in the file's unit; farther, a sample is no position; chosen


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Points, both markers and others, of M points and F frames.

    Attributes:
        xyz: (M, F, 3) mm, or the file's unit for what is no length; NaN where missing.
        residual: (M, F) the same; NaN where missing.
        cameras: (M, F) bits.
        origin: (M, F) an `Origin` each.
    """

    xyz: Floats
    residual: Floats
    cameras: NDArray[np.uint32]
    origin: NDArray[np.uint8]


def distinct(labels: Sequence[str], count: int, blank: str) -> tuple[str, ...]:
    """`count` names that differ: blank ones become `blank` and their number, repeated ones get a [2], [3], …"""
    names: dict[str, None] = {}
    seen: dict[str, int] = {}
    for i in range(count):
        label = (labels[i] if i < len(labels) else "") or f"{blank}{i + 1}"
        name = label
        while name in names:
            seen[label] = seen.get(label, 1) + 1
            name = f"{label} [{seen[label]}]"
        names[name] = None
    return tuple(names)


def point_names(doc: C3D) -> tuple[str, ...]:
    """(M) the names of the points; `*1`, `*2`, … where the file has none."""
    return distinct(doc.texts("POINT", "LABELS"), doc.points.shape[1], "*")


def kinds_of(doc: C3D, names: Sequence[str]) -> tuple[str, ...]:
    """What each point is: LENGTH, or one of `OUTPUTS`."""
    listed = {label: kind for kind in reversed(OUTPUTS) for label in doc.texts("POINT", kind) if label}
    return tuple(listed.get(name, LENGTH) for name in names)


def modeled_points(source: Any) -> tuple[str, ...]:
    """Labels of points that are positions, but that a C3D file lists as a program's own: POINT:MODELED_MARKERS.

    POINT:TYPE_GROUPS names such lists, and may name others. Empty where the source of a trial is no C3D file.
    """
    if not isinstance(source, C3D):
        return ()
    lists = dict.fromkeys((MODELED, *source.texts("POINT", "TYPE_GROUPS")[::2]))
    return tuple(label for name in lists if name and name not in OUTPUTS for label in source.texts("POINT", name))


def mm_per_unit(doc: C3D) -> float:
    """Length of the file's unit; mm is assumed where POINT:UNITS is absent or blank.

    Raises:
        KinemarkError: the unit is not known.
    """
    unit = next(iter(doc.texts("POINT", "UNITS")), "") or "mm"
    if (mm := mm_per(unit)) is None:
        raise KinemarkError(
            f"POINT:UNITS is {unit!r}, wanted {USUAL_UNITS}. State the true one: --length-unit mm (units='mm')."
        )
    return mm


def samples_of(doc: C3D) -> Samples:
    """The points of a document."""
    kinds = np.array(kinds_of(doc, point_names(doc)), dtype=object)
    length = kinds == LENGTH
    factor = np.where(length, mm_per_unit(doc), 1.0)
    missing = _missing(doc, length, length | (kinds == "ANGLES"))
    xyz = np.ascontiguousarray((doc.points * factor[:, None]).transpose(1, 0, 2))
    residual = np.ascontiguousarray((np.maximum(doc.residual, 0) * factor).T)
    cameras = np.where(missing, 0, doc.cameras.T).astype(np.uint32)
    xyz[missing], residual[missing] = np.nan, np.nan
    origin = np.where(missing, Origin.MISSING, Origin.MEASURED).astype(np.uint8)
    filled = (doc.word.T == 0) & (cameras != 0).any(1, keepdims=True) & ~missing
    origin[filled | (stated_filled(doc, point_names(doc)) & ~missing)] = Origin.FILLED
    return Samples(xyz, residual, cameras, origin)


def _missing(doc: C3D, length: Bools, zero_is_gap: Bools) -> Bools:
    """(M, F) where a point has no position."""
    finite = np.isfinite(doc.points).all(-1)
    if not doc.floats:
        finite &= ~(doc.points == HALF * doc.scale).all(-1)
    zero = (doc.points == 0).all(-1)
    far = (np.abs(doc.points) >= FARTHEST).any(-1)
    marked = ~(doc.word >= 0)
    if marked.all() and (finite & ~zero).any():
        marked = np.zeros_like(marked)
    return np.ascontiguousarray((marked | ~finite | (zero & zero_is_gap) | (far & length)).T)
