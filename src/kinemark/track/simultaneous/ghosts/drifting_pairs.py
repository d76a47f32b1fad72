"""Pairs of images that drift past each other: two cameras' images of two markers, taken for one.

Where two cameras alone see a track, its images may be two markers' that lie on each other's epipolar lines for a while.
Their residual e, by (1) of `epipolar_noise`, is then anywhere within the gate, and changes as slowly as both move. Of
one marker it is the noise of the images, new in every frame, about what the calibration leaves, which is much the same
all the time. So a mean of many frames, and their trend, tell what no frame by itself does.

Both are known from the recording itself: from points of SOUND and more images, of which each pair of cameras has the
residual e of many, with the median m. Second differences leave of it the white noise alone, of variance v. In blocks
of up to BLOCK frames that follow each other, with orthonormal polynomials p_k of degree 0 to DEGREES − 1 of the time,

    a_k = Σ p_k(t) (e_t − m),   V_k = f (v + n L_k)                                       (1)

have the variance V_k in blocks of n frames: L_k is what the calibration adds, by the median of |a_k|. Images of two
markers pass the gate of g standard deviations of e, as the tracker takes it, s, and their a_k have more, W_k:

    W_k = V_k + n g² s² / 3 · 2^−(k+1),   score = ½ Σ (a_k² / V_k − a_k² / W_k − ln(W_k / V_k))  (2)

is the log-likelihood ratio of two markers to one. Where chance meetings are many, sound points have images of other
markers too: f and the share of such blocks are those of the likeliest mixture of both, by expectation and maximisation.
Where f is large in most pairs of cameras, the residual does something else, as that of cameras that are not
synchronous, and nothing is judged. Images that run together, or that a limb hides a part of, drift too, but by a small
part of the gate. So nothing is judged either where the share is large in the whole, unless the blocks that drift are
likelier to be anywhere within the gate than within a part of it, of NARROW of the variance that it adds to V:

    Σ ln N(a; 0, W) − ln N(a; 0, V + NARROW (W − V)) > 0                                  (3)

of their means and trends, with each block by its probability of being two markers'. Nor is a pair judged of which the
share is large.

Of blocks of points of two images that have more than CERTAIN, the part of the highest score is given up, and so are
parts of what is left; and all of a track without sound points of which MOST is. Two cameras see alone what is at the
edge of an image, where a calibration may leave more than where sound points are: where the medians of e − m of SEVERAL
tracks in different places have the median d there, d² is added to L_0 (4). Where there are but two cameras, or two that
have too few sound points, all of their points are taken for sound, as most are one marker's. Cameras that hardly see
the same markers have too few; there nothing is judged.

Points of SOUND to MOST_IMAGES images have another marker's image too. They are judged by all pairs of their images:
where a block of one has more than CERTAIN, the image of which all pairs have the greatest sum of scores is given up
(5), one after the other, and what is left is judged as other points of so many images.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple, cast

import numpy as np
import scipy
from numpy.typing import NDArray

from ....data.array_types import Bools, Floats, Ints
from ....numerics.returned_memory import return_memory
from ....numerics.robust import SD_PER_MEDIAN
from ....numerics.runs import begins, equal_runs
from ..detection_index import Images
from ..following.candidate_points import fundamentals

SOUND = 3
"""Images of a point that are taken for one marker's, a number; chosen, as in `second_pass`."""

MOST_IMAGES = 4
"""Images of a point of which one is given up, a number; chosen: of more one moves the point little."""

BLOCK = 24
"""Frames of a block at most, a number; chosen (see benchmarks/tracking_scenes.py, seeds 5000 to 5119)."""

DEGREES = 4
"""Of the polynomials of (1), a number; chosen: what is left above them is noise."""

MIN_SOUND, MIN_BLOCKS = 100, 8
"""Sound points, and blocks of half of BLOCK frames and more, from which two cameras are known; chosen."""

MAX_BLOCKS = 200
"""Sound blocks that are looked at for two cameras; chosen: more take time and say the same."""

MIXING = 0.1
"""Share of sound blocks that are two markers', to begin with; chosen: half of it and twice as much end alike."""

