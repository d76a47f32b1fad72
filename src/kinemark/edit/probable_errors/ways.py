"""Where all paths of a file lead from what is before a place, and back from what is after it, and how far apart that
usually is: by parabolas through a few samples, quick enough for all frames of all paths (`breaks`)."""

from __future__ import annotations

import warnings
from functools import cached_property

import numpy as np

from ...data.array_types import Floats, Ints
from ...numerics.evenly import evenly
from .paths import HALF, LEAST_SD

WINDOW, WIDEST = 5, 24
"""Samples of a parabola next to a place, and of one that is continued over many frames; chosen: two more than it needs,
and still short beside a stride at 25 Hz."""
USUAL_S = 0.5
"""s of a block that says, with those beside it, what is usual; chosen: a stride and a half."""
UNUSUAL = 1.5
"""Mean of ln(1 + χ²/4) over the paths from which on a frame is looked at; chosen: of what is usual it is 0.5."""
LOOKED_AT, TESTS = 60, 200
"""Frames that are looked at, at most, the strangest; and that say how distances over some frames go with those over
one; chosen."""
LONGEST_S = 0.3
"""s that are lost at most; chosen: farther on a parabola is no motion."""
SMEARED, SMEARED_S = 6, 0.15
"""Frames, and s, over which filters smear what happens at once, at most; chosen, as of leaps."""
BLOCK = 2000
"""Frames at once; chosen: for memory."""


