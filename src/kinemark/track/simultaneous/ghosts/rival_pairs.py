"""Rival pairs: what else two images of a track may be, and which of the two is likelier.

Where two cameras alone see a marker, the images of two markers now and then lie on each other's epipolar lines for as
long as both move alike, so no motion, and no distance to other markers, tells such a pair from a marker. But one of its
images has often its true partner, which no track has. A stretch of a track is a run of frames in which the same two
cameras see it, and no other; merged images do not count, as one of both markers fits their meeting too. For either
image of a stretch, the free images of each other camera that lie near its lines are chained from frame to frame,

    r₁ r₂ … : the image nearest to 2 r₂ − r₁, where the three points fit one motion by (1) of `initiate`        (1)

and a chain that has MIN_COVERED of the frames of the stretch is a rival. With q and q′ the squared distances of the
two images of the stretch and of the rival, in standard deviations, from the point that fits them best, and Student's
t of `likelihood`,

    score = Σ ln t(q′) − ln t(q)                                                          (2)

over the frames of the chain is the log-likelihood ratio, if images are as noisy as they say, and what is off is new in
every frame. Neither is quite so: many frames of a rival with a little less noise, or where the calibration leaves less,
add up to much. The score (2) of `drifting_pairs` knows what is usual of two cameras, and of each block only how it
drifts. Where it judges the images of both,

    score(stretch) − score(rival)                                                         (3)

stands for (2). A stretch with a rival of more than `likelihood.SURE` by (2), and by (3), is given up: its rivals become
tracks of their own, what comes before and after it becomes two tracks, and stitching decides which of these go on as
which.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....data.array_types import Bools, Floats, Ints
from ....numerics.robust import student_log_likelihood
from ....numerics.runs import equal_runs
from ..detection_index import Images
from ..following.candidate_points import batches, intersect, near_lines
from ..following.likelihood import DEGREES_OF_FREEDOM, SURE
from ..following.passes import Associations
from ..simultaneous_method import Simultaneous
from .drift_of_runs import scores_of_runs
from .drifting_pairs import usual_residuals

MIN_COVERED = 0.3
"""Share of the frames of a stretch that a rival has at least; chosen (see benchmarks/tracking_scenes.py)."""

MIN_FRAMES = 4
"""Frames of a stretch, and of a rival, at least: fewer make no track; chosen."""


class Rivals(NamedTuple):
    """H pairs of images, one `kept` of a stretch and one `free`: indices in `Images`; row of the stretch's association;
    squared (H) of the two images and xyz (3, H) mm, cov (3, 3, H) mm² of their point."""

    row: Ints
    kept: Ints
    free: Ints
    squared: Floats
    xyz: Floats
    cov: Floats

    def take(self, which: Bools | Ints) -> Rivals:
        """Only these."""
        return Rivals(
            self.row[which],
            self.kept[which],
            self.free[which],
            self.squared[which],
            self.xyz[:, which],
            self.cov[..., which],
        )


class Rivalled(NamedTuple):
    """Associations in which rivals, as tracks of their own, stand for the stretches that they are likelier than; and
    the cuts (K, 3) of the tracks that had these: track, last frame before the cut, the number of what comes after it,
    later cuts first."""

    associations: Associations
    cuts: Ints

    def pieces(self, id: Ints, frame: Ints) -> Ints:
        """The piece that tracks id (N) are in frame (N)."""
        id = id.copy()
        for track, last, number in self.cuts.tolist():
            id[(id == track) & (frame > last)] = number
        return id

    def whole(self) -> Ints:
        """The track that each piece is of."""
        number = max(int(self.associations.id.max(initial=-1)), int(self.cuts[:, 2].max(initial=-1))) + 1
        whole = np.arange(number)
        whole[self.cuts[:, 2]] = self.cuts[:, 0]
        return whole


def without_rivalled(
    columns: list[NDArray[Any]], images: Images, F: Floats, T: float, method: Simultaneous
) -> Rivalled:
    """Associations of these columns with rivals in place of stretches that are less likely.

    The list is empty afterwards, so that no column is in memory twice.
    """
    every = Associations(*columns)
    alone = images.own(every.detection)
    stretch = stretches(every.frame, every.id, alone)
    held = every.detection[:, (every.detection >= 0).sum(0) >= 2]
    free = images.usable.copy()
    free[held[held >= 0]] = False
    taken = np.zeros(len(free), bool)
    rivals = near_rivals(every.frame, alone, stretch, images, free, F, method.gate)
    own = _squared(images, alone, np.flatnonzero(stretch >= 0))
    won: list[Rivals] = []
    gone: list[Ints] = []
    likelier = _by_drift(_chains(rivals, stretch, own, images, T, method), rivals, every, images, method.gate)
    for chain in likelier:
        if free[rivals.free[chain]].all() and not taken[rivals.kept[chain]].any():
            free[rivals.free[chain]], taken[rivals.kept[chain]] = False, True
            won.append(rivals.take(chain))
            gone.append(_given_up(every.frame, stretch, won[-1].row))
    number = int(every.id.max(initial=-1)) + 1
    new = [_as_associations(rival, every, images, number + k) for k, rival in enumerate(won)]
    cuts = _cuts(every, gone, number + len(won))
    del every
    return Rivalled(_replaced(columns, new, gone), cuts)


def stretches(frame: Ints, id: Ints, detection: Ints, least: int = MIN_FRAMES) -> Ints:
    """(S) the stretch of `least` frames and more of each point of tracks id (S), of detection (C, S); −1 for none."""
    has = detection >= 0
    rows = np.flatnonzero(has.sum(0) == 2)
    pair = has[:, rows].argmax(0) * len(has) + len(has) - has[::-1, rows].argmax(0)
    order = np.lexsort([frame[rows], id[rows]])
    rows, pair = rows[order], pair[order]
    run = np.arange(len(rows)) - frame[rows]
    cuts = equal_runs(id[rows], pair, run)
    out = np.full(len(id), -1)
    number = np.repeat(np.arange(len(cuts) - 1), np.diff(cuts))
    out[rows] = np.where(np.diff(cuts)[number] >= least, number, -1)
    return out


def _squared(images: Images, detection: Ints, rows: Ints) -> Floats:
    """(S) the squared distances of the images of some rows of detection (C, S), NaN of the others."""
    out = np.full(detection.shape[1], np.nan)
    found = intersect(images, detection[:, rows]).squared
    out[rows] = np.where(detection[:, rows] >= 0, found, 0.0).sum(0)
    return out


def near_rivals(
    frame: Ints, detection: Ints, stretch: Ints, images: Images, free: Bools, F: Floats, gate: float
) -> Rivals:
    """All pairs of an image of a stretch (S), of detection (C, S), and a free one that lie near each other's lines."""
    rows = np.flatnonzero(stretch >= 0)
    row_of = np.full(len(images.uv), -1, np.int32)  # in four bytes: long recordings have many images
    for camera in detection[:, rows]:
        row_of[camera[camera >= 0]] = rows[camera >= 0]
    some = free | (row_of >= 0)
    frames = np.unique(frame[rows]).tolist()
    looked_at = [own[some[own]] for own in images.in_frames(frames)]
    pair = np.concatenate([near_lines(images, part, F, gate) for part in batches(looked_at)], -1)
    pair = np.concatenate([pair, pair[::-1]], -1)
    pair = pair[:, (row_of[pair[0]] >= 0) & free[pair[1]]]
    point = intersect(images, pair, images.camera[pair])
    squared = point.squared.sum(0)
    good = (squared < gate**2) & np.isfinite(point.xyz).all(0) & np.isfinite(point.cov).all((0, 1))
    return Rivals(row_of[pair[0]].astype(np.int64), pair[0], pair[1], squared, point.xyz, point.cov).take(good)


