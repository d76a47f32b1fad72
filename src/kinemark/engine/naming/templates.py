"""The template that a trial of a session is named by: of what files and earlier trials show of the subject.

What moves goes before what stands still, the subject before another one who is scaled; a template of another, or one
that was kept, is taken as long as the subject's own trials do not show as many markers.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from ...data import MarkerSet, Trajectories
from ...io.marker_sets import marker_sets, read_marker_set
from ...io.trial import read_trial
from ...label import Template, learn_template
from ..label_files import OTHER_SUBJECT, STATIC_SPREAD
from ..settings import Settings
from ..template_files import is_template, load_template
from .earlier import ABSENT, Earlier
from .named_tracks import load_learnt


class SessionTemplate(NamedTuple):
    """A template, and the files and trials that it was learnt from."""

    template: Template
    sources: tuple[str, ...]


class Shown(NamedTuple):
    """Labelled trials, and where they are from."""

    source: str
    trial: Trajectories


def worn(root: Path, settings: Settings) -> MarkerSet | None:
    """The marker set that the session says; None where it says none.

    Raises:
        KinemarkError: there is no such set.
    """
    if settings.marker_set is None:
        return None
    known = settings.marker_set in marker_sets()
    return read_marker_set(settings.marker_set if known else root / settings.marker_set)


def session_template(root: Path, settings: Settings, earlier: Sequence[Earlier]) -> SessionTemplate | None:
    """What is known of the subject when a trial comes to be named; None where nobody says anything.

    Args:
        root: the session's folder. settings: of the session. earlier: the trials before this one.

    Raises:
        KinemarkError: a file is absent or has too few names.
    """
    label, marker_set = settings.label, worn(root, settings)
    if label is None:
        return None
    names = label.markers or (marker_set.moving if marker_set else ())
    files = [file for file in label.template if not is_template(file)]
    given = [Shown(file, read_trial(root / file).trajectories) for file in files]
    seen = [Shown(one.name, load_learnt(one.folder)) for one in earlier if one.key != ABSENT]
    still = [shown for one, shown in zip(_done(earlier), seen, strict=True) if one.kind == "static"]
    moved = [shown for one, shown in zip(_done(earlier), seen, strict=True) if one.kind != "static"]
    still += [Shown(file, read_trial(root / file).trajectories) for file in label.static]
    segments = dict(marker_set.segments) if marker_set else {}
    own = moved if label.scale else given + moved
    found = _learnt(own, names) or _learnt(still, names, spread=STATIC_SPREAD, segments=segments)
    kept = [_kept(root / file) for file in label.template if is_template(file)]
    other = _learnt(given, names) if label.scale else None
    if other is not None and label.scale is not None:
        scaled = other.template.scaled(label.scale, relative_spread=OTHER_SUBJECT)
        kept.append(SessionTemplate(scaled, other.sources))
    best = max(kept, key=lambda one: len(one.template), default=None)
    return best if found is None or (best and len(best.template) > len(found.template)) else found


def _done(earlier: Sequence[Earlier]) -> list[Earlier]:
    return [one for one in earlier if one.key != ABSENT]


def _kept(path: Path) -> SessionTemplate:
    """A template that was kept in a file."""
    return SessionTemplate(load_template(path).template, (path.name,))


def _learnt(
    shown: Sequence[Shown], names: Sequence[str], *, spread: float = 0.0, segments: dict[str, tuple[str, ...]] | None = None
) -> SessionTemplate | None:
    """The template of trials that have names; None where none has."""
    useful = [one for one in shown if any(not name.startswith("*") for name in one.trial.names)]
    if not useful:
        return None
    there = {name for one in useful for name in one.trial.names}
    known = tuple(name for name in names if name in there)
    template = learn_template(
        *(one.trial for one in useful), names=known or None, relative_spread=spread, segments=segments
    )
    return SessionTemplate(template, tuple(one.source for one in useful))
