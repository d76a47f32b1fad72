"""The aspect ratio of a camera's pixels from a bar that is turned before it (UM²AS 4.1), in the virtual laboratory.

The thesis's jig: 14 flat markers of 38 mm on a bar, 70 mm apart, the two in the middle 100 mm, turned in steps of 36°
from 0° to 360°. V must be multiplied by 0.8407 (the camera: 485 / 570 = 0.8509). The distance of the outer pair then
changes by 71.77 px if the bar is 416 px wide, so the camera stands that far away here; the image is 640 × 512 px. After
the correction the thesis has about 0.5 px left.

1. The pictures, rendered; markers detected; distances of the pairs before and after, as seen and with coordinates of
   whole pixels, as a digitising board gives them; the factor by all distances together, as the thesis has it (mean of
   the roots), and as its eq. 4.4 is printed (without the root).
2. How true the stated standard deviation is: 400 simulated jigs with coordinates of whole pixels.
3. What a bar does that does not face the camera, and what a lens does.

Run: python studies/aspect_ratio.py [--figure FILE.svg]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from kinemark.calibrate import AspectRatio, aspect_ratio
from kinemark.data import Camera
from kinemark.data.array_types import Floats
from kinemark.detect import Centroids, detect_frames
from kinemark.geometry import project
from kinemark.synth import look_at, render

FACTOR = 0.8407
SIZE = (640, 512)
AWAY = 3000.0
FOCAL = 415.6 / 940 * AWAY
RADIUS = 19.0
ANGLES = np.arange(0.0, 361.0, 36.0)
HALF = 50.0 + 70.0 * np.arange(7)
ALONG = np.concatenate([-HALF[::-1], HALF])
"""The markers' places on the bar, mm."""
BOLT = np.array([2.3, 1.7])
"""How far the bar's middle is from the bolt it turns on, mm: else half a turn would show the same picture again."""


def camera(*, turned: float = 0.0, aside: float = 0.0, lens: float = 0.0) -> Camera:
    """Before the bar, `turned` about the vertical by so many degrees, or so many mm `aside`."""
    a, middle = np.radians(turned), np.array([aside, 0.0, aside])
    place = middle + AWAY * np.array([np.sin(a), -np.cos(a), 0.0])
    return look_at("cam", place, middle, focal_px=(FOCAL, FOCAL / FACTOR), size=SIZE, distortion=(lens, 0, 0, 0, 0))


def bars(start: float = 0.0) -> Floats:
    """(11, 14, 3) mm: the markers at each step, in a plane that faces −Y."""
    a = np.radians(ANGLES + start)[:, None]
    x, z = np.cos(a) * (ALONG + BOLT[0]) - np.sin(a) * BOLT[1], np.sin(a) * (ALONG + BOLT[0]) + np.cos(a) * BOLT[1]
    return np.stack([x, np.zeros_like(x), z], -1)


def in_order(uv: Floats) -> Floats:
    """Markers (14, 2) along the bar; from which end does not matter."""
    axis = np.linalg.svd(uv - uv.mean(0), full_matrices=False)[2][0]
    return uv[np.argsort(uv @ axis)]


def pictures() -> Floats:
    """(11, 14, 2) px: the markers as detected."""
    rng, found = np.random.default_rng(1), []
    for xyz in bars():
        blobs = detect_frames(render(camera(), xyz, RADIUS, rng=rng)[None], method=Centroids())
        found.append(in_order(blobs.uv[blobs.validity == 0]))
    return np.array(found)


def row(what: str, a: AspectRatio) -> None:
    before, after = a.spread
    print(
        f"  {what:34s}{before:8.2f}{after:9.3f}{a.factor:11.5f} ± {a.sd:.5f}{a.cf:9.4f}{spread(a, a.cf):7.2f}"
        f"{a.cf_printed:9.4f}{spread(a, a.cf_printed):8.2f}"
    )


