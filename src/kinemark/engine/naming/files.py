"""Naming the markers of files of trajectories by what is known of the subject."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...data import KinemarkError, Trajectories
from ...findings.labels import displaced_finding
from ...io.formats import check_new_trial
from ...io.notes import FileNote, read_notes
from ...io.track_names import TrackName
from ...io.trial import read_trial, write_trial
from ...label import Labels, Switch, label_subjects, label_switching, named
from ...label.bystanders import among_bystanders
from ...label.from_set import by_figure_alone
from ...label.stated import with_stated
from ...label.subject_template import SubjectTemplate
from ...report.words import advice_of, text_of
from ..fill_files import own_name
from ..put_aside import PutAside, put_aside, put_back
from .statements import stated_tracks
from .subject_templates import Known, subject_template


class LabelledFile(NamedTuple):
    """What was named.

    Attributes:
        trajectories: named. labels: of the tracks that were there. figures: the same for a machine.
        written: the file. notes: what was odd, and what the target could not hold.
    """

    trajectories: Trajectories
    labels: Labels
    figures: dict[str, Any]
    written: Path
    notes: tuple[FileNote, ...]


def template_of(files: Sequence[Path], known: Known = Known(), *, scale: float | None = None) -> SubjectTemplate:  # noqa: B008  immutable
    """The template of labelled trials, or of what else is known.

    Args:
        files: labelled trials, and templates that were kept. known: what is known beside them.
        scale: the files are of another subject; times as tall is the one who is to be labelled.

    Raises:
        KinemarkError: there is nothing, a file cannot be read, or has too few names.
    """
    if scale is not None and not 0.2 < scale < 5:
        raise KinemarkError(
            f"The scale is {scale:g}. Wanted is the height of this subject over that of the template's."
        )
    found = subject_template(files, known)
    return found if scale is None else replace(found, template=found.template.of_another(scale), wider=None)


def label_file(
    source: Path,
    target: Path,
    template: SubjectTemplate | Mapping[str, SubjectTemplate],
    *,
    method: Any = None,
    unsure: bool = False,
    stated: Sequence[TrackName] = (),
    computed: bool = False,
) -> LabelledFile:
    """Name the markers of a trial and write it; channels, events and parameters stay as they were.

    Args:
        source: any file of trajectories; names that it has are not looked at.
        target: the file to write; an existing one is not replaced.
        template: of the subject; of several by their names, which stand before those of markers, as in `A:LKNE`.
        method: of `label.LABEL`. unsure: also take names that are not sure.
        stated: names that a person states of its tracks; they are facts.
        computed: also name points that look computed of others, which else stay as they are; see `label`.

    Raises:
        KinemarkError: a file is absent, damaged or holds no trajectories, the target exists or has an unknown ending,
            a statement is of no track, or the template does not fit; nothing is written then.
    """
    check_new_trial(target)
    trial = read_trial(source)
    own = {*_names_of(template), *(one.track for one in stated)}
    points = PutAside(trial.trajectories) if computed else put_aside(trial, keep=own)
    tracks, facts = stated_tracks(points.rest, stated)
    if isinstance(template, SubjectTemplate):
        tracks, labels, _, switches = label_switching(tracks, template.template, method=method, stated=facts)
        if template.wider is not None:
            labels = among_bystanders(tracks, labels, template.template, template.wider, method=method, stated=facts)
        by_figure = template.figure_alone
    else:
        each = {name: one.template for name, one in template.items()}
        labels, switches = label_subjects(tracks, each, method=method, stated=facts).labels, ()
        trial = replace(trial, about={**trial.about, "subject": ", ".join(template)})
        by_figure = any(one.figure_alone for one in template.values())
    if labels.refused:
        raise KinemarkError(f"{source} is not labelled. {text_of(labels.refused)} {advice_of(labels.refused)}")
    labels = with_stated(by_figure_alone(labels) if by_figure else labels, tracks, facts)
    done = named(tracks, labels, unsure=unsure)
    done = put_back(done, points.aside)
    notes = (*read_notes(trial.notes), *write_trial(replace(trial, trajectories=done), target))
    figures = _figures(tracks, labels, _names_of(template), by_figure, switches)
    figures["computed"] = [path.name for path in points.aside]
    return LabelledFile(done, labels, figures, target, notes)


def label_files(
    sources: Sequence[Path],
    output: Path,
    template: SubjectTemplate | Mapping[str, SubjectTemplate],
    *,
    announce: Callable[[Path], None] = lambda source: None,
    **options: Any,
) -> dict[Path, LabelledFile | KinemarkError]:
    """Label one trial into a file or folder, or many into a folder under their own names.

    Of many, one that cannot be labelled keeps nobody from the others: its error stands in its place.

    Args:
        sources: files as `label_file` takes them.
        output: a file, or a folder, which is made where it is not there.
        template: of the subject, or of several. announce: called with each trial before it is labelled.
        options: the others of `label_file`.

    Raises:
        KinemarkError: there are many files for one, or the only one cannot be labelled.
    """
    many, into = len(sources) > 1, output.is_dir() or not output.suffix
    if many and not into:
        raise KinemarkError(f"{output} is one file, and there are {len(sources)} trials. Name a folder.")
    done: dict[Path, LabelledFile | KinemarkError] = {}
    for source in sources:
        announce(source)
        try:
            done[source] = label_file(source, output / own_name(source) if into else output, template, **options)
        except KinemarkError as error:
            if not many:
                raise
            done[source] = error
    return done


def _names_of(template: SubjectTemplate | Mapping[str, SubjectTemplate]) -> tuple[str, ...]:
    """All that tracks can be called."""
    if isinstance(template, SubjectTemplate):
        return template.template.names
    return tuple(f"{subject}:{name}" for subject, one in template.items() for name in one.template.names)


def _figures(
    tracks: Trajectories, labels: Labels, names: Sequence[str], by_figure: bool, switches: Sequence[Switch]
) -> dict[str, Any]:
    """For a machine."""
    n = np.isfinite(tracks.xyz[..., 0]).sum(1)
    each = [
        {
            "track": path.name,
            "samples": int(samples),
            "name": name,
            "probability": round(float(p), 4),
            "state": state,
            "runner_up": second,
        }
        for path, samples, name, p, state, second in zip(
            tracks, n, labels.names, labels.probability, labels.state, labels.runner_up, strict=True
        )
    ]
    sure = {one["name"] for one in each if one["state"] == "sure"}
    return {
        "fit": round(labels.fit, 3),
        "placed_share": round(labels.placed, 4),
        "figure_alone": by_figure,
        "undecided": None if labels.undecided is None else labels.undecided.kind,
        "another_subject": None if labels.another is None else round(labels.another, 3),
        "missing": [name for name in names if name not in sure],
        "displaced": [{"name": name, "off_mm": round(mm, 1)} for name, mm in labels.displaced],
        "tracks": each,
        "switches": [
            {"frame": one.frame + tracks.first_frame, "before": one.before, "after": one.after} for one in switches
        ],
    }


def label_text(found: LabelledFile) -> str:
    """The same as lines of text: what is sure in a line, the rest one by one."""
    figures = found.figures
    of = {state: [one for one in figures["tracks"] if one["state"] == state] for state in ("sure", "unsure", "unknown")}
    lines = [
        f"sure:     {len(of['sure'])} of {len(figures['tracks'])} tracks, {len({one['name'] for one in of['sure']})} "
        f"markers; the trial scores {found.labels.fit:.2f} of what the template scores on its own data",
        *(f"          {text}" for text in _why_not_sure(found)),
        *(
            f"unsure:   {one['track']} ({one['samples']} samples): {one['name']}, {100 * one['probability']:.0f} %, "
            f"or {one['runner_up'] or 'no marker'}"
            for one in of["unsure"]
        ),
        f"unknown:  {len(of['unknown'])} tracks",
        *_displaced_lines(figures["displaced"]),
        *(
            f"cut:      a track that is {one['before']}, and {one['after']} from frame {one['frame']} on"
            for one in figures["switches"]
        ),
    ]
    if aside := figures["computed"]:
        lines.append(
            f"aside:    {len(aside)} computed points, such as {', '.join(aside[:3])}, which are no markers and stay as "
            "they are; --computed names them too"
        )
    if figures["missing"]:
        lines.append(f"missing:  {', '.join(figures['missing'])}")
    return "\n".join([*lines, f"results:  {found.written}"])


def _why_not_sure(found: LabelledFile) -> list[str]:
    """What keeps names of the whole trial from being sure, a line each; none where nothing does."""
    labels, lines = found.labels, []
    if found.figures["figure_alone"]:
        lines.append("by the marker set's figure alone, so that no name is sure")
    if labels.another is not None:
        lines.append(
            "its stiffest distances do not hold: the template is of another subject, this one "
            f"{labels.another:.2f} times as tall, or markers were moved, so that no name is sure; "
            "if it is another's, say so: --scale, or --heights-mm"
        )
    if labels.undecided is not None:
        lines.append(f"{text_of(labels.undecided)} {advice_of(labels.undecided)}")
    return lines


def _displaced_lines(displaced: Sequence[Mapping[str, Any]]) -> list[str]:
    """Of markers beside their places; none where there are none."""
    if not displaced:
        return []
    told = displaced_finding(displaced)
    return [f"beside:   {text_of(told)} {advice_of(told)}"]
