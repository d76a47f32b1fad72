"""Which points are given, and what is said of the others: the volume, uncertain positions, pairs of images."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.report.words import text_of
from kinemark.track.simultaneous import Simultaneous, diagnose, diagnose_points, track_simultaneously
from kinemark.track.simultaneous.diagnosis.diagnostics_of_points import points_left_out
from support.laboratory import observe, ring
from support.motions import dance

METHOD = Simultaneous()


@pytest.fixture(scope="module")
def walked_out():
    """A rig with a small volume, detections of a dance of which half is outside, and the dance."""
    xyz = dance(n=8, frames=40)
    middle = np.median(xyz.reshape(-1, 3), axis=0)
    rig = replace(ring(5), volume=np.array([[-3000.0, -3000, 0], [middle[0], 3000, 3000]]))
    return rig, observe(rig, xyz, noise=0.1)[0]


@pytest.mark.parametrize("margin", [0.0, 50.0, 200.0])
def test_the_margin_of_the_volume_holds_and_what_is_left_out_is_told(walked_out, margin):
    rig, detections = walked_out
    every = track_simultaneously(detections, rig, METHOD, volume_margin=None)
    some = track_simultaneously(detections, rig, METHOD, volume_margin=margin)
    limit = rig.volume[1, 0] + margin
    assert some.tracks.cloud.xyz[:, 0].max() <= limit < every.tracks.cloud.xyz[:, 0].max()
    left_out = int((every.tracks.cloud.xyz[:, 0] > limit).sum())
    (found,) = diagnose_points(some, METHOD, margin)
    assert found.kind == "points_dropped_outside" and found.values["points"] == len(some.outside) == left_out > 0
    assert limit <= found.values["least_mm_list"][0] <= found.values["greatest_mm_list"][0]
    assert diagnose_points(every, METHOD, None) == []


def test_uncertain_positions_are_given_with_their_covariance_and_told():
    """Two cameras side by side know the depth poorly."""
    rig, xyz = ring(60).select(["c0", "c3"]), dance(n=8, frames=40)
    detections, marker = observe(rig, xyz, noise=0.8)
    result = track_simultaneously(detections, rig, METHOD)
    cloud = result.tracks.cloud
    sd = np.sqrt(np.trace(cloud.cov, axis1=1, axis2=2))
    uncertain = sd > METHOD.uncertain_sd
    seen = np.zeros(xyz.shape[:2], int)
    np.add.at(seen, (marker, detections.frame), 1)
    assert uncertain.any() and len(cloud) > 0.97 * (seen == 2).sum()
    (found,) = diagnose_points(result, METHOD, None)
    assert found.kind == "positions_uncertain" and found.values["points"] == uncertain.sum()
    inside = np.zeros(40, bool)
    for first, last in found.frames:
        inside[first : last + 1] = True
    assert np.flatnonzero(inside).tolist() == np.unique(cloud.frame[uncertain]).tolist()


@pytest.mark.parametrize("rate", [100.0, 250.0])
def test_markers_that_a_third_camera_never_sees_are_kept(rate):
    """However narrowly the motion holds them: two images leave one distance free, whatever was predicted."""
    rig, xyz = ring(8).select(["c0", "c1"]), dance(n=12, frames=100, rate=rate)
    detections, marker = observe(rig, xyz, noise=0.5, rate=rate)
    result = track_simultaneously(detections, rig, METHOD)
    seen = np.zeros(xyz.shape[:2], int)
    np.add.at(seen, (marker, detections.frame), 1)
    assert len(result.tracks.cloud) > 0.97 * (seen == 2).sum()


@pytest.mark.parametrize(("unit", "mm"), [("m", 1000.0), ("cm", 10.0), ("in", 25.4), (None, 1.0)])
def test_a_volume_in_another_unit_is_named_and_the_frame_rate_is_not_blamed(unit, mm):
    xyz = dance(n=8, frames=40)
    volume = np.stack([xyz.min((0, 1)) - 200, xyz.max((0, 1)) + 200]) / mm
    if unit is None:
        volume += 5000  # the right unit and the wrong place
    rig = replace(ring(5), volume=volume)
    detections = observe(rig, xyz, noise=0.1)[0]
    result = track_simultaneously(detections, rig, METHOD, volume_margin=0.0)
    assert len(result.outside) > 200 and len(result.tracks.cloud) <= 2
    found = diagnose_points(result, METHOD, 0.0, rig.volume)[0]
    assert found.values["unit"] == unit and found.severity == "red"
    assert ("probably not written in mm" in text_of(found)) == (unit is not None)
    assert "nothing_goes_on" not in [one.kind for one in diagnose(detections, rig, result)]


def test_a_volume_of_metres_that_the_subject_left_is_in_no_other_unit():
    """A walk of 14 m through a volume of 4: in metres it would be 4 km."""
    volume = np.array([[0.0, -600, -100], [4000, 600, 2000]])
    far = np.stack([np.linspace(4200, 9000, 50), np.zeros(50), np.full(50, 900.0)], axis=1)
    assert points_left_out(far, 20, 100.0, volume).values["unit"] is None
    assert points_left_out(far - [4000, 0, 0], 20, 100.0, volume / 1000).values["unit"] == "m"
