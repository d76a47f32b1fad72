"""What became of the gaps of a trial: figures, what needs attention, and the verdict."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..data import Finding, Origin, Trajectories, make_finding
from ..data import MarkerTrajectory as MarkerPath
from ..data.finding import most_severe_first, red_if
from ..fill import Filled, FilledGap, MarkerArray, find_gaps, usual_limit
from ..fill.fill import of_markers
from ..fill.known_samples import plausible
from ..version import __version__
from .plain import SCHEMA_VERSION, plain
from .verdict import verdict_of

UNSURE = 0.5
"""Share of the usual limit; an expected error, or a standard deviation, that is greater should be looked at before
its values are used; chosen: 10 mm on a person."""
MORE_MOTION = 2.0
"""Times the motion of all hold-out gaps, above which the error of a gap is expected by extrapolation; chosen."""
MUCH = 0.2
"""Share of a marker's samples; if more is filled, it is hardly measured any more; chosen."""
STATIC = "static"


def filling_figures(
    filled: Filled,
    before: Trajectories,
    *,
    source: str,
    method: str,
    limit_mm: float | None,
    computed: int = 0,
) -> dict[str, Any]:
    """Everything that the page of a filled trial says, as plain data for JSON.

    Args:
        filled: what `fill.fill` gave.
        before: the trial before it.
        source: name of the trial or file; method: of filling; limit_mm: as given to `fill`, which may be None.
        computed: points of the file with missing samples that are no markers, and were not looked at.
    """
    after = filled.trajectories
    gaps = [_gap(gap, after) for gap in filled.gaps]
    usual = usual_limit(before.xyz)
    figures: dict[str, Any] = {
        "kinemark": __version__,
        "schema_version": SCHEMA_VERSION,
        "source": source,
        "method": method,
        "limit_mm": usual if limit_mm is None else limit_mm,
        "rate_hz": before.rate,
        "frames": before.n_frames,
        "markers": len(before),
        **_counts(gaps),
        "missing_samples": _missing(before),
        "missing_after": _missing(after),
        "beyond": sum(_beyond(path) for path in _of_markers(after))
        - sum(_at_an_end(gap, before) for gap in filled.gaps),
        "never_seen": [path.name for path in after if (path.origin == Origin.MISSING).all()],
        "much_filled": [path.name for path in after if (path.origin == Origin.FILLED).mean() > MUCH],
        "far_away": _far_away(before),
        **_nameless(before),
        "computed_points": computed,
        "list": gaps,
    }
    figures = plain(figures)
    findings = most_severe_first(list(_findings(figures, UNSURE * usual)))
    figures["findings"] = [found.as_dict() for found in findings]
    figures["verdict"] = verdict_of(findings, _statements(figures)).as_dict()
    return figures


def _counts(gaps: list[dict[str, Any]]) -> dict[str, Any]:
    """How many gaps there are and what became of them."""
    done = [gap for gap in gaps if gap["method"]]
    known = [gap for gap in done if np.isfinite(gap["expected_mm"])]
    tested = [gap["expected_mm"] for gap in known if gap["method"] != STATIC]
    return {
        "gaps": len(gaps),
        "filled": len(done),
        "open": len(gaps) - len(done),
        "replaced": sum(len(gap["trimmed"]) for gap in done),
        "suspicious": len({(gap["marker"], frame) for gap in gaps for frame in gap["suspicious"]}),
        "expected_median_mm": float(np.median(tested)) if tested else None,
        "expected_max_mm": max((gap["expected_mm"] for gap in known), default=None),
        "unknown": len(done) - len(known),
        "by_method": dict(Counter(gap["method"] for gap in done).most_common()),
    }


def _missing(trajectories: Trajectories) -> int:
    return sum(int((path.origin == Origin.MISSING).sum()) for path in trajectories)


def _of_markers(trajectories: Trajectories) -> list[MarkerPath]:
    """Without tracks that have no name beside such as have one: `fill` leaves them."""
    named = [path for path in trajectories if not path.name.startswith("*")]
    return named or list(trajectories)


