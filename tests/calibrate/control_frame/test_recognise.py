"""The control frame: rods known by their spacings, whatever else is in the image."""

import numpy as np
import pytest

from kinemark.calibrate import (
    calibrate_control_frame,
    identify_markers,
    judge_control_points,
    recognise_control_frame,
)
from kinemark.calibrate.control_frame import control_frame_quality
from kinemark.calibrate.control_frame.spacing import NO_FIT, spacing_errors
from kinemark.data import Detections, KinemarkError, Rig, Rods, Validity
from kinemark.geometry import project, project_all
from kinemark.io.rods_toml import rods_from_toml
from kinemark.synth import ring
from kinemark.synth.targets import control_frame

RODS = control_frame()
LENS = (-0.1, 0.0, 0.0, 0.0, 0.0)


def seen(camera, rng, *, noise=0.1, strays=0):
    """Markers (4, 6, 2) as a camera sees them, and all points (n, 2) in any order, strays among them."""
    uv = project(camera, RODS.xyz) + rng.normal(0, noise, (4, 6, 2))
    points = np.concatenate([uv.reshape(-1, 2), rng.uniform(0, camera.size, (strays, 2))])
    return uv, rng.permutation(points)


@pytest.mark.parametrize(("k1", "strays"), [(0.0, 0), (-0.1, 3), (-0.25, 2), (0.0, 30)])
def test_all_rods_are_known_from_all_around(k1, strays):
    rng = np.random.default_rng(strays)
    for camera in ring(8, start_deg=11, distortion=(k1, 0, 0, 0, 0)):
        uv, points = seen(camera, rng, strays=strays)
        np.testing.assert_array_equal(recognise_control_frame(points, RODS), uv)


@pytest.mark.parametrize("roll_deg", [30, 90, 180])
def test_rods_need_not_be_upright_in_the_image(roll_deg):
    turn = np.radians(roll_deg)
    T = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    uv, points = seen(ring(3, distortion=LENS)[1], np.random.default_rng(1))
    np.testing.assert_allclose(recognise_control_frame(points @ T.T, RODS), uv @ T.T)


def test_hidden_markers_are_missing_and_the_others_known():
    rng = np.random.default_rng(2)
    for camera in ring(6, distortion=LENS):
        uv, _ = seen(camera, rng)
        hidden = rng.permutation(4 * 6)[:2]
        uv.reshape(-1, 2)[hidden] = np.nan
        points = uv.reshape(-1, 2)[np.isfinite(uv.reshape(-1, 2)[:, 0])]
        np.testing.assert_array_equal(recognise_control_frame(points, RODS), uv)


def test_a_rod_that_lost_half_its_markers_is_found_by_the_others():
    uv, _ = seen(ring(1, distortion=LENS)[0], np.random.default_rng(3))
    uv[2, [0, 3, 4]] = np.nan
    points = uv[np.isfinite(uv[..., 0])]
    np.testing.assert_array_equal(recognise_control_frame(points, RODS), uv)


def test_order_of_the_points_does_not_matter():
    _, points = seen(ring(1)[0], np.random.default_rng(4), strays=4)
    order = np.random.default_rng(5).permutation(len(points))
    one, other = identify_markers(points, RODS), identify_markers(points[order], RODS)
    np.testing.assert_array_equal(order[other], one)


def test_a_projective_map_leaves_spacings_without_error_and_no_other_rod_has_them():
    rng = np.random.default_rng(6)
    for rod in range(4):
        s = RODS.along[rod]
        a, b, c = rng.uniform(0.1, 0.4), rng.uniform(-500, 500), rng.uniform(-2e-4, 2e-4)
        q = (a * s + b) / (c * s + 1)
        errors = [spacing_errors(RODS.along[r], q[None])[0] for r in range(4)]
        assert errors[rod] < 1e-6 and min(errors[:rod] + errors[rod + 1 :]) > 5
        assert spacing_errors(s, q[None, ::-1])[0] > 5
    assert spacing_errors(s, 1 / (s - s.mean() + 1)[None])[0] == NO_FIT  # half of the rod behind the camera


def test_two_rods_or_none_are_refused_with_the_number_found():
    uv, points = seen(ring(1)[0], np.random.default_rng(7))
    with pytest.raises(KinemarkError, match=r"Among 12 points, 2 of 4 rods .*Check"):
        recognise_control_frame(uv[:2].reshape(-1, 2), RODS)
    for few in (points[:0], points[:3], np.full((30, 2), 7.0)):
        with pytest.raises(KinemarkError, match="0 of 4 rods"):
            recognise_control_frame(few, RODS)
    with pytest.raises(KinemarkError, match=r"101 points .* 24 markers"):
        recognise_control_frame(np.random.default_rng(0).uniform(0, 500, (101, 2)), RODS)


