"""The template that a trial of a session is named by: of what files and earlier trials show of the subject.

What moves goes before what stands still, the subject before another one who is scaled; a template of another, or one
that was kept, is taken as long as the subject's own trials do not show as many markers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from ...data import MarkerSet, Trajectories
from ...data.finding import Finding
from ...io.c3d import prefixes_of
from ...io.marker_sets import marker_sets, read_marker_set
from ...io.trial import read_trial
from ...label import Labelling, Template, learn_template
from ...label.from_set import STATIC_SPREAD, figure_template, static_bystanders, static_template
from ...label.subject_template import SubjectTemplate, TemplateSource
from ...label.template import names_in
from ..put_aside import put_aside
from ..settings import Settings, TrialEntry
from ..settings.tables import GaitTable
from .earlier import ABSENT, NAMED_BY_HAND, Earlier
from .impossible_names import impossible_names
from .labelled_trials import Agreeing, agreeing, set_of_clusters
from .named_tracks import load_learnt, load_learnt_frames
from .subject_templates import of_subject
from .template_files import ENDING, is_template, load_template, save_template
from .usual_segments import set_of_names

TEMPLATE = f"subject{ENDING}"
"""Below a session's results: what its trials show of the subject; `subject-A.template.h5` of one of several."""


class SessionTemplate(NamedTuple):
    """A template, what it was learnt from, `SubjectTemplate.wider`, and what was left out of labelled trials."""

    template: Template
    sources: tuple[str, ...]
    wider: Template | None = None
    findings: tuple[Finding, ...] = ()


class Shown(NamedTuple):
    """A labelled trial, where it is from, and the number in its recording of each frame, where some are left out."""

    source: str
    trial: Trajectories
    frames: tuple[int, ...] = ()


def worn(root: Path, settings: Settings) -> MarkerSet | None:
    """The marker set that the session says; None where it says none.

    Raises:
        KinemarkError: there is no such set.
    """
    if settings.marker_set is None:
        return None
    known = settings.marker_set in marker_sets()
    return read_marker_set(settings.marker_set if known else root / settings.marker_set)


def templates_of_trial(
    root: Path, settings: Settings, earlier: Sequence[Earlier], entry: TrialEntry | None = None
) -> dict[str, SessionTemplate]:
    """Subject → what is known of it when a trial comes to be named; without those of whom nobody says anything.

    The only subject of a session is called "", as nothing stands before its markers' names.

    Args:
        root: the session's folder. settings: of the session. earlier: the trials before this one.
        entry: the trial, which may be of some subjects only; that of all where None.

    Raises:
        KinemarkError: a file is absent or has too few names.
    """
    subjects = settings.subjects_of(entry)
    apart = {s: settings.of_subject(s) for s in subjects} if subjects else {"": settings}
    found = {s: session_template(root, own, earlier, subject=s) for s, own in apart.items()}
    return {s: one for s, one in found.items() if one is not None}


def prefix_of(subject: str) -> str:
    """What stands before the names of a subject's markers; nothing where it is the only one, ""."""
    return f"{subject}:" if subject else ""


def markers_of(trial: Trajectories, subject: str) -> Trajectories:
    """The markers of one of a session's subjects, without what stands before their names."""
    prefix = prefix_of(subject)
    own = [path for path in trial if path.name.startswith(prefix)]
    return replace(trial, paths=tuple(replace(path, name=path.name.removeprefix(prefix)) for path in own))


def session_template(
    root: Path, settings: Settings, earlier: Sequence[Earlier], *, subject: str = ""
) -> SessionTemplate | None:
    """What is known of a subject when a trial comes to be named; None where nobody says anything.

    Args:
        root: the session's folder. settings: of the session, as they are for this subject alone.
        earlier: the trials before this one. subject: one of several; "" for the only one.

    Raises:
        KinemarkError: a file is absent or has too few names.
    """
    label, marker_set = settings.label, worn(root, settings)
    if label is None:
        return None
    names = label.markers or (marker_set.moving if marker_set else ())
    given = [_shown(root, file, subject, names) for file in label.template if not is_template(file)]
    moved, still = _shown_earlier(earlier, subject)
    still += [_shown(root, file, subject, names) for file in label.static]
    moved = moved if label.scale else given + moved
    # Files are asked for enough names; trials in which somebody has begun to name are left alone.
    own = _learnt(moved, names) if _enough(moved, names) or (given and not label.scale) else None
    if own is None and (_enough(still, names) or label.static):
        own = _of_static(still, names, marker_set, settings.gait)
    best = max(_of_others(root, label, given, names, marker_set), key=lambda one: len(one.template), default=None)
    return best if own is None or (best and len(best.template) > len(own.template)) else own


