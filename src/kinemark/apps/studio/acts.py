"""Acts of the page as edits of the journal, said or only looked at; what they change, in as few samples as can be.

An edit leaves most samples as they are, and often all: a track that was named is the same under another name. So each
trajectory that is new or others than before is said by one of before, its base, and by the frames in which it differs
from that. Where fills are shown all frames are sent: they may have been judged again since the page has them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence

import numpy as np

from ...data import KinemarkError, MarkerTrajectory, Origin, Trajectories
from ...data.array_types import Bools
from ...data.edit_outcomes import Applied
from ...data.edits import AddEvent, Claim, Edit, Signed, Trim, Undo
from ...edit import Edited
from ...engine.editing import makers as make
from ...engine.editing.editing import Editing, Said
from ...engine.editing.journal import StaleJournal, last_undo
from ...report.words import edit_text
from . import acts_messages as m
from .desk import OpenDocument
from .edit_messages import ActBody, ActDone, ChangedPaths, Join, Outcome, Preview
from .gap_work import work_of
from .gaps import chosen_fills, may_show_fills
from .header import header, next_undo, pairs_of
from .images import mosaic_of
from .paths import differing, forget_others, part, whole_part
from .problems import alternative_edits, verdict_on
from .turns import Rank

MOST_SAMPLES = 200_000
"""Of trajectories that are in the answer to an act; chosen: 20 markers of 10 000 frames are 4.5 MB of text."""


def changed_by(before: Edited, after: Edited) -> tuple[list[str], list[str]]:
    """Markers of other samples, or of gaps that are to be filled otherwise; and those that are there no more."""
    changed, removed = differing(before.trajectories, after.trajectories)
    old, new = Counter(before.choices), Counter(after.choices)
    refilled = {choice.marker for choice in [*(old - new), *(new - old)]} - {*changed}
    return changed + [name for name in after.trajectories.names if name in refilled], removed


def shown_now(
    document: OpenDocument, before: Edited, changed: Sequence[str], removed: Sequence[str]
) -> ChangedPaths | None:
    """Trajectories as the page shows them, so that it need not ask again; None where it must."""
    bases = bases_of(before.trajectories, document.now.trajectories, changed, removed)
    filled = may_show_fills(document, before, {*bases.values()}) or may_show_fills(document, document.now, {*changed})
    first, stop = (0, document.now.trajectories.n_frames) if filled else span_of(before, document.now, bases)
    if len(changed) * (stop - first) > MOST_SAMPLES:
        return None
    if not filled and stop - first < document.now.trajectories.n_frames:
        return ChangedPaths(bases=[*bases.values()], **dict(part(changed, document.now.trajectories, first, stop)))
    shown, pending = chosen_fills(document, set(changed))
    forget_others(document, (document.editing.trajectories, document.now.trajectories, shown))
    return None if pending else ChangedPaths(bases=[""] * len(shown), **dict(whole_part(document, shown)))


def bases_of(
    before: Trajectories, after: Trajectories, changed: Sequence[str], removed: Collection[str]
) -> dict[str, str]:
    """By each changed trajectory the one of before that it is told by, empty for none.

    That is the one of its name, else one with the same samples that is there no more; none for one without samples.
    """
    there, gone = {*before.names}, {_mark(path): path.name for path in before if path.name in removed}
    own = (after[name] for name in changed)
    return {p.name: (p.name if p.name in there else gone.get(_mark(p), "")) if p.origin.any() else "" for p in own}


def span_of(before: Edited, after: Edited, bases: dict[str, str]) -> tuple[int, int]:
    """First frame and last-plus-one, from 0, in which any trajectory is other than its base."""
    old, differs = before.trajectories, np.zeros(after.trajectories.n_frames, bool)
    if old.n_frames != len(differs) or old.first_frame != after.trajectories.first_frame:
        return 0, len(differs)
    for name, base in bases.items():
        path = after.trajectories[name]
        differs |= others(old[base], path) if base else path.origin != Origin.MISSING
    at = np.flatnonzero(differs)
    return (int(at[0]), int(at[-1]) + 1) if len(at) else (0, 0)


def others(one: MarkerTrajectory, other: MarkerTrajectory) -> Bools:
    """(F) whether two trajectories have different samples."""
    xyz, cov = _unlike(one.xyz, other.xyz).any(1), _unlike(one.cov, other.cov).any((1, 2))
    return np.asarray((one.origin != other.origin) | xyz | cov)


def _unlike(one: np.ndarray, other: np.ndarray) -> Bools:
    return np.zeros(one.shape, bool) if one is other else (one != other) & ~(np.isnan(one) & np.isnan(other))


def _mark(path: MarkerTrajectory) -> tuple[bytes, bytes]:
    """By which trajectories of nearly the same samples are found."""
    return path.origin.tobytes(), path.xyz[path.origin != Origin.MISSING][:1].tobytes()


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


def preview(document: OpenDocument, said: m.Act) -> Preview:
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


def previewed(document: OpenDocument, said: m.Act) -> Edited:
    """The trial with an act that is not said."""
    return document.editing.preview(edits_of(document, said))


def outcome(one: Applied) -> Outcome:
    """What became of an edit, for the page."""
    return Outcome.like(one, kind=one.edit.kind, words=edit_text(one.edit))


def edits_of(document: OpenDocument, said: m.Act) -> tuple[Edit, ...]:
    """The edits that an act says.

    Raises:
        KinemarkError: it cannot be.
    """
    match said:
        case m.SeveralAct():
            return tuple(edit for one in said.acts for edit in edits_of(document, one))
        case m.AlternativeAct():
            return alternative_edits(document, said.problem, said.key)
        case m.ReviewAct():
            return (verdict_on(document, said.problem, right=said.right),)
        case m.SidesAct():
            return _sides(document, said)
        case m.UndoAct() | m.RedoAct() | m.SignAct():
            return (_of_journal(document, said),)
        case _:
            return _of_trial(document.editing, said)


def _of_trial(of: Editing, said: m.Act) -> tuple[Edit, ...]:
    """Edits of identities and of the whole."""
    match said:
        case m.ClaimAct():
            return make.claim(of, said.track, said.name, first=said.first, last=said.last, at=said.at)
        case m.ExchangeAct():
            return make.exchange(of, said.a, said.b, first=said.first, last=said.last)
        case m.TrimAct():
            return (make.made(Trim, said.first, said.last),)
        case m.FinishAct():
            return make.finish(of, first=said.first, last=said.last)
        case m.TrackAgainAct():
            return (make.track_again(of),)
        case m.EventAct():
            return (make.made(AddEvent, said.label, said.side, said.time_s),)
        case _:
            return (_of_marker(of, said),)


def _of_marker(of: Editing, said: m.Act) -> Edit:
    """Edits of one marker's values."""
    match said:
        case m.EraseAct():
            return make.erase(of, said.marker, said.first, said.last)
        case m.PutAct():
            return _put(of, said)
        case m.GapAct():
            return make.gap(of, said.marker, said.first, said.last, said.method)
        case m.SmoothAct():
            return make.smooth(of, said.marker, said.first, said.last, said.cutoff_hz, function=said.function)
        case m.ImageAct():
            return make.image(of, said.camera, said.frame, said.u, said.v, said.marker)
        case _:
            raise KinemarkError(f"{said.kind} is no act of this trial.")


