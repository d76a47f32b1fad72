"""What needs attention in the lengths of a calibration: its scale, its wand, and where its cameras stand."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator

from ..data import Finding, make_finding
from ..data.finding import red_if
from .trial_findings import Figures

SCALE_AMBER, SCALE_RED = 0.005, 0.02
"""How far a length that took no part may come out wrong, as a share of it.
Chosen (see studies/calibration_quality.py)."""
WAND_AMBER, WAND_RED = 0.005, 0.02
"""RMS error of the wand's length, as a share of it, and …; chosen (see studies/calibration_quality.py)."""
WAND_FLOOR_MM = 1.0
"""… below this nobody minds; chosen (see studies/calibration_quality.py)."""
NEAREST_MM, FARTHEST_MM = 60.0, 500_000.0
"""Median distance between cameras; chosen: about a hand, a face or a mouse they stand 0.1 m apart, in rooms and halls
less than 60 mm if lengths were given in m. Cameras about a field of play stand 100 m apart, and of cameras half a metre
apart, mm that were taken for m make 500 m."""
SAME_PLACE_MM = 30.0
"""Cameras nearer to each other than this would be within each other; chosen (see studies/calibration_quality.py)."""
MOST_OFF = 4.0
"""Standard errors by which the wand's mean length about one place must be off to be reported.
Chosen (see studies/calibration_quality.py)."""
FEWEST_POSES = 5
"""About one place, from which its mean length is reported; chosen (see studies/calibration_quality.py)."""


def _scale(figures: Figures) -> Iterator[Finding]:
    for check in figures["checks"]:
        off = abs(check["error_share"] or 0)
        if off > SCALE_AMBER:
            yield make_finding(
                "scale_doubtful",
                severity=red_if(off > SCALE_RED),
                length=check["what"],
                known_mm=check["known_mm"],
                found_mm=check["found_mm"],
                error_share=off,
            )
    places = [c["position_mm"] for c in figures["cameras"]]
    apart = statistics.median(math.dist(a, b) for i, a in enumerate(places) for b in places[:i])
    if not NEAREST_MM <= apart <= FARTHEST_MM:
        yield make_finding("cameras_distance_implausible", apart_mm=apart)


def _same_place(figures: Figures) -> Iterator[Finding]:
    cameras = figures["cameras"]
    for i, a in enumerate(cameras):
        for b in cameras[:i]:
            if math.dist(a["position_mm"], b["position_mm"]) < SAME_PLACE_MM:
                yield make_finding("cameras_at_one_place", cameras=[b["name"], a["name"]])


def _wand(figures: Figures) -> Iterator[Finding]:
    wand = figures["wand"]
    if not wand or not wand["poses"]:
        return
    length = sum(wand["known_mm"]) / len(wand["known_mm"])
    error = wand["error_rms_mm"]
    if error > max(WAND_FLOOR_MM, WAND_AMBER * length):
        severity = red_if(error > max(WAND_FLOOR_MM, WAND_RED * length))
        yield make_finding("wand_length_wrong", severity=severity, rms_mm=error)
    for cell in wand["by_place"]:
        surely = MOST_OFF * (cell["error_sd_mm"] or 0) / math.sqrt(cell["poses"])
        limit = max(WAND_FLOOR_MM, WAND_AMBER * length, surely)
        if cell["poses"] >= FEWEST_POSES and abs(cell["error_mean_mm"]) > limit:
            yield make_finding(
                "wand_length_wrong_here", place_mm_list=cell["middle_mm"], error_mm=cell["error_mean_mm"]
            )


LENGTH_CHECKS = (_scale, _same_place, _wand)
