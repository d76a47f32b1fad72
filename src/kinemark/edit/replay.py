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

from ..data import Detections, MarkerTrajectory, Origin, Rig, Trajectories
from ..data.array_types import Bools
from ..data.edits import (
    AddEvent,
    Applied,
    Claim,
    DropUnnamed,
    Edit,
    Entry,
    Erase,
    GapChoice,
    ImagePoint,
    Outcome,
    Put,
    Smooth,
    Trim,
    Verdict,
    is_named,
    live,
)
from .claims import ENOUGH, Claimed, with_claims
from .values import Changed, Footage, Result, erase, put, smooth, with_image, without_image
from .votes import nearest_images, votes


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
    """

    trajectories: Trajectories
    applied: tuple[Applied, ...] = ()
    reviewed: tuple[Reviewed, ...] = ()

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
    rig: Rig | None = None,
    world: str = "",
) -> Edited:
    """The trial with all entries that count.

    Args:
        trajectories: as they come from tracking and naming, or from a file.
        entries: of the journal, undone ones among them.
        detections, rig: behind the samples; None for a file without.
        world: key of the cameras in whose world the trial is; claims made in another one are found by images alone.
    """
    said = [(entry.id, edit) for entry in live(entries) for edit in entry.edits]
    claims = [edit for _, edit in said if isinstance(edit, Claim)]
    claimed = with_claims(trajectories, claims, detections, world=world)
    of = Footage(trajectories.first_frame, trajectories.rate, detections, rig, world)
    changing = _Markers(claimed.trajectories, of)
    outcome = iter([_claim_outcome(claimed, k) for k in range(len(claims))])
    applied = []
    for number, edit in said:
        if isinstance(edit, Claim):
            applied.append(Applied(number, edit, *next(outcome)))
        else:
            result = changing.apply(edit, trajectories)
            applied.append(Applied(number, edit, result.outcome, 1.0, result.samples, result.reason))
    found = _overruled(applied)
    verdicts = [one.edit for one in found if one.outcome == "held" and isinstance(one.edit, Verdict)]
    found_again = tuple(reviewed(edit, trajectories, of) for edit in verdicts)
    return Edited(changing.trajectories, tuple(found), found_again)


def _claim_outcome(claimed: Claimed, k: int) -> tuple[Outcome, float, int, str]:
    """Outcome, share of witnesses found, samples, and reason of claim k."""
    asked, found, samples = int(claimed.asked[k]), int(claimed.found[k]), int(claimed.samples[k])
    share = found / asked if asked else 0.0
    if not asked:
        return "moot", 0.0, 0, "the trial has none of its frames"
    if not found:
        return "orphan", 0.0, 0, "none of its witnesses is on a path now"
    if not samples:
        return "overruled", share, 0, "later claims have all of its samples"
    if share < ENOUGH:
        return "thin", share, samples, f"only {found} of its {asked} witnesses are on a path now"
    if not claimed.changed[k]:
        return "moot", share, samples, "it is called so without it"
    return "held", share, samples, ""


class _Markers:
    """The markers while edits of values are applied to them, one after the other."""

    def __init__(self, trajectories: Trajectories, of: Footage) -> None:
        self.trajectories = trajectories
        self.of = of

    def apply(self, edit: Edit, before: Trajectories) -> Result:
        """What becomes of an edit; `before` are the paths before all edits."""
        if isinstance(edit, Verdict):
            return _verdict_result(edit, before, self.of)
        if isinstance(edit, Trim):
            inside = edit.last >= self.of.first_frame and edit.first < self.of.first_frame + before.n_frames
            return Result("held") if inside else Result("orphan", reason="the trial has none of these frames")
        if isinstance(edit, DropUnnamed):
            n = sum(not is_named(name) for name in self.trajectories.names)
            return Result("held", n) if n else Result("moot", reason="all have names")
        if isinstance(edit, ImagePoint) and edit.marker is None:
            return self._no_marker(edit)
        if isinstance(edit, Erase | Put | Smooth | ImagePoint | GapChoice):
            return self._of_marker(edit)
        return Result("held")

    def _of_marker(self, edit: Erase | Put | Smooth | ImagePoint | GapChoice) -> Result:
        """Edits of one marker."""
        name = str(edit.marker)
        if name not in self.trajectories.names:
            return Result("orphan", reason=f"there is no marker {name}")
        path = self.trajectories[name]
        if isinstance(edit, GapChoice):
            return _choice_result(edit, path.origin == Origin.MISSING, self.of)
        changed, result = _change(path, edit, self.of)
        self._put_back(changed)
        return result

    def _put_back(self, changed: MarkerTrajectory) -> None:
        paths = tuple(changed if path.name == changed.name else path for path in self.trajectories)
        self.trajectories = replace(self.trajectories, paths=paths)

    def _no_marker(self, edit: ImagePoint) -> Result:
        """An image that is no marker's is taken from whoever has it."""
        seen, f = self.of.detections, edit.frame - self.of.first_frame
        if seen is None or edit.camera not in seen.cameras:
            return Result("orphan", reason=f"there is no camera {edit.camera}")
        if not 0 <= f < min(self.trajectories.n_frames, seen.n_frames):
            return Result("moot", reason="the trial does not have this frame")
        c = seen.cameras.index(edit.camera)
        row = nearest_images(np.array([c]), np.array([f]), np.array([[edit.u, edit.v]]), seen)[0]
        have = [path for path in self.trajectories if path.detection.shape[1] and path.detection[f, c] == row >= 0]
        for path in have:
            self._put_back(without_image(path, f, edit.camera, self.of)[0])
        return Result("held", len(have)) if have else Result("moot", reason="no marker has an image there")


def _change(path: MarkerTrajectory, edit: Erase | Put | Smooth | ImagePoint, of: Footage) -> Changed:
    """A marker after an edit of its values."""
    if isinstance(edit, Erase):
        return erase(path, edit, of)
    if isinstance(edit, Put):
        return put(path, edit, of)
    return smooth(path, edit, of) if isinstance(edit, Smooth) else with_image(path, edit, of)


def _choice_result(edit: GapChoice, missing: Bools, of: Footage) -> Result:
    """Whether a choice has anything to choose for."""
    span = slice(max(edit.first - of.first_frame, 0), max(edit.last - of.first_frame + 1, 0))
    n = int(missing[span].sum())
    return Result("held", n) if n else Result("moot", reason="there is no gap in these frames")


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
