"""The template of a subject from what there is: kept templates, labelled and static trials, other subjects, a set."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ...data import KinemarkError, MarkerSet, Trajectories, Trial
from ...data.edits import is_named
from ...data.marker_sides import without_subject
from ...data.nearest_word import some_names
from ...io.c3d import prefixes_of
from ...io.trial import read_trial
from ...label import Template, learn_template
from ...label.from_set import STATIC_SPREAD, figure_template, static_bystanders, static_template
from ...label.pooled import contradiction, pooled, template_of_subjects
from ...label.subject_template import SubjectTemplate, TemplateSource
from ...report.words import advice_of, text_of
from ..put_aside import computed_in, put_aside
from .impossible_names import impossible_names
from .labelled_trials import agreeing, set_of_clusters
from .template_files import is_template, load_template
from .usual_segments import set_of_names

LEAST_MM, MOST_MM = 100.0, 5000.0
"""Heights that a subject may have, mm; chosen: what is smaller was given in metres or centimetres."""


class Known(NamedTuple):
    """What is known of a subject beside files.

    Attributes:
        marker_set: that the subject wears; None where it is not known.
        markers: names to learn; all where none is given.
        static: the trials show no motion. subject: name.
        height_mm: of the subject, mm; None where it is not known.
        heights_mm: of the others whose files are given, mm, in their order; none where the files are of the subject.
        computed: where all names are learnt, also those of points that look computed of others.
        clusters: markers by the segment that they sit on, as `[gait.clusters]` has them, in place of a marker set.
        to_name: trials that are to be named: points that these show to be computed are no markers of a static trial,
            in which nothing moves that would tell them.
        say: called with what is left out of labelled trials, and why.
    """

    marker_set: MarkerSet | None = None
    markers: tuple[str, ...] = ()
    static: bool = False
    subject: str = ""
    height_mm: float | None = None
    heights_mm: tuple[float, ...] = ()
    computed: bool = False
    clusters: Mapping[str, tuple[str, ...]] = MappingProxyType({})
    to_name: tuple[Path, ...] = ()
    say: Callable[[str], None] = lambda text: None


def subject_template(files: Sequence[Path], known: Known) -> SubjectTemplate:
    """The template of a subject.

    Args:
        files: templates that were kept, and labelled trials; of the subject, or of others with their heights.
        known: what else is known; a marker set and a height alone give a template of wide spreads.

    Raises:
        KinemarkError: nothing is given, a file cannot be read or has too few names, a height is none, or a trial
            contradicts a template.
    """
    _check_heights(known, len(files))
    _check_clusters(files, known)
    if not files:
        return _by_set(known)
    if known.heights_mm:
        return _by_others(files, known)
    kept = [load_template(file) for file in files if is_template(file)]
    trials = [file for file in files if not is_template(file)]
    if not kept:
        return _by_trials(trials, known)
    if len(kept) > 1:
        raise KinemarkError(
            f"There are {len(kept)} templates of one subject. Give one, or the height of each subject (--heights-mm)."
        )
    found = _named(kept[0], known)
    for file in trials:
        found = with_trial(found, file, say=known.say)
    return found


def _check_heights(known: Known, n_files: int) -> None:
    for height in (*known.heights_mm, *([] if known.height_mm is None else [known.height_mm])):
        if not LEAST_MM <= height <= MOST_MM:
            raise KinemarkError(f"The height {height:g} mm is none of a subject. Heights are in mm: 1.32 m is 1320.")
    if known.heights_mm and (len(known.heights_mm) != n_files or known.height_mm is None):
        raise KinemarkError(
            f"There are {len(known.heights_mm)} heights of others and {n_files} files"
            f"{'' if known.height_mm else ', and no height of the subject'}. Give --heights-mm one for each file, and "
            "--height-mm of the one who is to be labelled."
        )


def _check_clusters(files: Sequence[Path], known: Known) -> None:
    trials = [file for file in files if not is_template(file)]
    unread = not trials or (len(trials) < len(files) and not known.heights_mm)
    if known.clusters and (known.marker_set is not None or not known.static or known.markers or unread):
        raise KinemarkError(
            "Clusters tell which markers of a static trial keep their distances, where no marker set does: give "
            "--cluster with a static trial and --static, and neither --marker-set nor --markers, nor a template that "
            "was kept, which knows it already."
        )


def _by_set(known: Known) -> SubjectTemplate:
    """By the set's figure and the height."""
    if known.marker_set is None:
        raise KinemarkError(
            "There is no template. Give one or more labelled trials of the subject, or a template that was kept: "
            "--template FILE; or a marker set and the height: --marker-set NAME --height-mm 1700."
        )
    if known.height_mm is None:
        raise KinemarkError(
            f"There is no trial of the subject. By the marker set {known.marker_set.name} alone markers are named with "
            "the subject's height: --height-mm 1700; better with a labelled trial: --template TRIAL."
        )
    source = TemplateSource(known.marker_set.name, 0, _today(), "marker set")
    return _named(SubjectTemplate(figure_template(known.marker_set, known.height_mm), sources=(source,)), known)


