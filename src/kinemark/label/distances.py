"""Labelling by the distances of markers: the method `distances`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..data import Trajectories
from ..data.array_types import Floats, Ints
from ..data.method import ONE, Method, parameter
from ..numerics.vectors import lengths
from .against import against
from .beside_its_place import beside_their_places
from .calibration import calibrated_shift
from .decided_sides import at_most_even, decided_sides
from .evidence import PairScore
from .held import OWN, held
from .label import refusal, state_of
from .labels import Labels, State
from .margin import (
    BETA_LABEL,
    BETA_OTHER,
    BETA_PIECE,
    BETA_TRACK,
    GAINED,
    GAINED_OTHER,
    Margins,
    label_probability,
    margins,
    track_probability,
)
from .own_images import no_images, own_images
from .parts import KNOWN, placed_share, with_parts
from .recalibration import by_what_is_absent, recalibrated
from .solve import solve, solve_with_facts
from .stage import LABEL
from .stated import anchored, fixed_labels
from .stretches import FREE, Stretches, stretches_of
from .sweeps import places
from .template import Template
from .told_by_one import at_most_tellers

FRAMES = 40
"""In which a subject's size is measured; chosen, as in `held`."""
FEWEST = 8
"""Markers with a name, without which no template is taken for another subject's; chosen."""
NEVER_SURE = 0.98
"""Probability of a name, at most, by the template of another subject that was given as this one's, or by parts alone;
chosen, as by a figure alone."""
BESIDE = 0.75
"""Probability, at most, of a piece that lies beside its marker's place; chosen, above `parts.KNOWN`: of such pieces of
trials with ghosts in a sixth of the gaps one in ten is right, of others none is wrong by a ghost."""
SCALES = (0.8, 1.25)
"""Within which it is taken to lie; chosen: distances of bodies beyond it would have named nothing."""
LEAST_PART = 0.2
"""Share of the samples that a first part of the body must place, for others to be looked for; chosen: sitting, of which
a walk showed nothing, pelvis and trunk place a third."""


@dataclass(frozen=True, slots=True)
class Distances(Method):
    """By distances of pairs and orientation of quadruples: key frames, outwards in time, sweeps and exchanges."""

    key_frames: int = parameter(10, unit="frames", low=1, meaning="frames in which a first labelling is looked for")
    beam: int = parameter(500, unit=ONE, low=1, meaning="states of the search in a key frame that go on")
    least_track_fit: float = parameter(
        0.3,
        unit=ONE,
        low=0,
        below=1,
        meaning="evidence of a track, as a share of what the template expects, below which it has no name",
    )
    least_fit: float = parameter(
        0.55,
        unit=ONE,
        low=0,
        high=1,
        meaning="score of the trial, as a share of the template's on its own data, below which nothing is named",
    )
    least_placed: float = parameter(
        0.5, unit=ONE, low=0, high=1, meaning="share of the samples that could have a name below which nothing is named"
    )
    sure: float = parameter(0.99, unit=ONE, above=0, high=1, meaning="probability from which on a name is sure")


@LABEL.method("distances", Distances)
def label_by_distances(
    trajectories: Trajectories, template: Template, *, method: Distances, stated: Mapping[str, str | None]
) -> Labels:
    """See `label`; where a template proves to be another subject's, names are found as by such, and none is sure."""
    found = _by_body_and_parts(trajectories, template, method, stated)
    settled = found.refused is not None or found.undecided is not None
    ratio = None if settled else _of_another(trajectories, template, found)
    if ratio is None:
        return found
    return replace(
        _never_sure(_by_body_and_parts(trajectories, template.of_another(ratio), method, stated)), another=ratio
    )


def _never_sure(found: Labels) -> Labels:
    """Labels none of which is sure."""
    state: tuple[State, ...] = tuple("unsure" if one == "sure" else one for one in found.state)
    return replace(found, probability=np.minimum(found.probability, NEVER_SURE), state=state)


