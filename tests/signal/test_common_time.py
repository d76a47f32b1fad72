"""Detections of cameras that are not synchronous, moved to the times of the frames."""

import numpy as np
import pytest

from kinemark.data import Detections
from kinemark.signal.common_time import at_common_time, nearest_images
from kinemark.track.simultaneous import Simultaneous, track_detections
from support.laboratory import observe, ring

N, SECONDS = 12, 1.2


def places(t):
    """(N, F, 3) mm of markers on circles at times t (F) s, at up to 1.9 m/s."""
    rng = np.random.default_rng(3)
    centre = np.column_stack([rng.permutation(N) * 150.0 - 900, rng.uniform(-400, 400, N), rng.uniform(500, 1500, N)])
    radius, turn, phase = rng.uniform(100, 300, N), rng.uniform(0.5, 1.0, N), rng.uniform(0, 2 * np.pi, N)
    angle = 2 * np.pi * turn[:, None] * t + phase[:, None]
    circle = np.stack([np.cos(angle), np.sin(angle), 0.5 * np.sin(2 * angle)], -1)
    return centre[:, None] + radius[:, None, None] * circle


def recorded(rig, rate, delays, rates=None, noise=0.1):
    """What cameras see that take their images by (1), and which point each detection is."""
    n, counts, uv, cov, marker = round(SECONDS * rate), [], [], [], []
    for c, delay in enumerate(delays):
        own = rates[c] if rates else rate
        one, truth = observe(rig, places(np.arange(n) / own + delay), noise=noise, rate=rate, seed=c)
        mine = one.camera == c
        counts.append(one.counts[c])
        uv.append(one.uv[mine])
        cov.append(one.cov[mine])
        marker.append(truth[mine])
    detections = Detections.build(rig.names, rate, np.array(counts), np.concatenate(uv), np.concatenate(cov))
    return detections, np.concatenate(marker)


def recall_and_error(tracks, rate):
    """The share of samples that have a point within 10 mm, and the RMS distance of these, mm."""
    xyz, cloud = places(np.arange(round(SECONDS * rate)) / rate), tracks.cloud
    off = np.array(
        [
            np.linalg.norm(cloud[f] - xyz[m, f], axis=1).min(initial=np.inf)
            for f in range(5, cloud.n_frames - 5)
            for m in range(N)
        ]
    )
    found = off < 10
    return found.mean(), np.sqrt((off[found] ** 2).mean()), len(tracks)


@pytest.mark.parametrize(("rate", "ms"), [(50, 8), (100, 2), (100, 13), (250, 20)])
def test_known_delays_cost_nothing(rate, ms):
    rig = ring(5)
    delays = np.array([0, ms, 0, -ms / 2, 0]) / 1000
    together = recall_and_error(track_detections(recorded(rig, rate, np.zeros(5))[0], rig, method=Simultaneous()), rate)
    late, _ = recorded(rig, rate, delays)
    moved = recall_and_error(
        track_detections(at_common_time(late, delays).detections, rig, method=Simultaneous()), rate
    )
    assert moved[0] >= together[0] - 0.002
    assert moved[1] < 1.15 * together[1] + 0.02
    assert moved[2] <= together[2] + 1


def test_cameras_of_other_rates_meet_in_the_frames():
    rig, rates = ring(4), [100.0, 98.0, 101.5, 100.0]
    other, _ = recorded(rig, 100, np.zeros(4), rates)
    tracks = track_detections(at_common_time(other, np.zeros(4), rate=rates).detections, rig, method=Simultaneous())
    share, rms, count = recall_and_error(tracks, 100)
    assert (share > 0.99, count) == (True, N)
    assert rms < 0.6


def test_detections_lie_where_the_marker_was_at_the_time_of_the_frame():
    rig, delays = ring(3), np.array([0.0, 0.004, -0.017])
    late, marker = recorded(rig, 100, delays, noise=0.0)
    found = at_common_time(late, delays)
    there, truth = recorded(rig, 100, np.zeros(3), noise=0.0)
    known = {(c, f, m): uv for c, f, m, uv in zip(there.camera, there.frame, truth, there.uv, strict=True)}
    moved = found.detections
    keys = zip(moved.camera, moved.frame, marker[found.row], strict=True)
    off = np.array([np.linalg.norm(known[key] - uv) for key, uv in zip(keys, moved.uv, strict=True) if key in known])
    assert np.quantile(off, 0.95) < 0.05  # px; the marker moves by up to 5 px a frame
    assert np.isfinite(moved.cov).all()


def test_a_synchronous_recording_stays_as_it_is():
    rig = ring(3)
    detections, _ = recorded(rig, 100, np.zeros(3))
    found = at_common_time(detections, np.zeros(3))
    assert np.array_equal(found.row, np.arange(len(detections)))
    assert np.array_equal(found.detections.uv, detections.uv)
    assert np.array_equal(found.detections.cov, detections.cov)
    assert np.array_equal(found.detections.start, detections.start)


@pytest.mark.parametrize("first", [0, 40, 10_000])
def test_the_nearest_image_is_less_than_half_an_image_away(first):
    image, late = nearest_images(200, 100.0, 99.0, 0.013, first)
    assert (np.abs(late) <= 0.5 / 99 + 1e-12).all()
    there = np.flatnonzero(image >= 0)
    assert (image[there] + first) / 99 + 0.013 - (there + first) / 100 == pytest.approx(late[there], abs=1e-9)


def test_a_part_of_a_recording_is_moved_as_the_whole_is():
    rig, rates = ring(3), [100.0, 99.0, 101.0]
    whole, _ = recorded(rig, 100, np.zeros(3), rates)
    all_, part = at_common_time(whole, np.zeros(3), rate=rates), whole.frames(20, 100)
    some = at_common_time(part, np.zeros(3), rate=rates, first_frame=20)
    for c in range(3):
        for f in range(25, 95):
            assert some.detections[c, f - 20] == pytest.approx(all_.detections[c, f], abs=1e-9)


@pytest.mark.parametrize(("delay", "rate"), [([0, 0], None), ([0, 0, np.nan], None), ([0, 0, 0], [1, 0, 1])])
def test_what_is_not_one_a_camera_is_refused(delay, rate):
    detections, _ = recorded(ring(3), 50, np.zeros(3))
    with pytest.raises(ValueError, match="for each of 3 cameras"):
        at_common_time(detections, delay, rate=rate)


@pytest.mark.parametrize("rate", [50.0, 60.0, 100.0])
def test_cameras_of_fifty_and_sixty_hertz_last_equally_long(rate):
    rig, rates = ring(4), [50.0, 60.0, 50.0, 60.0]
    parts = [recorded(rig, own, np.zeros(4)) for own in (50.0, 60.0)]
    n = [round(SECONDS * own) for own in rates]
    counts = np.array([np.pad(parts[c % 2][0].counts[c], (0, max(n) - n[c])) for c in range(4)])
    rows = [parts[c % 2][0].camera == c for c in range(4)]
    uv, cov = (
        np.concatenate([getattr(parts[c % 2][0], name)[own] for c, own in enumerate(rows)]) for name in ("uv", "cov")
    )
    found = at_common_time(Detections.build(rig.names, rate, counts, uv, cov), np.zeros(4), rate=rates).detections
    assert abs(found.n_frames - SECONDS * rate) <= rate / 50
    share, rms, count = recall_and_error(track_detections(found, rig, method=Simultaneous()), rate)
    assert (share > 0.99, count) == (True, N)
    assert rms < 0.8
