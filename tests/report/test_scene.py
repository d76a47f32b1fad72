"""The 3D scene: level whichever axis points up, opened on the subject, with markers that move."""

from base64 import b64decode
from dataclasses import replace

import numpy as np
import pytest

from kinemark.findings.cameras import upwards
from kinemark.report.scene3d import GREATEST, motion, scene
from support.captures import RATE, capture, ring, walk
from support.drawings import checked
from support.many_tracks import fragments

TURNS = {
    2: np.eye(3),
    1: np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]),
    0: np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]),
}
"""World with z up → world with this axis up."""


def turned(up, markers=4):
    """A rig and records of a walk, in a world whose `up` axis points upwards."""
    rig, xyz = ring(6), walk(markers=markers) @ TURNS[up].T
    rig = replace(rig, cameras=tuple(replace(c, R=c.R @ TURNS[up].T) for c in rig))
    return rig, capture(rig, xyz)


@pytest.mark.parametrize("up", [0, 1, 2])
def test_the_floor_stays_level_while_the_scene_is_turned(up):
    rig, records = turned(up)
    assert upwards(rig) == up
    fig = checked(scene(rig, records["tracks"], records["trajectories"]))
    assert fig.layout.scene.dragmode == "turntable"  # which turns about Plotly's z and never tips
    assert fig.layout.scene.camera.up.to_plotly_json() == {"x": 0, "y": 0, "z": 1}
    (floor,) = [trace for trace in fig.data if trace.type == "mesh3d"]
    assert np.ptp(floor.z) == 0 and np.ptp(floor.x) > 0 and np.ptp(floor.y) > 0
    titles = [fig.layout.scene[f"{axis}axis"].title.text for axis in "xyz"]
    assert titles[2] == f"{'xyz'[up]} (mm)" and len(set(titles)) == 3
    named = [trace for trace in fig.data if trace.hovertemplate and "%{z:.0f} mm" not in trace.hovertemplate]
    assert bool(named) == (up != 2)  # what hovers is called by the world's axes


def starts(up):
    """(M, 3) where each path begins, as plotted."""
    rig, records = turned(up)
    fig = checked(scene(rig, records["tracks"], records["trajectories"]))
    lines = [trace for trace in fig.data if trace.type == "scatter3d" and trace.legendgroup]
    return np.array([[trace[axis][k] for axis in "xyz"] for trace in lines for k in (0, 20, 39)])


@pytest.mark.parametrize("up", [0, 1])
def test_the_scene_is_turned_and_not_mirrored(up):
    one, other = (points - points.mean(0) for points in (starts(up), starts(2)))
    U, _, Vt = np.linalg.svd(one.T @ other)
    assert np.linalg.det(U @ Vt) == pytest.approx(1)
    assert one @ U @ Vt == pytest.approx(other, abs=0.01)


@pytest.mark.parametrize("up", [0, 1, 2])
def test_it_opens_on_the_subject_and_shows_the_laboratory_on_request(up):
    rig, records = turned(up)
    fig = checked(scene(rig, records["tracks"], records["trajectories"]))
    box = np.array([fig.layout.scene[f"{axis}axis"].range for axis in "xyz"])
    unit = np.prod(np.ptp(box, axis=1)) ** (1 / 3)
    centre = np.array([fig.layout.scene.camera.center[axis] for axis in "xyz"]) * unit + box.mean(1)
    xyz = np.concatenate([p.xyz for p in records["trajectories"]])[:, [(up + 1) % 3, (up + 2) % 3, up]]
    assert (xyz.min(0) < centre).all() and (centre < xyz.max(0)).all()
    near, far = (button.args[0]["scene.camera"] for button in fig.layout.updatemenus[0].buttons)
    away = [np.linalg.norm([c["eye"][a] - c["center"][a] for a in "xyz"]) for c in (near, far)]
    assert away[0] < 0.5 * away[1]
    ratio = np.array([fig.layout.scene.aspectratio[axis] for axis in "xyz"])
    assert ratio == pytest.approx(np.ptp(box, axis=1) / unit)  # a millimetre is as long along each axis


def test_a_ghost_far_away_does_not_make_the_subject_small():
    rig, xyz = ring(4), walk(markers=4, frames=200)
    here = checked(scene(rig, *[capture(rig, xyz)[k] for k in ("tracks", "trajectories")])).layout.scene.camera
    odd = xyz.copy()
    odd[0, 3] += 1500.0
    there = checked(scene(rig, *[capture(rig, odd)[k] for k in ("tracks", "trajectories")])).layout.scene.camera
    away = [np.linalg.norm([c.eye[a] - c.center[a] for a in "xyz"]) for c in (here, there)]
    assert away[1] == pytest.approx(away[0], rel=0.5)


def unpacked(told):
    """Time, marker and place, mm, of all that plays."""
    who = np.frombuffer(b64decode(told["marker"]), "<u2")
    xyz = np.frombuffer(b64decode(told["xyz"]), "<i2").reshape(-1, 3) * told["step"] + told["origin"]
    frame = np.repeat(np.arange(len(told["time"])), np.diff(told["starts"]))
    return np.array(told["time"])[frame], who, xyz


@pytest.mark.parametrize("up", [1, 2])
def test_what_plays_is_where_the_markers_were(up):
    _, records = turned(up)
    trajectories = records["trajectories"]
    time, who, xyz = unpacked(motion(trajectories, up, trace=3))
    assert len(who) == 4 * trajectories.n_frames
    for t, m, place in list(zip(time, who, xyz, strict=True))[::7]:
        true = trajectories[trajectories.names[m]].xyz[round(t * RATE)]
        assert place == pytest.approx(true[[(up + 1) % 3, (up + 2) % 3, up]], abs=0.11)


def test_the_slider_begins_at_the_dots_that_are_drawn():
    """The dots were those of 1.00 s, and the slider below them stood at 0.00 s."""
    rig, records = turned(2)
    drawn = checked(scene(rig, records["tracks"], records["trajectories"])).data[-1]
    told = motion(records["trajectories"], 2, trace=3)
    assert drawn.name == f"markers at {told['time'][told['drawn']]:.2f} s" != "markers at 0.00 s"


def test_what_plays_is_bounded_and_leaves_gaps_open():
    trajectories = fragments(300, 3000)
    told = motion(trajectories, 2, trace=0)
    time, who, xyz = unpacked(told)
    assert len(who) <= 6000 and len(told["time"]) <= 400 and np.isfinite(xyz).all()
    for t, m in list(zip(time, who, strict=True))[::97]:
        assert np.isfinite(trajectories.paths[m].xyz[round(t * RATE)]).all()
    assert GREATEST < 2**15
