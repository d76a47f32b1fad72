"""The trials of the study of edits, and the ways in which they are processed again."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy
from recordings import recording

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from kinemark.data import Camera, Detections, Rig, Trajectories
from kinemark.data.array_types import Floats
from kinemark.data.track_trajectories import trajectories_of
from kinemark.engine.session import Session
from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.tdf import read_tdf
from kinemark.match import EpipolarTriplets, KissTriplets, NearestEpipolar, match
from kinemark.reconstruct import LeastSquares, reconstruct
from kinemark.synth import combined_subjects, observe, ring, walking, with_markers
from kinemark.track import ExtrapolationLadder, KissTracking, track
from kinemark.track.simultaneous import Simultaneous, track_detections
from support.scenes import make, scene

SCENES = (4, 11, 14, 21, 38, 7, 17, 25, 33, 42, 48, 53, 61, 77, 83, 91)


class Trial(NamedTuple):
    """A trial as it comes: rig and detections, and the true paths (M, F, 3) mm, NaN where they are not known."""

    name: str
    rig: Rig
    detections: Detections
    xyz: Floats


class Processed(NamedTuple):
    """A trial processed: its tracks with the images behind them, in which world, and the truth there."""

    trajectories: Trajectories
    detections: Detections
    rig: Rig
    xyz: Floats


def trials(n: int) -> Iterator[Trial]:
    """The first n."""
    makers: list[Callable[[], Trial]] = [gait9, infrared, child, *(lambda s=s: simulated(s) for s in SCENES), pair]
    for made in makers[:n]:
        yield made()


def gait9() -> Trial:
    tdf = read_tdf(recording("cameras/gait9_bts/gait9.tdf"))
    assert tdf.rig and tdf.detections and tdf.trajectories
    return Trial("gait9 (BTS, recorded)", tdf.rig, tdf.detections, tdf.trajectories.xyz)


def infrared() -> Trial:
    """The plate with 15 LEDs; they are where its pattern fits the points of a frame."""
    from infrared_footage import FEWEST, SETTINGS, fit, pattern, published_rig

    source = recording("cameras/ir_4cam_footage")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_rig_toml(folder / "rig.toml", published_rig(source / "config"))
        (folder / "session.toml").write_text(SETTINGS.format(videos=source.as_posix()))
        trial = Session.open(folder).trial("target").run("track")
        rig, detections, cloud = trial.rig, trial.detections, trial.tracks.cloud
    model, pose = pattern(source / "config"), None
    xyz = np.full((len(model), cloud.n_frames, 3), np.nan)
    for f in range(cloud.n_frames):
        found = fit(cloud[f], model, pose) if len(cloud[f]) >= FEWEST else None
        pose = found[1] if found else None
        if found:
            R, t = found[1]
            xyz[:, f] = model @ R.T + t
    return Trial("infrared footage (recorded)", rig, detections, xyz)


def child(seed: int = 5) -> Trial:
    """A child's feet: small markers some 20 mm apart, which run together in many images."""
    subject = walking(duration_s=2.5, rate=100.0, height_mm=850.0, marker_radius_mm=4.0, wobble_mm=0.5, seed=seed)
    subject = with_markers(subject, 39, apart_mm=18.0, seed=seed)
    rig = ring(8)
    return Trial(
        "a child of 0.85 m, 39 markers",
        rig,
        observe(rig, subject, noise_px=0.15, merge_px=5.0, seed=seed).detections,
        subject.xyz,
    )


def pair(seed: int = 6) -> Trial:
    """Two people."""
    people = [
        walking(duration_s=2.0, rate=100.0, wobble_mm=1.0, seed=seed + k, middle=(1200.0, 450.0 + 500 * k))
        for k in range(2)
    ]
    subject, rig = combined_subjects(*people), ring(8)
    return Trial(
        "two people", rig, observe(rig, subject, noise_px=0.2, merge_px=4.0, seed=seed).detections, subject.xyz
    )


def simulated(seed: int) -> Trial:
    made = make(scene(seed))
    s = made.scene
    name = f"scene {seed}: {s.motion}, {s.markers} markers, {s.cameras} cameras"
    return Trial(name, made.rig, made.detections, made.xyz)


# Ways of processing


def by_default(trial: Trial, **parameters: Any) -> Processed:
    tracks = track_detections(trial.detections, trial.rig, method=Simultaneous(**parameters))
    return Processed(trajectories_of(tracks), trial.detections, trial.rig, trial.xyz)


def by_points(trial: Trial, matching: Any, method: Any) -> Processed:
    cloud = reconstruct(
        match(trial.detections, trial.rig, method=matching), trial.detections, trial.rig, method=LeastSquares()
    )
    return Processed(trajectories_of(track(cloud, method=method)), trial.detections, trial.rig, trial.xyz)


