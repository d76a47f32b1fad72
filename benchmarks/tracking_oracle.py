"""What no tracker can do better in the scenes of `tracking_scenes.py`, by the same centroids.

    python benchmarks/tracking_oracle.py 2100-2171          a line a scene, and how many scenes can meet the aims
    python benchmarks/tracking_oracle.py 5200-5260 --json F

The oracle is told what a tracker has to find: the true rig and noise, which images of a camera are one marker's, and
all that three cameras see, with what is at most AHEAD beside it in time. So it errs only where the images themselves
leave it open:

- *pieces of two cameras alone*, of one marker, are found where they are likelier so than by chance (1);
- *chance*: images of two markers, of merged ones, or false, that are left and fit each other as one marker's would in
  all frames in which both are there (1), move no faster than the markers and lie more than 10 mm from each;
- *merged images* count as such where a file marks them, where two of their markers are seen alone in this camera at
  most AHEAD before or after, or where one is known from other cameras. Others look like one marker's.

With z the epipolar residuals of a piece in standard deviations, its score is that of `drifting_pairs` (2),

    Σ ½ Σ_k (a_k² − a_k² / W_k − ln W_k)  over blocks of its frames,                      (1)

of two markers against one. Pieces of either kind are taken up to a score that is the best for each scene. Samples are
placed by the rig as its file states it, and found where that is near enough.

Aims that the oracle does not meet are out of reach of any tracker that goes by the places of images. Those that it
meets may be: it knows more than any tracker can.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
from scipy.ndimage import maximum_filter1d
from tracking_scenes import meets, numbers, share

from kinemark.data import Rig
from kinemark.data.array_types import Bools, Floats, Ints
from kinemark.geometry.camera import undistort_all
from kinemark.geometry.epipolar import fundamental
from kinemark.geometry.triangulate import refine, triangulate
from kinemark.track.simultaneous.ghosts.drifting_pairs import Usual, blocks, scores
from support.scenes import Made, Tally, make, scene
from support.scenes.tally import NEAR, OPEN

AHEAD = 0.12  # s that a marker is known beside what is seen of it; `Simultaneous.max_coasting`
GATE = 5.0  # standard deviations; `Simultaneous.gate`
ONE = Usual(median=0.0, white=1.0, lasting=np.zeros(4), factor=1.0, share=0.0, blocks=1, wide=0.0)  # of (1)


class Seen(NamedTuple):
    """Places (C, I, F, 2) px without the lens and NaN where not there, of I identities: M markers alone, then images
    that look like one marker's and are of more or none; and the detections (C, I, F), −1 for none."""

    uv: Floats
    detection: Ints


class Pieces(NamedTuple):
    """Of N pieces: the score (1), samples of two cameras that are gained, points that are ghosts."""

    score: Floats
    gained: Ints
    ghosts: Ints


def oracle(made: Made) -> Tally:
    """What can be found of a scene and the ghosts that go with it, as its aims are met best."""
    reach = max(round(AHEAD * made.scene.rate), 1)
    found, wanted = near_by_file(made), made.sd <= OPEN
    two, more = wanted & (made.own == 2), wanted & (made.own > 2)
    of = piece_numbers(made.own >= 2, reach)
    doubted = (of >= 0) & (np.bincount(of[made.own > 2], minlength=of.max() + 1) == 0)[of]
    seen = images_left(made, reach)
    pieces = true_pieces(made, seen, np.where(doubted, of, -1), two & found), chance(made, seen, reach)
    score, gained, ghosts = (np.concatenate(each) for each in zip(*pieces, strict=True))
    order = np.argsort(score)
    gains = (two & found & ~doubted).sum() + np.append(0, np.cumsum(gained[order]))
    counts = int(more.sum()), int((more & found).sum())
    tallies = [
        Tally(int(two.sum()), n, *counts, k, made.own.shape[1], *[0] * 6)
        for n, k in zip(gains.tolist(), np.append(0, np.cumsum(ghosts[order])).tolist(), strict=True)
    ]
    return max(tallies, key=lambda t: (meets(made.scene.cameras, t), t.two_found - t.ghosts))


def near_by_file(made: Made) -> Bools:
    """(M, F) whether the images of a marker alone and the rig as its file states it place it as near as is asked."""
    M, F = made.own.shape
    alone = of_one(made)
    uv = np.where(alone[..., None], made.detections.uv[made.image], np.nan).reshape(len(alone), M * F, 2)
    xyz = solved(made.rig, uv.swapaxes(0, 1)).reshape(M, F, 3)
    near = np.maximum(NEAR, 4 * np.minimum(np.where(np.isfinite(made.sd), made.sd, 0.0), OPEN))
    return np.asarray(np.linalg.norm(xyz - made.xyz, axis=-1) < near)


