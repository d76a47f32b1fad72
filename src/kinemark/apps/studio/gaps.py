"""The gaps of a trial: how each can be filled and how well, judged behind while the page shows what is known."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from ...data import KinemarkError, MarkerTrajectory, Origin, Trajectories
from ...data.edits import BEST, OPEN, GapChoice, is_named
from ...edit import Edited
from ...engine.editing.last_fill import last_filled
from ...fill import Filled, FilledGap, usual_limit
from ...fill.prepared import GapFill
from .desk import OpenDocument
from .edit_messages import Candidate, GapCandidates, GapRow, Gaps, MethodError
from .gap_work import Gap, Key, work_of
from .header import finite


def gaps_in(trajectories: Trajectories) -> Iterator[Gap]:
    """Those between samples of named markers."""
    for path in trajectories:
        if is_named(path.name):
            yield from (Gap(path, start, stop) for start, stop in path.gaps)


def gaps_of_markers(document: OpenDocument) -> Iterator[Gap]:
    """Those of the trial as it is now, without points of a file that are no markers."""
    away = document.editing.computed
    yield from (gap for gap in gaps_in(document.now.trajectories) if gap.path.name not in away)


def gap_table(document: OpenDocument) -> Gaps:
    """Every gap with what is known of it; those that nobody judged are judged behind."""
    work, before = work_of(document), filled_before(document)
    rows, unknown, limit = [], list[Gap](), _usual_limit(document)
    for gap in gaps_of_markers(document):
        found = work.known(gap, BEST)
        said = found.gap if found else before.get(gap.key)
        if said is None:
            unknown.append(gap)
        rows.append(_row(document, gap, said, limit))
    work.ask_all(document, unknown)
    pending = any(work.awaited(gap) for gap in unknown)
    return Gaps(gaps=rows, limit_mm=limit, pending=pending, head=document.head)


def judged_gaps(document: OpenDocument) -> tuple[FilledGap, ...]:
    """What filling says of the gaps, as far as it is known."""
    work, before = work_of(document), filled_before(document)
    found = []
    for gap in gaps_of_markers(document):
        answer = work.known(gap, BEST)
        said = answer.gap if answer else before.get(gap.key)
        found += [said] if said else []
    return tuple(found)


def filled_before(document: OpenDocument) -> dict[Key, FilledGap]:
    """What the last run said of gaps, by marker and frames; a gap beside which anything changed is not among them."""
    filled = _last(document)
    if filled is None:
        return {}
    said = {(gap.marker, gap.start, gap.stop): gap for gap in filled.gaps}
    old = {path.name: path for path in filled.trajectories}
    there = (gap.key for gap in gaps_in(document.now.trajectories) if _same(old, gap))
    return {key: said[key] for key in there if key in said}


def _last(document: OpenDocument) -> Filled | None:
    """What the last run filled, read once."""
    if "fills" not in document.kept:
        trial, measured = document.trial, document.editing.trajectories
        document.kept["fills"] = None if trial is None else last_filled(trial, measured)
    found: Filled | None = document.kept["fills"]
    return found


def _same(old: dict[str, MarkerTrajectory], gap: Gap) -> bool:
    """Whether the samples beside a gap are those that it was filled between."""
    path, ends = old.get(gap.path.name), [gap.start - 1, gap.stop]
    if path is None or len(path) != len(gap.path):
        return False
    return bool(np.array_equal(path.xyz[ends], gap.path.xyz[ends], equal_nan=True))


def candidates(document: OpenDocument, marker: str, first: int) -> GapCandidates:
    """Quick ways to fill a gap at once, all others behind.

    Raises:
        KinemarkError: there is no such gap.
    """
    start = document.now.trajectories.first_frame
    gap = next(
        (g for g in gaps_in(document.now.trajectories) if g.path.name == marker and g.start == first - start), None
    )
    if gap is None:
        raise KinemarkError(f"{marker} has no gap that begins in frame {first}. Look at the table again.")
    work = work_of(document)
    found = {one.method: one for one in work.quick(document, gap)}
    work.look(document, gap)
    final = work.known(gap, BEST)
    if final is not None:
        found[final.method] = final
    expected = {name: _expected(one, final) for name, one in found.items()}
    order = sorted(
        found.values(),
        key=lambda one: (not np.isfinite(expected[one.method]), expected[one.method], one is not final),
    )
    return GapCandidates(
        marker=marker,
        first=first,
        last=gap.stop - 1 + start,
        candidates=[_candidate(one, expected[one.method]) for one in order if np.isfinite(one.xyz).all()],
        best=final.method if final else None,
        pending=work.awaited(gap),
        head=document.head,
    )


def chosen_fills(document: OpenDocument, names: Collection[str] | None = None) -> tuple[Trajectories, bool]:
    """The trial with the fills that somebody chose, else of the last run; and whether some are still computed.

    Only of these markers where `names` are given.
    """
    whole, work, unknown = document.now.trajectories, work_of(document), list[tuple[Gap, str]]()
    now = whole if names is None else replace(whole, paths=tuple(path for path in whole if path.name in names))
    paths = _as_run_before(document, now)
    for gap in gaps_in(now):
        choice = _choice(document, gap)
        if choice is None:
            continue
        if choice == OPEN:
            paths[gap.path.name] = _with(paths[gap.path.name], gap, gap.path.xyz[gap.start : gap.stop], None)
            continue
        fill = work.known(gap, choice)
        if fill is None:
            unknown.append((gap, choice))
        else:
            paths[gap.path.name] = _with(paths[gap.path.name], gap, fill.xyz, fill.cov)
    work.ask_chosen(document, unknown)
    return replace(now, paths=tuple(paths[path.name] for path in now)), bool(unknown)


def may_show_fills(document: OpenDocument, of: Edited, names: Collection[str]) -> bool:
    """Whether some of these markers have gaps of which fills may be shown: chosen, or of the last run."""
    chosen = {choice.marker for choice in of.choices}
    some = [path for path in of.trajectories if path.name in names and path.gaps]
    return any(path.name in chosen for path in some) or (bool(some) and _last(document) is not None)


def _as_run_before(document: OpenDocument, now: Trajectories) -> dict[str, MarkerTrajectory]:
    """The markers with the fills of the last run, in gaps that are still the same."""
    paths, filled = {path.name: path for path in now}, _last(document)
    if filled is None:
        return paths
    old = {path.name: path for path in filled.trajectories}
    for gap in gaps_in(now):
        at = slice(gap.start, gap.stop)
        if _same(old, gap) and (old[gap.path.name].origin[at] == Origin.FILLED).all():
            paths[gap.path.name] = _with(
                paths[gap.path.name], gap, old[gap.path.name].xyz[at], old[gap.path.name].cov[at]
            )
    return paths


def _with(path: MarkerTrajectory, gap: Gap, xyz: Any, cov: Any) -> MarkerTrajectory:
    """A marker with a gap filled, or left open where `xyz` is NaN."""
    at = slice(gap.start, gap.stop)
    columns = {name: getattr(path, name).copy() for name in ("xyz", "cov", "origin")}
    columns["xyz"][at], columns["cov"][at] = xyz, np.nan if cov is None else cov
    known = np.isfinite(columns["xyz"][at]).all(1)
    columns["xyz"][at][~known] = np.nan
    columns["origin"][at] = np.where(known, Origin.FILLED, Origin.MISSING)
    return replace(path, **columns)


def _choice(document: OpenDocument, gap: Gap) -> str | None:
    """What somebody chose for a gap; the last word counts."""
    start = document.now.trajectories.first_frame
    first, last = gap.start + start, gap.stop - 1 + start

    def about(one: GapChoice) -> bool:
        return one.marker == gap.path.name and one.first <= last and one.last >= first

    mine = [one.method for one in document.now.choices if about(one)]
    return mine[-1] if mine else None


def _usual_limit(document: OpenDocument) -> float:
    """mm, that of the markers as they are now."""
    now, away = document.now.trajectories, document.editing.computed
    return usual_limit(now.xyz[[name not in away for name in now.names]])


def _row(document: OpenDocument, gap: Gap, said: FilledGap | None, limit_mm: float) -> GapRow:
    start, choice = document.now.trajectories.first_frame, _choice(document, gap)
    others = {} if said is None else {m: mm for m, mm in said.expected_of.items() if m != said.method}
    return GapRow(
        marker=gap.path.name,
        first=gap.start + start,
        last=gap.stop - 1 + start,
        frames=gap.stop - gap.start,
        method=(said.method or None) if said else None,
        expected_mm=None if said is None else finite(_expected_of(said, choice)),
        others=[MethodError(method=m, expected_mm=finite(mm)) for m, mm in sorted(others.items(), key=lambda o: o[1])],
        cameras_alone=_alone(document, gap),
        state=_state(said, choice, limit_mm),
        choice=choice,
        words=_words(said) if said else "",
    )


def _words(said: FilledGap) -> str:
    """What else is to be known of a gap: what its method lacked, and samples beside it that are in doubt."""
    if said.reason or not said.suspicious:
        return said.reason
    many = f"{len(said.suspicious)} samples" if len(said.suspicious) > 1 else "a sample"
    if said.off_mm:
        return f"does not follow {many} beside it, up to {said.off_mm:.1f} mm off"
    return f"{many} beside it in doubt"


def _expected_of(said: FilledGap, choice: str | None) -> float:
    """mm of the way that somebody chose, else of the best; NaN where that way was not judged."""
    return said.expected_mm if choice in (None, BEST, OPEN) else said.expected_of.get(choice or "", float("nan"))


def _state(said: FilledGap | None, choice: str | None, limit_mm: float) -> Any:
    if choice is not None:
        return "open" if choice == OPEN else "chosen"
    if said is None:
        return "not judged"
    if not said.candidates and not said.method:
        return "no way"
    return "fillable" if said.method and said.expected_mm <= limit_mm else "above limit"


def _alone(document: OpenDocument, gap: Gap) -> list[str]:
    """The cameras whose image was used in the gap though no other saw the marker."""
    detections = document.editing.detections
    if detections is None or gap.path.detection.shape[1] != len(detections.cameras):
        return []
    seen = np.flatnonzero((gap.path.detection[gap.start : gap.stop] >= 0).any(0))
    return [detections.cameras[c] for c in seen.tolist()]


def _expected(fill: GapFill, final: GapFill | None) -> float:
    """mm, by all hold-out gaps where they are done, NaN of a method that they left behind: those of the first answer
    are fewer, and another measure, by which it could seem better than the one that is proposed."""
    if final is None or fill is final:
        return fill.expected_mm
    return final.gap.expected_of.get(fill.method, float("nan"))


def _candidate(fill: GapFill, expected_mm: float) -> Candidate:
    known = bool(np.isfinite(fill.sd).all())
    return Candidate(
        method=fill.method,
        expected_mm=finite(expected_mm),
        xyz=fill.xyz.tolist(),
        sd=fill.sd.tolist() if known else None,
    )