def test_rods_with_other_spacings_are_not_recognised():
    even = np.linspace(0, 1, 6)[:, None]
    ladder = RODS.xyz[:, :1] + even * (RODS.xyz[:, -1:] - RODS.xyz[:, :1])
    for camera in ring(3):
        with pytest.raises(KinemarkError, match="no three of them fit one camera"):
            recognise_control_frame(project(camera, ladder).reshape(-1, 2), RODS)


def hung(change):
    """The rods as they hang, `change` applied to the places (4, 6, 3) that the description says."""
    xyz = RODS.xyz.copy()
    change(xyz)
    return xyz


def seen_otherwise(xyz, seed, camera):
    """What a camera sees (4, 6, 2) of rods that hang otherwise than described."""
    rng = np.random.default_rng(seed)
    return project(ring(6, start_deg=rng.uniform(0, 60), distortion=LENS)[camera], xyz) + rng.normal(0, 0.05, (4, 6, 2))


@pytest.mark.parametrize("camera", range(3))
def test_a_marker_that_sits_elsewhere_on_its_rod_is_left_out_and_the_rest_known(camera):
    def lower(xyz):
        xyz[1, 2, 2] -= 60

    uv = seen_otherwise(hung(lower), camera, camera)
    found = recognise_control_frame(np.random.default_rng(0).permutation(uv.reshape(-1, 2)), RODS)
    uv[1, 2] = np.nan
    np.testing.assert_array_equal(found, uv)


UNSEEN = ("control_points_unseen", "control_points_seen_by_few")


def all_seen(rig, xyz, seed=0):
    """Detections of rods that hang at (4, 6, 3), each camera's in one and the same order."""
    uv = project_all(rig, xyz.reshape(-1, 3)) + np.random.default_rng(seed).normal(0, 0.05, (len(rig), 24, 2))
    cov = np.tile(np.eye(2) * 0.05**2, (24 * len(rig), 1, 1))
    return uv, Detections.build(rig.names, 1.0, [[24]] * len(rig), uv.reshape(-1, 2), cov)


def test_a_rod_that_hangs_elsewhere_is_left_out_by_most_cameras_and_named():
    """Three upright rods of a single camera may be any three; several cameras agree which one is wrong."""
    rig = Rig(ring(6, start_deg=11, distortion=LENS).cameras[:3])
    uv, detections = all_seen(rig, hung(lambda xyz: np.add.at(xyz, (1, slice(None), 0), 150.0)))
    fit = control_frame_quality(detections, RODS, sizes=[camera.size for camera in rig])
    there = np.isfinite(fit.uv[..., 0])
    np.testing.assert_allclose(fit.uv[there], uv[there], atol=0.02)  # no marker was taken for another
    judged = judge_control_points(fit)
    unseen = [one.values["points_list"] for one in judged.findings if one.kind in UNSEEN]
    assert ("B1", "B2", "B3", "B4", "B5", "B6") in unseen


def exchanged(pair):
    def exchange(xyz):
        xyz[list(pair), :, :2] = xyz[list(pair[::-1]), :, :2]

    return hung(exchange)


@pytest.mark.parametrize(("pair", "camera"), [((0, 2), 0), ((1, 3), 1)])
def test_opposite_rods_at_each_others_places_are_a_mirror_image_and_refused_by_every_camera(pair, camera):
    uv = seen_otherwise(exchanged(pair), camera, camera)
    with pytest.raises(KinemarkError, match="They do if A and C, or B and D, hang at each other's places"):
        recognise_control_frame(uv.reshape(-1, 2), RODS)


def test_neighbouring_rods_at_each_others_places_are_named():
    rig = Rig(ring(6, start_deg=11, distortion=LENS).cameras[1:3])
    _, detections = all_seen(rig, exchanged((0, 1)))
    with pytest.raises(KinemarkError, match=r"They do if A and B.* hang at each other's"):
        calibrate_control_frame(detections, RODS, sizes=[camera.size for camera in rig])


def test_rods_of_any_number_of_markers_in_any_layout():
    """Five rods, slanted, of four to eight markers."""
    rng = np.random.default_rng(3)
    tables = []
    for name, n in zip("ABCDE", (8, 6, 5, 7, 4), strict=True):
        foot, top = rng.uniform([200, 100, 50], [2200, 1300, 300]), rng.uniform([200, 100, 1500], [2200, 1300, 1900])
        share = np.cumsum(rng.uniform(0.4, 2.0, n))
        places = foot + (share / share[-1])[:, None] * (top - foot)
        tables.append(f'[[rod]]\nname = "{name}"\nmarkers = {np.round(places, 1).tolist()}')
    rods = rods_from_toml("\n".join(tables))
    for camera in ring(5, distortion=LENS):
        uv = project(camera, rods.xyz) + rng.normal(0, 0.05, (*rods.xyz.shape[:2], 2))
        points = rng.permutation(uv[np.isfinite(uv[..., 0])])
        np.testing.assert_array_equal(recognise_control_frame(points, rods), uv)