def _put(of: Editing, said: m.PutAct) -> Edit:
    """A place, or clicks that show one."""
    if said.xyz is not None:
        return make.put(of, said.marker, said.frame, said.xyz, sd_mm=said.sd or make.PUT_SD)
    images = {one.camera: (one.u, one.v) for one in said.clicks}
    return make.put_in_images(of, said.marker, said.frame, images)


def _sides(document: OpenDocument, said: m.SidesAct) -> tuple[Claim, ...]:
    """Every left and right pair exchanged, of those that are there; in a stretch some are only one of both."""
    pairs = pairs_of(document)
    if not pairs:
        raise KinemarkError("There is no pair of a left and a right marker in this trial.")
    ways = [(a, b) for pair in pairs for a, b in (pair, pair[::-1]) if _seen(document, a, said)]
    if not ways:
        raise KinemarkError("No marker of a left and right pair has a sample in these frames.")
    claims = (make.claim(document.editing, a, b, first=said.first, last=said.last) for a, b in ways)
    return tuple(claim for one in claims for claim in one)


def _seen(document: OpenDocument, marker: str, said: m.SidesAct) -> bool:
    """Whether a marker has a sample in the frames of an exchange."""
    now = document.now.trajectories
    frames = np.flatnonzero(now[marker].origin != Origin.MISSING) + now.first_frame
    frames = frames if said.first is None else frames[frames >= said.first]
    return len(frames if said.last is None else frames[frames <= said.last]) > 0


def _of_journal(document: OpenDocument, said: m.UndoAct | m.RedoAct | m.SignAct) -> Edit:
    """Undo, redo and signature."""
    if isinstance(said, m.SignAct):
        return Signed(document.head)
    if isinstance(said, m.UndoAct):
        of = next_undo(document.text) if said.of is None else said.of
        if of is None:
            raise KinemarkError("There is nothing to undo.")
        return Undo(of)
    last = last_undo(document.text.entries)
    if last is None:
        raise KinemarkError("There is nothing to redo: nothing was undone last.")
    return Undo(last.id)


def _join(of: Editing, said: m.Act) -> Join | None:
    """How well a claimed track goes on the marker of that name (KISS 4.3)."""
    if not isinstance(said, m.ClaimAct) or said.name is None:
        return None
    found = of.connection(said.track, said.name)
    if found is None:
        return None
    apart = max(found.gap, 1) / of.trajectories.rate
    return Join(**found._asdict(), speed_mm_s=found.off_mm / apart)
