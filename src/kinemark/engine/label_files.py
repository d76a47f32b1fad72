"""Naming the markers of a file of trajectories by labelled trials of the subject, and checking names that are there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..data import KinemarkError, Trajectories
from ..io.formats import endings
from ..io.notes import FileNote, read_notes
from ..io.trial import read_trial, write_trial
from ..label import Exchanged, Labels, Template, find_exchanges, label, learn_template, named
from ..report.words import advice_of, text_of

STATIC_SPREAD = 0.14
"""Share of each distance that a static trial does not show; chosen, see docs/theory/label.md."""


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


def template_of(
    files: Sequence[Path], *, markers: Sequence[str] = (), static: bool = False, scale: float | None = None
) -> Template:
    """The template of labelled trials.

    Args:
        files: of one subject. markers: names to learn; all that do not begin with "*" where there are none. Name them
            where the files also have computed points, such as segments' axes.
        static: they show no motion. scale: of another subject; times as tall is
            the one who is to be labelled.

    Raises:
        KinemarkError: there are none, one cannot be read, or they have too few names.
    """
    if not files:
        raise KinemarkError("There is no template. Give one or more labelled trials of the subject: --template TRIAL.")
    if scale is not None and not 0.2 < scale < 5:
        raise KinemarkError(
            f"The scale is {scale:g}. Wanted is the height of this subject over that of the template's."
        )
    trials = [read_trial(file).trajectories for file in files]
    template = learn_template(*trials, names=tuple(markers) or None, relative_spread=STATIC_SPREAD if static else 0.0)
    return template if scale is None else template.of_another(scale)


def label_file(
    source: Path, target: Path, template: Template, *, method: Any = None, unsure: bool = False
) -> LabelledFile:
    """Name the markers of a trial and write it; channels, events and parameters stay as they were.

    Args:
        source: any file of trajectories; names that it has are not looked at.
        target: the file to write; an existing one is not replaced.
        template: of the subject. method: of `label.LABEL`. unsure: also take names that are not sure.

    Raises:
        KinemarkError: a file is absent, damaged or holds no trajectories, the target exists or has an unknown ending,
            or the template does not fit; nothing is written then.
    """
    if target.exists():
        raise KinemarkError(f"{target} exists, and nothing is overwritten. Name another file or remove it.")
    if target.suffix.lower() not in endings("trajectories"):
        raise KinemarkError(f"{target} wants one of the endings {', '.join(endings('trajectories'))}.")
    trial = read_trial(source)
    labels = label(trial.trajectories, template, method=method)
    if labels.refused:
        raise KinemarkError(f"{source} is not labelled. {text_of(labels.refused)} {advice_of(labels.refused)}")
    done = named(trial.trajectories, labels, unsure=unsure)
    notes = (*read_notes(trial.notes), *write_trial(replace(trial, trajectories=done), target))
    return LabelledFile(done, labels, _figures(trial.trajectories, labels, template), target, notes)


def _figures(tracks: Trajectories, labels: Labels, template: Template) -> dict[str, Any]:
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
        "missing": [name for name in template.names if name not in sure],
        "tracks": each,
    }


def label_text(found: LabelledFile) -> str:
    """The same as lines of text: what is sure in a line, the rest one by one."""
    each = found.figures["tracks"]
    of = {state: [one for one in each if one["state"] == state] for state in ("sure", "unsure", "unknown")}
    names = {one["name"] for one in of["sure"]}
    lines = [
        f"sure:     {len(of['sure'])} of {len(each)} tracks, {len(names)} markers; the trial scores "
        f"{found.labels.fit:.2f} of what the template scores on its own data",
        *(
            f"unsure:   {one['track']} ({one['samples']} samples): {one['name']}, {100 * one['probability']:.0f} %, "
            f"or {one['runner_up'] or 'no marker'}"
            for one in of["unsure"]
        ),
        f"unknown:  {len(of['unknown'])} tracks",
    ]
    if found.figures["missing"]:
        lines.append(f"missing:  {', '.join(found.figures['missing'])}")
    return "\n".join([*lines, f"results:  {found.written}"])


def check_file(source: Path, template: Template) -> tuple[Exchanged, ...]:
    """Where names of a labelled file are exchanged.

    Raises:
        KinemarkError: the file cannot be read, or has too few of the template's names.
    """
    return find_exchanges(read_trial(source).trajectories, template)


def check_text(source: Path, found: Sequence[Exchanged]) -> str:
    """A line for each; frames from 1."""
    if not found:
        return f"{source}: no exchanged names"
    return "\n".join(
        f"{source}: {one.markers[0]} and {one.markers[1]} are exchanged in frames {one.first + 1}–{one.stop}: "
        f"the other way round fits better by {one.gain:.0f} nats a frame"
        for one in found
    )
