"""What the tracker makes of gaps, close calls, and troubled input."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Rig
from kinemark.synth.score import changes, score
from kinemark.track.simultaneous import Simultaneous, diagnose, track_simultaneously, track_with_decisions
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.candidate_points import fundamentals
from kinemark.track.simultaneous.joining.stitch import CLEAR_MARGIN, stitched
from kinemark.track.simultaneous.noise.measurement_noise import learn_noise
from kinemark.track.simultaneous.points.neighbouring_points import TrackPoints, smoothed
from support.clouds import points
from support.laboratory import observe, ring
from support.motions import body, dance, in_pieces

METHOD = Simultaneous()


@pytest.mark.parametrize("gap", [1, 5, 10])
def test_pieces_join_by_their_motion(gap):
    paths = dance(n=4, frames=80)
    whole = stitched(points(np.concatenate([in_pieces(paths[0], gap), paths[1:]])), 0.01, METHOD)
    assert whole.id.tolist() == [0, 0, 2, 3, 4]


def test_a_long_gap_is_joined_by_distances_and_not_without_them():
    paths = body(frames=130)
    pieces = in_pieces(paths[0], 45)
    with_mates = stitched(points(np.concatenate([pieces, paths[1:]])), 0.01, METHOD)
    assert with_mates.id[1] == 0
    assert stitched(points(pieces), 0.01, METHOD).id[1] == 1
    others = np.concatenate([in_pieces(paths[0], 45)[:1], in_pieces(paths[1], 45)[1:], paths[2:]])
    assert stitched(points(others), 0.01, METHOD).id[1] == 1  # what begins is another one


def test_two_that_might_both_be_are_not_joined():
    path = np.stack([np.linspace(0, 600, 61), np.zeros(61), np.full(61, 1000.0)], -1)
    one, other = in_pieces(path, 3)
    twin = np.where(np.isfinite(other), other + np.array([0, 2.0, 0]), np.nan)
    both = stitched(points(np.stack([one, other, twin])), 0.01, METHOD)
    assert both.id.tolist() == [0, 1, 2]
    assert any(stitch.before == 0 and stitch.margin < CLEAR_MARGIN for stitch in both.stitches)


def test_smoothing_is_surer_than_the_images_and_as_sure_as_it_says():
    paths = dance(n=40, frames=21, seed=2)
    cloud = points(paths, sd=0.5)
    vague = cloud.frame == 10
    rng = np.random.default_rng(0)
    xyz, cov = cloud.xyz.copy(), np.array(cloud.cov)
    xyz[vague], cov[vague] = paths[cloud.id[vague], 10] + 10 * rng.normal(size=(40, 3)), np.eye(3) * 100
    smooth, left = smoothed(TrackPoints(cloud.frame, cloud.id, xyz, cov), vague, ~vague, 0.01, METHOD)
    off = smooth - paths[cloud.id[vague], 10]
    assert np.sqrt((off**2).sum(1).mean()) < 1.0
    squared = (off * np.linalg.solve(left, off[..., None])[..., 0]).sum(1)
    assert squared.mean() < 4.5  # 3 for a filter of just this motion; the dance is smoother than it allows for


@pytest.fixture(scope="module")
def ball():
    """A dance in six cameras."""
    rig, xyz = ring(6), dance(n=12, frames=80)
    detections, _ = observe(rig, xyz, noise=0.1)
    return rig, xyz, detections


def said(detections, rig, xyz, least=0.99):
    """The findings about a run that found the truth."""
    result = track_simultaneously(detections, rig, METHOD)
    found = score(result.tracks, xyz)
    assert found.recall >= least and found.swaps == 0
    return diagnose(detections, rig, result)


def test_nothing_is_said_of_good_input(ball):
    rig, xyz, detections = ball
    assert said(detections, rig, xyz) == []
    assert track_simultaneously(detections, rig, METHOD).noise.added.max() == 0


@pytest.mark.parametrize("true", [0.15, 0.6])
def test_noise_that_nobody_states_is_learned(true):
    rig, xyz = ring(6), dance(n=12, frames=40)
    detections, _ = observe(rig, xyz, noise=true, cov=False)
    images = read_images(detections, rig)
    images, _ = learn_noise(images, fundamentals(images.P), 5.0)
    assert np.sqrt(np.median(images.variance)) == pytest.approx(true, rel=0.25)


def test_a_camera_that_is_noisier_than_it_says(ball):
    rig, xyz, detections = ball
    uv = (
        detections.uv
        + (detections.camera == 2)[:, None] * np.random.default_rng(1).normal(size=detections.uv.shape) * 0.8
    )
    result = track_simultaneously(replace(detections, uv=uv), rig, METHOD)
    assert np.flatnonzero(result.noise.added).tolist() == [2] and result.noise.added[2] == pytest.approx(0.8, rel=0.3)
    assert score(result.tracks, xyz).recall > 0.99


def test_a_camera_two_pixels_off_is_named(ball):
    rig, xyz, detections = ball
    uv = detections.uv + (detections.camera == 3)[:, None] * [2.0, 0.0]
    (found,) = said(replace(detections, uv=uv), rig, xyz)
    assert (found.kind, found.cameras) == ("camera_put_right", (rig.names[3],))
    assert found.values["offset_u_px"] == pytest.approx(2.0, abs=0.1)


def test_cameras_in_the_wrong_order_are_named(ball):
    rig, xyz, detections = ball
    order = [0, 4, 2, 3, 1, 5]
    wrong = Rig(tuple(replace(rig[k], name=name) for k, name in zip(order, rig.names, strict=True)))
    findings = said(detections, wrong, xyz, least=0.9)
    assert [one.kind for one in findings] == ["camera_takes_place_of_other"] * 2
    assert {one.cameras for one in findings} == {(rig.names[1], rig.names[4]), (rig.names[4], rig.names[1])}


def test_a_camera_that_stops_is_named(ball):
    rig, xyz, detections = ball
    (found,) = said(detections.keep((detections.camera != 1) | (detections.frame < 40)), rig, xyz)
    assert (found.kind, found.cameras, found.frames) == ("camera_stopped", (rig.names[1],), ((40, 79),))


def test_a_camera_that_was_moved_is_named(ball):
    rig, xyz, detections = ball
    moved = (detections.camera == 5) & (detections.frame >= 40)
    uv = detections.uv + moved[:, None] * [15.0, 6.0]
    (found,) = said(replace(detections, uv=uv), rig, xyz)
    assert (found.kind, found.cameras, found.frames) == ("camera_moved", (rig.names[5],), ((40, 79),))


def test_an_impossible_rate_is_named(ball):
    rig, _, detections = ball
    fast = replace(detections, rate=5000.0)
    found = diagnose(fast, rig, track_simultaneously(fast, rig, METHOD))
    assert any(one.kind in ("speeds_impossible", "nothing_goes_on") for one in found)


def crossing(frames=40, apart=6.0):
    """Two points that come near each other, stop as one, and part again, (2, F, 3) mm."""
    x = np.linspace(-1, 1, frames)
    y = np.sign(x) * np.maximum(np.abs(x) - 0.15, 0) * 400
    one = np.stack([x * 50, y + apart / 2, np.full(frames, 1000.0)], -1)
    other = np.stack([x * 50, -y - apart / 2, np.full(frames, 1000.0)], -1)
    return np.stack([one, other])


def test_a_swap_is_among_the_doubts():
    """Two points meet out of sight, and what comes out of it is anybody's guess."""
    rig, swaps = ring(3), 0
    for seed in range(6):
        xyz = crossing()
        detections, _ = observe(rig, xyz, noise=0.3, seed=seed)
        hidden = np.isin(detections.frame, np.arange(18, 22))
        tracks, found = track_with_decisions(detections.keep(~hidden), rig)
        result = score(tracks, xyz)
        for track, frame, *_ in changes(tracks, result.owner, xyz):
            swaps += 1
            assert any(
                d.kind in ("swap", "stitch") and track in d.tracks and d.first - 8 <= frame <= d.last + 8 for d in found
            )
    assert swaps > 0


