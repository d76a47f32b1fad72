"""Acts of the page as edits of the journal: said, or only looked at."""

from __future__ import annotations

import numpy as np

from ...data import KinemarkError, Origin
from ...data.edit_outcomes import Applied
from ...data.edits import AddEvent, Claim, Edit, Signed, Trim, Undo
from ...edit import Edited
from ...engine.editing import makers as make
from ...engine.editing.editing import Editing, Said
from ...engine.editing.journal import StaleJournal, last_undo
from ...report.words import edit_text
from .acts_messages import (
    Act,
    AlternativeAct,
    ClaimAct,
    EraseAct,
    EventAct,
    ExchangeAct,
    FinishAct,
    GapAct,
    ImageAct,
    PutAct,
    RedoAct,
    ReviewAct,
    SeveralAct,
    SidesAct,
    SignAct,
    SmoothAct,
    TrackAgainAct,
    TrimAct,
    UndoAct,
)
from .changed_paths import bases_of, changed_by, shown_now, span_of
from .desk import OpenDocument
from .edit_messages import ActBody, ActDone, Join, Outcome, Preview
from .gap_work import work_of
from .header import header, next_undo, pairs_of
from .images import mosaic_of
from .paths import differing, part
from .problems import alternative_edits, verdict_on
from .turns import Rank

STALE = "Somebody else has said something of this trial since. It is shown anew: look, and decide again."


def act(document: OpenDocument, body: ActBody) -> ActDone:
    """Write an act into the journal, and say what it changed.

    Raises:
        StaleJournal: the journal is not as the page has seen it.
        KinemarkError: it cannot be done.
    """
    with document.lock:
        document.refresh()
        if body.head != document.head:
            raise StaleJournal(STALE)
        before = document.now
        edits = edits_of(document, body.act)  # which may have to look for problems, that give way to the rest
        with work_of(document).turns.taken(Rank.ASKED):
            said = document.editing.say(*edits, why=body.why, head=body.head)
            document.refresh()
            return done(document, said, before)


def done(document: OpenDocument, said: Said, before: Edited) -> ActDone:
    """What an act that was said changed since `before`."""
    changed, removed = changed_by(before, document.now)
    return ActDone(
        entry=said.entry.id,
        outcomes=[outcome(one) for one in said.applied],
        head=document.head,
        changed=changed,
        removed=removed,
        paths=shown_now(document, before, changed, removed),
        header=header(document, mosaic_of(document)),
    )


def seen_anew(before: Edited, document: OpenDocument, said: ActDone) -> ActDone:
    """What an act changed that had the trial tracked or named again: `document` is the trial opened anew."""
    changed, removed = changed_by(before, document.now)
    shown = header(document, mosaic_of(document))
    now = {"changed": changed, "removed": removed, "head": document.head, "header": shown, "paths": None}
    return said.model_copy(update=now)


def preview(document: OpenDocument, said: Act) -> Preview:
    """What an act would give; nothing is written."""
    with document.lock:
        document.refresh()
        before, after = document.now, previewed(document, said)
    changed, removed = differing(before.trajectories, after.trajectories)
    outcomes = [outcome(one) for one in after.applied[len(before.applied) :]]
    bases = bases_of(before.trajectories, after.trajectories, changed, ())
    first, stop = span_of(before, after, bases)
    shown = part(changed, after.trajectories, first, stop)
    return Preview(outcomes=outcomes, changed=changed, removed=removed, paths=shown, join=_join(document.editing, said))


def previewed(document: OpenDocument, said: Act) -> Edited:
    """The trial with an act that is not said."""
    return document.editing.preview(edits_of(document, said))


def outcome(one: Applied) -> Outcome:
    """What became of an edit, for the page."""
    words = edit_text(one.edit)
    return Outcome(
        kind=one.edit.kind, words=words, outcome=one.outcome, share=one.share, samples=one.samples, reason=one.reason
    )


