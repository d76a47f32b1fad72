"""Marker detection beside other detectors: error, markers missed and invented, frames a second, on the same images.

    python benchmarks/detection.py [seconds]

39 discs on 1280 × 1024 px of 8 bits, noise of 3 grey levels, everything on one thread. The errors are those of discs
of 5, 8 and 12 px; the times, of 8 px, are the best of many, taken turn by turn within `seconds` (30) so that a busy
machine harms all alike. `RIVALS` drives both. Those that need a package that is absent are named and left out:
pip install ".[bench]" brings all. Every rival has the settings that suit these images best: the same threshold, sizes
around the discs' own.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from typing import Any, NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}

import cv2
import numpy as np
from metrics import Metric
from numpy.typing import NDArray

from kinemark.data.array_types import Floats
from kinemark.detect import detect_frames
from kinemark.native import PLAIN, library

Images = NDArray[np.uint8]
H, W, MARKERS = 1024, 1280, 39
BACKGROUND, PEAK, NOISE, BLUR, THRESHOLD = 12.0, 190.0, 3.0, 0.5, 60
CUT = 25
NEAR = 2.0  # px: what lies no closer to a disc is another thing


# ---- Images whose truth is known ----


def disc(u: float, v: float, diameter: float) -> Floats:
    """(CUT, CUT) a blurred disc at (u, v) from the middle of the cut-out, grey levels."""
    fine = 16
    at = (np.arange(CUT * fine) + 0.5) / fine - 0.5 - CUT // 2
    shape = ((at - u) ** 2 + (at[:, None] - v) ** 2 <= diameter**2 / 4).astype(np.float64)
    shape = shape.reshape(CUT, fine, CUT, fine).mean((1, 3))
    return PEAK * cv2.GaussianBlur(shape, (7, 7), BLUR)


def scene(diameter: float, rng: np.random.Generator, n: int = 16) -> tuple[Images, Floats]:
    """(n, H, W) images, and the true centroids (n, MARKERS, 2) px, no two discs close."""
    images = rng.normal(BACKGROUND, NOISE, (n, H, W)).astype(np.float32)
    cells = np.stack(np.meshgrid(np.arange(40, W - 40, 60), np.arange(40, H - 40, 60)), -1).reshape(-1, 2)
    truth = np.zeros((n, MARKERS, 2))
    for f in range(n):
        middle = cells[rng.choice(len(cells), MARKERS, replace=False)]
        part = rng.uniform(-0.5, 0.5, (MARKERS, 2))
        truth[f] = middle + part
        for (x, y), (u, v) in zip(middle - CUT // 2, part, strict=True):
            images[f, y : y + CUT, x : x + CUT] += disc(u, v, diameter)
    return np.clip(np.rint(images), 0, 255).astype(np.uint8), truth


# ---- Detectors: from images (n, H, W) of discs of about this diameter to centroids, an array (D, 2) a frame ----


def kinemark(images: Images, _: float) -> list[Floats]:
    blobs = detect_frames(images)
    return np.split(blobs.uv, np.cumsum(blobs.counts)[:-1])


def kinemark_plain(images: Images, diameter: float) -> list[Floats]:
    with plain():
        return kinemark(images, diameter)


@contextmanager
def plain() -> Iterator[None]:
    """Without the compiled library."""
    before = os.environ.get(PLAIN, "")
    os.environ[PLAIN] = "1"
    try:
        yield
    finally:
        os.environ[PLAIN] = before


def opencv_outline(images: Images, _: float) -> list[Floats]:
    """Moments of the outlines' polygons."""
    frames = []
    for image in images:
        m = [cv2.moments(outline) for outline in outlines(image)]
        frames.append(points([(k["m10"] / k["m00"], k["m01"] / k["m00"]) for k in m if k["m00"]]))
    return frames


def opencv_grey(images: Images, _: float) -> list[Floats]:
    """Moments of the grey levels above the threshold, in the outlines' rectangles."""
    frames = []
    for image in images:
        kept = cv2.threshold(image, THRESHOLD, 255, cv2.THRESH_TOZERO)[1]
        boxes = [cv2.boundingRect(outline) for outline in outlines(image)]
        frames.append(points([moved(cv2.moments(kept[y : y + h, x : x + w]), x, y) for x, y, w, h in boxes]))
    return frames


