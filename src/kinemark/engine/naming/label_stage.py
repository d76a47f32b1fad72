"""The stage `label` of a trial's graph."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...data import Tracks, Trajectories
from ...io.stated_names_csv import StatedName, read_stated_names
from ..sources import Recording
from .earlier import ABSENT, Earlier, template_files_key
from .named_tracks import NamedTracks, load_learnt
from .naming import name_tracks, stated_by_recording
from .templates import session_template, worn


def given_of(of: Recording, earlier: Sequence[Earlier]) -> tuple[Any, ...]:
    """What names depend on besides the tracks: files, marker set and the trials before."""
    label = of.settings.label
    assert label is not None  # else there is no such stage
    before = [(one.name, one.kind, one.key) for one in earlier]
    return template_files_key(of.root, label), worn(of.root, of.settings), before


def name_trial(of: Recording, tracks: Tracks, earlier: Sequence[Earlier], named: Trajectories | None) -> NamedTracks:
    """The tracks of a trial joined to markers.

    Args:
        of: what is recorded. tracks: of it. earlier: the trials before it.
        named: its markers where the recording itself says which is which.

    Raises:
        KinemarkError: a file that the session names is absent or unusable.
    """
    label = of.settings.label
    assert label is not None  # else there is no such stage
    if named is not None:
        return stated_by_recording(tracks, named)
    template = session_template(of.root, of.settings, earlier)
    first = of.frames[0] if of.frames else 1
    return name_tracks(tracks, template, how=label, stated=_stated(of), first_frame=first)


def _stated(of: Recording) -> tuple[StatedName, ...]:
    """What a person said of this trial."""
    label = of.settings.label
    if label is None or label.names is None:
        return ()
    return tuple(one for one in read_stated_names(of.root / label.names) if one.trial == of.entry.name)


def static_of(earlier: Sequence[Earlier]) -> Trajectories | None:
    """The markers of the session's first static trial that has names; None where there is none."""
    for one in earlier:
        if one.kind == "static" and one.key != ABSENT:
            learnt = load_learnt(one.folder)
            if len(learnt):
                return learnt
    return None
