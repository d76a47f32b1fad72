"""The trials that lie open: each is loaded once, and looked at again when something is said of it."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ...data import KinemarkError, MarkerSet
from ...data.edits import live
from ...edit import Edited
from ...engine.editing.editing import Editing
from ...engine.naming.templates import worn
from ...engine.open_trial import OpenTrial
from ...engine.session import Session
from ...engine.store import STEPS, Store
from ...engine.trial_inputs import TrialInputs
from ...io.edits_jsonl import JournalText
from .chosen_sets import set_of_file
from .home import other_program, read_once, written
from .shelf import Place, Shelf

MOST_OPEN = 4
"""Trials that are kept in memory; chosen: 60 markers in 10 000 frames with all columns are 150 MB."""


class NotRun(KinemarkError):
    """The trial was not tracked yet, so that there is nothing to show."""


@dataclass(slots=True)
class OpenDocument:
    """An open trial.

    Attributes:
        place: of it. editing: before all edits, with what is behind it.
        trial, inputs, records: of a session's trial, as far as edits need it; None and empty for a file.
        marker_set: that the subject wears, where the session says so; of a file the one that was
            chosen, else as its names show.
        text, now: the journal as it was read, and the trial with it.
        lock: for whoever reads or changes `text` and `now`; looking: for whoever looks for problems, which no act waits
            for.
        ran: when the trial was run last, or the file written.
        blobs: encoded columns of trajectories, by the identity of these.
    """

    place: Place
    editing: Editing
    text: JournalText
    now: Edited
    trial: OpenTrial | None = None
    inputs: TrialInputs | None = None
    records: Mapping[str, Any] = field(default_factory=dict)
    marker_set: MarkerSet | None = None
    lock: threading.RLock = field(default_factory=threading.RLock)
    looking: threading.Lock = field(default_factory=threading.Lock)
    blobs: dict[int, Any] = field(default_factory=dict)
    kept: dict[str, Any] = field(default_factory=dict)
    stamp: tuple[int, ...] = ()
    ran: int = 0

    @property
    def head(self) -> str:
        """Of the journal."""
        return self.text.head

    @property
    def said(self) -> int:
        """How many entries count."""
        return len(live(self.text.entries))

    def refresh(self) -> None:
        """Read the journal again where another process has written to it."""
        with self.lock:
            stamp = journal_stamp(self.editing)
            if stamp == self.stamp:
                return
            self.text, self.stamp = self.editing.journal.read(), stamp
            self.now = self.editing.edited()


def journal_stamp(editing: Editing) -> tuple[int, ...]:
    """Changes when the journal does."""
    try:
        stat = editing.journal.path.stat()
        return stat.st_size, stat.st_mtime_ns, stat.st_ino
    except OSError:
        return ()


class Desk:
    """The trials that lie open, the last used ones kept."""

    def __init__(self, shelf: Shelf, by: str) -> None:
        self.shelf = shelf
        self.by = by
        self._open: OrderedDict[str, tuple[int, OpenDocument]] = OrderedDict()
        self._lock = threading.Lock()
        self._places: dict[str, Place] = {}

    def place(self, key: str) -> Place:
        """The trial of an id; raises NotThere."""
        if key not in self._places:
            self._places[key] = self.shelf.place(key)
        return self._places[key]

    def document(self, key: str) -> OpenDocument:
        """The open trial of an id, with all that was said of it until now.

        Raises:
            NotThere: there is none.
            NotRun: it was not tracked, or what it depends on was changed since.
            KinemarkError: it cannot be read.
        """
        place = self.place(key)
        with self._lock:  # two tabs must not load one trial twice
            ran = _ran(place)
            known = self._open.get(key)
            if known is None or known[0] != ran or known[1].editing.outdated:
                self._open[key] = known = ran, opened(place, self.by)
                known[1].ran = ran
            self._open.move_to_end(key)
            while len(self._open) > MOST_OPEN:
                self._open.popitem(last=False)
        known[1].refresh()
        return known[1]

    def forget(self, key: str) -> None:
        """It was run again."""
        with self._lock:
            self._open.pop(key, None)

    def forget_session(self, place: Place) -> None:
        """All trials of a session are loaded anew when they are next asked for."""
        for other in self.shelf.trials():
            if other.path == place.path:
                self.forget(other.id)

    def documents(self) -> dict[str, OpenDocument]:
        """The open trials by their ids."""
        with self._lock:
            return {key: document for key, (_, document) in self._open.items()}

    def heads(self) -> dict[str, str]:
        """The head of each open trial, read anew where it changed."""
        documents = self.documents()
        for document in documents.values():
            document.refresh()
        return {key: document.head for key, document in documents.items()}


def opened(place: Place, by: str) -> OpenDocument:
    """A trial, loaded; raises as `Desk.document` does."""
    if place.trial is None:
        editing = Editing.of_file(place.path, by=by, trial=read_once(place.path))
        _check_markers(place, editing)
        document = _document(place, editing)
        document.marker_set = set_of_file(document.editing, place.path.parent, document.now.trajectories.names)
        return document
    session = Session.open(place.path)
    trial = session.trial(place.trial)
    _check_tracked(trial)
    _, inputs, records = trial.before_edits()
    document = _document(place, Editing.of_records(trial, inputs, records, by=by))
    document.trial, document.inputs, document.records = trial, inputs, records
    document.marker_set = worn(session.root, session.settings)
    return document


def _document(place: Place, editing: Editing) -> OpenDocument:
    stamp = journal_stamp(editing)
    text = editing.journal.read()
    return OpenDocument(place, editing, text, editing.edited(), stamp=stamp)


def _check_markers(place: Place, editing: Editing) -> None:
    """Raises KinemarkError where a file holds no place of any point, as one of analog signals alone."""
    found = editing.trajectories
    if not len(found) or not found.n_frames:
        raise KinemarkError(f"{place.name} holds no trajectories of markers, so there is nothing to show of it here.")


def _check_tracked(trial: OpenTrial) -> None:
    """Raises NotRun where the trial would have to be processed before it can be shown."""
    done = Store.read(trial.folder).old
    if "track" not in done:
        raise NotRun(f"{trial.name} was not run yet. Run it first.")
    if not trial.state()["track"]:  # names are found in seconds, and anew by what was said since
        why = other_program(done["track"]) or f"Settings or recordings changed since {trial.name} was run."
        raise NotRun(f"{why} Run it again: what was said of it is kept.")


def _ran(place: Place) -> int:
    """When the trial was run last, or the file written."""
    if place.trial is None:
        return written(place.path)
    return written(place.path / "results" / place.trial / STEPS)
