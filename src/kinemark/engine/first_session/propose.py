"""From a folder's files to a proposal: cameras, rate, fields, what calibrates, what is a trial, and what is asked."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ...data import KinemarkError
from ...data.typed import typed
from ...detect.interlacing import FEWEST, interlacing
from ...detect.proposal import propose
from ...io.images import ImageSource, open_images
from ...io.images import natural as natural_path
from ..folders import is_recording
from .calibration_way import completed
from .camera_names import Grouping, best_grouping, grouped
from .folder_files import (
    Facts,
    Stream,
    camera_files,
    facts_of,
    files_below,
    is_picture,
    is_video,
    other_file,
    streams_of,
    tdf_with_rig,
    trial_name,
)
from .labelled_trials import judged_labelled
from .proposal import TRIALS, FoundRecording, Reason, Role, SessionProposal, day_in
from .role_words import role_of

LOOKED_AT = 60
"""Frames of a camera in which fields are looked for; chosen: one or two seconds, in which something moves."""
KEPT = 8
"""Folders whose proposals are kept; chosen: those that somebody goes to and fro between."""
CAMERAS_LOOKED_AT = 3
"""Cameras whose images are decoded for it; chosen: one of them sees the motion."""
First = Literal[False, "top", "bottom"]
"""The field that was taken first."""


def propose_session(folder: Path) -> SessionProposal:
    """What the recordings of a folder propose for its first `session.toml`; nothing is written.

    Images are decoded for it, once as long as no file changes.

    Args:
        folder: with recordings in it or in folders below.

    Raises:
        KinemarkError: it is no folder, or nothing in it is a recording.
    """
    paths = files_below(folder)
    stats = [(folder / path).stat() for path in paths]
    return _proposed(folder, paths, tuple((stat.st_size, stat.st_mtime_ns) for stat in stats))


@lru_cache(maxsize=KEPT)
def _proposed(folder: Path, paths: tuple[str, ...], stamps: tuple[tuple[int, int], ...]) -> SessionProposal:
    """The same for files that are as these stamps say."""
    pictures = [path for path in paths if is_picture(path)]
    found = [one for path in paths if not is_picture(path) and (one := _other(folder, path))]
    found += camera_files(folder, paths)
    if (tdf := tdf_with_rig(folder, paths)) is not None:
        found.append(FoundRecording(tdf, "rig", (), Role.RIG, Reason("holds_rig")))
    grouping, seen = _pictured(folder, pictures)
    names, why = _cameras(grouping, found)
    recordings = tuple(_judged(one, names) for one in _distinct([*seen, *found]))
    if all(one.role is Role.UNUSED for one in recordings):
        raise _nothing(folder, len(paths), recordings)
    recordings = tuple(judged_labelled(folder, recordings))
    proposal = SessionProposal(folder, folder.resolve().name, _date(folder, recordings), names, why)
    return completed(_timed(replace(proposal, recordings=recordings)))


def _nothing(folder: Path, n_files: int, recordings: Sequence[FoundRecording]) -> KinemarkError:
    """The error for a folder that no session can be made of."""
    nameless = [one.path for one in recordings if one.why.kind == "no_camera_in_name"]
    if nameless:
        many = "1 recording" if len(nameless) == 1 else f"{len(nameless)} recordings"
        return KinemarkError(
            f"{folder} has {many}, and nothing says which camera took which: {nameless[0]}. "
            "Name files or folders after the cameras, as cam1, cam2; two of them make a point in space."
        )
    return KinemarkError(
        f"{folder} has no recordings: no videos, images, 2D points or calibration among {n_files} "
        f"{'file' if n_files == 1 else 'files'}. Put the recordings of one day into it, a video or a folder of images "
        "for each camera and trial."
        f"{_without_session(folder)}"
    )


def _without_session(folder: Path) -> str:
    """What to do with trajectories of another system, which need no session."""
    trials = sum(map(is_recording, folder.iterdir()))
    if not trials:
        return ""
    here = typed(folder)
    return (
        f" Its {trials} {'file' if trials == 1 else 'files'} of trajectories {'needs' if trials == 1 else 'need'} no "
        f"session: kinemark audit {here}, kinemark fill {here}, kinemark gait, kinemark studio {here}."
    )


def _other(folder: Path, path: str) -> FoundRecording | None:
    """A file that is no picture; with its path within the folder."""
    one = other_file(folder, path)
    return None if one is None else replace(one, path=path)


def _pictured(folder: Path, pictures: Sequence[str]) -> tuple[Grouping | None, list[FoundRecording]]:
    """Images and videos by cameras: how the cameras are named, and the recordings."""
    known: dict[str, Facts] = {}

    def facts(stream: Stream) -> Facts:
        if stream.path not in known:
            known[stream.path] = facts_of(folder, stream)
        return known[stream.path]

    videos = [path for path in pictures if is_video(path)]
    by_path = {path: Stream(path, (path,)) for path in videos}

    def alike(paths: Sequence[str]) -> bool:
        return len({(facts(by_path[path]).frames, facts(by_path[path]).size) for path in paths}) == 1

    first = best_grouping(videos, alike)
    streams = streams_of(pictures, first.names if first else ())
    by_path |= {stream.path: stream for stream in streams}
    grouping = best_grouping([stream.path for stream in streams], alike) or first
    if grouping is None:
        return None, [_lone(stream, facts(stream)) for stream in streams]
    grouping = grouped([stream.path for stream in streams], grouping.how)
    together = [
        _recording(pattern, {name: by_path[path] for name, path in found.items()}, facts)
        for pattern, found in grouping.patterns.items()
    ]
    return grouping, [*together, *(_lone(by_path[path], facts(by_path[path])) for path in grouping.rest)]


def _recording(pattern: str, streams: Mapping[str, Stream], facts: Callable[[Stream], Facts]) -> FoundRecording:
    """The same of all cameras."""
    known = [facts(stream) for stream in streams.values()]
    forms = {stream.pattern[stream.path.find("#") :] if "#" in stream.path else "" for stream in streams.values()}
    tail = pattern[pattern.find("#") :]
    form = forms.pop() if len(forms) == 1 else tail.replace("#", "*")
    path = pattern[: pattern.find("#")] + form if "#" in pattern else pattern
    role, why = role_of(pattern)
    if role is Role.GRID:
        path = re.sub(r"%(0\d+)?d", "*", path)  # several views of a grid are no sequence in time
    frames = [one.frames for one in known if one.frames is not None]
    damaged = tuple(stream.path for stream, one in zip(streams.values(), known, strict=True) if one.frames is None)
    rates = [one.rate for one in known if one.rate]
    return FoundRecording(
        path, "images", tuple(sorted(streams, key=lambda name: natural_path(Path(name)))), role, why,
        trial_name(pattern), min(frames, default=None), rates[0] if rates else None,
        known[0].size, len(set(frames)) > 1, damaged,
    )  # fmt: skip


def _lone(stream: Stream, facts: Facts) -> FoundRecording:
    """Images of which nothing says what camera took them."""
    return FoundRecording(
        stream.pattern, "images", (), Role.UNUSED, Reason("no_camera_in_name"), "", facts.frames, facts.rate, facts.size
    )


def _cameras(grouping: Grouping | None, found: Sequence[FoundRecording]) -> tuple[tuple[str, ...], Reason]:
    """Names of the cameras: of images, else of 2D points, else of a calibration."""
    if grouping is not None and grouping.names:
        return grouping.names, Reason(f"by_{grouping.how.split()[0]}", {"patterns": len(grouping.patterns)})
    for content in ("detections", "points", "rig"):
        for one in found:
            if one.content == content and one.cameras:
                return one.cameras, Reason("of_file", {"path": one.path})
    return (), Reason("no_cameras")


def _judged(one: FoundRecording, names: tuple[str, ...]) -> FoundRecording:
    """A recording that some cameras lack cannot be used; nor can fewer cameras than two."""
    if one.role is Role.UNUSED or not one.cameras or one.content == "rig":
        return one
    lacking = [name for name in names if name not in one.cameras]
    if not lacking:
        return one
    values = {"cameras": lacking, "has": one.cameras, "role": str(one.role)}
    return replace(one, role=Role.UNUSED, why=Reason("lacks_cameras", values))


def _distinct(recordings: Sequence[FoundRecording]) -> list[FoundRecording]:
    """The same in order of their paths, with names of trials that differ."""
    ordered = sorted(recordings, key=lambda one: natural_path(Path(one.path.replace("/", " "))))
    taken: set[str] = set()
    result = []
    for one in ordered:
        name = one.name or "trial"
        if one.role in TRIALS:
            folder = "_".join(part for part in one.path.split("/")[:-1] if "{camera}" not in part)
            tries = (name, f"{folder}_{name}".strip("_"), *(f"{name}_{k}" for k in range(2, len(ordered) + 3)))
            name = next(t for t in tries if t not in taken)
            taken.add(name)
        result.append(replace(one, name=name))
    return result


def _date(folder: Path, recordings: Sequence[FoundRecording]) -> str:
    """The day that the names say, of the folder or else of all trials alike."""
    of_folder = day_in(folder.resolve().name)
    days = {of_folder} if of_folder else {day_in(one.path) for one in recordings if one.role in TRIALS}
    return days.pop() if len(days) == 1 else ""


def _timed(proposal: SessionProposal) -> SessionProposal:
    """With rate, fields and whether markers are dark, of the trials where there are any."""
    used = [one for one in proposal.recordings if one.role in TRIALS] or [
        one for one in proposal.recordings if one.content in ("images", "detections")
    ]
    filmed = [one for one in used if one.content == "images" and (one.frames or 0) > 2]
    field, field_why = _fields(proposal.folder, proposal.cameras, filmed)
    proposal = replace(proposal, inverted_why=_dark(proposal.folder, proposal.cameras, filmed))
    rated = [one for one in used if one.rate]
    notes = [
        *proposal.notes,
        *(Reason("damaged", {"path": path}) for one in proposal.recordings for path in one.damaged),
    ]
    if not rated:
        return replace(proposal, interlaced=field, interlaced_why=field_why, notes=tuple(notes))
    first = rated[0]
    rate = (first.rate or 0.0) * (2 if field and first.content == "images" else 1)
    others = [one for one in rated[1:] if abs((one.rate or 0) - (first.rate or 0)) > 0.01 * (first.rate or 1)]
    notes += [Reason("another_rate", {"path": one.path, "rate_hz": one.rate}) for one in others]
    why = Reason("of_fields" if field else "of_recording", {"path": first.path, "rate_hz": first.rate})
    return replace(proposal, rate=rate, rate_why=why, interlaced=field, interlaced_why=field_why, notes=tuple(notes))


def _sources(folder: Path, cameras: Sequence[str], recording: FoundRecording) -> list[ImageSource]:
    """What some cameras recorded; without those that cannot be opened."""
    sources = []
    for name in cameras[:CAMERAS_LOOKED_AT]:
        with suppress(KinemarkError):
            sources.append(open_images(folder / recording.path.replace("{camera}", name)))
    return sources


def _dark(folder: Path, cameras: Sequence[str], filmed: Sequence[FoundRecording]) -> Reason | None:
    """Why markers are darker than their ground, where all cameras that are looked at show it."""
    if not filmed:
        return None
    longest = max(filmed, key=lambda one: one.frames or 0)
    said = []
    for source in _sources(folder, cameras, longest):
        with suppress(KinemarkError):
            said.append(propose(source).inverted)
    return Reason("markers_dark", {"path": longest.path}) if said and all(said) else None


def _fields(folder: Path, cameras: Sequence[str], filmed: Sequence[FoundRecording]) -> tuple[First, Reason]:
    """Whether images are two fields, and which came first, by what moves in them."""
    if not filmed or not cameras:
        return False, Reason("no_images")
    longest = max(filmed, key=lambda one: one.frames or 0)
    looked = []
    for source in _sources(folder, cameras, longest):
        with suppress(KinemarkError):
            frames = list(islice(source.frames(), LOOKED_AT))
            if len(frames) > 2:
                looked.append(interlacing(np.stack(frames)))
    said = [one for one in looked if one.first is not None]
    doubting = sum(one.first is None and one.pixels >= FEWEST for one in looked)
    if not said or (doubting > len(said) and all(one.first for one in said)):  # big soft discs are nearly as woven ones
        return False, Reason("nothing_moved", {"path": longest.path, "pixels_wanted": FEWEST})
    surest = max(said, key=lambda one: one.pixels)
    values = {"path": longest.path, "ratio": round(surest.ratio, 2), "first": surest.first}
    first: Any = surest.first or False
    return first, Reason("fields" if surest.first else "whole_frames", values)
