"""Whether an edit is still of what somebody saw.

A marker's name may be another marker's by now: names were worked out anew, or somebody exchanged two. A frame's number
may be another moment: the file was written again, trimmed or at another rate. And places may be in another world. So an
edit of samples has witnesses, as a claim has: samples of the marker as it was then, those that are wrong or, where the
edit is of what is missing, those beside. They are as tracking or the file has them, but for what was put where nothing
was: else an edit would be lost when one before it is taken back. A witness *denies* the edit where the marker has a
sample in that frame now which is clearly elsewhere (`votes`, 4), and *finds* it where that sample is not.

Samples of the marker's other frames tell whose the edit is: where more than half of them are samples that another
marker has now, it is of that marker, as its samples are called so by now (6). Those of the place itself cannot tell: a
sample is often erased for being another marker's, and trackers exchange two markers for some frames.

An edit that is denied and not found is an orphan, and is applied to nothing (1); it is thin where more deny than find
it (2). A place, or an image, that is near to the samples beside it now stands all the same: those that it was said
beside may have been wrong (3). A method that was chosen for a gap is thin where that is LONGER times as long now (4).
An edit that no witness speaks of stands: those of older journals have none, and samples may be gone.

Frames to which a trial is trimmed, and times of events, are no marker's: their witnesses are samples of several
markers, and the edit is an orphan where none of them is on any path (5). At another rate an event is at the same time,
and so are its witnesses; or in the same frames, where these find more of them: then the rate was wrong (7).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TypeVar

import numpy as np

from ..data import Camera, Detections, MarkerTrajectory, Origin, Trajectories
from ..data.array_types import Floats, Ints
from ..data.edits import OPEN, AddEvent, Edit, Erase, GapChoice, ImagePoint, Put, Smooth, Stretch, Trim, is_named
from ..geometry import project
from ..numerics.evenly import evenly_rounded
from ..numerics.runs import true_runs
from .values import Changed, Footage, Result
from .votes import FAR_MM, compared, known_votes, votes, witnesses_of
from .witnesses import witnesses_at

FEW = 4
"""Witnesses of an edit of samples, and of whose it is, a number; chosen: a claim has 16 and more of a whole path."""
LONGER = 2.0
"""Times, of (4); chosen: ends of a gap move by some frames when a trial is processed again."""
ELSEWHERE = Result("orphan", reason="the marker is elsewhere there than when this was said")
"""What becomes of an edit whose witnesses all deny it."""
OfMarker = Erase | Put | GapChoice | Smooth | ImagePoint
Anchored = OfMarker | Trim | AddEvent
"""Edits that have such witnesses; an image that is no marker's is a witness itself."""
AnyEdit = TypeVar("AnyEdit", bound=Edit)


def anchored(
    edit: AnyEdit,
    trajectories: Trajectories,
    detections: Detections | None,
    world: str,
    before: Mapping[str, MarkerTrajectory] = MappingProxyType({}),
) -> AnyEdit:
    """An edit with its witnesses; the same where it has no use for any, or the marker has no samples to be one.

    Args:
        edit: as somebody says it. trajectories: as they see them.
        detections: behind the samples; None for a file without. world: key of the cameras in whose world these are.
        before: markers before their edits of values, by name; those that have none may be absent.
    """
    if not isinstance(edit, Anchored) or edit.where is not None:
        return edit
    start = trajectories.first_frame
    if isinstance(edit, Trim | AddEvent):
        given = tuple(before.get(path.name, path) for path in trajectories)
        found = _of_moments(edit, replace(trajectories, paths=given))
        where = _stretch(found, start, detections, world)
        timed = replace(edit, rate=trajectories.rate) if isinstance(edit, AddEvent) and where else edit
        return replace(timed, where=where)
    if edit.marker is None or edit.marker not in trajectories.names:
        return edit
    now = trajectories[edit.marker]
    path = before.get(now.name, now)
    frames = np.flatnonzero(now.origin != Origin.MISSING) + start
    found, rest = (
        [(now if path.origin[f - start] == Origin.MISSING else path, f) for f in some.tolist()]
        for some in _spoken_of(edit, frames)
    )
    where, whose = (_stretch(some, start, detections, world) for some in (found, rest))
    return replace(edit, where=where, whose=whose) if where else edit


