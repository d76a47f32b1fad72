"""Two tracks that go on as each other."""

import numpy as np
import pytest

from kinemark.data import Cloud
from kinemark.track.simultaneous import Simultaneous, track_with_decisions
from kinemark.track.simultaneous.following.passes import Associations
from kinemark.track.simultaneous.joining import exchanged_tails as module
from kinemark.track.simultaneous.joining.exchanged_tails import NEVER, exchanged_tails, with_exchanged_tails
from kinemark.track.simultaneous.joining.stitch import Stitch, Stitched
from kinemark.track.simultaneous.points.neighbouring_points import TrackPoints
from support.scenes import make, scene, tally

RATE, METHOD, MARKERS, FRAMES, CUT = 25.0, Simultaneous(), 6, 50, 20
ONE, OTHER = 0, 1


def limb(*, shift=0.0, rate=RATE, amplitude=300.0):
    """(MARKERS, FRAMES, 3) mm, markers 60 mm apart on a limb that swings once a second."""
    t = np.arange(FRAMES) / rate
    angle = amplitude / 300 * np.sin(2 * np.pi * t)
    along = np.stack([np.sin(angle), np.zeros(FRAMES), -np.cos(angle)], -1)
    across = np.array([0.0, 30.0, 0.0]) * (np.arange(MARKERS) % 2)[:, None, None]
    return (300 + 60 * np.arange(MARKERS))[:, None, None] * along + across + [1000.0, 0.0, 1500.0] + shift


def tracked(*, own=ONE, other=OTHER, cut=CUT, missing=(), **how):
    """Points of tracks of a limb, to 1 mm, `own` and `other` exchanged from a frame on; none where (track, frames)."""
    xyz = limb(**how)
    xyz += np.random.default_rng(1).normal(0, 0.3, xyz.shape)
    xyz[[own, other], cut:] = xyz[[other, own], cut:]
    there = np.ones(xyz.shape[:2], bool)
    for one, frames in missing:
        there[one, frames] = False
    frame, id = np.nonzero(there.T)
    return TrackPoints(frame, id, xyz[id, frame], np.broadcast_to(np.eye(3) / 3, (len(id), 3, 3)))


def cuts(points, rate=RATE):
    return exchanged_tails(points, 1 / rate, METHOD).cuts.tolist()


@pytest.mark.parametrize("shift", [0.0, 5e6])
def test_two_tracks_that_go_on_as_each_other_are_changed_back(shift):
    assert cuts(tracked(shift=shift)) == [[ONE, OTHER, CUT, CUT]]


@pytest.mark.parametrize("amplitude", [0.0, 300.0, 450.0])
def test_tracks_that_go_on_as_themselves_are_left(amplitude):
    assert cuts(tracked(other=ONE, amplitude=amplitude)) == []


@pytest.mark.parametrize(
    ("missing", "found"),
    [
        ([(ONE, slice(17, 20))], [ONE, OTHER, CUT, CUT]),
        ([(OTHER, slice(0, CUT)), (ONE, slice(45, 50))], [ONE, OTHER, CUT, CUT]),
        ([(OTHER, slice(CUT, FRAMES))], [ONE, OTHER, CUT, NEVER]),
    ],
    ids=["after a gap", "one begins there", "one ends there"],
)
def test_also_where_a_link_lacks(missing, found):
    assert cuts(tracked(missing=missing)) == [found]


def test_a_track_that_is_there_in_the_gap_of_another_alone_is_no_other_marker():
    """It may be the same one, whose tail would be taken away."""
    assert (
        cuts(
            tracked(
                other=ONE,
                missing=[(ONE, slice(18, 24)), *((OTHER, k) for k in range(FRAMES) if k not in (19, 20, 21, 22))],
            )
        )
        == []
    )


def test_an_exchange_there_and_back_is_changed_back_twice():
    points = tracked()
    back = (points.frame >= 24) & (points.id <= OTHER)
    points = points._replace(id=np.where(back, 1 - points.id, points.id))
    exchanges = exchanged_tails(points, 1 / RATE, METHOD)
    truth = np.where((points.frame >= CUT) & ~back & (points.id <= OTHER), 1 - points.id, points.id)
    assert (exchanges.of(points.id, points.frame) == truth).all()


def test_no_points_are_exchanged_with_none():
    assert cuts(tracked().take(np.zeros(0, np.int64))) == []


def test_a_link_is_compared_with_the_tracks_that_are_there(monkeypatch):
    """At each link all tracks of a recording of one minute took a third of the time."""
    asked, at_once = [], module._at_once

    def counted(points, pairs, T):
        asked.append(len(pairs.a))
        return at_once(points, pairs, T)

    monkeypatch.setattr(module, "_at_once", counted)
    one, pause = tracked(), FRAMES + round(RATE)
    parts = [one._replace(id=one.id + MARKERS * k, frame=one.frame + pause * k) for k in range(5)]
    found = cuts(TrackPoints(*map(np.concatenate, zip(*parts, strict=True))))
    assert sorted(found) == [
        [ONE + MARKERS * k, OTHER + MARKERS * k, CUT + pause * k, CUT + pause * k] for k in range(5)
    ]
    assert max(asked) <= 3 * MARKERS


def test_what_a_track_was_followed_by_goes_with_its_later_part():
    points = tracked()
    order = np.argsort(points.frame, kind="stable")
    points = points.take(order)
    first, n = np.searchsorted(points.frame, np.arange(FRAMES + 1)), len(points.id)
    cloud = Cloud(RATE, first, points.xyz, points.cov, np.zeros(n), np.zeros((n, 2), int))
    none = np.zeros((2, n), np.int32)
    seen = Associations(
        points.frame, points.id, none, none > 0, np.zeros(n), np.zeros(n), points.xyz.T, np.zeros((3, 3, 0))
    )
    stitch = Stitch(ONE, ONE, 20.0, 20.0, 1.0, CUT - 1, CUT)
    ids, after, whole = with_exchanged_tails(
        cloud, points.id, seen, Stitched(np.arange(MARKERS), [stitch]), 1 / RATE, METHOD
    )
    truth = np.where((points.frame >= CUT) & (points.id <= OTHER), 1 - points.id, points.id)
    assert (ids == truth).all() and (whole.id[after.id] == truth).all()
    assert (after.id[points.frame < CUT] == points.id[points.frame < CUT]).all()
    (moved,) = whole.stitches
    assert (moved.before, whole.id[moved.after]) == (ONE, OTHER)


def test_arms_at_25_hz_are_not_exchanged_for_good():
    """Two markers of an arm 56 mm apart, exchanged in its fourth frame, were so for the other 93."""
    slow = scene(830023)._replace(motion="arms", rate=25.0, markers=39, cameras=8, seconds=4.0)
    made = make(slow)
    assert tally(made, *track_with_decisions(made.detections, made.rig)).swaps == 0