def opencv_ground(images: Images, _: float) -> list[Floats]:
    """Moments of the grey levels above the ground, in the outlines' rectangles widened by 2 px."""
    frames = []
    for image in images:
        ground = int(np.median(image[::64, ::8]))
        boxes = [cv2.boundingRect(outline) for outline in outlines(image)]
        boxes = [(max(x - 2, 0), max(y - 2, 0), x + w + 2, y + h + 2) for x, y, w, h in boxes]
        cuts = [image[y:to_y, x:to_x].astype(np.float32) - ground for x, y, to_x, to_y in boxes]
        m = [cv2.moments(cut) for cut in cuts]
        frames.append(points([moved(k, x, y) for (x, y, *_), k in zip(boxes, m, strict=True)]))
    return frames


def opencv_components(images: Images, _: float) -> list[Floats]:
    frames = []
    for image in images:
        white = cv2.threshold(image, THRESHOLD, 255, cv2.THRESH_BINARY)[1]
        frames.append(np.asarray(cv2.connectedComponentsWithStats(white)[3][1:], np.float64))
    return frames


def opencv_blobs(
    images: Images, diameter: float, levels: tuple[int, int] = (THRESHOLD, THRESHOLD + 10)
) -> list[Floats]:
    """SimpleBlobDetector with one level, which is its fastest."""
    wanted = cv2.SimpleBlobDetector.Params()
    wanted.minThreshold, wanted.maxThreshold, wanted.thresholdStep = *levels, 10
    wanted.minRepeatability = 1 if levels[1] - levels[0] <= 10 else 2
    wanted.blobColor, wanted.minArea, wanted.maxArea = 255, 4, 4 * diameter**2
    wanted.filterByInertia = wanted.filterByConvexity = False
    detector = cv2.SimpleBlobDetector.create(wanted)
    return [points([k.pt for k in detector.detect(image)]) for image in images]


def opencv_blobs_levels(images: Images, diameter: float) -> list[Floats]:
    """SimpleBlobDetector with a level each 10 greys, which is its usual way."""
    return opencv_blobs(images, diameter, (THRESHOLD, 200))


def regionprops(images: Images, _: float) -> list[Floats]:
    from skimage import measure

    frames = []
    for image in images:
        regions = measure.regionprops(measure.label(image > THRESHOLD), intensity_image=image)
        frames.append(points([region.centroid_weighted[::-1] for region in regions]))
    return frames


def trackpy(images: Images, diameter: float) -> list[Floats]:
    import trackpy

    trackpy.quiet()
    window = int(diameter) // 2 * 2 + 3
    found = [trackpy.locate(image, window, minmass=1000, threshold=5, engine="python") for image in images]
    return [np.asarray(table[["x", "y"]]) for table in found]


def outlines(image: Images) -> Any:
    """Of the white pixels, by OpenCV."""
    white = cv2.threshold(image, THRESHOLD, 255, cv2.THRESH_BINARY)[1]
    return cv2.findContours(white, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]


def moved(m: Any, x: int, y: int) -> tuple[float, float]:
    """The centroid of OpenCV's moments of a cut-out whose first pixel is (x, y)."""
    return x + m["m10"] / m["m00"], y + m["m01"] / m["m00"]


def points(pairs: list[Any]) -> Floats:
    """(D, 2), also of none."""
    return np.array(pairs, np.float64).reshape(-1, 2)


class Rival(NamedTuple):
    """A detector: its package beyond OpenCV, and how many frames it is timed on."""

    run: Callable[[Images, float], list[Floats]]
    needs: str = "cv2"
    frames: int = 16
    ours: bool = False


RIVALS = {
    "kinemark, compiled": Rival(kinemark, ours=True),
    "kinemark, NumPy alone": Rival(kinemark_plain, ours=True),
    "OpenCV outline": Rival(opencv_outline),
    "OpenCV grey in outline": Rival(opencv_grey),
    "OpenCV grey above ground": Rival(opencv_ground),
    "OpenCV connectedComponents": Rival(opencv_components, frames=4),
    "OpenCV SimpleBlob, 1 level": Rival(opencv_blobs, frames=4),
    "OpenCV SimpleBlob, 14 levels": Rival(opencv_blobs_levels, frames=2),
    "scikit-image regionprops": Rival(regionprops, needs="skimage", frames=2),
    "trackpy locate": Rival(trackpy, needs="trackpy", frames=1),
}


