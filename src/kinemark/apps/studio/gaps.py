"""The gaps of a trial: how each can be filled and how well, judged behind while the page shows what is known."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from ...data import KinemarkError, MarkerTrajectory, Origin, Trajectories
from ...data.edits import BEST, OPEN, GapChoice, is_named
from ...engine.last_fill import last_filled
from ...fill import LIMIT, Filled, FilledGap
from ...fill.methods.stage import FILL
from ...fill.prepared import GapFill, PreparedFill, prepare
from .desk import OpenDocument
from .edit_messages import Candidate, GapCandidates, GapRow, Gaps, MethodError
from .header import finite

POOL = ThreadPoolExecutor(1, "gaps")
"""Judges gaps, one at a time, so that edits are answered at once meanwhile."""


FEW = 3
"""Gaps that are judged one by one, at most; chosen: as after an edit of a marker."""
Key = tuple[str, int, int]
"""Marker, first frame and last-plus-one, from 0."""


class Gap(NamedTuple):
    """A gap of a marker: its frames from 0, stop excluded."""

    path: MarkerTrajectory
    start: int
    stop: int

    @property
    def key(self) -> Key:
        """By which it is known."""
        return self.path.name, self.start, self.stop


@dataclass(slots=True)
class GapWork:
    """What is known of the gaps of an open trial, by marker, frames and method; worth something while the path is."""

    answers: dict[tuple[Key, str], tuple[MarkerTrajectory, Future[GapFill]]] = field(default_factory=dict)
    prepared: PreparedFill | None = None

    def of(self, document: OpenDocument) -> PreparedFill:
        """The trial as it is now, prepared once."""
        now = document.now.trajectories
        if self.prepared is None or self.prepared.trajectories is not now:
            self.prepared = prepare(now)
        return self.prepared

    def ask(self, document: OpenDocument, gap: Gap, method: str) -> Future[GapFill]:
        """How a method fills a gap, "best" for what filling would take; worked out behind."""
        key = gap.key, method
        known = self.answers.get(key)
        if known is None or known[0] is not gap.path:
            self.answers[key] = known = gap.path, POOL.submit(self._answer, document, gap, method)
        return known[1]

    def ask_all(self, document: OpenDocument, gaps: Sequence[Gap]) -> None:
        """How filling would fill each of some gaps; many are worked out together, which takes as long as a few."""
        left = [gap for gap in gaps if not self._asked(gap, BEST)]
        if len(left) <= FEW:
            for gap in left:
                self.ask(document, gap, BEST)
            return
        asked = [(gap, Future[GapFill]()) for gap in left]
        self.answers |= {(gap.key, BEST): (gap.path, answer) for gap, answer in asked}
        POOL.submit(self._answer_all, document, asked)

    def _asked(self, gap: Gap, method: str) -> bool:
        known = self.answers.get((gap.key, method))
        return known is not None and known[0] is gap.path

    def known(self, gap: Gap, method: str) -> GapFill | None:
        """An answer that is there; the best fill answers for its own method."""
        best = self._done(gap, BEST)
        return best if method == BEST or (best is not None and best.method == method) else self._done(gap, method)

    def _done(self, gap: Gap, method: str) -> GapFill | None:
        found = self.answers.get((gap.key, method))
        if found is None or found[0] is not gap.path or not found[1].done() or found[1].exception() is not None:
            return None
        return found[1].result()

    def _answer_all(self, document: OpenDocument, asked: Sequence[tuple[Gap, Future[GapFill]]]) -> None:
        found: dict[Key, GapFill] = {}
        try:
            prepared = self.of(document)
            there = set(map(id, prepared.trajectories.paths))
            still = [gap for gap, _ in asked if id(gap.path) in there]
            fills = prepared.all_best(document.editing.computed) if still else ()
            found = {gap.key: one for gap in still if (one := _fill_of(gap, fills))}
        finally:  # whoever waits hears of it, whatever happened
            for gap, answer in asked:
                if gap.key in found:
                    answer.set_result(found[gap.key])
                else:
                    answer.set_exception(KinemarkError("this gap was not judged, or its marker was edited since"))

    def _answer(self, document: OpenDocument, gap: Gap, method: str) -> GapFill:
        if gap.path not in document.now.trajectories.paths:
            raise KinemarkError("this marker was edited since")
        prepared, frame = self.of(document), gap.start + document.now.trajectories.first_frame
        if method == BEST:
            return _within(gap, prepared.best(gap.path.name, frame))
        return _within(gap, prepared.candidates(gap.path.name, frame, methods=(FILL.make(method),))[0])


def _fill_of(gap: Gap, fills: Sequence[GapFill]) -> GapFill | None:
    """That of all fills which is of a gap."""
    own = (one for one in fills if one.gap.marker == gap.path.name and one.gap.start <= gap.start < one.gap.stop)
    return next((_within(gap, one) for one in own), None)


def _within(gap: Gap, fill: GapFill) -> GapFill:
    """The fill in the frames of a gap: filling takes samples beside it that cannot be positions for missing too."""
    at = slice(gap.start - fill.gap.start, gap.stop - fill.gap.start)
    said = replace(fill.gap, start=gap.start, stop=gap.stop)
    return replace(fill, gap=said, first=fill.first + at.start, xyz=fill.xyz[at], cov=fill.cov[at])


def work_of(document: OpenDocument) -> GapWork:
    """The work on a document's gaps."""
    with document.lock:
        found: GapWork = document.kept.setdefault("gaps", GapWork())
        return found


