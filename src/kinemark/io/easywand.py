"""Calibrations of easyWand (Theriault et al. 2014): the digitised wand, its length, cameras before and after the fit.

A MAT file with one structure `easyWandData`. wandPts has a row a frame: u, v of end 1 in every camera, then of end 2;
backgroundPts single points of unknown places, axisPts points of the world's axes or a thrown object. nlin are k1, k2,
p1, p2, k3 a camera, about ppts, for focalLengths; coefs are DLT coefficients of undistorted pixels, in metres.
Pixels stay as they are in the file: from which corner and number they count is not said there.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..data import Camera, KinemarkError
from ..data.array_types import Floats, Ints
from .mat5 import read_mat5

MOST_CAMERAS = 64  # in a file; chosen, lest a broken file take memory


class EasyWand(NamedTuple):
    """C cameras, F frames of a wand.

    Attributes:
        wand: (C, F, 2, 2) both ends, px; NaN where not digitised or taken out by the user.
        background: (C, N, 2) single points, px; NaN as above.
        axis: (C, A, 2) points of the axes, or of a thrown object, px; NaN where not digitised.
        length: of the wand, mm.
        sizes: (C, 2) px.
        start: (C) the lenses that easyWand began with; their places are not set.
        lenses: (C) those it ended with.
        dlt: (C, 11) its result, for ideal pixels and mm.
    """

    wand: Floats
    background: Floats
    axis: Floats
    length: float
    sizes: Ints
    start: tuple[Camera, ...]
    lenses: tuple[Camera, ...]
    dlt: Floats


def read_easywand(path: Path | str) -> EasyWand:
    """The calibration in a MAT file of easyWand.

    Raises:
        KinemarkError: the file is absent or damaged, or no finished calibration of easyWand.
    """
    easy = read_mat5(path).get("easyWandData")
    if not isinstance(easy, dict):
        raise KinemarkError(f"{path} has no structure easyWandData. Save the calibration with easyWand.")
    widths = _numbers(path, easy, "imageWidth", None)
    n = len(widths)
    if not 0 < n <= MOST_CAMERAS:
        raise KinemarkError(f"{path} has {n} image widths, wanted one a camera. Save it with easyWand again.")
    given = np.column_stack([widths, _numbers(path, easy, "imageHeight", n)])
    length = float(_numbers(path, easy, "wandLen", 1)[0]) * 1000.0
    if not (np.isfinite(given).all() and (given > 0).all() and (given < 1e6).all() and 0 < length < np.inf):
        raise KinemarkError(f"{path}: image sizes {given.tolist()} and a wand of {length} mm cannot be. Correct them.")
    sizes = given.astype(np.int64)
    dlt = _numbers(path, easy, "coefs", 11 * n).reshape(n, 11)
    dlt[:, [0, 1, 2, 4, 5, 6, 8, 9, 10]] /= 1000.0  # per mm
    return EasyWand(
        _points(path, easy, "wandPts", n, 2).transpose(2, 0, 1, 3),
        _points(path, easy, "backgroundPts", n, 1)[:, 0].transpose(1, 0, 2),
        _points(path, easy, "axisPts", n, 1)[:, 0].transpose(1, 0, 2),
        length,
        sizes,
        _lenses(path, easy, sizes, ("estFocalLengths", "pp_est", "nlin_est")),
        _lenses(path, easy, sizes, ("focalLengths", "ppts", "nlin")),
        dlt,
    )


def _numbers(path: Path | str, easy: dict[str, Any], name: str, n: int | None) -> Floats:
    """All numbers of a field, in MATLAB's order."""
    value = easy.get(name)
    if not isinstance(value, np.ndarray) or (n is not None and value.size != n):
        found = f"{value.size} numbers" if isinstance(value, np.ndarray) else type(value).__name__
        raise KinemarkError(f"{path}: {name} is {found}, wanted {n or 'numbers'}. Finish the calibration in easyWand.")
    return np.asarray(value.ravel(order="F"), np.float64)


REMOVED = {"wandPts": "rmpts", "backgroundPts": "bkrmpts"}


def _points(path: Path | str, easy: dict[str, Any], name: str, n: int, k: int) -> Floats:
    """(F, k, C, 2) points; none where the field is empty."""
    value = easy.get(name)
    if value is None or (isinstance(value, np.ndarray) and value.size == 0):
        return np.zeros((0, k, n, 2))
    if not isinstance(value, np.ndarray) or value.ndim != 2 or value.shape[1] != 2 * k * n:
        raise KinemarkError(f"{path}: {name} has not {2 * k * n} columns for {n} cameras. Save it with easyWand again.")
    points = value.reshape(-1, k, n, 2).copy()
    removed = easy.get(REMOVED.get(name, ""))
    if isinstance(removed, np.ndarray) and removed.size == len(points) * k:
        points[removed.reshape(len(points), k) != 0] = np.nan
    points[~np.isfinite(points).all(-1)] = np.nan
    return points


def _lenses(path: Path | str, easy: dict[str, Any], sizes: Ints, names: tuple[str, str, str]) -> tuple[Camera, ...]:
    n = len(sizes)
    focal, centre, terms = (_numbers(path, easy, name, k * n) for name, k in zip(names, (1, 2, 5), strict=True))
    if not (np.isfinite(terms).all() and np.isfinite(centre).all() and (np.abs(focal) > 0).all()):
        raise KinemarkError(f"{path}: {', '.join(names)} are no lenses. Finish the calibration in easyWand.")
    cameras = []
    for c in range(n):
        K = np.array([[focal[c], 0.0, centre[2 * c]], [0.0, focal[c], centre[2 * c + 1]], [0.0, 0.0, 1.0]])
        cameras.append(Camera(f"cam{c + 1}", sizes[c], K, np.eye(3), np.zeros(3), terms[5 * c : 5 * c + 5]))
    return tuple(cameras)
