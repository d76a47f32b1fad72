"""Every figure of the report as plain data, for machines and for the page that shows them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ..data import Cloud, Detections, Finding, Identity, Rig, Step, Tracks, Trajectories
from ..data.array_types import Floats
from ..io.files import replacing
from ..track.simultaneous import AmbiguousDecision
from ..track.simultaneous.rig.camera_strobes import without_strobes
from ..version import __version__
from .cameras import camera_figures, residuals
from .left_over import left_over, shown_at_once
from .markers import completeness_known, frames_in_view, marker_figures, positions, trajectory_figures
from .off_course import off_course_share
from .plain import SCHEMA_VERSION, mean, plain, quantile, rms, share
from .room import room_at
from .trial_findings import trial_findings
from .trial_records import AboutTrial, TrialRecords
from .trial_verdict import trial_verdict


def quality(
    records: TrialRecords,
    *,
    about: AboutTrial,
    steps: Sequence[Step],
    findings: Sequence[Finding] = (),
    judged: Mapping[str, Any] | None = None,
    filling: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """All figures of one trial as JSON-able data, units in the names of the keys, None where unknown.

    Args:
        records: what was measured. about: which recording it is. steps: how the trial was made.
        findings: what the stages found themselves, as what the tracking says of its input; frames as numbers in the
            recording.
        judged: how good the calibration is, from `calibration.calibration_figures`; None where nobody judged it.
        filling: what became of the gaps, from `filling.filling_figures`; None where none was to be filled.

    Raises:
        ValueError: a camera of the detections is not in the rig, or the points were not made from these detections.
    """
    rig, detections, tracks, trajectories = records.rig, records.detections, records.tracks, records.trajectories
    cloud, rig_used, given = tracks.cloud, rig.select(detections.cameras), records.given
    _check(cloud, detections)
    if any(one.kind == "strobes_seen" for one in findings):  # by which nothing was left over
        detections = without_strobes(detections, rig_used)
    offsets = residuals(rig_used, detections, cloud)
    before = given and given._replace(rig=given.rig.select(detections.cameras))
    seen = camera_figures(rig_used, detections, cloud, offsets, before)
    cameras = [one | left for one, left in zip(seen, left_over(detections, tracks), strict=True)]
    figures: dict[str, Any] = plain(
        {
            "kinemark": __version__,
            "schema_version": SCHEMA_VERSION,
            "session": about.session,
            "trial": about.trial,
            "identity": dict(about.identity or asdict(Identity())),
            "recording": _recording(
                detections, trajectories.first_frame if about.first_frame is None else about.first_frame
            ),
            "calibration": {
                "method": rig.method,
                "cameras_not_used": [n for n in rig.names if n not in rig_used.names],
                **({key: judged[key] for key in ("verdict", "findings", "precision")} if judged else {}),
                "room": room_at(judged.get("room") if judged else None, positions(trajectories).reshape(-1, 3)),
            },
            "volume": _volume(rig, trajectories),
            "cameras": cameras,
            "points": _points(cloud, tracks, offsets),
            "tracks": _tracks(tracks),
            "trajectories": _trajectories(trajectories, detections, cameras),
            "timing": _timing(steps, detections.n_frames),
            "steps": [_step(step) for step in steps],
            "ambiguous_decisions": [
                _decision(row, detections.rate, records.track_names) for row in records.ambiguous_decisions
            ],
            "filling": filling,
        }
    )
    found = trial_findings(figures, findings)
    figures["findings"] = [one.as_dict() for one in found]
    figures["verdict"] = trial_verdict(figures, found).as_dict()
    return figures


def write_quality(path: Path | str, quality: dict[str, Any]) -> None:
    """Write the figures as indented JSON, whole or not at all.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    text = json.dumps(quality, indent=2, ensure_ascii=False, allow_nan=False)
    with replacing(path) as beside:
        beside.write_text(text + "\n", encoding="utf-8")


def _check(cloud: Cloud, detections: Detections) -> None:
    if not len(cloud):
        return
    if cloud.detection.shape[1] != len(detections.cameras):
        raise ValueError(
            f"tracks see {cloud.detection.shape[1]} cameras, wanted the {len(detections.cameras)} of detections"
        )
    if cloud.detection.max(initial=-1) >= len(detections):
        raise ValueError(f"tracks refer to detection {cloud.detection.max()}, but there are only {len(detections)}")


