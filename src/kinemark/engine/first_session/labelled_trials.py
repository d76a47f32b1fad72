"""Labelled trials and kept templates beside the recordings: which ones a session's markers can be named by.

Of labelled trials the greatest number that agree are taken: that have the same markers, and in which no distance on a
segment is another subject's. One without motion is a static trial, whatever its name, as its distances say nothing of
what a motion changes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...data import KinemarkError, Trajectories
from ...io.c3d import modeled_points
from ...io.trial import read_trial
from ...label import Template, computed_points, learn_template
from ...label.pooled import contradiction
from ...label.template import names_in
from ..naming.template_files import load_template
from ..put_aside import put_aside
from .proposal import FoundRecording, Reason, Role

LEAST = 4
"""Named markers; by definition: a template of fewer has no hand."""
STILL = 0.03
"""Greatest spread of a distance as a share of the template's size, below which a trial shows no motion; chosen: static
trials of eight subjects have 0.0001 to 0.011, their motions 0.12 to 0.23."""
OTHER = 0.12
"""Share of the distances on segments that are off, above which a trial is another subject's; chosen: those of five
children had 0 to 0.08 by their own walks, and 0.17 to 0.73 by others'."""
SHARED = 0.5
"""Of the markers of two trials, those that both must have to be of one marker set; chosen."""


class Shown(NamedTuple):
    """What a labelled trial shows: its file, its markers, what is learnt of them, and whether it moves."""

    path: str
    trial: Trajectories
    template: Template
    still: bool


def judged_labelled(folder: Path, recordings: Sequence[FoundRecording]) -> list[FoundRecording]:
    """The recordings, of which trajectories name the session's markers, or say why they cannot.

    Args:
        folder: that the paths are relative to.
    """
    looked = {one.path: _looked(folder, one) for one in recordings if one.content == "trajectories"}
    shown = [one for one in looked.values() if isinstance(one, Shown)]
    unfit = {path: why for path, why in looked.items() if isinstance(why, Reason)}
    roles: dict[str, Role | Reason] = {**unfit, **_together(shown)}
    return [_with(one, roles.get(one.path)) for one in recordings]


def kept_template(path: Path) -> FoundRecording:
    """A template that was kept in a file.

    Raises:
        KinemarkError: it is none.
    """
    n = len(load_template(path).template)
    return FoundRecording(path.name, "template", (), Role.TEMPLATE, Reason("holds_template", {"markers": n}))


def _looked(folder: Path, one: FoundRecording) -> Shown | Reason:
    """What a file shows, or why nothing can be named by it."""
    try:
        file = read_trial(folder / one.path)
    except KinemarkError as error:
        return Reason("unreadable", {"error": str(error)})
    trial = put_aside(file).rest
    computed = {*computed_points(trial, least_left=0), *modeled_points(file.source)}
    names = [name for name in names_in([trial]) if name not in computed]
    if len(names) < LEAST:
        return Reason("few_names", {"names": len(names), "points": len(file.trajectories)})
    if len({name.partition(":")[0] for name in names if ":" in name}) > 1:
        return Reason("several_subjects")
    try:
        template = learn_template(trial, names=names)
    except KinemarkError as error:
        return Reason("unreadable", {"error": str(error)})
    return Shown(one.path, trial, template, bool(np.nanmax(template.spread) < STILL * template.size))


def _together(shown: Sequence[Shown]) -> Mapping[str, Role | Reason]:
    """By path: what trials are that agree with each other, and why the others are not used."""
    moving = [one for one in shown if not one.still]
    if not moving:
        return _standing(shown)
    against = [[_against(first, other) for other in moving] for first in moving]
    agree = [sum(why is None for why in row) for row in against]
    best = max(range(len(moving)), key=lambda k: (agree[k], len(moving[k].template)))
    rivals = [
        k for k, why in enumerate(against[best]) if why and why.kind == "other_subject" and agree[k] == agree[best]
    ]
    if rivals:
        why = Reason("which_subject", {"path": moving[best].path, "other": moving[rivals[0]].path})
        return {one.path: why for one in shown}
    return {one.path: _against(moving[best], one) or _role(one) for one in shown}


def _standing(shown: Sequence[Shown]) -> Mapping[str, Role | Reason]:
    """The one that shows most markers: without a motion nothing tells whether others are of the same subject."""
    if not shown:
        return {}
    best = max(shown, key=lambda one: len(one.template))
    why = Reason("another_static", {"path": best.path})
    return {one.path: _role(one) if one is best else why for one in shown}


def _role(one: Shown) -> Role:
    return Role.STATIC_TEMPLATE if one.still else Role.TEMPLATE


def _against(first: Shown, other: Shown) -> Reason | None:
    """Why a trial does not show the subject and the marker set of one that moves; None where it does."""
    both = [name for name in first.template.names if name in other.template.names]
    every = {*first.template.names, *other.template.names}
    if len(both) < max(LEAST, SHARED * len(every)):
        return Reason("other_markers", {"path": first.path, "shared": len(both), "markers": len(other.template)})
    said = contradiction(first.template, learn_template(other.trial, names=both), other.trial)
    if said is None or said.pairs_share < OTHER:
        return None
    return Reason("other_subject", {"path": first.path, "percent": round(100 * said.pairs_share)})


def _with(one: FoundRecording, said: Role | Reason | None) -> FoundRecording:
    """A recording with what was found of it; another one as it is."""
    if said is None:
        return one
    if isinstance(said, Reason):
        return replace(one, role=Role.UNUSED, why=said)
    why = Reason("named_and_still" if said is Role.STATIC_TEMPLATE else "named_and_moving")
    return replace(one, role=said, why=why)
