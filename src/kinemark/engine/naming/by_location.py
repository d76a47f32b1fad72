"""Naming the markers of a file by where each is on the body: height, side and front."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...data import KinemarkError, Trajectories
from ...io.formats import check_new_trial
from ...io.notes import FileNote, read_notes
from ...io.trial import read_trial, write_trial
from ...label import Labels, label_by_location, named
from ...label.by_location import Located
from ...label.labels import State
from ..put_aside import put_aside, put_back


class LocatedFile(NamedTuple):
    """What was named: the trajectories, a row a track for a machine, the file, and what was odd of the files."""

    trajectories: Trajectories
    figures: dict[str, Any]
    written: Path
    notes: tuple[FileNote, ...]


def label_file_by_location(
    source: Path, target: Path, shown: Path, *, up: str = "z", unsure: bool = False
) -> LocatedFile:
    """Name the markers of a trial by their location on the body, and write it.

    Args:
        source: any file of trajectories; names that it has are not looked at.
        target: the file to write; an existing one is not replaced.
        shown: a labelled trial of the same marker set, of whatever subject.
        up: the axis that points upwards: x, y or z. unsure: also take names that are not sure.

    Raises:
        KinemarkError: a file is absent, damaged or has no samples, the target exists or has an unknown ending, or there
            is no such axis.
    """
    if up not in ("x", "y", "z"):
        raise KinemarkError(f'The axis that points upwards is "{up}"; wanted: x, y or z.')
    check_new_trial(target)
    trial, known = read_trial(source), put_aside(read_trial(shown)).rest
    points = put_aside(trial, keep=set(known.names))
    found = label_by_location(points.rest, known, up=up)
    labels = _labels(found)
    done = put_back(named(points.rest, labels, unsure=unsure), points.aside)
    notes = (*read_notes(trial.notes), *write_trial(replace(trial, trajectories=done), target))
    return LocatedFile(done, _figures(points.rest, labels, known.names), target, notes)


def _labels(found: Sequence[Located]) -> Labels:
    """As of tracks whose names have no probability: 1 where sure, ½ where another is near, 0 without a name."""
    state: list[State] = ["unknown" if one.name is None else "sure" if one.sure else "unsure" for one in found]
    share = {"sure": 1.0, "unsure": 0.5, "unknown": 0.0}
    n, with_name = len(found), sum(one.name is not None for one in found)
    return Labels(
        names=tuple(one.name for one in found),
        probability=np.array([share[one] for one in state]),
        state=tuple(state),
        runner_up=(None,) * n,
        margin=np.full(n, np.nan),
        fit=np.nan,
        placed=with_name / n if n else 0.0,
    )


def _figures(tracks: Trajectories, labels: Labels, names: Sequence[str]) -> dict[str, Any]:
    """For a machine."""
    each = [
        {"track": path.name, "name": name, "state": state}
        for path, name, state in zip(tracks, labels.names, labels.state, strict=True)
    ]
    missing = [name for name in names if name not in {one["name"] for one in each if one["state"] == "sure"}]
    return {"tracks": each, "missing": missing}


def location_text(found: LocatedFile) -> str:
    """The same as lines of text."""
    of = {state: [one for one in found.figures["tracks"] if one["state"] == state] for state in ("sure", "unsure")}
    n = len(found.figures["tracks"])
    lines = [f"sure:     {len(of['sure'])} of {n} tracks, by height, side and front"]
    lines += [f"unsure:   {one['track']}: {one['name']}, or another near it" for one in of["unsure"]]
    lines.append(f"unknown:  {n - len(of['sure']) - len(of['unsure'])} tracks")
    if found.figures["missing"]:
        lines.append(f"missing:  {', '.join(found.figures['missing'])}")
    return "\n".join([*lines, f"results:  {found.written}"])
