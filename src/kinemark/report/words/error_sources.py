"""How a source of error is known, and what helps against it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

SOURCE_ADVICE = {
    "disturbed images": "Find the camera from which limb or clothes hide the marker; add one there, or move it.",
    "centroid noise": "Average over more cycles, or filter. Larger markers and longer lenses make larger images.",
    "lens model": "Linearise the cameras with a grid, or allow more lens terms; the maps show which camera.",
    "calibration": "Calibrate again, waving the wand through the whole volume, and before every session.",
    "marker placement": "Palpate twice, one examiner a subject, joint centres found from motion. Cameras cannot help.",
}
"""What helps against each source of error."""

EVIDENCE = {
    "given": "as given",
    "residual_scatter": "scatter of the residuals",
    "calibration_residuals": "residuals of the calibration",
    "usual_noise": "assumed: no marker is seen by three cameras",
    "residuals_of_regions": "residuals that are alike in one part of an image",
    "outlying_residuals": "points with residuals far beyond all others",
    "residuals_of_cameras": "a change of the cameras that the residuals ask for; scale cannot be seen",
    "calibration_covariance": "covariance of the calibration",
    "usual_placement": "assumed, {mm:.4g} mm along each axis",
}
"""By `ErrorSource.evidence`."""


def evidence_text(source: Mapping[str, Any]) -> str:
    """How a source of the ranking is known."""
    return EVIDENCE[source["evidence"]].format(mm=source["mm"] if source["mm"] is not None else float("nan"))
