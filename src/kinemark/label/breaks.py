"""Where a track breaks off and goes on as another: by motion alone, before anything has a name.

A marker does not jump. Where the step of a track from one sample to the next is less likely than any place in the
volume, by the density of `stretches`, it may be a bad sample, or the track may be another marker from there on. It is
another one where motion says which: with the track cut there, another one goes on into its second part, or its
first part goes on into another one, better by 10 nats than the two parts do into each other.

That needs no template, so that it holds where one tells little of single frames, as a static trial's does.

Where two images become one, a track goes on from a place between both, and no other goes on into it. Its steps there
are likelier than any place, but sudden.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..data import Trajectories
from ..data.array_types import Floats, Ints
from .cutting import cut
from .stretches import LINK_S, SPEED_S, link_nats, stretches_of
from .sweeps import GOES_ON

UNLIKELY = 0.0
"""Nats of a step below which a track may break; by definition of `link_nats`: any place is as likely."""
SUDDEN = 4.0
"""Standard deviations of a step from which on it is sudden; chosen: of the 55 000 of a gait trial 35 are."""


def find_breaks(tracks: Trajectories, size: float, free: Ints) -> set[tuple[int, int]]:
    """(track, frame) before which tracks break off and others go on.

    Args:
        tracks: of a recording. size: of the body, mm. free: the tracks that may be cut.
    """
    xyz = tracks.xyz
    jumps = {(t, frame) for t in free.tolist() for frame in _jumps(xyz[t], tracks.rate, size)}
    if not jumps:
        return set()
    pieces, of = cut(tracks, jumps)
    stretches = stretches_of(pieces, size)
    link = stretches.link
    found = set()
    for t, frame in jumps:
        own = np.flatnonzero(of == t)
        before, after = own[stretches.stop[own] <= frame], own[stretches.start[own] >= frame]
        if not len(before) or not len(after):
            continue
        p, q = int(before[-1]), int(after[0])
        into, out = link[:, [q]].toarray()[:, 0], link[[p]].toarray()[0]
        together = into[p]
        into[own] = out[own] = -np.inf
        if max(into.max(), out.max()) > together + GOES_ON:
            found.add((t, frame))
    return found


def sudden_steps(tracks: Trajectories, size: float, which: Ints) -> set[tuple[int, int]]:
    """(track, frame) to which some tracks come by a step that is sudden.

    Args:
        tracks: of a recording. size: of the body, mm. which: the tracks that are looked at.
    """
    xyz = tracks.xyz
    return {(t, frame) for t in which.tolist() for frame in _jumps(xyz[t], tracks.rate, size, sudden=True)}


def _jumps(xyz: Floats, rate: float, size: float, *, sudden: bool = False) -> list[int]:
    """Frames to which a track (F, 3) comes by a step that is less likely than any place, or that is sudden."""
    rows = np.flatnonzero(np.isfinite(xyz[:, 0]))
    if len(rows) < 2:
        return []
    p, i, width = xyz[rows], np.arange(len(rows)), max(1, round(SPEED_S * rate))
    first, last = np.maximum(i - width, 0), np.minimum(i + width, len(rows) - 1)
    out = (p - p[first]) / np.maximum(rows - rows[first], 1)[:, None]
    into = (p[last] - p) / np.maximum(rows[last] - rows, 1)[:, None]
    out[0], into[-1] = into[1], out[-2]  # an end has no speed of its own
    frames = np.diff(rows)
    step = np.diff(p, axis=0) - 0.5 * (out[:-1] + into[1:]) * frames[:, None]
    nats = link_nats(step, frames, rate, size)
    least = link_nats(0 * step, frames, rate, size) - 0.5 * SUDDEN**2 if sudden else UNLIKELY
    unlikely = (nats < least) & (frames <= LINK_S * rate)
    unlikely[[0, -1]] = False  # one sample tells of no motion
    if not unlikely.any():
        return []
    # a jump spoils the speeds beside it, so that the worst of its neighbourhood is taken
    worst = nats <= scipy.ndimage.minimum_filter1d(nats, 2 * width + 1)
    return [int(frame) for frame in rows[1:][unlikely & worst]]
