"""Edits, made from what somebody points at, and not yet said: faces preview them, or say several in one act."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ...data import KinemarkError, MarkerTrajectory, Origin, Trajectories
from ...data.array_types import Bools
from ...data.edits import (
    Claim,
    DropUnnamed,
    Erase,
    GapChoice,
    ImagePoint,
    Put,
    Smooth,
    SmoothingFunction,
    Stretch,
    TrackAgain,
    Trim,
    Verdict,
    is_named,
    live,
)
from ...data.errors import users_mistake
from ...data.nearest_word import guess, some_names
from ...edit import stretch_of
from ...edit.values import Footage, solve

if TYPE_CHECKING:
    from .editing import Editing

EditKind = TypeVar("EditKind")

REVIEWED_BESIDE = 20
"""Frames before and after an ambiguous decision that witnesses of a verdict are taken from; chosen."""
LEAST_COMMON = 0.1
"""Of the trial's frames, fewer than which are cut out only where somebody says which; chosen: a short piece that has a
name by mistake leaves fewer."""
PUT_SD = 1.0
"""mm per axis, of a place put by hand where nobody says; chosen."""


def claim(
    of: Editing,
    track: str,
    name: str | None,
    *,
    first: int | None = None,
    last: int | None = None,
    at: int | None = None,
) -> tuple[Claim, ...]:
    """A stretch of a trajectory is the marker of this name, or no marker where that is None.

    Of a trajectory that was joined, each piece is claimed by itself, so that none keeps what it was called before. What
    has the name already and goes on with the trajectory is claimed as well: whoever names the trial anew then knows
    both.

    Raises:
        KinemarkError: there is no such trajectory or no sample of it, or the name is none.
    """
    now = of.edited().trajectories
    try:
        where = stretch_of(
            now, track, first=first, last=last, at=at, detections=of.detections, world=of.world, among=of.trajectories
        )
        said = tuple(Claim(one, name) for one in by_pieces(of, now, track, where, at=at))
    except (KeyError, ValueError) as error:
        raise KinemarkError(f"{error.args[0]}.") from error
    if name is None or first is not None or last is not None:
        return said
    other = of.connection(track, name)
    return said if other is None or not other.connectable else (*claim(of, name, name), *said)


def by_pieces(
    of: Editing, now: Trajectories, track: str, where: Stretch, *, at: int | None = None
) -> tuple[Stretch, ...]:
    """A stretch of each of the pieces that a trajectory was joined of; the stretch itself where it was not.

    Args:
        of: the trial. now: as it is edited now. track: whose stretch it is, of `now`; where: it.
        at: a frame that somebody pointed at.
    """
    pieces = _pieces(of.trajectories, now, track, (where.witnesses[0].frame, where.witnesses[-1].frame))
    if len(pieces) <= 1:
        return (where,)
    return tuple(
        stretch_of(
            of.trajectories, piece, first=where.first, last=where.last, within=span,
            at=at if at is not None and span[0] <= at <= span[1] else None, detections=of.detections, world=of.world,
        )
        for piece, span in pieces
    )  # fmt: skip


def _pieces(
    given: Trajectories, now: Trajectories, track: str, span: tuple[int, int]
) -> list[tuple[str, tuple[int, int]]]:
    """The trajectories of before the edits that a path was joined of, with their first and last frames in a span.

    Samples beside them that gave way to those of another piece belong to them.
    """
    path, found = now[track], []
    part = slice(span[0] - given.first_frame, span[1] - given.first_frame + 1)
    for piece in given.paths if all(path is not one for one in given) else ():
        own = _same(piece, path, part)
        if not own.any():
            continue
        others = [one for one in now if is_named(one.name) and one is not path]
        free = (piece.origin[part] != Origin.MISSING) & (path.origin[part] != Origin.MISSING)
        for other in others:
            free &= ~_same(piece, other, part)
        first, last = np.flatnonzero(own)[[0, -1]].tolist()
        while first > 0 and free[first - 1]:
            first -= 1
        while last < len(own) - 1 and free[last + 1]:
            last += 1
        found.append((piece.name, (first + span[0], last + span[0])))
    return found


def _same(one: MarkerTrajectory, other: MarkerTrajectory, part: slice) -> Bools:
    """(F) the frames of a part in which two paths have the same sample."""
    same: Bools = (one.xyz[part] == other.xyz[part]).all(1)
    return same


def exchange(
    of: Editing, one: str, other: str, *, first: int | None = None, last: int | None = None
) -> tuple[Claim, ...]:
    """Two trajectories have each other's names in these frames; where one has none, the other takes it over.

    Raises:
        KinemarkError: neither has a marker's name, or one is not there or has no sample in these frames.
    """
    pairs = [(a, b) for a, b in ((one, other), (other, one)) if is_named(b)]
    if not pairs:
        raise KinemarkError(f"Neither {one} nor {other} has a marker's name. Claim one of them for a marker first.")
    return tuple(said for a, b in pairs for said in claim(of, a, b, first=first, last=last))


def erase(of: Editing, marker: str, first: int, last: int) -> Erase:
    """Samples of a marker are wrong."""
    return made(Erase, known(of, marker), first, last)


def put(of: Editing, marker: str, frame: int, xyz: Sequence[float], *, sd_mm: float = PUT_SD) -> Put:
    """A marker is at this place, mm, in a frame."""
    place = np.asarray(xyz, np.float64)
    images = tuple(footage_of(of).images_of(frame, place))
    spot = (float(place[0]), float(place[1]), float(place[2]))
    return made(Put, known(of, marker), frame, spot, sd_mm, images, of.world)


def put_in_images(of: Editing, marker: str, frame: int, images: Mapping[str, tuple[float, float]]) -> Put:
    """A marker is where it was clicked in two images or more: u, v px by camera.

    Raises:
        KinemarkError: these are no place.
    """
    footage = footage_of(of)
    for name in images:
        _check_fits(footage, name, frame)
    found = solve(footage, frame, images)
    if found is None:
        raise KinemarkError(f"{', '.join(images) or 'No image'} is no place: click it in two of the cameras.")
    seen = tuple((name, u, v) for name, (u, v) in images.items())
    sd = float(np.sqrt(np.trace(found.cov) / 3))
    x, y, z = found.xyz.tolist()
    return made(Put, known(of, marker), frame, (x, y, z), sd, seen, of.world)


def gap(of: Editing, marker: str, first: int, last: int, method: str) -> GapChoice:
    """How gaps of a marker that reach into these frames are filled: a method, "best" or "open"."""
    return made(GapChoice, known(of, marker), first, last, method)


def smooth(
    of: Editing,
    marker: str,
    first: int,
    last: int,
    cutoff_hz: float,
    function: SmoothingFunction = "butterworth",
) -> Smooth:
    """A stretch of a marker is low-pass filtered by a function; raises a KinemarkError where it could not be."""
    rate = of.edited().trajectories.rate
    if cutoff_hz >= rate / 2:
        raise KinemarkError(
            f"The cut-off is {cutoff_hz:g} Hz, and {rate:g} frames a second show nothing above {rate / 2:g} Hz. Give "
            "one below that."
        )
    return made(Smooth, known(of, marker), first, last, cutoff_hz, "smooth", function)


def image(of: Editing, camera: str, frame: int, u: float, v: float, marker: str | None) -> ImagePoint:
    """Where a marker is in an image; or that the image there is no marker's."""
    if marker:
        _check_fits(footage_of(of), camera, frame)
    return made(ImagePoint, camera, frame, u, v, marker and known(of, marker))


