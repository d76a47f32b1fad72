"""The origin of the world is arbitrary: a trial 10 km away gives the same answer, 10 km away.

Each function that takes positions has a case below: what it gives in a world moved by `by`. Places must move along, and
all else must stay: distances, angles, covariances, pixels, names, choices. Inputs lie on a grid that such a move does
not round, so that what is left is the rounding of the computation. 10 km has ulp 1.9e-9 mm.
"""

import importlib
import inspect
import pkgutil
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from shifted import FAR, Answer, differences, moved, on_grid

import kinemark
from kinemark import calibrate, geometry, kinematics, sensitivity, signal, synth
from kinemark.calibrate import bundle, control_frame, control_points, quality, wand
from kinemark.calibrate.bundle import Sticks
from kinemark.data import Cloud, Matches, Path, Tracks, Trajectories
from kinemark.fill import METHODS as FILLERS
from kinemark.fill import (
    Filling,
    Gap,
    LimbAngles,
    Motion,
    Rays,
    StaticShape,
    angles,
    fill,
    fill_recording,
    find_gaps,
    fit_model,
    place_absent,
    trim_edges,
)
from kinemark.follow import FormerTwoCameras, Simultaneous
from kinemark.kinematics import Butterworth, Pose, WoltringSpline
from kinemark.match import EpipolarTriplets, KissTriplets, NearestEpipolar
from kinemark.reconstruct import CameraPairs, LeastSquares
from kinemark.track import DistanceOnly, ExtrapolationLadder, KissTracking, Swamidas, swamidas, track

CASES = {}
"""By id: case(by) -> Answer; mm and share that its answer may be off; the functions that it is about."""
MM, SHARE = 1e-7, 1e-9


def law(*functions, mm=MM, share=SHARE, each=(None,), name=""):
    """A case for these functions, once for each of some parameters."""

    def add(case):
        for one in each:
            label = name or functions[0].__name__
            key = label if one is None else f"{label}[{getattr(type(one), '__name__', '') if not isinstance(one, str) else one}]"
            assert key not in CASES, key
            CASES[key] = ((lambda by, one=one: case(by, one)) if one is not None else case, mm, share, functions)
        return case

    return add


# ---- A laboratory and what happens in it ----


@cache
def walk(duration=3.0, rate=50.0):
    subject = synth.dressed(synth.walking(duration_s=duration, rate=rate, seed=2, wobble_mm=1.0), 20, seed=2)
    limbs = subject.capsules
    limbs = replace(limbs, a=on_grid(limbs.a), b=on_grid(limbs.b))
    return replace(subject, xyz=on_grid(subject.xyz), capsules=limbs)


@cache
def trial(gaps=True):
    """A walk with four gaps, noise, a wild sample, and a bad sample beside a gap."""
    xyz = walk().xyz + on_grid(np.random.default_rng(0).normal(0, 0.3, walk().xyz.shape))
    if gaps:
        for marker, start, stop in ((1, 30, 45), (4, 60, 90), (7, 100, 110), (8, 100, 125)):
            xyz[marker, start:stop] = np.nan
        xyz[1, 29] += 40.0
    cov = np.broadcast_to(0.09 * np.eye(3), (xyz.shape[1], 3, 3))
    paths = [Path.measured(name, at, cov=cov) for name, at in zip(walk().names, xyz, strict=True)]
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
    short = replace(subject, xyz=subject.xyz[:, :60], capsules=replace(subject.capsules, a=subject.capsules.a[:, :60], b=subject.capsules.b[:, :60]))
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
    return kinemark.followed(observed().detections, rig(), Simultaneous())


def motion(gaps=True):
    return Motion.of(trial(gaps))


def found_gaps():
    return find_gaps(motion())


POINTS = on_grid(np.random.default_rng(5).uniform([200, 200, 100], [2200, 1200, 1800], (40, 3)))


# ---- Filling ----


@law(fill, each=tuple(FILLERS), mm=1e-5, share=1e-5)
def _(by, name):
    filled, gaps = fill(moved(trial(), by), method=FILLERS[name](), ends=True, limit_mm=np.inf)
    return Answer(filled.xyz, ([p.cov for p in filled], [p.origin for p in filled], gaps))


@law(trim_edges)
def _(by):
    found = trim_edges(moved(motion(), by), found_gaps())
    return Answer(found.motion.xyz, (found.gaps, found.before, found.after))


@law(find_gaps)
def _(by):
    return Answer(rest=find_gaps(moved(motion(), by), ends=True))


@law(place_absent, mm=1e-6, share=1e-7)
def _(by):
    xyz = motion().xyz.copy()
    xyz[3] = np.nan
    static = StaticShape.of(Motion(motion(False).xyz[:, :20] + by, 50.0, motion().names))
    placed = place_absent(Motion(xyz + by, 50.0, motion().names), static)
    return Answer(([p.xyz for p in placed], static.xyz), ([p._replace(xyz=None) for p in placed], static.sd))


@law(fill_recording, mm=1e-5, share=1e-5)
def _(by):
    rays = Rays.left_by(moved(tracks(), by), observed().detections, moved(rig(), by))
    short = replace(trial(), paths=tuple(Path.measured(p.name, p.xyz[:60], cov=p.cov[:60]) for p in trial()))
    filled, gaps = fill_recording(moved(short, by), rays, method=Filling(limit_mm=1e9))
    return Answer(filled.xyz, ([p.cov for p in filled], [p.cameras for p in filled], gaps))


@law(fit_model, angles.connect, angles.directions, angles.learn_model, angles.learned_of, share=1e-7)
def _(by):
    xyz, names = motion().xyz + by, motion().names
    segments = angles.connect(xyz, names=names)
    model = angles.learn_model(xyz, rate=50.0, names=names, segments=segments)
    fitted = fit_model(moved(motion(), by))
    learned = angles.learned_of(moved(motion(), by), method=LimbAngles())
    return Answer(rest=(segments, angles.directions(xyz, segments.link), model, fitted.model, fitted.phase, learned))


@law(angles.fill_limb_angles, angles.fill_kalman_angles, mm=1e-5, share=1e-5)
def _(by):
    said = [f(moved(motion(), by), found_gaps()) for f in (angles.fill_limb_angles, angles.fill_kalman_angles)]
    return Answer([p.xyz for each in said for p in each], [p._replace(xyz=None) for each in said for p in each])


@pytest.mark.parametrize("key", CASES)
def test_far_away_the_answer_is_the_same(key):
    case, mm, share, _ = CASES[key]
    places, rest = differences(case(np.zeros(3)), case(FAR), FAR)
    assert places <= mm and rest <= share, f"places are off by {places:.2g} mm, the rest by {rest:.2g} of itself"
