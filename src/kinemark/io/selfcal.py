"""Folders of MultiCamSelfCal (Svoboda, Martinec & Pajdla 2005): one marker waved before several cameras.

    points.dat          three rows a camera, u, v and 1; a column a moment
    IdMat.dat           a row a camera; 1 where it saw the marker
    Res.dat             a row a camera, width and height
    camera_order.txt    names, a line a camera; may be absent
    NAME1.rad …         K11 … K33 and kc1 … kc4 (k1 k2 p1 p2) of a linearisation; may be absent
    camera1.Pmat.cal …  projections of a calibration, for pixels freed of the lens by the .rad; may be absent

Numbers stay as they are: pixels count from where the file counts, and the world's unit is the file's. Lines that begin
with # are Octave's headings.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..data import Camera, KinemarkError
from ..data.array_types import Floats, Ints
from .number_text import bad_line, numbers, read_text, whole

MOST_CAMERAS = 1024  # in a file; chosen, lest a broken file take memory


class SelfCal(NamedTuple):
    """What a folder holds.

    names (C); sizes (C, 2) px; uv (C, N, 2) px, NaN where a camera did not see the marker; lenses (C) with K and
    distortion of the .rad files, in no place (R = I, t = 0), or None; P (C, 3, 4) of the .Pmat.cal files, or None.
    """

    names: tuple[str, ...]
    sizes: Ints
    uv: Floats
    lenses: tuple[Camera, ...] | None
    P: Floats | None


def read_selfcal(folder: Path | str) -> SelfCal:
    """The points of a folder and, where they are there, lenses and projections.

    Raises:
        KinemarkError: a file is absent or is not as above; the message has its name and line.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise KinemarkError(f"{folder} is no folder. Name the folder that holds points.dat, IdMat.dat and Res.dat.")
    sizes, lines = _table(folder / "Res.dat")
    if sizes.shape[1] != 2 or not 0 < len(sizes) <= MOST_CAMERAS or not (sizes >= 1).all():
        raise KinemarkError(f"{folder / 'Res.dat'}: wanted width and height of each camera, px")
    size = np.stack([whole(folder / "Res.dat", lines, column, "a size") for column in sizes.T], 1)
    uv = _points(folder, len(size))
    names = _names(folder / "camera_order.txt", len(size))
    return SelfCal(names, size, uv, _lenses(folder, names, size), _projections(folder, len(size)))


def read_rad(path: Path | str) -> tuple[Floats, Floats]:
    """K (3, 3) and k1 k2 p1 p2 k3 (5,) of a .rad file.

    Raises:
        KinemarkError: the file is absent, or an entry is missing or no number.
    """
    found = {}
    for k, line in enumerate(read_text(path).splitlines(), 1):
        if line.strip() and not line.lstrip().startswith("#"):
            entry = re.fullmatch(r"\s*(\w{1,16})\s*=\s*(\S{1,64})\s*", line)
            if not entry:
                raise bad_line(path, k, f"wanted NAME = NUMBER, found {line.strip()[:40]!r}")
            found[entry[1]] = float(numbers(path, [k], [[entry[2]]], 1)[0, 0])
    wanted = [f"K{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)] + [f"kc{i}" for i in (1, 2, 3, 4)]
    missing = [name for name in wanted if not np.isfinite(found.get(name, np.nan))]
    if missing:
        raise KinemarkError(f"{path} has no {', '.join(missing)}. Check that it is a .rad file of K and kc.")
    K = np.array([found[name] for name in wanted[:9]]).reshape(3, 3)
    if abs(K[2, 2] - 1) > 1e-9 or K[0, 0] * K[1, 1] == 0 or K[1, 0] or K[2, 0] or K[2, 1]:
        raise KinemarkError(f"{path}: K must be upper triangular with focal lengths and K33 = 1, found {K.tolist()}")
    return K, np.array([found[name] for name in wanted[9:]] + [found.get("kc5", 0.0)])


def read_pmat(path: Path | str) -> Floats:
    """P (3, 4) of a .Pmat.cal file.

    Raises:
        KinemarkError: the file is absent or has not three rows of four numbers.
    """
    P, _ = _table(Path(path))
    if P.shape != (3, 4) or not np.isfinite(P).all():
        raise KinemarkError(f"{path} has {P.shape[0]} rows of {P.shape[1]} numbers, wanted three of four")
    return P


def _points(folder: Path, cameras: int) -> Floats:
    table, _ = _table(folder / "points.dat")
    seen, _ = _table(folder / "IdMat.dat")
    wanted = (3 * cameras, seen.shape[1])
    if table.shape != wanted or len(seen) != cameras:
        raise KinemarkError(
            f"{folder}: points.dat has {table.shape[0]} rows of {table.shape[1]}, IdMat.dat {seen.shape[0]} of "
            f"{seen.shape[1]}; Res.dat names {cameras} cameras, so {wanted[0]} rows and {cameras} rows are wanted, as "
            "many columns in both."
        )
    uv = table.reshape(cameras, 3, -1)[:, :2].transpose(0, 2, 1)
    return np.where((seen > 0)[..., None], uv, np.nan)


def _names(path: Path, cameras: int) -> tuple[str, ...]:
    if not path.is_file():
        return tuple(f"camera{c + 1}" for c in range(cameras))
    names = tuple(line.strip() for line in read_text(path).splitlines() if line.strip())
    if len(names) != cameras or len(set(names)) != cameras:
        raise KinemarkError(f"{path} has {len(names)} names, wanted a different one for each of {cameras} cameras")
    return names


def _lenses(folder: Path, names: tuple[str, ...], sizes: Ints) -> tuple[Camera, ...] | None:
    paths = _numbered(folder, r".*?(\d{1,4})\.rad", len(names))
    if paths is None:
        return None
    found = (read_rad(path) for path in paths)
    return tuple(
        Camera(name, size, K, np.eye(3), np.zeros(3), k) for name, size, (K, k) in zip(names, sizes, found, strict=True)
    )


def _projections(folder: Path, cameras: int) -> Floats | None:
    paths = _numbered(folder, r"camera(\d{1,4})\.Pmat\.cal", cameras)
    return None if paths is None else np.array([read_pmat(path) for path in paths])


def _numbered(folder: Path, pattern: str, cameras: int) -> list[Path] | None:
    """The files whose names end in 1 … C; None where there is none at all."""
    matches = [(re.fullmatch(pattern, path.name), path) for path in sorted(folder.iterdir())]
    found = {int(match[1]): path for match, path in matches if match}
    if not found:
        return None
    missing = [c for c in range(1, cameras + 1) if c not in found]
    if missing:
        raise KinemarkError(
            f"{folder} has files for cameras {sorted(found)}, and none for {missing}. Add them, or remove all."
        )
    return [found[c] for c in range(1, cameras + 1)]


def _table(path: Path) -> tuple[Floats, list[int]]:
    """A table of numbers between spaces, and the number of each line."""
    rows = [
        (k, line.split())
        for k, line in enumerate(read_text(path).splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not rows:
        raise KinemarkError(f"{path} has no numbers. Check the path.")
    lines = [k for k, _ in rows]
    return numbers(path, lines, [cells for _, cells in rows], len(rows[0][1])), lines
