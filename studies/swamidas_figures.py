"""Figures 4.4, 4.5 and 4.8 to 4.13 of Swamidas (1997), redrawn: sensor tracks, motions, images, gaps.

Figures 4.4 and 4.5 show the track of a magnetic sensor that is moved along a straight line, as measured and after a
filter, a moving average: while it does not "remove the curvature of the data (since we expect a line), it does remove
much of the high frequency noise". Neither data nor window are told; here a sensor is simulated whose noise grows with
its distance from the transmitter, up to the 0.1 inch that its maker states, and whose field is bent. Printed are what a
window leaves of both.

Figures 4.8 to 4.10 are the motions in space, 4.11 what the two cameras see of them, 4.12 the tracks of run 1
reconstructed from images with noise of 5 and 10 %, and 4.13 where markers are hidden. The motions are rebuilt, so the
figures have the character of the document's and not their shape.

Run: python studies/swamidas_figures.py [--figures FILE.html]
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from missing_markers_figures import HEIGHT, WIDTH, polyline
from swamidas_images import FOCAL, RMS, cameras
from swamidas_runs import gap_frames, recorded, visible

from kinemark.data.array_types import Bools, Floats
from kinemark.geometry import project_all, triangulate
from kinemark.numerics.runs import true_runs
from kinemark.signal.filters import moving_average

WINDOWS = (3, 5, 7, 9, 15)
"""Samples of the moving average."""
SENSOR_SD = 2.54
"""Noise at the end of the range, 0.1 inch, mm."""
BEND = 25.0
"""By which the field bends a line of 1.2 m, mm: a magnetic field among metal."""
COLOURS = ("#0072B2", "#D55E00", "#009E73")
VIEW = np.array([[0.80, 0.60, 0.0], [0.30, -0.40, 0.866]])
"""Rows: what is drawn to the right and upwards of (x, y, z)."""
MARGIN = 20.0  # px


class SensorTrack(NamedTuple):
    """A straight line as a sensor has it: measured, and where the bent field alone would put it, (F, 3) mm."""

    measured: Floats
    bent: Floats


def sensor_track(seed: int = 0, *, seconds: float = 6.0, rate: float = 30.0) -> SensorTrack:
    """A sensor that is moved along a line at an even speed."""
    t = np.linspace(0, 1, round(seconds * rate))
    line = np.array([250.0, -600.0, 100.0]) + np.outer(t, [300.0, 1200.0, 0.0])
    bent = line + np.outer(4 * t * (1 - t), [BEND, 0.0, 0.4 * BEND])
    sd = SENSOR_SD * (np.linalg.norm(line, axis=1) / np.linalg.norm(line, axis=1).max()) ** 2
    return SensorTrack(bent + sd[:, None] * np.random.default_rng(seed).normal(size=line.shape), bent)


def noise(path: Floats) -> float:
    """What differs from sample to sample, mm RMS of a coordinate: by third differences, √20 times white noise."""
    return float(np.sqrt((np.diff(path, 3, axis=0) ** 2).mean() / 20))


def curvature(path: Floats) -> float:
    """Greatest distance of a path from its own straight line, mm."""
    centre = path.mean(0)
    way = np.linalg.svd(path - centre)[2][0]
    off = path - centre - np.outer((path - centre) @ way, way)
    return float(np.linalg.norm(off, axis=1).max())


def averages(seed: int = 0) -> list[tuple[int, float, float, float]]:
    """For windows of so many samples: noise, distance from where the field puts the sensor (RMS), and curvature, mm."""
    track = sensor_track(seed)
    found = []
    for window in (1, *WINDOWS):
        path = moving_average(track.measured, window)
        off = float(np.sqrt(((path - track.bent) ** 2).sum(1).mean()))
        found.append((window, noise(path), off, curvature(path)))
    return found


def noisy_tracks(number: int, percent: int, seed: int = 0) -> Floats:
    """(3, F, 3) mm of a run reconstructed from two images with this noise, read as of a camera of focal length 1."""
    rig, xyz = cameras(), recorded(number, 0.0).xyz
    uv = np.moveaxis(project_all(rig, xyz), 0, 2)
    share = np.random.default_rng(seed).uniform(-1, 1, uv.shape)
    noisy = uv + share * np.array(RMS[percent]) * FOCAL
    return triangulate(noisy.reshape(-1, 2, 2), rig.P).reshape(xyz.shape)


def in_view(path: Floats) -> Floats:
    """(…, 2) of points (…, 3) mm: to the right, and upwards."""
    return path @ VIEW.T


def drawing(words: str, paths: list[Floats], names: tuple[str, ...]) -> str:
    """Plane paths (F, 2), y upwards, at one scale."""
    every = np.concatenate(paths)
    low, high = every.min(0), every.max(0)
    scale = min((WIDTH - 2 * MARGIN) / (high[0] - low[0]), (HEIGHT - 2 * MARGIN) / (high[1] - low[1]))
    lines = [
        polyline(MARGIN + (path[:, 0] - low[0]) * scale, HEIGHT - MARGIN - (path[:, 1] - low[1]) * scale, colour, 1.2)
        for path, colour in zip(paths, COLOURS, strict=False)
    ]
    legend = ", ".join(f'<span style="color:{c}">{n}</span>' for n, c in zip(names, COLOURS, strict=False))
    return f"<figure><figcaption>{words}. {legend}</figcaption>{svg(lines)}</figure>"


def svg(parts: list[str]) -> str:
    """A picture of these."""
    size = f'width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{"".join(parts)}</svg>'


def sketch(seen: Bools) -> str:
    """Figure 4.13: a line a marker, with its gaps, (3, F)."""
    x = MARGIN + (WIDTH - 2 * MARGIN) * np.arange(seen.shape[1]) / seen.shape[1]
    parts = [
        polyline(x[[a, b - 1]], np.full(2, HEIGHT * (k + 1) / 4), COLOURS[k], 3.0)
        for k, own in enumerate(seen)
        for a, b in true_runs(own)
    ]
    words = "Like figure 4.13: three tracks with one gap each (test 3)"
    return f"<figure><figcaption>{words}</figcaption>{svg(parts)}</figure>"


def page() -> str:
    """All figures as HTML."""
    track = sensor_track()
    parts = [
        drawing("Like figure 4.4: a sensor on a line, as measured", [track.measured[:, [1, 0]]], ("x against y",)),
        drawing(
            "Like figure 4.5: after a moving average of nine", [moving_average(track.measured, 9)[:, [1, 0]]],
            ("x against y",),
        ),
    ]  # fmt: skip
    rig = cameras()
    for number, letters in ((1, "ABC"), (2, "ABC"), (3, "DBC")):
        xyz = recorded(number, 0.0).xyz
        parts.append(drawing(f"Like figure 4.{number + 7}: run {number} in space", [*in_view(xyz)], tuple(letters)))
        for camera, uv in zip(rig, np.asarray(project_all(rig, xyz)), strict=True):
            own = [path * [1, -1] for path in uv]
            parts.append(drawing(f"Like figure 4.11: run {number} in {camera.name}", own, tuple(letters)))
    for percent in (5, 10):
        words = f"Like figure 4.12: run 1 reconstructed, {percent} % noise"
        parts.append(drawing(words, [*in_view(noisy_tracks(1, percent))], tuple("ABC")))
    parts.append(sketch(visible(gap_frames(3), 1)))
    title = "<title>Sensors, motions, images, gaps, after Swamidas (1997)</title>"
    head = f'<!doctype html><html lang="en"><meta charset="utf-8">{title}'
    style = (
        "<style>body{font:14px sans-serif;margin:24px;max-width:1420px}figure{display:inline-block;margin:8px}</style>"
    )
    return "\n".join([head + style, f"<h1>{title[7:-8]}</h1>", *parts, "</html>", ""])


def main() -> None:
    print("Moving average of a sensor's track along a straight line (figures 4.4 and 4.5); seed 0, mm")
    print("  samples   noise from sample to sample   off the bent line, RMS   greatest distance from a straight line")
    for window, rough, off, bent in averages():
        print(f"  {window:7d}   {rough:27.2f}   {off:22.2f}   {bent:39.1f}")
    print("Noisy reconstruction (figure 4.12), run 1: RMS distance from the truth, mm, markers A, B, C")
    for percent in (5, 10):
        wrong = noisy_tracks(1, percent) - recorded(1, 0.0).xyz
        print(f"  {percent:2d} % noise:" + "".join(f"{v:8.1f}" for v in np.sqrt((wrong**2).sum(-1).mean(1))))
    if "--figures" in sys.argv:
        file = Path(sys.argv[sys.argv.index("--figures") + 1])
        file.write_text(page(), encoding="utf-8")
        print(f"Figures like 4.4, 4.5 and 4.8 to 4.13: {file}")


if __name__ == "__main__":
    main()
