"""The figures that matter most, as a few lines for the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .digitised import digitised_line
from .formatting import number, percent
from .words import advice_of, headline_of, sentences_of, text_of


def summary(quality: dict[str, Any]) -> str:
    """A short plain text of what `quality` found: verdict, what was measured, a line a camera, what to do."""
    lines = [f"{quality['session']} / {quality['trial']}: {headline_of(quality['verdict'])}"]
    lines += [f"  {sentence}" for sentence in sentences_of(quality["verdict"])]
    if quality.get("digitising"):
        lines.append(f"  {digitised_line(quality['digitising'])}")
    lines += ["", *_cameras(quality["cameras"])]
    if quality["findings"]:
        lines.append("")
    lines += finding_lines(quality["findings"])
    if quality["timing"]["total_s"]:
        timing = quality["timing"]
        lines += ["", f"  {number(timing['total_s'], 1)} s of computing, {number(timing['frames_per_s'], 1)} frames/s."]
    return "\n".join(lines) + "\n"


def finding_lines(findings: Sequence[Mapping[str, Any]]) -> list[str]:
    """A line a finding: how severe, what, and what to do."""
    return [f"  {one['severity'].upper():5s} {text_of(one)} {advice_of(one)}".rstrip() for one in findings]


def _cameras(cameras: list[dict[str, Any]]) -> list[str]:
    width = max([len("camera"), *(len(camera["name"]) for camera in cameras)])
    head = f"  {'camera':{width}s}  seen/frame   used  median px   95 % px"
    return [head] + [
        f"  {camera['name']:{width}s}  {number(camera['detections_per_frame']['mean'], 1):>10s}"
        f"  {percent(camera['used_share']):>5s}  {number(camera['residual_median_px'], 2):>9s}"
        f"  {number(camera['residual_95_px'], 2):>8s}"
        for camera in cameras
    ]
