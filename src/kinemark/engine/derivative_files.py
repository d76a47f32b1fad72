"""Velocities and accelerations of the markers of a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..data import KinemarkError
from ..data.derivatives import MarkerDerivatives
from ..data.finding import plain_value
from ..io.derivatives_csv import write_derivatives_csv
from ..io.trial import read_trial
from ..kinematics import marker_derivatives


def derivatives_of_file(
    source: Path,
    target: Path,
    *,
    rate_hz: float | None = None,
    length_unit: str | None = None,
    partial: bool = False,
) -> dict[str, Any]:
    """Write the velocities and accelerations of a file's markers; their figures, marker by marker.

    Args:
        source: a file of trajectories.
        target: the CSV file.
        rate_hz, length_unit: of a file that does not say it. partial: read what there is of a damaged one.

    Raises:
        KinemarkError: the file cannot be read, has no trajectories, or the target exists.
    """
    if target.exists():
        raise KinemarkError(f"{target} exists. Give another name, or move it away.")
    trajectories = read_trial(source, rate_hz=rate_hz, length_unit=length_unit, partial=partial).trajectories
    if trajectories is None or not len(trajectories):
        raise KinemarkError(f"{source} has no trajectories. Give a file of markers in space, as a C3D file.")
    found = marker_derivatives(trajectories)
    write_derivatives_csv(target, found, first_frame=trajectories.first_frame)
    return {
        "file": str(target),
        "rate_hz": found.rate,
        "markers": [_figures(found, m) for m in range(len(found.names))],
    }


def _figures(found: MarkerDerivatives, m: int) -> dict[str, Any]:
    """Of one marker: noise, and the median standard deviations; None where it has too few samples."""
    known = np.isfinite(found.velocity_sd[m])
    values = {"noise_mm": found.noise_sd[m]}
    for name, sd in (("velocity_sd_mm_s", found.velocity_sd), ("acceleration_sd_mm_s2", found.acceleration_sd)):
        values[name] = np.median(sd[m, known]) if known.any() else np.nan
    return {"name": found.names[m], "frames": int(known.sum())} | {
        key: plain_value(float(value)) for key, value in values.items()
    }