class Ways:
    """Of paths (M, F, 3) mm, at some Hz."""

    def __init__(self, xyz: Floats, rate: float) -> None:
        self.xyz, self.rate = xyz, rate
        self._usual: dict[tuple[int | str, int | None], Floats] = {}
        most = max(1, int(LONGEST_S * rate))
        steps = np.unique(np.round(np.geomspace(1, most, 12)).astype(np.int64))
        self.losses: tuple[int, ...] = tuple(steps.tolist())
        longest = max(1, int(SMEARED_S * rate))
        self.spans = range(1, min(SMEARED, longest) + 1)
        self.longer_spans = [s for s in (2, 3, 4, 5, 6, 8, 10, 12) if s <= longest]

    def ends(self, f: Ints, s: int, lost: int) -> tuple[Floats, Floats]:
        """(M, N, 3) where paths lead from frames f (N) and f + s to the middle between them, so many being lost."""
        n = min(WINDOW + (s + abs(lost)) // 4, WIDEST)
        weight = _parabola(n, (s + lost) / 2)
        return self._led(f, -1, weight), self._led(f + s, 1, weight)

    def off(self, f: Ints, s: int, lost: int) -> Floats:
        """(M, N) mm between the ends."""
        before, after = self.ends(f, s, lost)
        return _length(after - before)

    def squared(self, f: Ints, s: int, lost: int) -> Floats:
        """(M, N) χ² of them."""
        return np.asarray(self.off(f, s, lost) ** 2 * HALF / self.usual(s, lost, f) ** 2)

    def strange(self, f: Ints, s: int) -> Floats:
        """(N) means of ln(1 + χ²/4) over the paths where nothing is lost; 0 where none is known."""
        of = np.log1p(self.squared(f, s, 0) / 4)
        return np.where(np.isfinite(of), of, 0.0).sum(0) / np.maximum(np.isfinite(of).sum(0), 1)

    def usual(self, s: int, lost: int, f: Ints) -> Floats:
        """(M, N) mm that ends are usually apart, medians, near to frames f."""
        if (s, lost) not in self._usual:
            frames = evenly(self.xyz.shape[1] - s, TESTS)
            off = self.off(frames, s, lost) / self._near_by[:, frames]
            self._usual[s, lost] = _median(off, axis=1)
        return np.maximum(self._usual[s, lost][:, None] * self._near_by[:, f], LEAST_SD * np.sqrt(HALF))

    def inside(self, f: Ints, s: int) -> tuple[Floats, Floats]:
        """(M, N, 3) where paths are in the middle of frames f and f + s by what is before and after, and are."""
        at = (s + 1) // 2
        n = WINDOW + s // 4
        led = self._led(f, -1, _parabola(n, at)), self._led(f + s, 1, _parabola(n, s - at))
        return (led[0] + led[1]) / 2, self.xyz[:, f + at]

    def usual_inside(self, s: int, f: int) -> Floats:
        """(M) mm that these are usually apart."""
        if (s, None) not in self._usual:
            frames = evenly(self.xyz.shape[1] - s, TESTS)
            a, b = self.inside(frames, s)
            self._usual[s, None] = _median(np.linalg.norm(b - a, axis=2) / self._near_by[:, frames], axis=1)
        return np.maximum(self._usual[s, None] * self._near_by[:, f], LEAST_SD * np.sqrt(HALF))

    def rough(self, f: Ints, step: int) -> Floats:
        """(N) means over the paths of ln(1 + χ²/4) of how far samples are from one parabola, those up to frames f (step
        −1) or from there on (1): great where a break is among them."""
        if ("rough", step) not in self._usual:
            frames = evenly(self.xyz.shape[1], TESTS)
            self._usual["rough", step] = _median(self._from_parabola(frames, step) / self._near_by[:, frames], axis=1)
        usual = np.maximum(self._usual["rough", step][:, None] * self._near_by[:, f], LEAST_SD)
        of = np.log1p(self._from_parabola(f, step) ** 2 * HALF / usual**2 / 4)
        return np.where(np.isfinite(of), of, 0.0).sum(0) / np.maximum(np.isfinite(of).sum(0), 1)

    def _from_parabola(self, f: Ints, step: int) -> Floats:
        """(M, N) mm, root mean square of WINDOW samples."""
        t = np.vander(np.arange(WINDOW, dtype=np.float64), 3)
        rest = np.eye(WINDOW) - t @ np.linalg.pinv(t)
        return _length(np.stack([_length(self._led(f, step, row)) for row in rest], axis=-1)) / np.sqrt(WINDOW)

    def near_unusual(self, s: int) -> Ints:
        """Frames from which something over s frames may have happened, and not beside them."""
        f = np.unique((self.unusual[:, None] - np.arange(s)).ravel())
        f = f[(f >= 0) & (f + s < self.xyz.shape[1])]
        return f[np.maximum(self.rough(f, -1), self.rough(f + s, 1)) < UNUSUAL]

    def broken(self, s: int) -> Ints:
        """Those of them from which paths go on over s frames as they do not usually."""
        f = self.near_unusual(s)
        return f[self.strange(f, s) > UNUSUAL] if len(f) else f

    @cached_property
    def unusual(self) -> Ints:
        """Frames after which paths do not go on as they usually do, the LOOKED_AT strangest."""
        n = self.xyz.shape[1] - 1
        of = np.concatenate([self.strange(f, 1) for f in _blocks(n)]) if n else np.zeros(0)
        strangest = np.argsort(-of, kind="stable")[:LOOKED_AT]
        return np.sort(strangest[of[strangest] > UNUSUAL])

    @cached_property
    def _near_by(self) -> Floats:
        """(M, F) mm that ends next to each other are apart near to each frame, medians of three blocks."""
        M, F = self.xyz.shape[:2]
        off = np.full((M, F), np.nan)
        for f in _blocks(F - 1):
            off[:, f] = self.off(f, 1, 0)
        size = max(8, round(USUAL_S * self.rate))
        starts = range(0, F, size)
        blocks = np.column_stack([_median(off[:, max(a - size, 0) : a + 2 * size], axis=1) for a in starts])
        whole = _median(off, axis=1)[:, None]
        blocks = np.where(np.isfinite(blocks), blocks, whole)
        return np.maximum(np.repeat(blocks, size, axis=1)[:, :F], LEAST_SD)

    def _led(self, f: Ints, step: int, weight: Floats) -> Floats:
        """(M, N, 3) by the samples from frames f on, backwards (step −1) or ahead (1); NaN where one is missing."""
        at = f[:, None] + step * np.arange(len(weight))
        there = ((at >= 0) & (at < self.xyz.shape[1])).all(1)
        out = np.full((len(self.xyz), len(f), 3), np.nan)
        out[:, there] = np.einsum("n,mfnk->mfk", weight, self.xyz[:, at[there]])
        return out


def _parabola(n: int, at: float) -> Floats:
    """(n) weights of samples at 0, −1, … of a parabola's value at `at`, by least squares."""
    t = -np.arange(n, dtype=np.float64)
    return np.array([1.0, at, at**2]) @ np.linalg.pinv(np.vander(t, 3, increasing=True))


def _length(d: Floats) -> Floats:
    return np.asarray(np.sqrt(np.einsum("...k,...k->...", d, d)))


def _blocks(n: int) -> list[Ints]:
    return np.array_split(np.arange(n), max(1, n // BLOCK))


def _median(some: Floats, axis: int) -> Floats:
    """Of what is known; NaN where nothing is."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.asarray(np.nanmedian(some, axis=axis))
