"""What a file could not hold as it was: as values, and their words: here, so that a conversion imports no report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

Kind = Literal["resampled", "cut", "not_written", "not_turned", "turned", "incomplete", "shortened", "read", "left_out"]


@dataclass(frozen=True, slots=True)
class FileNote:
    """One thing that changed or was left out on the way from one file into another.

    Attributes:
        kind: "turned", to other axes; "not_turned", which stay in those in which they were computed;
            "resampled", to another rate; "cut", where it reaches beyond the frames; "not_written", as the format has
            no place for it; "incomplete", where a sample that is known in part is missing in the file; "shortened",
            names cut to what the format has room for;
            "read", what was odd in the source; "left_out", files that were not read.
        what: "analog", "signals", "force plates", "events", "covariance", …; in words where something was read.
        names: the channels, signals or markers, in order; empty where it is all of them.
        values: numbers that go with it: `rate_hz` and `stored_rate_hz` of what was resampled, `seconds` that were cut.
    """

    kind: Kind
    what: str
    names: tuple[str, ...] = ()
    values: Mapping[str, float] = field(default_factory=dict)


UNREADABLE = "unreadable: "
"""How the note of a reader begins that says what is lost of a file; all others say what is odd, or not needed."""


def read_notes(notes: Iterable[str]) -> tuple[FileNote, ...]:
    """What was odd in a source, among the notes of what became of it."""
    return tuple(FileNote("read", note) for note in notes)


MOST_NAMES = 8
"""So many names stand in a sentence, all of them in its figures; chosen."""

TEMPLATES = {
    "turned": "{who}.",
    "not_turned": "{who}: not turned; they stay in the axes in which they were computed.",
    "resampled": "{who}: resampled from {rate_hz:g} to {stored_rate_hz:g} Hz.",
    "cut": "{who}: {seconds:.3g} s beyond the frames are not in the file.",
    "not_written": "{who}: not in the file, as its format has no place for it. HDF5 (.h5) keeps all.",
    "incomplete": "{who}: samples of which only some components are known are missing in the file.",
    "shortened": "{who}: cut to 127 bytes in the file, as its format has no room for more. HDF5 (.h5) keeps all.",
    "read": "in the source: {who}.",
    "left_out": "{who}: left out, as another format of the same recording is there.",
}
"""By `FileNote.kind`."""


def file_note_figures(notes: Iterable[FileNote]) -> list[dict[str, Any]]:
    """Notes for a machine, each with its sentence."""
    return [{**asdict(note), "text": file_note_text(note)} for note in notes]


def file_note_text(note: FileNote) -> str:
    """A note as a sentence."""
    listed, more = note.names[:MOST_NAMES], len(note.names) - MOST_NAMES
    who = note.what + (f" {', '.join(listed)}" if listed else "") + (f" and {more} more" if more > 0 else "")
    who = who.rstrip(".") if note.kind == "read" else who
    return TEMPLATES[note.kind].format(who=who, **note.values)