def spread(a: AspectRatio, factor: float) -> float:
    """What is left with another factor, px."""
    v2 = (a.before**2 - a.after**2) / (1 - a.factor**2)
    return float(np.ptp(np.sqrt(a.before**2 + (factor**2 - 1) * v2), axis=0).max())


def jig(figure: Path | None) -> None:
    uv = pictures()
    print(f"the jig of UM²AS 4.1: {uv.shape[1]} markers at {len(uv)} steps, true factor {FACTOR}")
    print("  largest change of a distance, px, before and after (quoted from the thesis: 71.77 and about 0.5)")
    heads = (
        f"{'before':>8s}{'after':>9s}{'factor':>11s}{'':10s}{'eq. 4.5':>9s}{'after':>7s}{'printed':>9s}{'after':>8s}"
    )
    print(f"  {'':34s}{heads}")
    row("centroids", aspect_ratio(uv))
    whole = aspect_ratio(np.round(uv))
    row("whole pixels", whole)
    if figure:
        figure.write_text(svg(whole), encoding="utf-8")


def error_bars() -> None:
    rng, off = np.random.default_rng(2), []
    for _ in range(400):
        place = rng.uniform(-0.5, 0.5, 2)
        a = aspect_ratio(np.round(project(camera(), bars(rng.uniform(0, 36))) + place))
        off.append((a.factor - FACTOR, a.sd))
    error, sd = np.array(off).T
    print("\nhow true the standard deviation is: 400 jigs, whole pixels, the bar at any angle to begin with")
    print(
        f"  mean error {error.mean():.5f}, SD of the factor {error.std():.5f}, as stated {np.sqrt((sd**2).mean()):.5f}"
    )


def limits() -> None:
    print("\nwhat else changes the distances: error of the factor, and what is left of their spread, px")
    for what, cam in (
        ("bar and camera 2° from parallel", camera(turned=2.0)),
        ("bar and camera 5° from parallel", camera(turned=5.0)),
        ("barrel lens, k1 = −0.30", camera(lens=-0.30)),
        ("the same, bar 200 mm off the axis", camera(aside=200.0, lens=-0.30)),
    ):
        a = aspect_ratio(project(cam, bars()))
        print(f"  {what:34s}{a.factor - FACTOR:10.4f}{a.spread[1]:9.3f}")


def svg(a: AspectRatio) -> str:
    """The distances of the pairs by the bar's angle, before and after (the thesis's figures 4.2 and 4.3)."""
    parts, width, height = [], 560, 380
    for k, (d, words) in enumerate(((a.before, "before"), (a.after, "after"))):
        x, top = 70 + k * (width + 40) + ANGLES / 360 * (width - 60), 40
        for pair in d.T:
            y = top + height - pair / 500 * height
            places = " ".join(f"{u:.1f},{v:.1f}" for u, v in zip(x, y, strict=True))
            parts.append(f'<polyline points="{places}" fill="none" stroke="#247" stroke-width="2"/>')
        for px in range(0, 501, 100):
            y0 = top + height - px / 500 * height
            parts.append(f'<line x1="{x[0]}" x2="{x[-1]}" y1="{y0}" y2="{y0}" stroke="#ddd"/>')
            parts.append(f'<text x="{x[0] - 6}" y="{y0 + 5}" text-anchor="end">{px}</text>')
        for degrees in range(0, 361, 90):
            at = x[0] + degrees / 360 * (x[-1] - x[0])
            parts.append(f'<text x="{at}" y="{top + height + 22}" text-anchor="middle">{degrees}°</text>')
        parts.append(f'<text x="{x.mean()}" y="24" text-anchor="middle">distance of each pair {words}, px</text>')
    frame = f'viewBox="0 0 {2 * width + 80} {height + 80}" font-family="sans-serif" font-size="15"'
    ground = '<rect width="100%" height="100%" fill="white"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {frame}>{ground}{"".join(parts)}</svg>\n'


def main(figure: Path | None = None) -> None:
    jig(figure)
    error_bars()
    limits()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="The aspect ratio from a bar that is turned.")
    parser.add_argument("--figure", type=Path)
    main(**vars(parser.parse_args()))
