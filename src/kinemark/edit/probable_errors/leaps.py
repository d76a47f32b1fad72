"""Leaps: a path of a file goes over to another place within some frames, and stays there or ends.

Somebody exchanged two markers, or a point was worked out of wrong images, and the file was filtered afterwards: the
step is smeared over some frames, each off what was before and what comes after. What a filter leaves, motion cannot do:
between the last sample before and the first one after the path comes `left_mm` away from where what is near it carries
it as a rigid body (`carried`), faster than it does in the seconds around, and farther than what is near it does
meanwhile, and before does not go on in after (`paths.meeting`). This tells a leap from a foot that strikes the floor
where frames are few, and from the skin of a runner.

A spike that was filtered is a leap that comes back soon, before or after the steps that tell most.

Tracks that have images are not looked at: a tracker takes another marker's image from one frame to the next, see
`changes`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from .carried import LEAST_MM, Leaving, left_mm
from .paths import SIGNIFICANT, Meeting, Paths, ends, meeting, sudden
from .probability import probability

SMEARED, SMEARED_S = 6, 0.15
"""Frames, and s, over which a leap may be smeared, at most; chosen: low-pass filters of half the frequency that frames
can show leave as many, and what takes longer may be motion."""

TOGETHER_S, SOME = 0.2, 0.05
"""s between leaps of a path that are one, as of changes, and their least probability; chosen: what is not worth a look
joins nothing."""


class LeapEvidence(NamedTuple):
    """What tells of a leap.

    Attributes:
        off: ln(1 + χ²/4) of how before goes on in after.
        left: ln of how far the path comes from where its companions carry it, mm; without companions, from where its
            own motion leads.
        speed: ln of the same a second, mm/s.
        usual: ln of the speed with which the path leaves its companions in other steps near to it, their median, mm/s.
        beside: ln of how far what is nearest comes from where it is carried at once, the median, mm.
        rate: ln of the trial's, Hz.
    """

    off: float
    left: float
    speed: float
    usual: float
    beside: float
    rate: float


class Leap(NamedTuple):
    """A path is mm off where motion leads in frame `after`, as seen from `before` (from 0), or in between where
    it comes `back`; and how likely that is wrong."""

    path: int
    before: int
    after: int
    evidence: LeapEvidence
    wrong: float
    mm: float
    back: bool = False


def leaps(paths: Paths) -> list[Leap]:
    """Those of all paths; of those that share frames the likeliest, and those that follow each other as one."""
    rows = [row for p in range(len(paths.frames)) for row in _rows(paths, p)]
    if not rows:
        return []
    met = _meeting(paths, rows)
    telling = np.flatnonzero(met.squared > SIGNIFICANT).tolist()
    leaving = Leaving(paths)
    found = []
    for n in telling:
        path, i, j = rows[n]
        f, g = int(paths.frames[path][i]), int(paths.frames[path][j + 1])
        evidence = _evidence(leaving, (path, f, g), float(met.off[n]), float(met.squared[n]))
        found.append(Leap(path, f, g, evidence, probability("leap", evidence), float(met.off[n])))
    return _together(paths, _apart(found))


def _meeting(paths: Paths, rows: Sequence[tuple[int, int, int]]) -> Meeting:
    """How paths up to their samples of index i go on in those from index j + 1 on."""
    p, i, j = (np.array(column, np.int64) for column in zip(*rows, strict=True))
    return meeting(ends(paths, p, i, -1), ends(paths, p, j + 1, 1), paths.rate, paths.q)


def _rows(paths: Paths, p: int) -> Iterator[tuple[int, int, int]]:
    """Path, and indices of the last sample before the first step of a leap and before the last one."""
    if paths.images[p].any():
        return
    own, (starts, stops) = paths.frames[p], sudden(paths, p)
    longest = _longest(paths)
    for i in starts.tolist():
        for j in stops[np.searchsorted(stops, i) : np.searchsorted(stops, i + longest)].tolist():
            if own[j + 1] - own[i] <= longest:
                yield p, i, j


def _evidence(leaving: Leaving, row: tuple[int, int, int], off: float, squared: float) -> LeapEvidence:
    """Of a path between frames f and g, with how before goes on in after."""
    rate, left, (_, f, g) = leaving.paths.rate, leaving.mm(*row), row
    mm = off if np.isnan(left) else left
    return LeapEvidence(
        float(np.log1p(squared / 4)),
        float(np.log(mm + LEAST_MM)),
        float(np.log((mm + LEAST_MM) * rate / (g - f))),
        float(np.log((leaving.usual(*row) + LEAST_MM) * rate)),
        float(np.log(leaving.beside(*row) + LEAST_MM)),
        float(np.log(rate)),
    )


def _apart(found: list[Leap]) -> list[Leap]:
    """Of those that share frames the likeliest."""
    kept: list[Leap] = []
    for one in sorted(found, key=lambda leap: (-leap.wrong, -leap.mm)):
        if not any(one.path == k.path and one.before < k.after and k.before < one.after for k in kept):
            kept.append(one)
    return kept


def _together(paths: Paths, found: list[Leap]) -> list[Leap]:
    """Of one path, those of some probability that follow each other soon are one, as likely as the likeliest."""
    groups: list[list[Leap]] = []
    for one in sorted(found, key=lambda leap: (leap.path, leap.before)):
        last = groups[-1][-1] if groups else None
        soon = last is not None and last.path == one.path and one.before - last.after <= TOGETHER_S * paths.rate
        if soon and min(one.wrong, groups[-1][-1].wrong) >= SOME:
            groups[-1].append(one)
        else:
            groups.append([one])
    return [_one(paths, group) if group[0].wrong >= SOME else group[0] for group in groups]


def _one(paths: Paths, group: list[Leap]) -> Leap:
    """A leap of a path, or several: there and back where the path was carried, shortly before or after, to where it is
    then, as what is near it was."""
    best = max(group, key=lambda leap: (leap.wrong, leap.mm))
    first, last = group[0].before, group[-1].after
    far = max(float(np.exp(one.evidence.left)) for one in group)
    for f, g in _spans(paths, best.path, first, last):
        if (f, g) != (best.before, best.after) and _left(paths, best.path, f, g) < far / 2:
            return best._replace(before=f, after=g, mm=far, back=True)
    return best._replace(before=first, after=last)


def _spans(paths: Paths, p: int, first: int, last: int) -> Iterator[tuple[int, int]]:
    """These frames, and those up to which a leap may be smeared before the first, or after the last."""
    yield first, last
    for n in range(1, _longest(paths) + 1):
        for f, g in ((first - n, last), (first, last + n)):
            if f >= 0 and g < paths.seen.shape[1] and paths.seen[p, f] and paths.seen[p, g]:
                yield f, g


def _longest(paths: Paths) -> int:
    """Frames over which a leap may be smeared."""
    return min(SMEARED, max(1, int(SMEARED_S * paths.rate)))


def _left(paths: Paths, p: int, f: int, g: int) -> float:
    """mm from where what is near path p carries it from frame f to g; without, from where motion leads."""
    left = left_mm(paths, p, g, f)
    if np.isnan(left):
        return float(_meeting(paths, [(p, paths.index_before(p, f), paths.index_before(p, g) - 1)]).off[0])
    return left
