"""Stitches over wide gaps stay only where companions do not contradict them."""

import numpy as np
import pytest

from kinemark.track.simultaneous import Simultaneous
from kinemark.track.simultaneous.neighbouring_points import TrackPoints
from kinemark.track.simultaneous.stitch import Stitch, Stitched
from kinemark.track.simultaneous.wide_stitches import without_contradicted
from support.motions import dance

METHOD, RATE = Simultaneous(), 100.0
ENDS, BEGINS = 60, 75  # frames of a gap of 0.15 s


def limb(seed, others):
    """Points of markers 0 and 1, 80 mm apart on a limb with `others` that are seen throughout, to 0.5 mm; of both the
    pieces before the gap, tracks 0 and 1, and after it, tracks 2 and 3."""
    rng = np.random.default_rng(seed)
    places = np.concatenate([[[0, 0, 0], [80, 0, 0]], rng.uniform(-150, 250, (others, 3))])
    turn = np.cumsum(rng.normal(0, 0.004, 140))
    none, one = np.zeros(140), np.ones(140)
    R = np.array([[np.cos(turn), -np.sin(turn), none], [np.sin(turn), np.cos(turn), none], [none, none, one]])
    path = dance(n=1, frames=140, rate=RATE, seed=seed)[0]
    xyz = path + np.einsum("ijf,mj->mfi", R, places) + rng.normal(0, 0.5, (len(places), 140, 3))
    seen = [(0, 0, range(ENDS + 1)), (1, 1, range(ENDS + 1)), (2, 0, range(BEGINS, 140)), (3, 1, range(BEGINS, 140))]
    seen += [(m + 2, m, range(140)) for m in range(2, others + 2)]
    id, marker, frame = np.array([(i, m, f) for i, m, frames in seen for f in frames]).T
    order = np.lexsort([id, frame])
    cov = np.broadcast_to(np.eye(3) * 0.25, (len(id), 3, 3))
    return TrackPoints(frame[order], id[order], xyz[marker, frame][order], cov)


def judged(points, pairs, *, sd=50.0, score=12.0):
    """Which of the stitches between tracks are left, and the identities of tracks 0 to 3."""
    made = [Stitch(a, b, score, score, sd, ENDS, BEGINS) for a, b in pairs]
    ids = np.arange(int(points.id.max()) + 1)
    for a, b in pairs:
        ids[b] = a
    left = without_contradicted(points, Stitched(ids, made), 1 / RATE, METHOD)
    return [(one.before, one.after) for one in left.stitches], left.id[:4].tolist()


@pytest.mark.parametrize("seed", range(4))
def test_a_stitch_to_another_marker_of_the_limb_is_undone(seed):
    points = limb(seed, 6)
    assert judged(points, [(0, 2), (1, 3)]) == ([(0, 2), (1, 3)], [0, 1, 0, 1])
    assert judged(points, [(0, 3), (1, 2)]) == ([], [0, 1, 2, 3])
    assert judged(points, [(0, 3)]) == ([], [0, 1, 2, 3])


def test_motion_that_leaves_little_open_is_not_contradicted():
    """Neighbours that bend or swing contradict many stitches that motion alone makes sure."""
    assert judged(limb(0, 6), [(0, 3)], sd=0.9 * METHOD.uncertain_sd) == ([(0, 3)], [0, 1, 2, 0])
    assert judged(limb(0, 6), [(0, 3)], score=60.0) == ([(0, 3)], [0, 1, 2, 0])


def test_too_few_companions_contradict_nothing():
    assert judged(limb(0, 1), [(0, 3)]) == ([(0, 3)], [0, 1, 2, 0])
