"""Chance meetings of two images, told by all that is known of them at once.

Where two cameras alone see a track, no single property tells a marker from images of two markers that meet by chance
for a while. Four together do. A stretch is a run of frames in which the same two cameras see a track, and no other.
With D its score (2) of `drifting_pairs`, N the number of points of its track, q_k the squared distances, in standard
deviations, of free images from the points at which they meet either image of the stretch elsewhere, and H the score (1)
of `held_beyond`,

    logit p = BIAS + DRIFT max(D, LEAST) + LENGTH ln N + PARTNERS ln(1 + Σ_k exp(−q_k / 2)) + HELD H      (1)

with the mean of the sum over the frames of the stretch, p is the probability that it is a chance meeting (logistic
regression, Cox 1958). Images of two markers mostly have their true partners on their lines, which no track has, as the
meeting has taken one image of either. Few images of markers have partners: a third camera that sees the marker is in
its track. Stretches of more than LIKELY are given up. Those of cameras of which it is not known what is usual are not
judged. Merged images do not count: one of two markers fits a meeting of both.
"""

from __future__ import annotations

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ....native import inverse
from ..detection_index import Images
from ..following.candidate_points import intersect
from .drift_of_runs import scores_of_pair
from .drifting_pairs import UsualResiduals, residual, shared_shift
from .held_beyond import held_elsewhere
from .rival_pairs import Rivals, near_rivals, stretches

BIAS, DRIFT, LENGTH, PARTNERS, HELD = -2.23, 0.38, -0.96, 6.8, 0.5
"""Of (1), without unit; fitted by `benchmarks/chance_meetings.py`; the last chosen with the others kept (see
docs/theory/tracking-ghosts.md)."""

LEAST = -5.0
"""Of D in (1), a natural logarithm; chosen: what drifts less than usual for longer is no likelier a marker's."""

LIKELY = float(-np.log(9.0))
"""logit p from which a stretch is given up, a natural logarithm: p is then 0.1; chosen on scenes of four cameras by
which nothing was fitted (see docs/theory/tracking-ghosts.md)."""


FEW = 4
"""Cameras, a number, up to which anything is judged; chosen: of more, most markers have a third image, and two cameras
alone see few chance meetings. Of 14 scenes (5200 to 5222 of benchmarks/tracking_scenes.py) it would take none of 16
ghosts and 12 samples."""

APART = 3.0
"""Standard deviations within which a free image is taken for one of the same marker; chosen: with 2 a whole track of a
marker was given up whose calibration keeps four of its images apart (141065 of benchmarks/tracking_scenes.py)."""


def chance_meetings(
    frame: Ints, id: Ints, detection: Ints, images: Images, usual: UsualResiduals, r: float, gate: float
) -> Bools:
    """(P) the points of tracks id (P), of detections (C, P), that are given up as chance meetings; r px is that of
    `image_chains`."""
    if len(detection) > FEW:
        return np.zeros(len(frame), bool)
    stretch, what = evidence(frame, id, detection, images, usual, r, gate)
    logit = BIAS + what @ (DRIFT, LENGTH, PARTNERS, HELD)  # (1)
    return (stretch >= 0) & np.append(logit > LIKELY, False)[stretch]


def evidence(
    frame: Ints, id: Ints, detection: Ints, images: Images, usual: UsualResiduals, r: float, gate: float
) -> tuple[Ints, Floats]:
    """The stretch (P) of each point of tracks id (P), −1 where it is not judged, and of each of N stretches what (1)
    is made of (N, 4), without its coefficients; r px is that of `image_chains`."""
    usual, detection = usual_of_two(id, detection, images, usual), images.own(detection)
    stretch = stretches(frame, id, detection, 1)
    drift = _own_scores(frame, detection, stretch, images, usual, gate)
    stretch[~np.isfinite(np.append(drift, np.nan))[stretch]] = -1
    number = np.ones(len(drift))
    rows = np.flatnonzero(stretch >= 0)
    number[stretch[rows]] = np.bincount(id)[id[rows]]
    partners = _partners(frame, detection, stretch, len(drift), images, usual, gate)
    held = held_elsewhere(frame, detection, stretch, len(drift), images, r)
    return stretch, np.column_stack([np.maximum(np.nan_to_num(drift), LEAST), np.log(number), np.log1p(partners), held])


def _partners(
    frame: Ints, detection: Ints, stretch: Ints, N: int, images: Images, usual: UsualResiduals, gate: float
) -> Floats:
    """(N) the mean of Σ exp(−q / 2) of (1) over the frames of each stretch."""
    free = images.usable & ~images.merged
    free[detection[detection >= 0]] = False
    near = near_rivals(frame, detection, stretch, images, free, usual.F, gate)
    near = near.take(~_same_place(near, detection, images))
    total = np.bincount(stretch[near.row], np.exp(-near.squared / 2), N)
    return np.asarray(total / np.maximum(np.bincount(stretch[stretch >= 0], minlength=N), 1))


def _same_place(near: Rivals, detection: Ints, images: Images) -> Bools:
    """(H) whether the point of each pair is where that of both images of the stretch is."""
    row, which = np.unique(near.row, return_inverse=True)
    own = intersect(images, detection[:, row])
    off = near.xyz - own.xyz[:, which]
    N = inverse(near.cov + own.cov[..., which])
    return np.asarray(np.einsum("it,ijt,jt->t", off, N, off) < APART**2)


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
    """(N) score(a, b) of (2) of each stretch, NaN where its cameras are not judged."""
    out = np.full(int(stretch.max(initial=-1)) + 1, np.nan)
    has = detection >= 0
    for a, b in usual.of:
        rows = np.flatnonzero(has[a] & has[b] & (stretch >= 0))
        rows = rows[np.lexsort([frame[rows], stretch[rows]])]
        both = detection[[a, b]][:, rows]
        some = np.unique(stretch[rows])
        out[some] = scores_of_pair(frame[rows], stretch[rows], both, images, usual, (a, b), gate)[some]
    return out
