"""The marker set that the subject of an open trial wears: which may be, and another one chosen on the page."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from ...data import KinemarkError, MarkerSet
from ...engine.session_changes import change_session
from ...engine.session_name import FILE
from ...io.marker_sets import marker_sets, read_marker_set
from .desk import Desk, OpenDocument
from .edit_messages import MarkerSetChoice
from .shelf import NotThere


def set_choices(document: OpenDocument) -> list[MarkerSetChoice]:
    """All that may be chosen, with how many of their markers the trial has by name."""
    there = set(document.now.trajectories.names)
    return [
        MarkerSetChoice(
            name=name, markers=len(one), there=len(there & {*one.names}), description=one.description,
            worn=document.marker_set is not None and document.marker_set.names == one.names,
        )
        for name, one in _known(document).items()
    ]  # fmt: skip


def choose_set(desk: Desk, document: OpenDocument, name: str | None) -> None:
    """State a marker set, or none: of a session in its session.toml, of a file as long as the studio runs.

    Raises:
        NotThere: there is no such set.
        KinemarkError: the session says it for each of several subjects, or cannot be written.
    """
    known = _known(document)
    if name is not None and name not in known:
        raise NotThere(f"There is no marker set {name!r}. There are {', '.join(known)}.")
    if document.trial is None:
        desk.wear(document, None if name is None else known[name])
        return
    if document.trial.workspace.settings.label_subjects:
        raise KinemarkError(
            "Each subject has a marker set of its own: state it under [label.subjects] in session.toml."
        )
    change_session(document.place.path, {("marker_set",): name})
    desk.forget_session(document.place)


def _known(document: OpenDocument) -> dict[str, MarkerSet]:
    """Those that come with Kinemark, and the files beside session.toml, by what session.toml calls them."""
    found = {name: read_marker_set(name) for name in marker_sets()}
    for file in sorted(_own_files(document)):
        with suppress(KinemarkError):  # it is another kind of file
            found[file.name] = read_marker_set(file)
    return found


def _own_files(document: OpenDocument) -> list[Path]:
    if document.trial is None:
        return []
    return [file for file in document.place.path.glob("*.toml") if file.name != FILE and not file.is_symlink()]