def _beyond(path: MarkerPath) -> int:
    """Frames before a marker's first sample and after its last; none of a marker that is never seen."""
    seen = np.flatnonzero(path.origin != Origin.MISSING)
    return int(seen[0] + len(path) - 1 - seen[-1]) if len(seen) else 0


def _at_an_end(gap: FilledGap, before: Trajectories) -> int:
    """Frames of a gap at an end of the trial that was to be filled and stayed open."""
    at_end = (gap.start == 0) != (gap.stop == before.n_frames)
    return gap.length - len(gap.trimmed) if at_end and not gap.method else 0


def _nameless(trajectories: Trajectories) -> dict[str, int]:
    """Tracks whose gaps are none of a marker's, and these gaps."""
    motion = MarkerArray.of(trajectories)
    gaps = find_gaps(motion)
    left = set(gaps) - set(of_markers(gaps, motion.names))
    return {"nameless_tracks": len({gap.marker for gap in left}), "nameless_gaps": len(left)}


def _far_away(trajectories: Trajectories) -> int:
    """Samples that cannot be positions."""
    motion = MarkerArray.of(trajectories)
    return int((motion.seen & ~plausible(motion.xyz)).sum())


def _gap(gap: FilledGap, after: Trajectories) -> dict[str, Any]:
    """One gap; sd_max_mm: the greatest standard deviation of an axis in it; trimmed: measured frames replaced.

    Suspicious samples of a gap that was to be trimmed and stays open are kept.
    """
    sd = np.array([gap.sd_mm])
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
        "sd_max_mm": float(np.nanmax(sd)) if np.isfinite(sd).any() else None,
        "jump_mm": gap.jump_mm,
        "sides_mm": gap.sides_mm,
        "motion_ratio": gap.motion_ratio,
        "candidates_mm": dict(gap.candidates),
        "tests": gap.tests,
        "reference_markers": list(gap.reference_markers),
        "trimmed": [frame + after.first_frame for frame in gap.trimmed] if gap.method else [],
        "suspicious": [frame + after.first_frame for frame in gap.suspicious],
        "off_mm": gap.off_mm,
        "state": gap.state,
        "reason": gap.reason,
    }


def largest_error(gap: dict[str, Any]) -> float:
    """Greatest of what is said of a gap's error, mm."""
    return max(gap["expected_mm"] or 0.0, gap["sd_max_mm"] or 0.0)


def _more_motion(gap: dict[str, Any]) -> bool:
    """Whether the body part moves clearly more in a gap than in any hold-out gap that tells its error."""
    return gap["motion_ratio"] is not None and gap["motion_ratio"] > MORE_MOTION


def _findings(figures: dict[str, Any], unsure_mm: float) -> Iterator[Finding]:
    """What needs attention; gaps that may be farther off are uncertain."""
    uncertain = [largest_error(gap) for gap in figures["list"] if gap["method"] and largest_error(gap) > unsure_mm]
    stayed_open = sum(not gap["method"] and gap["state"] != "left_open" for gap in figures["list"])
    if stayed_open:
        yield make_finding("gaps_open", severity=red_if(not figures["filled"]), gaps=stayed_open)
    if uncertain:
        yield make_finding("gaps_uncertain", gaps=len(uncertain), limit_mm=unsure_mm, max_mm=max(uncertain))
    if figures["unknown"]:
        yield make_finding("gaps_untested", gaps=figures["unknown"])
    if beyond := [gap["motion_ratio"] for gap in figures["list"] if gap["method"] and _more_motion(gap)]:
        yield make_finding("gaps_beyond_tests", gaps=len(beyond), max_ratio=max(beyond))
    if n := figures["nameless_tracks"]:
        yield make_finding("tracks_not_filled", tracks=n, gaps=figures["nameless_gaps"])
    if n := figures["computed_points"]:
        yield make_finding("computed_not_filled", points=n)
    yield from _elsewhere(figures)
    yield from _odd_samples(figures)
    if figures["much_filled"]:
        yield make_finding("markers_mostly_filled", markers=figures["much_filled"], limit_share=MUCH)
    if figures["never_seen"]:
        markers = figures["never_seen"]
        yield make_finding("markers_absent", severity=red_if(_nothing_seen(figures)), markers=markers)


