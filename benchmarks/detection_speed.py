"""Raw videos of six cameras, from files to detections and to a C3D file: frame-sets a second of the processor's time.

    python benchmarks/detection_speed.py [frames a camera, 200]

The videos are uncompressed, 1280 × 1024 px, with 39 discs of 8 px a frame that stand in other places in each of 16
frames, which are repeated. Decoding alone is what no detection can save; what `detect` takes beyond it is learning
(`detect.learning`) and the detections. The whole chain has videos of its own, of a walk with 39 markers drawn as such
discs: detected, tracked, and written. Counted is the time of all threads together, the median of three rounds in turns;
of two threads also the time that goes by, which only a machine at rest shows.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
from detection import scene
from metrics import Metric
from numpy.typing import NDArray

from kinemark.data import Rig, Trial
from kinemark.detect import Centroids, detect
from kinemark.io.images import ImageSource, open_images
from kinemark.io.trial import write_trial
from kinemark.synth import observe, ring, walking, with_markers
from kinemark.track import to_trajectories
from kinemark.track.simultaneous import track_detections

CAMERAS, BATCH, ROUNDS, RATE = 6, 16, 3, 100.0
GONE_BY = "detection, two threads, time gone by"
STATED = Centroids(threshold=60, min_area=4, max_area=2000, min_width=2, max_aspect=2.5)


def write_raw(path: Path, film: NDArray[np.uint8], frames: int) -> None:
    """An uncompressed video of so many frames, of which a few are repeated."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("rawvideo", 100)
        stream.height, stream.width, stream.pix_fmt = *film.shape[1:], "gray"
        for k in range(frames):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(film[k % len(film)], format="gray")))
        container.mux(stream.encode(None))


def processor_seconds(run: Callable[[], object]) -> float:
    """Of all threads of this process, s."""
    before = resource.getrusage(resource.RUSAGE_SELF)
    run()
    after = resource.getrusage(resource.RUSAGE_SELF)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def decode(sources: list[ImageSource]) -> None:
    for source in sources:
        for _ in source.batches(BATCH):
            pass


def write_walk(folder: Path, frames: int) -> tuple[Rig, list[Path]]:
    """Six cameras about a walk with 39 markers, and their raw videos: soft discs of 8 px where markers are seen."""
    rig = ring(CAMERAS)
    subject = with_markers(walking(duration_s=frames / RATE, rate=RATE, seed=1), 39, seed=1)
    seen = observe(rig, subject, seed=1).sight
    reach = np.arange(-6, 7)
    paths = []
    for c, camera in enumerate(rig):
        film = np.full((frames, camera.size[1], camera.size[0]), 20, np.uint8)
        for m, f in np.argwhere(seen.visible[c, :, :frames]):
            u, v = seen.uv[c, m, f]
            x, y = round(u) + reach, round(v) + reach
            if min(x[0], y[0]) >= 0 and x[-1] < film.shape[2] and y[-1] < film.shape[1]:
                disc = np.clip(4.5 - np.hypot(x - u, (y - v)[:, None]), 0, 1)
                window = film[f, y[0] : y[-1] + 1, x[0] : x[-1] + 1]
                np.maximum(window, (20 + 200 * disc).astype(np.uint8), out=window)
        paths.append(folder / f"walk {c}.mkv")
        write_raw(paths[-1], film, frames)
    return rig, paths


def whole_chain(rig: Rig, sources: list[ImageSource], target: Path, threads: int) -> None:
    """From videos to a C3D file."""
    found = detect(sources, cameras=rig.names, rate=RATE, threads=threads)
    target.unlink(missing_ok=True)
    trajectories = to_trajectories(track_detections(found, rig), rig)
    write_trial(Trial("walk", trajectories), target)


def median_seconds(frames: int) -> dict[str, float]:
    """Of each way, the median of the rounds, s: of the processor, and gone by where the name ends so."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{k}.mkv" for k in range(CAMERAS)]
        for k, path in enumerate(paths):
            write_raw(path, scene(8.0, np.random.default_rng(k))[0], frames)
        rig, walk = write_walk(Path(folder), frames)
        sources, names = [open_images(path) for path in paths], [f"camera {k}" for k in range(CAMERAS)]
        walked = [open_images(path) for path in walk]
        ways: dict[str, Callable[[], object]] = {
            "decoding alone": lambda: decode(sources),
            "detection, all stated": lambda: detect(sources, cameras=names, rate=RATE, method=STATED, threads=1),
            "detection, all learned": lambda: detect(sources, cameras=names, rate=RATE, threads=1),
            "detection, two threads": lambda: detect(sources, cameras=names, rate=RATE, threads=2),
            "whole chain": lambda: whole_chain(rig, walked, Path(folder) / "walk.c3d", 1),
        }
        spent: dict[str, list[float]] = {name: [] for name in [*ways, GONE_BY]}
        for _ in range(ROUNDS):
            for name, run in ways.items():
                began = time.perf_counter()
                spent[name].append(processor_seconds(run))
                if name == "detection, two threads":
                    spent[GONE_BY].append(time.perf_counter() - began)
    return {name: float(np.median(of)) for name, of in spent.items()}


def metrics() -> list[Metric]:
    """What detection and the whole chain take beside decoding alone, of short recordings."""
    spent = median_seconds(64)
    base = spent["decoding alone"]
    return [
        Metric(f"{name}, by decoding alone", spent[name] / base, "ratio", "less", relative=0.5)
        for name in spent
        if name not in ("decoding alone", GONE_BY)
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frames", nargs="?", type=int, default=200)
    asked = parser.parse_args()
    for name, seconds in median_seconds(asked.frames).items():
        print(f"{name:34s} {asked.frames / seconds:8.0f} frame-sets a second")


if __name__ == "__main__":
    main()