def as_detections(rig, rng, strays):
    points = [seen(camera, rng, noise=0.05, strays=strays)[1] for camera in rig]
    counts = [[len(p)] for p in points]
    n = sum(len(p) for p in points)
    return Detections.build(rig.names, 1.0, counts, np.concatenate(points), np.tile(np.eye(2) * 0.05**2, (n, 1, 1)))


def test_one_frame_of_all_cameras_gives_the_rig():
    rng, rig = np.random.default_rng(9), ring(6, distortion=LENS)
    found = calibrate_control_frame(as_detections(rig, rng, 2), RODS, sizes=[camera.size for camera in rig])
    assert found.names == rig.names and max(camera.residual for camera in found) < 0.12
    inside = rng.uniform([300, 200, 200], [2100, 1200, 1700], (50, 3))
    assert np.sqrt(np.mean((project_all(found, inside) - project_all(rig, inside)) ** 2)) < 0.05


def test_invalid_detections_take_no_part_and_errors_name_the_camera():
    rig = ring(2)
    detections = as_detections(rig, np.random.default_rng(10), 0)
    validity = np.where(detections.camera == 1, Validity.TOO_LARGE, Validity.VALID)
    spoilt = Detections.build(rig.names, 1.0, detections.counts, detections.uv, validity=validity)
    with pytest.raises(KinemarkError, match=r"Camera cam2: Among 0 points, 0 of 4 rods"):
        calibrate_control_frame(spoilt, RODS, sizes=[(0, 0)] * 2)
    with pytest.raises(ValueError, match="frame is 1"):
        calibrate_control_frame(detections, RODS, sizes=[(0, 0)] * 2, frame=1)


def toml(units="mm", scale=1.0, rods=RODS, extra="marker_diameter = 25.0"):
    parts = [
        f'[[rod]]\nname = "{name}"\nmarkers = {(xyz * scale).tolist()}'
        for name, xyz in zip(rods.names, rods.xyz, strict=True)
    ]
    return "\n".join([f'units = "{units}"', extra, *parts])


@pytest.mark.parametrize(("units", "scale"), [("mm", 1.0), ("cm", 0.1), ("m", 0.001)])
def test_rods_from_toml_are_in_millimetres(units, scale):
    rods = rods_from_toml(toml(units, scale))
    assert rods.names == RODS.names
    np.testing.assert_allclose(rods.xyz, RODS.xyz)
    np.testing.assert_allclose(rods.marker_diameter, 25.0 / scale)
    assert np.isnan(rods_from_toml(toml(extra="")).marker_diameter)


BENT = RODS.xyz.copy()
BENT[1, 2, 0] += 100
MIXED = RODS.xyz[:, [0, 2, 1, 3, 4, 5]]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", r"2 to 16 tables \[\[rod\]\]"),
        ("units = [", "no TOML"),
        ("x = " + "[" * 5000, "no TOML"),
        ('units = "ell"', "units"),
        ("units = 3", "units"),
        ("rod = 5", "rod"),
        ("[[rod]]\n[[rod]]", "Rod 1: markers"),
        ('[[rod]]\nname="A"\nmarkers=[[1,2,3],[1,2]]\n[[rod]]', "Rod A: markers"),
        ('[[rod]]\nmarkers="x"\n[[rod]]', "Rod 1: markers"),
        ("[[rod]]\nmarkers=[[0,0,nan],[0,0,1],[0,0,2],[0,0,3]]\n[[rod]]", "finite"),
        ("rod = [1, 2]", "Rod 1: markers"),
        (toml(extra="marker_diameter = -1"), "marker_diameter"),
        (toml(extra="marker_diameter_mm = 25.0"), r"unknown key 'marker_diameter_mm' \(did you mean 'marker_diameter'"),
        (toml().replace("units", "unit", 1), r"unknown key 'unit' \(did you mean 'units'"),
        (toml().replace("markers =", "marker =", 1), r"Rod A has the unknown key 'marker'"),
        (toml(rods=Rods(RODS.names, BENT)), "Rod B is not straight: marker 3"),
        (toml(rods=Rods(RODS.names, MIXED)), "in order"),
    ],
)
def test_descriptions_that_are_none(text, says):
    with pytest.raises(KinemarkError, match=says):
        rods_from_toml(text)


def test_rods_hold_what_they_say():
    with pytest.raises(ValueError, match="xyz has shape"):
        Rods(("A",), RODS.xyz)
    with pytest.raises(ValueError, match="finite"):
        Rods(RODS.names, RODS.xyz * np.nan)
    with pytest.raises(ValueError, match="read-only"):
        RODS.xyz[0, 0, 0] = 1
