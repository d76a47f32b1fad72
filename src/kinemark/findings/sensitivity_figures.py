"""What limits the accuracy of a recording, as plain numbers and sentences.

How large an error of an angle may be: McGinley et al. (2009), reviewing the reliability of gait measurements, hold 2°
or less to be acceptable in most clinical situations, 2° to 5° reasonable if it is kept in mind, and more misleading.
"""

from __future__ import annotations

import math
from typing import Any

from ..data.array_types import Floats
from ..report.formatting import measure, millimetres, number, percent, some
from ..sensitivity import ErrorSource, LostCamera, Ranking, typical
from ..sensitivity.ranked_sources import Unit
from ..version import __version__
from .plain import plain, quantile, share

ACCEPTABLE_DEG, REASONABLE_DEG = 2.0, 5.0
CYCLES = (1, 2, 3, 4, 6, 8, 10, 15, 20)
MANY_GONE = 0.05

ADVICE = {
    "disturbed images": "Find the camera from which limb or clothes hide the marker; add one there, or move it.",
    "centroid noise": "Average over more cycles, or filter. Larger markers and longer lenses make larger images.",
    "lens model": "Linearise the cameras with a grid, or allow more lens terms; the maps show which camera.",
    "calibration": "Calibrate again, waving the wand through the whole volume, and before every session.",
    "marker placement": "Palpate twice, one examiner a subject, joint centres found from motion. Cameras cannot help.",
}


def sensitivity_figures(ranking: Ranking, *, session: str, trial: str) -> dict[str, Any]:
    """Everything that the page says, as plain numbers."""
    rows = [_source(ranking, source) for source in ranking.sources]
    lost = [_lost(ranking, camera) for camera in ranking.lost]
    figures = {
        "kinemark": __version__,
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
            "cameras_mm": typical(ranking.total("mm", without="marker placement")),
            "cameras_deg": _deg(ranking, ranking.total("deg", without="marker placement")),
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
    figures["verdict"] = _verdict(figures)
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
        "origin": source.origin,
        "advice": ADVICE[source.name],
    }


def _mean_of(ranking: Ranking, n: int) -> dict[str, Any]:
    row: dict[str, Any] = {"cycles": n}
    units: tuple[Unit, ...] = ("mm", "deg") if ranking.angles else ("mm",)
    for unit in units:
        row[unit] = typical(ranking.total(unit, cycles=n))
        row[f"cameras_{unit}"] = typical(ranking.total(unit, without="marker placement", cycles=n))
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


def _verdict(figures: dict[str, Any]) -> dict[str, Any]:
    unit, total = figures["ranked_by"], figures["total"]
    first = figures["ranking"][0]
    value = degrees if unit == "deg" else millimetres
    word = {
        "centroid noise": "the noise of the centroids",
        "disturbed images": "images that are disturbed",
        "marker placement": "where the markers are put on",
    }
    name = word.get(first["source"], f"the {first['source']}")
    sentences = [
        f"{'An angle' if unit == 'deg' else 'A position'} is uncertain by {value(total[unit])} in a single "
        f"frame, one standard deviation, and by {value(total['mean_' + unit])} in a mean over "
        f"{number(figures['cycles'])} cycles. {percent(first['variance_share'])} of the variance is {name}."
    ]
    sentences.append(
        f"What the cameras do amounts to {millimetres(total['cameras_mm'])} for a marker along each axis"
        + (f" and {value(total['cameras_deg'])} for an angle." if unit == "deg" else ".")
    )
    if first["source"] == "marker placement":
        second = figures["ranking"][1]["source"]
        sentences.append(
            f"Placement is an assumption, {millimetres(figures['placement_mm'])} along each axis; say what yours is. "
            f"Of what the trial itself shows, {second} is the first."
        )
    sentences.append(_lost_words(figures["lost"]))
    if unit == "deg" and total["mean_deg"] is not None:
        grade = _grade(total["mean_deg"])
    else:
        grade = "green" if first["source"] == "marker placement" else "amber"
    return {"grade": grade, "headline": f"What limits this recording is {name}.", "sentences": sentences}


def _grade(deg: float) -> str:
    return "green" if deg <= ACCEPTABLE_DEG else "amber" if deg <= REASONABLE_DEG else "red"


def _lost_words(lost: list[dict[str, Any]]) -> str:
    if not lost:
        return "With two cameras nothing is measured when one is lost."
    words = [f"Without {lost[0]['camera']}, the camera most missed, "]
    if lost[0]["mm"] is None:
        return words[0] + "no point would be left."
    words.append(
        f"the cameras' part would be {millimetres(lost[0]['mm'])} instead of {millimetres(lost[0]['all_mm'])}"
        f" where something is left, and {percent(lost[0]['gone_share'])} of the points would be gone."
    )
    holes = [row["camera"] for row in lost if row["gone_share"] > MANY_GONE]
    if holes:
        words.append(f" Losing {some('camera', holes)} takes more than {percent(MANY_GONE)} of the points.")
    return "".join(words)


def sensitivity_summary(figures: dict[str, Any]) -> str:
    """Verdict and ranked table for the terminal."""
    n = figures["cycles"]
    lines = [f"{figures['session']} / {figures['trial']}: {figures['verdict']['headline']}"]
    lines += [f"  {sentence}" for sentence in figures["verdict"]["sentences"]]
    lines += ["", f"  {'source':18s}   px      mm   angle   mean of {n}   variance   how it is known"]
    for row in figures["ranking"]:
        lines.append(
            f"  {row['source']:18s} {number(row['px'], 3):>6s} {number(row['mm'], 2):>6s} {degrees(row['deg']):>7s} "
            f"{degrees(row['mean_deg']):>11s} {percent(row['variance_share']):>10s}   {row['origin']}"
        )
    total = figures["total"]
    lines.append(
        f"  {'all together':18s} {'':6s} {number(total['mm'], 2):>6s} {degrees(total['deg']):>7s} "
        f"{degrees(total['mean_deg']):>11s}"
    )
    lines += [
        f"  {'without ' + row['camera']:18s} {'':6s} {number(row['mm'], 2):>6s} {degrees(row['deg']):>7s}"
        f"   of the cameras' part alone, {percent(row['gone_share'])} of points gone"
        for row in figures["lost"][:3]
    ]
    return "\n".join(lines) + "\n"


def degrees(value: float | None, decimals: int = 2) -> str:
    """An angle with its sign, or a dash."""
    return measure(value, decimals, "°").replace("\u00a0°", "°")
