"""Joint angles as CSV: `frame, time_s`, for each degree of freedom angle, SD and a mark, for each joint a mark.

    shoulder_flexion_deg        the angle; the name is what the joint does where it is above zero
    shoulder_flexion_sd_deg     its standard deviation
    shoulder_flexion_outside    1 where it is beyond the range of normal motion
    shoulder_locked             1 where the joint is in gimbal lock

An empty cell is a missing angle or an unknown standard deviation. Cycles have `percent` instead of frame and time, and
for each degree of freedom the mean, the SD over the cycles, and the SD of the mean by the measurement.
"""

from __future__ import annotations

from pathlib import Path

from ..data import Angles
from ..data.angles import Cycles, NamedAngle, named_angles, outside
from ..data.models import Model
from .csv_table import cell, write_table
from .number_text import plain


def column(model: Model, one: NamedAngle) -> str:
    """`shoulder_flexion`: what the columns of a degree of freedom begin with."""
    return f"{model.joints[one.joint].name} {one.motion.positive}".replace(" ", "_")


def write_angles_csv(path: Path | str, angles: Angles, model: Model, *, first_frame: int = 1) -> None:
    """Write all frames; frame and time count as C3D does, from 1 and 0 s.

    Raises:
        KinemarkError: the file cannot be written.
    """
    free, sd, out = named_angles(model), angles.sd, outside(angles, model)
    heading = ["frame", "time_s"]
    for one in free:
        heading += [column(model, one) + end for end in ("_deg", "_sd_deg", "_outside")]
    heading += [f"{joint}_locked".replace(" ", "_") for joint in angles.joints]
    rows = []
    for f in range(angles.deg.shape[1]):
        row = [str(f + first_frame), plain((f + first_frame - 1) / angles.rate)]
        for j, t, _ in free:
            row += [cell(angles.deg[j, f, t]), cell(sd[j, f, t]), str(int(out[j, f, t]))]
        rows.append(row + [str(int(flag)) for flag in angles.locked[:, f]])
    write_table(path, heading, rows)


def write_cycles_csv(path: Path | str, cycles: Cycles, model: Model) -> None:
    """Write mean and spread over the cycles, 0 to 100 %.

    Raises:
        KinemarkError: the file cannot be written.
    """
    free = named_angles(model)
    heading = ["percent"]
    for one in free:
        heading += [column(model, one) + end for end in ("_mean_deg", "_sd_deg", "_noise_deg")]
    parts = (cycles.mean, cycles.spread, cycles.noise)
    rows = [[str(k), *(cell(part[j, k, t]) for j, t, _ in free for part in parts)] for k in range(cycles.mean.shape[1])]
    write_table(path, heading, rows)
