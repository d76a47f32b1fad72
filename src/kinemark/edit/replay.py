"""All that was said of a trial, applied to it: a pure function of trajectories and journal.

    claims → names (1) → erase, put, smooth, images, in their order (2) → choices for gaps, events (3) → trim, drop (4)

(1) and (2) change the trajectories; (3) is for filling and for the file that is written, and (4) for what comes last,
so that filling can use what is trimmed. Of each edit it is said what became of it; what does not find its place is
neither dropped nor applied to anything else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..data import Detections, Rig, Trajectories
from ..data.edit_outcomes import Applied, Outcome
from ..data.edits import (
    AddEvent,
    Claim,
    DropUnnamed,
    Edit,
    Entry,
    Erase,
    GapChoice,
    ImagePoint,
    Put,
    Trim,
    Verdict,
    facts_of,
    is_named,
    live,
)
from .anchors import ELSEWHERE, followed, is_of_no_path
from .claims import ENOUGH, FEW_UNSURE, UNSURE, Claimed, with_claims
from .folds import Folded, ValueEdit, with_values
from .moves import carried_over, is_moved
from .values import Footage, Result
from .votes import votes

MOVED = "all places of the file were moved since, and its own go with them"
"""Why an edit has other places than it was stated with."""
TRACKED_ELSEWHERE = Result("moot", reason="tracking had it as a fact, and the marker is elsewhere there now")
"""What becomes of samples erased from a path that tracking, told of them, did not make again."""


class Reviewed(NamedTuple):
    """An ambiguous decision with a verdict: its kind, frames from 0, the paths (indices) it is about, whether right."""

    decision: str
    first: int
    last: int
    paths: tuple[int, ...]
    right: bool


@dataclass(frozen=True, slots=True, eq=False)
class Edited:
    """A trial as people said that it is.

    Attributes:
        trajectories: the markers, before filling.
        applied: what became of each edit, in the order of the journal.
        reviewed: ambiguous decisions that nobody is to be asked about again; paths are those before all edits.
        folds: markers with their edits of values, which the next version may use again.
    """

    trajectories: Trajectories
    applied: tuple[Applied, ...] = ()
    reviewed: tuple[Reviewed, ...] = ()
    folds: tuple[Folded, ...] = ()

    @property
    def standing(self) -> tuple[Edit, ...]:
        """The edits that stand."""
        return tuple(one.edit for one in self.applied if one.outcome in ("held", "thin"))

    @property
    def choices(self) -> tuple[GapChoice, ...]:
        """For gaps."""
        return tuple(edit for edit in self.standing if isinstance(edit, GapChoice))

    @property
    def events(self) -> tuple[AddEvent, ...]:
        """To be added."""
        return tuple(edit for edit in self.standing if isinstance(edit, AddEvent))

    @property
    def named_only(self) -> bool:
        """Whether what has no marker's name is left out in the end."""
        return any(isinstance(edit, DropUnnamed) for edit in self.standing)

    @property
    def kept(self) -> tuple[int, int]:
        """First frame and last-plus-one, from 0, of what is left in the end."""
        n, start = self.trajectories.n_frames, self.trajectories.first_frame
        trims = [edit for edit in self.standing if isinstance(edit, Trim)]
        if not trims:
            return 0, n
        return max(trims[-1].first - start, 0), min(max(trims[-1].last - start + 1, 0), n)


def replay(
    trajectories: Trajectories,
    entries: Sequence[Entry],
    *,
    detections: Detections | None = None,
    timed: Detections | None = None,
    rig: Rig | None = None,
    world: str = "",
    left_out: tuple[tuple[str, int, int], ...] = (),
    facts: bool = False,
) -> Edited:
    """The trial with all entries that count.

    Args:
        trajectories: as they come from tracking and naming, or from a file.
        entries: of the journal, undone ones among them.
        detections, rig: behind the samples; None for a file without. timed: the detections at the times of the frames,
            the same rows; None where all cameras are in time.
        world: key of the cameras in whose world the trial is; claims made in another one are found by images alone.
        left_out: cameras and frames in which they fit the others no more, as `Footage` has them.
        facts: the claims were facts by which the markers were named, so that they hold where they change nothing.
    """
    tracked_by, counting = facts_of(entries) if facts else (), live(entries)
    stated = [edit for entry in counting for edit in entry.edits]
    of = Footage(trajectories.first_frame, trajectories.rate, detections, rig, world, timed, left_out)
    numbers = [entry.id for entry in counting for _ in entry.edits]
    said = list(zip(numbers, carried_over(stated, trajectories, of), strict=True))
    claims = [edit for edit in _as_tracked(said, tracked_by) if isinstance(edit, Claim)]
    claimed = with_claims(trajectories, claims, detections, world=world)
    said = [(number, followed(edit, trajectories, claimed.trajectories, of)) for number, edit in said]
    values = [edit for _, edit in said if isinstance(edit, ValueEdit)]
    after, results, folds = with_values(claimed.trajectories, values, of)
    of_claims = iter([_claim_outcome(claimed, k, facts, claim.name) for k, claim in enumerate(claims)])
    of_values = iter(results)
    tracked = {entry.id for entry in tracked_by}

    def applied(number: int, edit: Edit) -> Applied:
        if isinstance(edit, Claim):
            return Applied(number, edit, *next(of_claims))
        result = next(of_values) if isinstance(edit, ValueEdit) else _result(edit, trajectories, after, of)
        if number in tracked and isinstance(edit, Erase) and result == ELSEWHERE:
            result = TRACKED_ELSEWHERE
        return Applied(number, edit, result.outcome, 1.0, result.samples, result.reason)

    outcomes = [applied(number, edit) for number, edit in said]
    found = _overruled([_of_another(one, edit) for one, edit in zip(outcomes, stated, strict=True)])
    verdicts = [one.edit for one in found if one.outcome == "held" and isinstance(one.edit, Verdict)]
    return Edited(after, tuple(found), tuple(reviewed(edit, trajectories, of) for edit in verdicts), folds)


