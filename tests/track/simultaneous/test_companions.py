"""Pieces with the same place among others on both sides of a gap are one track; any other stay apart."""

import numpy as np
import pytest

from kinemark.data import Cloud
from kinemark.track.simultaneous import Simultaneous
from kinemark.track.simultaneous.joining.companions import OVERLAP, joined_pieces, once_a_frame, with_companions
from kinemark.track.simultaneous.joining.stitch import Stitched
from kinemark.track.simultaneous.points.neighbouring_points import TrackPoints
from support.motions import dance

RATE = 100.0
AWAY = {k: (120, 280) for k in range(5)}  # of nine markers of a plate, for 1.6 s


def plate(seed, F=400):
    """(9, F, 3) mm: nine markers of a stiff plate that is carried about and turned, to 0.5 mm."""
    rng = np.random.default_rng(seed)
    t = np.arange(F) / RATE
    turn = 1.5 * np.sin(2 * np.pi * 0.3 * t + rng.uniform(0, 6))
    R = np.array([[np.cos(turn), -np.sin(turn), 0 * t], [np.sin(turn), np.cos(turn), 0 * t], [0 * t, 0 * t, 0 * t + 1]])
    places = rng.uniform(-250, 250, (9, 3)) * [1, 1, 0]
    path = 600 * np.sin(2 * np.pi * 0.4 * t[:, None] + rng.uniform(0, 6, 3))
    return path + np.einsum("ijf,mj->mfi", R, places) + rng.normal(0, 0.5, (9, F, 3))


def in_pieces(xyz, away, later=0):
    """Points of markers (M, F, 3), of which those in `away` are gone from one frame to another and come back as tracks
    M on, `later` frames before that."""
    M, F = xyz.shape[:2]
    parts = [(m, m, np.arange(F)) for m in range(M) if m not in away]
    for k, (m, (first, stop)) in enumerate(away.items()):
        parts += [(m, m, np.arange(first)), (M + k, m, np.arange(stop - later, F))]
    frame = np.concatenate([f for *_, f in parts])
    id = np.concatenate([np.full(len(f), i) for i, _, f in parts])
    points = np.concatenate([xyz[m, f] for _, m, f in parts])
    order = np.lexsort([id, frame])
    return TrackPoints(frame[order], id[order], points[order], np.broadcast_to(np.eye(3) * 0.25, (len(frame), 3, 3)))


def joined(points, whole=None):
    """The identity of each track."""
    whole = whole or Stitched(np.arange(int(points.id.max(initial=-1)) + 1), [])
    return with_companions(points, whole, 1 / RATE, Simultaneous())


@pytest.mark.parametrize("seed", range(4))
def test_a_plate_half_of_which_is_away_for_long_has_its_tracks_back(seed):
    ids = joined(in_pieces(plate(seed), AWAY)).id
    assert ids.tolist() == [*range(9), *range(5)]


def test_a_number_that_another_marker_has_by_now_is_that_marker_s():
    """What was track 8 became track 0, as of a body that breaks, and another marker took over the number 8."""
    points = in_pieces(plate(1), {})
    start, n = np.searchsorted(points.frame, np.arange(points.frame.max() + 2)), len(points.id)
    cloud = Cloud(RATE, start, points.xyz, np.array(points.cov), np.zeros(n), np.full((n, 2), -1))
    whole = Stitched(np.array([*range(8), 0, 2]), [])
    kept, ids, after = joined_pieces(cloud, points.id, whole, 1 / RATE, Simultaneous())
    assert len(kept) == n
    assert ids.tolist() == points.id.tolist()
    assert after.id.tolist() == whole.id.tolist()


def test_numbers_of_tracks_that_are_there_no_more_change_nothing():
    points = in_pieces(plate(1), AWAY)
    plain, far = joined(points), joined(points._replace(id=3 * points.id + 2))
    assert far.id[2::3].tolist() == [3 * i + 2 for i in plain.id.tolist()]
    assert far.id[:2].tolist() == [0, 1]
    ends = [(3 * one.before + 2, 3 * one.after + 2) for one in plain.stitches]
    assert [(one.before, one.after) for one in far.stitches] == ends != []


@pytest.mark.parametrize("seed", range(4))
def test_markers_that_move_by_themselves_are_not_joined(seed):
    points = in_pieces(dance(n=12, frames=400, rate=RATE, seed=seed), {1: (120, 260), 6: (140, 270)})
    assert joined(points).id.tolist() == list(range(14))


@pytest.mark.parametrize("seed", range(4))
def test_what_is_new_beside_a_plate_is_none_of_its_markers(seed):
    points = in_pieces(plate(seed), AWAY)
    points.xyz[points.id == 9] += [40.0, -70.0, 50.0]
    assert joined(points).id.tolist() == [*range(10), *range(1, 5)]


