"""Each kind of doubt, each finding on the input, and what decides which tracks there are: one law at a time."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Cloud, Tracks
from kinemark.match import match
from kinemark.reconstruct import reconstruct
from kinemark.synth.score import score
from kinemark.track import track
from kinemark.track.simultaneous import Simultaneous, diagnose, diagnose_tracks, track_detections, track_simultaneously
from kinemark.track.simultaneous.diagnosis.ambiguous import (
    WEAK_EVIDENCE,
    AmbiguousDecision,
    _came_near,
    _close_stitches,
    _found_again,
    _little_evidence,
    _merged,
    _possible_exchanges,
)
from kinemark.track.simultaneous.following.candidate_points import CandidatePoints
from kinemark.track.simultaneous.following.initiate import _triples
from kinemark.track.simultaneous.following.likelihood import WEAK, evidence
from kinemark.track.simultaneous.following.passes import Associations
from kinemark.track.simultaneous.joining.possible_exchanges import possible_exchanges
from kinemark.track.simultaneous.joining.stitch import CLEAR_MARGIN, Stitch, stitched
from support.clouds import points
from support.laboratory import observe, ring
from support.motions import dance, in_pieces

METHOD = Simultaneous()


def sightings(xyz, *, rows=None, before=1.0, shared=None):
    """Tracks (N, F, 3) seen by two cameras in every frame, by frame; rows (N, F, 2) where not all are, −1 for none;
    shared (N, F, 2) images."""
    n, frames, _ = xyz.shape
    id, frame = (k.ravel() for k in np.mgrid[:n, :frames])
    own = np.arange(2 * n * frames).reshape(n, frames, 2) if rows is None else np.asarray(rows)
    shared = np.zeros(own.shape, bool) if shared is None else shared
    wide = np.broadcast_to(np.asarray(before, float), (n, frames)).ravel()
    cov = np.broadcast_to(np.eye(3)[..., None], (3, 3, n * frames))
    every = Associations(
        frame,
        id,
        own.reshape(-1, 2).T,
        shared.reshape(-1, 2).T,
        np.zeros(n * frames),
        wide,
        xyz.reshape(-1, 3).T,
        cov,
    )
    return every.take(np.argsort(frame, kind="stable"))


def straight(n=2, frames=20, apart=100.0):
    t = np.arange(frames)
    return np.stack([np.stack([5.0 * t, apart * k + 0 * t, 1000 + 0 * t], -1) for k in range(n)]).astype(float)


# What deserves a doubt


@pytest.mark.parametrize(("share", "found"), [(0.98, 1), (1.02, 0)])
def test_tracks_nearer_than_their_gates_may_be_swapped(share, found):
    paths, before = straight(), 3.0
    paths[..., 2] += 50 * (np.arange(20) % 2)  # they leave their courses by more than `before`
    paths[1, 8:12, 1] = share * 2 * METHOD.gate * before / np.sqrt(3)  # (1); elsewhere 100 mm apart
    decisions = _came_near(sightings(paths, before=before), METHOD)
    assert [(d.kind, d.first, d.last, d.tracks) for d in decisions] == [("swap", 8, 11, (0, 1))] * found


@pytest.mark.parametrize(("sideways", "found"), [(0.0, 0), (10.0, 0), (40.0, 1)])
def test_tracks_that_keep_their_courses_were_not_exchanged(sideways, found):
    """At a low rate any marker may go far until the next frame; what they did tells whether these were exchanged."""
    paths = straight(apart=200.0)
    paths[:, 10, 2] += sideways
    decisions = _came_near(sightings(paths, before=60.0), METHOD)
    assert len(decisions) == found
    assert all(d.tracks == (0, 1) and abs(d.first - 8) <= 2 and abs(d.last - 12) <= 2 for d in decisions)


def test_a_track_that_was_lost_and_found_is_a_doubt_only_where_its_place_was_hardly_known():
    before = np.ones((2, 20))
    before[0, 9], before[1, 9] = 1.1 * METHOD.uncertain_sd, 0.9 * METHOD.uncertain_sd
    rows = np.arange(80).reshape(2, 20, 2)
    rows[:, 5:9] = -1
    (decision,) = _found_again(sightings(straight(), before=before, rows=rows), METHOD)
    assert (decision.kind, decision.first, decision.last, decision.tracks) == ("swap", 9, 9, (0,))
    rows[0, 9:, 1] = -1  # one image alone finds nothing again
    assert _found_again(sightings(straight(), before=before, rows=rows), METHOD) == []


@pytest.mark.parametrize(("tracks", "found"), [(1, []), (2, [0])])
def test_a_marker_alone_is_exchanged_with_none_and_one_that_was_not_lost_neither(tracks, found):
    """At a low rate the place of any track is hardly known from one frame to the next."""
    before, rows = np.full((2, 20), 1.1 * METHOD.uncertain_sd), np.arange(80).reshape(2, 20, 2)
    before[:, [0, -1]], rows[0, 9] = 1.0, -1
    seen = sightings(straight(), before=before, rows=rows)
    decisions = _found_again(seen.take(np.flatnonzero(seen.id < tracks)), METHOD)
    assert [d.tracks for d in decisions] == [(k,) for k in found]
    assert all((d.first, d.last) == (8, 10) for d in decisions)


def tracks_of(xyz, *, missing=(), rate=100.0):
    """Tracks (N, F, 3), to 1 mm, of four images a point but where (track, frames) are missing."""
    there = np.ones(xyz.shape[:2], bool)
    for one, frames in missing:
        there[one, frames] = False
    frame, id = np.nonzero(there.T)
    start, n = np.searchsorted(frame, np.arange(xyz.shape[1] + 1)), len(frame)
    cov = np.broadcast_to(np.eye(3), (n, 3, 3))
    return Tracks(Cloud(rate, start, xyz[id, frame], cov, np.zeros(n), np.arange(4 * n).reshape(n, 4)), id)


def test_a_track_that_lives_on_merged_images_may_be_the_other_marker():
    """Also where no other track shares them: the marker that comes out of them may not be the one that went in."""
    tracks, own, seen, merged = tracks_of(straight()), np.ones((40, 4), bool), sightings(straight()), np.zeros(80, bool)
    assert _merged(tracks, own, seen, merged) == []
    own[(tracks.id == 0) & (tracks.cloud.frame >= 5) & (tracks.cloud.frame < 9), 1:] = False
    assert [(d.kind, d.first, d.last, d.tracks) for d in _merged(tracks, own, seen, merged)] == [("merge", 5, 8, (0,))]


def test_a_track_that_was_followed_by_images_of_others_is_merged():
    """Also where these points were given up since."""
    shared = np.zeros((2, 20, 2), bool)
    shared[0, 5:9, 0] = True
    left = tracks_of(straight(), missing=[(0, slice(5, 9))])
    decisions = _merged(left, np.ones((36, 4), bool), sightings(straight(), shared=shared), np.zeros(80, bool))
    assert [(d.kind, d.first, d.last, d.tracks) for d in decisions] == [("merge", 5, 8, (0,))]


@pytest.mark.parametrize(("apart", "found"), [(10.0, 1), (400.0, 0)])
def test_tracks_that_were_lost_together_may_be_exchanged_where_they_are_near(apart, found):
    tracks = tracks_of(straight(apart=apart), missing=[(0, slice(8, 12)), (1, slice(9, 13))])
    decisions = _possible_exchanges(tracks, np.ones((len(tracks.id), 4), bool), METHOD)
    assert [(d.kind, d.first, d.last, d.tracks) for d in decisions] == [("swap", 8, 12, (0, 1))] * found


@pytest.mark.parametrize("seen_on", [0, 1])
def test_tracks_that_other_cameras_see_from_one_frame_to_the_next_may_be_exchanged(seen_on):
    """An image of each in the same camera before and after tells that it is the same marker."""
    tracks = tracks_of(straight(apart=1.0))
    own = np.tile([True, True, False, False], (len(tracks.id), 1))
    own[tracks.cloud.frame >= 10] = [False, seen_on, True, True]
    decisions = _possible_exchanges(tracks, own, METHOD)
    assert [(d.first, d.last, d.tracks) for d in decisions] == [(9, 10, (0, 1))] * (not seen_on)


def test_an_exchange_is_as_likely_as_what_comes_of_it():
    """Of two tracks that were exchanged in a gap the margin is that of those that were not, the other way round."""
    paths = straight(apart=10.0)
    exchanged = np.concatenate([paths[:, :10], paths[::-1, 10:]], 1)
    missing = [(0, slice(8, 12)), (1, slice(8, 12))]
    every = [tracks_of(xyz, missing=missing) for xyz in (paths, exchanged)]
    right, wrong = (possible_exchanges(one, np.ones((len(one.id), 4), bool), METHOD).margin for one in every)
    assert right == pytest.approx(-wrong) and right > 0


def test_of_many_tracks_that_were_lost_together_the_likeliest_exchanges_of_each_are_listed():
    tracks = tracks_of(straight(4, apart=10.0), missing=[(k, slice(8, 12)) for k in range(4)])
    own = np.ones((len(tracks.id), 4), bool)
    assert {d.tracks for d in _possible_exchanges(tracks, own, METHOD)} == {(0, 1), (1, 2), (2, 3)}


@pytest.fixture(scope="module")
def result():
    """Of six markers in six cameras."""
    detections, _ = observe(ring(6), dance(n=6, frames=40), noise=0.1)
    return track_simultaneously(detections, ring(6), METHOD)


def test_a_track_of_little_evidence_may_be_a_ghost(result):
    assert _little_evidence(result) == []
    track = int(result.id[0])
    own = np.flatnonzero(result.id[: len(result.evidence)] == track)
    speaks = result.evidence.copy()
    speaks[own] = (WEAK_EVIDENCE - 0.1) / len(own)
    (decision,) = _little_evidence(result._replace(evidence=speaks))
    assert (decision.kind, decision.tracks) == ("ghost", (track,))


def test_joins_are_doubted_at_their_gap():
    """Also where a piece was itself stitched before: the gap is that between the pieces that meet there."""
    path = np.stack([np.linspace(0, 600, 121), np.zeros(121), np.full(121, 1000.0)], -1)
    pieces = np.stack([path] * 3)
    pieces[0, 40:], pieces[1, :43], pieces[1, 80:], pieces[2, :84] = (np.nan,) * 4
    found = stitched(points(pieces), 0.01, METHOD).stitches
    assert {(stitch.last, stitch.first) for stitch in found} == {(39, 43), (79, 84)}
    rest = stitched(points(pieces[:, :, :]), 0.01, replace(METHOD, max_gap=0.045)).stitches
    assert {(stitch.last, stitch.first) for stitch in rest} == {(39, 43)}


@pytest.mark.parametrize(
    ("margin", "sd", "reason"),
    [
        (1.5 * CLEAR_MARGIN, 1.0, "stitched_with_rival"),
        (3 * CLEAR_MARGIN, 0.6 * METHOD.uncertain_sd, "stitched_over_wide_gap"),
        (0.5 * CLEAR_MARGIN, 1.0, "not_stitched_with_rival"),
        (3 * CLEAR_MARGIN, 0.4 * METHOD.uncertain_sd, None),
    ],
)
def test_joins_with_a_rival_or_over_a_wide_gap_are_doubts(result, margin, sd, reason):
    decisions = _close_stitches(result._replace(stitches=[Stitch(0, 1, 2 * margin, margin, sd, 10, 15)]), METHOD)
    assert [decision.reason for decision in decisions] == ([] if reason is None else [reason])
    assert all(decision.values == {"margin": margin, "sd_mm": sd} for decision in decisions)
    assert [AmbiguousDecision.of(decision.as_dict()) for decision in decisions] == decisions


# What is found of the input


@pytest.fixture(scope="module")
def seen():
    xyz, rig = dance(n=12, frames=80), ring(6)
    return rig, xyz, observe(rig, xyz, noise=0.1)[0]


def staged(detections, rig):
    """Tracks of the former stages, one after the other."""
    return track(reconstruct(match(detections, rig), detections, rig))


def test_a_camera_that_starts_late_is_named(seen):
    rig, _, detections = seen
    late = detections.keep((detections.camera != 2) | (detections.frame >= 30))
    for findings in (
        diagnose(late, rig, track_simultaneously(late, rig, METHOD)),
        diagnose_tracks(late, rig, staged(late, rig)),
    ):
        (found,) = findings
        assert (found.kind, found.cameras, found.frames) == ("camera_started_late", ("c2",), ((0, 29),))


def test_a_camera_whose_view_the_markers_enter_late_did_not_start_late():
    """And one whose view they leave did not stop."""
    rig, xyz = ring(6), dance(n=12, frames=80)
    detections, _ = observe(rig, xyz, noise=0.1)
    away = rig[2].R.copy()
    turned = replace(rig[2], R=np.diag([-1.0, 1, -1]) @ away, t=-np.diag([-1.0, 1, -1]) @ away @ rig[2].centre)
    looks_away = replace(rig, cameras=tuple(turned if c == 2 else rig[c] for c in range(6)))
    for own in (detections.frame >= 30, detections.frame < 50):
        some = detections.keep((detections.camera != 2) | own)
        findings = diagnose(some, looks_away, track_simultaneously(some, looks_away, METHOD))
        assert not {one.kind for one in findings} & {"camera_started_late", "camera_stopped"}


def test_speeds_that_nobody_has_name_the_rate(seen):
    rig, _, detections = seen
    tracks = staged(detections, rig)
    assert diagnose_tracks(detections, rig, tracks) == []
    fast = Tracks(replace(tracks.cloud, rate=2000.0), tracks.id)
    (found,) = diagnose_tracks(replace(detections, rate=2000.0), rig, fast)
    assert (found.kind, found.values["rate_hz"]) == ("speeds_impossible", 2000.0)
    assert found.values["speed_m_s"] > 15


def test_what_is_noticed_does_not_depend_on_who_made_the_tracks(seen):
    rig, _, detections = seen
    beside = replace(detections, uv=detections.uv + (detections.camera == 3)[:, None] * [2.0, 0.0])
    ours = diagnose(beside, rig, track_simultaneously(beside, rig, METHOD))
    theirs = diagnose_tracks(beside, rig, staged(beside, rig))
    (found,) = ours
    assert (found.kind, found.cameras, found.frames) == ("camera_put_right", ("c3",), ())
    assert found.values["offset_u_px"] == pytest.approx(2.0, abs=0.05)
    assert [(one.kind, one.cameras, one.frames) for one in theirs] == [("camera_shifted", found.cameras, found.frames)]
    assert {k: theirs[0].values[k] for k in found.values} == pytest.approx(dict(found.values), abs=0.05)


def test_a_shift_is_said_to_be_since_when_it_was(seen):
    rig, _, detections = seen
    for since in (0, 40):
        those = (detections.camera == 3) & (detections.frame >= since)
        beside = replace(detections, uv=detections.uv + those[:, None] * [3.0, 1.0])
        (found,) = diagnose(beside, rig, track_simultaneously(beside, rig, METHOD))
        offset = found.values["offset_u_px"], found.values["offset_v_px"]
        assert found.kind == "camera_put_right"
        assert offset == pytest.approx((3.0, 1.0), abs=0.05) and found.frames == (((since, 79),) if since else ())


@pytest.mark.parametrize(("a_frame", "kind"), [(0.0, "camera_put_right"), (0.06, "camera_moved")])
def test_images_in_no_track_that_lie_beside_by_the_same_are_of_a_shift(seen, a_frame, kind):
    rig, _, detections = seen
    by = np.where(detections.frame >= 40, 4.0 + a_frame * (detections.frame - 40), 0.0) * (detections.camera == 3)
    beside = replace(detections, uv=detections.uv + by[:, None] * [1.0, 0.0])
    tracked = track_simultaneously(beside, rig, METHOD)
    cloud = tracked.tracks.cloud
    has = (cloud.detection[cloud.frame >= 40, 3] >= 0).mean()
    assert has > 0.9 if kind == "camera_put_right" else has < 0.05
    (found,) = diagnose(beside, rig, tracked)
    assert (found.kind, found.cameras, found.frames) == (kind, ("c3",), ((40, 79),))


def test_a_shift_that_comes_little_by_little_is_of_the_place(seen):
    """As a subject walks through the volume of a calibration that fits less well on one side."""
    rig, _, detections = seen
    along = (detections.camera == 3) * np.clip(detections.frame - 10, 0, None) / 60
    drifting = replace(detections, uv=detections.uv + along[:, None] * [1.2, 0.6])
    assert diagnose(drifting, rig, track_simultaneously(drifting, rig, METHOD)) == []


def test_the_last_tenth_alone_tells_no_small_shift(seen):
    rig, _, detections = seen
    last = (detections.camera == 3) & (detections.frame >= 72)
    for by, kinds in ((0.7, []), (4.0, ["camera_moved"])):
        beside = replace(detections, uv=detections.uv + last[:, None] * [by, 0.0])
        found = diagnose(beside, rig, track_simultaneously(beside, rig, METHOD))
        assert [one.kind for one in found] == kinds


def test_a_calibration_that_is_off_in_all_cameras_touched_none(seen):
    rig, _, detections = seen
    by = np.array([[1.4, 0.5], [-0.9, 1.2], [0.4, -1.5], [-1.3, -0.9], [1.2, -0.9], [-0.9, 1.4]])
    off = replace(detections, uv=detections.uv + by[detections.camera])
    (found,) = diagnose(off, rig, track_simultaneously(off, rig, METHOD))
    assert found.kind == "calibration_off" and len(found.cameras) >= 3
    assert 0.5 < found.values["offset_px"] < 2
    touched = replace(off, uv=off.uv + (detections.camera == 3)[:, None] * [-8.0, 0.0])
    kinds = {one.kind: one.cameras for one in diagnose(touched, rig, track_simultaneously(touched, rig, METHOD))}
    assert kinds["camera_shifted"] == ("c3",)


def test_only_our_own_method_says_that_a_camera_was_left_out(seen):
    rig, _, detections = seen
    order = [0, 4, 2, 3, 1, 5]
    wrong = replace(rig, cameras=tuple(replace(rig[k], name=n) for k, n in zip(order, rig.names, strict=True)))
    ours = diagnose(detections, wrong, track_simultaneously(detections, wrong, METHOD))
    theirs = diagnose_tracks(detections, wrong, staged(detections, wrong))
    assert len(ours) == len(theirs) == 2
    assert all(one.values["left_out"] for one in ours) and not any(one.values["left_out"] for one in theirs)


def test_points_without_an_identity_say_nothing_of_speed(seen):
    rig, _, detections = seen
    tracks = staged(detections, rig)
    some = Tracks(tracks.cloud, np.where(tracks.id < 6, tracks.id, -1))
    assert diagnose_tracks(detections, rig, some) == []


def test_two_cameras_and_nothing_seen_are_no_trouble():
    rig = ring(2)
    for n in (0, 3):
        detections, _ = observe(rig, dance(n=n, frames=12))
        assert diagnose_tracks(detections, rig, staged(detections, rig)) == ([] if n else diagnose_tracks(*blind(rig)))


def blind(rig):
    """Twelve frames in which nobody sees anything."""
    detections, _ = observe(rig, np.zeros((0, 12, 3)))
    return detections, rig, staged(detections, rig)


# What decides


def test_evidence_is_what_its_formula_says():
    """For a gate of 5: 1.4 for two images that fit perfectly, 4.1 for three, and little against it however bad."""
    for n, squared, wanted in ((2, 0.0, 1.383), (3, 0.0, 4.149), (3, 6.0, 0.942), (2, 6.0, -0.908), (3, 1e4, -99.0)):
        row = np.arange(3)[:, None]
        none = np.zeros((3, 1), bool)
        one = Associations(
            np.array([0]),
            np.array([0]),
            row,
            none,
            np.array([squared]),
            np.ones(1),
            np.zeros((3, 1)),
            np.eye(3)[..., None],
        )
        assert evidence(one, row < n, 5.0)[0] == pytest.approx(max(wanted, np.log(WEAK)), abs=2e-3)


def test_of_two_that_end_neither_takes_the_one_that_begins():
    path = np.stack([np.linspace(0, 600, 61), np.zeros(61), np.full(61, 1000.0)], -1)
    one, other = in_pieces(path, 3)
    twin = np.where(np.isfinite(one), one + np.array([0, 2.0, 0]), np.nan)
    assert stitched(points(np.stack([one, twin, other])), 0.01, METHOD).id.tolist() == [0, 1, 2]


def places(xyz, frame, sd=1.0):
    """CandidatePoints of three images each at places (G, 3)."""
    n = len(xyz)
    cov = np.broadcast_to((np.eye(3) * sd**2)[..., None], (3, 3, n))
    return CandidatePoints(
        np.full(n, frame), np.asarray(xyz, float).T, cov, np.zeros((3, n), int), np.zeros(n), np.ones(n)
    )


def test_of_three_frames_the_straightest_and_slowest_begin_a_track():
    T = 0.01
    first = places([[0, 0, 0]], 0)
    middle = places([[5, 6, 0], [5, 0, 0]], 1)
    last = places([[10, 0, 0], [10, 9, 0]], 2)
    assert [k.tolist() for k in _triples(first, middle, last, T, METHOD)] == [[0], [1], [0]]
    far = places([[60, 0, 0], [5, 0, 0]], 1), places([[120, 0, 0], [10, 0, 0]], 2)  # both straight
    assert [k.tolist() for k in _triples(first, *far, T, METHOD)] == [[0], [1], [1]]


@pytest.mark.parametrize(("share", "initiated"), [(0.98, 1), (1.02, 0)])
def test_three_points_bend_as_far_as_their_covariances_say(share, initiated):
    T, sd = 1e-4, 2.0  # so short that no acceleration matters
    quick = replace(METHOD, velocity_sd=1e9)
    bend = share * METHOD.gate * np.sqrt(6) * sd
    groups = [places([[0, y, 0]], f, sd) for f, y in enumerate((bend / 4, -bend / 4, bend / 4))]
    assert len(_triples(*groups, T, quick)[0]) == initiated


@pytest.mark.parametrize(("beside", "initiated"), [(0, 1), (3, 0)])
def test_at_few_frames_a_second_a_bend_begins_no_track_among_other_points(beside, initiated):
    """Of two markers seen in turn: at 25 Hz a bend of 90 mm is within the gate, and no rarer than a chance."""
    others = [[60, 100, 40 * k] for k in range(beside)]
    groups = places([[0, 0, 0]], 0), places([[0, 90, 0]], 1), places([[0, 90, 0], *others], 2)
    assert len(_triples(*groups, 0.04, METHOD)[0]) == initiated


def test_points_less_sure_than_asked_for_are_not_given():
    """Two cameras side by side know the depth poorly."""
    rig = ring(12).select(["c0", "c1"])
    detections, _ = observe(rig, dance(n=8, frames=40), noise=0.3)
    every, sure = (track_detections(detections, rig, method=Simultaneous(max_sd=worst)).cloud for worst in (20.0, 2.0))
    sd = np.sqrt(np.trace(every.cov, axis1=1, axis2=2))
    assert sd.max() > 2.0 and len(sure) < len(every)
    assert (np.sqrt(np.trace(sure.cov, axis1=1, axis2=2)) < 2.0).all()


def test_a_track_does_not_outlive_what_is_known_of_its_place():
    """All cameras are blind for half a second: what comes after it is another track, however patient the method."""
    rig, xyz = ring(6), dance(n=6, frames=110)
    detections, _ = observe(rig, xyz, noise=0.1)
    blind = detections.keep((detections.frame < 30) | (detections.frame >= 80))
    patient = Simultaneous(max_coasting=2.0, max_gap=0.011)
    tracks = track_detections(blind, rig, method=patient)
    assert score(tracks, xyz).fragments.tolist() == [2] * 6
