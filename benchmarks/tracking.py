"""From 2D points to tracks, all methods on the same scenes: what they find, invent, swap, and how fast they are.

    python benchmarks/tracking.py [scene …] [--seeds N] [--runs N] [--growth]

A person walks through a ring or an arc of cameras, or two people do; limbs hide markers, images nearer than 8 px run
together, points come from nowhere. To be found is every sample inside the volume of which two cameras have an image of
its own. A ghost is a tracked point with no marker within 10 mm. Rivals that are absent are named and left out:
pip install ".[bench]" brings them (`tracking_rivals`). Everything runs on one thread; its time is the processor's, with
`--runs` the median of so many. `--growth` shows instead how the default tracker's time grows with markers and cameras.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import numpy as np
from metrics import Metric
from numpy.typing import NDArray
from tracking_rivals import RIVALS

from kinemark.data import Detections, Rig, Tracks
from kinemark.data.method import Method
from kinemark.match import EpipolarTriplets, KissTriplets, match
from kinemark.reconstruct import reconstruct
from kinemark.synth import ObservedImages, Subject, combined_subjects, observe, ring, walking, with_markers
from kinemark.synth.score import Score, score
from kinemark.track import ExtrapolationLadder, KissTracking, track
from kinemark.track.simultaneous import Simultaneous, track_detections


@dataclass(frozen=True)
class Scene:
    """What is seen, by how many cameras, and how well."""

    markers: int
    cameras: int = 6
    rate: float = 100.0
    noise: float = 0.1
    false: float = 2.0
    sweep: float = 360.0
    people: int = 1
    seconds: float = 2.0


SCENES = {
    "15, 6 cameras, 50 Hz": Scene(15, rate=50.0),
    "15, 4 cameras, 100 Hz, arc": Scene(15, 4, sweep=120.0),
    "39, 4 cameras, 50 Hz": Scene(39, 4, rate=50.0),
    "39, 6 cameras, 100 Hz": Scene(39),
    "39, 6 cameras, 100 Hz, 8 s": Scene(39, seconds=8.0),
    "39, 6 cameras, 100 Hz, arc, 10 false": Scene(39, sweep=120.0, false=10.0),
    "39, 8 cameras, 200 Hz, 0.3 px": Scene(39, 8, rate=200.0, noise=0.3),
    "39, 12 cameras, 100 Hz, 1 false": Scene(39, 12, false=1.0),
    "two people, 39, 8 cameras, 100 Hz": Scene(39, 8, people=2),
    "100, 8 cameras, 100 Hz, 10 false": Scene(100, 8, false=10.0),
    "100, 12 cameras, 50 Hz": Scene(100, 12, rate=50.0),
}


class Made(NamedTuple):
    """A scene: who walks, the cameras, what they saw, and which samples are to be found (M, F)."""

    subject: Subject
    rig: Rig
    observed: ObservedImages
    seen: NDArray[np.bool_]


def made(scene: Scene, seed: int = 0) -> Made:
    """The scene, with this seed."""
    if scene.people == 1:
        subject = with_markers(person(scene, seed), scene.markers, seed=seed)
    else:
        each = [person(scene, seed, (1200.0, 400.0)), person(scene, seed + 7, (1200.0, 1000.0), phase=0.2, speed=900.0)]
        counts = (scene.markers // 2, scene.markers - scene.markers // 2)
        subject = combined_subjects(*(with_markers(one, n, seed=seed + n) for one, n in zip(each, counts, strict=True)))
    rig = ring(scene.cameras, sweep_deg=scene.sweep, focal_px=1100.0)
    observed = observe(
        rig,
        subject,
        noise_px=scene.noise,
        false_per_frame=scene.false,
        merge_px=8.0,
        least_visible=0.3,
        seed=seed,
    )
    low, high = rig.volume if np.isfinite(rig.volume).all() else (np.full(3, -np.inf), np.full(3, np.inf))
    inside = ((subject.xyz >= low) & (subject.xyz <= high)).all(-1)
    return Made(subject, rig, observed, (observed.unmerged_views >= 2) & inside)


def person(
    scene: Scene,
    seed: int,
    middle: tuple[float, float] = (1200.0, 700.0),
    phase: float = 0.8,
    speed: float = 1100.0,
) -> Subject:
    """Somebody who walks; so slowly, where it takes long, that the volume holds it."""
    return walking(
        duration_s=scene.seconds,
        rate=scene.rate,
        seed=seed,
        speed_mm_s=speed * 2.0 / scene.seconds,
        wobble_mm=3.0,
        marker_radius_mm=7.0,
        middle=middle,
        phase=phase,
    )


# ---- Methods: from detections to tracks ----


def staged(matching: Method, tracking: Method) -> Callable[[Detections, Rig], Tracks]:
    """Matching, reconstruction and tracking one after another."""

    def run(detections: Detections, rig: Rig) -> Tracks:
        cloud = reconstruct(match(detections, rig, method=matching), detections, rig)
        return track(cloud, method=tracking)

    return run


METHODS: dict[str, Callable[[Detections, Rig], Tracks]] = {
    "simultaneous": lambda detections, rig: track_detections(detections, rig, method=Simultaneous()),
    "epipolar_triplets, extrapolation_ladder": staged(EpipolarTriplets(), ExtrapolationLadder()),
    "kiss_triplets, kiss_tracking": staged(KissTriplets(), KissTracking()),
}


def methods(cameras: int) -> tuple[dict[str, Callable[[Detections, Rig], Tracks]], list[str]]:
    """All that can run on so many cameras, and why the others cannot."""
    able, unable = dict(METHODS), []
    for name, rival in RIVALS.items():
        if rival.absent:
            unable.append(f"{name}: {', '.join(rival.absent)} is not installed")
        elif cameras > rival.most_cameras:
            unable.append(f"{name}: takes at most {rival.most_cameras} cameras")
        else:
            able[name] = rival.run
    return able, unable


def line(name: str, result: Score, samples: int, seconds: float) -> str:
    """A row of the table."""
    pieces = result.fragments[result.fragments > 0]
    return (
        f"  {name:42s}{100 * result.recall:7.2f}{100 * result.precision:8.2f}{result.extra_per_frame:8.3f}"
        f"{result.rmse:7.2f}{100 * result.coverage:7.1f}{result.chi2:7.2f}{result.swaps:6d}{result.handovers:6d}"
        f"{pieces.mean() if len(pieces) else np.nan:7.2f}{100 * np.nanmean(result.best):7.1f}"
        f"{samples / seconds / 1000:8.1f}"
    )


HEAD = (
    f"  {'':42s}{'recall':>7s}{'precis.':>8s}{'ghosts':>8s}{'RMSE':>7s}{'95 %':>7s}{'χ²/3':>7s}{'swaps':>6s}"
    f"{'hand-':>6s}{'pieces':>7s}{'best':>7s}{'1000':>8s}\n"
    f"  {'':42s}{'%':>7s}{'%':>8s}{'/frame':>8s}{'mm':>7s}{'hold':>7s}{'':>7s}{'':>6s}{'overs':>6s}"
    f"{'':>7s}{'track %':>7s}{'samp./s':>8s}"
)


def warm_up() -> None:
    """Run everything once, so that no method's time has imports in it."""
    _, rig, observed, _ = made(Scene(5, 4, rate=25.0))
    for run in methods(4)[0].values():
        run(observed.detections, rig)