def test_two_pieces_in_one_place_at_once_are_a_choice_that_is_not_made():
    points = in_pieces(plate(1), AWAY)
    twin = points.take(points.id == 9)
    points = points.plus(twin._replace(id=np.full(len(twin.id), 14), xyz=twin.xyz + 1.0))
    assert joined(points).id.tolist() == [*range(10), *range(1, 5), 14]


def test_a_vague_piece_beside_a_clear_one_is_not_the_same_marker_too():
    points = in_pieces(plate(1), AWAY)
    vague = points.take((points.id == 9) & (points.frame > 300))
    vague = vague._replace(id=np.full(len(vague.id), 14), cov=vague.cov * 30**2)
    assert joined(points.plus(vague)).id.tolist() == [*range(9), *range(5), 14]


@pytest.mark.parametrize(("frames", "one"), [(OVERLAP - 1, True), (OVERLAP + 3, False)])
def test_a_track_that_another_takes_over_may_last_a_few_frames_more(frames, one):
    points = in_pieces(plate(2), {0: (200, 200)}, later=frames)
    assert (joined(points).id[9] == 0) == one


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("drifts", [0, 9])
def test_of_a_track_that_another_takes_over_what_drifts_goes(seed, drifts):
    points = in_pieces(plate(seed), {0: (200, 200)}, later=OVERLAP - 1)
    both = (points.frame >= 200 - OVERLAP + 1) & (points.frame < 200)
    wrong = both & (points.id == drifts)
    points.xyz[wrong] += [30.0, -20.0, 10.0]
    as_one = points._replace(id=np.where(points.id == 9, 0, points.id))
    kept = once_a_frame(as_one, 1 / RATE, Simultaneous())
    assert np.flatnonzero(~kept).tolist() == np.flatnonzero(wrong).tolist()


def test_tracks_with_one_point_a_frame_keep_all():
    assert once_a_frame(in_pieces(plate(0), AWAY), 1 / RATE, Simultaneous()).all()


def swinging(seed, F=600):
    """(12, F, 3) mm: eight markers of a trunk that walks, and four of a forearm that swings beside it."""
    rng = np.random.default_rng(seed)
    t = np.arange(F) / RATE
    trunk = rng.uniform([-100, -180, 0], [100, 180, 500], (8, 1, 3)) + rng.normal(0, 0.5, (8, F, 3))
    turn = 0.7 * np.sin(2 * np.pi * rng.uniform(0.8, 1.1) * t + rng.uniform(0, 6))
    places = rng.uniform([-30, -30, -330], [30, 30, -200], (4, 3))
    R = np.array([[np.cos(turn), 0 * t, np.sin(turn)], [0 * t, 0 * t + 1, 0 * t], [-np.sin(turn), 0 * t, np.cos(turn)]])
    arm = np.array([0.0, 220.0, 200.0]) + np.einsum("ijf,mj->mfi", R, places) + rng.normal(0, 0.5, (4, F, 3))
    return np.concatenate([trunk, arm]) + 12.0 * np.arange(F)[:, None] * [1.0, 0.0, 0.0]


@pytest.mark.parametrize("seed", [0, 18, 43])
def test_markers_of_a_limb_that_were_away_together_do_not_come_back_as_each_other(seed):
    """Their distances from the trunk are others by then, perhaps what those of a neighbour were."""
    ids = joined(in_pieces(swinging(seed), {k: (220, 400) for k in (8, 9, 10, 11)})).id
    assert all(ids[12 + k] in (8 + k, 12 + k) for k in range(4))


def test_what_was_stitched_before_stays_one():
    points, before = in_pieces(plate(3), AWAY), np.arange(14)
    before = np.append(before, [0, 9])  # two more fragments: of track 0, and of track 9
    assert joined(points, Stitched(before, [])).id.tolist() == [*range(9), *range(5), 0, 0]


def test_joins_are_told_with_their_frames():
    found = joined(in_pieces(plate(0), AWAY)).stitches
    assert sorted((one.before, one.after, one.last, one.first) for one in found) == [
        (k, 9 + k, 119, 280) for k in range(5)
    ]


def test_nothing_to_join():
    none = TrackPoints(np.zeros(0, int), np.zeros(0, int), np.zeros((0, 3)), np.zeros((0, 3, 3)))
    assert once_a_frame(none, 1 / RATE, Simultaneous()).tolist() == []
    assert joined(none).id.tolist() == [] and joined(in_pieces(plate(0), {})).id.tolist() == list(range(9))
