"""Gait as CSV: curves over the stride, and of each stride its time-distance parameters and its key values.

    curves.csv          percent, then for each component mean, spread between strides, SD of measurement:
                        LKneeAngles_flexion_deg, LKneeAngles_flexion_spread, LKneeAngles_flexion_sd
    time_distance.csv   a row a stride: trial, side, first_s, last_s, then each parameter with its unit and its SD;
                        where the pelvis faces, how far it turns, and whether the stride counts in means and curves (1)
    key_values.csv      a row a value of a stride, of those that count: trial, side, first_s, name, unit, value, where
                        in the stride it is (at_percent), and the SD of measurement

A stride has the same trial, side and first_s in both tables. An empty cell is a missing value.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ..data.gait_curves import GaitCurves, KeyValue
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


def write_time_distance_csv(path: Path | str, each: Mapping[str, Sequence[Stride]]) -> None:
    """Write a row a stride.

    Args:
        path: of the table. each: the strides by the name of their trial.

    Raises:
        KinemarkError: the file cannot be written.
    """
    heading = ["trial", "side", "first_s", "last_s"]
    for name, unit in UNITS.items():
        heading += [f"{name} ({unit})", f"{name} sd"]
    heading += ["facing (deg)", "turned (deg)", "stands", "counts"]
    rows = (
        [trial, s.side, cell(s.first), cell(s.last),
         *(cell(v) for name in UNITS for v in (s.values[name], s.sd[name])),
         cell(s.facing_deg), cell(s.turned_deg), str(int(s.stands)), str(int(s.counts))]
        for trial, strides in each.items() for s in strides
    )  # fmt: skip
    write_table(path, heading, rows)


def write_key_values_csv(path: Path | str, each: Mapping[str, Sequence[KeyValue]]) -> None:
    """Write a row a value of a stride.

    Args:
        path: of the table. each: the values by the name of their trial.

    Raises:
        KinemarkError: the file cannot be written.
    """
    heading = ["trial", "side", "first_s", "name", "unit", "value", "at_percent", "sd"]
    rows = (
        [trial, v.side, cell(v.first), v.name, v.unit, cell(v.value), cell(v.at), cell(v.sd)]
        for trial, values in each.items() for v in values
    )  # fmt: skip
    write_table(path, heading, rows)
