"""A band of reference curves of gait, as JSON or TOML.

    {"source": "our controls 2026", "subjects": 12,
     "log_score": [mean, deviation],
     "numbers": {"speed": [mean, deviation], "knee flexion at strike": [mean, deviation], …},
     "curves": {"KneeAngles": {"axes": ["flexion", "adduction", "rotation"], "mean": [[…], … 101 rows], "sd": [[…], …]},
                …}}

In TOML likewise: `source`, `subjects`, and a table `[curves.KneeAngles]` with `mean` and `sd`, `nan` where unknown. The
`axes` may be absent but of ground reactions, which once were along those of the laboratory. The
`log_score`, of the controls' own profile scores, and `numbers`, time-distance parameters and key values in the units of
`gait.json` (mm, mm/s, s, deg), may be absent. Further keys, as of age, speed or licence, are kept out
of the computing and may stand there.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats
from ..data.gait_curves import GaitReference
from ..data.strides import UNITS
from ..data.subject_measures import SIDES
from .files import write_text
from .number_text import read_text
from .toml_text import toml_table

POINTS = 101
"""Of a curve, 0 to 100 % of the stride; conventional."""


def write_reference(path: Path | str, reference: GaitReference) -> None:
    """Write a band.

    Raises:
        KinemarkError: the file cannot be written.
    """
    curves: dict[str, dict[str, Any]] = {
        name: {"mean": _rows(reference.mean[name]), "sd": _rows(reference.sd[name])} for name in reference.mean
    }
    for name, axes in reference.axes.items():
        curves.get(name, {})["axes"] = axes
    table = {"source": reference.source, "subjects": reference.subjects, "curves": curves}
    if reference.log_score is not None:
        table["log_score"] = reference.log_score
    if reference.numbers:
        table["numbers"] = dict(reference.numbers)
    write_text(path, json.dumps(table, allow_nan=False) + "\n")


def read_reference(path: Path | str) -> GaitReference:
    """A band.

    Raises:
        KinemarkError: the file is absent, neither JSON nor TOML, or no such band.
    """
    table = toml_table(read_text(path), str(path)) if Path(path).suffix.lower() == ".toml" else read_json(path)
    try:
        curves = {name: (_curve(one["mean"]), _curve(one["sd"])) for name, one in table["curves"].items()}
        found = str(table["source"]), int(table["subjects"]), _pair(table.get("log_score"))
        axes = {str(name): tuple(map(str, one["axes"])) for name, one in table["curves"].items() if "axes" in one}
        numbers = {str(name): _number(name, pair) for name, pair in table.get("numbers", {}).items()}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise KinemarkError(
            f"{path} is no reference band ({error}). Make one: kinemark gait-reference CONTROL/gait.json … -o band.json"
        ) from None
    return GaitReference(
        {name: mean for name, (mean, _) in curves.items()},
        {n: sd for n, (_, sd) in curves.items()},
        *found,
        numbers,
        axes,
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


def control_axes(paths: Sequence[Path | str]) -> dict[str, tuple[str, ...]]:
    """What the components of each curve of subjects' `gait.json` are called, by its name.

    Raises:
        KinemarkError: a file is absent or no such file, or two call them otherwise.
    """
    found: dict[str, tuple[str, ...]] = {}
    for path in paths:
        try:
            own = {one["name"]: tuple(one["axes"]) for one in read_json(path)["curves"]}
        except (KeyError, TypeError) as error:
            raise KinemarkError(f"{path} is no gait.json of kinemark gait ({error}).") from None
        for name, axes in own.items():
            if found.setdefault(name, axes) != axes:
                raise KinemarkError(
                    f"{name} has the components {', '.join(axes)} in {path}, and {', '.join(found[name])} in another "
                    "file: one was made by an earlier version. Run kinemark gait on it again."
                )
    return found


def control_numbers(path: Path | str) -> dict[str, list[float]]:
    """Time-distance parameters and key values of a subject's `gait.json`: the means of the sides that have one.

    Raises:
        KinemarkError: the file is absent or no such file.
    """
    table = read_json(path)
    try:
        sides = {name: [table["time_distance"][s][name] for s in SIDES] for name in UNITS}
        sides |= {key["name"]: [key[side] for side in SIDES] for key in table.get("key_values", [])}
        means = {name: [one["mean"] for one in both if one is not None] for name, both in sides.items()}
        return {name: [float(x) for x in both if x is not None] for name, both in means.items()}
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
    except (ValueError, RecursionError) as error:
        raise KinemarkError(f"{path} is no JSON: {error}.") from None


def _pair(value: Any) -> tuple[float, float] | None:
    if value is None:
        return None
    mean, sd = (float(x) for x in value)
    if not (np.isfinite(mean) and sd > 0):
        raise ValueError(f"log_score is {value}, wanted a mean and a deviation above 0")
    return mean, sd


def _number(name: str, value: Any) -> tuple[float, float]:
    """Mean and deviation of one number."""
    mean, sd = (float(x) for x in value)
    if not (np.isfinite(mean) and sd >= 0):
        raise ValueError(f"{name} is {value}, wanted a mean and a deviation of 0 or more")
    return mean, sd


def _rows(curve: Floats) -> list[list[float | None]]:
    return [[round(float(v), 5) if np.isfinite(v) else None for v in row] for row in curve]


def _curve(rows: Any) -> Floats:
    """(101, A), NaN where it is null."""
    curve = np.array(rows, dtype=np.float64)
    if curve.ndim != 2 or len(curve) != POINTS:
        raise ValueError(f"a curve of shape {curve.shape}, wanted ({POINTS}, components)")
    return curve
