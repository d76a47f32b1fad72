"""The journal of what people said of a trial: `edits/<trial>.jsonl` beside the recording, append-only.

It is input: nothing that is computed goes into it, deleting results does not touch it, and no line is ever changed. An
entry stands on disk before `append` returns, so that what was answered is never lost; a process that is killed in the
midst leaves at most a cut-off line, which is named and does no harm. One process at a time writes; whoever writes on
what they have seen gives its head, and is refused where the journal has gone on since.
"""

from __future__ import annotations

import getpass
import os
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from filelock import FileLock, Timeout

from ...data import KinemarkError
from ...data.edits import Edit, Entry, Signed, Undo, counting, live
from ...io.edits_jsonl import Fault, JournalText, hash_of, line_of, parse_journal
from ...version import __version__

FOLDER = "edits"
WAIT_S = 10.0
"""How long a writer waits for another one, s; chosen: an append takes milliseconds."""


class StaleJournal(KinemarkError):
    """The journal has gone on since whoever writes has read it."""


@dataclass(frozen=True, slots=True)
class Journal:
    """A journal by its file, which need not be there yet."""

    path: Path

    @classmethod
    def of(cls, root: Path, trial: str) -> Journal:
        """That of a trial in a session's folder, or of a file of trajectories by its stem."""
        return cls(root / FOLDER / f"{trial}.jsonl")

    def read(self) -> JournalText:
        """All that stands in it; nothing where there is no file.

        Raises:
            KinemarkError: the file is there and cannot be read.
        """
        try:
            return parse_journal(self.path.read_bytes())
        except FileNotFoundError:
            return parse_journal(b"")
        except OSError as error:
            raise KinemarkError(f"{self.path} cannot be read: {error}. Check who may read it.") from error

    @property
    def entries(self) -> tuple[Entry, ...]:
        """All of its entries."""
        return self.read().entries

    @property
    def faults(self) -> tuple[Fault, ...]:
        """What is wrong with its lines."""
        return self.read().faults

    @property
    def head(self) -> str:
        """The hash of its last line."""
        return self.read().head

    def append(self, edits: Sequence[Edit], *, by: str = "", why: str = "", head: str | None = None) -> Entry:
        """Write one act, and return when it stands on disk.

        Args:
            edits: what was said.
            by: who; the user of the machine where empty. why: in their words.
            head: of the journal as the writer has seen it; None writes whatever it is now.

        Raises:
            StaleJournal: the journal has another head.
            KinemarkError: there is nothing to write, an undo is of no entry, another process has the journal for long,
                or the file cannot be written.
        """
        if not edits:
            raise KinemarkError("There is nothing to write: give at least one edit.")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with FileLock(self.path.with_name(f".{self.path.name}.lock"), timeout=WAIT_S):
                return self._append(tuple(edits), by or _user(), why, head)
        except Timeout as error:
            raise KinemarkError(f"Another process writes to {self.path}. Try again when it is done.") from error
        except OSError as error:
            raise KinemarkError(f"{self.path} cannot be written: {error}. Nothing was said.") from error

    def undo(self, of: int | None = None, *, by: str = "", why: str = "") -> Entry:
        """Take an entry back, the last that counts where None.

        Raises:
            KinemarkError: there is none, or it was undone before.
        """
        if of is None:
            of = next((e.id for e in reversed(live(self.entries)) if not _is(Signed, e)), None)
        if of is None:
            raise KinemarkError(f"There is nothing to undo in {self.path}.")
        return self.append([Undo(of)], by=by, why=why)

    def redo(self, *, by: str = "", why: str = "") -> Entry:
        """Take the last undo back that was not itself undone, unless something was said since.

        Raises:
            KinemarkError: there is none.
        """
        last = last_undo(self.entries)
        if last is None:
            raise KinemarkError(f"There is nothing to redo in {self.path}: nothing was undone last.")
        return self.append([Undo(last.id)], by=by, why=why)

    def _append(self, edits: tuple[Edit, ...], by: str, why: str, head: str | None) -> Entry:
        """With the lock held."""
        content = self.path.read_bytes() if self.path.is_file() else b""
        known = parse_journal(content)
        if head is not None and head != known.head:
            raise StaleJournal(
                f"{self.path} has gone on: its last line is another one than was read. Read it again, and decide anew."
            )
        _check_undo(known.entries, edits)
        number = max([known.lines, *(entry.id for entry in known.entries)]) + 1
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        entry = Entry(number, now, by, why, __version__, known.head, edits)
        cut_off = b"" if not content or content.endswith(b"\n") else b"\n"  # what a killed process left
        _write_through(self.path, cut_off + line_of(entry))
        return entry


def hash_of_entry(entry: Entry) -> str:
    """The hash of an entry's line: the head of the journal when it was the last."""
    return hash_of(line_of(entry))


def last_undo(entries: Sequence[Entry]) -> Entry | None:
    """The undo that a redo takes back: the last that counts, where nothing but undo and redo came after it."""
    undos = {entry.id for entry in entries if _is(Undo, entry)}
    counts = {entry.id for entry in counting(entries)}
    for entry in reversed(entries):
        if entry.id not in undos:
            return None
        redo = any(isinstance(edit, Undo) and edit.of in undos for edit in entry.edits)
        if entry.id in counts and not redo:
            return entry
    return None


def _is(kind: type, entry: Entry) -> bool:
    return any(isinstance(edit, kind) for edit in entry.edits)


def journals_of_no_trial(root: Path, trials: Sequence[str]) -> tuple[Path, ...]:
    """Journals in a session's folder that say something, and are of none of its trials, as after one was renamed.

    Args:
        root: the session's folder. trials: names of its trials.
    """
    found = sorted((root / FOLDER).glob("*.jsonl"))
    return tuple(path for path in found if path.stem not in trials and path.stat().st_size)


def _check_undo(entries: Sequence[Entry], edits: Sequence[Edit]) -> None:
    """Raises a KinemarkError where an undo is of no entry, or of one that does not count any more."""
    known, counts = ({entry.id for entry in some} for some in (entries, counting(entries)))
    for edit in edits:
        if isinstance(edit, Undo) and edit.of not in known:
            raise KinemarkError(f"There is no entry {edit.of}. List them: kinemark edits list.")
        if isinstance(edit, Undo) and edit.of not in counts:
            raise KinemarkError(f"Entry {edit.of} was undone before. List them: kinemark edits list.")


def _user() -> str:
    """Whose account it is."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # an account without a name, as in some containers
        return str(os.getuid()) if hasattr(os, "getuid") else "unknown"


def _write_through(path: Path, line: bytes) -> None:
    """Add a line to a file, and wait until the disk has it; a line that is cut off by an error is taken away again."""
    new = not path.exists()
    file = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
    try:
        size = os.fstat(file).st_size
        try:
            if os.write(file, line) != len(line):
                raise OSError("the disk took only a part of it")
            os.fsync(file)
        except OSError:
            os.ftruncate(file, size)
            raise
    finally:
        os.close(file)
    if new and os.name == "posix":
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
