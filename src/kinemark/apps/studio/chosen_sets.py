"""The marker set that a person chose for a file of trajectories: kept beside its journal, in edits/NAME.json.

A session says it in its session.toml; a file has no place for it.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from ...data import KinemarkError, MarkerSet
from ...engine.editing.editing import Editing
from ...engine.naming.marker_set_files import set_by_names
from ...engine.session_name import FILE
from ...io.files import read_json, write_json
from ...io.marker_sets import marker_sets, read_marker_set

CHOSEN = "marker_set"


def known_sets(folder: Path) -> dict[str, MarkerSet]:
    """Those that come with Kinemark, and the files of a folder, by what session.toml calls them."""
    found = {name: read_marker_set(name) for name in marker_sets()}
    for file in sorted(folder.glob("*.toml")):
        if file.name != FILE and not file.is_symlink():
            try:
                found[file.name] = read_marker_set(file)
            except KinemarkError:  # it is another kind of file
                continue
    return found


def set_of_file(editing: Editing, folder: Path, names: Collection[str]) -> MarkerSet | None:
    """The one that was chosen, none where that was chosen or its file is gone; else what the markers' names show."""
    said = read_json(_kept(editing))
    if CHOSEN not in said:
        return set_by_names(names)
    name = said[CHOSEN]
    return known_sets(folder).get(name) if isinstance(name, str) else None


def keep_choice(editing: Editing, name: str | None) -> None:
    """Write which one was chosen, or that none is; raises KinemarkError where it cannot be written."""
    write_json(_kept(editing), {CHOSEN: name})


def _kept(editing: Editing) -> Path:
    return editing.journal.path.with_suffix(".json")
