"""All of a trial but its samples, for the page."""

from __future__ import annotations

from contextlib import suppress
from functools import lru_cache
from typing import Any

import numpy as np

from ...data import Camera, KinemarkError, MarkerSet, MarkerTrajectory, Rig
from ...data.edits import Signed, counting, is_named, live
from ...data.marker_sides import one_sided, sides_by_name
from ...engine.editing.journal import last_undo
from ...engine.vertical import vertical
from ...fill.methods.stage import FILL
from ...findings.cameras import upwards
from ...io.edits_jsonl import JournalText
from ...version import __version__
from .desk import OpenDocument
from .home import last_of, newer
from .messages import CameraRow, EventRow, Link, MarkerSetRow, Mosaic, TrackRow, TrialHeader, Vector
from .paths import samples
from .shelf import Place

STALE = "Something was said or set since the last run: run the trial so that gaps, report and files follow."


def header(document: OpenDocument, mosaic: Mosaic | None) -> TrialHeader:
    """The header of an open trial."""
    editing, text, trial = document.editing, document.text, document.trial
    trajectories, rig = document.now.trajectories, editing.rig
    start, (low, stop) = trajectories.first_frame, document.now.kept
    tracks = _tracks(document)
    there = _there(tracks)
    return TrialHeader(
        id=document.place.id,
        name=editing.name,
        session=None if trial is None else trial.workspace.settings.name,
        session_id=None if trial is None else Place(trial.workspace.root).id,
        rate=trajectories.rate,
        first_frame=start,
        n_frames=trajectories.n_frames,
        tracks=tracks,
        cameras=[] if rig is None else [camera_row(camera) for camera in rig],
        volume=_volume(rig),
        up=_up(document),
        marker_set=None if document.marker_set is None else _marker_set(document.marker_set),
        pairs=_pairs(document, there),
        one_sided=_one_sided(document, there),
        events=_events(document),
        trim=(low + start, stop - 1 + start),
        named_only=document.now.named_only,
        head=text.head,
        edits=document.said,
        undo=next_undo(text),
        redo=_next_redo(text),
        version=__version__,
        by=editing.by,
        has_images=mosaic is not None,
        has_detections=editing.detections is not None,
        mosaic=mosaic,
        methods=[*FILL],
        last=last_of(text.entries),
        stale=STALE if trial is not None and newer(trial) else "",
    )


def next_undo(text: JournalText) -> int | None:
    """The entry that undo takes back."""
    found = (e.id for e in reversed(live(text.entries)) if not any(isinstance(edit, Signed) for edit in e.edits))
    return next(found, None)


def _next_redo(text: JournalText) -> int | None:
    last = last_undo(text.entries)
    return last.id if last is not None and last in counting(text.entries) else None


def _tracks(document: OpenDocument) -> list[TrackRow]:
    """A row for each trajectory, with what automatic labelling thinks of its name."""
    return [_track(document, path) for path in document.now.trajectories]


def _track(document: OpenDocument, path: MarkerTrajectory) -> TrackRow:
    """Of a trajectory, made once for each record."""
    known = document.blobs.setdefault(id(path), (path, {}))[1]
    if "row" not in known:
        start, (first, last, n) = document.now.trajectories.first_frame, samples(path)
        one = _likely(document).get(path.name, {})
        known["row"] = TrackRow(
            name=path.name,
            named=is_named(path.name),
            first=first + start if n else None,
            last=last + start if n else None,
            samples=n,
            probability=one.get("probability"),
            runner_up=one.get("runner_up"),
            computed=path.name in document.editing.computed,
        )
    found: TrackRow = known["row"]
    return found


def _likely(document: OpenDocument) -> dict[str, dict[str, Any]]:
    """What automatic labelling says of each name."""
    names = document.records["label"].figures["markers"] if "label" in document.records else []
    return {one["name"]: one for one in names}


def pairs_of(document: OpenDocument) -> list[tuple[str, str]]:
    """Left and right markers that are both there: as the marker set pairs them, others as they are called."""
    return _pairs(document, _there(_tracks(document)))


def _pairs(document: OpenDocument, there: tuple[str, ...]) -> list[tuple[str, str]]:
    if document.marker_set is not None:
        of_set = [pair for pair in document.marker_set.pairs if set(there).issuperset(pair)]
        return [*of_set, *_called_alike(_besides(document.marker_set, there))]
    return list(_called_alike(there))


def _one_sided(document: OpenDocument, there: tuple[str, ...]) -> list[str]:
    """Markers of a side of which the other is not there."""
    if document.marker_set is not None:
        of_set = [name for pair in document.marker_set.pairs if len(own := {*pair} & {*there}) == 1 for name in own]
        return [*of_set, *_alone(_besides(document.marker_set, there))]
    return list(_alone(there))


def _besides(marker_set: MarkerSet, there: tuple[str, ...]) -> tuple[str, ...]:
    """Markers that the set does not know."""
    return tuple(name for name in there if name not in marker_set.names)


def _there(rows: list[TrackRow]) -> tuple[str, ...]:
    """Names of the markers that have samples."""
    return tuple(row.name for row in rows if row.samples and row.named and not row.computed)


_called_alike = lru_cache(maxsize=8)(sides_by_name)
_alone = lru_cache(maxsize=8)(one_sided)
"""Worked out once, as the header is made anew at every act."""


def camera_row(camera: Camera) -> CameraRow:
    """A camera as the page projects with it."""
    plain: dict[str, Any] = {name: getattr(camera, name).tolist() for name in ("centre", "R", "t", "K", "distortion")}
    width, height = camera.size.tolist()
    return CameraRow(name=camera.name, width=width, height=height, **plain)


def _volume(rig: Rig | None) -> Any:
    return rig.volume.tolist() if rig is not None and np.isfinite(rig.volume).all() else None


def _up(document: OpenDocument) -> Vector:
    """Of a session as its cameras show; of a file as it says or its markers show, found once."""
    if "up" not in document.kept:
        rig, source = document.editing.rig, document.editing.source
        axis = np.eye(3)[2 if rig is None else upwards(rig)]
        with suppress(KinemarkError):  # along no axis
            axis = axis if source is None or document.trial is not None else vertical(source)[0]
        document.kept["up"] = tuple(axis.tolist())
    found: Vector = document.kept["up"]
    return found


def _marker_set(of: MarkerSet) -> MarkerSetRow:
    links = [
        Link(a=of.names[a], b=of.names[b], length_mm=finite(length), spread_mm=finite(spread))
        for (a, b), length, spread in zip(of.links.tolist(), of.length, of.spread, strict=True)
    ]
    return MarkerSetRow(
        name=of.name,
        names=list(of.names),
        places=dict(of.places),
        faces=dict(of.faces),
        meaning=dict(of.meaning),
        links=links,
    )


def _events(document: OpenDocument) -> list[EventRow]:
    """Those of the file or the recording, and those that were added."""
    source = document.editing.source
    given = [] if source is None else zip(source.events.label, source.events.side, source.events.time, strict=True)
    rows = [EventRow(label=a, side=b, time_s=float(c)) for a, b, c in given]
    return rows + [EventRow(label=e.label, side=e.side, time_s=e.time_s) for e in document.now.events]


def finite(value: Any) -> float | None:
    """A number, None where it is none."""
    return float(value) if value is not None and np.isfinite(value) else None
