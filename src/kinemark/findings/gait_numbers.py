"""Numbers of a gait report, ready for JSON: curves, harmonics, profiles, averages and uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..data.array_types import Floats
from ..data.gait_curves import GaitCurves, GaitReference, KeyValue
from ..data.strides import Stride
from ..data.subject_measures import SIDES, SubjectMeasures
from ..gait.gait_cycles import movement_analysis_profile, overall_score, scaled_score
from ..gait.harmonics import curve_harmonics
from ..gait.key_values import KEYS
from ..gait.time_distance import averages
from ..gait.turning import ways
from .plain import quantile


def harmonics(curves: Sequence[GaitCurves], strides: Sequence[Stride]) -> dict[str, Any]:
    """Frequency of the stride of both sides, Hz, and the harmonics of the mean curve of each angle."""
    each = [
        {"name": c.name, "component": axis, **curve_harmonics(c.mean[:, k])._asdict()}
        for c in curves if c.unit == "deg" for k, axis in enumerate(c.axes)
    ]  # fmt: skip
    return {"stride_hz": {side: _frequency(strides, side) for side in SIDES}, "angles": each}


def _frequency(strides: Sequence[Stride], side: str) -> float:
    """Hz, of the mean stride of a side; NaN where there is none."""
    times = [s.values["stride_time"] for s in strides if s.side == side]
    return float(1 / np.mean(times)) if times else float("nan")


def profile(curves: Sequence[GaitCurves], reference: GaitReference) -> dict[str, Any]:
    """Of both sides, and what they were compared with."""
    found: dict[str, Any] = {"source": reference.source, "subjects": reference.subjects}
    for side in SIDES:
        variables, score = movement_analysis_profile(curves, reference, side)
        found[side] = {"variables": variables, "score": score, "scaled_score": scaled_score(score, reference)}
    found["overall_score"] = overall_score(*(found[side]["variables"] for side in SIDES))
    return found


def measures_of(measures: SubjectMeasures) -> dict[str, Any]:
    """Of the body and of each leg, by name."""
    legs = {side: {k: getattr(measures.leg(side), k) for k in measures.leg(side).__slots__} for side in SIDES}
    whole = ("mass_kg", "height_mm", "asis_mm", "marker_diameter_mm")
    return {name: getattr(measures, name) for name in whole} | legs


def averages_of(strides: Sequence[Stride], side: str) -> dict[str, Any]:
    """Of each parameter of a side: mean, spread, number of strides and standard uncertainty of one."""
    found = averages(strides, "left" if side == "left" else "right")
    own = [stride for stride in strides if stride.side == side]
    return {
        name: {"mean": mean, "spread": spread, "strides": n, "sd": quantile(np.array([s.sd[name] for s in own]), 0.5),
               "systematic_sd": max((s.systematic.get(name, 0.0) for s in own), default=0.0)}
        for name, (mean, spread, n) in found.items()
    }  # fmt: skip


def key_values(values: Sequence[KeyValue]) -> list[dict[str, Any]]:
    """A row a value in the order of `KEYS`: of both sides mean, spread, strides and SD of measurement; None of a side
    without any."""
    rows = []
    for name in (key.name for key in KEYS):
        own = [one for one in values if one.name == name and np.isfinite(one.value)]
        if own:
            row: dict[str, Any] = {"name": name, "unit": own[0].unit}
            rows.append(row | {side: _average([one for one in own if one.side == side]) for side in SIDES})
    return rows


def _average(own: Sequence[KeyValue]) -> dict[str, Any] | None:
    """Of the strides of a side."""
    if not own:
        return None
    value, sd = np.array([one.value for one in own]), np.array([one.sd for one in own])
    spread = float(value.std(ddof=1)) if len(own) > 1 else None
    return {"mean": value.mean(), "spread": spread, "strides": len(own), "sd": np.sqrt(np.mean(sd**2))}


def ways_walked(strides: Sequence[Stride]) -> list[dict[str, Any]]:
    """Where the subject faces, and parameters of both sides, of each way it walks; none where it is one."""
    each = ways(strides)
    if len(each) < 2:
        return []
    return [
        {"facing_deg": own[0].facing_deg, "time_distance": {side: averages_of(own, side) for side in SIDES}}
        for own in each
    ]


def curve(one: GaitCurves) -> dict[str, Any]:
    """One quantity over the stride, rounded."""
    return {
        "name": one.name, "side": one.side, "unit": one.unit, "axes": one.axes, "strides": int(one.whole.sum()),
        "mean": np.round(one.mean, 4), "spread": np.round(one.spread, 4), "sd": np.round(one.measurement_sd, 4),
        "consistency": np.round(one.consistency, 4), "foot_off": float(np.nanmean(one.foot_off))
        if np.isfinite(one.foot_off).any() else None,
    }  # fmt: skip


def uncertainty_by_cause(causes: Mapping[str, Mapping[str, Floats]]) -> list[dict[str, Any]]:
    """A row a quantity: root mean square by cause, in its own unit."""
    names = sorted({name for cause in causes.values() for name in cause})
    return [
        {"name": name, "by_cause": {c: _rms_each(of[name]) for c, of in causes.items() if name in of}} for name in names
    ]


def _rms_each(sd: Floats) -> list[float]:
    known = np.asarray(np.isfinite(sd).any(axis=0))
    return [float(np.sqrt(np.nanmean(sd[:, k] ** 2))) if known[k] else float("nan") for k in range(sd.shape[1])]