def solved(rig: Rig, uv: Floats) -> Floats:
    """(N, 3) mm, from places (N, C, 2) px in images of equal noise."""
    ideal = undistort_all(rig, uv)
    xyz = triangulate(ideal, np.stack([camera.P for camera in rig]))
    return refine(rig, xyz, uv, np.broadcast_to(np.eye(2), (*uv.shape, 2))).xyz


def of_one(made: Made) -> Bools:
    """(C, M, F) whether a camera has an image of a marker alone."""
    members = np.bincount(made.image[made.image >= 0], minlength=len(made.detections))
    return (made.image >= 0) & (members[made.image] == 1)


def near_in_time(there: Bools, reach: int) -> Bools:
    """Whether something is there (…, F) in a frame or at most `reach` frames beside it."""
    return maximum_filter1d(there.astype(np.uint8), 2 * reach + 1, axis=-1, mode="constant") > 0


def piece_numbers(there: Bools, reach: int) -> Ints:
    """(M, F) number of the piece of a sample, −1 where none is there; holes of up to `reach` frames part none."""
    of, n = np.full(there.shape, -1), 0
    for m, has in enumerate(there):
        f = np.flatnonzero(has)
        if len(f):
            part = np.cumsum(np.diff(f, prepend=f[0]) > reach)
            of[m, f] = n + part
            n += part[-1] + 1
    return of


def images_left(made: Made, reach: int) -> Seen:
    """Identities and where their images are."""
    alone = of_one(made)
    merged = unknown_blobs(made, alone, made.own >= 2, reach)
    columns = [np.where(alone, made.image, -1), *(group[:, None] for group in merged), *false_images(made)]
    detection = np.concatenate(columns, 1)
    return Seen(undistort_rows(made, detection), detection)


def false_images(made: Made) -> list[Ints]:
    """Detections (C, 1, F) that are of no marker, each an identity in its frame and camera alone."""
    (C, _, F), start = made.image.shape, made.detections.start
    out = []
    for c in range(C):
        rest = [np.setdiff1d(np.arange(*start[c, f : f + 2]), made.image[c, :, f]) for f in range(F)]
        for k in range(max(map(len, rest))):
            out.append(np.full((C, 1, F), -1))
            out[-1][c, 0] = [one[k] if k < len(one) else -1 for one in rest]
    return out


def undistort_rows(made: Made, detection: Ints) -> Floats:
    """(C, I, F, 2) px of detections without the true lens."""
    uv = np.where((detection >= 0)[..., None], made.detections.uv[detection], np.nan)
    flat = uv.reshape(len(uv), -1, 2).swapaxes(0, 1)
    return undistort_all(made.true, flat).swapaxes(0, 1).reshape(uv.shape)


def unknown_blobs(made: Made, alone: Bools, known: Bools, reach: int) -> list[Ints]:
    """Detections (C, F) of images of the same markers that nothing tells to be merged."""
    out: dict[tuple[int, ...], Ints] = {}
    nearby = near_in_time(alone, reach)
    common = (made.image >= 0) & ~alone & (not made.scene.optics.marked)
    for c, f in np.argwhere(common.any(1)).tolist():
        m = np.flatnonzero(common[c, :, f])
        for d in np.unique(made.image[c, m, f]):
            group = m[made.image[c, m, f] == d]
            if not known[group, f].any() and nearby[c, group, f].sum() < 2:
                out.setdefault(tuple(group.tolist()), np.full((len(alone), alone.shape[2]), -1))[c, f] = d
    return list(out.values())


def true_pieces(made: Made, seen: Seen, of: Ints, gained: Bools) -> Pieces:
    """Pieces (M, F) of one marker in two cameras alone."""
    alone = of_one(made)
    n = int(of.max(initial=-1)) + 1
    score = np.zeros(n)
    for a, b in combinations(range(len(alone)), 2):
        m, f = np.nonzero((of >= 0) & alone[a] & alone[b])
        if len(m):
            z = standard_residual(made, a, b, seen.uv[a, m, f], seen.uv[b, m, f])
            for block in blocks(f, of[m, f]):
                np.add.at(score, of[m, f][block[:, 0]], scores(z[block], np.full(len(block), GATE**2), ONE))
    there = np.unique(of[of >= 0])
    return Pieces(score[there], np.bincount(of[gained & (of >= 0)], minlength=n)[there], np.zeros(len(there), int))


