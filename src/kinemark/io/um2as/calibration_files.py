"""Files of a calibration: `.msr`, `.cp1` … and `.rf1` … (UM²AS figures 3.5 and 3.9)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...data import KinemarkError
from ...data.array_types import Floats
from ..number_text import bad_line, read_text, wanted_number
from .tab_tables import ABSENT, MM, camera_number, read_rows, write_lines, write_rows

N_PARAMETERS = 11  # of a camera; of the format (UM²AS eq. 2.4)
DECIMALS = 7  # of a parameter; of the format (UM²AS, table 4.2)
PER_LENGTH = np.array([MM, MM, MM, 1, MM, MM, MM, 1, MM, MM, MM])
"""What a parameter for mm is multiplied by to be one for the files' cm; by definition."""

DATE = re.compile(r"\s*YEAR:\s*(\d{2}|\d{4})\s+MONTH:\s*(\d{1,2})\s+DAY:\s*(\d{1,2})\s*", re.IGNORECASE)
CENTURY = 1980
"""Two digits mean the hundred years from here: 92 is 1992."""


class Parameters(NamedTuple):
    """L (11,), px and mm; and when camera 1's file was made, None for other cameras."""

    L: Floats
    made: date | None


def read_msr(path: Path | str) -> Floats:
    """(N, 3) mm where the control balls were measured, ball 1 first.

    Raises:
        KinemarkError: the file is absent or has other rows than three numbers.
    """
    rows = read_rows(path, 3, absent=False)
    if rows.header:
        raise KinemarkError(f"{path} has the header of a .tdc file, and .msr files have none. Name another file.")
    return rows.values * MM


def write_msr(path: Path | str, xyz: ArrayLike) -> None:
    """Write places (N, 3) mm, no more digits than they have up to 1e-7 cm.

    Raises:
        ValueError: the places have another shape or are not finite.
        KinemarkError: the file cannot be written.
    """
    xyz = np.asarray(xyz, np.float64)
    if xyz.ndim != 2 or xyz.shape[1] != 3 or not len(xyz) or not np.isfinite(xyz).all():
        raise ValueError(f"xyz has shape {xyz.shape}, wanted (balls, 3), all finite")
    write_lines(path, ["\t".join(map(_short, row)) for row in (xyz / MM).tolist()])


def _short(value: float) -> str:
    """A number without zeros at its end, but for one."""
    text = f"{value:.{DECIMALS}f}".rstrip("0")
    return text + "0" if text.endswith(".") else text


def read_cp(path: Path | str) -> Parameters:
    """The eleven parameters of one camera.

    Raises:
        KinemarkError: the file is absent or has other lines than eleven numbers; the date is absent from camera 1's
            file, no date, or stands in another camera's.
    """
    camera = camera_number(path, "cp")
    lines = [(n, text) for n, text in enumerate(read_text(path).splitlines(), 1) if text.strip()]
    made = None
    if camera == 1:
        made = _date(path, *lines[0]) if lines else None
        lines = lines[1:]
    elif lines and DATE.fullmatch(lines[0][1]):
        raise bad_line(path, lines[0][0], "a date, which only camera 1's file has. Is this a copy of a .cp1?")
    values = [_parameter(path, n, text) for n, text in lines]
    if len(values) != N_PARAMETERS:
        raise KinemarkError(f"{path} has {len(values)} parameters, wanted {N_PARAMETERS}, one a line. Calibrate again.")
    return Parameters(np.array(values) / PER_LENGTH, made)


def _date(path: Path | str, line: int, text: str) -> date:
    """The date of camera 1's file."""
    found = DATE.fullmatch(text)
    if not found:
        raise bad_line(path, line, f"{text.strip()!r}, wanted camera 1's date, as YEAR: 92 MONTH: 11 DAY: 27")
    year, month, day = map(int, found.groups())
    try:
        return date(year if year > 99 else CENTURY + (year - CENTURY) % 100, month, day)
    except ValueError as error:
        raise bad_line(path, line, f"{text.strip()!r} is no date: {error}") from None