def timed(
    run: Callable[[Detections, Rig], Tracks], observed: ObservedImages, rig: Rig, runs: int
) -> tuple[Tracks, float]:
    """The tracks, and the median of the seconds of processor that they take."""
    seconds = []
    for _ in range(runs):
        begin = time.process_time()
        tracks = run(observed.detections, rig)
        seconds.append(time.process_time() - begin)
    return tracks, float(np.median(seconds))


def growth(runs: int) -> None:
    """Time of the default tracker by number of markers and of cameras, scenes of 2 s."""
    print("markers cameras       s   µs a sample   µs an image")
    for scene in (*(Scene(n, 8) for n in (20, 40, 80, 160)), *(Scene(39, n) for n in (4, 8, 16))):
        _, rig, observed, seen = made(scene)
        _, s = timed(track_detections, observed, rig, runs)
        per = 1e6 * s / seen.sum(), 1e6 * s / len(observed.detections)
        print(f"{scene.markers:7d}{scene.cameras:8d}{s:8.3f}{per[0]:14.1f}{per[1]:14.2f}", flush=True)


SHORT = ("15, 6 cameras, 50 Hz", "39, 4 cameras, 50 Hz", "39, 6 cameras, 100 Hz, arc, 10 false")


def metrics() -> list[Metric]:
    """The default tracker on three scenes, two seeds each, and its time as a ratio to the ladder's on one."""
    warm_up()
    found = []
    for name in SHORT:
        for seed in (0, 1):
            subject, rig, observed, seen = made(SCENES[name], seed)
            of = score(track_detections(observed.detections, rig), subject.xyz, seen=seen)
            said = f"{name}, seed {seed}"
            found += [
                Metric(f"recall: {said}", 100 * of.recall, "%", "more", absolute=0.05),
                Metric(f"ghosts: {said}", of.extra_per_frame, "a frame", "less", absolute=0.005),
                Metric(f"RMSE: {said}", of.rmse, "mm", "less", relative=0.02),
                Metric(f"95 % ellipsoid: {said}", 100 * of.coverage, "%", "near", absolute=1.0),
                Metric(f"swaps: {said}", of.swaps, "", "less"),
            ]
    _, rig, observed, _ = made(SCENES["39, 6 cameras, 100 Hz"])
    ours, ladder = (timed(run, observed, rig, 3)[1] for run in list(METHODS.values())[:2])
    return [*found, Metric("time by extrapolation_ladder's", ours / ladder, "ratio", "less", relative=0.35)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", nargs="*", help="part of a scene's name; all where none is given")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--runs", type=int, default=1, help="of each method, for its time")
    parser.add_argument("--growth", action="store_true")
    wanted = parser.parse_args()
    warm_up()
    if wanted.growth:
        growth(wanted.runs)
        return
    print(HEAD)
    for name, scene in SCENES.items():
        if wanted.scene and not any(part in name for part in wanted.scene):
            continue
        able, unable = methods(scene.cameras)
        for seed in range(wanted.seeds):
            subject, rig, observed, seen = made(scene, seed)
            print(f"{name}{f', seed {seed}' if wanted.seeds > 1 else ''}: {int(seen.sum())} samples")
            for method, run in able.items():
                tracks, seconds = timed(run, observed, rig, wanted.runs)
                print(line(method, score(tracks, subject.xyz, seen=seen), int(seen.sum()), seconds), flush=True)
        for why in unable:
            print(f"  left out: {why}")


if __name__ == "__main__":
    main()
