"""The record of naming a trial's tracks: tracks joined to markers, what is told of the names, and what others learn."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ...data import Finding, KinemarkError, Tracks, Trajectories
from ...io.files import replacing
from ...io.records import load, save

TRACKS, LABELS, LEARNT = "named.h5", "labels.json", "learnt.h5"
FILES = (TRACKS, LABELS, LEARNT)
"""What the stage leaves: tracks with the identity of markers, their names, and what other trials learn from them."""


class NamedTracks(NamedTuple):
    """Tracks whose identities are markers.

    Attributes:
        tracks: the points of a marker have one identity, whatever pieces the tracker made of it.
        names: of the identities; `*1`, `*2`, … of those without.
        tracker_names: what became of each of the tracker's own tracks; empty where it was taken for no marker.
        figures: for quality.json and the report.
        findings: what is to be said.
        learnt: some frames of the markers, for the template of other trials; none where the names were not accepted.
        learnt_frames: the number of each of these frames in the recording.
    """

    tracks: Tracks
    names: tuple[str, ...]
    tracker_names: tuple[str, ...]
    figures: Mapping[str, Any]
    findings: tuple[Finding, ...]
    learnt: Trajectories
    learnt_frames: tuple[int, ...] = ()


def save_named(path: Path, record: NamedTracks) -> None:
    """Write the tracks and, beside them, the rest."""
    said = {
        "names": record.names,
        "tracker_names": record.tracker_names,
        "figures": record.figures,
        "findings": [one.as_dict() for one in record.findings],
        "learnt_frames": record.learnt_frames,
    }
    with replacing(path.with_name(LABELS)) as beside:
        beside.write_text(json.dumps(said, indent=1, ensure_ascii=False) + "\n", "utf-8")
    save(path.with_name(LEARNT), record.learnt)
    save(path, record.tracks)


def load_named(path: Path) -> NamedTracks:
    """What an earlier run left.

    Raises:
        KinemarkError: a file is damaged.
    """
    try:
        said = json.loads(path.with_name(LABELS).read_text("utf-8"))
        findings = tuple(map(Finding.of, said["findings"]))
        names = tuple(said["names"]), tuple(said["tracker_names"])
        tracks = load(path)
        if not isinstance(tracks, Tracks):
            raise ValueError(f"{path.name} holds no tracks")
        learnt, frames = load_learnt(path.parent), tuple(said.get("learnt_frames", ()))
        return NamedTracks(tracks, *names, said["figures"], findings, learnt, frames)
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise KinemarkError(f"{path.with_name(LABELS)} is damaged: {error}. Delete it.") from error


def load_learnt(folder: Path) -> Trajectories:
    """What others may learn from a trial, by the folder of its results.

    Raises:
        KinemarkError: the file is absent or damaged.
    """
    found = load(folder / LEARNT)
    if not isinstance(found, Trajectories):
        raise KinemarkError(f"{folder / LEARNT} holds {type(found).__name__}, wanted Trajectories. Delete it.")
    return found


def load_learnt_frames(folder: Path) -> tuple[int, ...]:
    """The number in the recording of each frame of `load_learnt`; none where an earlier version did not write them.

    Raises:
        KinemarkError: the file is absent or damaged.
    """
    path = folder / LABELS
    try:
        return tuple(json.loads(path.read_text("utf-8")).get("learnt_frames", ()))
    except (OSError, ValueError) as error:
        raise KinemarkError(f"{path} is damaged: {error}. Delete it.") from error
