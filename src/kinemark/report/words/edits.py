"""What findings of edits say, and edits themselves, in words."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from ...data.edits import (
    SMOOTHING,
    AddEvent,
    Claim,
    DropUnnamed,
    Edit,
    Erase,
    GapChoice,
    ImagePoint,
    Put,
    Signed,
    Smooth,
    Stretch,
    TrackAgain,
    Trim,
    Undo,
    Verdict,
)
from ..formatting import span_of_frames
from .template import Words

EDIT_WORDS = {
    "edits_orphaned": Words(
        "{edits} {edits:edit of the journal no longer finds its place and is|edits of the journal no longer find their "
        "places and are} applied to nothing: {entries_list}.",
        "Look at {edits:it|them} with kinemark edits show, and say {edits:it|them} again where the trial needs it.",
    ),
    "edits_thin": Words(
        "{edits} {edits:edit of the journal stands|edits of the journal stand} on few of what it was said of: "
        "{entries_list}.",
        "Check that {edits:it is|they are} still right: kinemark edits check.",
    ),
    "edits_unreadable": Words(
        "{lines} {lines:line|lines} of the journal of edits {lines:does|do} not count: {lines_list}.",
        "Find out who changed the file; the other lines stand. What was lost must be said again.",
    ),
    "edits_applied": Words(
        "The journal has {entries} {entries:entry|entries}: {held} {held:stands|stand}, {moot} had nothing left to do, "
        "{overruled} gave way to later ones.",
    ),
}


SAID, FIRST = 3, 2
"""Edits of a kind in one entry that are all said, and those that are said where there are more; chosen."""


def entry_text(edits: Sequence[Edit]) -> str:
    """What an entry says, in a line; of many edits of a kind the first ones, and how many more there are."""
    if edits and (settled := _settled_text(edits)):
        return settled
    said: list[str] = []
    for _, some in groupby(edits, key=lambda edit: edit.kind):
        texts = [edit_text(edit) for edit in some]
        said += texts if len(texts) <= SAID else [*texts[:FIRST], f"and {len(texts) - FIRST} more"]
    return "; ".join(said)


def _settled_text(edits: Sequence[Edit]) -> str:
    """What an entry says that settled an exchange, or made pieces one marker; nothing of others."""
    *claims, last = edits
    names = [edit.name for edit in claims if isinstance(edit, Claim) and edit.name is not None]
    if not isinstance(last, Verdict) or last.right or not claims or len(names) < len(claims):
        return ""
    spans = [_frames(edit.where) for edit in claims if isinstance(edit, Claim)]
    if last.decision == "swap" and len(set(names)) == 2 and len(set(spans)) == 1:
        return f"{' and '.join(names)} exchanged, {spans[0]}"
    if last.decision == "join" and len(set(names)) == 1:
        return f"one marker: {names[0]}, {' and '.join(spans)}"
    return ""


def edit_text(edit: Edit) -> str:
    """What somebody said, in a line."""
    match edit:
        case Claim():
            return f"{'no marker' if edit.name is None else edit.name}: {_span(edit.where)}"
        case Erase():
            return f"{edit.marker} {span_of_frames(edit.first, edit.last)}: erased"
        case Put():
            x, y, z = edit.xyz
            return f"{edit.marker} {span_of_frames(edit.frame, edit.frame)}: put at ({x:.1f}, {y:.1f}, {z:.1f}) mm"
        case GapChoice():
            how = "left open" if edit.method == "open" else f"filled by {edit.method}"
            return f"{edit.marker}, gaps in {span_of_frames(edit.first, edit.last)}: {how}"
        case Smooth():
            by = "" if edit.function == SMOOTHING[0] else f" by {edit.function}"
            return f"{edit.marker} {span_of_frames(edit.first, edit.last)}: smoothed{by}, {edit.cutoff_hz:g} Hz"
        case ImagePoint():
            who = "no marker" if edit.marker is None else edit.marker
            return f"{who} in {edit.camera}, frame {edit.frame}: ({edit.u:.1f}, {edit.v:.1f}) px"
        case _:
            return _whole_text(edit)


DECISIONS = {"swap": "exchange", "join": "one marker", "stitch": "one marker"}
"""What kinds of decisions are called where the list of problems calls them otherwise."""


def _whole_text(edit: Edit) -> str:
    """Of edits that are of the whole trial or the journal."""
    match edit:
        case Verdict():
            frames = [witness.frame for stretch in edit.where for witness in stretch.witnesses]
            at = f" within {span_of_frames(min(frames), max(frames))}" if frames else ""
            what = DECISIONS.get(edit.decision, edit.decision)
            return f"{what}?{at}: {'right as it is' if edit.right else 'it was wrong'}"
        case Trim():
            return f"trimmed to {span_of_frames(edit.first, edit.last)}"
        case DropUnnamed():
            return "unnamed tracks dropped"
        case TrackAgain():
            return "tracked again, with all that was said before"
        case AddEvent():
            return f"event: {edit.side} {edit.label} at {edit.time_s:g} s".replace("  ", " ")
        case Undo():
            return f"entry {edit.of} undone"
        case Signed():
            return f"signed at {edit.head[:12]}"
        case _:
            raise ValueError(f"{edit} is no edit")


OPEN_ENDS = {
    (False, False): "", (False, True): " and on", (True, False): " and before", (True, True): "",
}  # fmt: skip
"""How far a stretch goes on beyond the frames that it was seen in: before them, after them."""


def _span(where: Stretch) -> str:
    """The frames of a stretch and where it begins."""
    x, y, z = where.witnesses[0].xyz
    whole = ", the track as a whole" if where.first is None and where.last is None else ""
    return f"{_frames(where)}{whole}, from ({x:.0f}, {y:.0f}, {z:.0f}) mm"


def _frames(where: Stretch) -> str:
    """The frames of a stretch."""
    seen = [witness.frame for witness in where.witnesses]
    follows = OPEN_ENDS[where.first is None, where.last is None]
    return f"{span_of_frames(where.first or seen[0], where.last or seen[-1])}{follows}"