def _stretch(
    samples: Sequence[tuple[MarkerTrajectory, int]], start: int, detections: Detections | None, world: str
) -> Stretch | None:
    """Samples, each of a path and a frame's number, as witnesses; None where there are none."""
    each = (witnesses_at(path, np.array([f - start]), start, detections) for path, f in samples)
    witnesses = tuple(one for own in each for one in own)
    return Stretch(None, None, witnesses, world) if witnesses else None


def _of_moments(edit: Trim | AddEvent, trajectories: Trajectories) -> list[tuple[MarkerTrajectory, int]]:
    """Samples of several markers at the ends of a trim, or around an event, each in a frame of its own."""
    at, n, found = FEW // 2, trajectories.n_frames, []
    if isinstance(edit, Trim):
        frames = [*range(edit.first, edit.first + at), *range(edit.last - at + 1, edit.last + 1)]
    else:
        middle = round(edit.time_s * trajectories.rate) + 1
        frames = list(range(middle - at, middle + at))
    for k, f in enumerate(sorted(set(frames))):
        here = f - trajectories.first_frame
        there = [path for path in trajectories if 0 <= here < n and path.origin[here] != Origin.MISSING]
        found += [(there[k % len(there)], f)] if there else []
    return found


def _spoken_of(edit: OfMarker, frames: Ints) -> tuple[Ints, Ints]:
    """Of the frames that a marker has, those by which an edit is found again, and those that tell whose it is."""
    first, last = (edit.frame, edit.frame) if isinstance(edit, Put | ImagePoint) else (edit.first, edit.last)
    own = (frames >= first) & (frames <= last)
    rest = frames[~own]
    if isinstance(edit, Erase | Smooth):
        return _spread(frames[own]), _spread(rest)
    return np.concatenate([rest[rest < first][-(FEW // 2) :], rest[rest > last][: FEW // 2]]), _spread(rest)


def _spread(frames: Ints) -> Ints:
    """FEW of some frames, evenly."""
    return frames[evenly_rounded(len(frames), FEW)]


def followed(edit: Edit, given: Trajectories, named: Trajectories, of: Footage) -> Edit:
    """An edit, of the marker that has its samples now (6), and of the frames that have its time (7).

    Args:
        edit: any. given: before all edits. named: the same samples under the names that claims give them.
        of: what is behind the samples.
    """
    if isinstance(edit, AddEvent):
        return _at_rate(edit, given, of)
    if not isinstance(edit, OfMarker) or edit.marker is None or edit.whose is None:
        return edit
    stated = named[edit.marker] if edit.marker in named.names else None
    own = {} if stated is None else known_votes(given, of.detections, of.world).own.setdefault(stated, {})
    if id(edit) in own:
        return edit
    frame, place = _whose_samples(edit.whose, given, of)

    def has(path: MarkerTrajectory) -> int:
        return int((path.xyz[frame] == place).all(1).sum())

    if stated is not None and 2 * has(stated) >= len(frame):
        own[id(edit)] = edit  # which is kept, so that its id stays its own; whatever others have by the next version
        return edit
    now = max(named, key=has)
    called = is_named(now.name) or not is_named(edit.marker)
    return replace(edit, marker=now.name) if called and 2 * has(now) > len(frame) else edit


def _whose_samples(whose: Stretch, given: Trajectories, of: Footage) -> tuple[Ints, Floats]:
    """Frames (N) from 0 and places (N, 3) mm that tell whose an edit is; none where half of them or less are found."""
    said = votes([whose], given, of.detections, world=of.world)
    seen = said.path >= 0
    if 2 * seen.sum() <= len(seen):
        return np.zeros(0, np.int64), np.zeros((0, 3))
    frame = said.frame[seen]
    return frame, np.array([given.paths[p].xyz[f] for p, f in zip(said.path[seen], frame, strict=True)])


def disowned(edit: Edit, before: MarkerTrajectory, path: MarkerTrajectory, of: Footage) -> Result | None:
    """What becomes of an edit that is not, or hardly, of what the marker has there; else None.

    Args:
        edit: any. before: the marker before all edits of values. path: as it is now, where it had nothing before.
        of: what is behind the samples.
    """
    if not isinstance(edit, OfMarker) or edit.where is None:
        return None
    cameras: Sequence[str] = of.detections.cameras if of.detections is not None else ()
    witnesses = witnesses_of([edit.where], of.first_frame, cameras, of.world)
    given, now = (compared(witnesses, one, of.detections) for one in (before, path))
    far, known = np.where(given.there, given.far, now.far), np.where(given.there, given.known, now.known)
    denied, found = int(far.sum()), int((known & ~far).sum())
    if isinstance(edit, Put | ImagePoint) and _goes_on(edit, path, of):
        return None
    if denied and not found:
        return ELSEWHERE  # (1)
    if denied > found:
        return Result("thin", reason=f"of {denied + found} samples it was said of {denied} are elsewhere now")  # (2)
    return _longer(edit, edit.where, path, of) if isinstance(edit, GapChoice) and edit.method != OPEN else None


def _longer(edit: GapChoice, where: Stretch, path: MarkerTrajectory, of: Footage) -> Result | None:
    """Doubt of a method that was chosen for a gap which is far longer now (4)."""
    frames = [witness.frame for witness in where.witnesses]
    before, after = [f for f in frames if f < edit.first], [f for f in frames if f > edit.last]
    first, last = edit.first - of.first_frame, edit.last - of.first_frame
    runs = true_runs(path.origin == Origin.MISSING).tolist()
    now = sum(stop - start for start, stop in runs if start <= last and stop > first)
    asked = min(after) - max(before) - 1 if before and after else now
    return (
        Result("thin", reason=f"of {asked} frames it was said, and {now} are missing") if now > LONGER * asked else None
    )


def is_of_no_path(edit: Trim | AddEvent, trajectories: Trajectories, of: Footage) -> bool:
    """Whether none of an edit's witnesses that lie in the trial is on a path (5); not where none lies in it."""
    if edit.where is None:
        return False
    found = votes([edit.where], trajectories, of.detections, world=of.world)
    inside = (found.frame >= 0) & (found.frame < trajectories.n_frames)
    return bool(inside.any() and (found.path < 0).all())


def _at_rate(edit: AddEvent, given: Trajectories, of: Footage) -> AddEvent:
    """An event at the rate that the trial has now (7)."""
    if edit.where is None or edit.rate in (None, of.rate):
        return edit
    faster = of.rate / edit.rate
    timed = {round((w.frame - 1) * faster) + 1: w for w in edit.where.witnesses}
    then = replace(edit.where, witnesses=tuple(w._replace(frame=frame) for frame, w in timed.items()))
    by_time, by_frame = (
        int((votes([where], given, of.detections, world=of.world).path >= 0).sum()) for where in (then, edit.where)
    )
    if by_frame > by_time:
        return replace(edit, time_s=edit.time_s / faster, rate=of.rate)
    return replace(edit, where=then, rate=of.rate)


def _goes_on(edit: Put | ImagePoint, path: MarkerTrajectory, of: Footage) -> bool:
    """Whether a place or an image is near to the marker's samples beside its frame: it was said of that marker (3)."""
    own, f = np.flatnonzero(path.origin != Origin.MISSING), edit.frame - of.first_frame
    beside = path.xyz[np.concatenate([own[own < f][-1:], own[own > f][:1]])]
    if isinstance(edit, ImagePoint):
        return any(_shows(camera, edit, beside) for camera in of.rig or () if camera.name == edit.camera)
    return edit.world == of.world and bool((np.linalg.norm(beside - np.array(edit.xyz), axis=1) <= FAR_MM).any())


def _shows(camera: Camera, edit: ImagePoint, xyz: Floats) -> bool:
    """Whether an image is where its camera has places (N, 3) mm, or within FAR_MM of one across its view."""
    seen, limit = project(camera, xyz), project(camera, xyz + FAR_MM * camera.R[0])
    apart = np.linalg.norm(seen - [edit.u, edit.v], axis=1)
    return bool((apart <= np.linalg.norm(limit - seen, axis=1)).any())


def with_doubt(changed: Changed, doubt: Result | None) -> Changed:
    """A marker after an edit that stands on few of its witnesses; the same where there is no doubt."""
    path, result = changed
    return (path, doubt._replace(samples=result.samples)) if doubt and result.outcome == "held" else changed
