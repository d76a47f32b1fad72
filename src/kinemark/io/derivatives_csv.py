"""Velocities and accelerations of markers as CSV: `frame, time_s`, and for each marker, an empty cell where unknown:

NAME_vx_mm_s, NAME_vy_mm_s, NAME_vz_mm_s      velocity
NAME_v_sd_mm_s                                standard deviation of each of its components
NAME_ax_mm_s2, NAME_ay_mm_s2, NAME_az_mm_s2   acceleration
NAME_a_sd_mm_s2                               standard deviation of each of its components
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..data.derivatives import MarkerDerivatives
from .csv_table import cell, write_table
from .number_text import plain

COLUMNS = ("vx_mm_s", "vy_mm_s", "vz_mm_s", "v_sd_mm_s", "ax_mm_s2", "ay_mm_s2", "az_mm_s2", "a_sd_mm_s2")
"""Of each marker, after its name."""


def write_derivatives_csv(path: Path | str, found: MarkerDerivatives, *, first_frame: int = 1) -> None:
    """Write all frames; frame and time count as C3D does, from 1 and 0 s.

    Raises:
        KinemarkError: the file cannot be written.
    """
    parts = (found.velocity, found.velocity_sd[..., None], found.acceleration, found.acceleration_sd[..., None])
    table = np.concatenate(parts, 2).transpose(1, 0, 2).reshape(found.velocity.shape[1], -1)
    heading = ["frame", "time_s", *(f"{name}_{column}" for name in found.names for column in COLUMNS)]
    rows = (
        [str(f + first_frame), plain((f + first_frame - 1) / found.rate), *map(cell, row)]
        for f, row in enumerate(table)
    )
    write_table(path, heading, rows)