def _shown_earlier(earlier: Sequence[Earlier], subject: str) -> tuple[list[Shown], list[Shown]]:
    """A subject's markers in earlier trials that have names: where they move, and where they stand still."""
    moved, still = list[Shown](), list[Shown]()
    for one in earlier:
        if one.key != ABSENT:
            trial = markers_of(load_learnt(one.folder), subject)
            shown = Shown(one.name, trial, load_learnt_frames(one.folder))
            (still if one.kind == "static" else moved).append(shown)
    return moved, still


def _of_others(
    root: Path, label: Labelling, given: Sequence[Shown], names: Sequence[str], marker_set: MarkerSet | None
) -> list[SessionTemplate]:
    """By what was kept, by another subject who is scaled, and where nothing was given by the set's figure alone."""
    found = [_kept(root / file) for file in label.template if is_template(file)]
    if label.scale is not None and (other := _learnt(given, names)):
        found.append(other._replace(template=other.template.of_another(label.scale), wider=None))
    if marker_set is not None and label.height_mm is not None and not given and not found:
        found.append(SessionTemplate(figure_template(marker_set, label.height_mm), (f"marker set {marker_set.name}",)))
    return found


def _of_static(
    shown: Sequence[Shown], names: Sequence[str], marker_set: MarkerSet | None, gait: GaitTable | None
) -> SessionTemplate | None:
    """Of those who stand still: by the segments of the marker set, else of clusters for gait, else by usual names."""
    useful = _with_names(shown)
    there = [name for name in useful[0].trial.names if not names or name in names] if useful else []
    if marker_set is None and gait is not None and gait.clusters:
        marker_set = set_of_clusters(gait.clusters, there, markers=gait.markers)
    if marker_set is None and len(useful) == 1:
        marker_set = set_of_names(there)
    if not useful or marker_set is None:
        return _learnt(useful, names, spread=STATIC_SPREAD)
    still, sources = useful[0].trial, (useful[0].source, f"marker set {marker_set.name}")
    found = tuple(impossible_names([still], sources[:1]))
    return SessionTemplate(static_template(still, marker_set), sources, static_bystanders(still, marker_set), found)


def _shown(root: Path, file: str, subject: str, names: Sequence[str]) -> Shown:
    """A file of trajectories without computed points that have no such name, of several subjects with this one's."""
    trial = read_trial(root / file)
    points = put_aside(trial, keep=names).rest
    own = of_subject(points, subject, prefixes_of(trial.source)) if subject else points
    return Shown(file, own)


def _kept(path: Path) -> SessionTemplate:
    """A template that was kept in a file."""
    kept = load_template(path)
    return SessionTemplate(kept.template, (path.name,), kept.wider)


def _enough(shown: Sequence[Shown], names: Sequence[str]) -> bool:
    """Whether trials show as many markers, of these names where they have any, as make a template."""
    there = set(names_in([one.trial for one in shown]))
    return len(there & set(names) or there) >= NAMED_BY_HAND


def _with_names(shown: Sequence[Shown]) -> list[Shown]:
    return [one for one in shown if any(not name.startswith("*") for name in one.trial.names)]


def _learnt(shown: Sequence[Shown], names: Sequence[str], *, spread: float = 0.0) -> SessionTemplate | None:
    """The template of trials that have names; None where none has."""
    useful = _with_names(shown)
    if not useful:
        return None
    there = {name for one in useful for name in one.trial.names}
    known = tuple(name for name in names if name in there)
    trials, sources = tuple(one.trial for one in useful), tuple(one.source for one in useful)
    kept = Agreeing(trials) if spread else agreeing(trials, sources, known, [one.frames for one in useful])
    template = learn_template(*kept.trials, names=known or None, relative_spread=spread)
    return SessionTemplate(template, sources, findings=(*kept.findings, *impossible_names(trials, sources)))


def keep_templates(results: Path, settings: Settings, known: Mapping[str, SessionTemplate]) -> None:
    """Write what a session knows of each subject, so that others may be named by it.

    Args:
        results: the folder. settings: of the session. known: of each subject, as `templates_of_trial` has it.

    Raises:
        KinemarkError: the file cannot be written.
    """
    for subject, one in known.items():
        name = f"subject-{subject}{ENDING}" if subject else TEMPLATE
        _keep(results / name, settings.of_subject(subject) if subject else settings, one)


def _keep(path: Path, settings: Settings, known: SessionTemplate) -> None:
    label = settings.label
    height = label.height_mm if label and label.height_mm else float("nan")
    date = settings.date.isoformat() if settings.date else ""
    n = int(known.template.frames.max(initial=0))
    sources = tuple(TemplateSource(source, n, date, "accepted") for source in known.sources)
    save_template(
        path,
        SubjectTemplate(
            known.template, settings.marker_set or "", settings.subject or "", height, sources, known.wider
        ),
    )
