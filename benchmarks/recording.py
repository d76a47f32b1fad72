"""Two cameras' videos, from file to detections: what decoding and detection take alone, and together.

    python benchmarks/recording.py [frames a camera, 60]

The videos are lossless (FFV1), 1280 × 1024 px, with 39 discs of 8 px a frame. While markers are looked for in one batch
of frames the next is decoded, and cameras are done side by side on as many threads as there are processors. Printed are
frames a second of both cameras together, the best of three runs, taken in turns.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from unittest.mock import patch

import numpy as np
from detection import scene
from metrics import Metric
from numpy.typing import NDArray

from kinemark.detect import detect, detect_frames
from kinemark.io.images import ImageSource, open_images
from kinemark.io.video import write_video

BATCH = 16


def decode(sources: list[ImageSource]) -> None:
    for source in sources:
        for _ in source.batches(BATCH):
            pass


def look(films: list[NDArray[np.uint8]], frames: int) -> None:
    for film in films:
        for begin in range(0, frames, BATCH):
            detect_frames(film[: min(BATCH, frames - begin)])


def in_turn(sources: list[ImageSource]) -> None:
    """Each batch decoded, then looked at, and nothing at the same time."""
    for source in sources:
        for images in source.batches(BATCH):
            detect_frames(images)


def side_by_side(sources: list[ImageSource], threads: int) -> None:
    with patch("os.cpu_count", return_value=threads):
        detect(sources, cameras=[f"camera {k}" for k in range(len(sources))], rate=100.0)


def least_seconds(frames: int, rounds: int = 3) -> dict[str, float]:
    """Of each way, the best of the rounds, s."""
    films = [scene(8.0, np.random.default_rng(k))[0] for k in range(2)]
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{k}.mkv" for k in range(2)]
        for path, film in zip(paths, films, strict=True):
            write_video(path, (film[k % len(film)] for k in range(frames)), 100.0)
        sources = [open_images(path) for path in paths]
        ways: dict[str, Callable[[], None]] = {
            "decoding alone": lambda: decode(sources),
            "detection alone, from memory": lambda: look(films, frames),
            "one after the other": lambda: in_turn(sources),
            "detect, a camera at a time": lambda: side_by_side(sources, 1),
            "detect, two cameras at a time": lambda: side_by_side(sources, 2),
        }
        best = dict.fromkeys(ways, np.inf)
        for _ in range(rounds):
            for name, run in ways.items():
                begin = time.perf_counter()
                run()
                best[name] = min(best[name], time.perf_counter() - begin)
    return best


def metrics() -> list[Metric]:
    """What detection adds to the time of decoding alone."""
    best = least_seconds(32)
    ratio = best["detect, two cameras at a time"] / best["decoding alone"]
    return [Metric("detection of two videos by decoding them alone", ratio, "ratio", "less", relative=0.5)]


def main() -> None:
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    best = least_seconds(frames)
    print(f"{os.cpu_count()} processors")
    for name, seconds in best.items():
        print(f"{name:30s} {2 * frames / seconds:8.0f} frames/s")


if __name__ == "__main__":
    main()
