"""What is probably wrong with a trial, and the edits that would mend it, for the page."""

from __future__ import annotations

from contextlib import suppress
from typing import NamedTuple

import numpy as np

from ...data import KinemarkError, MarkerTrajectory
from ...data import problems as core
from ...data.edits import Edit, GapChoice, Verdict, live
from ...data.progress import Cancelled, listening
from ...engine.problems import problems
from .acts_messages import AlternativeAct
from .desk import OpenDocument
from .edit_messages import Alternative, Problem, Problems
from .gap_work import work_of
from .gaps import judged_gaps
from .header import finite
from .turns import Rank

NEAR_FRAMES = 10
"""Frames beside the one to look at in which cameras are counted; chosen: a blink."""


class Looked(NamedTuple):
    """Problems that were looked for, in which version and state of the gaps, and the trial's paths then."""

    key: tuple[str, int, int]
    found: core.Problems
    paths: tuple[MarkerTrajectory, ...]


def problems_of(document: OpenDocument) -> core.Problems:
    """Those of the trial as it is edited now, worked out once for each version and state of the gaps.

    One looks at a time: whoever asked meanwhile finds those of the newest version, and none are worked out twice. For
    acts, which wait for them and keep others from the document: they give way to nothing. `listed` does.
    """
    with work_of(document).turns.hurried(), document.looking:
        while True:
            with suppress(Cancelled):
                return _found(document)


def _found(document: OpenDocument) -> core.Problems:
    """Those that are known of this version, or looked for; raises Cancelled where another version comes meanwhile."""
    gaps, now = judged_gaps(document), document.now.trajectories.paths
    key = document.head, document.ran, len(gaps)
    known: Looked | None = document.kept.get("problems")
    if known is None or known.key != key:
        turns = work_of(document).turns

        def go_on(*_: int) -> None:
            turns.give_way(Rank.BEHIND, unhurried=True)
            if document.head != key[0]:
                raise Cancelled

        with listening(go_on):
            document.kept["problems"] = known = Looked(key, problems(document.editing, gaps=gaps), now)
    return known.found


def worth_a_look(document: OpenDocument) -> int | None:
    """How many of them are, of the trial as it is now; None where they were not looked for yet."""
    known: Looked | None = document.kept.get("problems")
    return len(known.found.asked) if known is not None and known.key[:2] == (document.head, document.ran) else None


def listed(document: OpenDocument) -> Problems | None:
    """For the page; None where the trial is edited meanwhile, as the page asks again then.

    What is said meanwhile goes first, and those of a version that is no more are not looked for any longer. So requests
    do not pile up while somebody edits faster than problems are found: a browser has six at a time.
    """
    asked = document.head
    with suppress(Cancelled), document.looking:
        if document.head == asked:
            found = _found(document)
            rows = [_problem(document, one) for one in found.items]
            return Problems.like(found, problems=rows, worth_looking=len(found.asked), head=document.head)
    return None


def alternative_edits(document: OpenDocument, problem: str, key: str) -> tuple[Edit, ...]:
    """What an alternative says.

    Raises:
        KinemarkError: there is no such problem or alternative any more, or nothing is to be said.
    """
    one = _known(document, problem)
    edits = next((way.edits for way in one.alternatives if key_of(way) == key), ())
    if not edits:
        raise KinemarkError(f"There is no alternative {key!r} of this problem that says anything.")
    return edits


def verdict_on(document: OpenDocument, problem: str, *, right: bool) -> Verdict:
    """That a problem was looked at and is right as it is, or is wrong.

    Raises:
        KinemarkError: there is no such problem any more, or a verdict is none on it.
    """
    one = _known(document, problem)
    said = (edit for way in one.alternatives for edit in way.edits if isinstance(edit, Verdict))
    found = next(said, None)
    if found is None:
        raise KinemarkError("This is no question of right or wrong. Take one of its alternatives.")
    return Verdict(found.decision, found.where, right)


def key_of(way: core.Alternative) -> str:
    """What the page calls an alternative."""
    method = next((edit.method for edit in way.edits if isinstance(edit, GapChoice)), "")
    return f"{way.action}-{method}" if way.action == "fill" else way.action


def _known(document: OpenDocument, problem: str) -> core.Problem:
    """A problem; at once where it was known before and nothing was said of its tracks since."""
    before: Looked | None = document.kept.get("problems")
    with suppress(KeyError):
        if before is not None and _stands(one := before.found[problem], before, document):
            return one
    try:
        return problems_of(document)[problem]
    except KeyError as error:
        raise KinemarkError("This problem is there no more. Look at the list again.") from error


def _stands(one: core.Problem, before: Looked, document: OpenDocument) -> bool:
    """Whether all of a problem's tracks are as they were when it was found, and no way to settle it was said since."""
    if one.kind == "edit":  # which depends on the journal alone
        return False
    was, now = ({path.name: path for path in some} for some in (before.paths, document.now.trajectories))
    if any(name not in was or was[name] is not now.get(name) for name in one.tracks):
        return False
    said = {edit for entry in live(document.text.entries) for edit in entry.edits}
    return not any(said & set(way.edits) for way in one.alternatives)


def _problem(document: OpenDocument, one: core.Problem) -> Problem:
    ways = [_alternative(one, way) for way in one.alternatives]
    return Problem.like(
        one, wrong=finite(one.wrong), cost_mm=_off(one), alternatives=ways, images=_cameras(document, one)
    )


def _off(one: core.Problem) -> float | None:
    """mm that its samples are off where it is wrong, of a gap where it is filled; None where nothing tells."""
    if one.kind == "gap":
        return finite(one.values.get("expected_mm"))
    at_stake = one.wrong * one.at_stake
    return finite(one.cost / at_stake) if at_stake and not _assumed(one) else None


def _assumed(one: core.Problem) -> bool:
    """Whether how far off it is was not measured, but is the same for all such problems."""
    return "assumed_mm" in one.values or one.kind == "ghost" or (one.kind == "join" and len(one.tracks) > 1)


def _alternative(of: core.Problem, way: core.Alternative) -> Alternative:
    key = key_of(way)
    return Alternative.like(
        way,
        key=key,
        consequence=f"explains {way.images} images" if way.images is not None else "",
        **{name: finite(getattr(way, name)) for name in ("probability", "cost", "jump_mm")},
        act=AlternativeAct(kind="alternative", problem=of.id, key=key) if way.edits else None,
    )


def _cameras(document: OpenDocument, one: core.Problem) -> list[str]:
    """The cameras that see the tracks near the frame, those that see most first."""
    detections, now = document.editing.detections, document.now.trajectories
    if detections is None:
        return []
    f = one.frame - now.first_frame
    near = slice(max(f - NEAR_FRAMES, 0), f + NEAR_FRAMES + 1)
    seen = np.zeros(len(detections.cameras), np.int64)
    for path in now:
        if path.name in one.tracks and path.detection.shape[1] == len(seen):
            seen += (path.detection[near] >= 0).sum(0)
    return [detections.cameras[c] for c in np.argsort(-seen, kind="stable").tolist() if seen[c]]
