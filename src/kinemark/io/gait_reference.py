"""A band of reference curves of gait, as JSON.

    {"source": "our controls 2026", "subjects": 12,
     "curves": {"KneeAngles": {"mean": [[flexion, adduction, rotation], … 101 rows], "sd": [[…], …]}, …}}

Further keys, as of age, speed or licence, are kept out of the computing and may stand there.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats
from ..data.gait_curves import GaitReference
from .files import replacing
from .number_text import read_text

POINTS = 101
"""Of a curve, 0 to 100 % of the stride; conventional."""


def write_reference(path: Path | str, reference: GaitReference) -> None:
    """Write a band.

    Raises:
        KinemarkError: the file cannot be written.
    """
    curves = {name: {"mean": _rows(reference.mean[name]), "sd": _rows(reference.sd[name])} for name in reference.mean}
    table = {"source": reference.source, "subjects": reference.subjects, "curves": curves}
    with replacing(path) as beside:
        beside.write_text(json.dumps(table, allow_nan=False) + "\n", encoding="utf-8")


def read_reference(path: Path | str) -> GaitReference:
    """A band.

    Raises:
        KinemarkError: the file is absent, no JSON, or no such band.
    """
    table = read_json(path)
    try:
        curves = {name: (_curve(one["mean"]), _curve(one["sd"])) for name, one in table["curves"].items()}
        found = str(table["source"]), int(table["subjects"])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise KinemarkError(
            f"{path} is no reference band ({error}). Make one: kinemark gait-reference CONTROL/gait.json … -o band.json"
        ) from None
    return GaitReference(
        {name: mean for name, (mean, _) in curves.items()}, {n: sd for n, (_, sd) in curves.items()}, *found
    )


def control_curves(path: Path | str) -> dict[str, Floats]:
    """(101, A) mean curves by name of a subject's `gait.json`.

    Raises:
        KinemarkError: the file is absent or no such file.
    """
    try:
        return {one["name"]: _curve(one["mean"]) for one in read_json(path)["curves"] if one["axes"][0] != "envelope"}
    except (KeyError, TypeError, ValueError) as error:
        raise KinemarkError(
            f"{path} is no gait.json of kinemark gait ({error}). Run it on the control first."
        ) from None


def read_json(path: Path | str) -> Any:
    """What a JSON file holds.

    Raises:
        KinemarkError: it is absent or no JSON.
    """
    try:
        return json.loads(read_text(path))
    except ValueError as error:
        raise KinemarkError(f"{path} is no JSON: {error}.") from None


def _rows(curve: Floats) -> list[list[float | None]]:
    return [[round(float(v), 5) if np.isfinite(v) else None for v in row] for row in curve]


def _curve(rows: Any) -> Floats:
    """(101, A), NaN where it is null."""
    curve = np.array(rows, dtype=np.float64)
    if curve.ndim != 2 or len(curve) != POINTS:
        raise ValueError(f"a curve of shape {curve.shape}, wanted ({POINTS}, components)")
    return curve
