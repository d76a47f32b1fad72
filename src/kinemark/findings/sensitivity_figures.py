"""What limits the accuracy of a recording, as plain numbers, and the verdict.

How large an error of an angle may be: McGinley et al. (2009), reviewing the reliability of gait measurements, hold 2°
or less to be acceptable in most clinical situations, 2° to 5° reasonable if it is kept in mind, and more misleading.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from ..data import Finding, Severity, make_finding
from ..data.array_types import Floats
from ..sensitivity import ErrorSource, LostCamera, Ranking, typical
from ..sensitivity.ranked_sources import Unit
from ..version import __version__
from .plain import SCHEMA_VERSION, plain, quantile, share
from .verdict import Verdict, verdict_of

ACCEPTABLE_DEG, REASONABLE_DEG = 2.0, 5.0
"""deg; acceptable below 2°, reasonable to 5° (McGinley et al. 2009, on gait analysis)."""
CYCLES = (1, 2, 3, 4, 6, 8, 10, 15, 20)  # numbers of cycles in the table; chosen
MANY_GONE = 0.05  # of the points that a lost camera takes along; chosen

PLACEMENT = "marker placement"
"""The name of the source that is no camera's."""


def sensitivity_figures(ranking: Ranking, *, session: str, trial: str) -> dict[str, Any]:
    """Everything that the page says, as plain numbers."""
    rows = [_source(ranking, source) for source in ranking.sources]
    lost = [_lost(ranking, camera) for camera in ranking.lost]
    figures = {
        "kinemark": __version__,
        "schema_version": SCHEMA_VERSION,
        "session": session,
        "trial": trial,
        "ranked_by": ranking.unit,
        "angles": _angle_kind(ranking),
        "markers": len(ranking.markers),
        "placement_mm": ranking.method.placement_mm,
        "cycles": ranking.method.cycles,
        "ranking": rows,
        "total": {
            "mm": typical(ranking.total("mm")),
            "deg": _deg(ranking, ranking.total("deg")),
            "mean_mm": typical(ranking.total("mm", cycles=ranking.method.cycles)),
            "mean_deg": _deg(ranking, ranking.total("deg", cycles=ranking.method.cycles)),
            "cameras_mm": typical(ranking.total("mm", without=PLACEMENT)),
            "cameras_deg": _deg(ranking, ranking.total("deg", without=PLACEMENT)),
        },
        "lost": lost,
        "by_cycles": [_mean_of(ranking, n) for n in CYCLES],
        "by_marker": _by_marker(ranking),
        "by_angle": _by_angle(ranking),
        "calibration_stated_mm": ranking.stated_mm,
        "calibration_shown_mm": ranking.shown_mm,
        "degrees_of_freedom": ranking.evidence.freedom,
    }
    figures = plain(figures)
    findings, verdict = _verdict(figures)
    figures["findings"] = [found.as_dict() for found in findings]
    figures["verdict"] = verdict.as_dict()
    return figures


def _source(ranking: Ranking, source: ErrorSource) -> dict[str, Any]:
    n = ranking.method.cycles if source.averages else 1
    unit = ranking.unit
    squares = [typical(getattr(each, unit)) ** 2 for each in ranking.sources]
    whole = sum(each for each in squares if each == each)
    return {
        "source": source.name,
        "px": source.px,
        "mm": typical(source.mm),
        "mm_95": quantile(source.mm, 0.95),
        "deg": _deg(ranking, source.deg),
        "deg_95": quantile(source.deg, 0.95) if ranking.angles else math.nan,
        "mean_mm": typical(source.mm) / math.sqrt(n),
        "mean_deg": _deg(ranking, source.deg) / math.sqrt(n),
        "variance_share": share(typical(getattr(source, unit)) ** 2, whole),
        "without_it": typical(ranking.total(unit, without=source.name)),
        "averages": source.averages,
        "evidence": source.evidence,
    }