ROUNDS = 30
"""Of expectation and maximisation, a number; chosen: f no longer changes in its second digit."""

MAX_SHARE = 0.3
"""Of sound blocks that are two markers', from which a pair of cameras is not judged; chosen: of 665 pairs of 60
simulated scenes (seeds 90000 to 90059) none has more than 0.11, and what is as usual as that is no exception."""

MAX_STRANGE = 0.06
"""Of the sound blocks of a recording, the share that are two markers', less one of each pair of cameras, above which
nothing is judged where (3) does not hold; chosen: simulated scenes (seeds 122068 to 122149) have 0 to 0.04, crowded
ones up to 0.2, a child's foot of which markers touch in the images (`studies/child_foot.py`, five seeds) 0.07 to 0.17.
"""

NARROW = 0.05
"""Of (3), a ratio of variances; chosen: of the foot, from far and near, (3) is −1.1 to −1.8 a block, of crowded scenes
(seeds 131024, 137010, 137085 of benchmarks/tracking_scenes.py) 2.4 to 6.5."""

TREND = 2
"""Of the polynomials of (3), a number: mean and trend, by definition; those above are small for either."""

MAX_FACTOR = 1.3
"""The median of f of (1), a ratio of variances, from which sound points do not follow (1), and nothing is judged;
chosen: of 665 pairs of cameras of 60 simulated scenes all have 0.6 to 1.21, those of gait9 1.1 to 2.6, the median 1.55.
"""

CERTAIN = float(np.log(30.0))
"""Two markers are then thirty times likelier than one; chosen: in 68 scenes of four cameras (seeds 131000 to 131200 of
benchmarks/tracking_scenes.py) 629 ghosts with ln 1000 become 581, with ln 10 578, and with ln 3 584, for 0.02, 0.04 and
0.06 % of the samples that two cameras see."""

SEVERAL = 3
"""Tracks, a number; chosen: of three, two are markers."""

PLACE = 8.0
"""px, the side of a place of (4); chosen: noise is less, and few of the tracks that move meet in one by chance."""

MOST = 0.5
"""Of a track, a share; chosen: in the tracks of seeds 5000 to 5119 480 ghosts are given up for 443, and 309 points of
markers for 297."""


class Usual(NamedTuple):
    """What the residual of two cameras is for one marker: m px, v px², L (DEGREES) px² and f of (1); and the share of
    so many sound blocks that are two markers', of one at least, and the sum `wide` of (3) over them."""

    median: float
    white: float
    lasting: Floats
    factor: float
    share: float
    blocks: int
    wide: float

    def variance(self, n: int) -> Floats:
        """V of (1), px², for as many degrees as n frames have, last axis."""
        return np.asarray(self.factor * (self.white + n * self.lasting[..., : min(n, DEGREES)]))

    def shifted(self, d: float | Floats) -> Usual:
        """The same where the calibration leaves d px more, by (4); of many (N) also L is (N, DEGREES)."""
        return self._replace(lasting=self.lasting + np.multiply.outer(np.square(d), np.arange(DEGREES) == 0))


class UsualResiduals(NamedTuple):
    """What is usual for pairs of cameras (r, s), and their fundamental matrices F (C, C, 3, 3)."""

    of: dict[tuple[int, int], Usual]
    F: Floats


def usual_residuals(frame: Ints, id: Ints, detection: Ints, images: Images, gate: float) -> UsualResiduals:
    """As the points of tracks id (P) with detections (C, P) have them; of no pair where they do not follow (1)."""
    own, number = (detection >= 0) & ~images.merged[detection], (detection >= 0).sum(0)
    F, order = fundamentals(images.P), np.lexsort([frame, id])
    some = (own & (number <= MOST_IMAGES)).astype(np.float32)
    sound = own[:, order] & (number >= min(SOUND, len(detection)))[order]
    pairs = np.argwhere(np.triu(some @ some.T, 1)).tolist()
    known: dict[tuple[int, int], Usual] = {}
    for a, b in pairs:
        for some in (sound[a] & sound[b], (own[a] & own[b])[order]):  # without sound ones by all
            one = None if (a, b) in known else _usual(frame, id, detection, images, F, order[some], (a, b), gate)
            known |= {} if one is None else {(a, b): one}
    regular = _regular([*known.values()])
    return UsualResiduals({pair: one for pair, one in known.items() if regular and one.share < MAX_SHARE}, F)


