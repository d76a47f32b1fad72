"""Delays that a wand's film told of cameras, which a trial tries as they are.

A camera that runs by its own clock, or starts late by its make, is as late in a trial as it was at the wand; one that
was started by hand is not. Whole images are put into the frames that they show, and what is left moves the detections
(`signal.common_time`). Tracking decides whether that fits better than what the trial tells by itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...data import Detections, Finding, make_finding
from ...data.array_types import Floats


def told_delays(figures: Mapping[str, Any], stated_ms: Mapping[str, float]) -> dict[str, float]:
    """Delays, ms by camera, that the figures of a calibration tell and nobody stated.

    Args:
        figures: of the calibration. stated_ms: delays by `[cameras]`, by which the detections are moved already.
    """
    late = (one for one in figures.get("findings", ()) if one["kind"] == "camera_late_while_calibrating")
    told = ((one["cameras"][0], float(one["values"]["delay_ms"])) for one in late)
    return {name: ms for name, ms in told if name not in stated_ms}


def found_as_told(told_ms: Mapping[str, float], detections: Detections) -> tuple[Finding, ...]:
    """About cameras that are as late as `told_ms` says, each with the whole images of `detections` that this makes."""
    return tuple(
        make_finding(
            "camera_late_as_calibrated",
            cameras=[name],
            images=round(ms * detections.rate / 1000),
            delay_ms=ms,
            state_ms=ms,
        )
        for name, ms in told_ms.items()
    )


def delays_learned(findings: Sequence[Finding]) -> dict[str, float]:
    """Delays, ms by camera, that tracking learned beside those that were told."""
    learned = (one for one in findings if one.kind == "camera_delay_learned")
    return {one.cameras[0]: float(np.asarray(one.values["delay_ms"], np.float64)) for one in learned}


def parts_of_images(findings: Sequence[Finding], detections: Detections) -> Floats:
    """(C) s by which cameras are late as `found_as_told` says, beside whole images."""
    part = np.zeros(len(detections.cameras))
    for one in findings:
        if one.kind == "camera_late_as_calibrated":
            late, images = (float(np.asarray(one.values[name], np.float64)) for name in ("delay_ms", "images"))
            part[detections.cameras.index(one.cameras[0])] = late / 1000 - images / detections.rate
    return part