def _parameter(path: Path | str, line: int, text: str) -> float:
    try:
        value = wanted_number(text)
    except ValueError:
        raise bad_line(path, line, f"{text.strip()!r}, wanted one calibration parameter") from None
    if not np.isfinite(value):
        raise bad_line(path, line, f"{text.strip()!r} is not finite. Calibrate again.")
    return value


def write_cp(path: Path | str, L: ArrayLike, *, made: date | None = None) -> None:
    """Write the parameters (11,), px and mm, of the camera whose number the name has; the date into camera 1's only.

    Args:
        path: ends in `.cp1`, `.cp2`, …
        L: the parameters; seven decimals are kept.
        made: when; needed for camera 1.

    Raises:
        ValueError: L has another shape, is not finite, or camera 1's date is missing.
        KinemarkError: the name has no camera, or the file cannot be written.
    """
    L = np.asarray(L, np.float64)
    if L.shape != (N_PARAMETERS,) or not np.isfinite(L).all():
        raise ValueError(f"L has shape {L.shape}, wanted ({N_PARAMETERS},), all finite")
    lines = [f"{value:.{DECIMALS}f}" for value in (L * PER_LENGTH).tolist()]
    if camera_number(path, "cp") == 1:
        if made is None:
            raise ValueError("made is None, wanted the date that camera 1's file has")
        year = f"{made.year % 100:02d}" if 0 <= made.year - CENTURY < 100 else f"{made.year:04d}"
        lines.insert(0, f"YEAR: {year} MONTH: {made.month} DAY: {made.day}")
    write_lines(path, lines)


def read_cp_set(paths: Sequence[Path | str]) -> tuple[Floats, tuple[int, ...]]:
    """(C, 11) parameters, px and mm, and the cameras' numbers, of files that may come in any order.

    Raises:
        KinemarkError: a camera comes twice, or see `read_cp`.
    """
    numbered = in_order(paths, "cp")
    return np.array([read_cp(path).L for path in numbered.values()]).reshape(-1, N_PARAMETERS), tuple(numbered)


def in_order(paths: Sequence[Path | str], letters: str) -> dict[int, Path]:
    """{camera's number: file}, in the order of the cameras.

    Raises:
        KinemarkError: a camera comes twice.
    """
    found: dict[int, Path] = {}
    for path in paths:
        camera = camera_number(path, letters)
        if camera in found:
            raise KinemarkError(f"{found[camera]} and {path} are both of camera {camera}. Name one a camera.")
        found[camera] = Path(path)
    return dict(sorted(found.items()))


def files_of_set(path: Path | str, letters: str) -> list[Path]:
    """All cameras' files of the set that one of them belongs to: the same name, in the same folder.

    Raises:
        KinemarkError: the name has no camera, or the file is not there.
    """
    camera_number(path, letters)
    path = Path(path)
    found = [
        p for p in path.parent.glob("*") if p.stem == path.stem and re.fullmatch(rf"\.{letters}\d+", p.suffix.lower())
    ]
    if path not in found:
        raise KinemarkError(f"{path} is not a file. Check the path.")
    return list(in_order(found, letters).values())


def read_rf(path: Path | str) -> Floats:
    """(2,) px where the reference marker was when the camera was calibrated.

    Raises:
        KinemarkError: the file is absent, has other than one row of two numbers, or says that it was not seen.
    """
    camera_number(path, "rf")
    rows = read_rows(path, 2)
    if rows.header or len(rows.values) != 1:
        raise KinemarkError(f"{path} has {len(rows.values)} rows, wanted one: U and V of the reference marker.")
    if np.isnan(rows.values).any():
        raise KinemarkError(f"{path} says {ABSENT:g}: the reference marker was not seen. Digitise it again.")
    return np.asarray(rows.values[0])


def write_rf(path: Path | str, uv: ArrayLike) -> None:
    """Write the reference marker's place (2,) px.

    Raises:
        ValueError: it is not two finite numbers.
        KinemarkError: the name has no camera, or the file cannot be written.
    """
    uv = np.asarray(uv, np.float64)
    if uv.shape != (2,) or not np.isfinite(uv).all():
        raise ValueError(f"uv is {uv}, wanted two finite numbers")
    camera_number(path, "rf")
    write_rows(path, uv[None], decimals=DECIMALS)
