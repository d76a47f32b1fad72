"""The stage `edit`: what people said of a trial, applied to its trajectories. There is one where something was said."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from ...data import Finding, KinemarkError, Rig, Trajectories, Trial
from ...data.edit_outcomes import Applied
from ...data.edits import AddEvent, Edit, Entry, GapChoice, Signed, live
from ...data.events import Events
from ...edit import Edited, Reviewed, cropped, replay
from ...fill import Filled, FilledGap
from ...fill.chosen_gaps import check_choices
from ...findings.edits import edit_figures, edit_findings
from ...io.edits_jsonl import Fault, JournalText, line_of
from ...io.files import replacing
from ...io.records import load, save
from ...track.simultaneous import AmbiguousDecision
from ..graph import Records, Stage
from ..keys import world_key
from ..trial_inputs import detections_of, trial_rig
from .journal import Journal

OUTCOMES = "edits.json"
_APPLIED: TypeAdapter[Any] = TypeAdapter(tuple[Applied, ...])
_REVIEWED: TypeAdapter[Any] = TypeAdapter(tuple[Reviewed, ...])
_FAULTS: TypeAdapter[Any] = TypeAdapter(tuple[Fault, ...])


@dataclass(frozen=True, slots=True, eq=False)
class EditRecord:
    """What the stage leaves: the trial as people said it is, and what is wrong with the journal."""

    edited: Edited
    faults: tuple[Fault, ...] = ()

    @property
    def findings(self) -> Iterator[Finding]:
        """What needs attention."""
        return edit_findings(self.edited.applied, self.faults)

    @property
    def figures(self) -> list[dict[str, Any]]:
        """Each edit and its outcome, as plain data."""
        return edit_figures(self.edited.applied)


def applied_entries(journal: JournalText) -> tuple[Entry, ...]:
    """The entries that replay applies: signatures change nothing."""
    return unsigned(journal.entries)


def unsigned(entries: Sequence[Entry]) -> tuple[Entry, ...]:
    """Of some entries those that count and are no signature."""
    return tuple(e for e in live(entries) if not all(isinstance(edit, Signed) for edit in e.edits))


def edit_stage(
    root: Path, trial: str, rig: Rig, needs: tuple[str, ...], named: Callable[[Any, Records], Trajectories]
) -> list[Stage[Any]]:
    """The stage, in a list that is empty where nobody said anything.

    Args:
        root: of the session. trial: its name. rig: its cameras.
        needs: the stages before it. named: gives the trajectories that they lead to.
    """
    journal = Journal.of(root, trial).read()
    entries = applied_entries(journal)
    if not entries and not journal.faults:
        return []
    given = (world_key(rig), [line_of(entry) for entry in entries], journal.faults)
    compute = partial(_compute, named, entries, journal.faults)
    return [Stage("edit", needs, ("edited.h5", OUTCOMES), compute, _save, _load, given=given)]


def stage_before_edits(stages: Sequence[str]) -> str:
    """The last of these stages that edits are applied to: where names are given, else where tracks are."""
    return next(stage for stage in ("label", "retrack", "track") if stage in stages)


def unreviewed(decisions: Sequence[AmbiguousDecision], edited: Edited) -> tuple[AmbiguousDecision, ...]:
    """The ambiguous decisions on which nobody gave a verdict."""
    return tuple(one for one in decisions if not any(_is_about(verdict, one) for verdict in edited.reviewed))


def _is_about(verdict: Reviewed, decision: AmbiguousDecision) -> bool:
    """Whether a verdict was on this decision: of one kind, about all of its tracks, at its time."""
    same = verdict.decision == decision.kind and {t for t in decision.tracks if t >= 0} <= set(verdict.paths)
    return same and verdict.first <= decision.last and verdict.last >= decision.first


def cropped_fill(filled: Filled, edited: Edited) -> Filled:
    """What is left of a filled trial when it is trimmed and its unnamed tracks are dropped, and of its gaps."""
    left = cropped(filled.trajectories, edited)
    if left is filled.trajectories:
        return filled
    first, stop = edited.kept
    inside = [gap for gap in filled.gaps if gap.marker in left.names and gap.start < stop and gap.stop > first]
    return Filled(left, tuple(_shifted(gap, first, stop) for gap in inside))


def with_edits(trial: Trial, edited: Edited) -> Trial:
    """A whole trial with the events that were added, trimmed, without what is unnamed where that was said."""
    first, stop = edited.kept
    whole = replace(trial, events=with_events(trial.events, edited.events))
    if (first, stop) != (0, trial.trajectories.n_frames):
        whole = whole.frames(first, stop)
    return replace(whole, trajectories=cropped(trial.trajectories, edited))


def with_events(events: Events, added: Sequence[AddEvent]) -> Events:
    """The events with others after them."""
    if not added:
        return events
    return Events(
        (*events.label, *(one.label for one in added)),
        (*events.side, *(one.side for one in added)),
        [*events.time, *(one.time_s for one in added)],  # type: ignore[arg-type]
    )


def check_methods(edits: Sequence[Edit]) -> None:
    """Refuse a choice for a gap that no method answers to.

    Raises:
        KinemarkError: there is one.
    """
    try:
        check_choices([edit.method for edit in edits if isinstance(edit, GapChoice)])
    except ValueError as error:
        raise KinemarkError(f"{error}. What there is: kinemark methods fill.") from error


def _shifted(gap: FilledGap, first: int, stop: int) -> FilledGap:
    """A gap by the frames of a trial that begins at `first`, as far as it lies in it."""
    trimmed, suspicious = (
        tuple(f - first for f in frames if first <= f < stop) for frames in (gap.trimmed, gap.suspicious)
    )
    start, end = max(gap.start, first) - first, min(gap.stop, stop) - first
    return replace(gap, start=start, stop=end, trimmed=trimmed, suspicious=suspicious)


def _compute(
    named: Callable[[Any, Records], Trajectories],
    entries: tuple[Entry, ...],
    faults: tuple[Fault, ...],
    inputs: Any,
    records: Records,
) -> EditRecord:
    """The stage: replay."""
    check_methods([edit for entry in entries for edit in entry.edits])
    cameras, detections = trial_rig(records), detections_of(records)
    edited = replay(
        named(inputs, records), entries, detections=detections, timed=cameras.timed(detections), rig=cameras.rig,
        world=world_key(inputs.rig), left_out=cameras.left_out_of(inputs.source.of.first_frame),
        facts=claims_are_facts(records),
    )  # fmt: skip
    return EditRecord(edited, faults)


def claims_are_facts(records: Records) -> bool:
    """Whether markers are tracked, or named, by what people claim as well: a claim that confirms a name is a fact."""
    return "retrack" in records or "label" in records


def _save(path: Path, record: EditRecord) -> None:
    """The trajectories, and beside them what became of each edit."""
    parts = {
        "applied": json.loads(_APPLIED.dump_json(record.edited.applied)),
        "reviewed": json.loads(_REVIEWED.dump_json(record.edited.reviewed)),
        "faults": json.loads(_FAULTS.dump_json(record.faults)),
    }
    with replacing(path.with_name(OUTCOMES)) as beside:
        beside.write_text(json.dumps(parts, ensure_ascii=False) + "\n", "utf-8")
    save(path, record.edited.trajectories)


def _load(path: Path) -> EditRecord:
    """What an earlier run left; damaged files count as none."""
    beside = path.with_name(OUTCOMES)
    try:
        parts = json.loads(beside.read_text("utf-8"))
        applied, reviewed, faults = (
            kind.validate_json(json.dumps(parts[name]))
            for kind, name in ((_APPLIED, "applied"), (_REVIEWED, "reviewed"), (_FAULTS, "faults"))
        )
    except (OSError, ValueError, KeyError, ValidationError) as error:
        raise KinemarkError(f"{beside} is damaged: {error}. Delete it.") from error
    trajectories = load(path)
    if not isinstance(trajectories, Trajectories):
        raise KinemarkError(f"{path} holds {type(trajectories).__name__}, wanted Trajectories. Delete it.")
    return EditRecord(Edited(trajectories, applied, reviewed), faults)
