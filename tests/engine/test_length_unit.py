"""A calibration in another unit of length than mm, as its markers and where they are tell."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Cloud, Detections, Rig
from kinemark.engine.length_unit import length_unit
from kinemark.geometry import project
from kinemark.report.words import text_of
from support.laboratory import ring

RNG = np.random.default_rng(7)
PERSON = RNG.uniform([-300, -250, 0], [300, 250, 1750], (20, 3))
HAND = RNG.uniform(-80, 80, (20, 3)) + np.array([0, 0, 180])
CM, INCH = 0.1, 1 / 25.4


def scaled(rig, factor):
    return Rig(tuple(replace(camera, t=camera.t * factor) for camera in rig))


def said(points, written=1.0, *, marker_mm=np.nan, far=1.0):
    """What is found of points (N, 3) mm, seen from 4 m times `far`, where all lengths are written times a factor."""
    rig, n = scaled(ring(4), far), len(points)
    depth = np.concatenate([(points @ camera.R.T + camera.t)[:, 2] / camera.K[0, 0] for camera in rig])
    area = np.pi / 4 * (marker_mm / depth) ** 2
    uv = np.concatenate([project(camera, points) for camera in rig])
    detections = Detections.build(rig.names, 100.0, np.full((4, 1), n), uv, area=area)
    rows = np.arange(4 * n).reshape(4, n).T
    cloud = Cloud(100.0, np.array([0, n]), points * written, np.zeros((n, 3, 3)), np.zeros(n), rows)
    return list(length_unit(detections, scaled(rig, written), cloud))


@pytest.mark.parametrize("marker_mm", [np.nan, 6.5, 9.0, 14.0, 25.0])
def test_a_person_in_mm_is_not_doubted(marker_mm):
    assert said(PERSON, marker_mm=marker_mm) == []
    assert said(PERSON[:3], marker_mm=marker_mm) == []


@pytest.mark.parametrize("written", [CM, INCH, 1 / 304.8])
@pytest.mark.parametrize(("marker_mm", "severity"), [(np.nan, "info"), (14.0, "amber"), (25.0, None)])
def test_a_person_in_another_unit_is_told(written, marker_mm, severity):
    (found,) = said(PERSON, written, marker_mm=marker_mm)
    assert found.kind == "length_unit_doubtful"
    assert found.severity == (severity or ("info" if written == CM else "amber"))  # in cm 2.5, as those of a face
    assert ("wide" in text_of(found)) == np.isfinite(marker_mm)


@pytest.mark.parametrize("px", [4.0, 5.0])
def test_coarse_images_of_markers_make_them_no_larger(px):
    scale = ring(4).cameras[0].K[0, 0] / 900  # images of px at 12 m of a camera of 900 px
    assert said(PERSON, marker_mm=px * 4000 * 3 / 900 / 1, far=3.0 * scale / scale) == []


def test_areas_of_0_are_not_known():
    assert said(PERSON, marker_mm=0.0) == []


def test_markers_too_large_are_told():
    (found,) = said(PERSON, 10.0, marker_mm=14.0)  # in tenths of a mm
    assert found.severity == "amber" and found.values["marker_mm"] == pytest.approx(140.0, rel=0.05)


def test_a_hand_with_markers_of_5_mm_is_not_doubted_and_is_asked_about_where_no_size_is_known():
    assert said(HAND, marker_mm=5.0, far=0.2) == []
    (found,) = said(HAND, far=0.2)
    assert found.severity == "info" and found.values["distance_mm"] == pytest.approx(800, rel=0.1)


def test_without_points_nothing_is_said():
    rig = ring(4)
    none = Detections.build(rig.names, 100.0, np.zeros((4, 1), int), np.zeros((0, 2)))
    cloud = Cloud(100.0, np.zeros(2, int), np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros(0), np.zeros((0, 4), int))
    assert list(length_unit(none, rig, cloud)) == []
