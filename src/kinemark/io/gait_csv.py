"""Gait as CSV: curves over the stride, and time-distance parameters of each stride.

    curves.csv          percent, then for each component mean, spread between strides, SD of measurement:
                        LKneeAngles_flexion_deg, LKneeAngles_flexion_spread, LKneeAngles_flexion_sd
    time_distance.csv   a row a stride: side, first_s, last_s, then each parameter with its unit and its SD; where
                        the pelvis faces, how far it turns, and whether the stride counts in means and curves (1)

An empty cell is a missing value.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..data.gait_curves import GaitCurves
from ..data.strides import UNITS, Stride
from .csv_table import cell, write_table


def write_curves_csv(path: Path | str, curves: Sequence[GaitCurves]) -> None:
    """Write mean, spread and measurement SD, 0 to 100 % of the stride.

    Raises:
        KinemarkError: the file cannot be written.
    """
    heading, columns = ["percent"], []
    for one in curves:
        for k, axis in enumerate(one.axes):
            name = f"{one.name}_{axis}".replace(" ", "_")
            heading += [f"{name}_{one.unit}", f"{name}_spread", f"{name}_sd"]
            columns += [part[:, k] for part in (one.mean, one.spread, one.measurement_sd)]
    n = max((len(column) for column in columns), default=0)
    write_table(path, heading, ([str(t), *(cell(column[t]) for column in columns)] for t in range(n)))


def write_time_distance_csv(path: Path | str, strides: Sequence[Stride]) -> None:
    """Write a row a stride.

    Raises:
        KinemarkError: the file cannot be written.
    """
    heading = ["side", "first_s", "last_s"]
    for name, unit in UNITS.items():
        heading += [f"{name} ({unit})", f"{name} sd"]
    heading += ["facing (deg)", "turned (deg)", "counts"]
    rows = (
        [s.side, cell(s.first), cell(s.last), *(cell(v) for name in UNITS for v in (s.values[name], s.sd[name])),
         cell(s.facing_deg), cell(s.turned_deg), str(int(s.counts))]
        for s in strides
    )  # fmt: skip
    write_table(path, heading, rows)
