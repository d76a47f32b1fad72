"""Before and after, barefoot and shod: what `kinemark gait-compare` does."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...data import KinemarkError
from ...data.array_types import Floats
from ...data.strides import UNITS
from ...data.subject_measures import LETTER, SIDES, Side
from ...findings.plain import plain
from ...gait.comparison import LEAST_POINTS, Condition, Difference, difference, stretches
from ...gait.key_values import KEYS, Key
from ...io.csv_table import cell, write_table
from ...io.files import write_json
from ...io.gait_reference import control_axes, read_json
from ...report.drawing_library import assets_for
from ...report.gait_comparison_page import ComparedCurve, write_comparison_page
from ...version import __version__
from .files import FIGURES


class GaitComparison(NamedTuple):
    """The figures of a comparison, and where the files are."""

    figures: dict[str, Any]
    folder: Path


def compare_gait(
    first: Path, second: Path, *, folder: Path, same_markers: bool = False, self_contained: bool = False
) -> GaitComparison:
    """Read the figures of two conditions, and write what differs beyond its error: a page, CSV and JSON.

    Args:
        first, second: `gait.json` of each condition, or its folder.
        folder: of the results.
        same_markers: they stayed on the subject in between, with one static trial: what is systematic is in both alike.
        self_contained: the page holds the drawing library.

    Raises:
        KinemarkError: a file is no gait.json, both are one, they are of other methods or along other axes, or the
            folder cannot be written.
    """
    paths = tuple(path / FIGURES if path.is_dir() else path for path in (first, second))
    if paths[0].resolve() == paths[1].resolve():
        raise KinemarkError(f"{first} is compared with itself. Give two conditions.")
    tables = tuple(_read(path) for path in paths)
    if tables[0]["method"] != tables[1]["method"]:
        raise KinemarkError(
            f"{first} and {second} were computed otherwise ({tables[0]['method']} and {tables[1]['method']}), so that "
            "differences would be the methods'. Run kinemark gait on both with the same settings."
        )
    control_axes(paths)  # raises where they differ
    curves = _curves(tables, same_markers)
    figures = plain(
        {
            "kinemark": __version__,
            "conditions": [_about(path, table) for path, table in zip(paths, tables, strict=True)],
            "same_markers": same_markers,
            "without_uncertainty": [p.parent.name for p, t in zip(paths, tables, strict=True) if not t["uncertainty"]],
            "time_distance": [row for side in SIDES for row in _parameters(tables, side, same_markers)],
            "key_values": _keys(tables, same_markers),
            "curves": [_row(one) for one in curves],
        }
    )
    folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / "comparison.json", figures)
    _write_csv(folder / "comparison.csv", figures)
    assets = None if self_contained else assets_for(folder)
    write_comparison_page(folder / "comparison.html", figures=figures, curves=curves, assets=assets)
    return GaitComparison(figures, folder)


def _write_csv(path: Path, figures: Mapping[str, Any]) -> None:
    """A row a number of both conditions, for statistics; a cell is empty where it is not known."""
    numbers = ("first", "second", "difference", "error")
    rows = (
        [*(one[key] for key in ("name", "side", "unit")),
         *("" if one[key] is None else cell(one[key]) for key in numbers),
         "" if one["error"] is None else int(one["exceeds"])]
        for one in (*figures["time_distance"], *figures["key_values"])
    )  # fmt: skip
    write_table(path, ["name", "side", "unit", "first", "second", "difference", "error_95", "exceeds"], rows)


def _read(path: Path) -> dict[str, Any]:
    table = read_json(path) if path.suffix.lower() == ".json" else None
    if not isinstance(table, dict) or not {"curves", "time_distance", "uncertainty", "method"} <= set(table):
        raise KinemarkError(f"{path} is no gait.json of kinemark gait. Run it on both conditions first.")
    return table


def _about(path: Path, table: Mapping[str, Any]) -> dict[str, Any]:
    strides = {side: table["time_distance"][side]["stride_time"]["strides"] for side in SIDES}
    return {
        "file": path.as_posix(), "name": path.parent.name, "subject": table["subject"],
        "trials": [trial["name"] for trial in table["trials"]], "strides": strides,
    }  # fmt: skip


def _parameters(tables: tuple[dict[str, Any], ...], side: str, same: bool) -> list[dict[str, Any]]:
    """A row a time-distance parameter."""
    rows = []
    for name, unit in UNITS.items():
        both = [table["time_distance"][side][name] for table in tables]
        if any(one["mean"] is None for one in both):
            continue
        sd = [_mean_sd(one, same) for one in both]
        first, second = (
            Condition(_array(one["mean"]), _array(one["spread"]), _array(s), one["strides"])
            for one, s in zip(both, sd, strict=True)
        )
        rows.append({"name": name, "side": side, "unit": unit} | _number_row(first, second))
    return rows


def _number_row(first: Condition, second: Condition) -> dict[str, Any]:
    """What is told of one number in both conditions."""
    found = difference(first, second)
    return {"first": first.mean, "second": second.mean, "difference": found.value, "error": found.error,
            "exceeds": bool(found.exceeds)}  # fmt: skip


def _keys(tables: tuple[dict[str, Any], ...], same: bool) -> list[dict[str, Any]]:
    """A row a key value of a side that both conditions have; those without a known measurement's error have none."""
    each = [{one["name"]: one for one in table.get("key_values", [])} for table in tables]  # earlier versions: none
    rows = []
    for key in KEYS:
        for side in SIDES:
            both = [found.get(key.name, {}).get(side) for found in each]
            if any(one is None for one in both):
                continue
            first, second = (_key(one, key, side, t, same) for one, t in zip(both, tables, strict=True))
            rows.append(
                {"name": key.name, "side": side, "unit": each[0][key.name]["unit"]} | _number_row(first, second)
            )
    return rows