def _by_others(files: Sequence[Path], known: Known) -> SubjectTemplate:
    """By other subjects, scaled."""
    assert known.height_mm is not None
    others = [
        load_template(file) if is_template(file) else _by_trials([file], known._replace(heights_mm=()))
        for file in files
    ]
    template = template_of_subjects([one.template for one in others], known.heights_mm, known.height_mm)
    frames = [sum(source.frames for source in one.sources) for one in others]
    sources = tuple(
        TemplateSource(file.name, n, _today(), "other subject") for file, n in zip(files, frames, strict=True)
    )
    return _named(SubjectTemplate(template, sources=sources), known)


def _by_trials(files: Sequence[Path], known: Known) -> SubjectTemplate:
    """By labelled trials of the subject."""
    read = [read_trial(file) for file in files]
    points = [trial.trajectories if known.computed else _markers_of(trial, known) for trial in read]
    own = [of_subject(one, known.subject, prefixes_of(trial.source)) for one, trial in zip(points, read, strict=True)]
    trials = [without_prefix(trial, _wanted(known)) for trial in own]
    for said in impossible_names(trials, [file.name for file in files]):
        known.say(f"{text_of(said)} {advice_of(said)}")
    known = _with_set(trials[0], known) if known.static else known
    trials = trials if known.static else _agreeing(trials, files, known)
    kind = "static" if known.static else "labelled"
    sources = tuple(
        TemplateSource(file.name, trial.n_frames, _today(), kind) for file, trial in zip(files, trials, strict=True)
    )
    return _named(SubjectTemplate(_learnt(trials, known), sources=sources, wider=_wider(trials, known)), known)


def _agreeing(trials: Sequence[Trajectories], files: Sequence[Path], known: Known) -> list[Trajectories]:
    """Without samples whose names contradict the rest of these trials, of which it is told."""
    kept = agreeing(trials, [file.name for file in files], _wanted(known))
    for said in kept.findings:
        known.say(f"{text_of(said)} {advice_of(said)}")
    return list(kept.trials)


def _markers_of(trial: Trial, known: Known) -> Trajectories:
    """Without computed points, also those that only the trials to be named show to be such."""
    wanted = _wanted(known)
    rest = put_aside(trial, keep=wanted).rest
    elsewhere = computed_in(known.to_name) if known.static else frozenset()
    own = [name for name in rest.names if name not in elsewhere or name.rpartition(":")[2] in wanted]
    return rest.select(own) if own else rest


def _with_set(static: Trajectories, known: Known) -> Known:
    """What is known, with a marker set by clusters or by usual names, where none was given and no names were."""
    if known.clusters:
        return _by_clusters(static, known)
    return known if known.marker_set or known.markers else known._replace(marker_set=set_of_names(static.names))


def _by_clusters(static: Trajectories, known: Known) -> Known:
    """What is known, with a marker set of all that the static trial shows, by its clusters."""
    markers = [name for own in known.clusters.values() for name in own]
    shown = {*static.names, *map(without_subject, static.names)}
    worn = set_of_clusters(known.clusters, static.names)
    if worn is None:
        raise KinemarkError(
            f"The static trial shows no cluster as a whole, of {', '.join(markers)}: it has "
            f"{some_names(sorted(static.names))}."
        )
    if absent := [name for name in markers if name not in shown]:
        raise KinemarkError(
            f"The static trial has no {', '.join(absent)}, of --cluster: it has {some_names(sorted(static.names))}. "
            "Name the markers as the file does, or leave out those that it lacks."
        )
    return known._replace(marker_set=worn)


def _wider(trials: Sequence[Trajectories], known: Known) -> Template | None:
    """With the markers of a single static trial that nobody named."""
    if not known.static or known.marker_set is None or known.markers or len(trials) > 1:
        return None
    return static_bystanders(trials[0], known.marker_set)


def _wanted(known: Known) -> tuple[str, ...]:
    return known.markers or (known.marker_set.names if known.marker_set else ())


def _learnt(trials: Sequence[Trajectories], known: Known) -> Template:
    if known.static and known.marker_set is not None and not known.markers:
        found = static_template(trials[0], known.marker_set)
        for trial in trials[1:]:
            new = learn_template(trial, names=[name for name in found.names if name in trial.names])
            found = pooled(found, new, trial)
        return found
    there = {name for trial in trials for name in trial.names}
    names = tuple(name for name in _wanted(known) if name in there or name in known.markers)
    if known.marker_set is not None and not known.markers and len(names) < 4:
        raise KinemarkError(
            f"{len(names)} of the {len(known.marker_set)} markers of {known.marker_set.name or 'the marker set'} are "
            f"in the trial, which has {some_names(sorted(there))}. Wanted are four or more, spelt alike."
        )
    if known.computed and not names:
        names = tuple(sorted(name for name in there if not name.startswith("*")))
    return learn_template(*trials, names=names or None, relative_spread=STATIC_SPREAD if known.static else 0.0)


