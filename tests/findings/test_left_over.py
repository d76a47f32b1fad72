"""Images of no point: lamps and flicker are no markers that were missed; images that move on are."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from kinemark.data import Cloud, Detections, Finding, MarkerTrajectory, Tracks, Trajectories
from kinemark.findings.left_over import NEAR_PX, left_over
from kinemark.geometry import project
from kinemark.report.words import advice_of, text_of
from support.captures import RATE, judge, ring
from support.findings import found

LAMPS, FLICKER, FRAMES = 6, 4, 200


def crossing(markers):
    """(M, F, 3) mm: markers that cross the volume side by side."""
    t = np.linspace(0, 4, FRAMES)
    path = np.stack([300 * np.sin(t), 200 * np.sin(2 * t), 1000 + 50 * t], -1)
    return path + 90.0 * np.arange(markers)[:, None, None] * np.array([0.2, 1, 1.0])


def seen_beside(rig, xyz, *, tracked, lamps=0, flicker=0, known=None, wander=0.2):
    """Records of markers (M, F, 3), of which the first `tracked` are points, where `known` (F, M) or always.

    Each camera sees lamps in eight of ten frames, with a standard deviation `wander` px, and flicker.
    """
    rng, n = np.random.default_rng(4), xyz.shape[1]
    known = np.ones((n, tracked), bool) if known is None else known
    detection, rows, counts = np.full((n, tracked, len(rig)), -1), [], np.zeros((len(rig), n), int)
    for c, camera in enumerate(rig):
        places = rng.uniform([0, 0], [640, 480], (lamps, 2))
        for f in range(n):
            on = places[rng.random(lamps) < 0.8]
            also = [on + rng.normal(0, wander, on.shape), rng.uniform([0, 0], [640, 480], (flicker, 2))]
            detection[f, :, c] = sum(map(len, rows)) + np.arange(tracked)
            rows.append(np.concatenate([project(camera, xyz[:, f]), *also]))
            counts[c, f] = len(rows[-1])
    frame, marker = np.nonzero(known)
    cov = np.broadcast_to(0.25 * np.eye(3), (len(frame), 3, 3))
    start = np.searchsorted(frame, np.arange(n + 1))
    points = xyz[marker, frame]
    cloud = Cloud(RATE, start, points, cov, np.zeros(len(frame)), detection[frame, marker])
    told = {"cov": np.broadcast_to(0.25 * np.eye(3), (n, 3, 3)), "cameras": np.full(n, 2 ** len(rig) - 1)}
    paths = [np.where(known[:, m, None], xyz[m], np.nan) for m in range(tracked)]
    named = tuple(MarkerTrajectory.measured(f"m{m}", path, **told) for m, path in enumerate(paths))
    return {
        "detections": Detections.build(rig.names, RATE, counts, np.concatenate(rows)),
        "tracks": Tracks(cloud, marker),
        "trajectories": Trajectories(named, RATE),
    }


def test_lamps_and_flicker_are_named_and_are_no_markers_that_were_missed():
    """Two thirds of the images are no marker's, and all markers are there: it was red."""
    rig = ring()
    figures = judge(rig, seen_beside(rig, crossing(4), tracked=4, lamps=LAMPS, flicker=FLICKER))
    assert figures["verdict"]["grade"] == "green"
    assert {one["kind"] for one in figures["findings"]} == {"reflections_standing", "images_fleeting"}
    assert [camera["standing_spots"] for camera in figures["cameras"]] == [LAMPS] * len(rig)
    (standing,), (fleeting,) = (found(figures, kind) for kind in ("reflections_standing", "images_fleeting"))
    first = figures["cameras"][1]["standing_at"][0]
    assert f"{rig.names[1]} {LAMPS}, at ({first[0]:.0f}, {first[1]:.0f})" in text_of(
        standing
    ) and "[masks]" in advice_of(standing)
    assert fleeting.cameras == rig.names
    valid, used = 4 + 0.8 * LAMPS + FLICKER, 4
    for camera in figures["cameras"]:
        assert abs(camera["used_of_valid_share"] - used / valid) < 0.02
        assert abs(camera["standing_share"] - 0.8 * LAMPS / valid) < 0.02
        assert 0.8 * FLICKER / valid < camera["fleeting_share"] < 1.05 * FLICKER / valid


@pytest.mark.parametrize("wander", [0.6, 0.9, 1.2])
def test_a_lamp_whose_images_wander_is_one_place(wander):
    """Its pixel was printed twice."""
    rig = ring()
    records = seen_beside(rig, crossing(4), tracked=4, lamps=LAMPS, wander=wander)
    for camera in left_over(records["detections"], records["tracks"]):
        assert camera["standing_spots"] == LAMPS
        assert pdist(camera["standing_at"]).min() > 2 * NEAR_PX


def test_images_of_no_point_that_move_on_are_told_as_unused():
    """As where the calibration is wrong for a part of the volume."""
    rig = ring()
    figures = judge(rig, seen_beside(rig, crossing(16), tracked=4))
    assert [(one["kind"], one["severity"]) for one in figures["findings"]] == [("detections_unused", "red")]
    assert all(camera["standing_spots"] == camera["fleeting_share"] == 0 for camera in figures["cameras"])


def test_nothing_stands_out_where_the_markers_stand_or_none_was_found():
    rig, still = ring(), np.repeat(crossing(12)[:, :1], FRAMES, axis=1)
    for tracked in (3, 0):
        records = seen_beside(rig, still, tracked=tracked)
        for camera in left_over(records["detections"], records["tracks"]):
            assert camera == {"standing_spots": 0, "standing_at": [], "standing_share": 0.0, "fleeting_share": 0.0}


def test_markers_that_were_hidden_are_missing_less_badly_than_those_that_the_cameras_saw():
    rig, there = ring(), np.ones((FRAMES, 8), bool)
    there[50:150, :4] = False
    hidden = crossing(8)
    records = seen_beside(rig, hidden, tracked=8, known=there)
    assert [one.severity for one in found(judge(rig, records), "incomplete")] == ["red"]
    used = np.unique(records["tracks"].cloud.detection)
    seen = records["detections"].keep(np.isin(np.arange(len(records["detections"])), used))
    cloud = records["tracks"].cloud
    again = np.searchsorted(used, cloud.detection)
    cloud = Cloud(RATE, cloud.start, cloud.xyz, cloud.cov, cloud.residual, again)
    records |= {"detections": seen, "tracks": Tracks(cloud, records["tracks"].id)}
    assert [one.severity for one in found(judge(rig, records), "incomplete")] == ["amber"]


def test_markers_that_the_images_show_and_nobody_found_count_as_missing():
    """Of tracks without names: 16 markers are seen, and the 11 that are followed were said to be all that there are."""
    rig = ring()
    records = seen_beside(rig, crossing(16), tracked=11, flicker=FLICKER)
    nameless = (replace(one, name=f"*{k + 1}") for k, one in enumerate(records["trajectories"]))
    figures = judge(rig, records | {"trajectories": Trajectories(tuple(nameless), RATE)})
    markers = figures["trajectories"]
    assert (markers["markers_worn"], markers["markers_shown"]) == (11, 16)
    assert markers["completeness_of_found_share"] == 1
    assert abs(markers["completeness_in_view_share"] - 11 / 16) < 0.01
    assert [one.severity for one in found(figures, "incomplete")] == ["red"]
    (complete,) = (Finding.of(one) for one in figures["verdict"]["statements"] if one["kind"] == "completeness")
    assert "about 16 markers" in text_of(complete)
    figures = judge(rig, records)  # names say what there is
    assert figures["trajectories"]["completeness_in_view_share"] == 1