def _mean_of(ranking: Ranking, n: int) -> dict[str, Any]:
    row: dict[str, Any] = {"cycles": n}
    units: tuple[Unit, ...] = ("mm", "deg") if ranking.angles else ("mm",)
    for unit in units:
        row[unit] = typical(ranking.total(unit, cycles=n))
        row[f"cameras_{unit}"] = typical(ranking.total(unit, without=PLACEMENT, cycles=n))
    return row


def _lost(ranking: Ranking, camera: LostCamera) -> dict[str, Any]:
    return {
        "camera": camera.camera,
        "mm": typical(camera.mm),
        "all_mm": typical(camera.all_mm),
        "cost_mm": camera.cost("mm"),
        "deg": _deg(ranking, camera.deg),
        "cost_deg": camera.cost("deg") if ranking.angles else math.nan,
        "gone_share": camera.gone,
    }


def _deg(ranking: Ranking, values: Floats) -> float:
    return typical(values) if ranking.angles else math.nan


def _angle_kind(ranking: Ranking) -> str:
    if ranking.by_model:
        return f"{len(ranking.angles)} joint angles"
    if ranking.angles:
        return f"directions of {len(ranking.angles) // 2} segments"
    return "none"


def _by_marker(ranking: Ranking) -> list[dict[str, Any]]:
    return [
        {"marker": name} | {source.name: typical(source.mm[m]) for source in ranking.sources}
        for m, name in enumerate(ranking.markers)
    ]


def _by_angle(ranking: Ranking) -> list[dict[str, Any]]:
    step = 1 if ranking.by_model else 2  # both turns of a segment are one row
    return [
        {"angle": ranking.angles[a].removesuffix(", turn 1")}
        | {source.name: typical(source.deg[:, a : a + step]) for source in ranking.sources}
        for a in range(0, len(ranking.angles), step)
    ]


def _verdict(figures: dict[str, Any]) -> tuple[list[Finding], Verdict]:
    """What limits the recording, and how much it is; the size of the error makes the grade."""
    headline = make_finding("error_limited_by", severity=_severity(figures), source=figures["ranking"][0]["source"])
    findings = [headline, *_errors(figures), *_losses(figures["lost"])]
    return findings, verdict_of(findings, findings)


def _severity(figures: dict[str, Any]) -> Severity:
    mean = figures["total"]["mean_deg"]
    if figures["ranked_by"] == "deg" and mean is not None:
        return "info" if mean <= ACCEPTABLE_DEG else "amber" if mean <= REASONABLE_DEG else "red"
    return "info" if figures["ranking"][0]["source"] == PLACEMENT else "amber"


def _errors(figures: dict[str, Any]) -> Iterator[Finding]:
    unit, total, first = figures["ranked_by"], figures["total"], figures["ranking"][0]
    kind = "error_of_angle" if unit == "deg" else "error_of_position"
    yield make_finding(
        kind,
        **{f"frame_{unit}": total[unit], f"mean_{unit}": total[f"mean_{unit}"]},
        cycles=figures["cycles"],
        source=first["source"],
        variance_share=first["variance_share"],
    )
    angle = total["cameras_deg"] if unit == "deg" else None
    yield make_finding("error_of_cameras", position_mm=total["cameras_mm"], angle_deg=angle)
    if first["source"] == PLACEMENT:
        yield make_finding(
            "placement_assumed",
            placement_mm=figures["placement_mm"],
            next_source=figures["ranking"][1]["source"],
        )


def _losses(lost: list[dict[str, Any]]) -> Iterator[Finding]:
    if not lost:
        yield make_finding("two_cameras_no_loss")
        return
    first = lost[0]
    yield make_finding(
        "camera_most_missed",
        cameras=[first["camera"]],
        without_mm=first["mm"],
        with_mm=first["all_mm"],
        lost_share=first["gone_share"],
    )
    holes = [row["camera"] for row in lost if row["gone_share"] > MANY_GONE]
    if holes and first["mm"] is not None:
        yield make_finding("cameras_losing_points", cameras=holes, limit_share=MANY_GONE)