def _check_fits(of: Footage, camera: str, frame: int) -> None:
    """Refuse an image of a camera that shows no place in a frame."""
    if not of.fits(camera, frame):
        raise KinemarkError(
            f"{camera} was moved, and fits the other cameras no more in frame {frame}: its images show no place. "
            "Click the marker in other cameras."
        )


def finish(of: Editing, *, first: int | None = None, last: int | None = None) -> tuple[DropUnnamed, Trim]:
    """Drop what is unnamed, and trim all markers to the frames that all of them have (KISS 4.3).

    Points of a file that are no markers stay, and ask for nothing.

    Raises:
        KinemarkError: no marker has a name, there is no frame between the first and the last that all have, or there
            are few and nobody said which.
    """
    edited = of.edited().trajectories
    edited = edited.select([name for name in edited.names if name not in of.computed])
    low, high = common_frames(edited)
    if first is None and last is None and 0 <= high - low < LEAST_COMMON * edited.n_frames - 1:
        raise KinemarkError(
            f"All named markers have only frames {low} to {high}, of {edited.n_frames}: {_shortest(edited)} is seen in "
            f"few. Join it, name it otherwise or delete it, or say from where to where: --frames {low}-{high}."
        )
    low, high = (low if first is None else first), (high if last is None else last)
    if low > high:
        raise KinemarkError(
            f"There are no frames that all named markers reach: the last begins in frame {low} and the first ends "
            f"in {high}. Name the pieces that are missing, or say from where to where: --frames."
        )
    return DropUnnamed(), Trim(low, high)


