"""From rendered images of the hanging rods, opposite strobes glaring, to the rig: KISS 3.3 from end to end."""

import numpy as np

from kinemark.calibrate import calibrate_control_frame
from kinemark.detect import detect
from kinemark.geometry import project_all, triangulate, undistort
from kinemark.synth import render, ring
from kinemark.synth.targets import control_frame
from support.films import Film


def test_images_of_the_rods_give_cameras_that_are_true_within_their_error_bars():
    rng, hung = np.random.default_rng(0), control_frame()
    rig, xyz = ring(3, distortion=(-0.12, 0, 0, 0, 0)), hung.xyz.reshape(-1, 3)
    others = [np.delete(rig.centres, c, 0) for c in range(3)]
    images = [render(c, xyz, hung.marker_diameter / 2, strobes=s, rng=rng) for c, s in zip(rig, others, strict=True)]
    seen = detect([Film(image[None]) for image in images], cameras=rig.names, rate=1.0)
    found = calibrate_control_frame(seen, hung, sizes=[camera.size for camera in rig])
    assert max(camera.residual for camera in found) < 0.02
    inside = rng.uniform([300, 200, 200], [2100, 1200, 1700], (50, 3))
    assert np.abs(project_all(found, inside) - project_all(rig, inside)).max() < 0.03
    ideal = np.stack([undistort(a, uv) for a, uv in zip(found, project_all(rig, inside), strict=True)], 1)
    assert np.linalg.norm(triangulate(ideal, found.P) - inside, axis=1).max() < 0.1