def _key(one: Mapping[str, Any], key: Key, side: Side, table: Mapping[str, Any], same: bool) -> Condition:
    """A key value; of its measurement only the noise, over strides, where the markers stayed on; none if not asked.

    What is systematic in a range nobody knows, whatever was asked.
    """
    sd = _array(one["sd"]) if table["uncertainty"] or key.how == "range" else np.array(0.0)
    if same:
        share = _noise_share(table, LETTER[side] + key.curve)
        sd = sd * (share[key.axis] if key.axis < len(share) else 0.0) / np.sqrt(max(one["strides"], 1))
    return Condition(_array(one["mean"]), _array(one["spread"]), sd, one["strides"])


def _mean_sd(one: Mapping[str, Any], same: bool) -> float:
    """Of the mean over strides: events err stride by stride, markers that sit elsewhere in all of them alike."""
    systematic = float(one.get("systematic_sd", 0.0))  # tables of earlier versions have none
    each = max(_number(one["sd"]) ** 2 - systematic**2, 0.0) / max(one["strides"], 1)
    return float(np.sqrt(each + (0.0 if same else systematic**2)))


def _curves(tables: tuple[dict[str, Any], ...], same: bool) -> list[ComparedCurve]:
    """All quantities of joints that both conditions have."""
    by_name = [{one["name"]: one for one in table["curves"] if one["axes"][0] != "envelope"} for table in tables]
    found = []
    for name, one in by_name[0].items():
        other = by_name[1].get(name)
        if other is None or not (one["strides"] and other["strides"]):
            continue
        conditions = tuple(
            Condition(_array(row["mean"]), _array(row["spread"]), _measured(row, table, same), row["strides"])
            for row, table in zip((one, other), tables, strict=True)
        )
        found.append(
            ComparedCurve(
                name, one["side"], one["unit"], tuple(one["axes"]), conditions[0], conditions[1],
                _difference(*conditions, angle=name.endswith("Angles")),
            )
        )  # fmt: skip
    return found


def _difference(first: Condition, second: Condition, *, angle: bool) -> Difference:
    """Angles differ by less than half a turn."""
    if angle:
        whole_turns = np.round((second.mean - first.mean) / 360.0) * 360.0
        second = second._replace(mean=second.mean - whole_turns)
    return difference(first, second)


def _measured(row: Mapping[str, Any], table: Mapping[str, Any], same: bool) -> Floats:
    """(101, A) of the measurement; of its noise alone, over strides, where the markers stayed on."""
    sd = np.nan_to_num(_array(row["sd"]))
    if not same:
        return sd
    share = _noise_share(table, row["name"])
    return np.asarray(sd * (share if len(share) else 0.0) / np.sqrt(max(row["strides"], 1)))


def _noise_share(table: Mapping[str, Any], name: str) -> Floats:
    """(A) of the measurement's standard uncertainty, how much is noise; empty where causes are not known."""
    causes: dict[str, Any] = next((one["by_cause"] for one in table["uncertainty"] if one["name"] == name), {})
    squares = {cause: np.nan_to_num(_array(values)) ** 2 for cause, values in causes.items()}
    if not squares:
        return np.zeros(0)
    total = np.sum(list(squares.values()), axis=0)
    noise = squares.get("noise", np.zeros_like(total))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.sqrt(np.where(total > 0, noise / total, 0.0)))


def _row(one: ComparedCurve) -> dict[str, Any]:
    """Where a quantity differs, by its components: most clearly, or, where it does not differ, most."""
    parts = []
    for k, axis in enumerate(one.axes):
        where = stretches(one.difference.exceeds[:, k])
        value, error = one.difference.value[:, k], one.difference.error[:, k]
        clear = np.abs(value) / error if where else np.abs(value)
        if where:
            clear = np.where(np.isin(np.arange(101), [p for a, b in where for p in range(a, b + 1)]), clear, np.nan)
        most = int(np.nanargmax(clear)) if np.isfinite(clear).any() else None
        parts.append({
            "axis": axis, "stretches": where, "greatest": None if most is None else value[most], "at": most,
            "error_there": None if most is None else error[most],
            "unknown": int((np.isfinite(value) & ~np.isfinite(error)).sum()) >= LEAST_POINTS,
        })  # fmt: skip
    return {"name": one.name, "side": one.side, "unit": one.unit, "components": parts}


def _array(values: Any) -> Floats:
    """Numbers, NaN where there are none."""
    return np.array(values, dtype=object).astype(np.float64) if values is not None else np.array(np.nan)


def _number(value: float | None) -> float:
    return 0.0 if value is None else float(value)
