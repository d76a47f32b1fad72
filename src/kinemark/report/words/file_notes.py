"""What did not go from one file into another as it was."""

from __future__ import annotations

from ...io.notes import FileNote

TEMPLATES = {
    "resampled": "{who}: resampled from {rate_hz:g} to {stored_rate_hz:g} Hz.",
    "cut": "{who}: {seconds:.3g} s beyond the frames are not in the file.",
    "not_written": "{who}: not in the file, as its format has no place for it. HDF5 (.h5) keeps all.",
    "incomplete": "{who}: samples of which only some components are known are missing in the file.",
    "read": "in the source: {who}.",
}
"""By `FileNote.kind`."""


def file_note_text(note: FileNote) -> str:
    """A note as a sentence."""
    who = note.what + (f" {', '.join(note.names)}" if note.names else "")
    who = who.rstrip(".") if note.kind == "read" else who
    return TEMPLATES[note.kind].format(who=who, **note.values)
