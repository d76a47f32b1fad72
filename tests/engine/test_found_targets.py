"""Calibration targets in images are those that a calibration recognises."""

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.engine.found_targets import found_target, targets_of
from kinemark.engine.session import Session
from kinemark.engine.simulate import Scene, simulate
from kinemark.geometry import project
from kinemark.io.rods_toml import read_rods

SMALL = {"seconds": 0.4, "size_px": (376, 292), "focal_px": 385.0, "cameras": 3}


def test_rods_are_where_the_calibration_has_them(tmp_path):
    simulate(tmp_path / "rods", scene=Scene(**SMALL))
    session = Session.open(tmp_path / "rods")
    rig, rods = session.calibrate().rig, read_rods(session.root / "rods.toml")
    assert targets_of(session.settings) == ("control_frame",)
    for camera in rig:
        found = found_target(session.root, session.settings, "control_frame", camera.name, 1, None)
        place = {f"{rod}{k + 1}": rods.xyz[r, k] for r, rod in enumerate(rods.names) for k in range(rods.xyz.shape[1])}
        wanted = project(camera, np.array([place[name] for name in found.names]))
        assert len(found.names) > 10 and np.abs(found.uv - wanted).max() < 1.5, camera.name
        assert all(found.names[a][0] == found.names[b][0] for a, b in found.lines), "lines join markers of one rod"
    with pytest.raises(KinemarkError, match="no image of wand"):
        found_target(session.root, session.settings, "wand", "cam1", 1, None)
    with pytest.raises(KinemarkError, match="no frame 9"):
        found_target(session.root, session.settings, "control_frame", "cam1", 9, None)


def test_wand_and_l_frame_lie_on_bright_spots(tmp_path):
    """Of the wand the outer markers are apart by the stated lengths' proportions; the L-frame wants a calibration."""
    simulate(tmp_path / "wand", scene=Scene(**SMALL | {"calibration": "wand"}))
    session = Session.open(tmp_path / "wand")
    kinds, n = targets_of(session.settings), 0
    assert "wand" in kinds
    for camera in session.settings.cameras.names:
        found = found_target(session.root, session.settings, "wand", camera, 5, None)
        if len(found.uv) == 0:
            continue
        near = np.linalg.norm(found.uv[:, None] - found.spots, axis=-1).min(1)
        assert near.max() < 1e-6 and len(found.lines) == len(found.uv) - 1
        n += 1
    assert n >= 2
    if "l_frame" in kinds:
        none = found_target(session.root, session.settings, "l_frame", "cam1", 1, None)
        assert none.words.startswith("The L-frame is shown where the calibration puts it")
        rig = session.calibrate().rig
        found = found_target(session.root, session.settings, "l_frame", "cam1", 1, rig)
        near = np.linalg.norm(found.uv[:, None] - found.spots, axis=-1).min(1)
        assert near.max() < 3.0 and found.names == ("X", "corner", "Y")
