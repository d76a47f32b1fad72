"""Leaps: a path of a file goes over to another place within some frames, and stays there or ends.

Somebody exchanged two markers, or a point was worked out of wrong images, and the file was filtered afterwards: the
step is smeared over some frames, each off what was before and what comes after. What a filter leaves, motion cannot do:
between the last sample before and the first one after the path comes `left_mm` away from where what is near it carries
it as a rigid body (`carried`), faster than it does otherwise, and before does not go on in after (`paths.meeting`).
This tells a leap from a foot that strikes the floor where frames are few.

Tracks that have images are not looked at: a tracker takes another marker's image from one frame to the next, see
`changes`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from .carried import LEAST_MM, left_mm
from .paths import SIGNIFICANT, Meeting, Paths, ends, meeting, sudden
from .probability import probability

SMEARED, SMEARED_S = 6, 0.15
"""Frames, and s, over which a leap may be smeared, at most; chosen: low-pass filters of half the frequency that frames
can show leave as many, and what takes longer may be motion."""

TESTS, RARE = 40, 0.9
"""Steps of a path that say how fast it leaves its companions otherwise, and the share of them that are slower; chosen:
a tenth of a path may be wrong, and the most of a stride is not fast."""

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
        usual: ln of the speed with which the path leaves its companions otherwise, mm/s.
        rate: ln of the trial's, Hz.
    """

    off: float
    left: float
    speed: float
    usual: float
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
    usual = {path: _usual(paths, path) for path in {rows[n][0] for n in telling}}
    found = []
    for n in telling:
        path, i, j = rows[n]
        f, g = int(paths.frames[path][i]), int(paths.frames[path][j + 1])
        evidence = _evidence(paths, path, f, g, float(met.off[n]), float(met.squared[n]), usual[path])
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
    longest = min(SMEARED, max(1, int(SMEARED_S * paths.rate)))
    for i in starts.tolist():
        for j in stops[np.searchsorted(stops, i) : np.searchsorted(stops, i + longest)].tolist():
            if own[j + 1] - own[i] <= longest:
                yield p, i, j


def _evidence(paths: Paths, p: int, f: int, g: int, off: float, squared: float, usual: float) -> LeapEvidence:
    """Between frames f and g, with how before goes on in after."""
    left = left_mm(paths, p, g, f)
    mm = off if np.isnan(left) else left
    return LeapEvidence(
        float(np.log1p(squared / 4)),
        float(np.log(mm + LEAST_MM)),
        float(np.log((mm + LEAST_MM) * paths.rate / (g - f))),
        usual,
        float(np.log(paths.rate)),
    )


def _usual(paths: Paths, p: int) -> float:
    """`LeapEvidence.usual`: what is faster is rare, of steps from one frame to the next that are evenly spread."""
    own = paths.frames[p]
    steps = np.flatnonzero(np.diff(own) == 1)
    some = own[steps[np.linspace(0, len(steps) - 1, min(len(steps), TESTS)).astype(int)]]
    mm = np.array([left_mm(paths, p, int(f) + 1, int(f)) for f in some])
    known = mm[np.isfinite(mm)]
    return float(np.log((np.quantile(known, RARE) if len(known) else 0.0) + LEAST_MM) + np.log(paths.rate))


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
    return [_one(paths, group) if len(group) > 1 else group[0] for group in groups]


def _one(paths: Paths, group: list[Leap]) -> Leap:
    """Several leaps of a path."""
    best = max(group, key=lambda leap: (leap.wrong, leap.mm))
    p, f, g = best.path, group[0].before, group[-1].after
    left = left_mm(paths, p, g, f)
    if np.isnan(left):
        left = float(_meeting(paths, [(p, paths.index_before(p, f), paths.index_before(p, g) - 1)]).off[0])
    return best._replace(before=f, after=g, back=left < best.mm / 2)
