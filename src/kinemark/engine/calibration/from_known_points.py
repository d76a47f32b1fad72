"""Cameras from a ready-made file, from control points or from a control frame: places that were surveyed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...calibrate.control_frame import control_frame_quality
from ...calibrate.control_points import ControlFit, control_point_quality, judge_control_points
from ...calibrate.quality import Evidence
from ...data import KinemarkError, Rig
from ...data.array_types import Floats, Ints
from ...geometry import cameras_from_dlt
from ...io.control_points import read_control_points
from ...io.dlt_csv import read_dlt_csv
from ...io.rig_toml import read_rig_toml
from ...io.rods_toml import read_rods
from ...io.tdf import read_tdf
from ...io.um2as import files_of_set, read_cp_set
from ...io.units import MM
from ..recordings import size_of_cameras
from ..settings import DigitisedPoints, TargetRecording
from .lens_grids import Lenses, lenses_of
from .task import RigWithEvidence, Task


def from_file(task: Task) -> RigWithEvidence:
    """A ready-made calibration."""
    s, file = task.settings, task.root / str(task.settings.calibration.file)
    unit = s.calibration.length_unit
    if file.suffix.lower() == ".tdf":
        found = read_tdf(file, parts=("rig",)).rig
        if found is None:
            raise KinemarkError(f"{file} has no calibration. Name the file of the session's calibration.")
        rig = found
    elif file.suffix.lower() == ".csv":
        rig = rig_of_dlt(file, s.cameras.names, unit)
    elif is_cp(file):
        if unit not in (None, "cm"):
            raise KinemarkError(f"{file} is in cm, and length_unit says {unit}. Leave length_unit out.")
        rig = rig_of_cp(files_of_set(file, "cp"), names=s.cameras.names)
    else:
        rig = read_rig_toml(file, unit)
    if s.cameras.names:
        if missing := [name for name in s.cameras.names if name not in rig.names]:
            have, lack = ", ".join(rig.names), ", ".join(missing)
            raise KinemarkError(f"{file} has cameras {have}, not {lack}. Correct names in [cameras].")
        rig = rig.select(s.cameras.names)
    return RigWithEvidence(rig, Evidence(way=f"the file {file.name}"))


def rig_of_dlt(file: Path, names: Sequence[str], unit: str | None) -> Rig:
    """A rig from eleven parameters a camera, whose unit of length the file does not say.

    Raises:
        KinemarkError: no unit is given, or the file has another number of cameras than there are names.
    """
    if unit is None:
        raise KinemarkError(f"{file} does not say its unit of length. Set length_unit in [calibration].")
    L = read_dlt_csv(file)
    names = names or tuple(f"cam{c + 1}" for c in range(len(L)))
    if len(names) != len(L):
        raise KinemarkError(f"{file} has {len(L)} columns and [cameras] {len(names)} names. Name one a column.")
    mm = MM[unit]
    scaled = L / np.array([mm, mm, mm, 1, mm, mm, mm, 1, mm, mm, mm])
    return Rig(cameras_from_dlt(names, scaled), f"DLT of {file.name}")


def is_cp(path: Path) -> bool:
    """Whether a file is one of UM²AS's calibration parameters, `.cp1`, `.cp2`, …"""
    return path.suffix.lower().startswith(".cp") and path.suffix[3:].isdecimal()


def rig_of_cp(files: Sequence[Path | str], *, names: Sequence[str] = ()) -> Rig:
    """A rig from UM²AS's `.cp` files, one a camera, called cam1, cam2, … by their numbers where no names are given.

    Raises:
        KinemarkError: a file is wrong, a camera comes twice, or there are not as many names.
    """
    L, numbers = read_cp_set(files)
    names = names or [f"cam{n}" for n in numbers]
    if len(names) != len(numbers):
        raise KinemarkError(f"There are {len(numbers)} .cp files and {len(names)} names of cameras. Name one each.")
    return Rig(cameras_from_dlt(names, L), f"DLT of {', '.join(Path(file).name for file in files)}")


def from_control_points(task: Task) -> RigWithEvidence:
    """Points at surveyed places, pointed at by an operator."""
    way = task.settings.calibration.control_points
    assert way is not None  # the settings see to it
    points, uv, xyz, cov, sizes = digitised(task, way)
    lenses = lenses_of(task)
    method: Any = task.settings.calibrate
    fit = control_point_quality(
        task.names,
        sizes,
        xyz,
        uv,
        cov=cov,
        method=method,
        lenses=lenses.cameras,
        diameter=way.marker_diameter_mm,
        points=points,
    )
    return _of_control_points(fit, f"{len(xyz)} control points", lenses)


class Pointed(NamedTuple):
    """Control points as an operator pointed at them: names (N), uv (C, N, 2), xyz (N, 3), cov, sizes (C, 2)."""

    names: tuple[str, ...]
    uv: Floats
    xyz: Floats
    cov: Floats | None
    sizes: Ints


def digitised(task: Task, way: DigitisedPoints) -> Pointed:
    """Control points of a CSV file, at the markers of the images where there are images."""
    seen = task.recorded(TargetRecording(images=way.images), "calibrate") if way.images else None
    file = task.root / way.points
    points = read_control_points(file, task.names, seen.detections if seen else None)
    sizes = seen.sizes if seen else size_of_cameras(task.root, task.settings, task.names)
    return Pointed(points.names, points.uv, points.xyz, points.cov, sizes)


def from_control_frame(task: Task) -> RigWithEvidence:
    """Hanging rods of markers."""
    way = task.settings.calibration.control_frame
    assert way is not None
    rods = read_rods(task.root / way.rods)
    seen = task.recorded(TargetRecording(images=way.images), "calibrate")
    lenses = lenses_of(task)
    method: Any = task.settings.calibrate
    fit = control_frame_quality(seen.detections, rods, sizes=seen.sizes, method=method, lenses=lenses.cameras)
    return _of_control_points(fit, f"a control frame of {len(fit.points)} markers", lenses)


def _of_control_points(fit: ControlFit, way: str, lenses: Lenses) -> RigWithEvidence:
    """The evidence of a fit to points at known places."""
    return RigWithEvidence(
        fit.rig,
        Evidence(
            way=way,
            names=fit.points,
            xyz=fit.xyz,
            uv=fit.uv,
            residual=fit.residual,
            kept=fit.kept,
            left_out=np.linalg.norm(fit.left_out_error, axis=-1),
            left_out_mm=np.linalg.norm(fit.left_out_xyz, axis=-1),
            freedom=int(fit.freedom.sum()),
            straight=lenses.straight,
            findings=lenses.findings,
            judged=judge_control_points(fit),
        ),
    )
