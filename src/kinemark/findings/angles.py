"""What a run says of joint angles: figures, what needs attention, and the verdict."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..data import Angles, Finding, Trajectories, make_finding
from ..data.array_types import Floats
from ..kinematics import Cycles, Model, named_angles, outside
from ..version import __version__
from .plain import SCHEMA_VERSION, plain, quantile, runs, share
from .verdict import verdict_of

TOO_STEADY_MM = 0.02
"""An estimated error of markers below this means that they were smoothed before; chosen."""
JUMP_DEG = 90.0
"""Change of an angle from one frame to the next, both out of gimbal lock, that no joint makes; chosen: a pitcher's arm
turns by 70° in a hundredth of a second."""
LEAP_DEG, LEAP_RATIO = 5.0, 8.0
"""The same of a change that stands alone: so large, and so many times the changes about it. A joint needs some frames
to begin a motion and to end it. Of 2500 angles between markers of seven recordings, among them a tennis serve at 50 Hz
and acrobatics, one in a hundred had any; chosen."""
LEAP_DEG_S2 = 50_000.0
"""The same by how fast it must begin: in a tenth of a second fingers and heads go some 50° from rest to rest, which are
two frames at 25 Hz. It is 5° at 100 Hz and 20° at 50; chosen."""
ABOUT = (-5, -4, -3, -2, 2, 3, 4, 5)
"""Which changes are about one, counted from it; those next to it may be the way back. Half must be known. Chosen."""
LEAST_BEYOND_DEG = 0.5
"""Beyond its normal range by less, an angle is not reported; chosen."""


def angle_figures(
    angles: Angles,
    model: Model,
    *,
    name: str,
    trajectories: Trajectories,
    how: dict[str, Any],
    cycles: Cycles | None = None,
    side: Finding | None = None,
) -> dict[str, Any]:
    """Every figure of the page by name.

    Args:
        angles: of the trial; model: that they were made with; cycles: of the trial, where it has some.
        name: of the trial.
        trajectories: the markers, with the covariance that was passed on.
        how: the words "method", "noise", "laboratory", "smoothing"; "marker_sd_mm" and "noise_from"; "lock_deg".
        side: how the side was told, where nobody stated it.
    """
    rows = [_angle(angles, model, k) for k in range(len(named_angles(model)))]
    joints = [_joint(angles, j) for j in range(len(angles.joints))]
    figures = {
        "kinemark": __version__,
        "schema_version": SCHEMA_VERSION,
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
    findings = [*_findings(figures), *_jumps(angles, model, trajectories.first_frame), *([side] if side else [])]
    figures["findings"] = [found.as_dict() for found in findings]
    return plain(figures | {"verdict": verdict_of(findings, _statements(figures, findings)).as_dict()})


def _angle(angles: Angles, model: Model, k: int) -> dict[str, Any]:
    """One degree of freedom."""
    j, t, motion = named_angles(model)[k]
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
            for j, t, motion in named_angles(model)
        ],
    }


def _findings(figures: dict[str, Any]) -> list[Finding]:
    """What needs attention, in the order of the page."""
    found = list(_missing(figures["joints"]))
    found += [one for joint in figures["joints"] for one in _locked(joint, figures["first_frame"])]
    for row in figures["angles"]:
        if row["outside_frames"] and row["outside_most_deg"] >= LEAST_BEYOND_DEG:
            found.append(
                make_finding(
                    "angle_beyond_normal",
                    joint=row["joint"],
                    angle=row["name"],
                    frames_share=row["outside_share"],
                    most_deg=row["outside_most_deg"],
                )
            )
    sd = figures["marker_sd_mm"]
    if figures["noise_from"] == "estimated" and sd is not None and sd < TOO_STEADY_MM:
        found.append(make_finding("markers_smoothed_before", sd_mm=sd))
    elif figures["noise_from"] != "stated":
        found.append(make_finding("marker_errors_not_stated", how=figures["noise_from"]))
    return found


def _jumps(angles: Angles, model: Model, first_frame: int) -> Iterator[Finding]:
    """Angles that change between two frames as no joint moves; frames in gimbal lock are told of elsewhere."""
    least = max(LEAP_DEG, LEAP_DEG_S2 / angles.rate**2)
    for j, t, motion in named_angles(model):
        free = ~(angles.locked[j, 1:] | angles.locked[j, :-1])
        change = np.where(free, np.abs(np.diff(angles.deg[j, :, t])), np.nan)
        at = np.flatnonzero((change > JUMP_DEG) | (change > least) & (change > LEAP_RATIO * _about(change)))
        if len(at):
            spans = [(int(f) + first_frame, int(f) + first_frame + 1) for f in at]
            most = float(change[at].max())
            yield make_finding(
                "angle_jumps", frames=spans, joint=angles.joints[j], angle=motion.name, count=len(at), most_deg=most
            )


def _about(change: Floats) -> Floats:
    """The largest of the changes (F-1) about each; infinite where fewer than half are known."""
    padded = np.pad(change, max(ABOUT), constant_values=np.nan)
    beside = np.stack([padded[max(ABOUT) + k : len(padded) - max(ABOUT) + k] for k in ABOUT])
    few = np.isfinite(beside).sum(0) < len(ABOUT) / 2
    return np.where(few, np.inf, np.nan_to_num(beside).max(0))


def _missing(joints: list[dict[str, Any]]) -> Iterator[Finding]:
    """Frames without angles, joints with the same number of them together."""
    for n in sorted({joint["missing_frames"] for joint in joints} - {0}):
        fits = [joint for joint in joints if joint["missing_frames"] == n]
        names = [joint["name"] for joint in fits]
        if not all(joint["frames"] for joint in fits):
            yield make_finding("joints_without_angles", joints_list=names)
        else:
            yield make_finding("frames_without_angles", count=n, joints_list=names)


def _locked(joint: dict[str, Any], first_frame: int) -> Iterator[Finding]:
    if joint["locked"]:
        spans = [(a + first_frame, b + first_frame) for a, b in joint["locked"]]
        yield make_finding("gimbal_lock", joint=joint["name"], frames=spans)


def _statements(figures: dict[str, Any], findings: list[Finding]) -> Iterator[Finding]:
    grade = verdict_of(findings, ()).grade
    yield make_finding({"green": "angles_good", "amber": "angles_usable", "red": "angles_missing"}[grade])
    yield make_finding("angles_computed", model=figures["model"], side=figures["side"], frame_count=figures["frames"])
    rows = [row for row in figures["angles"] if row["sd_median_deg"] == row["sd_median_deg"]]
    if rows:
        least, greatest = (f(rows, key=lambda row: row["sd_median_deg"]) for f in (min, max))
        yield make_finding(
            "angle_deviations",
            least_deg=least["sd_median_deg"],
            least_joint=least["joint"],
            least_angle=least["positive"],
            greatest_deg=greatest["sd_median_deg"],
            greatest_joint=greatest["joint"],
            greatest_angle=greatest["positive"],
        )
    if (cycles := figures["cycles"]) is not None:
        yield make_finding("cycles_averaged", cycles=len(cycles["spans_s"]))
