"""The three motions of Swamidas (1997), chapter 4, his twelve tests with hidden markers, and clouds made of them.

Three magnetic sensors on an arm, 30 Hz, within three feet of their transmitter: `kinemark.synth.motions`, whose
periods are those of the conclusions (about 2.2 s in run 1 and 1 s in run 3; run 2 is said to lie between).
The recordings are lost, and so is where in its cycle each began; every test is run from several phases of the cycle.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinemark.data import Cloud
from kinemark.data.array_types import Bools, Floats
from kinemark.synth import Subject, circle_over_cylinder, elbow_flexion, tilted_rectangle
from kinemark.synth.motions import PERIODS_S

PERIOD = dict(enumerate(PERIODS_S, 1))
"""Of the three runs, s."""

STARTS = (10, 80, 150)
"""Where gaps begin (tables 4.4 and 4.5), frames."""

AFTER = 20  # frames seen after the last gap


class Run(NamedTuple):
    """A recording: subject and the number (1, 2 or 3) of the run; `start` the frame of its cycle where it begins."""

    number: int
    subject: Subject
    start: int

    @property
    def xyz(self) -> Floats:
        """(3, F, 3) mm from the start on."""
        return self.subject.xyz[:, self.start :]


MOTIONS: dict[int, Callable[..., Subject]] = {1: circle_over_cylinder, 2: tilted_rectangle, 3: elbow_flexion}


def recorded(number: int, phase: float, *, duration_s: float = 8.0) -> Run:
    """Run 1, 2 or 3, begun at this phase (0 to 1) of its cycle, with unsteadiness of its own."""
    motion = MOTIONS[number]
    period = PERIOD[number]
    subject = motion(duration_s=duration_s + period, period_s=period, seed=round(1000 * phase))
    return Run(number, subject, round(phase * period * subject.rate))


def gap_frames(test: int) -> int:
    """How long the gaps of test 1 … 12 are, frames."""
    return 10 * ((test - 1) % 6 + 1)


def visible(n_gap: int, missing: int) -> Bools:
    """(3, F) who is seen: gaps of n_gap frames with 1 or 2 markers missing, as tables 4.4 and 4.5 place them.

    Table 4.5 takes A and B first, then B and C, then A and C.
    """
    seen = np.ones((3, STARTS[-1] + n_gap + AFTER), bool)
    for k, start in enumerate(STARTS):
        hidden = [k] if missing == 1 else [k, (k + 1) % 3]
        seen[hidden, start : start + n_gap] = False
    return seen


def cloud_of(
    xyz: Floats, seen: Bools, rate: float, extra: dict[int, Floats] | None = None
) -> tuple[Cloud, NDArray[np.int64]]:
    """Points of markers (M, F, 3) where seen (M, F), in the order of the markers, and the marker (P) of each.

    Args:
        extra: points (n, 3) mm that come first in these frames; their marker is −1.
    """
    extra = extra or {}
    points, marker, counts = [], [], []
    for f in range(seen.shape[1]):
        false, own = extra.get(f, np.zeros((0, 3))), np.flatnonzero(seen[:, f])
        points += [false, xyz[own, f]]
        marker += [np.full(len(false), -1), own]
        counts.append(len(false) + len(own))
    n = sum(counts)
    cloud = Cloud(
        rate=rate,
        start=np.concatenate([[0], np.cumsum(counts)]),
        xyz=np.concatenate(points),
        cov=np.broadcast_to(np.eye(3), (n, 3, 3)),
        residual=np.zeros(n),
        detection=np.full((n, 2), -1),
    )
    return cloud, np.concatenate(marker)
