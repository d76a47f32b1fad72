"""Templates from a marker set: with a static trial of the subject, or with nothing but the body height.

A static trial shows the distances of one posture. Within a segment they stay, up to the spread that the set states;
all others are uncertain by 18 %. Without any trial the set's figure, scaled by the height, stands for the subject:
markers of a person sit about 2 % of the height from there on each axis, so that a distance is uncertain by 2.8 % of the
height besides.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from ..data import KinemarkError, MarkerSet, MarkerTrajectory, Trajectories
from ..data.array_types import Floats, Ints
from ..data.computed_points import computed_points
from ..data.nearest_word import some_names
from .labels import Labels, State
from .template import LEAST_VOLUME, Template, learn_template, widest, widest_corner

STATIC_SPREAD = 0.18
"""Share of each distance that a static trial does not show; chosen, see docs/theory/label.md."""
SEGMENT_SPREAD = 0.03
"""Share of the distances within a segment whose set does not say how rigid it is; chosen, as skin moves in gait."""
LEAST_SEEN = 0.5
"""Share of a static trial in which a track without a name is a marker of it; chosen: ghosts are seen in less."""
LEAST_ACROSS = 0.3
"""The same as `LEAST_VOLUME`, of the edges from the best of four corners, of quadruples across a joint: 17° out of one
plane; measured on eight subjects, static trial against walk: of 1 217 quadruples above it 0.6 % of the samples turn."""
MOST_BY_FIGURE = 0.8
"""Greatest probability of a name that rests on the figure alone; measured on ten walks of nine subjects of five
laboratories, whole and in pieces: 83 % of such names are right, and where they are wrong, often all are."""
FIGURE_SPREAD = 0.028
"""Share of the height by which distances differ from those of the figure; measured on the static trials of seven
subjects, whose markers differ from it by 0.02 on each axis."""


def static_template(trial: Trajectories, marker_set: MarkerSet) -> Template:
    """The template of a subject by a static trial and the marker set that the subject wears.

    Markers that the set has and the trial does not show are left out, as are those of the static trial alone where
    they would be looked for in vain: ask for `marker_set.moving` when the subject moves.

    Args:
        trial: labelled; a frame is enough.
        marker_set: with segments.

    Raises:
        KinemarkError: fewer than four of the set's markers are in the trial.
    """
    names = [name for name in marker_set.moving if name in trial.names and np.isfinite(trial[name].xyz).any()]
    if len(names) < 4:
        raise KinemarkError(
            f"{len(names)} of the {len(marker_set.moving)} markers of {marker_set.name or 'the marker set'} are in "
            f"the static trial, which has {some_names(trial.names)}. Wanted are four or more, spelt alike."
        )
    return _of_static(trial, marker_set, names, [])


def static_bystanders(trial: Trajectories, marker_set: MarkerSet) -> Template | None:
    """The same with the static trial's tracks that are none of the set as further labels, called as they are there.

    A subject who wears more than the set, named or not, wears it in both trials: what another marker beside a thigh's
    is like tells which of the two is the thigh's. Computed points are none. See `bystanders`. None where there are no
    such tracks.
    """
    names, computed = list(static_template(trial, marker_set).names), computed_points(trial)
    others = [
        path.name
        for path in trial
        if path.name not in {*marker_set.names, *computed} and np.isfinite(path.xyz[:, 0]).mean() > LEAST_SEEN
    ]
    return _of_static(trial, marker_set, names, others) if others else None


def _of_static(trial: Trajectories, marker_set: MarkerSet, names: list[str], others: list[str]) -> Template:
    """Of markers of the set and of others, which are on no segment and in no quadruple.

    Those of the set that are on no segment have the quadruples that they would have without a set.
    """
    segments = segments_of(marker_set, names)
    template = learn_template(trial, names=[*names, *others], relative_spread=STATIC_SPREAD, segments=segments)
    handed, sign = _quadruples(trial, tuple(names), marker_set)
    held = {name for markers in segments.values() for name in markers}
    loose = [a for a, name in enumerate(names) if name not in held]
    more = np.isin(template.handed, loose).any(1) & (template.handed < len(names)).all(1)
    return replace(
        template,
        handed=np.concatenate([handed, template.handed[more]]),
        sign=np.concatenate([sign, template.sign[more]]),
        spread=np.hypot(template.spread, _rigidity(template, marker_set) * template.distance),
    )


def segments_of(marker_set: MarkerSet, names: list[str]) -> dict[str, tuple[str, ...]]:
    """The segments with those of their markers that are among the names, two or more."""
    kept = {key: tuple(name for name in markers if name in names) for key, markers in marker_set.segments.items()}
    return {key: markers for key, markers in kept.items() if len(markers) > 1}


def _rigidity(template: Template, marker_set: MarkerSet) -> Floats:
    """(L, L) share of its distance by which a pair on one segment moves; 0 of all others."""
    out = np.zeros((len(template),) * 2)
    for key, markers in marker_set.segments.items():
        at = [template.names.index(name) for name in markers if name in template.names]
        share = marker_set.rigidity.get(key, SEGMENT_SPREAD)
        out[np.ix_(at, at)] = np.maximum(out[np.ix_(at, at)], share)
    np.fill_diagonal(out, 0.0)
    return out


def _quadruples(trial: Trajectories, names: tuple[str, ...], marker_set: MarkerSet) -> tuple[Ints, Ints]:
    """(Q, 4) quadruples of the static trial that no usual motion turns, and (Q) their signs.

    They are on one segment, or on two that meet and far out of one plane: one posture does not show which of the others
    stay as they are.
    """
    at = {key: [names.index(m) for m in markers if m in names] for key, markers in marker_set.segments.items()}
    alone = {quad for markers in at.values() for quad in combinations(sorted(markers), 4)}
    met = [sorted({*at[a], *at[b]}) for a, b in marker_set.joints.values()]
    across = {quad for markers in met for quad in combinations(markers, 4)} - alone
    xyz = np.stack([np.nanmedian(trial[name].xyz, axis=0) for name in names])[:, None]
    quads = np.array(sorted(alone | across), np.int64).reshape(-1, 4)
    volume = widest_corner(xyz, quads)
    least = np.array([LEAST_VOLUME if tuple(quad) in alone else LEAST_ACROSS for quad in quads.tolist()])
    good = np.flatnonzero(np.abs(volume) > least)
    kept = widest(quads, np.abs(volume), good, len(names))
    return quads[kept].reshape(-1, 4), np.where(volume[kept] > 0, 1, -1).astype(np.int64)


def figure_template(marker_set: MarkerSet, height_mm: float) -> Template:
    """The template of any subject by the set's figure and a body height, with wide spreads.

    Args:
        marker_set: with places of its markers. height_mm: of the subject; of an object, its length.

    Raises:
        KinemarkError: fewer than four markers have places.
        ValueError: the height is not above 0.
    """
    if not 0 < height_mm < np.inf:
        raise ValueError(f"height_mm is {height_mm}, wanted a number above 0")
    placed = [name for name in marker_set.moving if name in marker_set.places]
    if len(placed) < 4:
        raise KinemarkError(
            f"{len(placed)} markers of {marker_set.name or 'the marker set'} have places. Wanted are four or more."
        )
    template = static_template(_figure({name: marker_set.places[name] for name in placed}, height_mm), marker_set)
    return replace(template, doubt=np.hypot(np.asarray(template.doubt), FIGURE_SPREAD * height_mm))


def _figure(places: Mapping[str, tuple[float, float, float]], height_mm: float) -> Trajectories:
    """One who stands as the figure, in one frame."""
    paths = (MarkerTrajectory.measured(n, height_mm * np.array([place])) for n, place in places.items())
    return Trajectories(tuple(paths), 1.0)


def by_figure_alone(labels: Labels) -> Labels:
    """Names that the figure alone gave: none of them is sure, as a body much unlike it is named wrongly as a whole."""
    state: tuple[State, ...] = tuple("unsure" if name is not None else "unknown" for name in labels.names)
    return replace(labels, probability=np.minimum(labels.probability, MOST_BY_FIGURE), state=state)
