"""What labelled trials show of a subject: without names that contradict the rest, and which markers sit on one segment.

A static trial alone does not tell which distances keep. A session that has clusters has said it: each cluster keeps its
shape, and so do, to skin, the landmarks of its segment, which the walks may lack.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...data import MarkerSet, Trajectories, make_finding
from ...data.edits import is_named
from ...data.finding import Finding
from ...data.marker_sides import without_subject
from ...data.model_markers import model_names
from ...gait.clusters import SEGMENTS, landmarks_of
from ...label import Exchanged
from ...label.own_exchanges import find_own_exchanges, without_exchanged

FEW = 0.1
"""Share of the samples of two markers up to which those that contradict the others are taken for the wrong ones;
chosen: which part is right nobody says, and names by the wrong one would be surely wrong."""


class Agreeing(NamedTuple):
    """Trials whose names agree, and what was left out of them."""

    trials: tuple[Trajectories, ...]
    findings: tuple[Finding, ...] = ()


def agreeing(
    trials: Sequence[Trajectories],
    sources: Sequence[str],
    names: Sequence[str] = (),
    frames: Sequence[Sequence[int]] = (),
) -> Agreeing:
    """Trials of one subject without the stretches in which two markers carry each other's names.

    Where these are more than `FEW` of what there is of the two, neither is learnt.

    Args:
        trials: labelled. sources: what each is called. names: that are learnt; all where none is given.
        frames: of each trial the number in its recording of each frame; where it has none, they follow its first.
    """
    own = [one.select([name for name in one.names if is_named(name) and name in (names or [name])]) for one in trials]
    exchanged = find_own_exchanges(*own)
    twos = {frozenset(one.markers) for found in exchanged for one in found}
    both = {name for two in twos if _share(two, trials, exchanged) > FEW for name in two}
    kept = (without_exchanged(one, found) for one, found in zip(trials, exchanged, strict=True))
    numbers = [
        known or range(one.first_frame, one.first_frame + one.n_frames)
        for one, known in zip(trials, frames or ((),) * len(trials), strict=True)
    ]
    findings = (
        make_finding(
            "template_names_exchanged", markers=one.markers, file=source, first=number[one.first],
            last=number[one.stop - 1], learnt=not both & set(one.markers),
        )
        for source, number, found in zip(sources, numbers, exchanged, strict=True)
        for one in found
    )  # fmt: skip
    return Agreeing(tuple(_without(one, both) for one in kept), tuple(findings))


def _share(two: frozenset[str], trials: Sequence[Trajectories], exchanged: Sequence[Sequence[Exchanged]]) -> float:
    """Of the samples of two markers, those that are exchanged."""
    n = wrong = 0
    for trial, found in zip(trials, exchanged, strict=True):
        seen = np.isfinite([trial[name].xyz[:, 0] for name in sorted(two) if name in trial.names]).sum(0)
        n += int(np.sum(seen))
        wrong += sum(int(np.sum(seen[one.first : one.stop])) for one in found if set(one.markers) == two)
    return wrong / max(n, 1)


def _without(trial: Trajectories, names: set[str]) -> Trajectories:
    """Without these markers, if there are any."""
    return replace(trial, paths=tuple(path for path in trial if path.name not in names)) if names else trial


RIGIDITY = 0.03
"""Standard deviation of the distances on a segment, as a share of each; chosen: thigh's and shank's of the shipped
sets."""


def set_of_clusters(
    clusters: Mapping[str, Sequence[str]], shown: Sequence[str], *, markers: Mapping[str, str] | None = None
) -> MarkerSet | None:
    """All markers of a static trial, those of a segment together; None where the trial shows no cluster.

    Args:
        clusters: markers by segment, one of `gait.clusters.SEGMENTS`, with the subject's name or without it.
        shown: names in the static trial.
        markers: the recording's names by the gait model's, of those that `model_names` does not know.
    """
    named = [name for name in shown if not name.startswith("*")]
    full = {without_subject(name): name for name in reversed(named)} | {name: name for name in named}
    if not any(full.keys() >= set(cluster) for cluster in clusters.values()):
        return None
    own = {**model_names(named), **(markers or {})}
    segments = {}
    for segment in SEGMENTS:
        wanted = [*clusters.get(segment, ()), *(own[name] for name in landmarks_of(segment) if name in own)]
        if len(there := dict.fromkeys(full[name] for name in wanted if name in full)) > 1:
            segments[segment] = tuple(there)
    return MarkerSet(tuple(named), segments, name="of clusters", rigidity=dict.fromkeys(segments, RIGIDITY))
