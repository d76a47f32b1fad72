"""Problems of a trial: what is probably wrong with it, and what can be said to mend it, in one list.

`problems(editing)` looks at the trial as it is edited now. What somebody gave a verdict on is not listed again, in this
processing or any other: the verdict finds its place by its witnesses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...data.edits import Verdict
from ...data.problems import Problem, ProblemKind, Problems
from ...edit.replay import Reviewed, reviewed
from ...edit.values import Footage
from ...fill import FilledGap, fill
from ...label import Template
from ..editing.editing import Editing
from .context import Context
from .exchanged_back import exchanged_back
from .found import ONCE
from .of_gaps import of_edits, of_gaps
from .of_names import of_names
from .of_paths import of_paths
from .together import together

__all__ = ["filled_gaps", "problems"]

NEAR_S = 0.2
"""s that a verdict may be beside a problem that it was on; chosen, as changes that are one problem."""
BEGINS_S, SURE = 0.5, 0.5
"""s that a change may be beside a stretch with wrong names to be its cause, and its least probability; chosen: names
are judged in windows of half a second."""
FAMILY: dict[str, str] = {"join": "swap", "stitch": "swap", "merge": "swap", "repeated": "lost", "shaken": "moved"}
"""Kinds of which one may be seen as another when a trial is processed again; others are of their own."""
BEFORE: dict[ProblemKind, int] = {"edit": 0}
"""Kinds that come first whatever they cost."""


def problems(
    editing: Editing, *, gaps: Sequence[FilledGap] = (), template: Template | None = None, one_by_one: bool = False
) -> Problems:
    """What is to be looked at, what saves most first.

    Args:
        editing: the trial.
        gaps: what filling said of its gaps; none are listed where it was not filled.
        template: of the subject, by which names are judged; what the trial is itself like where None.
        one_by_one: each step of a path by itself, which are one problem else (`together`).
    """
    edited = editing.edited()
    context = Context(editing, edited)
    found = [*of_edits(context), *of_gaps(context, gaps)]
    settled = _settled(context)
    seen = list(of_paths(context))
    seen += [one for one in of_names(context, template) if not _seen_by_motion(one, seen, context)]
    found += [one for one in seen if not any(_is_about(verdict, one, context) for verdict in settled)]
    if not one_by_one:
        found = list(together(context, list(exchanged_back(context, found))))
    order = sorted(found, key=lambda one: (BEFORE.get(one.kind, 1), not one.asked, -one.cost, one.first, one.id))
    return Problems(tuple(_with_own_ids(order)), editing.journal.head)


def filled_gaps(editing: Editing) -> tuple[FilledGap, ...]:
    """What filling says of each gap of a trial as it is edited now."""
    return fill(editing.edited().trajectories).gaps


def _settled(context: Context) -> list[Reviewed]:
    """Verdicts by the paths and frames of now."""
    e = context.editing
    of = Footage(context.start, context.now.rate, e.detections, e.rig, e.world, e.timed, e.left_out)
    return [reviewed(edit, context.now, of) for edit in context.edited.standing if isinstance(edit, Verdict)]


def _is_about(verdict: Reviewed, problem: Problem, context: Context) -> bool:
    """Whether a verdict was on this problem.

    What was wrong was mended, so that what is seen farther beside than one thing is seen twice is another one, as where
    two markers are exchanged for some frames; and what has another marker to it is, as where three are exchanged.
    """
    near = NEAR_S * context.now.rate if verdict.right else min(NEAR_S * context.now.rate, ONCE)
    kinds = [FAMILY.get(kind, kind) for kind in (verdict.decision, problem.kind)]
    first, last = problem.first - context.start, problem.last - context.start
    at_once = verdict.first - near <= last and verdict.last + near >= first
    names, tracks = {context.now.names[path] for path in verdict.paths}, set(problem.tracks)
    pieces = verdict.decision == problem.kind == "join"  # of a piece between two others both may be asked
    all_of_it = pieces or (problem.kind == "swap" and not verdict.right)
    return kinds[0] == kinds[1] and at_once and (tracks <= names if all_of_it else bool(names & tracks))


def _seen_by_motion(one: Problem, seen: Sequence[Problem], context: Context) -> bool:
    """Whether a stretch with wrong names begins where paths are seen to change already."""
    near = BEGINS_S * context.now.rate
    return any(
        other.kind in ("swap", "join", "spike")
        and other.wrong >= SURE
        and bool(set(other.tracks) & set(one.tracks))
        and one.first - near <= other.frame <= one.last + near
        for other in seen
    )


def _with_own_ids(found: Sequence[Problem]) -> list[Problem]:
    """No two with one id."""
    seen: dict[str, int] = {}
    out = []
    for one in found:
        k = seen.get(one.id, 0)
        seen[one.id] = k + 1
        out.append(one if not k else replace(one, id=f"{one.id}-{k + 1}"))
    return out