def test_good_input_raises_no_doubts(ball):
    rig, _, detections = ball
    tracks, found = track_with_decisions(detections, rig)
    assert len(tracks) == 12 and found == []


def left_lying(gone):
    """A dance that is in view but in the frames `gone`, and four markers that lie about all the time in sight of two of
    ten cameras."""
    rig, dancing = ring(10), dance(n=12, frames=160)
    dancing[:, gone] = np.nan
    lying = np.broadcast_to(np.array([[0.0, 0, 0], [300, 0, 0], [0, 300, 0], [300, 300, 40]])[:, None], (4, 160, 3))
    detections, marker = observe(rig, np.concatenate([dancing, lying + np.array([200.0, 0, 500])]), noise=0.1)
    return rig, detections.keep((marker < 12) | (detections.camera < 2))


@pytest.mark.parametrize("gone", [slice(90, 160), slice(0, 70), slice(50, 110)], ids=["out", "in", "between"])
def test_a_subject_that_leaves_stops_no_camera(gone):
    rig, detections = left_lying(gone)
    result = track_simultaneously(detections, rig, METHOD)
    assert (result.tracks.cloud.frame >= 150).any() and diagnose(detections, rig, result) == []


def test_a_camera_that_stops_before_the_subject_leaves_is_named():
    rig, detections = left_lying(slice(120, 160))
    stopped = detections.keep((detections.camera != 4) | (detections.frame < 60))
    (found,) = diagnose(stopped, rig, track_simultaneously(stopped, rig, METHOD))
    assert (found.kind, found.cameras, found.frames) == ("camera_stopped", ("c4",), ((60, 159),))


def test_a_camera_from_which_few_markers_turn_away_has_not_stopped():
    """Two markers on the front and back of something that turns twice are out of sight of each camera half of the
    time, also at the end."""
    rig, frames = ring(6), 240
    t = np.arange(frames) / 100
    angle = 2 * np.pi * 0.83 * t + np.array([[0.0], [0.3]])
    normal = np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)
    paths = normal * 120 + np.array([[[0, 0, 900.0]], [[0, 0, 1100.0]]])
    seen, truth = observe(rig, paths, noise=0.1)
    toward = rig.centres[seen.camera] - paths[truth, seen.frame]
    detections = seen.keep((toward * normal[truth, seen.frame]).sum(1) > 0)
    result = track_simultaneously(detections, rig, METHOD)
    assert score(result.tracks, paths).recall > 0.9
    assert not {"camera_stopped", "camera_started_late"} & {one.kind for one in diagnose(detections, rig, result)}