def _of_another(trajectories: Trajectories, template: Template, found: Labels) -> float | None:
    """How many times as tall the subject is as the template's, where the stiffest distances tell that it is another."""
    if np.any(template.doubt):
        return None
    stretches, pairs = stretches_of(trajectories, template.size), PairScore.of_template(template)
    label = np.where(found.probability >= KNOWN, _numbers(found, template), -1)
    if len(np.unique(label)) < FEWEST or held(stretches, label, pairs, absent_too=False) >= OWN:
        return None
    y = places(stretches, label, len(template))
    y = y[:: max(1, len(y) // FRAMES)]
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = lengths(y[:, :, None] - y[:, None]) / template.distance
    return float(np.clip(np.nanmedian(ratio[np.isfinite(ratio)]), *SCALES))


def _by_body_and_parts(
    trajectories: Trajectories, template: Template, method: Distances, stated: Mapping[str, str | None]
) -> Labels:
    """The whole body, then parts that it left without names; refused where both name too little.

    Without a body that fits, nothing says whether a part is of the left or the right, so that no name of it is sure.
    """

    def name(tracks: Trajectories, by: Template, facts: Mapping[str, str | None]) -> Labels:
        return _of_body(tracks, by, replace(method, least_placed=LEAST_PART), facts)

    body = name(trajectories, template, stated)
    if body.undecided is not None:  # by parts alone nothing would tell the sides either
        return body if body.placed >= method.least_placed else _nothing_named(body, body.placed, 1.0, method)
    found = with_parts(trajectories, body, template, name, stated)
    if found is body:
        return body if body.placed >= method.least_placed else _nothing_named(body, body.placed, 1.0, method)
    placed = placed_share(np.isfinite(trajectories.xyz[..., 0]), found, len(template))
    label, pairs = _numbers(found, template), PairScore.of_template(template)
    holds = held(stretches_of(trajectories, template.size), label, pairs)
    refused = refusal(found.fit, placed, holds, least_fit=method.least_fit, least_placed=method.least_placed)
    if refused is not None:
        return _nothing_named(found, placed, holds, method)
    return replace(found if body.refused is None else _never_sure(found), placed=placed, refused=None)


def _numbers(found: Labels, template: Template) -> Ints:
    """(T) labels by their names, −1 for none."""
    number = {name: a for a, name in enumerate(template.names)}
    return np.array([number.get(str(name), -1) for name in found.names], np.int64)


def _of_body(
    trajectories: Trajectories, template: Template, method: Distances, stated: Mapping[str, str | None]
) -> Labels:
    """By the template as one body."""
    fixed = fixed_labels(trajectories, template, stated)
    stretches = stretches_of(trajectories, template.size, fixed)
    pairs = PairScore.of_template(template)
    found = (solve if (fixed == FREE).all() else solve_with_facts)(
        stretches, template, pairs, key_frames=method.key_frames, beam=method.beam, least_fit=method.least_track_fit
    )  # fmt: skip
    sides = decided_sides(stretches, found.label, template, pairs)
    fit = found.score / max(found.expected, 1e-9) / template.own_fit
    placed = _placed(stretches, sides.label, len(template))
    holds = held(stretches, sides.label, pairs)
    refused = refusal(fit, placed, holds, least_fit=method.least_fit, least_placed=method.least_placed)
    label = np.full(len(stretches), -1) if refused else np.where(fixed == FREE, sides.label, np.maximum(fixed, -1))
    image = no_images(label) if refused or sides.finding else own_images(stretches, label, template, pairs)
    label = image.label
    after = found.after if (label == found.label).all() else None  # learnt with the sides as they were
    about = anchored(margins(stretches, label, template, pairs, after), label, fixed)
    p = probability_of_all(trajectories, template, after or pairs, label, about, stretches.weight, method)
    p = image.share * at_most_even(at_most_tellers(p, stretches, label, template, pairs), sides.undecided)
    second = np.where(image.other >= 0, image.other, about.runner_up)
    p = np.where(beside_their_places(stretches, label, template) & (fixed == FREE), np.minimum(p, BESIDE), p)
    state = tuple(state_of(float(one), method.sure) for one in p)
    return Labels(
        names=_names(label, template),
        probability=p,
        state=state,
        runner_up=_names(second, template),
        margin=about.track,
        fit=fit,
        placed=placed,
        refused=refused,
        against=against(stretches, label, second, template, pairs, [one == "unsure" for one in state]),
        undecided=None if refused else sides.finding or image.finding,
    )


def probability_of_all(
    trajectories: Trajectories,
    template: Template,
    pairs: PairScore,
    label: Ints,
    about: Margins,
    weight: Floats,
    method: Distances,
) -> Floats:
    """(T) by the coefficients of all trials, labels recalibrated, and tracks shifted by what the trial itself shows.

    What a map of labels' probabilities was measured on tells nothing of how sure a piece of a label is.
    """
    another = bool(np.any(template.doubt))
    p = probability_by(about, weight, another=another)
    shift = calibrated_shift(
        trajectories, template, pairs, label, p, sure=method.sure, least_fit=method.least_track_fit,
        nameless=float(np.nan_to_num(about.nameless).max(initial=0.0)), piece=BETA_TRACK if another else BETA_PIECE,
    )  # fmt: skip
    return probability_by(about, weight, another=another, shift=shift)


def probability_by(about: Margins, weight: Floats, *, another: bool, shift: float = 0.0) -> Floats:
    """(T) by the coefficients of all trials, labels recalibrated; 0 for tracks without label.

    Args:
        about: of T tracks. weight: (T) independent frames. another: the template is another subject's.
        shift: of the logits of tracks, by what the trial itself shows.
    """
    beta, gained = (BETA_OTHER, GAINED_OTHER) if another else (BETA_LABEL, GAINED)
    of_label = recalibrated(label_probability(about, label=beta, gained=gained), another=another)
    of_label = of_label if another else by_what_is_absent(of_label, about)
    p = of_label * track_probability(about, weight, shift, BETA_TRACK if another else BETA_PIECE)
    return np.where(np.isfinite(p), p, 0.0)


def _nothing_named(found: Labels, placed: float, holds: float, method: Distances) -> Labels:
    """Labels without any name, as the template does not fit."""
    refused = refusal(found.fit, placed, holds, least_fit=method.least_fit, least_placed=method.least_placed)
    n = len(found)
    none, unknown = (None,) * n, tuple[State, ...]("unknown" for _ in range(n))
    return Labels(none, np.zeros(n), unknown, none, np.full(n, np.nan), found.fit, placed, refused)


def _names(label: Ints, template: Template) -> tuple[str | None, ...]:
    """Names of labels, None for −1."""
    return tuple(template.names[a] if a >= 0 else None for a in label.tolist())


def _placed(stretches: Stretches, label: Ints, L: int) -> float:
    """Of the samples that could have a name, at most L a frame, those that have one."""
    could = np.minimum(stretches.seen.sum(0), L).sum()
    return float(stretches.seen[label >= 0].sum() / max(could, 1))
