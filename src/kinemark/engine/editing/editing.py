"""Editing a trial: what can be said of it, in one call each; the command line and every other face drive this.

A trial of a session is edited as it comes from tracking and naming; a file of trajectories as it stands in the file,
which is never changed: `files.write_edited` writes another one. What is said goes into the journal beside it,
`edits/<name>.jsonl`, and nowhere else.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock
from typing import NamedTuple

from ...data import Detections, KinemarkError, Rig, Trajectories, Trial
from ...data.edit_outcomes import Applied
from ...data.edits import AddEvent, Claim, Edit, Entry, Signed, SmoothingFunction, Trim, facts_of
from ...edit import Connection, Edited, anchored, connection, replay
from ...edit.anchors import Anchored
from ...fill import PieceMatch, piece_matches
from ...io.edits_jsonl import NOTHING
from ...io.trial import read_trial
from ...track.simultaneous import AmbiguousDecision
from ..graph import Records
from ..keys import world_key
from ..naming.claims import claims_of
from ..open_trial import OpenTrial
from ..put_aside import computed_names
from ..trial_inputs import TrialInputs, detections_of, last_tracked, measured_of, trial_rig
from . import makers
from .journal import Journal, hash_of_entry
from .makers import PUT_SD
from .stage import applied_entries, check_methods, claims_are_facts, unsigned

MOST_VERSIONS = 16
"""Versions that are kept; chosen: as far as people undo and redo while they look."""


class Replays:
    """Versions of a trial that were replayed already: undo, redo and preview come back to them at once.

    They share all markers that an edit does not touch, so several cost little more than one. Entries are known by
    identity, as a journal gives the same record for the same line.
    """

    def __init__(self) -> None:
        self._known: OrderedDict[tuple[int, ...], tuple[Sequence[Entry], Edited]] = OrderedDict()
        self._lock = Lock()

    def of(self, entries: Sequence[Entry], replay: Callable[[Sequence[Entry]], Edited]) -> Edited:
        """The version with these entries, replayed where it is not known."""
        key = tuple(map(id, entries))
        with self._lock:
            found = self._known.get(key)
        if found is None:
            found = entries, replay(entries)  # the entries are kept, so that their ids stay their own
        with self._lock:
            self._known[key] = found
            self._known.move_to_end(key)
            while len(self._known) > MOST_VERSIONS:
                self._known.popitem(last=False)
        return found[1]


class Said(NamedTuple):
    """An entry of the journal, and what became of its edits."""

    entry: Entry
    applied: tuple[Applied, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Editing:
    """A trial that is edited.

    Attributes:
        name: of the trial. journal: of what was said.
        trajectories: before all edits; detections, rig: behind them, the cameras as they were made with; None for a
            file without. timed: the detections at the times of the frames; None where they are.
        left_out: cameras and frames in which they fit the others no more, as `edit.values.Footage` has them.
        given: the cameras as they were calibrated, in whose world places are; `rig` where None.
        by: who edits; the user of the machine where empty.
        source: the file's trial; None of a session's. decisions: of the tracking that were close.
        facts: the claims by which the markers were named; pinned: the edits with which they were tracked again.
        named: whether claims are facts for the names, so that one which confirms a name holds.
        replays: versions that were worked out before.
    """

    name: str
    journal: Journal
    trajectories: Trajectories
    detections: Detections | None = None
    rig: Rig | None = None
    timed: Detections | None = None
    left_out: tuple[tuple[str, int, int], ...] = ()
    given: Rig | None = None
    by: str = ""
    source: Trial | None = None
    decisions: tuple[AmbiguousDecision, ...] = ()
    facts: tuple[Claim, ...] = ()
    pinned: tuple[Edit, ...] = ()
    named: bool = False
    replays: Replays = field(default_factory=Replays, repr=False)

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
        decisions = last_tracked(records).ambiguous_decisions
        named = claims_are_facts(records)
        facts = claims_of(trial.workspace.root, trial.name) if named else ()
        seen, cameras, first = detections_of(records), trial_rig(records), inputs.source.of.first_frame
        return cls(
            trial.name, journal, measured_of(inputs, records), seen, cameras.rig, cameras.timed(seen),
            cameras.left_out_of(first), inputs.rig, by, decisions=decisions, facts=facts,
            pinned=_pinned(journal) if "retrack" in records else (), named=named,
        )  # fmt: skip

    @property
    def computed(self) -> frozenset[str]:
        """Points of a file that are no markers (`put_aside`), by the names that it gives them."""
        return frozenset() if self.source is None else frozenset(computed_names(self.source))

    @property
    def outdated(self) -> bool:
        """Whether what the markers were tracked or named by does not count any more: open the trial anew."""
        now = [edit for entry in applied_entries(self.journal.read()) for edit in entry.edits]
        return _pinned(self.journal) != self.pinned or any(claim not in now for claim in self.facts)

    @classmethod
    def of_file(cls, path: Path, *, by: str = "", trial: Trial | None = None) -> Editing:
        """A file of trajectories, and its trial where that was read; its journal is in the folder `edits` beside it.

        Raises:
            KinemarkError: it cannot be read, or two of its markers have one name.
        """
        trial = read_trial(path) if trial is None else trial
        names = trial.trajectories.names
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise KinemarkError(f"{path} has {', '.join(twice)} more than once. Give each marker a name of its own.")
        return cls(path.stem, Journal.of(path.parent, path.stem), trial.trajectories, by=by, source=trial)

    @property
    def world(self) -> str:
        """Key of the world that places are in."""
        given = self.given or self.rig
        return "" if given is None else world_key(given)

    def edited(self) -> Edited:
        """The trial with all that stands in the journal."""
        return self._replayed(applied_entries(self.journal.read()))

    def preview(self, edits: Sequence[Edit]) -> Edited:
        """What an act would give; it is written nowhere.

        Raises:
            KinemarkError: a choice for a gap is no method.
        """
        check_methods(edits)
        entries = self.journal.read().entries
        number = max((entry.id for entry in entries), default=0) + 1
        return self._replayed(unsigned((*entries, Entry(number, "", self.by, "", "", "", tuple(edits)))))

    def at(self, head: str) -> Edited:
        """The trial as it was when the journal had this head; before all edits where that is empty.

        Raises:
            KinemarkError: the journal never had it.
        """
        entries = self.journal.read().entries
        heads = [NOTHING, *map(hash_of_entry, entries)]
        head = head or NOTHING
        if head not in heads:
            raise KinemarkError(f"The journal {self.journal.path} has no line with the hash {head[:12]}.")
        return self._replayed(unsigned(entries[: heads.index(head)]))

    def say(self, *edits: Edit, why: str = "", head: str | None = None) -> Said:
        """Write one act into the journal; what came of it.

        Raises:
            KinemarkError: a choice for a gap is no method, or the journal cannot be written or has gone on.
        """
        check_methods(edits)
        entry = self.journal.append(self._anchored(edits), by=self.by, why=why, head=head)
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
        return self.say(*makers.claim(self, track, name, first=first, last=last, at=at), why=why)

    def exchange(
        self, one: str, other: str, *, first: int | None = None, last: int | None = None, why: str = ""
    ) -> Said:
        """Two trajectories have each other's names in these frames.

        Raises:
            KinemarkError: one has no marker's name, is not there, or has no sample.
        """
        return self.say(*makers.exchange(self, one, other, first=first, last=last), why=why)

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

    def matches(self, track: str) -> tuple[PieceMatch, ...]:
        """The markers that a piece of track may be, by where filling puts those that are missing then.

        Raises:
            KinemarkError: there is no such trajectory, or it has no sample.
        """
        try:
            return piece_matches(self.edited().trajectories, track)
        except (KeyError, ValueError) as error:
            raise KinemarkError(f"{error.args[0]}.") from error

    def erase(self, marker: str, first: int, last: int, *, why: str = "") -> Said:
        """Samples of a marker are wrong."""
        return self.say(makers.erase(self, marker, first, last), why=why)

    def put(self, marker: str, frame: int, xyz: Sequence[float], *, sd_mm: float = PUT_SD, why: str = "") -> Said:
        """A marker is at this place, mm, in a frame."""
        return self.say(makers.put(self, marker, frame, xyz, sd_mm=sd_mm), why=why)

    def put_in_images(self, marker: str, frame: int, images: dict[str, tuple[float, float]], *, why: str = "") -> Said:
        """A marker is where it was clicked in two images or more: u, v px by camera.

        Raises:
            KinemarkError: these are no place.
        """
        return self.say(makers.put_in_images(self, marker, frame, images), why=why)

    def gap(self, marker: str, first: int, last: int, method: str, *, why: str = "") -> Said:
        """How gaps of a marker that reach into these frames are filled: a method, "best" or "open"."""
        return self.say(makers.gap(self, marker, first, last, method), why=why)

    def smooth(
        self,
        marker: str,
        first: int,
        last: int,
        cutoff_hz: float,
        *,
        function: SmoothingFunction = "butterworth",
        why: str = "",
    ) -> Said:
        """A stretch of a marker is low-pass filtered by a function."""
        return self.say(makers.smooth(self, marker, first, last, cutoff_hz, function), why=why)

    def image(self, camera: str, frame: int, u: float, v: float, marker: str | None, *, why: str = "") -> Said:
        """Where a marker is in an image; or that the image there is no marker's."""
        return self.say(makers.image(self, camera, frame, u, v, marker), why=why)

    def event(self, label: str, side: str, time_s: float, *, why: str = "") -> Said:
        """An event, s from frame 1 of the recording."""
        return self.say(makers.made(AddEvent, label, side, time_s), why=why)

    def trim(self, first: int, last: int, *, why: str = "") -> Said:
        """All markers begin and end at these frames."""
        return self.say(makers.made(Trim, first, last), why=why)

    def finish(self, *, first: int | None = None, last: int | None = None, why: str = "") -> Said:
        """Drop what is unnamed, and trim all markers to the frames that all of them have (KISS 4.3): one act.

        Raises:
            KinemarkError: no marker has a name, or there is no frame between the first and the last that all have.
        """
        return self.say(*makers.finish(self, first=first, last=last), why=why)

    def track_again(self, *, why: str = "") -> Said:
        """Make the tracks again with all that stands as facts for the tracker; open the trial anew to see them.

        Raises:
            KinemarkError: there are no images, or nothing was said that tracking could use.
        """
        return self.say(makers.track_again(self), why=why)

    def review(self, number: int, *, right: bool, why: str = "") -> Said:
        """A verdict on an ambiguous decision, by its number from 1 among those of the tracking.

        Raises:
            KinemarkError: there is no such decision, or its tracks have no sample at its time.
        """
        return self.say(makers.review(self, number, right=right), why=why)

    def sign(self, *, why: str = "") -> Entry:
        """Stand for the trial as it is now."""
        head = self.journal.head
        return self.journal.append([Signed(head)], by=self.by, why=why, head=head)

    def _anchored(self, edits: Sequence[Edit]) -> tuple[Edit, ...]:
        """Edits with their witnesses, of markers as they are called when the claims among these are said."""
        if not any(isinstance(edit, Anchored) for edit in edits):
            return tuple(edits)
        claims = [edit for edit in edits if isinstance(edit, Claim)]
        now = self.preview(claims) if claims else self.edited()
        before = {fold.before.name: fold.before for fold in now.folds}
        return tuple(anchored(edit, now.trajectories, self.detections, self.world, before) for edit in edits)

    def _replayed(self, entries: Sequence[Entry]) -> Edited:
        def replayed(entries: Sequence[Entry]) -> Edited:
            return replay(
                self.trajectories, entries, detections=self.detections, timed=self.timed, rig=self.rig,
                world=self.world, left_out=self.left_out, facts=self.named,
            )  # fmt: skip

        return self.replays.of(entries, replayed)


def _pinned(journal: Journal) -> tuple[Edit, ...]:
    """The edits of a journal that are facts for the tracker."""
    return tuple(edit for entry in facts_of(journal.read().entries) for edit in entry.edits)
