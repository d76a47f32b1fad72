"""Names for the tracks of a file without a session, by what lies beside it.

What is known is tried in this order, and what names most tracks for sure is taken, of several as good the first: kept
templates of the folder (`*.template.h5`), its other trials, and the named markers of the file itself. Tracks that have
a name are facts. What names nothing, or does not fit, is passed over.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ...data import KinemarkError, Origin, Trajectories
from ...data.edits import is_named
from ...io.formats import endings
from ...label import Labels, Template, computed_points, label, learn_template
from .subject_templates import Known, subject_template
from .template_files import is_template, load_template

MOST_TRIALS = 4
"""Other trials that are tried, the first by their names; chosen: one takes seconds, and those of a folder are alike."""
LEAST_MARKERS = 6
"""Named markers by which a file itself tells who the others are; chosen, as for its problems."""


class ProposedName(NamedTuple):
    """What a track may be: its name, how likely, what else it may be, and whether that is sure."""

    name: str
    probability: float
    runner_up: str | None
    sure: bool


class ProposedNames(NamedTuple):
    """Names by track, of those without one, the file by which they are proposed, and all markers that it knows; empty
    where none fits."""

    source: str
    names: dict[str, ProposedName]
    known: tuple[str, ...] = ()


def propose_names(path: Path, tracks: Trajectories) -> ProposedNames:
    """Names for the tracks of a file that have none.

    Args:
        path: of the file. tracks: of it, as they are called now.
    """
    computed = computed_points(tracks)
    there = [one.name for one in tracks if one.name not in computed and (one.origin != Origin.MISSING).any()]
    some, best = tracks.select(there), ProposedNames("", {})
    if all(map(is_named, there)):
        return best
    for source, template in _known(path, some):
        found = ProposedNames(source, _proposed(some, template), template.names)
        if _worth(found) > _worth(best):
            best = found
    return best


def _worth(found: ProposedNames) -> tuple[int, int]:
    """Names that are sure, and all."""
    return sum(one.sure for one in found.names.values()), len(found.names)


def _known(path: Path, tracks: Trajectories) -> Iterator[tuple[str, Template]]:
    """Templates by the files that they are of."""
    beside = sorted(other for other in path.parent.iterdir() if other.is_file() and other != path)
    for other in beside:
        if is_template(other):
            with suppress(KinemarkError):
                yield other.name, load_template(other).template
    trials = [other for other in beside if other.suffix.lower() in endings("trajectories")]
    for other in trials[:MOST_TRIALS]:
        with suppress(KinemarkError):
            yield other.name, subject_template([other], Known()).template
    named = [name for name in tracks.names if is_named(name)]
    if len(named) >= LEAST_MARKERS:
        with suppress(KinemarkError):
            yield path.name, learn_template(tracks.select(named))


def _proposed(tracks: Trajectories, template: Template) -> dict[str, ProposedName]:
    """Names by a template, of tracks without one."""
    facts = {name: name if name in template.names else None for name in tracks.names if is_named(name)}
    try:
        found: Labels = label(tracks, template, stated=facts)
    except KinemarkError:
        return {}
    if found.refused:
        return {}
    columns = zip(tracks.names, found.names, found.probability, found.runner_up, found.state, strict=True)
    return {
        track: ProposedName(name, float(probability), second, state == "sure")
        for track, name, probability, second, state in columns
        if name is not None and not is_named(track)
    }