def standard_residual(made: Made, a: int, b: int, one: Floats, other: Floats) -> Floats:
    """(n) epipolar residuals of places (n, 2) px of two cameras in standard deviations, by the true rig."""
    F = fundamental(made.true[a].P, made.true[b].P)
    x, y = (np.column_stack([uv, np.ones(len(uv))]) for uv in (one, other))
    line, back = x @ F.T, y @ F
    size = np.sqrt((line[:, :2] ** 2).sum(1) + (back[:, :2] ** 2).sum(1))
    return np.asarray((line * y).sum(1) / size / made.scene.optics.noise)


class Chance(NamedTuple):
    """A piece of two images that are no one marker's: score (1), and its pairs of detections that make ghosts."""

    score: float
    pairs: list[list[int]]


def chance(made: Made, seen: Seen, reach: int) -> Pieces:
    """Pieces of images that are left, of no one marker; each image is in the likeliest alone."""
    M, left = len(made.own), seen.detection >= 0
    left[:, :M] &= ~near_in_time(made.own >= 2, reach)
    pairs = combinations(range(len(left)), 2)
    found = [one for a, b in pairs for one in chance_of_two(made, seen, left, a, b, reach)]
    used: set[int] = set()
    ghosts = []
    for one in (found := sorted(found, key=lambda one: one.score)):
        free = [pair for pair in one.pairs if not used.intersection(pair)]
        used.update(d for pair in free for d in pair)
        ghosts.append(len(free))
    return Pieces(np.array([one.score for one in found]), np.zeros(len(found), int), np.array(ghosts, int))


def chance_of_two(made: Made, seen: Seen, left: Bools, a: int, b: int, reach: int) -> Iterator[Chance]:
    """Pieces of images of cameras a and b that may be one marker's by all frames in which both are there."""
    there = seen.detection >= 0
    both = left[a].astype(np.float32) @ left[b].T.astype(np.float32) > 0
    both[np.diag_indices(len(made.own))] = False
    for p, q in np.argwhere(both).tolist():
        f = np.flatnonzero(there[a, p] & there[b, q])
        z = standard_residual(made, a, b, seen.uv[a, p, f], seen.uv[b, q, f])
        for part in np.split(np.arange(len(f)), np.flatnonzero(np.diff(f) > reach) + 1):
            if np.abs(z[part]).max() > GATE:
                continue
            at = f[part][left[a, p, f[part]] & left[b, q, f[part]]]
            pairs = np.column_stack([seen.detection[a, p, at], seen.detection[b, q, at]])
            ghosts = ghosts_of(made, a, b, pairs, at)
            if ghosts.any():
                n = np.zeros(len(part), int)
                each = [scores(z[part][block], np.full(len(block), GATE**2), ONE) for block in blocks(f[part], n)]
                yield Chance(float(np.concatenate(each).sum()), pairs[ghosts].tolist())


def ghosts_of(made: Made, a: int, b: int, pairs: Ints, frame: Ints) -> Bools:
    """(n) which points of detections (n, 2) in frames (n) are no marker's; none where they are behind a camera, or
    faster than every marker."""
    two = Rig((made.true[a], made.true[b]), made.true.method)
    xyz = solved(two, made.detections.uv[pairs])
    ahead = np.all([(xyz @ camera.R.T + camera.t)[:, 2] > 0 for camera in two])
    fastest = np.linalg.norm(np.diff(made.xyz, axis=1), axis=-1).max(initial=0.0)
    step = np.linalg.norm(np.diff(xyz, axis=0), axis=1) / np.diff(frame)
    likely = ahead and not (len(step) and np.median(step) > fastest)
    return np.asarray((np.linalg.norm(made.xyz[:, frame] - xyz, axis=-1).min(0) > NEAR) & likely)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seeds", nargs="+", help="such as 3 or 40-49")
    parser.add_argument("--json", type=Path, help="and write the counts of each scene")
    asked = parser.parse_args()
    print(f"{'two':>8s}{'more':>8s}{'ghosts':>8s}\n{'%':>8s}{'%':>8s}{'/frame':>8s}")
    done, good = {}, 0
    for one in (scene(seed) for seed in numbers(asked.seeds)):
        t = oracle(make(one))
        can = meets(one.cameras, t)
        good += can
        done[one.seed] = t._asdict()
        print(
            f"{share(t.two_found, t.two):8.2f}{share(t.more_found, t.more):8.2f}{t.ghosts / t.frames:8.3f}  "
            f"{'' if can else 'out of reach: '}{one}",
            flush=True,
        )
    print(f"aims can be met in {good} of {len(done)}")
    if asked.json:
        asked.json.write_text(json.dumps(done))


if __name__ == "__main__":
    main()
