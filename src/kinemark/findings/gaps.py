"""What became of the gaps of a trial: figures, a verdict and what deserves a look."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..data import MarkerTrajectory as MarkerPath
from ..data import Origin, Trajectories
from ..fill import Filled, FilledGap, MarkerArray
from ..fill.known_samples import possible
from ..report.formatting import count, millimetres, number, percent, some
from ..report.html_tables import WORDS
from ..version import __version__
from .plain import plain
from .trial_advice import Remark

UNSURE_MM = 10.0
"""An expected error, or a standard deviation, above which a gap should be looked at before its values are used."""
MUCH = 0.2
"""Share of a marker's samples; if more is filled, it is hardly measured any more."""
STATIC = "static"


def filling_figures(
    filled: Filled, before: Trajectories, *, source: str, method: str, limit_mm: float
) -> dict[str, Any]:
    """Everything that the page of a filled trial says, as plain data for JSON.

    Args:
        filled: what `fill.fill` gave.
        before: the trial before it.
        source: name of the trial or file; method: of filling; limit_mm: as given to `fill`.
    """
    after = filled.trajectories
    gaps = [_gap(gap, after) for gap in filled.gaps]
    done = [gap for gap in gaps if gap["method"]]
    known = [gap for gap in done if np.isfinite(gap["expected_mm"])]
    tested = [gap["expected_mm"] for gap in known if gap["method"] != STATIC]
    figures: dict[str, Any] = {
        "kinemark": __version__,
        "source": source,
        "method": method,
        "limit_mm": limit_mm,
        "rate_hz": before.rate,
        "frames": before.n_frames,
        "markers": len(before),
        "gaps": len(gaps),
        "filled": len(done),
        "open": len(gaps) - len(done),
        "missing_samples": _missing(before),
        "missing_after": _missing(after),
        "beyond": sum(_beyond(path) for path in after) - sum(_at_an_end(gap, before) for gap in filled.gaps),
        "replaced": sum(len(gap["trimmed"]) for gap in done),
        "expected_median_mm": float(np.median(tested)) if tested else None,
        "expected_worst_mm": max((gap["expected_mm"] for gap in known), default=None),
        "unknown": len(done) - len(known),
        "by_method": dict(Counter(gap["method"] for gap in done).most_common()),
        "never_seen": [path.name for path in after if (path.origin == Origin.MISSING).all()],
        "much_filled": [path.name for path in after if (path.origin == Origin.FILLED).mean() > MUCH],
        "far_away": _far_away(before),
        "list": gaps,
    }
    figures = plain(figures)
    figures["warnings"] = sorted(_remarks(figures), key=lambda remark: remark["severity"] == "info")
    figures["verdict"] = _verdict(figures)
    return figures


def _missing(trajectories: Trajectories) -> int:
    return sum(int((path.origin == Origin.MISSING).sum()) for path in trajectories)


def _beyond(path: MarkerPath) -> int:
    """Frames before a marker's first sample and after its last; none of a marker that is never seen."""
    seen = np.flatnonzero(path.origin != Origin.MISSING)
    return int(seen[0] + len(path) - 1 - seen[-1]) if len(seen) else 0


def _at_an_end(gap: FilledGap, before: Trajectories) -> int:
    """Frames of a gap at an end of the trial that was to be filled and stayed open."""
    at_end = (gap.start == 0) != (gap.stop == before.n_frames)
    return gap.length - len(gap.trimmed) if at_end and not gap.method else 0


def _far_away(trajectories: Trajectories) -> int:
    """Samples that cannot be positions."""
    motion = MarkerArray.of(trajectories)
    return int((motion.seen & ~possible(motion.xyz)).sum())


def _gap(gap: FilledGap, after: Trajectories) -> dict[str, Any]:
    """One gap; sd_worst_mm: the greatest standard deviation of an axis in it; trimmed: measured frames replaced."""
    sd = np.zeros(0)
    if gap.method:
        cov = after[gap.marker].cov[gap.start : gap.stop]
        sd = np.sqrt(np.diagonal(cov, axis1=1, axis2=2).max(1))
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
        "trimmed": [frame + after.first_frame for frame in gap.trimmed] if gap.method else [],
        "reason": gap.reason,
    }


