"""Files of a motion: `.da1` … and `.tdc` (UM²AS figures 3.12 and 3.17)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ...data import KinemarkError, Trajectories
from ...data import MarkerTrajectory as MarkerPath
from ...data.array_types import Floats
from .calibration_files import DECIMALS, in_order
from .tab_tables import MM, TabHeader, TabRows, camera_number, heading, read_rows, shaped, write_rows


def read_da(path: Path | str, *, markers: int | None = None) -> Floats:
    """(M, F, 2) px digitised in one camera; NaN where a marker was not seen.

    Args:
        path: ends in `.da1`, `.da2`, …
        markers: how many a frame, for a camera other than the first, whose file does not say it.

    Raises:
        KinemarkError: camera 1's header is missing or contradicts the rows or `markers`, another camera has one, or
            a row is wrong.
    """
    camera = camera_number(path, "da")
    rows = read_rows(path, 2)
    if camera > 1 and markers is None:
        raise KinemarkError(f"{path} does not say how many markers a frame has. Name .da1 too, or the number.")
    header = _header(path, rows, camera, markers)
    if markers is not None and header.markers != markers:
        raise KinemarkError(f"{path} has {header.markers} markers a frame, wanted {markers}. Name files of one motion.")
    return shaped(path, rows, header)


def read_da_set(paths: Sequence[Path | str], *, markers: int | None = None) -> tuple[Floats, tuple[int, ...]]:
    """(C, M, F, 2) px of several cameras, and their numbers; files may come in any order.

    Args:
        paths: at least one.
        markers: how many a frame; only needed without camera 1's file, which says it.

    Raises:
        ValueError: there are no files.
        KinemarkError: the cameras have different numbers of frames or markers, one comes twice, or see `read_da`.
    """
    if not paths:
        raise ValueError("paths is empty, wanted at least one .da file")
    numbered = in_order(paths, "da")
    each: list[Floats] = []
    for path in numbered.values():
        each.append(read_da(path, markers=len(each[0]) if each else markers))
        if each[-1].shape != each[0].shape:
            frames = f"{each[0].shape[1]} frames and {path} {each[-1].shape[1]}"
            raise KinemarkError(
                f"{next(iter(numbered.values()))} has {frames}, of {len(each[0])} markers each. Digitise the same "
                "frames of all cameras."
            )
    return np.stack(each), tuple(numbered)


def _header(path: Path | str, rows: TabRows, camera: int, markers: int | None) -> TabHeader:
    """The header of camera 1, or what stands for it in another camera's file."""
    if camera == 1:
        if rows.header is None:
            raise KinemarkError(
                f"{path} does not begin with the header that camera 1's file has, as "
                f"'{heading(TabHeader(2, 10))}'. Put it in, or name the file after its camera."
            )
        return rows.header
    if rows.header is not None:
        raise KinemarkError(f"{path} has a header, which only camera 1's file has. Is it copied from it?")
    assert markers is not None  # the caller has looked
    if len(rows.values) % max(markers, 1):
        raise KinemarkError(
            f"{path} has {len(rows.values)} rows, which is no whole number of frames of {markers} markers. Was it cut "
            "off, or made with other markers? Digitise it again."
        )
    return TabHeader(len(rows.values) // max(markers, 1), markers)


def write_da(path: Path | str, uv: ArrayLike) -> None:
    """Write digitised centroids (M, F, 2) px; with the header where the name is camera 1's.

    Raises:
        ValueError: uv has another shape, or is NaN in one coordinate only.
        KinemarkError: the name has no camera, or the file cannot be written.
    """
    camera = camera_number(path, "da")
    _write(path, np.asarray(uv, np.float64), "uv", 2, headed=camera == 1)


def read_tdc(path: Path | str) -> Floats:
    """(M, F, 3) mm calculated places; NaN where there is none.

    Raises:
        KinemarkError: the file is absent, has no header, or other rows than it says.
    """
    rows = read_rows(path, 3)
    if rows.header is None:
        raise KinemarkError(f"{path} does not begin with '{heading(TabHeader(2, 10))}'. Put the header in.")
    return shaped(path, rows, rows.header) * MM


def trajectories_of_tdc(path: Path | str, *, rate: float, names: Sequence[str] = ()) -> Trajectories:
    """The markers of a `.tdc` file, called 1, 2, … where no names are given; their covariance is not known.

    Args:
        path: the file.
        rate: frames a second, Hz; the file does not say it.
        names: (M) of the markers.

    Raises:
        KinemarkError: the file is wrong, or has another number of markers than names.
    """
    xyz = read_tdc(path)
    names = names or [str(m + 1) for m in range(len(xyz))]
    if len(names) != len(xyz):
        raise KinemarkError(f"{path} has {len(xyz)} markers, and {len(names)} names are given. Name each marker once.")
    return Trajectories(tuple(MarkerPath.measured(n, p) for n, p in zip(names, xyz, strict=True)), rate)


def write_tdc(path: Path | str, xyz: ArrayLike) -> None:
    """Write places (M, F, 3) mm.

    Raises:
        ValueError: xyz has another shape, or is NaN in some coordinates only.
        KinemarkError: the file cannot be written.
    """
    _write(path, np.asarray(xyz, np.float64) / MM, "xyz", 3, headed=True)


def _write(path: Path | str, values: Floats, name: str, width: int, *, headed: bool) -> None:
    """TabRows (M, F, k) frame after frame."""
    if values.ndim != 3 or values.shape[2] != width or not values.size:
        raise ValueError(f"{name} has shape {values.shape}, wanted (markers, frames, {width})")
    if (np.isnan(values).any(2) != np.isnan(values).all(2)).any():
        raise ValueError(f"{name} is NaN in some coordinates of a marker only, wanted all of them or none")
    first = heading(TabHeader(values.shape[1], values.shape[0])) if headed else None
    write_rows(path, values.transpose(1, 0, 2).reshape(-1, width), decimals=DECIMALS, heading=first)
