"""The marker set that the subject of an open trial wears: which may be, and another one chosen on the page."""

from __future__ import annotations

from contextlib import suppress

from ...data import KinemarkError, MarkerSet
from ...engine.session_changes import change_session
from .chosen_sets import keep_choice, known_sets
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
    """State a marker set, or none: of a session in its session.toml, of a file beside its journal.

    Raises:
        NotThere: there is no such set.
        KinemarkError: the session says it for each of several subjects, or cannot be written.
    """
    known = _known(document)
    if name is not None and name not in known:
        raise NotThere(f"There is no marker set {name!r}. There are {', '.join(known)}.")
    if document.trial is None:
        with suppress(KinemarkError):  # nobody may write there: it is worn while the file lies open
            keep_choice(document.editing, name)
        document.marker_set = None if name is None else known[name]
        return
    if document.trial.workspace.settings.label_subjects:
        raise KinemarkError(
            "Each subject has a marker set of its own: state it under [label.subjects] in session.toml."
        )
    change_session(document.place.path, {("marker_set",): name})
    desk.forget_session(document.place)


def _known(document: OpenDocument) -> dict[str, MarkerSet]:
    """All that may be chosen, the files beside session.toml or beside the file among them."""
    path = document.place.path
    return known_sets(path.parent if document.trial is None else path)
