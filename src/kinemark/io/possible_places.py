"""Places in a file that cannot be, or hardly in the unit that was read: told, and no calculation meets them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data import Trajectories, Trial
from ..data.array_types import Floats
from .c3d import C3D
from .c3d.points import FARTHEST

LEAST_MARKERS = 5
"""Fewer may lie as near to each other as they like, as on a tool; chosen."""
NARROWEST_MM, WIDEST_MM = 10.0, 1e5
"""What so many markers span at least and at most; chosen: a person in metres read as mm spans 2, one in mm read as
metres a million, a hand 150."""
FRAMES = 200
"""So many frames are looked at; chosen for time."""


def with_possible_places(trial: Trial) -> Trial:
    """The trial without samples farther than 1000 km, mm, and with notes of these and of a span that tells another
    unit. Where nothing is odd it is the same record."""
    notes = list(trial.notes)
    trajectories, far = _near(trial.trajectories)
    far += _left_out(trial)
    if far:
        samples = "1 sample is" if far == 1 else f"{far} samples are"
        notes.append(f"{samples} farther than 1000 km, which is no place; they are missing")
    if text := _unit_doubt(trajectories):
        notes.append(text)
    return trial if len(notes) == len(trial.notes) else replace(trial, trajectories=trajectories, notes=tuple(notes))


def _near(trajectories: Trajectories) -> tuple[Trajectories, int]:
    """Those within reach, and how many samples are not."""
    far = [np.asarray((np.abs(path.xyz) > FARTHEST).any(1)) for path in trajectories]
    count = int(sum(rows.sum() for rows in far))
    if not count:
        return trajectories, 0
    paths = [
        path.only(np.asarray(~rows, np.bool_)) if rows.any() else path
        for path, rows in zip(trajectories, far, strict=True)
    ]
    return replace(trajectories, paths=tuple(paths)), count


def _left_out(trial: Trial) -> int:
    """How many finite samples of the markers a C3D file states farther away; its reader gives them as missing."""
    if not isinstance(trial.source, C3D) or not len(trial.trajectories):
        return 0
    points = trial.source.points
    return int((np.isfinite(points).all(-1) & (np.abs(points) >= FARTHEST).any(-1)).sum())


def _unit_doubt(trajectories: Trajectories) -> str:
    """That the markers lie too near or too far from each other for the unit, and what to state; "" if not."""
    if len(trajectories) < LEAST_MARKERS or not trajectories.n_frames:
        return ""
    span = _span(trajectories.xyz[:, :: -(-trajectories.n_frames // FRAMES)])
    if NARROWEST_MM <= span <= WIDEST_MM or not span > 0:
        return ""
    wrong, right = ("m", "mm") if span > WIDEST_MM else ("mm", "m")
    return (
        f"the markers are {span:.3g} mm apart from end to end, as if {right} were read as {wrong}: if so, state the "
        f"unit with --length-unit {right}"
    )


def _span(xyz: Floats) -> float:
    """The longest side of the box about the markers (M, F, 3), median of the frames that have enough; NaN if none."""
    seen = xyz[:, np.isfinite(xyz).all(-1).sum(0) >= LEAST_MARKERS]
    if not seen.size:
        return float("nan")
    return float(np.median((np.nanmax(seen, 0) - np.nanmin(seen, 0)).max(-1)))
