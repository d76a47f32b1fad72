"""Labelled trials checked: where two markers carry each other's names, for a while or all through."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import KinemarkError, Trajectories
from ..data.array_types import Ints
from ..data.progress import tell
from .check_ends import ends
from .evidence import PairScore, Single
from .exchange import Exchanger
from .stretches import stretches_of
from .sweeps import places
from .template import Template

WINDOW_S = 0.5
"""Length of the parts of a trial that are looked at, s; chosen, as long as a new pose takes."""
LEAST_NATS = 8.0
"""What an exchange must gain a frame to be said; chosen: it stands above what soft tissue makes of near markers."""


PEERS = 3
"""Names of which most is told, by which an exchange must gain as well; chosen, as many as place it, of 1, 2, 3, 4 and 6
(docs/theory/label.md). Two bodies that stand otherwise to each other than the template shows are off in all distances
between them, and turned in all quadruples, which are many."""


class Exchanged(NamedTuple):
    """Two markers whose names fit better the other way round.

    Attributes:
        markers: the two. first, stop: first and last-plus-one frame, from 0.
        gain: nats a frame by which the exchanged names are better, mean over these frames.
    """

    markers: tuple[str, str]
    first: int
    stop: int
    gain: float


def find_exchanges(trajectories: Trajectories, template: Template) -> tuple[Exchanged, ...]:
    """Stretches of a labelled trial in which the names of two near markers are exchanged, in the order of time.

    Raises:
        KinemarkError: fewer than four of the template's names are in the trial.
    """
    known = trajectories.select([name for name in template.names if name in trajectories.names])
    if len(known) < 4:
        raise KinemarkError(
            f"{len(known)} of the template's {len(template)} markers are in the trial. Wanted are four or more: "
            "names must be spelt alike."
        )
    stretches = stretches_of(known, template.size)
    label = np.array([template.names.index(name) for name in known.names])
    y = places(stretches, label, len(template))
    pairs = PairScore.of_template(template)
    exchanger = Exchanger.of(template, pairs)
    near = by_peers(exchanger)
    wide = max(1, round(WINDOW_S * trajectories.rate))
    window = stretches.frame // wide
    found: list[Exchanged] = []
    for part in (parts := np.unique(window)):
        tell(int(part), int(parts[-1]))
        rows = np.flatnonzero(window == part)
        found += _in_window(y[rows], exchanger, near, template, stretches.frame[rows])
    placed = [_placed(one, known, template, exchanger, wide) for one in _merged(found, 2 * wide)]
    return tuple(sorted(placed, key=lambda one: (one.first, one.markers)))


def _placed(one: Exchanged, known: Trajectories, template: Template, exchanger: Exchanger, window: int) -> Exchanged:
    """With its ends to the frame."""
    a, b = (template.names.index(name) for name in one.markers)
    first, stop = ends(known, template, exchanger, ((a, b), (b, a)), (one.first, one.stop), window)
    return one._replace(first=first, stop=stop)


def by_peers(exchanger: Exchanger) -> Exchanger:
    """The same by the pairs alone of which one is among the `PEERS` that tell most of the other.

    And by quadruples all of whose pairs are such: those across two bodies are turned where these stand otherwise.
    """
    pairs, told = exchanger.pairs, exchanger.pairs.expected
    peers = (told > 0) & (told >= np.sort(told, axis=1)[:, [-min(PEERS, len(told))]])
    kept = peers | peers.T
    share = kept.astype(np.float32)
    four = exchanger.handed
    within = (kept[four[:, :, None], four[:, None]] | np.eye(4, dtype=bool)).all((1, 2))
    return exchanger._replace(
        pairs=pairs._replace(inverse=pairs.inverse * share, base=pairs.base * share, least=pairs.least * share),
        handed=four[within],
        sign=exchanger.sign[within],
    )


def _in_window(y: Single, exchanger: Exchanger, near: Exchanger, template: Template, frame: Ints) -> list[Exchanged]:
    """Of these frames; `near` is the same by each one's peers alone."""
    seen = np.asarray(np.isfinite(y[..., 0]).any(0))
    moves = [((a, b), to) for (a, b), to in exchanger.twos if seen[a] and seen[b]]
    moves = [move for move, may in zip(moves, near.may_gain(y, moves), strict=True) if may]
    gains, own = exchanger.gains(y, moves), near.gains(y, moves)
    return [
        Exchanged((template.names[a], template.names[b]), int(frame[0]), int(frame[-1]) + 1, float(gain))
        for ((a, b), _), gain, near_gain in zip(moves, gains, own, strict=True)
        if gain > LEAST_NATS and near_gain > 0
    ]


def _merged(found: list[Exchanged], near: int) -> list[Exchanged]:
    """Neighbouring windows of the same two as one."""
    out: dict[tuple[str, str], list[Exchanged]] = {}
    for one in found:
        own = out.setdefault(one.markers, [])
        if own and one.first - own[-1].stop < near:
            old = own.pop()
            n, m = old.stop - old.first, one.stop - one.first
            one = Exchanged(one.markers, old.first, one.stop, (n * old.gain + m * one.gain) / (n + m))
        own.append(one)
    return [one for own in out.values() for one in own]
