"""What any body tells of its sides, whatever the template: feet and pelvis point forwards, and left is up × forwards.

The front is where the toes are from the heels, and the pelvis has the same front, from the sacrum or the posterior
spines to the anterior ones; up is where all other markers are from those of the feet. So names of a body that are
exchanged, or turned about, contradict each other even where no distance shows it. Each is told by the markers that are
there: a heel and the toe of its foot, a left marker and its right one, so that an absent one turns no direction.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats, Ints
from ..data.landmarks import FOREFOOT, OF_A_SIDE, OF_THE_MIDDLE, landmarks
from ..data.marker_sides import sides_by_name
from ..data.subject_measures import Side
from .evidence import Single

PROOF = 10.0
"""What a cosine of the agreement is worth, nats a frame; chosen, as two or three quadruples."""


class Anatomy(NamedTuple):
    """Labels that tell the front: of each foot and of the pelvis; all others; pairs of left and right."""

    heel: list[int]
    toe: list[int]
    back: list[int]
    front: list[int]
    rest: list[int]
    left: list[int]
    right: list[int]

    @classmethod
    def of(cls, names: Sequence[str]) -> Anatomy:
        """By what names say (`data.landmarks`)."""
        feet = _feet(names)
        heel, toe = ([foot[k] for foot in feet] for k in (0, 1))
        front, back = _of_pelvis(names, "ASI"), [*_of_pelvis(names, "SACR"), *_of_pelvis(names, "PSI")]
        rest = sorted({*range(len(names))} - {*heel, *toe})
        sides = sides_by_name(names)
        left, right = ([names.index(pair[k]) for pair in sides] for k in (0, 1))
        return cls(heel, toe, back, front, rest, left, right)

    def agreement(self, y: Single) -> float:
        """From −2 to 2 for labelled places y (K, L, 3): mean cosines of left with up × front, and of both fronts.

        Where there are no heels and toes, or no pelvis, that part is 0.
        """
        front, left = _mean(y[:, self.toe] - y[:, self.heel]), _mean(y[:, self.left] - y[:, self.right])
        up = _mean(y[:, self.rest]) - _mean(y[:, [*self.heel, *self.toe]])
        pelvis = _mean(y[:, self.front]) - _mean(y[:, self.back])
        return _mean_cosine(np.cross(up, front), left) + _mean_cosine(front, pelvis)

    def tells(self, labels: Sequence[int]) -> bool:
        """Whether one of the labels is on a foot or the pelvis."""
        return not {*self.heel, *self.toe, *self.back, *self.front}.isdisjoint(labels)

    def gain(self, y: Single, turn: Ints) -> float:
        """Nats a frame that labels y (K, L, 3) gain when each becomes turn (L)."""
        return float(self.gains(y, [turn])[0])

    def gains(self, y: Single, turns: Iterable[Ints]) -> Floats:
        """(M) what each of several turns (L) gains, as `gain`."""
        own = self.agreement(y)
        return PROOF * np.array([self.agreement(y[:, np.argsort(turn)]) - own for turn in turns], float)


def _feet(names: Sequence[str]) -> list[tuple[int, int]]:
    """Heel and toe of each foot that has both; of several the most usual toe, as none of them shows the front better.

    A foot is that of a side of a subject.
    """
    heels, toes = _best(names, OF_A_SIDE["HEE"]), _best(names, FOREFOOT)
    return [(heel, toes[foot]) for foot, heel in heels.items() if foot in toes]


def _best(names: Sequence[str], words: Sequence[str]) -> dict[tuple[str, Side], int]:
    """By subject and side the marker that has the first of these words."""
    found: dict[tuple[str, Side], tuple[int, int]] = {}
    for k, ways in enumerate(landmarks(names).values()):
        for one in ways:
            if one.side is not None and one.word in words:
                rank = words.index(one.word), k
                found[one.subject, one.side] = min(rank, found.get((one.subject, one.side), rank))
    return {foot: k for foot, (_, k) in found.items()}


def _of_pelvis(names: Sequence[str], landmark: str) -> list[int]:
    """Which markers show a landmark of the pelvis."""
    sided = landmark in OF_A_SIDE
    words = OF_A_SIDE[landmark] if sided else OF_THE_MIDDLE[landmark]
    return [
        k
        for k, ways in enumerate(landmarks(names).values())
        if any((one.side is not None) == sided and one.word in words for one in ways)
    ]


def _mean(y: Single) -> Floats:
    """(K, 3) of places, or ways, y (K, n, 3), of those that are known; NaN where none is."""
    known = np.isfinite(y)
    count = known.sum(1)
    return np.asarray(np.where(count > 0, np.where(known, y, 0.0).sum(1) / np.maximum(count, 1), np.nan), float)


def _mean_cosine(a: Floats, b: Floats) -> float:
    """Over the frames in which both are known; 0 without any."""
    size = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
    known = size > 0
    return float(((a * b).sum(1)[known] / size[known]).mean()) if known.any() else 0.0
