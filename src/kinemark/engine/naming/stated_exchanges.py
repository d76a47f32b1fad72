"""Names that people stated of a trial's tracks, where two markers carry each other's by all that distances tell.

What was stated is a fact, and is kept. But a slip of the hand names the other trials too, so that it is said where it
happened. By a template it is told which names are wrong, and nobody learns them; without one only that they change.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

from ...data import Trajectories, make_finding
from ...data.edits import is_named
from ...data.finding import Finding
from ...label import Exchanged, find_exchanges
from ...label.own_exchanges import find_own_exchanges, without_exchanged
from ...label.subject_template import FEWEST
from .templates import SessionTemplate, markers_of, prefix_of


class StatedExchanges(NamedTuple):
    """The findings, and the trial as others may learn from it."""

    findings: tuple[Finding, ...]
    learnt: Trajectories


def stated_exchanges(
    done: Trajectories, by: Mapping[str, SessionTemplate], stated: Collection[str | None]
) -> StatedExchanges:
    """Where two markers of a trial carry each other's names, of which a person stated one.

    Args:
        done: with names. by: subject → what is known of it without this trial; none where nothing is.
        stated: the names that were stated.
    """
    if not any(stated):
        return StatedExchanges((), done)
    told = [one for subject, known in by.items() for one in _by_template(done, subject, known)]
    own = [] if by else find_own_exchanges(done.select([name for name in done.names if is_named(name)]))[0]
    wrong, found = ([one for one in some if set(one.markers) & set(stated)] for some in (told, [*told, *own]))
    findings = (
        make_finding(
            "stated_names_exchanged", markers=one.markers, frames=((one.first, one.stop - 1),), template=bool(by)
        )
        for one in found
    )
    return StatedExchanges(tuple(findings), without_exchanged(done, wrong))


def _by_template(done: Trajectories, subject: str, known: SessionTemplate) -> list[Exchanged]:
    """Of one subject; none where too few of its markers have names."""
    own = markers_of(done, subject)
    if len(set(own.names) & set(known.template.names)) < FEWEST:
        return []
    prefix = prefix_of(subject)
    return [
        one._replace(markers=(prefix + one.markers[0], prefix + one.markers[1]))
        for one in find_exchanges(own, known.template)
    ]
