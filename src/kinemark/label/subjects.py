"""Several subjects in one volume, each with a template of its own: whose marker each track is.

The subjects are named one after the other, in every order, each among the tracks that those before it left; then each
anew among all that the others are not sure of, as a limb that passes by is another's. Of the orders that is kept whose
sum of scores (`sweeps.total_score`), each by its subject's own template, is greatest. Two subjects whose templates fit
each other's bodies as well, to what two quadruples are worth, cannot be told apart: their names are as likely the other
way round, and are not sure, unless a person stated a marker of either.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from itertools import combinations, permutations
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..data import KinemarkError, Trajectories
from ..data.array_types import Bools, Floats
from ..data.finding import Finding
from .decided_sides import UNDECIDED
from .evidence import PairScore
from .label import label
from .labels import Labels, State
from .stated import with_stated
from .stretches import stretches_of
from .sweeps import total_score
from .template import Template

MOST = 4
"""Subjects; chosen: their orders are all tried."""


class SubjectLabels(NamedTuple):
    """Labels of T tracks whose names have the subject before them, `A:LKNE`.

    Attributes:
        labels: of all subjects together. of: subject → its own labels of all tracks.
        undecided: pairs of subjects that cannot be told apart.
    """

    labels: Labels
    of: Mapping[str, Labels]
    undecided: tuple[tuple[str, str], ...]


class _Facts(NamedTuple):
    """What a person stated.

    Attributes:
        own: subject → track → marker, without the subject before it. others: subject → (T) tracks that are not its.
    """

    own: dict[str, dict[str, str | None]]
    others: dict[str, Bools]

    @classmethod
    def of(cls, tracks: Trajectories, subjects: Mapping[str, Any], stated: Mapping[str, str | None]) -> _Facts:
        """Of statements such as `A:LKNE`; what is stated to be no marker, or of nobody here, is no subject's."""
        own: dict[str, dict[str, str | None]] = {s: {} for s in subjects}
        for track, name in stated.items():
            s, _, bare = (name or "").partition(":")
            if s in own:
                own[s][track] = bare
        return cls(own, {s: np.array([t in stated and t not in own[s] for t in tracks.names], bool) for s in own})


def label_subjects(
    tracks: Trajectories,
    templates: Mapping[str, Template],
    *,
    method: Any = None,
    stated: Mapping[str, str | None] = MappingProxyType({}),
) -> SubjectLabels:
    """Which marker of which subject each track is.

    Args:
        tracks: of a recording with all of them.
        templates: subject → what is known of the subject's markers.
        method: one of `LABEL`.
        stated: track → `A:LKNE` that a person stated, None for no marker; facts by which the others are found.

    Raises:
        KinemarkError: there are no tracks, or no or too many subjects.
    """
    if not 1 <= len(templates) <= MOST:
        raise KinemarkError(f"There are {len(templates)} subjects, wanted 1 to {MOST}. Label the others apart.")
    facts = _Facts.of(tracks, templates, stated)

    @cache  # several orders leave a subject the same tracks
    def among(s: str, taken: frozenset[int]) -> Labels:
        return _among(tracks, taken, templates[s], method, facts.own[s])

    found = [_in_turn(len(tracks), order, among, facts) for order in permutations(templates)]
    best = max(found, key=lambda each: sum(_score(tracks, each[s], templates[s]) for s in templates))
    free = [(a, b) for a, b in combinations(templates, 2) if not any((*facts.own[a].values(), *facts.own[b].values()))]
    undecided = tuple(pair for pair in free if _alike(tracks, best, templates, *pair))
    of = {s: _doubted(one, any(s in pair for pair in undecided)) for s, one in best.items()}
    return SubjectLabels(with_stated(_together(of), tracks, stated), of, undecided)


def _in_turn(
    n: int, order: tuple[str, ...], among: Callable[[str, frozenset[int]], Labels], facts: _Facts
) -> dict[str, Labels]:
    """Each subject among what the others left of n tracks, in this order, then among what they are not sure of."""
    of: dict[str, Labels] = {}
    for s in order:
        of[s] = among(s, _indices(facts.others[s] | _taken(of, ("sure", "unsure"), n)))
    for s in order:
        others = {other: one for other, one in of.items() if other != s}
        of[s] = among(s, _indices(facts.others[s] | _taken(others, ("sure",), n)))
    return of


