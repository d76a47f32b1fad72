"""Marker detection: frames a second and centroid error, beside OpenCV's threshold, findContours and moments.

    python benchmarks/detection.py [repeats]

39 discs of 8 px on 1280 × 1024 px of 8 bits, noise of 3 grey levels, one thread, both in one run, turn by turn.
OpenCV's moments are those of the outline's polygon; a grey-weighted variant (moments of the thresholded
cut-out) is shown as well, as that is what one compares accuracy with.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from kinemark.detect import detect_frames

Images = NDArray[np.uint8]
Points = NDArray[np.float64]
H, W, FRAMES, MARKERS = 1024, 1280, 16, 39
BACKGROUND, PEAK, NOISE, BLUR, THRESHOLD = 12.0, 190.0, 3.0, 0.5, 60
CUT = 25


def disc(u: float, v: float, diameter: float) -> Points:
    """(CUT, CUT) a blurred disc at (u, v) from the middle of the cut-out, grey levels."""
    fine = 16
    at = (np.arange(CUT * fine) + 0.5) / fine - 0.5 - CUT // 2
    shape = ((at - u) ** 2 + (at[:, None] - v) ** 2 <= diameter**2 / 4).astype(np.float64)
    shape = shape.reshape(CUT, fine, CUT, fine).mean((1, 3))
    return PEAK * cv2.GaussianBlur(shape, (7, 7), BLUR)


def scene(diameter: float, rng: np.random.Generator) -> tuple[Images, Points]:
    """(FRAMES, H, W) images, and the true centroids (FRAMES, MARKERS, 2) px, no two discs close."""
    images = rng.normal(BACKGROUND, NOISE, (FRAMES, H, W)).astype(np.float32)
    cells = np.stack(np.meshgrid(np.arange(40, W - 40, 60), np.arange(40, H - 40, 60)), -1).reshape(-1, 2)
    truth = np.zeros((FRAMES, MARKERS, 2))
    for f in range(FRAMES):
        middle = cells[rng.choice(len(cells), MARKERS, replace=False)]
        part = rng.uniform(-0.5, 0.5, (MARKERS, 2))
        truth[f] = middle + part
        for (x, y), (u, v) in zip(middle - CUT // 2, part, strict=True):
            images[f, y : y + CUT, x : x + CUT] += disc(u, v, diameter)
    return np.clip(np.rint(images), 0, 255).astype(np.uint8), truth


def kinemark(images: Images) -> list[Points]:
    """Our centroids, a frame each."""
    blobs = detect_frames(images)
    return np.split(blobs.uv, np.cumsum(blobs.counts)[:-1])


def opencv(images: Images) -> list[Points]:
    """Centroids of the outlines."""
    frames = []
    for image in images:
        white = cv2.threshold(image, THRESHOLD, 255, cv2.THRESH_BINARY)[1]
        outlines = cv2.findContours(white, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
        m = [cv2.moments(outline) for outline in outlines]
        frames.append(np.array([(k["m10"] / k["m00"], k["m01"] / k["m00"]) for k in m if k["m00"]]))
    return frames


def opencv_grey(images: Images) -> list[Points]:
    """Centroids of the grey levels above the threshold, in the outlines' rectangles."""
    frames = []
    for image in images:
        kept = cv2.threshold(image, THRESHOLD, 255, cv2.THRESH_TOZERO)[1]
        white = cv2.threshold(image, THRESHOLD, 255, cv2.THRESH_BINARY)[1]
        outlines = cv2.findContours(white, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
        boxes = [cv2.boundingRect(outline) for outline in outlines]
        m = [cv2.moments(kept[y : y + h, x : x + w]) for x, y, w, h in boxes]
        pairs = zip(boxes, m, strict=True)
        frames.append(np.array([(x + k["m10"] / k["m00"], y + k["m01"] / k["m00"]) for (x, y, _, _), k in pairs]))
    return frames


def seconds(run: Callable[[Images], list[Points]], images: Images) -> float:
    """A frame, s."""
    begin = time.perf_counter()
    run(images)
    return (time.perf_counter() - begin) / len(images)


def error(found: list[Points], truth: Points) -> tuple[float, int]:
    """RMS error of an axis, px, over markers found within 2 px, and how many were not."""
    off, missing = [], 0
    for uv, true in zip(found, truth, strict=True):
        d = np.linalg.norm(uv[None] - true[:, None], axis=-1)
        near = d.argmin(1)
        good = d.min(1) < 2
        missing += int((~good).sum())
        off.append((uv[near] - true)[good])
    return float(np.sqrt(np.mean(np.concatenate(off) ** 2))), missing


def main() -> None:
    cv2.setNumThreads(1)
    rng = np.random.default_rng(0)
    rivals = {"kinemark": kinemark, "cv2 outline": opencv, "cv2 grey": opencv_grey}
    for diameter in (5.0, 8.0, 12.0):
        images, truth = scene(diameter, rng)
        for name, run in rivals.items():
            rms, missing = error(run(images), truth)
            print(f"disc {diameter:4.0f} px  {name:12s} error {rms:.4f} px an axis, {missing} missing")
    images, _ = scene(8.0, rng)
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    times = {name: min(values) for name, values in turns(rivals, images, repeats).items()}
    for name, best in times.items():
        print(f"{name:12s} {1 / best:6.0f} frames/s, {times['cv2 outline'] / best:.2f} × cv2 outline")


def turns(
    rivals: Mapping[str, Callable[[Images], list[Points]]], images: Images, repeats: int
) -> dict[str, list[float]]:
    """Seconds a frame, `repeats` times, turn by turn so that a busy machine harms all alike."""
    values: dict[str, list[float]] = {name: [] for name in rivals}
    for _ in range(repeats):
        for name, run in rivals.items():
            values[name].append(seconds(run, images))
    return values


if __name__ == "__main__":
    main()