def edits_of(document: OpenDocument, said: Act) -> tuple[Edit, ...]:
    """The edits that an act says.

    Raises:
        KinemarkError: it cannot be.
    """
    match said:
        case SeveralAct():
            return tuple(edit for one in said.acts for edit in edits_of(document, one))
        case AlternativeAct():
            return alternative_edits(document, said.problem, said.key)
        case ReviewAct():
            return (verdict_on(document, said.problem, right=said.right),)
        case SidesAct():
            return _sides(document, said)
        case UndoAct() | RedoAct() | SignAct():
            return (_of_journal(document, said),)
        case _:
            return _of_trial(document.editing, said)


def _of_trial(of: Editing, said: Act) -> tuple[Edit, ...]:
    """Edits of identities and of the whole."""
    match said:
        case ClaimAct():
            return make.claim(of, said.track, said.name, first=said.first, last=said.last, at=said.at)
        case ExchangeAct():
            return make.exchange(of, said.a, said.b, first=said.first, last=said.last)
        case TrimAct():
            return (make.made(Trim, said.first, said.last),)
        case FinishAct():
            return make.finish(of, first=said.first, last=said.last)
        case TrackAgainAct():
            return (make.track_again(of),)
        case EventAct():
            return (make.made(AddEvent, said.label, said.side, said.time_s),)
        case _:
            return (_of_marker(of, said),)


def _of_marker(of: Editing, said: Act) -> Edit:
    """Edits of one marker's values."""
    match said:
        case EraseAct():
            return make.erase(of, said.marker, said.first, said.last)
        case PutAct():
            return _put(of, said)
        case GapAct():
            return make.gap(of, said.marker, said.first, said.last, said.method)
        case SmoothAct():
            return make.smooth(of, said.marker, said.first, said.last, said.cutoff_hz, function=said.function)
        case ImageAct():
            return make.image(of, said.camera, said.frame, said.u, said.v, said.marker)
        case _:
            raise KinemarkError(f"{said.kind} is no act of this trial.")


def _put(of: Editing, said: PutAct) -> Edit:
    """A place, or clicks that show one."""
    if said.xyz is not None:
        return make.put(of, said.marker, said.frame, said.xyz, sd_mm=said.sd or make.PUT_SD)
    images = {one.camera: (one.u, one.v) for one in said.clicks}
    return make.put_in_images(of, said.marker, said.frame, images)


def _sides(document: OpenDocument, said: SidesAct) -> tuple[Claim, ...]:
    """Every left and right pair exchanged, of those that are there; in a stretch some are only one of both."""
    pairs = pairs_of(document)
    if not pairs:
        raise KinemarkError("There is no pair of a left and a right marker in this trial.")
    ways = [(a, b) for pair in pairs for a, b in (pair, pair[::-1]) if _seen(document, a, said)]
    if not ways:
        raise KinemarkError("No marker of a left and right pair has a sample in these frames.")
    claims = (make.claim(document.editing, a, b, first=said.first, last=said.last) for a, b in ways)
    return tuple(claim for one in claims for claim in one)


def _seen(document: OpenDocument, marker: str, said: SidesAct) -> bool:
    """Whether a marker has a sample in the frames of an exchange."""
    now = document.now.trajectories
    frames = np.flatnonzero(now[marker].origin != Origin.MISSING) + now.first_frame
    frames = frames if said.first is None else frames[frames >= said.first]
    return len(frames if said.last is None else frames[frames <= said.last]) > 0


def _of_journal(document: OpenDocument, said: UndoAct | RedoAct | SignAct) -> Edit:
    """Undo, redo and signature."""
    if isinstance(said, SignAct):
        return Signed(document.head)
    if isinstance(said, UndoAct):
        of = next_undo(document.text) if said.of is None else said.of
        if of is None:
            raise KinemarkError("There is nothing to undo.")
        return Undo(of)
    last = last_undo(document.text.entries)
    if last is None:
        raise KinemarkError("There is nothing to redo: nothing was undone last.")
    return Undo(last.id)


def _join(of: Editing, said: Act) -> Join | None:
    """How well a claimed track goes on the marker of that name (KISS 4.3)."""
    if not isinstance(said, ClaimAct) or said.name is None:
        return None
    found = of.connection(said.track, said.name)
    if found is None:
        return None
    apart = max(found.gap, 1) / of.trajectories.rate
    return Join(**found._asdict(), speed_mm_s=found.off_mm / apart)
