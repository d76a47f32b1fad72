"""Merged images in files that do not mark them: known by the images of one camera alone, without any track.

Images go on in the next frame in the one that lies nearest to y + v, v being their step from the frame before, if that
one's nearest is they, within FARTHEST (1). With r px below which two markers are one image (`unmarked_merging`), two
images a and b less than 2 NEAR r apart have run together where a goes on nowhere, no image without a past lies within
r of y_a + v_a, and b goes on in an image that lies between y_a + v_a and y_b + v_b,

    least < c < 1 − least,   |d| < ACROSS L + 1,   LEAST r < L < NEAR r                    (2)

with L the distance of both, c L how far it lies along it, and d how far beside it. That image and those in which it
goes on are of both, until one without a past is born within NEAR r of them. Backwards in time the same holds of images
that come apart. Where one of the two vanishes behind a limb, the image jumps from the middle of both to the other, by
more than

    |y′ − y − v| = JUMP r + 2 m                                                              (3)

with y′ the image in which y goes on, v at first the mean step of a and b, and m the median of |y′ − y − v|. From there
on it is of one. What both ways tell within LONGEST frames is merged, and so are the first MOST frames after either:
later, one of the two is often hidden, and its image does not always jump.

The tracker gives these images the variance (r / 4)², as they lie anywhere within r / 2 of either marker. What tracks
tell of others (`unmarked_merging`) comes on top of it.
"""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ....native import candidates
from ....numerics.runs import equal_runs
from ..detection_index import Images

FARTHEST = 15.0
"""px of (1); chosen: images that move by more from what they did before are hardly told from others'."""
ROUNDS = 3
"""Of (1), each with the steps of the one before; chosen: a fourth changes no step."""
NEAR, LEAST = 1.8, 0.3
"""Of (2), in r; chosen: markers come nearer by some of their distance a frame; nearer ones were one image before."""
BETWEEN, ACROSS = 0.2, 0.25
"""Of (2), least and ACROSS, shares of L; chosen: common images lie in the middle, by a tenth of it."""
SURE = 0.25
"""Up to which share of r images lie beside y + v, in the median; chosen: more of where both were going is not known,
and images of a plate at 10 Hz (0.8) were marked that are of one marker. Scenes in which it finds merging have 0.2."""
JUMP = 0.1
"""Of (3), in r; chosen: of images beyond such a jump two to six in a hundred are merged ones, on eight scenes of four
cameras (700042 to 860129)."""
LONGEST, MOST = 20, 8
"""Frames; chosen: of images up to MOST after a merging four in five are merged ones, of later ones
hardly more than half, but for those up to LONGEST from merging and from parting, of which five in six are."""


class _Links(NamedTuple):
    """Rows (D) in which images go on, and from which they come; −1 for none."""

    on: Ints
    back: Ints

    def reversed(self) -> _Links:
        """The same with time backwards."""
        return _Links(self.back, self.on)


def merged_in_images(images: Images, r: float) -> Bools:
    """(D) whether an image is of two markers, where those nearer than r px are one."""
    links = _linked(images)
    error = _step_error(images, links)
    if error > SURE * r:
        return np.zeros(len(images.uv), bool)
    jump = JUMP * r + 2 * error  # (3)
    after, before = (_since(images, of, way, r, jump) for of, way in ((links, 1), (links.reversed(), -1)))
    soon = [(age >= 0) & (age < MOST) for age in (after, before)]
    return np.asarray(((after >= 0) & (before >= 0)) | soon[0] | soon[1])


def _linked(images: Images) -> _Links:
    """By (1)."""
    rows = cast(Ints, np.asarray(images.by_cell.order).astype(np.int64))
    D = len(images.uv)
    links = _Links(np.full(D, -1), np.full(D, -1))
    for _ in range(ROUNDS):
        ahead = _nearest(images, rows, 1, images.uv[rows] + _steps(images, links, rows))
        behind = _nearest(images, rows, -1, images.uv[rows] + _steps(images, links.reversed(), rows))
        goes, came = np.full((2, D), -1)
        goes[rows], came[rows] = ahead, behind
        on = np.where((goes >= 0) & (came[goes] == np.arange(D)), goes, -1)
        back = np.full(D, -1)
        back[on[on >= 0]] = np.flatnonzero(on >= 0)
        links = _Links(on, back)
    return links


def _steps(images: Images, links: _Links, rows: Ints) -> Floats:
    """(n, 2) px of images, from the frame before or else to the one after; 0 where they have neither."""
    on, back = links.on[rows, None], links.back[rows, None]
    uv = images.uv[rows]
    ahead = np.where(on >= 0, images.uv[on[:, 0]] - uv, 0.0)
    return np.where(back >= 0, uv - images.uv[back[:, 0]], ahead)