def _regular(known: list[Usual]) -> bool:
    """Whether the points that three cameras see follow (1), but for a few."""
    if not known:
        return False
    blocks = sum(usual.blocks for usual in known)
    strange = sum(usual.share * usual.blocks - 1 for usual in known) / blocks
    few = strange <= MAX_STRANGE or sum(usual.wide for usual in known) > 0  # (3)
    return bool(np.median([usual.factor for usual in known]) <= MAX_FACTOR and few)


def drifting(frame: Ints, id: Ints, detection: Ints, images: Images, usual: UsualResiduals, gate: float) -> Bools:
    """(P) the points of two images, merged ones left out, of tracks id (P) that are given up; detections (C, P)."""
    number = (images.own(detection) >= 0).sum(0)
    out = _judged(frame, id, detection, number == 2, images, usual, gate).of_two
    return with_rest(out, id, number)


def without_strangers(
    frame: Ints, id: Ints, detection: Ints, images: Images, usual: UsualResiduals, gate: float
) -> Ints:
    """The detections (C, P) of tracks id (P), those of SOUND to MOST_IMAGES without the image that drifts past the
    others (5); in four bytes, as there are many."""
    detection, number = cast(Ints, detection.astype(np.int32)), (images.own(detection) >= 0).sum(0)
    which = (number >= SOUND) & (number <= MOST_IMAGES)
    while which.any():
        judged = _judged(frame, id, detection, which, images, usual, gate)
        rows = np.flatnonzero(judged.of_two)
        worst = np.where(images.own(detection[:, rows]) >= 0, judged.blame[:, rows], -np.inf).argmax(0)
        detection[worst, rows] = -1
        which = judged.of_two & ((images.own(detection) >= 0).sum(0) >= SOUND)
    return detection


class _Judged(NamedTuple):
    """Of points: whether two of their images are two markers' (P), and the sum (C, P) of the scores of each image."""

    of_two: Bools
    blame: NDArray[np.float32]


def _judged(
    frame: Ints, id: Ints, detection: Ints, which: Bools, images: Images, usual: UsualResiduals, gate: float
) -> _Judged:
    """Some points (P) judged by all pairs of their images."""
    out = _Judged(np.zeros(len(frame), bool), np.zeros(detection.shape, np.float32))
    for (a, b), rows, part in _scored(frame, id, detection, which, images, usual, gate):
        for c in (a, b):
            out.blame[c, rows] += part.score[:, None]
        for k in np.flatnonzero(part.score > CERTAIN).tolist():
            out.of_two[rows[k, _parts_of_two(part.off[k], part.reach[k], part.usual)]] = True
    return out


class _Scored(NamedTuple):
    """Of blocks: score (B) by (2), residuals less m, off (B, n) px, g² s², reach (B) px², and what is usual there."""

    score: Floats
    off: Floats
    reach: Floats
    usual: Usual


def _scored(
    frame: Ints, id: Ints, detection: Ints, which: Bools, images: Images, usual: UsualResiduals, gate: float
) -> Iterator[tuple[tuple[int, int], Ints, _Scored]]:
    """Of each pair of cameras, blocks of some points (P), their rows (B, n), and the scores."""
    order = np.flatnonzero(which)
    order = order[np.lexsort([frame[order], id[order]])]
    own = images.own(detection[:, order]) >= 0
    for (a, b), one in usual.of.items():
        rows = order[own[a] & own[b]]
        return_memory()
        e, squared = residual(images, usual.F[a, b], detection[a, rows], detection[b, rows])
        there = one.shifted(shared_shift(e - one.median, id[rows], images.uv[detection[a, rows]]))
        for block in blocks(frame[rows], id[rows]):
            off, reach = e[block] - one.median, squared[block].mean(1) * gate**2
            yield (a, b), rows[block], _Scored(scores(off, reach, there), off, reach, there)