def _elsewhere(figures: dict[str, Any]) -> Iterator[Finding]:
    """Gaps after which a marker is elsewhere on its body, filled or not."""
    about = [gap for gap in figures["list"] if gap["sides_mm"]]
    if not about:
        return
    spans = [(gap["first_frame"], gap["last_frame"]) for gap in about]
    yield make_finding(
        "gap_sides_contradict",
        markers=dict.fromkeys(gap["marker"] for gap in about),
        frames=spans,
        gaps=len(about),
        where_list=[
            f"{gap['marker']} {first}–{last}, {gap['sides_mm']:.0f} mm apart"
            for gap, (first, last) in zip(about, spans, strict=True)
        ],
    )


def _odd_samples(figures: dict[str, Any]) -> Iterator[Finding]:
    """Samples that are no positions, that were replaced, or that stand out beside gaps."""
    if figures["far_away"]:
        yield make_finding("samples_far_away", samples=figures["far_away"])
    if figures["replaced"]:
        gaps = sum(bool(gap["trimmed"]) for gap in figures["list"])
        yield make_finding("samples_replaced", samples=figures["replaced"], gaps=gaps)
    if figures["suspicious"]:
        yield _suspicious(figures)


def _suspicious(figures: dict[str, Any]) -> Finding:
    """Measured samples beside gaps that stand out and were kept: how many, of which markers, in which frames.

    How far the farthest of a gap is off a fill that does not follow them stands beside them.
    """
    about = [gap for gap in figures["list"] if gap["suspicious"]]
    spans = [(gap, *span) for gap in about for span in _spans(gap["suspicious"])]
    return make_finding(
        "samples_suspicious",
        markers=dict.fromkeys(gap["marker"] for gap in about),
        frames=[(first, last) for _, first, last in spans],
        samples=figures["suspicious"],
        gaps=len(about),
        where_list=[_where(*span) for span in spans],
    )


def _where(gap: dict[str, Any], first: int, last: int) -> str:
    """One run of suspicious samples beside a gap, in words."""
    frames = f"{first}–{last}" if last > first else f"{first}"
    most = "up to " if len(gap["suspicious"]) > 1 else ""
    off = f" ({most}{gap['off_mm']:.1f} mm off)" if gap["off_mm"] else ""
    return f"{gap['marker']} {frames}{off}"


def _spans(frames: list[int]) -> list[tuple[int, int]]:
    """First and last of each run of successive frames, which are in rising order."""
    starts = [k for k, frame in enumerate(frames) if k == 0 or frame > frames[k - 1] + 1]
    return [(frames[a], frames[b - 1]) for a, b in zip(starts, [*starts[1:], len(frames)], strict=True)]


def _nothing_seen(figures: dict[str, Any]) -> bool:
    """Whether there are markers and none of them is seen; those that were placed count as seen."""
    return not figures["gaps"] and len(figures["never_seen"]) == figures["markers"] > 0


def _statements(figures: dict[str, Any]) -> Iterator[Finding]:
    """The headline, and what is expected of the filled samples."""
    if figures["gaps"]:
        yield make_finding("gaps_filled", filled=figures["filled"], gaps=figures["gaps"])
    else:
        yield make_finding("no_marker_seen" if _nothing_seen(figures) else "nothing_to_fill")
    if figures["expected_median_mm"] is not None:
        yield make_finding(
            "expected_gap_error", median_mm=figures["expected_median_mm"], max_mm=figures["expected_max_mm"]
        )
    if n := figures["by_method"].get(STATIC, 0):
        largest = max(gap["expected_mm"] or 0.0 for gap in figures["list"] if gap["method"] == STATIC)
        yield make_finding("markers_from_static", count=n, max_mm=largest)
    if n := figures["beyond"]:
        yield make_finding("samples_beyond", samples=n)