def _chains(
    rivals: Rivals, stretch: Ints, own: Floats, images: Images, T: float, method: Simultaneous
) -> list[tuple[float, Ints]]:
    """Scores (2) of rivals that are likelier than their stretches, of associations own (S), and their pairs."""
    length = np.bincount(stretch[stretch >= 0], minlength=1)
    number, kept, free = stretch[rivals.row], images.camera[rivals.kept], images.camera[rivals.free]
    order = np.lexsort([images.frame[rivals.kept], free, kept, number])
    cuts = equal_runs(number[order], kept[order], free[order])
    found = []
    for a, b in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
        group = order[a:b]
        least = max(MIN_COVERED * length[number[group[0]]], MIN_FRAMES)
        if len(np.unique(images.frame[rivals.kept[group]])) < least:
            continue
        chain = _longest(rivals, group, images, T, method)
        score = _log_likelihood(rivals.squared[chain]) - _log_likelihood(own[rivals.row[chain]])
        if len(chain) >= least and score > SURE:
            found.append((score, chain))
    return found


def _by_drift(
    found: list[tuple[float, Ints]], rivals: Rivals, every: Associations, images: Images, gate: float
) -> list[Ints]:
    """The pairs of the rivals that are likelier by (3) too, the likeliest first."""
    if not found:
        return []
    score, chains = np.array([one for one, _ in found]), [chain for _, chain in found]
    of, pair = np.repeat(np.arange(len(found)), [len(chain) for chain in chains]), np.concatenate(chains)
    frame, kept, free = (column[pair] for column in (images.frame[rivals.kept], rivals.kept, rivals.free))
    held = np.sort(images.own(every.detection[:, rivals.row[pair]]), axis=0)[-2:]
    usual = usual_residuals(every.frame, every.id, every.detection, images, gate)
    stretch = scores_of_runs(held, frame, of, len(found), images, usual, gate)
    rival = scores_of_runs(np.stack([kept, free]), frame, of, len(found), images, usual, gate)
    judged = (stretch != 0) & (rival != 0)
    score[judged] = (stretch - rival)[judged]
    return [chains[k] for k in np.argsort(-score, kind="stable") if score[k] > SURE]