def _triplets(trial: Trial, kind: Any) -> Any:
    return kind() if len(trial.rig) > 2 else NearestEpipolar()


def disturbed(trial: Trial, noise: float, lost: float, seed: int) -> Trial:
    rng = np.random.default_rng(seed)
    found = trial.detections.keep(rng.random(len(trial.detections)) >= lost)
    return trial._replace(detections=replace(found, uv=found.uv + rng.normal(0, noise, found.uv.shape)))


def other_detection(trial: Trial, seed: int) -> Trial:
    """Each camera's centroids biased by up to half a pixel and noisier, near images merged, and false ones between."""
    rng = np.random.default_rng(seed)
    found = trial.detections
    bias = rng.uniform(-0.5, 0.5, (len(found.cameras), 2))
    uv = found.uv + bias[found.camera] + rng.normal(0, 0.15, found.uv.shape)
    found = replace(found, uv=uv, cov=np.full_like(found.cov, np.nan), area=np.full_like(found.area, np.nan))
    return trial._replace(detections=with_false(found.keep(rng.random(len(found)) >= 0.03), 0.5, rng))


def with_false(found: Detections, mean: float, rng: np.random.Generator) -> Detections:
    """With so many images from nowhere a camera and frame."""
    extra = rng.poisson(mean, found.counts.shape)
    camera = np.repeat(np.arange(len(found.cameras)), extra.sum(1))
    frame = np.repeat(np.tile(np.arange(found.n_frames), len(found.cameras)), extra.reshape(-1))
    low, high = found.uv.min(0), found.uv.max(0)
    order = np.lexsort((np.concatenate([found.frame, frame]), np.concatenate([found.camera, camera])))
    uv = np.concatenate([found.uv, rng.uniform(low, high, (len(frame), 2))])[order]
    validity = np.concatenate([found.validity, np.zeros(len(frame), np.uint8)])[order]
    return Detections.build(found.cameras, found.rate, found.counts + extra, uv, validity=validity)


def recalibrated(trial: Trial, seed: int) -> Trial:
    """One camera turned by 0.1° and moved by 2 mm, as a new calibration may have it."""
    rng = np.random.default_rng(seed)
    c = int(rng.integers(len(trial.rig)))
    axis, step = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    R = scipy.spatial.transform.Rotation.from_rotvec(np.radians(0.1) * axis).as_matrix()
    one = trial.rig[c]
    cameras = [
        replace(one, R=R @ one.R, t=R @ (one.t - one.R @ (2 * step))) if k == c else camera
        for k, camera in enumerate(trial.rig)
    ]
    return trial._replace(rig=replace(trial.rig, cameras=tuple(cameras)))


A, B = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.array([600.0, -700.0, 400.0])


def moved_world(trial: Trial) -> Trial:
    """The world turned by 90° and moved by a metre: x becomes A x + B."""

    def moved(camera: Camera) -> Camera:
        return replace(camera, R=camera.R @ A.T, t=camera.t - camera.R @ A.T @ B)

    corners = trial.rig.volume @ A.T + B
    rig = replace(trial.rig, cameras=tuple(map(moved, trial.rig)), volume=np.sort(corners, axis=0))
    return trial._replace(rig=rig, xyz=trial.xyz @ A.T + B)


def cropped(trial: Trial) -> Processed:
    n = trial.detections.n_frames
    first, stop = n // 4, n - n // 4
    part = trial._replace(detections=trial.detections.frames(first, stop), xyz=trial.xyz[:, first:stop])
    done = by_default(part)
    return done._replace(trajectories=replace(done.trajectories, first_frame=first + 1))


WAYS: dict[str, Callable[[Trial], Processed]] = {
    "the same again": by_default,
    "other parameters": lambda t: by_default(t, gate=3.5, process_noise=15_000.0, max_coasting=0.05, max_gap=0.2),
    "+0.3 px, 10 % lost": lambda t: by_default(disturbed(t, 0.3, 0.1, 1)),
    "other detection": lambda t: by_default(other_detection(t, 2)),
    "a camera recalibrated": lambda t: by_default(recalibrated(t, 3)),
    "a moved world": lambda t: by_default(moved_world(t)),
    "ladder tracker": lambda t: by_points(t, _triplets(t, EpipolarTriplets), ExtrapolationLadder()),
    "KISS tracker": lambda t: by_points(t, _triplets(t, KissTriplets), KissTracking()),
    "cropped to a half": cropped,
    "moved and disturbed": lambda t: by_default(moved_world(disturbed(t, 0.3, 0.1, 4))),
}


# Who is who
