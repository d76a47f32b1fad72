"""What an act changed of the trajectories, told in as few samples as can be.

An edit leaves most samples as they are, and often all: a track that was named is the same under another name. So each
trajectory that is new or others than before is said by one of before, its base, and by the frames in which it differs
from that. Where fills are shown all frames are sent: they may have been judged again since the page has them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence

import numpy as np

from ...data import MarkerTrajectory, Origin, Trajectories
from ...data.array_types import Bools
from ...edit import Edited
from .desk import OpenDocument
from .edit_messages import ChangedPaths
from .gaps import chosen_fills, may_show_fills
from .paths import differing, forget_others, part, whole_part

MOST_SAMPLES = 200_000
"""Of trajectories that are in the answer to an act; chosen: 20 markers of 10 000 frames are 4.5 MB of text."""


def changed_by(before: Edited, after: Edited) -> tuple[list[str], list[str]]:
    """Markers of other samples, or of gaps that are to be filled otherwise; and those that are there no more."""
    changed, removed = differing(before.trajectories, after.trajectories)
    old, new = Counter(before.choices), Counter(after.choices)
    refilled = {choice.marker for choice in [*(old - new), *(new - old)]} - {*changed}
    return changed + [name for name in after.trajectories.names if name in refilled], removed


def shown_now(
    document: OpenDocument, before: Edited, changed: Sequence[str], removed: Sequence[str]
) -> ChangedPaths | None:
    """Trajectories as the page shows them, so that it need not ask again; None where it must."""
    bases = bases_of(before.trajectories, document.now.trajectories, changed, removed)
    filled = may_show_fills(document, before, {*bases.values()}) or may_show_fills(document, document.now, {*changed})
    first, stop = (0, document.now.trajectories.n_frames) if filled else span_of(before, document.now, bases)
    if len(changed) * (stop - first) > MOST_SAMPLES:
        return None
    if not filled and stop - first < document.now.trajectories.n_frames:
        return ChangedPaths(bases=[*bases.values()], **dict(part(changed, document.now.trajectories, first, stop)))
    shown, pending = chosen_fills(document, set(changed))
    forget_others(document, (document.editing.trajectories, document.now.trajectories, shown))
    return None if pending else ChangedPaths(bases=[""] * len(shown), **dict(whole_part(document, shown)))


def bases_of(
    before: Trajectories, after: Trajectories, changed: Sequence[str], removed: Collection[str]
) -> dict[str, str]:
    """By each changed trajectory the one of before that it is told by, empty for none.

    That is the one of its name, else one with the same samples that is there no more; none for one without samples.
    """
    there, gone = {*before.names}, {_mark(path): path.name for path in before if path.name in removed}
    own = (after[name] for name in changed)
    return {p.name: (p.name if p.name in there else gone.get(_mark(p), "")) if p.origin.any() else "" for p in own}


def span_of(before: Edited, after: Edited, bases: dict[str, str]) -> tuple[int, int]:
    """First frame and last-plus-one, from 0, in which any trajectory is other than its base."""
    old, differs = before.trajectories, np.zeros(after.trajectories.n_frames, bool)
    if old.n_frames != len(differs) or old.first_frame != after.trajectories.first_frame:
        return 0, len(differs)
    for name, base in bases.items():
        path = after.trajectories[name]
        differs |= others(old[base], path) if base else path.origin != Origin.MISSING
    at = np.flatnonzero(differs)
    return (int(at[0]), int(at[-1]) + 1) if len(at) else (0, 0)


def others(one: MarkerTrajectory, other: MarkerTrajectory) -> Bools:
    """(F) whether two trajectories have different samples."""
    xyz, cov = _unlike(one.xyz, other.xyz).any(1), _unlike(one.cov, other.cov).any((1, 2))
    return np.asarray((one.origin != other.origin) | xyz | cov)


def _unlike(one: np.ndarray, other: np.ndarray) -> Bools:
    return np.zeros(one.shape, bool) if one is other else (one != other) & ~(np.isnan(one) & np.isnan(other))


def _mark(path: MarkerTrajectory) -> tuple[bytes, bytes]:
    """By which trajectories of nearly the same samples are found."""
    return path.origin.tobytes(), path.xyz[path.origin != Origin.MISSING][:1].tobytes()