def _recording(detections: Detections, first_frame: int) -> dict[str, Any]:
    n, rate = detections.n_frames, detections.rate
    return {"first_frame": first_frame, "frames": n, "rate_hz": rate, "duration_s": share(n, rate)}


def _volume(rig: Rig, trajectories: Trajectories) -> dict[str, Any]:
    """The control volume as given, the box that the markers spanned, the share of their samples outside the former."""
    xyz = positions(trajectories).reshape(-1, 3)
    xyz = xyz[np.isfinite(xyz).all(1)]
    given = bool(np.isfinite(rig.volume).all())
    outside = ((xyz < rig.volume[0]) | (xyz > rig.volume[1])).any(1)
    return {
        "given_mm": rig.volume if given else None,
        "spanned_mm": [xyz.min(0), xyz.max(0)] if len(xyz) else None,
        "samples_outside_given_share": share(outside.sum(), len(xyz)) if given else None,
    }


def _points(cloud: Cloud, tracks: Tracks, offsets: list[Floats]) -> dict[str, Any]:
    distance = np.linalg.norm(np.concatenate([np.zeros((0, 2)), *offsets]), axis=1)
    views = (cloud.detection >= 0).sum(1)
    number, count = np.unique(views, return_counts=True)
    return {
        "count": len(cloud),
        "per_frame_mean": share(len(cloud), cloud.n_frames),
        "cameras_per_point": {str(n): k for n, k in zip(number, count, strict=True)},
        "fewer_than_3_cameras_share": share((views < 3).sum(), len(cloud)),
        "in_a_track_share": share((tracks.id >= 0).sum(), len(cloud)),
        "residual_median_px": quantile(distance, 0.5),
        "residual_rms_px": rms(distance),
        "residual_95_px": quantile(distance, 0.95),
    }


def _trajectories(trajectories: Trajectories, detections: Detections, cameras: list[dict[str, Any]]) -> dict[str, Any]:
    frames = positions(trajectories).shape[1]
    images = (
        np.bincount(detections.frame[detections.valid], minlength=frames) if frames == detections.n_frames else None
    )
    inside = frames_in_view(trajectories, images)
    markers = marker_figures(trajectories, inside)
    shown = shown_at_once(cameras, detections.n_frames)
    return trajectory_figures(trajectories, markers, inside, known=completeness_known(cameras), shown=shown)


def _tracks(tracks: Tracks) -> dict[str, Any]:
    lengths = tracks.lengths
    return {
        "count": (lengths > 0).sum(),
        "length_mean_frames": mean(lengths[lengths > 0].astype(float)),
        "length_median_frames": quantile(lengths[lengths > 0].astype(float), 0.5),
        "off_course_share": off_course_share(tracks),
        "lengths_frames": lengths,
    }


def _decision(row: AmbiguousDecision, rate: float, names: Sequence[str] | None) -> dict[str, Any]:
    """A close decision, its tracks by the names of their trajectories."""
    own = [track for track in row.tracks if track >= 0]
    called = [f"*{track + 1}" if names is None else names[track] or "no marker" for track in own]
    return {
        "kind": row.kind,
        "first_frame": row.first,
        "last_frame": row.last,
        "time_s": row.first / rate,
        "trajectories": list(dict.fromkeys(called)) if names is not None else called,
        "reason": row.reason,
        "values": dict(row.values),
    }


def _timing(steps: Sequence[Step], frames: int) -> dict[str, Any]:
    """Of the trial's own stages in all; the calibration, which its session shares, has a row and no part of it."""
    total = float(sum(step.seconds for step in steps if step.stage != "calibrate"))
    stages: dict[str, float] = {}
    for step in steps:
        stages[step.stage] = stages.get(step.stage, 0.0) + step.seconds
    return {
        "total_s": total,
        "frames_per_s": share(frames, total),
        "stages": [{"stage": name, "time_s": s, "frames_per_s": share(frames, s)} for name, s in stages.items()],
    }


def _step(step: Step) -> dict[str, Any]:
    return {
        "stage": step.stage,
        "method": step.method,
        "parameters": step.parameters,
        "version": step.version,
        "input": step.input,
        "time_s": step.seconds,
    }
