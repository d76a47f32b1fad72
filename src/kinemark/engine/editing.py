"""Editing a trial: what can be said of it, in one call each; the command line and every other face drive this.

A trial of a session is edited as it comes from tracking and naming; a file of trajectories as it stands in the file,
which is never changed: `edit_files.write_edited` writes another one. What is said goes into the journal beside it,
`edits/<name>.jsonl`, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from ..data import Detections, KinemarkError, Origin, Rig, Trajectories, Trial
from ..data.array_types import Floats
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
    Put,
    Signed,
    Smooth,
    Trim,
    Verdict,
    is_named,
)
from ..edit import Connection, Edited, connection, replay, stretch_of
from ..edit.values import Footage, solve
from ..geometry import project
from ..io.trial import read_trial
from ..track.simultaneous import AmbiguousDecision
from .edit_stage import applied_entries, check_methods
from .graph import Records
from .journal import Journal
from .keys import world_key
from .open_trial import OpenTrial
from .trial_inputs import TrialInputs, measured_of

EditKind = TypeVar("EditKind")

REVIEWED_BESIDE = 20
"""Frames before and after an ambiguous decision that witnesses of a verdict are taken from; chosen."""
PUT_SD = 1.0
"""mm per axis, of a place put by hand where nobody says; chosen."""


class Said(NamedTuple):
    """An entry of the journal, and what became of its edits."""

    entry: Entry
    applied: tuple[Applied, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Editing:
    """A trial that is edited.

    Attributes:
        name: of the trial. journal: of what was said.
        trajectories: before all edits; detections, rig: behind them, None for a file without.
        by: who edits; the user of the machine where empty.
        source: the file's trial; None of a session's. decisions: of the tracking that were close.
    """

    name: str
    journal: Journal
    trajectories: Trajectories
    detections: Detections | None = None
    rig: Rig | None = None
    by: str = ""
    source: Trial | None = None
    decisions: tuple[AmbiguousDecision, ...] = ()

    @classmethod
    def of_trial(cls, trial: OpenTrial, *, by: str = "") -> Editing:
        """A trial of a session, processed as far as edits need it.

        Raises:
            KinemarkError: it cannot be processed.
        """
        _, inputs, records = trial.before_edits()
        return cls.of_records(trial, inputs, records, by=by)

    @classmethod
    def of_records(cls, trial: OpenTrial, inputs: TrialInputs, records: Records, *, by: str = "") -> Editing:
        """A trial of a session, by what `OpenTrial.before_edits` gave."""
        journal = Journal.of(trial.workspace.root, trial.name)
        decisions = records["track"].ambiguous_decisions
        return cls(
            trial.name, journal, measured_of(inputs, records), records["detect"], inputs.rig, by, decisions=decisions
        )

    @classmethod
    def of_file(cls, path: Path, *, by: str = "") -> Editing:
        """A file of trajectories; its journal is in the folder `edits` beside it.

        Raises:
            KinemarkError: it cannot be read, or two of its markers have one name.
        """
        trial = read_trial(path)
        names = trial.trajectories.names
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise KinemarkError(f"{path} has {', '.join(twice)} more than once. Give each marker a name of its own.")
        return cls(path.stem, Journal.of(path.parent, path.stem), trial.trajectories, by=by, source=trial)

    @property
    def world(self) -> str:
        """Key of the world that places are in."""
        return "" if self.rig is None else world_key(self.rig)

    def edited(self) -> Edited:
        """The trial with all that stands in the journal."""
        return self.replayed(applied_entries(self.journal.read()))

    def say(self, *edits: Edit, why: str = "", head: str | None = None) -> Said:
        """Write one act into the journal; what came of it.

        Raises:
            KinemarkError: a choice for a gap is no method, or the journal cannot be written or has gone on.
        """
        check_methods(edits)
        entry = self.journal.append(edits, by=self.by, why=why, head=head)
        return Said(entry, tuple(one for one in self.edited().applied if one.entry == entry.id))

    def claim(
        self,
        track: str,
        name: str | None,
        *,
        first: int | None = None,
        last: int | None = None,
        at: int | None = None,
        why: str = "",
    ) -> Said:
        """A stretch of a trajectory is the marker of this name, or no marker where that is None.

        Args:
            track: the trajectory, as it is called now, such as "*12". name: of the marker.
            first, last: frames, numbers in the recording; None where it follows the path as far as that goes.
            at: the frame that somebody pointed at. why: in their words.
        """
        return self.say(self.claimed(track, name, first=first, last=last, at=at), why=why)

    def claimed(
        self, track: str, name: str | None, *, first: int | None = None, last: int | None = None, at: int | None = None
    ) -> Claim:
        """The claim, not yet said.

        Raises:
            KinemarkError: there is no such trajectory or no sample of it, or the name is none.
        """
        now = self.edited().trajectories
        try:
            where = stretch_of(now, track, first=first, last=last, at=at, detections=self.detections, world=self.world)
            return Claim(where, name)
        except (KeyError, ValueError) as error:
            raise KinemarkError(f"{error.args[0]}.") from error

    def exchange(
        self, one: str, other: str, *, first: int | None = None, last: int | None = None, why: str = ""
    ) -> Said:
        """Two trajectories have each other's names in these frames.

        Raises:
            KinemarkError: one has no marker's name, is not there, or has no sample.
        """
        both = (one, other), (other, one)
        return self.say(*(self.claimed(a, b, first=first, last=last) for a, b in both), why=why)

    def connection(self, track: str, name: str) -> Connection | None:
        """How well a trajectory goes on the one of a name, before it is claimed for it; None where there is none.

        Raises:
            KinemarkError: there is no such trajectory, or one has no sample.
        """
        now = self.edited().trajectories
        if name not in now.names or track == name:
            return None
        try:
            return connection(now[name], now[track], rate=now.rate)
        except (KeyError, ValueError) as error:
            raise KinemarkError(f"{error.args[0]}.") from error

    def erase(self, marker: str, first: int, last: int, *, why: str = "") -> Said:
        """Samples of a marker are wrong."""
        return self.say(_made(Erase, self._known(marker), first, last), why=why)

    def put(self, marker: str, frame: int, xyz: Sequence[float], *, sd_mm: float = PUT_SD, why: str = "") -> Said:
        """A marker is at this place, mm, in a frame."""
        place = np.asarray(xyz, np.float64)
        images = () if self.rig is None else tuple(_seen(self.rig, place))
        spot = (float(place[0]), float(place[1]), float(place[2]))
        return self.say(_made(Put, self._known(marker), frame, spot, sd_mm, images, self.world), why=why)

    def put_in_images(self, marker: str, frame: int, images: dict[str, tuple[float, float]], *, why: str = "") -> Said:
        """A marker is where it was clicked in two images or more: u, v px by camera.

        Raises:
            KinemarkError: these are no place.
        """
        of = Footage(self.trajectories.first_frame, self.trajectories.rate, self.detections, self.rig, self.world)
        found = solve(of, images)
        if found is None:
            raise KinemarkError(f"{', '.join(images) or 'No image'} is no place: click it in two of the cameras.")
        seen = tuple((name, u, v) for name, (u, v) in images.items())
        sd = float(np.sqrt(np.trace(found.cov) / 3))
        x, y, z = found.xyz.tolist()
        return self.say(_made(Put, self._known(marker), frame, (x, y, z), sd, seen, self.world), why=why)

    def gap(self, marker: str, first: int, last: int, method: str, *, why: str = "") -> Said:
        """How gaps of a marker that reach into these frames are filled: a method, "best" or "open"."""
        return self.say(_made(GapChoice, self._known(marker), first, last, method), why=why)

    def smooth(self, marker: str, first: int, last: int, cutoff_hz: float, *, why: str = "") -> Said:
        """A stretch of a marker is low-pass filtered."""
        return self.say(_made(Smooth, self._known(marker), first, last, cutoff_hz), why=why)

    def image(self, camera: str, frame: int, u: float, v: float, marker: str | None, *, why: str = "") -> Said:
        """Where a marker is in an image; or that the image there is no marker's."""
        return self.say(_made(ImagePoint, camera, frame, u, v, marker and self._known(marker)), why=why)

    def event(self, label: str, side: str, time_s: float, *, why: str = "") -> Said:
        """An event, s from frame 1 of the recording."""
        return self.say(_made(AddEvent, label, side, time_s), why=why)

    def trim(self, first: int, last: int, *, why: str = "") -> Said:
        """All markers begin and end at these frames."""
        return self.say(_made(Trim, first, last), why=why)

    def finish(self, *, first: int | None = None, last: int | None = None, why: str = "") -> Said:
        """Drop what is unnamed, and trim all markers to the frames that all of them have (KISS 4.3): one act.

        Raises:
            KinemarkError: no marker has a name, or there is no frame between the first and the last that all have.
        """
        low, high = common_frames(self.edited().trajectories)
        low, high = (low if first is None else first), (high if last is None else last)
        if low > high:
            raise KinemarkError(
                f"There are no frames that all named markers reach: the last begins in frame {low} and the first ends "
                f"in {high}. Name the pieces that are missing, or say from where to where: --frames."
            )
        return self.say(DropUnnamed(), Trim(low, high), why=why)

    def review(self, number: int, *, right: bool, why: str = "") -> Said:
        """A verdict on an ambiguous decision, by its number from 1 among those of the tracking.

        Raises:
            KinemarkError: there is no such decision, or its tracks have no sample at its time.
        """
        if not 1 <= number <= len(self.decisions):
            raise KinemarkError(f"There is no decision {number}: the tracking left {len(self.decisions)} to look at.")
        decision, start = self.decisions[number - 1], self.trajectories.first_frame
        ends = decision.first + start, decision.last + start
        beside = ends[0] - REVIEWED_BESIDE, ends[1] + REVIEWED_BESIDE
        names = [self.trajectories.names[track] for track in decision.tracks if track >= 0]
        try:
            where = tuple(
                stretch_of(
                    self.trajectories, name, first=ends[0], last=ends[1], within=beside, detections=self.detections,
                    world=self.world,
                )
                for name in names
            )  # fmt: skip
        except ValueError as error:
            raise KinemarkError(f"{error}.") from error
        return self.say(Verdict(decision.kind, where, right), why=why)

    def sign(self, *, why: str = "") -> Entry:
        """Stand for the trial as it is now."""
        head = self.journal.head
        return self.journal.append([Signed(head)], by=self.by, why=why, head=head)

    def _known(self, marker: str) -> str:
        """Raises a KinemarkError where there is no such marker, or it has no name."""
        names = self.edited().trajectories.names
        if marker not in names:
            raise KinemarkError(f"There is no marker {marker}; there are {', '.join(names) or 'none'}.")
        if not is_named(marker):
            raise KinemarkError(
                f"{marker} is the number of a track, which is another in the next run. Claim a name for it first."
            )
        return marker

    def replayed(self, entries: Sequence[Entry]) -> Edited:
        """The trial with these entries."""
        return replay(self.trajectories, entries, detections=self.detections, rig=self.rig, world=self.world)


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


def _made(kind: type[EditKind], *values: object) -> EditKind:
    """An edit, with the user's mistakes as errors of theirs."""
    try:
        return kind(*values)
    except ValueError as error:
        raise KinemarkError(f"{error}.") from error


def _seen(rig: Rig, xyz: Floats) -> Iterator[tuple[str, float, float]]:
    """Where a place is in the images of all cameras that look at it."""
    for camera in rig:
        if (camera.R @ xyz + camera.t)[2] > 0:
            u, v = project(camera, xyz[None])[0].tolist()
            yield camera.name, u, v