def installed() -> dict[str, Rival]:
    """The rivals that can run here."""
    found = {name: rival for name, rival in RIVALS.items() if find_spec(rival.needs)}
    if library() is None:
        del found["kinemark, compiled"]
    return found


# ---- Measuring ----


class Score(NamedTuple):
    """RMS error of an axis, px, over discs found within `NEAR`; discs not found; detections that are no disc."""

    error: float
    missing: int
    false: int


def score(found: list[Floats], truth: Floats) -> Score:
    off, missing, false = [np.zeros((0, 2))], 0, 0
    for uv, true in zip(found, truth, strict=True):
        if len(uv) == 0:
            missing += len(true)
            continue
        d = np.linalg.norm(uv[None] - true[:, None], axis=-1)
        near = d.argmin(1)
        good = d.min(1) < NEAR
        missing += int((~good).sum())
        false += len(uv) - len(np.unique(near[good]))
        off.append((uv[near] - true)[good])
    return Score(float(np.sqrt(np.mean(np.concatenate(off) ** 2))), missing, false)


def scores(rivals: dict[str, Rival], diameter: float, seed: int = 0, n: int = 16) -> dict[str, Score]:
    images, truth = scene(diameter, np.random.default_rng(seed), n)
    return {name: score(rival.run(images, diameter), truth) for name, rival in rivals.items()}


def times(rivals: dict[str, Rival], diameter: float, seconds: float) -> dict[str, float]:
    """Least time a frame, s, of each, and of reading the images."""
    images, _ = scene(diameter, np.random.default_rng(1))
    runs: dict[str, tuple[Callable[[], object], int]] = {"np.max": (images.max, len(images))}
    for name, rival in rivals.items():
        runs[name] = (partial(rival.run, images[: rival.frames], diameter), rival.frames)
    best = dict.fromkeys(runs, np.inf)
    end = time.perf_counter() + seconds
    while time.perf_counter() < end or np.inf in best.values():
        for name, (run, frames) in runs.items():
            for _ in range(10 if name in ("np.max", "kinemark, compiled") or frames == 16 else 1):
                begin = time.perf_counter()
                run()
                best[name] = min(best[name], (time.perf_counter() - begin) / frames)
    return best


def metrics() -> list[Metric]:
    """Errors of Kinemark, and its speed as a ratio to the fastest rival that comes with the tests."""
    cv2.setNumThreads(1)
    rivals = {name: rival for name, rival in installed().items() if rival.needs == "cv2"}
    ours = {name: rival for name, rival in rivals.items() if rival.ours}
    found = []
    for d in (5.0, 8.0, 12.0):
        for name, of in scores(ours, d, seed=int(d)).items():
            found.append(Metric(f"error, {d:g} px, {name}", of.error, "px", "less", relative=0.01))
            found.append(Metric(f"missing or false, {d:g} px, {name}", of.missing + of.false, "markers", "less"))
    best = times(rivals, 8.0, 10.0)
    fastest = min(best[name] for name, rival in rivals.items() if not rival.ours)
    return found + [Metric(f"speed, {name}", fastest / best[name], "ratio", "more", relative=0.35) for name in ours]


def main() -> None:
    cv2.setNumThreads(1)
    rivals = installed()
    errors = {d: scores(rivals, d, seed=int(d)) for d in (5.0, 8.0, 12.0)}
    best = times(rivals, 8.0, float(sys.argv[1]) if len(sys.argv) > 1 else 30.0)
    fastest = min(best[name] for name, rival in rivals.items() if not rival.ours)
    print(f"{'':29s} error px of discs of    missing  false  frames/s   × fastest")
    print(f"{'':29s}   5 px    8 px   12 px                                  rival")
    for name in rivals:
        of = [errors[d][name] for d in errors]
        px = "  ".join(f"{s.error:.4f}" for s in of)
        counts = f"{sum(s.missing for s in of):7d}{sum(s.false for s in of):7d}"
        print(f"{name:29s} {px} {counts}  {1 / best[name]:8.0f}   {fastest / best[name]:9.3g}")
    print(f"{'reading the image (np.max)':54s}{'':15s}{1 / best['np.max']:8.0f}   {fastest / best['np.max']:9.3g}")
    for name in RIVALS.keys() - rivals.keys():
        needs = RIVALS[name].needs
        print(f"{name} is left out: {'no compiler was there' if needs == 'cv2' else needs + ' is not installed'}")


if __name__ == "__main__":
    main()