def review(of: Editing, number: int, *, right: bool) -> Verdict:
    """A verdict on an ambiguous decision, by its number from 1 among those of the tracking.

    Raises:
        KinemarkError: there is no such decision, or its tracks have no sample at its time.
    """
    if not 1 <= number <= len(of.decisions):
        raise KinemarkError(f"There is no decision {number}: the tracking left {len(of.decisions)} to look at.")
    decision, start = of.decisions[number - 1], of.trajectories.first_frame
    ends = decision.first + start, decision.last + start
    beside = ends[0] - REVIEWED_BESIDE, ends[1] + REVIEWED_BESIDE
    names = [of.trajectories.names[track] for track in decision.tracks if track >= 0]
    with users_mistake():
        where = tuple(
            stretch_of(
                of.trajectories, name, first=ends[0], last=ends[1], within=beside, detections=of.detections,
                world=of.world,
            )
            for name in names
        )  # fmt: skip
    return Verdict(decision.kind, where, right)


def track_again(of: Editing) -> TrackAgain:
    """The tracks are to be made again, with what was said as facts; markers that it is about are found by their paths.

    Raises:
        KinemarkError: there are no images, or nothing was said that the tracker could use.
    """
    if of.detections is None:
        raise KinemarkError(
            f"{of.name} is a file of trajectories without images, so that nothing can be tracked again. "
            "Ask for it of a session's trial."
        )
    said = [edit for entry in live(of.journal.read().entries) for edit in entry.edits]
    if not any(isinstance(edit, Claim | Put | Erase | ImagePoint) for edit in said):
        raise KinemarkError(
            "Nothing was said that tracking could use: claim names, put places or correct images first."
        )
    claimed = {edit.name for edit in said if isinstance(edit, Claim)}
    spoken = {edit.marker for edit in said if isinstance(edit, Put | Erase | ImagePoint)} - claimed
    names = [path.name for path in of.trajectories if path.name in spoken and (path.origin != Origin.MISSING).any()]
    stretches = {n: stretch_of(of.trajectories, n, detections=of.detections, world=of.world) for n in names}
    return TrackAgain(tuple(Claim(where, name) for name, where in stretches.items()))


def common_frames(trajectories: Trajectories) -> tuple[int, int]:
    """First and last frame, numbers in the recording, between the ends of every named marker that is seen.

    Raises:
        KinemarkError: no marker has a name.
    """
    seen = [np.flatnonzero(path.origin != Origin.MISSING) for path in trajectories if is_named(path.name)]
    seen = [frames for frames in seen if len(frames)]
    if not seen:
        raise KinemarkError("No trajectory has a marker's name, so nothing would be left. Claim names first.")
    start = trajectories.first_frame
    return max(int(f[0]) for f in seen) + start, min(int(f[-1]) for f in seen) + start


def _shortest(trajectories: Trajectories) -> str:
    """The named marker that is seen in the fewest frames."""
    seen = {path.name: int((path.origin != Origin.MISSING).sum()) for path in trajectories if is_named(path.name)}
    return min((name for name, frames in seen.items() if frames), key=seen.__getitem__)


def made(kind: type[EditKind], *values: object) -> EditKind:
    """An edit, with the user's mistakes as errors of theirs."""
    with users_mistake():
        return kind(*values)


def known(of: Editing, marker: str) -> str:
    """A marker's name; raises a KinemarkError where there is no such marker, or it has no name."""
    names = of.edited().trajectories.names
    if marker not in names:
        raise KinemarkError(f"There is no marker {marker}{guess(marker, names)}; there are {some_names(names)}.")
    if not is_named(marker):
        raise KinemarkError(
            f"{marker} is the number of a track, which is another in the next run. Claim a name for it first."
        )
    return marker


def footage_of(of: Editing) -> Footage:
    """What is behind a trial's samples."""
    trajectories = of.trajectories
    return Footage(trajectories.first_frame, trajectories.rate, of.detections, of.rig, of.world, of.timed, of.left_out)