def _log_likelihood(squared: Floats) -> float:
    """Σ ln t of (2), but for a constant."""
    return float(student_log_likelihood(squared, DEGREES_OF_FREEDOM, np.ones(len(squared))).sum())


def _longest(rivals: Rivals, group: Ints, images: Images, T: float, method: Simultaneous) -> Ints:
    """The longest chain (1) of a group of pairs, by frame."""
    at: dict[int, list[int]] = defaultdict(list)
    for pair in group.tolist():
        at[int(images.frame[rivals.kept[pair]])].append(pair)
    best: list[int] = []
    used: set[int] = set()
    for pair in group.tolist():
        if pair in used:
            continue
        chain = [pair]
        while (after := _next(rivals, chain, at, images, T, method)) is not None and after not in used:
            chain.append(after)
        used.update(chain)
        best = chain if len(chain) > len(best) else best
    return np.array(best)


def _next(
    rivals: Rivals, chain: list[int], at: dict[int, list[int]], images: Images, T: float, method: Simultaneous
) -> int | None:
    """The pair by (1) that goes on a chain."""
    uv = images.uv[rivals.free[chain[-2:]]]
    towards = 2 * uv[-1] - uv[0]
    options = at.get(int(images.frame[rivals.kept[chain[-1]]]) + 1, [])
    options = [pair for pair in options if len(chain) < 2 or _fits(rivals, [*chain[-2:], pair], T, method)]
    far = [float(np.hypot(*(images.uv[rivals.free[pair]] - towards))) for pair in options]
    return options[int(np.argmin(far))] if far else None


def _fits(rivals: Rivals, three: list[int], T: float, method: Simultaneous) -> bool:
    """Whether three points are one motion."""
    bend = rivals.xyz[:, three] @ [1.0, -2.0, 1.0]
    S = rivals.cov[..., three] @ [1.0, 4.0, 1.0] + (method.acceleration_sd * T * T) ** 2 * np.eye(3)
    return bool(bend @ np.linalg.solve(S, bend) < method.gate**2)


def _given_up(frame: Ints, stretch: Ints, row: Ints) -> Ints:
    """The rows of a stretch that go with those of its rival (n): on either side the rest, where it is shorter."""
    rows = np.flatnonzero(stretch == stretch[row[0]])
    first, last = int(frame[row].min()), int(frame[row].max())
    before, after = frame[rows] < first, frame[rows] > last
    stays = (before & (before.sum() >= len(row))) | (after & (after.sum() >= len(row)))
    return rows[~stays]


def _replaced(columns: list[NDArray[Any]], new: list[Associations], gone: list[Ints]) -> Associations:
    """The associations of these columns without the rows `gone`, and with the rivals; the list is empty afterwards."""
    kept = np.ones(columns[0].shape[-1], bool)
    kept[np.concatenate([np.zeros(0, np.int64), *gone])] = False
    more = list(zip(*new, strict=True)) or [()] * len(columns)
    return Associations(*(np.concatenate([columns.pop(0)[..., kept], *each], -1) for each in more))


def _cuts(every: Associations, gone: list[Ints], number: int) -> Ints:
    """`Rivalled.cuts` where the rows `gone` were; what comes after them is numbered from `number` on."""
    last = {(int(every.id[rows[0]]), int(every.frame[rows].max())) for rows in gone}
    latest_first = sorted(last, key=lambda cut: -cut[1])
    return np.array([(*cut, number + k) for k, cut in enumerate(latest_first)], np.int64).reshape(-1, 3)


def _as_associations(rival: Rivals, every: Associations, images: Images, id: int) -> Associations:
    """A rival as a track."""
    n = len(rival.row)
    detection = np.full((len(every.detection), n), -1, every.detection.dtype)
    for each in (rival.kept, rival.free):
        detection[images.camera[each], np.arange(n)] = each
    sd = np.sqrt(np.trace(rival.cov))
    none = np.zeros(detection.shape, bool)
    return Associations(
        every.frame[rival.row], np.full(n, id), detection, none, rival.squared, sd, rival.xyz, rival.cov
    )
