"""How good the proposed parameters are: pairs of markers close to each other, and real infrared videos.

The videos show a plate with 15 LEDs (published by IEatCodeDaily/indoor-infrared-mocap). Nobody says which are hidden
when, so frames are counted in which exactly 15 are found, and those with more, in which at least one is false.

Run: python studies/kiss_proposed.py [--no-videos]     (the videos take some minutes)
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence

import numpy as np
from kiss_detection import Images, Method, Row, methods_of, show
from numpy.typing import NDArray
from recordings import recording

from kinemark.data.array_types import Floats
from kinemark.detect import Blobs, Centroids, KissNearest, KissScanning, detect_frames
from kinemark.detect.proposal import propose
from kinemark.io.images import open_images

LEDS = 15


def pairs(number: int = 200) -> Iterator[Row]:
    """Share of pairs of discs of 8 to 14 px, turned any way, of which both are found within a fifth of a diameter."""
    rng = np.random.default_rng(5)
    for apart in (0.7, 0.85, 1.0):
        found = np.zeros(3)
        for diameter in (8.0, 11.0, 14.0):
            methods = methods_of(propose(drawn(places(rng, 20, diameter, 0.0), diameter)), aspect=1.0)
            centres = places(rng, number, diameter, apart)
            images = drawn(centres, diameter)
            found += [both_found(detect_frames(images, method=m), centres, diameter / 5) for m in methods]
        cells = tuple(f"{share:.0%}" for share in found / (3 * number))
        yield Row(f"pairs of discs {apart:g} diameters apart, both found", "", cells)


def places(rng: np.random.Generator, number: int, diameter: float, apart: float) -> Floats:
    """(N, 2, 2) px centres of two discs in images of 48 × 48 px."""
    turn = rng.uniform(0, np.pi, number)
    half = apart * diameter / 2 * np.stack([np.cos(turn), np.sin(turn)], -1)
    return np.stack([half, -half], 1) + 23.5 + rng.uniform(-0.5, 0.5, (number, 1, 2))


def drawn(centres: Floats, diameter: float) -> Images:
    """(N, 48, 48) discs with rims a pixel wide, of grey level 200 on 10."""
    y, x = np.mgrid[:48, :48]
    inside = diameter / 2 - np.hypot(x - centres[:, :, 0, None, None], y - centres[:, :, 1, None, None])
    return np.asarray(np.round(10 + 190 * np.clip(inside + 0.5, 0, 1).max(1)), np.uint8)


def both_found(blobs: Blobs, centres: Floats, reach: float) -> int:
    """In how many images there are exactly two detections, both within reach of their disc, px."""
    good, ends = 0, np.cumsum(blobs.counts)
    for f in np.flatnonzero(blobs.counts == 2):
        uv = blobs.uv[ends[f] - 2 : ends[f]]
        off = min(np.linalg.norm(each - centres[f], axis=1).max() for each in (uv, uv[::-1]))
        good += int(off < reach)
    return good


def real() -> Iterator[Row]:
    """Frames of the infrared videos with all LEDs and nothing else; in the first column the number of frames."""
    folder = recording("cameras/ir_4cam_footage")
    for camera in range(4):
        source = open_images(folder / f"calibration1_{camera}.mp4")
        proposed = propose(source)
        for name, methods in (
            ("proposed", methods_of(proposed, aspect=1.0)),
            ("default", (KissScanning(), KissNearest(), Centroids(aspect=1.0))),
        ):
            counts = [np.concatenate(each) for each in zip(*counted(source.batches(64), methods), strict=True)]
            cells = (f"{(c == LEDS).sum()} ({(c > LEDS).sum()} more)" for c in counts)
            yield Row(f"infrared camera {camera}, {name} parameters", f"{source.n_frames}", tuple(cells))


def counted(batches: Iterator[Images], methods: Sequence[Method]) -> Iterator[list[NDArray[np.int64]]]:
    """Valid detections a frame, for each batch and method."""
    for images in batches:
        found = (detect_frames(images, method=method) for method in methods)
        yield [
            np.add.reduceat(np.append(b.validity == 0, 0), np.cumsum(b.counts) - b.counts) * (b.counts > 0)
            for b in found
        ]


if __name__ == "__main__":
    show(pairs(), "")
    if "--no-videos" not in sys.argv:
        print("\nframes with exactly 15 LEDs, and with more")
        show(real(), "frames")
