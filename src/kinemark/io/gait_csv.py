"""Gait as CSV: curves over the stride, and time-distance parameters of each stride.

    curves.csv          percent, then for each component mean, spread between strides, SD of measurement:
                        LKneeAngles_flexion_deg, LKneeAngles_flexion_spread, LKneeAngles_flexion_sd
    time_distance.csv   a row a stride: side, first_s, last_s, then each parameter with its unit and its SD

An empty cell is a missing value.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from ..data.gait_curves import GaitCurves
from ..data.strides import UNITS, Stride
from .files import replacing
from .number_text import plain


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
    _write(path, heading, ([str(t), *(_cell(column[t]) for column in columns)] for t in range(n)))


def write_time_distance_csv(path: Path | str, strides: Sequence[Stride]) -> None:
    """Write a row a stride.

    Raises:
        KinemarkError: the file cannot be written.
    """
    heading = ["side", "first_s", "last_s"]
    for name, unit in UNITS.items():
        heading += [f"{name} ({unit})", f"{name} sd"]
    rows = (
        [s.side, _cell(s.first), _cell(s.last), *(_cell(v) for name in UNITS for v in (s.values[name], s.sd[name]))]
        for s in strides
    )
    _write(path, heading, rows)


def _cell(value: float) -> str:
    """Six decimals; empty where it is missing."""
    return plain(round(float(value), 6)) if np.isfinite(value) else ""


def _write(path: Path | str, heading: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    with replacing(path) as beside, beside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heading)
        writer.writerows(rows)
