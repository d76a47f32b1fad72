"""Where the reference tracks of `gait_trial` stand up, and who is right where a tracker differs from them.

None of this looks at a tracker's own choice of images. A reference sample does not *stand up* where

- no two cameras have an image within NO_IMAGE px of where it should be seen (1): it is filled, or smoothed over a jump;
- of the images within REACH px of it, one a camera, the most that agree on a point, three and more to AGREE px RMS,
  agree on one that lies farther than NEAR mm from it (2): it was made with an image of another marker as well;
- it lies within MARGIN frames of one of its jumps (3), as `continuous_pieces` cuts them.

Three judges say which of two points of one marker and frame is right. *Images*: the consensus of (2), which is nearer
to one of them. *Path*: a cubic through the samples that both have in common in the PATH frames before and after, at
least FEWEST on either side. *Distances*, which knows nothing of images: those to the MATES markers that keep theirs
most steadily, in their own spread. Each says so where one point is CLEARLY times nearer to what it expects.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinemark.data import Rig
from kinemark.data.array_types import Floats, Ints
from kinemark.geometry import triangulate

NEAR = 5.0  # mm; a reference sample counts as found
NO_IMAGE = 1.0  # px
REACH = 3.0  # px
AGREE = 0.3  # px in either axis, RMS over what a point of so many images leaves free
PATH = 16  # frames
FEWEST = 4  # samples
CLEARLY = 1.5
MATES = 4


class FrameImages(NamedTuple):
    """Ideal pixels uv (D, 2), and the first (C, F + 1) row of each camera and frame, as `Detections` has them."""

    uv: Floats
    start: Ints

    def nearest(self, c: int, f: int, uv: Floats) -> Floats:
        """The images (n, 2) px nearest to places uv (n, 2) in a camera and frame, NaN where there are none."""
        some = self.uv[self.start[c, f] : self.start[c, f + 1]]
        if not len(some):
            return np.full(uv.shape, np.nan)
        return some[np.linalg.norm(some - uv[:, None], axis=-1).argmin(1)]


def projected(rig: Rig, xyz: Floats) -> Floats:
    """(N, C, 2) ideal px of points (N, 3)."""
    x = np.einsum("cij,nj->nci", rig.P, np.column_stack([xyz, np.ones(len(xyz))]))
    return np.asarray(x[..., :2] / x[..., 2:])


def images_beside(rig: Rig, images: FrameImages, frame: Ints, xyz: Floats) -> tuple[Floats, Floats]:
    """The nearest image (N, C, 2) px of each camera to samples (N) at xyz (N, 3), and how far (N, C) it is."""
    at = projected(rig, xyz)
    uv = np.full_like(at, np.nan)
    for f in np.unique(frame):
        rows = np.flatnonzero(frame == f)
        for c in range(len(rig)):
            uv[rows, c] = images.nearest(c, f, at[rows, c])
    return uv, np.nan_to_num(np.linalg.norm(uv - at, axis=-1), nan=np.inf)


def consensus(rig: Rig, uv: Floats, off: Floats) -> Floats:
    """(N, 3) mm, the point that the most of N samples' images uv (N, C, 2) within REACH, by `off` (N, C), agree on.

    NaN where no three agree to AGREE.
    """
    within, C = off < REACH, len(rig)
    best, most, least = np.full((len(uv), 3), np.nan), np.zeros(len(uv), np.int64), np.full(len(uv), np.inf)
    for n in range(3, C + 1):
        for some in combinations(range(C), n):
            rows = np.flatnonzero(within[:, some].all(1))
            if not len(rows):
                continue
            own = np.full((len(rows), C, 2), np.nan)
            own[:, some] = uv[rows][:, some]
            xyz = triangulate(own, rig.P)
            left = np.nansum((own - projected(rig, xyz)) ** 2, axis=(1, 2)) / (2 * n - 3)  # px² of either axis
            good = (left < AGREE**2) & ((n > most[rows]) | (left < least[rows]))
            best[rows[good]], most[rows[good]], least[rows[good]] = xyz[good], n, left[good]
    return best


class Standing(NamedTuple):
    """Which samples (M, F) of the reference do not stand up, by (1), (2) and (3), and the point (M, F, 3) of (2)."""

    unseen: NDArray[np.bool_]
    elsewhere: NDArray[np.bool_]
    jumping: NDArray[np.bool_]
    consensus: Floats

    @property
    def fallen(self) -> NDArray[np.bool_]:
        """By any."""
        return self.unseen | self.elsewhere | self.jumping


def standing(rig: Rig, images: FrameImages, reference: Floats, pieces: Floats) -> Standing:
    """Where the reference (M, F, 3) stands up; `pieces` (K, F, 3) are its continuous ones."""
    marker, frame = np.nonzero(np.isfinite(reference[..., 0]))
    xyz = reference[marker, frame]
    uv, off = images_beside(rig, images, frame, xyz)
    agreed = np.full(reference.shape, np.nan)
    agreed[marker, frame] = consensus(rig, uv, off)
    unseen = np.zeros(reference.shape[:2], bool)
    unseen[marker, frame] = (off < NO_IMAGE).sum(1) < 2
    kept = np.zeros(reference.shape[:2], bool)
    for f in range(reference.shape[1]):
        some = pieces[np.isfinite(pieces[:, f, 0]), f]
        kept[:, f] = (reference[:, f, None] == some).all(-1).any(1)
    elsewhere = np.linalg.norm(agreed - reference, axis=-1) > NEAR
    return Standing(unseen, elsewhere, np.isfinite(reference[..., 0]) & ~kept, agreed)


class Disputed(NamedTuple):
    """N reference samples of marker and frame that are not found, while a tracked point, at xyz (N, 3), is near."""

    marker: Ints
    frame: Ints
    xyz: Floats


class Judged(NamedTuple):
    """Of n disputed samples that a judge can tell, %: our point is right, the reference is, neither clearly."""

    n: int
    ours: float
    reference: float
    neither: float


def judged(
    some: Disputed, known: NDArray[np.bool_], reference: Floats, stands: Standing, low: float, high: float
) -> dict[str, Judged]:
    """What each judge says of samples disputed by low to high mm; `known` (M, F) are those found."""
    theirs = reference[some.marker, some.frame]
    apart = np.linalg.norm(some.xyz - theirs, axis=1)
    which = (apart >= low) & (apart < high)
    out = {}
    for name, place in (
        ("images", stands.consensus[some.marker, some.frame]),
        ("path", by_path(some, known, reference)),
    ):
        out[name] = _verdict(*(np.linalg.norm(place - one, axis=1)[which] for one in (some.xyz, theirs)))
    out["distances"] = _verdict(*(_left(some, one, known, reference)[which] for one in (some.xyz, theirs)))
    return out


def _verdict(ours: Floats, theirs: Floats) -> Judged:
    """Of what our points (N) and the reference's leave, NaN where the judge cannot tell."""
    some = np.isfinite(ours) & np.isfinite(theirs)
    ours, theirs = ours[some], theirs[some]
    said = 100 * np.array([(CLEARLY * ours < theirs).mean(), (CLEARLY * theirs < ours).mean()])
    return Judged(len(ours), said[0], said[1], 100 - said.sum())


