"""Reflections that stand still meet in two cameras by chance, in all frames or in none."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from kinemark.data import Detections, Rig
from kinemark.data.array_types import Bools, Floats
from kinemark.geometry import project_all
from kinemark.track.simultaneous import track_detections
from support.plain_ring import ring

CAMERAS, FRAMES, MARKERS, NOISE = 8, 64, 12, 0.2


def seen(rig: Rig, xyz: Floats, visible: Bools, spots: int, rng: np.random.Generator) -> Detections:
    """Images of markers (F, M, 3) where they are visible (C, F, M), and of spots that flicker in each camera."""
    uv, counts = project_all(rig, xyz), np.zeros((CAMERAS, FRAMES), int)
    place, rows = rng.uniform([0, 0], [1280, 1024], (CAMERAS, spots, 2)), []
    for c, f in np.ndindex(CAMERAS, FRAMES):
        of = np.concatenate([uv[c, f][visible[c, f]], place[c][rng.random(spots) < 0.7]])
        counts[c, f] = len(of)
        rows.append(of + rng.normal(0, NOISE, of.shape))
    return Detections.build(rig.names, 100.0, counts, np.concatenate(rows))


def body(rng: np.random.Generator, speed: float) -> Floats:
    """(F, M, 3) mm, markers that go round together at a speed, mm/s."""
    t = np.arange(FRAMES)[:, None, None] / 100
    shape = rng.uniform([-400, -400, 200], [400, 400, 1600], (MARKERS, 3))
    along = np.concatenate([np.sin(2 * t), 1 - np.cos(2 * t), 0.1 * np.sin(5 * t)], -1)
    return shape + speed / 2 * along


def turned(rig: Rig, px: float, rng: np.random.Generator) -> Rig:
    """The rig as a calibration has it that is off by about so many px."""
    turns = Rotation.from_rotvec(rng.normal(0, px / 1000, (CAMERAS, 3))).as_matrix()
    moved = zip(rig, turns, strict=True)
    return Rig(tuple(replace(one, R=turn @ one.R, t=turn @ one.t) for one, turn in moved))


def test_reflections_that_meet_by_chance_are_no_points() -> None:
    for seed in range(2):
        rng = np.random.default_rng(seed)
        rig, xyz = ring(CAMERAS), body(rng, 700.0)
        visible = rng.random((CAMERAS, FRAMES, MARKERS)) < 0.9
        detections = seen(rig, xyz, visible, 12, rng)
        cloud = track_detections(detections, turned(rig, 0.3, rng)).cloud
        off = np.linalg.norm(cloud.xyz[:, None] - xyz[cloud.frame], axis=-1).min(1)
        assert (off < 20).sum() > 0.999 * MARKERS * FRAMES
        assert not (off > 20).any()


def test_markers_that_stand_before_two_cameras_are_kept() -> None:
    rng = np.random.default_rng(5)
    rig, xyz = ring(CAMERAS), body(rng, 0.0)
    visible = np.ones((CAMERAS, FRAMES, MARKERS), bool)
    visible[2:, :, :4] = False  # four are seen by two cameras alone
    cloud = track_detections(seen(rig, xyz, visible, 2, rng), rig).cloud
    off = np.linalg.norm(cloud.xyz[:, None] - xyz[cloud.frame], axis=-1)
    assert ((off < 10).sum(0) > 0.99 * FRAMES).all()