def gaps_in(trajectories: Trajectories) -> Iterator[Gap]:
    """Those between samples of named markers."""
    for path in trajectories:
        if is_named(path.name):
            yield from (Gap(path, start, stop) for start, stop in path.gaps)


def gaps_of_markers(document: OpenDocument) -> Iterator[Gap]:
    """Those of the trial as it is now, without points of a file that are no markers."""
    away = document.editing.computed
    yield from (gap for gap in gaps_in(document.now.trajectories) if gap.path.name not in away)


def gap_table(document: OpenDocument, *, judge: bool = True) -> Gaps:
    """Every gap with what is known of it; those that nobody judged are judged behind."""
    work, before = work_of(document), filled_before(document)
    rows, unknown = [], list[Gap]()
    for gap in gaps_of_markers(document):
        found = work.known(gap, BEST)
        said = found.gap if found else before.get(gap.key)
        if said is None and judge:
            unknown.append(gap)
        rows.append(_row(document, gap, said))
    work.ask_all(document, unknown)
    pending = any(not work.ask(document, gap, BEST).done() for gap in unknown)
    return Gaps(gaps=rows, limit_mm=LIMIT, pending=pending, head=document.head)


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
    quick = [_within(gap, one) for one in work.of(document).candidates(marker, first)]
    best = work.ask(document, gap, BEST)
    found = {one.method: one for one in quick}
    final = work.known(gap, BEST)
    if final is not None:
        found[final.method] = final
    expected = {name: _expected(one, final) for name, one in found.items()}
    order = sorted(found.values(), key=lambda one: (not np.isfinite(expected[one.method]), expected[one.method]))
    return GapCandidates(
        marker=marker,
        first=first,
        last=gap.stop - 1 + start,
        candidates=[_candidate(one, expected[one.method]) for one in order if np.isfinite(one.xyz).all()],
        best=final.method if final else None,
        pending=not best.done(),
        head=document.head,
    )


def chosen_fills(document: OpenDocument, names: Collection[str] | None = None) -> tuple[Trajectories, bool]:
    """The trial with the fills that somebody chose, else of the last run; and whether some are still computed.

    Only of these markers where `names` are given.
    """
    whole, work, pending = document.now.trajectories, work_of(document), False
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
            work.ask(document, gap, choice)
        pending |= fill is None
        if fill is not None:
            paths[gap.path.name] = _with(paths[gap.path.name], gap, fill.xyz, fill.cov)
    return replace(now, paths=tuple(paths[path.name] for path in now)), pending


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


def _row(document: OpenDocument, gap: Gap, said: FilledGap | None) -> GapRow:
    start, choice = document.now.trajectories.first_frame, _choice(document, gap)
    others = {} if said is None else {m: mm for m, mm in said.candidates.items() if m != said.method}
    return GapRow(
        marker=gap.path.name,
        first=gap.start + start,
        last=gap.stop - 1 + start,
        frames=gap.stop - gap.start,
        method=(said.method or None) if said else None,
        expected_mm=finite(said.expected_mm) if said else None,
        others=[MethodError(method=m, expected_mm=finite(mm)) for m, mm in sorted(others.items(), key=lambda o: o[1])],
        cameras_alone=_alone(document, gap),
        state=_state(said, choice),
        choice=choice,
        words=said.reason if said else "",
    )


def _state(said: FilledGap | None, choice: str | None) -> Any:
    if choice is not None:
        return "open" if choice == OPEN else "chosen"
    if said is None:
        return "not judged"
    if not said.candidates and not said.method:
        return "no way"
    return "fillable" if said.method and said.expected_mm <= LIMIT else "above limit"


def _alone(document: OpenDocument, gap: Gap) -> list[str]:
    """The cameras whose image was used in the gap though no other saw the marker."""
    detections = document.editing.detections
    if detections is None or gap.path.detection.shape[1] != len(detections.cameras):
        return []
    seen = np.flatnonzero((gap.path.detection[gap.start : gap.stop] >= 0).any(0))
    return [detections.cameras[c] for c in seen.tolist()]


def _expected(fill: GapFill, final: GapFill | None) -> float:
    """mm, by all hold-out gaps where they are done: those of the first answer are fewer, and another measure."""
    if final is None or fill is final:
        return fill.expected_mm
    return final.gap.candidates.get(fill.method, fill.expected_mm)


def _candidate(fill: GapFill, expected_mm: float) -> Candidate:
    known = bool(np.isfinite(fill.sd).all())
    return Candidate(
        method=fill.method,
        expected_mm=finite(expected_mm),
        xyz=fill.xyz.tolist(),
        sd=fill.sd.tolist() if known else None,
    )
