"""What is worked out of the gaps of an open trial, behind the page.

All gaps of a trial are judged together, which takes a tenth of the time of one by one, and tens of seconds where there
are hundreds. Who opens one of them meanwhile does not wait for the others: it is judged by itself, and the judging of
all, or of a few one by one, stands still until it is done. All of these stand still while the page waits for the quick
ways to fill one.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from ...data import KinemarkError, MarkerTrajectory
from ...data.edits import BEST
from ...data.progress import listening
from ...fill.methods.stage import FILL
from ...fill.prepared import GapFill, PreparedFill, prepare
from .desk import OpenDocument
from .turns import Rank, Turns

POOL = ThreadPoolExecutor(1, "gaps")
"""Judges gaps, one at a time, so that edits are answered at once meanwhile."""
FIRST = ThreadPoolExecutor(1, "gap that is looked at")
"""Judges what somebody waits for."""
FEW = 3
"""Gaps that are judged one by one, at most; chosen: as after an edit of a marker."""
STILL_S = 1.0
"""s after it was asked for last in which somebody still looks at a gap, though another one was looked at since; chosen:
the page asks every quarter of a second, and who goes through many gaps waits for the last. The gap that was looked at
last is gone on with, however long a busy machine lets the page wait."""
ALONE = "best alone"
"""As a method: the best by the tests of this gap alone, which says what is best until all were judged together."""
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
    looked: dict[Key, float] = field(default_factory=dict)
    last_looked: Key | None = None
    turns: Turns = field(default_factory=Turns)
    lock: threading.Lock = field(default_factory=threading.Lock)

    def of(self, document: OpenDocument) -> PreparedFill:
        """The trial as it is now, prepared once."""
        with self.lock:
            now = document.now.trajectories
            if self.prepared is None or self.prepared.trajectories is not now:
                self.prepared = prepare(now)
            return self.prepared

    def quick(self, document: OpenDocument, gap: Gap) -> list[GapFill]:
        """The ways to fill a gap that take no time to speak of."""
        with self.turns.taken(Rank.ASKED):
            found = self.of(document).candidates(gap.path.name, gap.start + document.now.trajectories.first_frame)
            return [_within(gap, one) for one in found]

    def look(self, document: OpenDocument, gap: Gap) -> None:
        """Somebody looks at a gap: what fills it best is worked out before the others."""
        self.looked[gap.key], self.last_looked = time.monotonic(), gap.key
        if self._done(gap, BEST) is None:
            self._ask(document, gap, ALONE, FIRST)

    def ask_all(self, document: OpenDocument, gaps: Sequence[Gap]) -> None:
        """How filling would fill each of some gaps; many are worked out together, which takes as long as a few."""
        left = [gap for gap in gaps if not self._asked(gap, BEST)]
        if len(left) <= FEW:
            for gap in left:
                self._ask(document, gap, BEST, POOL)
            return
        asked = [(gap, Future[GapFill]()) for gap in left]
        self.answers |= {(gap.key, BEST): (gap.path, answer) for gap, answer in asked}
        POOL.submit(self._answer_all, document, asked)

    def ask_chosen(self, document: OpenDocument, chosen: Sequence[tuple[Gap, str]]) -> None:
        """How gaps are filled by the methods that somebody chose; a few, as just now, before all others."""
        for gap, method in chosen:
            self._ask(document, gap, method, FIRST if len(chosen) <= FEW else POOL)

    def awaited(self, gap: Gap) -> bool:
        """Whether what fills a gap best is asked for, and not there yet."""
        return any(self._asked(gap, how) and not self.answers[gap.key, how][1].done() for how in (BEST, ALONE))

    def known(self, gap: Gap, method: str) -> GapFill | None:
        """An answer that is there; the best fill answers for its own method."""
        best = self._done(gap, BEST) or self._done(gap, ALONE)
        return best if method == BEST or (best is not None and best.method == method) else self._done(gap, method)

    def _ask(self, document: OpenDocument, gap: Gap, method: str, pool: ThreadPoolExecutor) -> None:
        """Work out behind how a method fills a gap, once."""
        if not self._asked(gap, method):
            work = self._answer_behind if pool is POOL else self._answer_first
            self.answers[gap.key, method] = gap.path, pool.submit(work, document, gap, method)

    def _asked(self, gap: Gap, method: str) -> bool:
        known = self.answers.get((gap.key, method))
        return known is not None and known[0] is gap.path

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
            with listening(lambda *_: self.turns.give_way(Rank.BEHIND)):
                fills = prepared.all_best(document.editing.computed) if still else ()
            found = {gap.key: one for gap in still if (one := _fill_of(gap, fills))}
        finally:  # whoever waits hears of it, whatever happened
            for gap, answer in asked:
                if gap.key in found:
                    answer.set_result(found[gap.key])
                else:
                    answer.set_exception(KinemarkError("this gap was not judged, or its marker was edited since"))

    def _answer_first(self, document: OpenDocument, gap: Gap, method: str) -> GapFill:
        """That of a gap that somebody looks at, as long as they do."""

        def go_on(*_: int) -> None:
            left = self.last_looked != gap.key and time.monotonic() - self.looked.get(gap.key, 0.0) > STILL_S
            if method == ALONE and left:
                self.answers.pop((gap.key, ALONE), None)  # who looks at it again asks again
                raise KinemarkError("nobody looks at this gap any more")
            self.turns.give_way(Rank.LOOKED_AT)

        go_on()
        with self.turns.taken(Rank.LOOKED_AT), listening(go_on):
            return self._answer(document, gap, BEST if method == ALONE else method)

    def _answer_behind(self, document: OpenDocument, gap: Gap, method: str) -> GapFill:
        """That of one of a few gaps, after what somebody waits for or looks at."""
        with listening(lambda *_: self.turns.give_way(Rank.BEHIND)):
            return self._answer(document, gap, method)

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
    found: GapWork = document.kept.setdefault("gaps", GapWork())  # without a lock: acts hold theirs while they wait
    return found
