"""Markers and their images by cameras that are not quite where they are believed to be."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from kinemark.data import Rig
from kinemark.geometry import project, refine
from kinemark.sensitivity import SampledFrames, shown

RATE = 100.0


def dance(markers=8, frames=120, seed=0):
    """(M, F, 3) mm: pairs of markers 300 mm apart, all turning and wandering through the volume."""
    rng, t = np.random.default_rng(seed), np.arange(frames) / frames
    out = []
    for _ in range(markers // 2):
        phase = rng.uniform(0, 6, 5)
        middle = np.stack([350 * np.sin(6 * t + phase[k]) for k in range(3)], -1) + np.array([0, 0, 1000])
        a, b = 9 * t + phase[3], np.sin(7 * t + phase[4])
        line = np.stack([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)], -1)
        out += [middle - 150 * line, middle + 150 * line]
    return np.array(out)


def recorded(believed, true=None, *, noise=0.1, xyz=None, seed=1, hide=0.2, bend=None):
    """Markers and images (M, F, C, 2) of true cameras with noise, and points from the believed ones."""
    rng, xyz, true = np.random.default_rng(seed), dance() if xyz is None else xyz, true or believed
    uv = np.stack([project(camera, xyz) for camera in true], 2)
    uv = uv + noise * rng.standard_normal(uv.shape)
    if bend is not None:
        uv = uv + bend(uv)
    uv[rng.random(uv.shape[:3]) < hide] = np.nan
    flat = uv.reshape(-1, len(believed), 2)
    place = refine(believed, xyz.reshape(-1, 3), flat, np.broadcast_to(np.eye(2), (*flat.shape, 2)))
    few = np.isfinite(flat[..., 0]).sum(1) < 2
    found = np.where(few[:, None], np.nan, place.xyz).reshape(xyz.shape)
    return SampledFrames(tuple(f"m{m}" for m in range(len(xyz))), found, uv, np.arange(xyz.shape[1]) / RATE)


def shown_by(rig, there):
    flat = there.xyz.reshape(-1, 3)
    safe = np.where(np.isfinite(flat), flat, 0.0)
    return shown(rig, safe, there.uv.reshape(len(flat), len(rig), 2), np.tile(there.time_s, len(there.xyz)))


def moved_cameras(rig, seed=0, turn=1e-3, shift=1.5):
    rng = np.random.default_rng(seed)
    return Rig(
        tuple(
            replace(
                camera,
                R=Rotation.from_rotvec(turn * rng.standard_normal(3)).as_matrix() @ camera.R,
                t=camera.t + shift * rng.standard_normal(3),
            )
            for camera in rig
        )
    )
