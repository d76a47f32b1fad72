"""Hanging rods as TOML: `units`, `marker_diameter`, and for each rod a table `[[rod]]` with `name` and `markers`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..data import KinemarkError, Rods
from ..data.array_types import Floats
from .number_text import read_text
from .toml_text import check_keys, toml_table
from .units import USUAL_UNITS, mm_per

MOST_RODS = 16  # in a description; chosen for the speed of recognising them
MOST_MARKERS = 12  # of a rod; chosen for the speed of recognising them
BEND = 0.02  # of a rod's length by which a marker may be off its line; chosen
LARGEST = 100.0  # m; no laboratory hangs rods further apart; chosen


def read_rods(path: Path) -> Rods:
    """The rods that a file describes.

    Raises:
        KinemarkError: the file is absent, or as in `rods_from_toml`.
    """
    text = read_text(path)
    try:
        return rods_from_toml(text)
    except KinemarkError as error:
        raise KinemarkError(f"{path}: {error}") from None


def rods_from_toml(text: str) -> Rods:
    """The frame described as `units = "mm"`, `marker_diameter = 25.0`, and a `[[rod]]` each with `name` and `markers`.

    Raises:
        KinemarkError: no such description, or rods that are not straight.
    """
    table = toml_table(text, "The description of the rods")
    _check("The description of the rods", table, ("units", "marker_diameter", "rod"))
    units = table.get("units", "mm")
    if (mm := mm_per(units)) is None:
        raise KinemarkError(f"The rods' units are {units!r}, wanted {USUAL_UNITS}.")
    entries = table.get("rod")
    if not isinstance(entries, list) or not 2 <= len(entries) <= MOST_RODS:
        raise KinemarkError(f"The description must have 2 to {MOST_RODS} tables [[rod]] with a name and markers.")
    parts = [_rod(k, entry) for k, entry in enumerate(entries)]
    longest = max(len(xyz) for _, xyz in parts)
    padded = [np.pad(xyz, ((0, longest - len(xyz)), (0, 0)), constant_values=np.nan) for _, xyz in parts]
    rods = Rods(
        tuple(name for name, _ in parts),
        np.array(padded) * mm,
        _diameter(table.get("marker_diameter")) * mm,
    )
    _check_straight(rods)
    if (size := float(np.ptp(rods.xyz[rods.present], axis=0).max()) / 1000) > LARGEST:
        raise KinemarkError(
            f"The rods hang {size:.0f} m apart by their coordinates and units = {units!r}. Correct these."
        )
    return rods


def _check(where: str, table: dict[str, Any], known: tuple[str, ...]) -> None:
    try:
        check_keys(where, table, known)
    except ValueError as error:
        raise KinemarkError(f"{error}. Correct it.") from None


def _rod(k: int, entry: Any) -> tuple[str, Floats]:
    name = str(entry.get("name", k + 1)) if isinstance(entry, dict) else str(k + 1)
    if isinstance(entry, dict):
        _check(f"Rod {name}", entry, ("name", "markers"))
    try:
        xyz = np.array(entry["markers"], np.float64)
    except (KeyError, TypeError, ValueError, OverflowError):
        xyz = np.zeros(0)
    if xyz.ndim != 2 or xyz.shape[1] != 3 or not 4 <= len(xyz) <= MOST_MARKERS or not np.isfinite(xyz).all():
        raise KinemarkError(
            f"Rod {name}: markers must be 4 to {MOST_MARKERS} finite places [x, y, z] in order along it."
        )
    return name, xyz


def _diameter(value: Any) -> float:
    if value is None:
        return float("nan")
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < 1e6:
        raise KinemarkError(f"marker_diameter is {value!r}, wanted a length above 0.")
    return float(value)


def _check_straight(rods: Rods) -> None:
    for name, places, s, there in zip(rods.names, rods.xyz, rods.along, rods.present, strict=True):
        xyz, s = places[there], s[there]
        length = float(np.linalg.norm(xyz[-1] - xyz[0]))
        if not length > 0 or (np.diff(s) <= 0).any():
            raise KinemarkError(f"Rod {name}: its markers must be given in order along it.")
        foot = xyz[0] + s[:, None] * (xyz[-1] - xyz[0]) / length
        bend = np.linalg.norm(xyz - foot, axis=1)
        if bend.max() > BEND * length:
            k = int(bend.argmax())
            raise KinemarkError(
                f"Rod {name} is not straight: marker {k + 1} lies {bend[k]:.1f} mm off the line from the first to the "
                "last. Check its coordinates."
            )