def of_one_marker(
    frame: Ints, id: Ints, detection: Ints, which: Bools, images: Images, usual: UsualResiduals, gate: float
) -> Bools:
    """(P) of some points of tracks id (P), those whose images are rather one marker's by (2), in each block of any two
    of their cameras."""
    worst = np.full(len(frame), -np.inf)
    for _, rows, part in _scored(frame, id, detection, which, images, usual, gate):
        worst[rows] = np.maximum(worst[rows], part.score[:, None])
    return np.isfinite(worst) & (worst < 0)


def with_rest(given_up: Bools, id: Ints, number: Ints) -> Bools:
    """(P) those given up, and the rest of tracks of which MOST is and no point has SOUND images, number (P)."""
    many, never = np.bincount(id), np.bincount(id, number >= SOUND) == 0
    return given_up | (never & (np.bincount(id, given_up) >= MOST * many))[id]


def shared_shift(e: Floats, id: Ints, uv: Floats) -> float:
    """The median, px, of the medians of the residuals (n) less m of SEVERAL tracks and more; otherwise 0.

    Tracks of which the images uv (n, 2) px of one camera have the median in one place are pieces of one: reflections
    that stand met by chance all the time, and each piece told that the others are usual.
    """
    order = np.lexsort([e, id])
    cuts = equal_runs(id[order])
    e, first, last = e[order], cuts[:-1], cuts[1:] - 1
    each = (e[(first + last) // 2] + e[(first + last + 1) // 2]) / 2
    place = np.round(uv[order[(first + last) // 2]] / PLACE)
    each = each[np.unique(place, axis=0, return_index=True)[1]]
    return float(np.median(each)) if len(each) >= SEVERAL else 0.0


def _usual(
    frame: Ints, id: Ints, detection: Ints, images: Images, F: Floats, rows: Ints, pair: tuple[int, int], gate: float
) -> Usual | None:
    """What sound points, some rows by track and frame, say of a pair of cameras; None where they are too few."""
    if len(rows) < MIN_SOUND:
        return None
    a, b = pair
    return_memory()  # of the pair before: there are many, of long recordings
    e, squared = residual(images, F[a, b], detection[a, rows], detection[b, rows])
    median = float(np.median(e))
    every = [block[:: -(-len(block) // MAX_BLOCKS)] for block in blocks(frame[rows], id[rows])]
    bend = np.concatenate([np.diff(e[block], 2).ravel() for block in every])
    long = [block for block in every if 2 * block.shape[1] >= BLOCK]
    if len(bend) < MIN_SOUND or sum(len(block) for block in long) < MIN_BLOCKS:
        return None
    white = float((SD_PER_MEDIAN * np.median(np.abs(bend))) ** 2 / 6)
    length = np.concatenate([np.full(len(block), block.shape[1]) for block in long])
    size = np.concatenate([_coefficients(e[block] - median) for block in long])
    whole = (SD_PER_MEDIAN * np.median(np.abs(size), axis=0)) ** 2
    lasting = np.maximum(whole - white, 0.0) / np.median(length)
    reach = np.concatenate([squared[block].mean(1) for block in long]) * gate**2
    factor, share, wide = _mixture(size, white + length[:, None] * lasting, _added(length, reach, DEGREES))
    return Usual(median, white, lasting, max(factor, 1.0), share, len(size), wide)


def _mixture(a: Floats, V: Floats, added: Floats) -> tuple[float, float, float]:
    """f of (1) and the share of two markers, likeliest for coefficients (B, k) of variance f V, or f V + `added`; and
    the sum of (3)."""
    f, share = 1.0, MIXING
    for _ in range(ROUNDS):
        one, two = (_unlikelihood(a, W) for W in (f * V, f * V + added))
        of_two = scipy.special.expit((one - two) / 2 + scipy.special.logit(share))
        share = float(np.clip(of_two.mean(), 1 / len(a), 1 - 1 / len(a)))
        f = float(((1 - of_two) @ (a**2 / V).mean(1)) / np.maximum((1 - of_two).sum(), np.finfo(float).tiny))
    a, V, added = a[:, :TREND], f * V[:, :TREND], added[:, :TREND]
    wider = _unlikelihood(a, V + NARROW * added) - _unlikelihood(a, V + added)
    return f, share, float(of_two @ wider) / 2  # (3)


def _unlikelihood(a: Floats, W: Floats) -> Floats:
    """(B) −2 ln N(a; 0, W) of coefficients (B, k), up to a constant."""
    return np.asarray(np.log(W).sum(1) + (a**2 / W).sum(1))


def residual(images: Images, F: Floats, one: Ints, other: Ints) -> tuple[Floats, Floats]:
    """e (n) px by (1) of `epipolar_noise` of images of two cameras, and s² (n) px² by (2) of it."""
    x, y = images.uv[one], images.uv[other]
    line, back = x @ F[:, :2].T + F[:, 2], y @ F[:2] + F[2]
    size, back_size = (line[:, :2] ** 2).sum(1), (back[:, :2] ** 2).sum(1)
    both = np.maximum((size + back_size) / 2, np.finfo(float).tiny)
    squared = (back_size * images.variance[one] + size * images.variance[other]) / both
    return ((line[:, :2] * y).sum(1) + line[:, 2]) / np.sqrt(both), squared


def blocks(frame: Ints, id: Ints) -> list[Ints]:
    """Places of blocks (n, length) of rows by track and frame: frames that follow each other, in parts of BLOCK."""
    new = begins(id, frame - np.arange(len(frame)))
    run = np.cumsum(new) - 1
    first, length = np.flatnonzero(new), np.bincount(run)
    parts = -(-length // BLOCK)
    part = (np.arange(len(frame)) - first[run]) * parts[run] // length[run]
    start = np.flatnonzero(begins(run, part))
    length = np.diff(np.append(start, len(frame)))
    return [start[length == n][:, None] + np.arange(n) for n in np.unique(length).tolist()]


@cache
def _polynomials(n: int) -> Floats:
    """p of (1), (n, k): orthonormal over n frames, of as many degrees as there are."""
    powers = np.vander(np.linspace(-1, 1, n), min(n, DEGREES), increasing=True)
    return np.asarray(np.linalg.qr(powers)[0])


def _coefficients(e: Floats) -> Floats:
    """a (B, k) of (1), of residuals (B, n) less m."""
    return np.asarray(e @ _polynomials(e.shape[1]))


def scores(e: Floats, reach: Floats, usual: Usual) -> Floats:
    """(2) of residuals (B, n) less m, with g² s² (B)."""
    n, a = e.shape[1], _coefficients(e)
    V = usual.variance(n)
    W = V + _added(n, reach, a.shape[1])
    return np.asarray((a**2 * (1 / V - 1 / W) - np.log(W / V)).sum(1) / 2)


def _added(n: int | Ints, reach: Floats, degrees: int) -> Floats:
    """W − V of (2), (B, k) px², of blocks of n frames, n or (B), with g² s² (B)."""
    return np.asarray((n * reach)[:, None] / 3 * 0.5 ** np.arange(1, degrees + 1))


def _parts_of_two(e: Floats, reach: float, usual: Usual) -> Bools:
    """The parts of residuals (n) less m, from the one of the highest score (2) on, that are above CERTAIN."""
    out, left = np.zeros(len(e), bool), [(0, len(e))]
    while left:
        first, last = left.pop()
        score, a, b = _worst(e[first:last], reach, usual)
        if score > CERTAIN:
            out[first + a : first + b] = True
            left += [(first, first + a), (first + b, last)]
    return out


def _worst(e: Floats, reach: float, usual: Usual) -> tuple[float, int, int]:
    """The highest score (2) of a part of residuals (n) less m, its first and last-plus-one."""
    best = (-np.inf, 0, 0)
    for n in range(len(e), 0, -1):
        windows = np.lib.stride_tricks.sliding_window_view(e, n)
        score = scores(windows, np.full(len(windows), reach), usual)
        k = int(score.argmax())
        best = max(best, (float(score[k]), k, k + n))
    return best
