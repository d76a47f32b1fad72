"""Markers are where the others of their body say: points that changed places change back, pieces find their marker."""

from functools import cache

import numpy as np
import pytest

from kinemark.label import learn_template
from kinemark.label.body_places import body_places, distance, figures, places_by
from kinemark.label.by_body import ASIDE_POINT, NamedPoints, judged
from kinemark.label.carried_places import carried_places
from kinemark.synth import walking, with_markers

RATE = 50.0


@cache
def walk(seed, speed=1000.0):
    walker = walking(duration_s=2.0, rate=RATE, seed=seed, wobble_mm=2.0, marker_radius_mm=7.0, speed_mm_s=speed)
    return with_markers(walker, 39, seed=1)


@cache
def template():
    return learn_template(walk(1, 900.0).trajectories)


def index():
    return np.array([template().names.index(name) for name in walk(2).names])


def points_of(xyz, marker=None, track=None):
    """One point a marker and frame; `marker` (M, F) what each is taken for."""
    M, F = xyz.shape[:2]
    m, f = (grid.ravel() for grid in np.meshgrid(np.arange(M), np.arange(F), indexing="ij"))
    marker = m if marker is None else marker.ravel()
    track = marker.copy() if track is None else track.ravel()
    return NamedPoints(f, track, marker, xyz.reshape(-1, 3), np.tile(np.eye(3), (M * F, 1, 1)), np.zeros(M * F, bool))


def places_of(points, M, F):
    xyz = np.full((M, F, 3), np.nan)
    own = points.marker >= 0
    xyz[points.marker[own], points.frame[own]] = points.xyz[own]
    return xyz


@pytest.mark.parametrize("by", [np.zeros(3), np.full(3, 1e7)])
def test_places_and_their_covariance_hold_of_another_walk_wherever_it_is(by):
    xyz = walk(2).xyz + by
    found = body_places(xyz, index(), template(), RATE)
    square = distance(xyz, found.place, found.cov)
    assert np.isfinite(square).mean() > 0.95
    well = np.sqrt(np.trace(found.cov, axis1=-1, axis2=-2)) < 10
    assert (square[well] > 25).mean() < 0.01  # 5 standard deviations
    assert (well.mean(1) > 0.5).sum() > 15


def test_in_a_gap_where_it_lay_before_and_after_tells_more():
    xyz = walk(2).xyz
    wanted = np.zeros(xyz.shape[:2], bool)
    for m in range(len(xyz)):
        wanted[m, 20 + m : 25 + m] = True
    hidden = np.where(wanted[..., None], np.nan, xyz)
    body = figures(hidden, index(), template(), RATE)
    found = carried_places(body, hidden, wanted, RATE)
    truth = xyz[found.marker, found.frame]
    plain = places_by(body, hidden).place[found.marker, found.frame]
    off, off_plain = (np.median(np.linalg.norm(one - truth, axis=1)) for one in (found.xyz, plain))
    assert off < 0.6 * off_plain
    assert (distance(truth, found.xyz, found.cov) > 25).mean() < 0.02


def near_pair():
    """Two markers whose places are known well, nearest to each other."""
    xyz = walk(2).xyz
    sd = np.nanmedian(np.sqrt(np.trace(body_places(xyz, index(), template(), RATE).cov, axis1=-1, axis2=-2)), axis=1)
    well = np.flatnonzero(sd < 3)
    apart = np.linalg.norm(xyz[well][:, None] - xyz[well], axis=-1).mean(-1) + np.diag(np.full(len(well), np.inf))
    return well[list(np.unravel_index(apart.argmin(), apart.shape))]


def test_markers_that_took_each_others_place_in_a_third_of_the_frames_change_back():
    """Frame after frame, also for one or two; each alone would be believed by its neighbours."""
    xyz, (a, b) = walk(2).xyz, near_pair()
    marker = np.tile(np.arange(len(xyz))[:, None], xyz.shape[1])
    for frames in (slice(5, 6), slice(20, 22), slice(40, 70)):
        marker[[a, b], frames] = marker[[b, a], frames]
    points = points_of(xyz, marker)
    body = body_places(places_of(points, *xyz.shape[:2]), index(), template(), RATE)
    out = judged(points, body).reshape(marker.shape)
    own = np.arange(len(xyz))[:, None]
    assert ((out == own) | (out == ASIDE_POINT)).all()
    assert (out == own)[[a, b]].mean() > 0.95 > (marker == own)[[a, b]].mean()
    fixed = points._replace(fixed=np.isin(points.marker, [a, b]))
    assert (judged(fixed, body) == points.marker).all()


def test_a_piece_that_hops_between_places_gives_its_points_and_a_marker_without_a_name_stays():
    xyz, (a, b) = walk(2).xyz, near_pair()
    M, F = xyz.shape[:2]
    extra = xyz[a] + np.array([0.0, 0.0, 120.0])
    xyz = np.concatenate([xyz, extra[None]])
    marker = np.tile(np.arange(M + 1)[:, None], F)
    track = marker.copy()
    marker[M] = -1
    for f in range(30, 36):  # two tracks of points of both
        marker[[a, b], f] = -1
        track[[a, b], f] = (M + 1, M + 2) if f % 2 else (M + 2, M + 1)
    points = points_of(xyz, marker, track)
    body = body_places(places_of(points, M, F), index(), template(), RATE)
    out = judged(points, body).reshape(M + 1, F)
    assert (out[:M] == np.arange(M)[:, None]).all()
    assert (out[M] == -1).all()


def test_a_point_far_off_is_put_aside():
    xyz, (a, _) = walk(2).xyz.copy(), near_pair()
    xyz[a, 50] += [0.0, 0.0, 90.0]
    points = points_of(xyz)
    out = judged(points, body_places(xyz, index(), template(), RATE)).reshape(xyz.shape[:2])
    assert out[a, 50] == ASIDE_POINT
    out[a, 50] = a
    assert (out == np.arange(len(xyz))[:, None]).all()
