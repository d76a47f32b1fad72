"""Control points that determine no camera, or contradict each other: refused, or named, with the reason."""

import numpy as np
import pytest

from kinemark.calibrate import (
    ControlPoints,
    Dlt,
    calibrate_control_points,
    control_point_quality,
)
from kinemark.calibrate.control_points.mistaken import find_swapped_points, mistaken_points
from kinemark.data import KinemarkError
from kinemark.geometry import project, project_all
from kinemark.synth import ring
from kinemark.synth.targets import calibration_box, control_frame

FRAME = control_frame().xyz.reshape(-1, 3)
BOX = calibration_box(1400.0).xyz[:, 0]


def calibrated(rig, xyz, uv, **options):
    return calibrate_control_points(rig.names, [camera.size for camera in rig], xyz, uv, **options)


def test_errors_name_the_camera_and_say_what_to_do():
    rig = ring(2)
    uv = project_all(rig, FRAME)
    few = uv.copy()
    few[1, 5:] = np.nan
    with pytest.raises(KinemarkError, match=r"Camera cam2: 5 control points.*six"):
        calibrated(rig, FRAME, few)
    with pytest.raises(KinemarkError, match=r"Camera cam1: .*plane"):
        calibrated(rig, FRAME[:12], uv[:, :12])  # two rods
    with pytest.raises(KinemarkError, match=r"Camera cam1: .*plane"):
        calibrated(rig, FRAME[[0, 0, 0, 0, 5, 7, 12]], uv[:, [0, 0, 0, 0, 5, 7, 12]])
    shuffled = np.random.default_rng(0).permutation(24)
    with pytest.raises(KinemarkError, match=r"Camera cam1: .*order"):
        calibrated(rig, FRAME, uv[:, shuffled])


CUBE = np.stack(np.meshgrid([0.0, 1000], [0.0, 800], [0.0, 600, 1200]), -1).reshape(-1, 3)


def flat(axis, thickness):
    """Points within so many mm of a plane at right angles to an axis, or to (1, 0, 1)."""
    xyz = np.random.default_rng(0).uniform(200, 1800, (20, 3))
    height = np.random.default_rng(1).uniform(-thickness, thickness, 20)
    if axis == "slanted":
        normal = np.array([1, 0, 1]) / np.sqrt(2)
        return xyz - ((xyz - 1000) @ normal - height)[:, None] * normal
    xyz[:, "xyz".index(axis)] = 900 + height
    return xyz


@pytest.mark.parametrize(
    ("xyz", "says"),
    [
        (flat("z", 3.0), r"within [23]\.\d mm of a plane, about z = 900 mm"),
        (flat("x", 0.0), r"within 0\.1 mm of a plane, about x = 900 mm"),
        (flat("slanted", 1.0), r"at right angles to \(0\.71, 0\.00, 0\.71\)"),
        (np.linspace([300, 300, 300], [1500, 1200, 1500], 9), "of a line"),
        (np.array([[0, 0, 500.0], [900, 0, 500]])[[0, 1, 0, 1, 0, 1, 0]], "repeat: they are at 2 different places"),
        (CUBE / 1000, r"within 1\.2 mm of each other. Are their coordinates in metres"),
        (CUBE * 1000, "spread over 1200 m"),
        (np.full((8, 3), np.nan), "0 control points are seen"),
    ],
)
def test_points_that_determine_no_camera_are_refused_with_the_reason(xyz, says):
    camera = ring(1)[0]
    places = np.nan_to_num(xyz) * (1 if np.nanmax(xyz, initial=1000) > 10 else 1000)
    uv = project(camera, np.clip(places, -2000, 2000))[None]
    with pytest.raises(KinemarkError, match=says):
        calibrate_control_points(["a"], [camera.size], xyz, uv)


def test_repeated_points_are_named():
    camera = ring(1)[0]
    uv = project(camera, CUBE)[None]
    xyz = CUBE.copy()
    xyz[7] = xyz[2]
    with pytest.raises(KinemarkError, match=r"Camera a: Control points 3 and 8 have the same place in the survey"):
        calibrate_control_points(["a"], [camera.size], xyz, uv)
    taken = uv.copy()
    taken[0, 7] = taken[0, 2]
    with pytest.raises(KinemarkError, match=r"Control points P3 and P8, \d+ mm apart, have the same image"):
        calibrate_control_points(["a"], [camera.size], CUBE, taken, points=[f"P{i}" for i in range(1, 13)])
    twice = np.concatenate([CUBE, CUBE[:3]])  # measured again: they count twice, and nothing is wrong
    again = project(camera, twice) + np.random.default_rng(0).normal(0, 0.1, (15, 2))
    assert calibrate_control_points(["a"], [camera.size], twice, again[None])[0].residual < 0.3


@pytest.mark.parametrize("pair", [(2, 5), (0, 7)])
def test_two_exchanged_points_are_named_even_where_no_camera_fits(pair):
    rng, rig = np.random.default_rng(15), ring(3)
    uv = project_all(rig, BOX) + rng.normal(0, 0.2, (3, 8, 2))
    uv[1, list(pair)] = uv[1, list(pair[::-1])]
    swap = find_swapped_points(BOX, uv[1])
    assert [int(i) for i in np.flatnonzero(swap.image_of != np.arange(8))] == sorted(pair) and swap.after < 1
    assert find_swapped_points(BOX, uv[0]) is None and mistaken_points(BOX, uv[0], "12345678", camera="cam1") is None
    names = tuple(str(i + 1) for i in pair)
    with pytest.raises(KinemarkError, match=f"Camera cam2.*control points {names[0]}, {names[1]}") as error:
        control_point_quality(rig.names, [(0, 0)] * 3, BOX, uv)
    (said,) = (one for one in error.value.findings if one.kind == "control_points_swapped")
    assert (said.cameras, said.values["points_list"], said.values["image_of_list"]) == (("cam2",), names, names[::-1])
    assert said.values["after_px"] < 1 < said.values["before_px"]


@pytest.mark.parametrize("what", ["sizes", "xyz", "uv", "cov"])
def test_arrays_that_do_not_fit(what):
    rig = ring(2)
    arrays = {"sizes": np.zeros((2, 2)), "xyz": FRAME, "uv": project_all(rig, FRAME), "cov": np.zeros((2, 24, 2, 2))}
    arrays[what] = {"sizes": arrays["sizes"][:1], "xyz": FRAME[:, :2]}.get(what, arrays[what][:, :5])
    with pytest.raises(ValueError, match=rf"{what} has shape .* wanted"):
        calibrate_control_points(rig.names, arrays["sizes"], arrays["xyz"], arrays["uv"], cov=arrays["cov"])


@pytest.mark.parametrize("wrong", [{"radial": 4}, {"radial": -1}, {"reject": 1.0}, {"reject": float("nan")}])
def test_parameters_out_of_range(wrong):
    with pytest.raises(ValueError, match="wanted"):
        ControlPoints(**wrong)
    with pytest.raises(ValueError, match="wanted"):
        Dlt(reject=wrong.get("reject", 0.0))