def _indices(some: Bools) -> frozenset[int]:
    return frozenset(np.flatnonzero(some).tolist())


def _taken(of: Mapping[str, Labels], states: tuple[State, ...], n: int) -> Bools:
    """(T) whether a track is some subject's."""
    return np.array([any(one.state[t] in states for one in of.values()) for t in range(n)], bool)


def _among(
    tracks: Trajectories, taken: frozenset[int], template: Template, method: Any, stated: Mapping[str, str | None]
) -> Labels:
    """Labels of all tracks, from a labelling of those that are free, and of those that were stated to be its own."""
    seen = np.asarray(np.isfinite(tracks.xyz[..., 0]).any(1))
    free = [t for t, name in enumerate(tracks.names) if seen[t] and (t not in taken or name in stated)]
    if not free:
        return _none(len(tracks))
    among = replace(tracks, paths=tuple(tracks.paths[t] for t in free))
    found = label(among, template, method=method, stated=stated)
    where = {t: k for k, t in enumerate(free)}

    def spread(values: Any, blank: Any) -> tuple[Any, ...]:
        return tuple(values[where[t]] if t in where else blank for t in range(len(tracks)))

    return replace(
        found, names=spread(found.names, None), state=spread(found.state, "unknown"),
        runner_up=spread(found.runner_up, None), against=spread(found.against, ()),
        probability=np.array(spread(found.probability, 0.0)), margin=np.array(spread(found.margin, np.nan)),
    )  # fmt: skip


def _none(n: int) -> Labels:
    unknown: State = "unknown"
    return Labels((None,) * n, np.zeros(n), (unknown,) * n, (None,) * n, np.full(n, np.nan), 0.0, 0.0)


def _score(tracks: Trajectories, found: Labels, template: Template) -> float:
    """Nats a frame of a subject's names by its template."""
    number = {name: a for a, name in enumerate(template.names)}
    label_of = np.array([-1 if name is None else number.get(name, -1) for name in found.names])
    return total_score(stretches_of(tracks, template.size), label_of, PairScore.of_template(template))[0]


def _alike(tracks: Trajectories, of: Mapping[str, Labels], templates: Mapping[str, Template], a: str, b: str) -> bool:
    """Whether two subjects' names, exchanged, score as well: only where their sets have names in common."""
    common = set(templates[a].names) & set(templates[b].names)
    if not common:
        return False

    def of_body(body: str, template: str) -> float:
        names = tuple(name if name in common else None for name in of[body].names)
        return _score(tracks, replace(of[body], names=names), templates[template])

    return of_body(a, a) + of_body(b, b) - of_body(a, b) - of_body(b, a) < UNDECIDED


def _doubted(found: Labels, doubted: bool) -> Labels:
    """The same with names as likely as the other subject's."""
    if not doubted:
        return found
    state: tuple[State, ...] = tuple("unsure" if one == "sure" else one for one in found.state)
    return replace(found, probability=0.5 * found.probability, state=state)


def _together(of: Mapping[str, Labels]) -> Labels:
    """All subjects' labels; where two have a track, that of the greater probability."""
    subjects = list(of)
    p: Floats = np.array([of[s].probability for s in subjects])
    best = [subjects[int(k)] for k in p.argmax(0)]
    there = [one for one in of.values() if any(one.names)] or list(of.values())

    def called(s: str, name: str | None) -> str | None:
        return None if name is None else f"{s}:{name}"

    return Labels(
        names=tuple(called(s, of[s].names[t]) for t, s in enumerate(best)),
        probability=p.max(0),
        state=tuple(of[s].state[t] for t, s in enumerate(best)),
        runner_up=tuple(called(s, of[s].runner_up[t]) for t, s in enumerate(best)),
        margin=np.array([of[s].margin[t] for t, s in enumerate(best)]),
        fit=min(one.fit for one in there),
        placed=min(one.placed for one in there),
        refused=_refused(of),
        against=tuple(of[s].against[t] for t, s in enumerate(best)),
        undecided=next((one.undecided for one in of.values() if one.undecided is not None), None),
        displaced=tuple((f"{s}:{name}", mm) for s, one in of.items() for name, mm in one.displaced),
    )


def _refused(of: Mapping[str, Labels]) -> Finding | None:
    """Why nothing is named; None where a subject's template fits."""
    refused = [one.refused for one in of.values()]
    return refused[0] if all(one is not None for one in refused) else None
