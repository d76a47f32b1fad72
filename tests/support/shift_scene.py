"""The laboratory that the cases of the shift law share: a walk with a gap, cameras, what they see, and its tracks."""

from dataclasses import replace
from functools import cache

import numpy as np

import kinemark
from kinemark import calibrate, geometry, synth
from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.fill import MarkerArray, find_gaps
from kinemark.track import track
from kinemark.track.simultaneous import Simultaneous
from support.shift_law import on_grid


@cache
def walk(duration=2.4, rate=50.0):
    subject = synth.with_markers(synth.walking(duration_s=duration, rate=rate, seed=2, wobble_mm=1.0), 16, seed=2)
    limbs = subject.capsules
    limbs = replace(limbs, a=on_grid(limbs.a), b=on_grid(limbs.b))
    return replace(subject, xyz=on_grid(subject.xyz), capsules=limbs)


@cache
def trial(gaps=True):
    """A walk with two gaps and noise."""
    xyz = walk().xyz + on_grid(np.random.default_rng(0).normal(0, 0.3, walk().xyz.shape))
    if gaps:
        xyz[1, 30:40] = np.nan
    cov = np.broadcast_to(0.09 * np.eye(3), (xyz.shape[1], 3, 3))
    paths = [MarkerTrajectory.measured(name, at, cov=cov) for name, at in zip(walk().names, xyz, strict=True)]
    return Trajectories(tuple(paths), walk().rate)


@cache
def rig():
    """Cameras with covariances, calibrated in a world whose origin is near."""
    true = synth.ring(5, distortion=(-0.1, 0.02, 0.0, 0.0, 0.0), sweep_deg=300.0)
    return calibrated(true).rig


@cache
def frame():
    """Control points on rods."""
    rods = synth.control_frame()
    return replace(rods, xyz=on_grid(rods.xyz))


def calibrated(true, by=0.0, **options):
    xyz = frame().xyz.reshape(-1, 3)
    uv = geometry.project_all(true, xyz) + np.random.default_rng(3).normal(0, 0.1, (len(true), len(xyz), 2))
    sizes = [camera.size for camera in true]
    return calibrate.control_point_quality(true.names, sizes, xyz + by, uv, points=frame().marker_names, **options)


@cache
def observed():
    subject = walk()
    short = replace(
        subject,
        xyz=subject.xyz[:, :60],
        capsules=replace(subject.capsules, a=subject.capsules.a[:, :60], b=subject.capsules.b[:, :60]),
    )
    return synth.observe(rig(), short, noise_px=0.1, false_per_frame=0.3, merge_px=2.0, seed=1)


@cache
def matches():
    return kinemark.match(observed().detections, rig())


@cache
def cloud():
    made = kinemark.reconstruct(matches(), observed().detections, rig())
    return replace(made, xyz=on_grid(made.xyz))


@cache
def tracks():
    return track(cloud())


@cache
def followed():
    return kinemark.track_simultaneously(observed().detections, rig(), Simultaneous())


def motion(gaps=True):
    return MarkerArray.of(trial(gaps))


def found_gaps():
    return find_gaps(motion())


POINTS = on_grid(np.random.default_rng(5).uniform([200, 200, 100], [2200, 1200, 1800], (40, 3)))