def _of_another(one: Applied, stated: Edit) -> Applied:
    """What became of an edit, with the reason why it is of another marker, or of other places, than was stated."""
    said, now = getattr(stated, "marker", None), getattr(one.edit, "marker", None)
    if one.reason or one.edit is stated:
        return one
    if said != now:
        return one._replace(reason=f"the samples of {said} are called {now} now")
    return one._replace(reason=MOVED) if is_moved(one.edit, stated) else one


def _as_tracked(said: Sequence[tuple[int, Edit]], tracked_by: Sequence[Entry]) -> list[Edit]:
    """The edits, claims that tracking had as facts without witnesses that were erased: their images are free now."""
    facts = {entry.id for entry in tracked_by}
    erased = [edit for number, edit in said if number in facts and isinstance(edit, Erase)]

    def as_tracked(claim: Claim) -> Claim:
        own = [edit for edit in erased if edit.marker == claim.name]
        left = tuple(w for w in claim.where.witnesses if not any(e.first <= w.frame <= e.last for e in own))
        return replace(claim, where=replace(claim.where, witnesses=left)) if own and left else claim

    return [as_tracked(edit) if number in facts and isinstance(edit, Claim) else edit for number, edit in said]


def _claim_outcome(claimed: Claimed, k: int, facts: bool, name: str | None) -> tuple[Outcome, float, int, str]:
    """Outcome, share of witnesses found, samples, and reason of claim k."""
    asked, found, samples = int(claimed.asked[k]), int(claimed.found[k]), int(claimed.samples[k])
    share = found / asked if asked else 0.0
    if not asked:
        return "moot", 0.0, 0, "the trial has none of its frames"
    if not found and facts and name is None:
        return "held", 1.0, 0, ""  # what is no marker is not tracked any more
    if not found:
        return "orphan", 0.0, 0, "none of its witnesses is on a path now"
    if not samples:
        return "overruled", share, 0, "later claims have all of its samples"
    if share < ENOUGH:
        return "thin", share, samples, f"only {found} of its {asked} witnesses are on a path now"
    if claimed.unsure[k] > max(UNSURE * samples, FEW_UNSURE):
        return "thin", share, samples, f"{claimed.unsure[k]} of its samples may be those of a marker near by"
    if not claimed.changed[k] and not facts:
        return "moot", share, samples, "it is called so without it"
    return "held", share, samples, ""


def _result(edit: Edit, before: Trajectories, after: Trajectories, of: Footage) -> Result:
    """What becomes of an edit that changes no values; `before` all edits, and with their names and values."""
    if isinstance(edit, Verdict):
        return _verdict_result(edit, before, of)
    if isinstance(edit, Trim | AddEvent) and is_of_no_path(edit, before, of):
        return Result("orphan", reason="the markers are elsewhere then than when this was said")
    if isinstance(edit, Trim):
        inside = edit.last >= of.first_frame and edit.first < of.first_frame + before.n_frames
        return Result("held") if inside else Result("orphan", reason="the trial has none of these frames")
    if isinstance(edit, DropUnnamed):
        n = sum(not is_named(name) for name in after.names)
        return Result("held", n) if n else Result("moot", reason="all have names")
    return Result("held")


def _verdict_result(edit: Verdict, before: Trajectories, of: Footage) -> Result:
    """A verdict stands where the stretches that it is about are found."""
    found = votes(edit.where, before, of.detections, world=of.world).path
    if len(found) and not (found >= 0).any():
        return Result("orphan", reason="none of its witnesses is on a path now")
    return Result("held")


def _overruled(applied: Sequence[Applied]) -> list[Applied]:
    """Edits that a later one of the same kind about the same thing takes the place of."""
    later, found = set[object](), list[Applied]()
    for one in reversed(applied):
        key = _about(one.edit)
        overruled = key is not None and key in later and one.outcome == "held"
        found.append(one._replace(outcome="overruled", reason="a later one says otherwise") if overruled else one)
        if key is not None and one.outcome == "held":
            later.add(key)
    return found[::-1]


def _about(edit: Edit) -> object:
    """What only one edit can say; None where several stand beside each other."""
    if isinstance(edit, Put):
        return "put", edit.marker, edit.frame
    if isinstance(edit, GapChoice):
        return "gap", edit.marker, edit.first, edit.last
    if isinstance(edit, ImagePoint):
        return "image", edit.camera, edit.frame, edit.marker
    return "trim" if isinstance(edit, Trim) else None


def reviewed(edit: Verdict, before: Trajectories, of: Footage) -> Reviewed:
    """A verdict by the paths and frames of some trajectories."""
    found = votes(edit.where, before, of.detections, world=of.world)
    on = found.path >= 0
    frames = found.frame[on]
    ends = [(s.first, s.last) for s in edit.where]
    first = min((a - of.first_frame for a, _ in ends if a is not None), default=int(frames.min(initial=0)))
    last = max((b - of.first_frame for _, b in ends if b is not None), default=int(frames.max(initial=0)))
    return Reviewed(edit.decision, first, last, tuple(np.unique(found.path[on]).tolist()), edit.right)


def cropped(trajectories: Trajectories, edited: Edited) -> Trajectories:
    """What is left when the trial is trimmed and its unnamed tracks are dropped."""
    first, stop = edited.kept
    if (first, stop) != (0, trajectories.n_frames):
        trajectories = trajectories.frames(first, stop)
    if edited.named_only:
        trajectories = replace(trajectories, paths=tuple(path for path in trajectories if is_named(path.name)))
    return trajectories
