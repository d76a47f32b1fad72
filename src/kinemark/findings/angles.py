"""What a run says of joint angles: as figures for a machine, as a few lines of text, and as warnings."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..data import Angles, Trajectories
from ..kinematics import Cycles, Model, named, outside
from ..report.formatting import count, number, percent, some
from ..version import __version__
from .plain import plain, quantile, runs, share

TOO_STEADY_MM = 0.02
"""An estimated error of markers below this means that their paths were smoothed before."""


def angle_figures(
    angles: Angles,
    model: Model,
    *,
    name: str,
    trajectories: Trajectories,
    how: dict[str, Any],
    cycles: Cycles | None = None,
) -> dict[str, Any]:
    """Every figure of the page by name.

    Args:
        angles: of the trial; model: that they were made with; cycles: of the trial, where it has some.
        name: of the trial.
        trajectories: the markers, with the covariance that was passed on.
        how: the words "method", "noise", "smoothing"; "marker_sd_mm" and "noise_from"; "lock_deg".
    """
    rows = [_angle(angles, model, k) for k in range(len(named(model)))]
    joints = [_joint(angles, j) for j in range(len(angles.joints))]
    figures = {
        "kinemark": __version__,
        "trial": name,
        "model": model.name,
        "source": model.source,
        "side": model.side,
        "frames": angles.deg.shape[1],
        "rate_hz": angles.rate,
        "first_frame": trajectories.first_frame,
        **how,
        "joints": joints,
        "angles": rows,
        "cycles": None if cycles is None else _cycles(cycles, model),
    }
    figures["warnings"] = _warnings(figures)
    worst = max((("info", "amber", "red").index(w["severity"]) for w in figures["warnings"]), default=0)
    return plain(figures | {"verdict": {"grade": ("green", "amber", "red")[worst], **_headline(figures, worst)}})


def _angle(angles: Angles, model: Model, k: int) -> dict[str, Any]:
    """One degree of freedom."""
    j, t, motion = named(model)[k]
    y, sd, out = angles.deg[j, :, t], angles.sd[j, :, t], outside(angles, model)[j, :, t]
    sd, known = sd[np.isfinite(sd)], np.isfinite(y)
    return {
        "joint": angles.joints[j],
        "name": motion.name,
        "positive": motion.positive,
        "normal_deg": motion.normal,
        "frames": int(known.sum()),
        "least_deg": float(y[known].min()) if known.any() else None,
        "greatest_deg": float(y[known].max()) if known.any() else None,
        "range_deg": float(np.ptp(y[known])) if known.any() else None,
        "sd_median_deg": quantile(sd, 0.5),
        "sd_95_deg": quantile(sd, 0.95),
        "outside_frames": int(out.sum()),
        "outside_share": share(float(out.sum()), float(known.sum())),
        "outside_most_deg": _beyond(y[known], motion.normal),
    }


def _beyond(y: np.ndarray[Any, np.dtype[np.float64]], normal: tuple[float, float] | None) -> float:
    """How far the angle goes beyond its range at most."""
    if normal is None or not y.size:
        return float("nan")
    return max(float(normal[0] - y.min()), float(y.max() - normal[1]), 0.0)


def _joint(angles: Angles, j: int) -> dict[str, Any]:
    known, locked = np.isfinite(angles.deg[j]).any(-1), angles.locked[j]
    return {
        "name": angles.joints[j],
        "sequence": angles.sequence[j],
        "frames": int(known.sum()),
        "missing_frames": int((~known).sum()),
        "locked_frames": int(locked.sum()),
        "locked": [[a, b - 1] for a, b in runs(locked)],
    }


def _cycles(cycles: Cycles, model: Model) -> dict[str, Any]:
    return {
        "spans_s": cycles.spans,
        "angles": [
            {
                "joint": model.joints[j].name,
                "name": motion.name,
                "mean_range_deg": quantile(cycles.mean[j, :, t], 1.0) - quantile(cycles.mean[j, :, t], 0.0),
                "spread_median_deg": quantile(cycles.spread[j, :, t], 0.5),
                "noise_median_deg": quantile(cycles.noise[j, :, t], 0.5),
            }
            for j, t, motion in named(model)
        ],
    }


def _warnings(figures: dict[str, Any]) -> list[dict[str, str]]:
    found = _missing(figures["joints"])
    found += [w for joint in figures["joints"] for w in _locked(joint, figures["first_frame"])]
    for row in figures["angles"]:
        if row["outside_frames"] and row["outside_most_deg"] >= 0.5:
            name, part = f"{row['joint'].capitalize()} {row['name']}", percent(row["outside_share"])
            most = number(row["outside_most_deg"], 1)
            what = f"{name} is beyond its normal range in {part} of the frames, by up to {most}°."
            found.append(_say("amber", what, "Check that no marker is swapped or misplaced; the angles are kept."))
    sd = figures["marker_sd_mm"]
    if figures["noise_from"] == "estimated" and sd is not None and sd < TOO_STEADY_MM:
        what = (
            f"The markers hardly tremble ({number(sd, 4)} mm): their paths were smoothed before, so that the standard "
            "deviations of the angles are far too small."
        )
        found.append(_say("amber", what, "State what the laboratory knows: --marker-sd-mm."))
    elif figures["noise_from"] != "stated":
        what = f"The file states no errors of its markers; their standard deviation is {figures['noise_from']}."
        found.append(_say("info", what, "State it with --marker-sd-mm, if it is known better."))
    return found


def _missing(joints: list[dict[str, Any]]) -> list[dict[str, str]]:
    """Frames without angles, joints with the same number of them together."""
    do, found = "Fill the gaps, or use a model with clusters and a static trial.", []
    for n in sorted({joint["missing_frames"] for joint in joints} - {0}):
        fits = [joint for joint in joints if joint["missing_frames"] == n]
        names = ", ".join(joint["name"] for joint in fits)
        if not all(joint["frames"] for joint in fits):
            found.append(_say("red", f"No frame has angles of: {names}. Markers are missing.", do))
        else:
            found.append(
                _say("info", f"{count(n, 'frame')} without angles of: {names}. Markers are missing there.", do)
            )
    return found


def _locked(joint: dict[str, Any], first_frame: int) -> list[dict[str, str]]:
    if not joint["locked"]:
        return []
    spans = [f"{a + first_frame}–{b + first_frame}" for a, b in joint["locked"]]
    what = f"The {joint['name']} is in gimbal lock: {some('frame', spans, 4)}."
    return [_say("amber", what, "Its first and third angle are not told apart there; another sequence may fit better.")]


def _say(severity: str, what: str, do: str) -> dict[str, str]:
    return {"severity": severity, "what": what, "do": do}


def _headline(figures: dict[str, Any], worst: int) -> dict[str, Any]:
    rows = [row for row in figures["angles"] if row["sd_median_deg"] == row["sd_median_deg"]]
    heads = ("The angles hold together", "The angles deserve a look", "A joint has no angles")
    sentences = [f"Model {figures['model']}, {figures['side']} side, {count(figures['frames'], 'frame')}."]
    if rows:
        best, last = (f(rows, key=lambda row: row["sd_median_deg"]) for f in (min, max))
        sentences.append(
            f"Standard deviations by the markers' errors: from {_deg(best)} ({best['joint']} {best['positive']}) to "
            f"{_deg(last)} ({last['joint']} {last['positive']}), in the middle of the frames. They are a floor: "
            "placement of the markers and skin that slides over bone come on top."
        )
    if (cycles := figures["cycles"]) is not None:
        sentences.append(f"{count(len(cycles['spans_s']), 'cycle')} averaged.")
    return {"headline": heads[worst], "sentences": sentences}


def _deg(row: dict[str, Any]) -> str:
    sd = row["sd_median_deg"]
    return f"{sd:.2g}°" if sd < 1 else f"{sd:.1f}°"


def angle_summary(figures: dict[str, Any]) -> str:
    """A short plain text: verdict, a line an angle, warnings."""
    rows = figures["angles"]
    width = max(len(f"{row['joint']} {row['name']}") for row in rows) if rows else 0
    lines = [f"{figures['trial']}: {figures['verdict']['headline']}"]
    lines += [f"  {sentence}" for sentence in figures["verdict"]["sentences"]]
    lines += ["", f"  {'angle, deg':{width}s}   least  greatest    SD  outside"]
    for row in rows:
        lines.append(
            f"  {row['joint'] + ' ' + row['name']:{width}s}  {number(row['least_deg'], 1):>6s}  "
            f"{number(row['greatest_deg'], 1):>8s}  {number(row['sd_median_deg'], 2):>4s}  "
            f"{number(row['outside_frames']):>7s}"
        )
    lines += ["", *(f"  {w['severity'].upper():5s} {w['what']} {w['do']}" for w in figures["warnings"])]
    return "\n".join(lines).rstrip() + "\n"
