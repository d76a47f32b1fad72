"""Raw videos of six cameras, from files to detections and to a C3D file: frame-sets a second of the processor's time.

    python benchmarks/detection_speed.py [frames a camera, 200]

The videos are uncompressed, 1280 × 1024 px, of somebody with 39 markers who walks on the spot, drawn as soft discs of
8 px: no frame comes twice, as what is repeated stays in the processor's cache, and the subject stays in view. Decoding
alone is what no detection can save; what `detect` takes beyond it is learning (`detect.learning`) and the detections.
The whole chain is detected, tracked, and written. Counted is the time of all threads together, the median of three
rounds in turns; of two threads also the time that goes by, which only a machine at rest shows.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import av
import numpy as np
from metrics import Metric
from numpy.typing import NDArray

from kinemark.data import Camera, Rig, Trial
from kinemark.data.array_types import Bools, Floats, Ints
from kinemark.detect import Centroids, detect
from kinemark.io.images import ImageSource, open_images
from kinemark.io.trial import write_trial
from kinemark.synth import Subject, observe, ring, walking, with_markers
from kinemark.track import to_trajectories
from kinemark.track.simultaneous import track_detections

CAMERAS, BATCH, ROUNDS, RATE = 6, 16, 3, 100.0
SPEED = 1100.0  # mm/s, of the walk
GONE_BY = ", time gone by"
STATED = Centroids(threshold=60, min_area=4, max_area=2000, min_width=2, max_aspect=2.5)


def write_raw(path: Path, film: Iterable[NDArray[np.uint8]], size: Ints) -> None:
    """An uncompressed video of frames (H, W) of this width and height (2)."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("rawvideo", 100)
        (stream.width, stream.height), stream.pix_fmt = size.tolist(), "gray"
        for image in film:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="gray")))
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


def on_the_spot(walk: Subject) -> Subject:
    """A walk at `SPEED` along x as a treadmill shows it."""
    moved = np.zeros((walk.n_frames, 3))
    moved[:, 0] = SPEED * (np.arange(walk.n_frames) - walk.n_frames / 2) / walk.rate
    limbs = replace(walk.capsules, a=walk.capsules.a - moved, b=walk.capsules.b - moved)
    return replace(walk, xyz=walk.xyz - moved, capsules=limbs)


def drawn(camera: Camera, uv: Floats, visible: Bools) -> Iterator[NDArray[np.uint8]]:
    """Frames (H, W) with a soft disc of 8 px where a marker (M, F, 2) px is visible (M, F)."""
    reach = np.arange(-6, 7)
    for f in range(uv.shape[1]):
        image = np.full(camera.size[::-1], 20, np.uint8)
        for u, v in uv[np.flatnonzero(visible[:, f]), f]:
            x, y = round(u) + reach, round(v) + reach
            if min(x[0], y[0]) >= 0 and x[-1] < camera.size[0] and y[-1] < camera.size[1]:
                disc = np.clip(4.5 - np.hypot(x - u, (y - v)[:, None]), 0, 1)
                window = image[y[0] : y[-1] + 1, x[0] : x[-1] + 1]
                np.maximum(window, (20 + 200 * disc).astype(np.uint8), out=window)
        yield image


def write_walk(folder: Path, frames: int) -> tuple[Rig, list[Path]]:
    """Six cameras about somebody with 39 markers who walks on the spot, and their raw videos."""
    rig = ring(CAMERAS)
    walk = on_the_spot(walking(duration_s=frames / RATE, rate=RATE, seed=1, speed_mm_s=SPEED))
    seen = observe(rig, with_markers(walk, 39, seed=1), seed=1).sight
    paths = [folder / f"walk {c}.mkv" for c in range(CAMERAS)]
    for camera, path, uv, visible in zip(rig, paths, seen.uv, seen.visible, strict=True):
        write_raw(path, drawn(camera, uv[:, :frames], visible[:, :frames]), camera.size)
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
        rig, paths = write_walk(Path(folder), frames)
        sources, target = [open_images(path) for path in paths], Path(folder) / "walk.c3d"
        ways: dict[str, Callable[[], object]] = {
            "decoding alone": lambda: decode(sources),
            "detection, all stated": lambda: detect(sources, cameras=rig.names, rate=RATE, method=STATED, threads=1),
            "detection, all learned": lambda: detect(sources, cameras=rig.names, rate=RATE, threads=1),
            "detection, two threads": lambda: detect(sources, cameras=rig.names, rate=RATE, threads=2),
            "whole chain": lambda: whole_chain(rig, sources, target, 1),
            "whole chain, two threads": lambda: whole_chain(rig, sources, target, 2),
        }
        spent: dict[str, list[float]] = {name: [] for name in ways}
        for _ in range(ROUNDS):
            for name, run in ways.items():
                began = time.perf_counter()
                spent[name].append(processor_seconds(run))
                if name.endswith("two threads"):
                    spent.setdefault(name + GONE_BY, []).append(time.perf_counter() - began)
    return {name: float(np.median(of)) for name, of in spent.items()}


def metrics() -> list[Metric]:
    """What detection and the whole chain take beside decoding alone, of short recordings."""
    spent = median_seconds(64)
    base = spent.pop("decoding alone")
    return [
        Metric(f"{name}, by decoding alone", seconds / base, "ratio", "less", relative=0.5)
        for name, seconds in spent.items()
        if not name.endswith(GONE_BY)
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frames", nargs="?", type=int, default=200)
    asked = parser.parse_args()
    for name, seconds in median_seconds(asked.frames).items():
        print(f"{name:34s} {asked.frames / seconds:8.0f} frame-sets a second")


if __name__ == "__main__":
    main()