def _remarks(figures: dict[str, Any]) -> Iterator[Remark]:
    """What deserves a look."""
    unsure = [gap for gap in figures["list"] if gap["method"] and worst_of(gap) > UNSURE_MM]
    if figures["open"]:
        yield {
            "severity": "amber",
            "what": f"{count(figures['open'], 'gap')} stayed open, for the reasons in the table.",
            "do": "Raise the limit if a greater error does no harm, give a static trial, or do without these frames.",
        }
    if unsure:
        yield {
            "severity": "amber",
            "what": f"{count(len(unsure), 'gap')} may be off by more than {UNSURE_MM:g} mm somewhere: that is their "
            "expected error, or a standard deviation within them, the worst "
            f"{millimetres(max(map(worst_of, unsure)))}.",
            "do": "Look at their drawings; a lower limit leaves open those whose expected error is great.",
        }
    if figures["unknown"]:
        yield {
            "severity": "amber",
            "what": f"{count(figures['unknown'], 'gap')} filled by a method that mostly had nothing to say in the "
            "hidden tests, so that nobody knows how far off it is.",
            "do": "Compare them with another method, or give a limit in mm.",
        }
    if figures["far_away"]:
        yield {
            "severity": "amber",
            "what": f"{count(figures['far_away'], 'sample')} farther than a kilometre from the others: no "
            "positions of markers. They are missing now, or filled.",
            "do": "Look where they come from; the file given still has them.",
        }
    yield from _remarks_on_markers(figures)


def worst_of(gap: dict[str, Any]) -> float:
    """Greatest of what is said of a gap's error, mm."""
    return max(gap["expected_mm"] or 0.0, gap["sd_worst_mm"] or 0.0)


def _remarks_on_markers(figures: dict[str, Any]) -> Iterator[Remark]:
    if figures["replaced"]:
        n = sum(bool(gap["trimmed"]) for gap in figures["list"])
        yield {
            "severity": "info",
            "what": f"{count(figures['replaced'], 'sample')} measured beside {count(n, 'gap')} stood out from the "
            "marker's own motion and were replaced (dots in the drawings).",
            "do": "Where the motion was right as it was measured, fill again with --trim 0 (trim = 0 in a session).",
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
            "do": "A static trial in which they are seen with three others of their segment can place them: --static.",
        }


def _verdict(figures: dict[str, Any]) -> dict[str, Any]:
    """grade, headline and sentences."""
    sentences = list(_sentences(figures))
    if figures["gaps"]:
        grade = "red" if not figures["filled"] else _grade(figures)
        some_of = f"{number(figures['filled'])} of {count(figures['gaps'], 'gap')}"
        filled = f"{some_of} {'is' if figures['filled'] == 1 else 'are'} filled"
        return {
            "grade": grade,
            "headline": filled if figures["open"] else "All gaps are filled",
            "sentences": sentences,
        }
    if figures["markers"] and len(figures["never_seen"]) == figures["markers"]:
        return {"grade": "red", "headline": "No marker is seen in this trial", "sentences": sentences}
    return {"grade": _grade(figures), "headline": "There was nothing to fill", "sentences": sentences}


def _grade(figures: dict[str, Any]) -> str:
    """Amber where anything but a note is said."""
    return "amber" if any(remark["severity"] != "info" for remark in figures["warnings"]) else "green"


def _sentences(figures: dict[str, Any]) -> Iterator[str]:
    if figures["expected_median_mm"] is not None:
        middle, worst = (_at_least(figures[f"expected_{which}_mm"]) for which in ("median", "worst"))
        yield (
            f"In the middle gap a filled sample is expected to be {middle} off, in the worst {worst}. That was "
            "measured on this trial: known samples were hidden in gaps of the same length, filled in the same way, and "
            "compared."
        )
    if n := figures["by_method"].get(STATIC, 0):
        worst = _at_least(max(gap["expected_mm"] or 0.0 for gap in figures["list"] if gap["method"] == STATIC))
        yield (
            f"{count(n, 'marker')} that the trial never shows {'is' if n == 1 else 'are'} placed from the static "
            f"trial, expected to be {worst} off at worst; that is told by how far neighbours move against each other."
        )
    if n := figures["beyond"]:
        verb = "was" if n == 1 else "were"
        yield f"{count(n, 'sample')} before a marker's first or after its last {verb} not to be filled (see --ends)."


def _at_least(mm: float) -> str:
    """A length, where it is too small to matter only a bound of it."""
    return millimetres(mm) if mm >= 0.01 else "less than 0.01\u00a0mm"


def filling_summary(figures: dict[str, Any]) -> str:
    """The figures as a few lines of text, with what deserves a look and the gaps that stayed open."""
    names = ", ".join(f"{name} {n}" for name, n in figures["by_method"].items())
    lines = [f"{figures['verdict']['headline']}{': ' + names if names else ''}", *figures["verdict"]["sentences"]]
    lines += [f"  {WORDS[remark['severity']]}: {remark['what']}" for remark in figures["warnings"]]
    for gap in figures["list"]:
        if not gap["method"]:
            frames = f"frames {gap['first_frame']} to {gap['last_frame']}"
            lines.append(f"  open: {gap['marker']}, {frames}: {gap['reason']}")
    return "\n".join(lines)
