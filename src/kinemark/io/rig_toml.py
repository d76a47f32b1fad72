"""Rigs as TOML, in the layout shared by anipose, caliscope and Pose2Sim.

One table a camera: name, size (px), matrix, distortions (OpenCV's k1 k2 p1 p2 k3), rotation (a Rodrigues vector,
world → camera) and translation. `[metadata]` says the unit of length and how the rig came about. What the shared layout
has no place for (the rotation's last digits, covariance, volume) stands below `[kinemark]`, which others ignore.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from ..data import Camera, KinemarkError, Rig
from ..data.array_types import Floats
from .files import write_text
from .number_text import read_text
from .toml_tables import tables_text
from .toml_text import toml_table
from .units import CALLERS, USUAL_UNITS, mm_per

NOT_CAMERAS = ("metadata", "kinemark")
OF_CAMERAS = ("matrix", "rotation", "translation")
SAME_TURN = 1e-9  # of a rotation's entries; closer, the file's angles are of this matrix; conventional: rounding
LARGEST = 1e100  # what may be squared without overflow; chosen
MOST_CAMERAS = 1024  # in a file; chosen, lest a broken file take memory


def read_rig_toml(path: Path | str, length_unit: str | None = None) -> Rig:
    """The rig of a calibration file; translations become mm.

    Args:
        path: the file.
        length_unit: "mm", "cm", "m" or "in", for a file whose `[metadata]` does not say `units`.

    Raises:
        ValueError: `length_unit` is another word.
        KinemarkError: the file is no TOML, has no cameras, no unit, or a camera that the model cannot express.
    """
    if length_unit is not None and length_unit not in CALLERS:
        raise ValueError(f"length_unit is {length_unit!r}, wanted {USUAL_UNITS}")
    document = toml_table(read_text(path), str(path))
    metadata, ours = (table if isinstance(table := document.get(k, {}), dict) else {} for k in NOT_CAMERAS)
    own = {k: v for k, v in document.items() if isinstance(v, dict) and k not in NOT_CAMERAS}
    tables = {k: v for k, v in own.items() if any(key in v for key in OF_CAMERAS)}  # one that lacks some is told below
    if "calibration" in document and "trials" in document:
        raise KinemarkError(
            f"{path} is a session, not a file of cameras or a trial. Give a file that it names or made."
        )
    if not 0 < len(tables) <= MOST_CAMERAS:
        raise KinemarkError(
            f"{path} has {len(tables)} cameras, wanted tables with `matrix`, `rotation`, `translation`."
        )
    scale = unit_of(path, metadata, length_unit)
    try:
        cameras = tuple(camera(f"{path}, [{k}]", k, v, table_of(ours, k), scale) for k, v in tables.items())
        volume = (
            array(f"{path}, [kinemark]", ours, "volume_mm", (2, 3)) if "volume_mm" in ours else np.full((2, 3), np.nan)
        )
        return Rig(cameras, str(metadata.get("method", "")), volume)
    except ValueError as error:
        raise KinemarkError(f"{path}: {error}. Correct the file or calibrate again.") from error


def unit_of(path: Path | str, metadata: Mapping[str, Any], length_unit: str | None) -> float:
    """mm in the unit that the file or the caller states; not two different ones."""
    stated = metadata.get("units")
    unit = stated if stated is not None else length_unit
    if unit is None:
        raise KinemarkError(
            f"{path} does not say the unit of its translations. Set `length_unit` in [calibration], or --length-unit, "
            f"to {USUAL_UNITS}."
        )
    mm = mm_per(unit)
    if mm is None or (length_unit is not None and mm_per(length_unit) != mm):
        raise KinemarkError(
            f"{path} states units = {stated!r}, wanted {length_unit or USUAL_UNITS}. "
            "Correct the file, or `length_unit` in [calibration]."
        )
    return mm


def table_of(own: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """The sub-table of `[kinemark]` for one camera; empty where there is none."""
    table = own.get(key, {})
    return table if isinstance(table, dict) else {}


def camera(where: str, key: str, table: Mapping[str, Any], own: Mapping[str, Any], scale: float) -> Camera:
    """One camera from its table and our own beside it."""
    if table.get("fisheye") not in (None, False):
        raise KinemarkError(f"{where}: fisheye lenses are not supported. Calibrate with the ordinary lens model.")
    R = scipy.spatial.transform.Rotation.from_rotvec(array(where, table, "rotation", (3,))).as_matrix()
    if "rotation_matrix" in own:
        exact = array(where, own, "rotation_matrix", (3, 3))
        # an edited Rodrigues vector counts; the matrix only adds the digits that the vector lost
        R = exact if np.abs(exact - R).max() < SAME_TURN else R
    size = array(where, table, "size", (2,)) if "size" in table else np.zeros(2)
    if (size < 0).any() or (size > 2**31).any() or (size != np.floor(size)).any():
        raise KinemarkError(f"{where}: size is {size.tolist()}, wanted width and height in whole pixels.")
    return Camera(
        name=str(table.get("name", key)),
        size=size.astype(np.int64),
        K=array(where, table, "matrix", (3, 3)),
        R=R,
        t=array(where, table, "translation", (3,)) * scale,
        distortion=distortion(where, table),
        cov=array(where, own, "covariance", (15, 15)) if "covariance" in own else np.zeros((15, 15)),
        residual=float(array(where, own, "residual_px", ())) if "residual_px" in own else np.nan,
        common=array(where, own, "common_errors", None) if "common_errors" in own else np.zeros((15, 0)),
    )


def distortion(where: str, table: Mapping[str, Any]) -> Floats:
    """(5,) k1 k2 p1 p2 k3 from four or five terms; further ones only if they are zero."""
    terms = array(where, table, "distortions", None) if "distortions" in table else np.zeros(5)
    if terms.ndim != 1 or len(terms) < 4 or terms[5:].any():
        raise KinemarkError(f"{where}: distortions are {terms.tolist()}, wanted k1 k2 p1 p2 or k1 k2 p1 p2 k3.")
    return np.concatenate([terms, [0.0]])[:5]


def array(where: str, table: Mapping[str, Any], key: str, shape: tuple[int, ...] | None) -> Floats:
    """The numbers of one key, of this shape; finite unless it is a residual or volume, where NaN means unknown."""
    try:
        values = np.array(table[key], np.float64)
    except (KeyError, ValueError, TypeError, OverflowError) as error:
        raise KinemarkError(
            f"{where}: {key} is {table.get(key, 'absent')!r}, wanted numbers. Calibrate again."
        ) from error
    if shape is not None and values.shape != shape:
        raise KinemarkError(f"{where}: {key} has shape {values.shape}, wanted {shape}.")
    if key not in ("residual_px", "volume_mm") and not (np.abs(values) < LARGEST).all():
        raise KinemarkError(f"{where}: {key} is not finite or too large: {values.tolist()}. Calibrate again.")
    return values


def write_rig_toml(path: Path | str, rig: Rig, *, metadata: Mapping[str, Any] | None = None) -> None:
    """Write a rig so that `read_rig_toml` gives back the same one, to the last bit.

    Args:
        path: of the file.
        rig: the cameras.
        metadata: texts and numbers for people and other programs, into `[metadata]`; they are not read back.

    Raises:
        KinemarkError: the file cannot be written.
    """
    residuals = [camera.residual for camera in rig]
    about = {"units": "mm", "method": rig.method, "residuals_px": residuals, **(metadata or {})}
    document = {f"cam_{c}": shared(camera) for c, camera in enumerate(rig)} | {"metadata": about}
    document["kinemark"] = {"volume_mm": rig.volume} | {f"cam_{c}": own(camera) for c, camera in enumerate(rig)}
    write_text(path, tables_text(plain(document)))


def shared(camera: Camera) -> dict[str, Any]:
    """The table that all programs share."""
    return {
        "name": camera.name,
        "size": camera.size,
        "matrix": camera.K,
        "distortions": camera.distortion,
        "rotation": scipy.spatial.transform.Rotation.from_matrix(camera.R).as_rotvec(),
        "translation": camera.t,
        "fisheye": False,
    }


def own(camera: Camera) -> dict[str, Any]:
    """The table that only Kinemark reads."""
    table = {"rotation_matrix": camera.R, "residual_px": camera.residual, "covariance": camera.cov}
    return table | ({"common_errors": camera.common} if camera.common.size else {})


def plain(value: Any) -> Any:
    """Arrays, in tables or alone, as lists, with every digit."""
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
