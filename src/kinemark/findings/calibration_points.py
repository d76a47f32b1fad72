"""The figures of a calibration's control points, and of its wand."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..calibrate.quality import Evidence
from ..data import Rig
from ..data.array_types import Floats
from .plain import mean, quantile, rms

CELLS = 3
"""Of the volume along each axis, in which the wand's length is judged; chosen (see studies/calibration_quality.py)."""
MOST_POINTS = 500
"""Points that are listed one by one; chosen (see studies/calibration_quality.py)."""


def control_point_figures(rig: Rig, evidence: Evidence) -> list[dict[str, Any]]:
    """The control points, the largest residual first."""
    off = np.linalg.norm(evidence.residual, axis=-1)
    out = evidence.left_out if evidence.left_out.size else np.full(off.shape, np.nan)
    rows = [_point(rig, evidence, off[:, n], out[:, n], n) for n in range(len(evidence.names))]
    return sorted(rows, key=lambda row: -np.nan_to_num(row["left_out_rms_px"], nan=row["residual_rms_px"]))[
        :MOST_POINTS
    ]


def _point(rig: Rig, evidence: Evidence, off: Floats, out: Floats, n: int) -> dict[str, Any]:
    known = np.isfinite(off)
    largest = int(np.nan_to_num(off, nan=-1.0).argmax())
    return {
        "name": evidence.names[n],
        "xyz_mm": evidence.xyz[n],
        "cameras": int(known.sum()),
        "residual_rms_px": rms(off),
        "max_camera": rig.names[largest] if known.any() else None,
        "max_px": off[largest],
        "left_out_rms_px": rms(out),
        "left_out_mm": evidence.left_out_mm[n] if len(evidence.left_out_mm) else None,
        "not_used_by": [name for c, name in enumerate(rig.names) if known[c] and not evidence.kept[c, n]],
    }


def wand_figures(evidence: Evidence, volume: Floats) -> dict[str, Any] | None:
    """The wand's lengths as poses that took no part give them, over all and by place."""
    if not len(evidence.known):
        return None
    off = evidence.lengths - evidence.known
    return {
        "known_mm": evidence.known,
        "poses": int(np.isfinite(off).any(1).sum()),
        **_length_errors(off),
        "by_place": _by_place(off, evidence.place, volume),
        "samples": _samples(off, evidence.place),
    }


def _length_errors(off: Floats) -> dict[str, Any]:
    finite = off[np.isfinite(off)]
    return {
        "error_mean_mm": mean(off),
        "error_sd_mm": float(finite.std()) if len(finite) else None,
        "error_rms_mm": rms(off),
        "error_abs_mean_mm": mean(np.abs(off)),
        "error_95_mm": quantile(np.abs(off), 0.95),
    }


def _by_place(off: Floats, place: Floats, volume: Floats) -> list[dict[str, Any]]:
    """Mean and RMS error in each of 3 × 3 × 3 cells of the volume in which the wand was."""
    inside = (place - volume[0]) / (volume[1] - volume[0])
    known = np.isfinite(inside).all(1) & np.isfinite(off).any(1)
    cell = np.clip(np.floor(np.nan_to_num(inside) * CELLS), 0, CELLS - 1).astype(int)
    rows = []
    for index in np.unique(cell[known], axis=0):
        here = known & (cell == index).all(1)
        middle = volume[0] + (index + 0.5) / CELLS * (volume[1] - volume[0])
        rows.append({"middle_mm": middle, "poses": int(here.sum()), **_length_errors(off[here])})
    return rows


def _samples(off: Floats, place: Floats) -> dict[str, Any]:
    """At most so many poses, for the figure: where the wand was and the error of its whole length."""
    whole = off.sum(1)
    known = np.flatnonzero(np.isfinite(place).all(1) & np.isfinite(whole))
    known = known[:: max(1, -(-len(known) // MOST_POINTS))]
    return {"place_mm": place[known], "error_mm": whole[known]}
