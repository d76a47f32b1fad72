"""What became of the gaps of a trial: figures, a verdict and what deserves a look."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..data import Origin, Trajectories
from ..fill import Filled, FilledGap
from ..version import __version__
from .advice import Remark
from .plain import plain
from .words import count, millimetres, percent, some

UNSURE_MM = 10.0
"""An expected error from which a filled gap should be looked at before its values are used."""
MUCH = 0.2
"""Share of a marker's samples; if more is filled, it is hardly measured any more."""


def filling_figures(
    filled: Filled, before: Trajectories, *, source: str, method: str, limit_mm: float
) -> dict[str, Any]:
    """Everything that the page of a filled trial says, as plain data for JSON.

    Args:
        filled: what `fill.fill` gave.
        before: the trial before it.
        source: name of the trial or file; method: of filling; limit_mm: as given to `fill`.
    """
    gaps = [_gap(gap, filled.trajectories) for gap in filled.gaps]
    expected = np.array([gap["expected_mm"] for gap in gaps if gap["method"]], float)
    figures: dict[str, Any] = {
        "kinemark": __version__,
        "source": source,
        "method": method,
        "limit_mm": limit_mm,
        "rate_hz": before.rate,
        "frames": before.n_frames,
        "markers": len(before),
        "gaps": len(gaps),
        "filled": len(expected),
        "open": len(gaps) - len(expected),
        "missing_samples": _missing(before),
        "missing_after": _missing(filled.trajectories),
        "beyond": _missing(filled.trajectories) - sum(gap["frames"] for gap in gaps if not gap["method"]),
        "expected_median_mm": float(np.median(expected)) if len(expected) else None,
        "expected_worst_mm": float(expected.max()) if len(expected) else None,
        "by_method": dict(Counter(gap["method"] for gap in gaps if gap["method"]).most_common()),
        "never_seen": [path.name for path in filled.trajectories if (path.origin == Origin.MISSING).all()],
        "much_filled": [path.name for path in filled.trajectories if (path.origin == Origin.FILLED).mean() > MUCH],
        "list": gaps,
    }
    figures = plain(figures)
    figures["warnings"] = list(_remarks(figures))
    figures["verdict"] = _verdict(figures)
    return figures


def _missing(trajectories: Trajectories) -> int:
    return sum(int((path.origin == Origin.MISSING).sum()) for path in trajectories)


def _gap(gap: FilledGap, after: Trajectories) -> dict[str, Any]:
    """One gap; sd_worst_mm is the greatest standard deviation of an axis in it."""
    own = after[gap.marker].cov[gap.start : gap.stop]
    sd = np.sqrt(np.diagonal(own, axis1=1, axis2=2).max(1)) if gap.method else np.zeros(0)
    return {
        "marker": gap.marker,
        "first_frame": gap.start + after.first_frame,
        "last_frame": gap.stop - 1 + after.first_frame,
        "first_s": gap.start / after.rate,
        "length_s": gap.length / after.rate,
        "frames": gap.length,
        "method": gap.method,
        "expected_mm": gap.expected_mm,
        "sd_worst_mm": float(np.nanmax(sd)) if np.isfinite(sd).any() else None,
        "candidates_mm": dict(gap.candidates),
        "tests": gap.tests,
        "donors": list(gap.donors),
        "reason": gap.reason,
    }


def _remarks(figures: dict[str, Any]) -> Iterator[Remark]:
    """What deserves a look."""
    unsure = [gap for gap in figures["list"] if gap["method"] and gap["expected_mm"] > UNSURE_MM]
    if figures["open"]:
        yield {
            "severity": "amber",
            "what": f"{count(figures['open'], 'gap')} stayed open, for the reasons in the table.",
            "do": "Raise the limit if a greater error does no harm, give a static trial, or do without these frames.",
        }
    if unsure:
        yield {
            "severity": "amber",
            "what": f"{count(len(unsure), 'gap')} may be off by more than {UNSURE_MM:g} mm, the worst by "
            f"{millimetres(max(gap['expected_mm'] for gap in unsure))} on average.",
            "do": "Look at their drawings; a lower limit leaves them open.",
        }
    if figures["much_filled"]:
        yield {
            "severity": "info",
            "what": f"{some('marker', figures['much_filled'])}: more than {percent(MUCH)} of the trial is filled.",
            "do": "What is computed from them rests on their neighbours.",
        }
    if figures["never_seen"]:
        yield {
            "severity": "amber",
            "what": f"{some('marker', figures['never_seen'])} never seen in this trial.",
            "do": "A static trial in which they are seen can place them: --static.",
        }


def _verdict(figures: dict[str, Any]) -> dict[str, Any]:
    """grade, headline and sentences."""
    if not figures["gaps"]:
        return {"grade": "green", "headline": "There was nothing to fill", "sentences": []}
    grade = "red" if not figures["filled"] else "amber" if figures["open"] or figures["warnings"] else "green"
    whole = (
        "All gaps are filled" if not figures["open"] else f"{figures['filled']} of {figures['gaps']} gaps are filled"
    )
    sentences = []
    if figures["filled"]:
        middle, worst = (millimetres(figures[f"expected_{which}_mm"]) for which in ("median", "worst"))
        sentences.append(
            f"In the middle gap a filled sample is expected to be {middle} off, in the worst {worst}. That was "
            "measured on this trial: known samples were hidden in gaps of the same length, filled in the same way, and "
            "compared."
        )
    if figures["beyond"]:
        sentences.append(
            f"{count(figures['beyond'], 'sample')} before a marker's first or after its last were not to be filled."
        )
    return {"grade": grade, "headline": whole, "sentences": sentences}


def filling_summary(figures: dict[str, Any]) -> str:
    """The figures as a few lines of text, with the gaps that stayed open."""
    names = ", ".join(f"{name} {n}" for name, n in figures["by_method"].items())
    lines = [f"{figures['verdict']['headline']}{': ' + names if names else ''}", *figures["verdict"]["sentences"]]
    for gap in figures["list"]:
        if not gap["method"]:
            frames = f"frames {gap['first_frame']} to {gap['last_frame']}"
            lines.append(f"  open: {gap['marker']}, {frames}: {gap['reason']}")
    return "\n".join(lines)
