"""Raw videos of six cameras, from files to detections: frame-sets a second of the processor's time.

    python benchmarks/detection_speed.py [frames a camera, 200]

The videos are uncompressed, 1280 × 1024 px, with 39 discs of 8 px a frame that stand in other places in each of 16
frames, which are repeated. Decoding alone is what no detection can save; what `detect` takes beyond it is learning
(`detect.learning`) and the detections. Counted is the time of all threads together, the least of three rounds in turns.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
from detection import scene
from metrics import Metric
from numpy.typing import NDArray

from kinemark.detect import Centroids, detect
from kinemark.io.images import ImageSource, open_images

CAMERAS, BATCH, ROUNDS = 6, 16, 3
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


def least_seconds(frames: int) -> dict[str, float]:
    """Of each way, the least of the rounds, s of the processor."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{k}.mkv" for k in range(CAMERAS)]
        for k, path in enumerate(paths):
            write_raw(path, scene(8.0, np.random.default_rng(k))[0], frames)
        sources, names = [open_images(path) for path in paths], [f"camera {k}" for k in range(CAMERAS)]
        ways: dict[str, Callable[[], object]] = {
            "decoding alone": lambda: decode(sources),
            "detection, all stated": lambda: detect(sources, cameras=names, rate=100.0, method=STATED),
            "detection, all learned": lambda: detect(sources, cameras=names, rate=100.0),
        }
        best = dict.fromkeys(ways, np.inf)
        for _ in range(ROUNDS):
            for name, run in ways.items():
                best[name] = min(best[name], processor_seconds(run))
    return best


def metrics() -> list[Metric]:
    """What detection adds to decoding alone, and learning to detection, of short recordings."""
    best = least_seconds(64)
    base = best["decoding alone"]
    return [
        Metric(f"{name}, by decoding alone", best[name] / base, "ratio", "less", relative=0.5)
        for name in best
        if name != "decoding alone"
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frames", nargs="?", type=int, default=200)
    asked = parser.parse_args()
    for name, seconds in least_seconds(asked.frames).items():
        print(f"{name:30s} {asked.frames / seconds:8.0f} frame-sets a processor's second")


if __name__ == "__main__":
    main()
