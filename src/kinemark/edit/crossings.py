"""Where a path steps onto the place of another: what is said of it before is not said of what comes then.

A tracker that was not sure exchanges two markers for some frames, and a path then has samples of both. With the sample
x in frame f and the next one y in g, at most STEP frames later, and the velocities v before and w after them, motion
leads from x to x + (g − f) v and back from y to y − (g − f) w. The path is broken between f and g where

    |y − (x + (g − f) v)|  and  |x − (y − (g − f) w)|  are above LEAST_MM                                      (1)

and another path's sample in g is nearer to the former place than y, or another's in f nearer to the latter than x (2).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..data import MarkerTrajectory, Trajectories
from ..data.array_types import Bools, Floats, Ints

LEAST_MM = 3.0
"""mm, of (1); chosen: motion of a marker at 100 Hz is off as much from one frame to the next, and two markers are
farther apart. See studies/edits.py."""
STEP = 3
"""Frames; chosen: over more, velocity does not tell where a path leads. See studies/edits.py."""


def unbroken(paths: Sequence[MarkerTrajectory], among: Trajectories) -> Ints:
    """(M, F) number, from 0, of the piece of its path that each frame belongs to; broken at steps onto others' places.

    Args:
        paths: of a trial. among: all paths of the trial; samples that are the path's own are not another's.
    """
    piece = np.zeros((len(paths), among.n_frames), np.int64)
    both = [_steps(path) for path in paths]
    whose = np.repeat(np.arange(len(paths)), [len(forth.frame) for forth, _ in both])
    if len(whose):
        forth, back = (_all(way) for way in zip(*both, strict=True))
        onto = _another(forth, among) | _another(back, among)  # (2)
        piece[whose[onto], forth.frame[onto]] = 1
    return np.cumsum(piece, axis=1)


class Steps(NamedTuple):
    """N steps of paths, one way: the frame that they go to, the sample there, where motion leads, and mm between."""

    frame: Ints
    xyz: Floats
    led: Floats
    off: Floats

    def of(self, chosen: Any) -> Steps:
        """Some of them, by a mask or a slice."""
        return Steps(self.frame[chosen], self.xyz[chosen], self.led[chosen], self.off[chosen])


def _all(some: Sequence[Steps]) -> Steps:
    """Steps of several paths, one after the other."""
    frame, xyz, led, off = (np.concatenate([one[k] for one in some]) for k in range(4))
    return Steps(frame, xyz, led, off)


_KNOWN: WeakKeyDictionary[MarkerTrajectory, tuple[Steps, Steps]] = WeakKeyDictionary()
"""Steps of paths, as long as somebody has these: an edit changes few, and every look at the trial asks for all."""


def _steps(path: MarkerTrajectory) -> tuple[Steps, Steps]:
    """Those for which (1) holds, forth and back; worked out once for each path."""
    if path not in _KNOWN:
        _KNOWN[path] = _steps_of(path)
    return _KNOWN[path]


def _steps_of(path: MarkerTrajectory) -> tuple[Steps, Steps]:
    """The same, worked out."""
    own = np.flatnonzero(np.isfinite(path.xyz[:, 0]))
    if len(own) < 3:
        own = own[:0]
    forth = _led(own, path.xyz[own])
    back = _led(own[::-1], path.xyz[own[::-1]]).of(slice(None, None, -1))
    far = (np.diff(own) <= STEP) & (np.minimum(forth.off, back.off) > LEAST_MM)  # (1)
    return forth.of(far), back.of(far)


def _led(frame: Ints, xyz: Floats) -> Steps:
    """All steps from one sample (N, 3) to the next, in this order, and where velocity before leads."""
    frames = np.diff(frame)[:, None]
    velocity = np.vstack([np.zeros((1, 3)), np.diff(xyz, axis=0) / frames])[: len(frames)]
    led = xyz[:-1] + frames * velocity
    return Steps(frame[1:], xyz[1:], led, np.linalg.norm(xyz[1:] - led, axis=1))


def _another(steps: Steps, among: Trajectories) -> Bools:
    """(N) whether another path's sample is nearer to where motion leads than the own."""
    found = np.zeros(len(steps.frame), bool)
    for path in among:
        other = path.xyz[steps.frame]
        nearer = np.linalg.norm(other - steps.led, axis=1) < steps.off
        found |= nearer & ~(other == steps.xyz).all(1)
    return found