def _step_error(images: Images, links: _Links) -> float:
    """px, the median of how far images lie beside y + v; infinite where none goes on."""
    rows = np.flatnonzero((links.on >= 0) & (links.back >= 0))
    if not len(rows):
        return np.inf
    beside = images.uv[links.on[rows]] - images.uv[rows] - _steps(images, links, rows)
    return float(np.median(np.hypot(*beside.T)))


def _nearest(images: Images, rows: Ints, step: int, place: Floats) -> Ints:
    """(n) of the images in the frame `step` later those nearest to places (n, 2) px, within FARTHEST; −1 for none."""
    cell, inside = _cells(images, rows, step)
    alike, nothing, reach = np.ones(len(images.uv)), np.zeros((3, len(rows))), np.full(len(rows), FARTHEST)
    query, row, squared, _ = candidates(
        images.by_cell, alike, images.usable, cell, place.T, nothing, reach, gate=FARTHEST**2
    )
    cuts, out = equal_runs(query), np.full(len(rows), -1)
    least = np.repeat(np.minimum.reduceat(squared, cuts[:-1]), np.diff(cuts)) if len(query) else squared
    nearest = np.flatnonzero((squared == least) & inside[query])[::-1]  # the first of equal ones stays
    out[query[nearest]] = row[nearest]
    return out


def _cells(images: Images, rows: Ints, step: int) -> tuple[Ints, Bools]:
    """(n) the cells of images' cameras `step` frames later, and whether there is such a frame."""
    frame = images.frame[rows].astype(np.int64) + step
    inside = (frame >= 0) & (frame < images.n_frames)
    return np.where(inside, frame, 0) * len(images.P) + images.camera[rows], inside


def _since(images: Images, links: _Links, step: int, r: float, jump: float) -> Ints:
    """(D) frames since two images ran together in each, fewer than LONGEST; −1 where they did not."""
    age, (now, v) = np.full(len(images.uv), -1), _begins(images, links, step, r)
    for n in range(LONGEST):
        if n:
            parted = _parted(images, links, now, r)
            now, v = now[~parted], v[~parted]
        new = age[now] < 0
        now, v = now[new], v[new]
        age[now] = n
        on = links.on[now]
        goes = (on >= 0) & (np.hypot(*(images.uv[on] - images.uv[now] - v).T) < jump)  # (3)
        now = on[goes]
        v = _steps(images, links, now)
    return age


def _begins(images: Images, links: _Links, step: int, r: float) -> tuple[Ints, Floats]:
    """The images (n) in which two have run together, by (2), and the mean (n, 2) px of the steps of both."""
    ends = _ends(images, links, step, r)
    cell, _ = _cells(images, ends, 0)
    query, other = images.near(cell, images.uv[ends, 0], np.full(len(ends), 2 * NEAR * r))
    good = (links.on[other] >= 0) & (links.back[other] >= 0) & (other != ends[query])
    one, other = ends[query[good]], other[good]
    common, ahead = links.on[other], images.uv[other] + _steps(images, links, other)
    axis, off = images.uv[one] + _steps(images, links, one) - ahead, images.uv[common] - ahead
    L = np.maximum(np.hypot(*axis.T), 1e-9)
    along, across = (off * axis).sum(1) / L**2, np.abs(off[:, 0] * axis[:, 1] - off[:, 1] * axis[:, 0]) / L
    between = (np.abs(along - 0.5) < 0.5 - BETWEEN) & (across < ACROSS * L + 1.0)  # (2)
    k = np.flatnonzero(between & (NEAR * r > L) & (LEAST * r < L))
    common, first = np.unique(common[k], return_index=True)
    both = [_steps(images, links, of[k[first]]) for of in (one, other)]
    return common, np.mean(both, axis=0)


def _ends(images: Images, links: _Links, step: int, r: float) -> Ints:
    """The images that go on nowhere, though they came from somewhere, and that no other takes up within r px."""
    rows = np.flatnonzero((links.on < 0) & (links.back >= 0))
    cell, inside = _cells(images, rows, step)
    rows, cell = rows[inside], cell[inside]
    place = images.uv[rows] + _steps(images, links, rows)
    query, row = images.near(cell, place[:, 0], np.full(len(rows), r))
    taken = (links.back[row] < 0) & (np.hypot(*(images.uv[row] - place[query]).T) < r)
    return rows[np.bincount(query, taken, len(rows)) == 0]


def _parted(images: Images, links: _Links, now: Ints, r: float) -> Bools:
    """(n) whether an image without a past lies beside these, as they have come apart."""
    cell, _ = _cells(images, now, 0)
    query, row = images.near(cell, images.uv[now, 0], np.full(len(now), NEAR * r))
    near = np.hypot(*(images.uv[row] - images.uv[now[query]]).T) < NEAR * r
    return np.bincount(query, (links.back[row] < 0) & (row != now[query]) & near, len(now)) > 0
