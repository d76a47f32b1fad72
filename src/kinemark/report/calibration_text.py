"""A calibration's figures that matter most, as a few lines for the terminal."""

from __future__ import annotations

from typing import Any

from .formatting import number, percent, signed
from .terminal_summary import finding_lines
from .words import headline_of, sentences_of


def calibration_summary(figures: dict[str, Any]) -> str:
    """Verdict, what was measured, a line a camera, what to do, and how it differs from the calibration before."""
    lines = [f"{figures['session']}: {headline_of(figures['verdict'])}"]
    lines += [f"  {sentence}" for sentence in sentences_of(figures["verdict"])]
    lines += ["", *_cameras(figures["cameras"]), ""]
    lines += finding_lines(figures["findings"])
    return "\n".join(lines + _change(figures["change"])).rstrip() + "\n"


def _cameras(cameras: list[dict[str, Any]]) -> list[str]:
    width = max([len("camera"), *(len(camera["name"]) for camera in cameras)])
    head = f"  {'camera':{width}s}  points  residual px  left out px  focal px  lost: error  lost: volume"
    return [head] + [
        f"  {camera['name']:{width}s}  {number(camera['points']):>6s}  {number(camera['residual_rms_px'], 3):>11s}"
        f"  {number(camera['left_out_rms_px'], 3):>11s}  {number(camera['focal_px'][0], 1):>8s}"
        f"  {'× ' + number(camera['without']['ratio_median'], 2):>11s}"
        f"  {percent(camera['without']['newly_unseen_share']):>12s}"
        for camera in cameras
    ]


def _change(change: dict[str, Any] | None) -> list[str]:
    if change is None:
        return []
    rows = [
        f"  {c['name']}: moved {number(c['moved_mm'], 2)} mm, turned {number(c['turned_deg'], 3)}°, focal length "
        f"{signed(100 * c['focal_share'], 2)} %, image shifted {number(c['image_px'], 2)} px"
        for c in change["cameras"]
    ]
    return ["", f"Since the calibration before, kept as {change['since']}:", *rows]
