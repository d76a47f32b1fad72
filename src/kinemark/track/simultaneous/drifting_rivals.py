"""Chance meetings of two images, told by what else these are: images of two markers that no track has.

Where two cameras alone see a track whose images are two markers', each of them often has its true partner in another
camera, which no track has, as its own image is taken. `rival_pairs` asks how well each fits from frame to frame; but a
meeting that lasts fits well, and that it drifts a little, `drifting_pairs` alone can not be sure of. A stretch is a run
of frames in which the same two cameras a and b see a track, and no other. For either of its images, the free images of
each other camera near its lines are linked from frame to frame, each to the one that is nearest in both directions,
while three of their points fit one motion (1). Such pieces of LEAST frames and more, which together have MIN_COVERED of
the frames of the stretch, are a rival r_a or r_b, unless its points lie within APART standard deviations of those of
the stretch: it is then of the same marker. With the score (2) of `drifting_pairs`, the log-likelihood ratio of two
markers to one,

    S = score(a, b) − score(a, r_a) − score(b, r_b)                                       (2)

says how much likelier two markers are, each with its rival, than one and two chance meetings; where one image alone
has a rival, without the other's. Hardly any stretch of a marker has a rival, but most that are two markers' do: so a
stretch of more than `likelihood.SURE` is given up, from the first frame of its rivals to their last.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...native import inverse
from ...numerics.returned_memory import return_memory
from ...numerics.runs import begins, equal_runs
from .candidate_points import intersect
from .detection_index import Images
from .drift_of_runs import scores_of_pair, scores_of_runs
from .drifting_pairs import UsualResiduals, residual, shared_shift
from .likelihood import SURE
from .rival_pairs import Rivals, near_rivals, stretches
from .simultaneous_method import Simultaneous

LEAST = 6
"""Frames of a stretch, and of a piece of a rival, a number; chosen: of four or five, all fit (137010, 141068 of
benchmarks/tracking_scenes.py: S of markers up to 5.1)."""

MIN_COVERED = 0.5
"""Share of the frames of a stretch that a rival has at least; chosen: what it is in the other half does not count."""

APART = 3.0
"""Standard deviations; chosen: with 2 a whole track of a marker is given up whose calibration keeps four of its images
apart (141065), with 5 a chance meeting that lies 40 mm beside its rivals stays (141068)."""


class _Pieces(NamedTuple):
    """K pieces, by stretch and cameras: the stretch (K), camera of its image and of the rival's (K), score (K) of
    `drifting_pairs`. Of their H frames, by piece: the piece (H), row of the stretch's point (H), its image (H) and the
    free one (H)."""

    stretch: Ints
    kept: Ints
    free: Ints
    score: Floats
    of: Ints
    row: Ints
    own: Ints
    image: Ints


class _Rival(NamedTuple):
    """Of the image of one camera of a stretch: free images (n), and their score with it."""

    kept: int
    images: Ints
    score: float


def with_rivals(
    frame: Ints, id: Ints, detection: Ints, images: Images, usual: UsualResiduals, T: float, method: Simultaneous
) -> Bools:
    """(P) the points of tracks id (P), of detections (C, P), that are given up for rivals; frames are T s apart."""
    usual = usual_of_two(id, detection, images, usual)
    stretch = stretches(frame, id, detection, LEAST)
    own = _own_scores(frame, detection, stretch, images, usual, method.gate)
    stretch = np.where(np.isfinite(np.append(own, np.nan))[stretch], stretch, -1)
    free = images.usable & ~images.merged
    free[detection[detection >= 0]] = False
    return_memory()
    rivals = near_rivals(frame, detection, stretch, images, free, usual.F, method.gate)
    pieces = _scored(_pieces(rivals, detection, stretch, images, T, method), images, usual, method.gate)
    length, lost = np.bincount(stretch + 1)[1:], np.zeros(len(stretch), bool)
    for k in np.unique(pieces.stretch).tolist():
        more, seen = _more(own[k], _rivals_of(pieces, k, MIN_COVERED * length[k]))
        if more > SURE:
            at = images.frame[seen]
            lost |= (stretch == k) & (frame >= at.min()) & (frame <= at.max())
    return lost


def usual_of_two(id: Ints, detection: Ints, images: Images, usual: UsualResiduals) -> UsualResiduals:
    """What is usual where two cameras see tracks alone, by (4) of `drifting_pairs`."""
    has = (detection >= 0) & ~images.merged[detection]
    two, known = (detection >= 0).sum(0) == 2, {}
    for (a, b), one in usual.of.items():
        rows = np.flatnonzero(two & has[a] & has[b])
        e = residual(images, usual.F[a, b], detection[a, rows], detection[b, rows])[0]
        known[a, b] = one.shifted(shared_shift(e - one.median, id[rows], images.uv[detection[a, rows]]))
    return usual._replace(of=known)


def _own_scores(
    frame: Ints, detection: Ints, stretch: Ints, images: Images, usual: UsualResiduals, gate: float
) -> Floats:
    """(N) score(a, b) of (2) of each stretch, NaN where its cameras are not judged, or an image is merged."""
    out = np.full(int(stretch.max(initial=-1)) + 1, np.nan)
    has = detection >= 0
    for a, b in usual.of:
        rows = np.flatnonzero(has[a] & has[b] & (stretch >= 0))
        rows = rows[np.lexsort([frame[rows], stretch[rows]])]
        both = detection[[a, b]][:, rows]
        some = np.unique(stretch[rows])
        out[some] = scores_of_pair(frame[rows], stretch[rows], both, images, usual, (a, b), gate)[some]
        out[stretch[rows[images.merged[both].any(0)]]] = np.nan
    return out


def _pieces(rivals: Rivals, detection: Ints, stretch: Ints, images: Images, T: float, method: Simultaneous) -> _Pieces:
    """The pieces by (1) of LEAST frames and more, of other markers than their stretches, without scores."""
    frame, number = images.frame[rivals.kept], stretch[rivals.row]
    kept, free = images.camera[rivals.kept], images.camera[rivals.free]
    order = np.lexsort([frame, free, kept, number])
    group = np.cumsum(begins(number[order], kept[order], free[order]), dtype=np.int64)
    of = np.empty(len(order), np.int64)
    of[order] = _linked(rivals.take(order), frame[order], group, images, T, method)
    K = int(of.max(initial=-1)) + 1
    many, same = np.bincount(of, minlength=K), _same_place(rivals, detection, images)
    some = np.flatnonzero(((many >= LEAST) & (2 * np.bincount(of, same, K) < many))[of])
    some = some[np.lexsort([frame[some], of[some]])]
    first = begins(of[some])
    one, of = some[first], np.cumsum(first) - 1
    score = np.zeros(len(one))
    return _Pieces(number[one], kept[one], free[one], score, of, rivals.row[some], rivals.kept[some], rivals.free[some])


def _scored(pieces: _Pieces, images: Images, usual: UsualResiduals, gate: float) -> _Pieces:
    """The pieces with their scores, 0 of cameras that are not judged."""
    pair, frame = np.stack([pieces.own, pieces.image]), images.frame[pieces.own]
    return pieces._replace(score=scores_of_runs(pair, frame, pieces.of, len(pieces.score), images, usual, gate))


def _same_place(rivals: Rivals, detection: Ints, images: Images) -> Bools:
    """(H) whether the point of each pair is where that of both images of the stretch is."""
    row, which = np.unique(rivals.row, return_inverse=True)
    own = intersect(images, detection[:, row])
    off = rivals.xyz - own.xyz[:, which]
    N = inverse(rivals.cov + own.cov[..., which])
    return np.asarray(np.einsum("it,ijt,jt->t", off, N, off) < APART**2)


def _linked(rivals: Rivals, frame: Ints, group: Ints, images: Images, T: float, method: Simultaneous) -> Ints:
    """(H) the piece by (1) of each of the pairs by group and frame."""
    key = group * (images.n_frames + 1) + frame
    low, n = np.searchsorted(key, key + 1), np.arange(len(key))
    many = np.searchsorted(key, key + 1, "right") - low
    one = np.repeat(n, many)
    other = np.arange(len(one)) - np.repeat(np.cumsum(many) - many - low, many)
    apart = np.hypot(*(images.uv[rivals.free[one]] - images.uv[rivals.free[other]]).T)
    nearest = _nearest(one, apart) & _nearest(other, apart)
    before = n.copy()
    before[other[nearest]] = one[nearest]
    three = np.stack([before[before], before, n])
    three = three[:, (three[0] != three[1]) & (three[1] != three[2])]
    broken = three[2, ~_fits(rivals, three, T, method)]
    before[broken] = broken
    while ((again := before[before]) != before).any():
        before = again
    return np.unique(before, return_inverse=True)[1]


def _nearest(row: Ints, apart: Floats) -> Bools:
    """(n) whether each is the nearest of its row."""
    order = np.lexsort([apart, row])
    out = np.zeros(len(row), bool)
    out[order[begins(row[order])]] = True
    return out


def _fits(rivals: Rivals, three: Ints, T: float, method: Simultaneous) -> Bools:
    """(n) whether three points (3, n) are one motion, by (1) of `initiate`."""
    weight = np.array([1.0, -2.0, 1.0])
    bend = np.einsum("ikt,k->it", rivals.xyz[:, three], weight)
    S = np.einsum("ijkt,k->ijt", rivals.cov[..., three], weight**2)
    S += (method.acceleration_sd * T * T) ** 2 * np.eye(3)[..., None]
    return np.asarray(np.einsum("it,ijt,jt->t", bend, inverse(S), bend) < method.gate**2)


def _rivals_of(pieces: _Pieces, k: int, least: float) -> list[_Rival]:
    """The rivals of stretch k, of `least` frames and more: of two cameras, the best pieces that share no frame."""
    mine = np.flatnonzero((pieces.stretch == k) & (pieces.score < 0))
    mine = mine[np.lexsort([pieces.score[mine], pieces.free[mine], pieces.kept[mine]])]
    cuts, out = equal_runs(pieces.kept[mine], pieces.free[mine]), []
    for a, b in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
        rows, total = np.zeros(0, np.int64), 0.0
        for piece in mine[a:b].tolist():
            own = np.arange(*np.searchsorted(pieces.of, [piece, piece + 1]))
            if not np.isin(pieces.row[own], pieces.row[rows]).any():
                rows, total = np.append(rows, own), total + float(pieces.score[piece])
        if len(rows) >= least:
            out.append(_Rival(int(pieces.kept[mine[a]]), pieces.image[rows], total))
    return out


def _more(own: float, rivals: list[_Rival]) -> tuple[float, Ints]:
    """The greatest S of (2), by one rival or by one of either image, and their images; −inf where there are none."""
    best = [(own - one.score, one.images) for one in rivals]
    for k, one in enumerate(rivals):
        for other in rivals[:k]:
            if one.kept != other.kept and not np.isin(one.images, other.images).any():
                best.append((own - one.score - other.score, np.append(one.images, other.images)))
    return max(best, key=lambda each: each[0], default=(-np.inf, np.zeros(0, np.int64)))