def of_subject(trial: Trajectories, subject: str, prefixes: Mapping[str, str]) -> Trajectories:
    """The markers of one of several subjects, by what stands before their names; all where that is before none.

    Where one other name stands before all of them, as a laboratory's program calls the subject, it is left out.

    Args:
        subject: name of it. prefixes: subject → what stands there, as the file says it; `A:` for A where it does not.
    """
    prefix = before_all(trial) or prefixes.get(subject, f"{subject}:")
    own = [path for path in trial if subject and path.name.startswith(prefix) and path.name != prefix]
    return replace(trial, paths=tuple(replace(p, name=p.name.removeprefix(prefix)) for p in own)) if own else trial


def before_all(trial: Trajectories) -> str:
    """A subject's name and the colon after it, where the same stands before all named markers; else nothing."""
    before = {colon and head + colon for head, colon, _ in (p.name.rpartition(":") for p in trial if is_named(p.name))}
    return before.pop() if len(before) == 1 else ""


def templates_of_subjects(said: Sequence[str], known: Known) -> dict[str, SubjectTemplate]:
    """Subject → template, of statements such as `A=anna.template.h5` or `B=walk01.c3d`.

    Args:
        said: one each. known: what is known of all of them, besides.

    Raises:
        KinemarkError: one is no such statement, a subject is named twice, or a file cannot be read.
    """
    found: dict[str, SubjectTemplate] = {}
    for one in said:
        subject, equals, file = one.partition("=")
        if not equals or not subject or not file or ":" in subject or subject in found:
            raise KinemarkError(
                f"{one!r} is no subject with a template. Give each subject a name of its own without a colon, and a "
                "template or labelled trial: --subject A=anna.template.h5 --subject B=ben.c3d."
            )
        found[subject] = subject_template([Path(file)], known._replace(subject=subject))
    return found


def without_prefix(trial: Trajectories, wanted: Sequence[str]) -> Trajectories:
    """The trial with names as the set has them, where a subject's name stands before all of them, as in `Anna:LASI`."""
    if not wanted or set(wanted) & set(trial.names):
        return trial
    bare = {path.name: path.name.rpartition(":")[2] for path in trial}
    if len(set(bare.values())) < len(bare) or not set(wanted) & set(bare.values()):
        return trial
    return replace(trial, paths=tuple(replace(path, name=bare[path.name]) for path in trial))


def _named(found: SubjectTemplate, known: Known) -> SubjectTemplate:
    """With what else is known."""
    height = known.height_mm if known.height_mm is not None else found.height_mm
    worn = known.marker_set.name if known.marker_set is not None else found.marker_set
    return replace(found, subject=known.subject or found.subject, height_mm=height, marker_set=worn)


def _today() -> str:
    return datetime.datetime.now(datetime.UTC).date().isoformat()


def with_trial(own: SubjectTemplate, file: Path, *, say: Callable[[str], None] = lambda text: None) -> SubjectTemplate:
    """A template with a labelled trial added, whose names are all taken for right that do not contradict each other.

    Args:
        own: template. file: labelled trial. say: called with what is left out of it, and why.

    Raises:
        KinemarkError: the file cannot be read, shares fewer than four names, or contradicts the template.
    """
    trial = without_prefix(read_trial(file).trajectories, own.template.names)
    names = [n for n in own.template.names if n in trial.names and np.isfinite(trial[n].xyz).any()]
    if len(names) < 4:
        raise KinemarkError(f"{file} has {len(names)} of the template's markers. Wanted are four or more, spelt alike.")
    (trial,) = _agreeing([trial], [file], Known(markers=tuple(names), say=say))
    new = learn_template(trial, names=names)
    found = contradiction(own.template, new, trial)
    if found is not None:
        said = found.finding
        raise KinemarkError(f"{file} is not added. {text_of(said)} {advice_of(said)}")
    source = TemplateSource(file.name, trial.n_frames, _today())
    return replace(own, template=pooled(own.template, new, trial), sources=(*own.sources, source), wider=None)


def template_figures(of: SubjectTemplate) -> dict[str, Any]:
    """What a template holds, for a machine."""
    return {
        "subject": of.subject or None,
        "marker_set": of.marker_set or None,
        "height_mm": None if np.isnan(of.height_mm) else of.height_mm,
        "markers": list(of.template.names),
        "size_mm": round(of.template.size, 1),
        "quadruples": len(of.template.handed),
        "figure_alone": of.figure_alone,
        "sources": [{"file": s.file, "kind": s.kind, "frames": s.frames, "date": s.date} for s in of.sources],
    }


def template_text(of: SubjectTemplate) -> str:
    """The same as lines of text."""
    figures = template_figures(of)
    said = [f"{key}: {figures[key]}" for key in ("subject", "marker_set", "height_mm") if figures[key] is not None]
    lines = [f"template of {len(of.template)} markers, {of.template.size:.0f} mm across", *said]
    lines += [", ".join(of.template.names), "learnt from:"]
    lines += [f"  {s.file}: {s.kind}{f', {s.frames} frames' if s.frames else ''}, {s.date}" for s in of.sources]
    return "\n".join(lines)