def by_path(some: Disputed, known: NDArray[np.bool_], reference: Floats) -> Floats:
    """(N, 3) mm, where the samples beside a dispute lead, NaN where too few are `known` (M, F) to both."""
    out = np.full(some.xyz.shape, np.nan)
    for k, (m, f) in enumerate(zip(some.marker.tolist(), some.frame.tolist(), strict=True)):
        first = max(f - PATH, 0)
        beside = np.flatnonzero(known[m, first : f + PATH + 1]) + first
        if min((beside < f).sum(), (beside > f).sum()) < FEWEST:
            continue
        A = np.vander((beside - f) / PATH, 4)
        out[k] = np.linalg.lstsq(A, reference[m, beside], rcond=None)[0][3]
    return out


def _left(some: Disputed, xyz: Floats, known: NDArray[np.bool_], reference: Floats) -> Floats:
    """(N) RMS by which points (N, 3) leave their usual distances, in their spread; NaN where no mate is known."""
    out = np.full(len(some.marker), np.nan)
    for m in np.unique(some.marker):
        apart = np.where(known & known[m], np.linalg.norm(reference - reference[m], axis=-1), np.nan)
        apart[m] = np.nan
        mates = np.flatnonzero(np.isfinite(apart).sum(1) >= 200)
        usual = np.nanmedian(apart[mates], axis=1)
        spread = 1.4826 * np.nanmedian(np.abs(apart[mates] - usual[:, None]), axis=1)
        best = np.argsort(spread)[:MATES]
        own = np.flatnonzero(some.marker == m)
        now = np.linalg.norm(reference[mates[best]][:, some.frame[own]] - xyz[own], axis=-1)
        now[~known[mates[best]][:, some.frame[own]]] = np.nan
        off = (now - usual[best, None]) / np.maximum(spread[best, None], 1.0)
        told = np.isfinite(off).any(0)
        out[own[told]] = np.sqrt(np.nanmean(off[:, told] ** 2, axis=0))
    return out
