"""Markers on each other or half hidden, single markers of many forms, and what telling them apart costs.

Outlines are drawn with eight subpixels a side (an edge counts by the share of the subpixel that it covers), blurred,
and given noise of 3 grey levels, 190 above the ground. Printed are: how many groups are found with every centre within
0.1 px, the error, and the mean of squared errors over what the stated covariance says; how many single markers, sharp,
blurred, seen aslant, moving while the shutter was open, or brighter on one side, are split or taken for hidden ones;
and the time a frame.

Run: python studies/overlapping_markers.py [number of cases in a row, 300] [--figure FILE.svg]
"""

from __future__ import annotations

import argparse
import base64
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from detection_pictures import png
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from kinemark.data.array_types import Floats
from kinemark.detect import Blobs, Centroids, detect_frames

Images = NDArray[np.uint8]

SIDE, FINE, MIDDLE = 45, 8, 22
AT = (np.arange(SIDE * FINE) + 0.5) / FINE - 0.5 - MIDDLE
NOISE = 3.0
STEPS = 13


def light(
    centres: Floats,
    diameter: float,
    *,
    blur: float = 0.5,
    squeeze: float = 1.0,
    motion: Floats | None = None,
    limb: tuple[float, float, float] | None = None,
) -> Floats:
    """(SIDE, SIDE) light of discs about centres (n, 2) px from the middle.

    Squeezed in height; moving by `motion` px; hidden where x u + y v > h for a limb (x, y, h).
    """
    total = np.zeros((SIDE, SIDE))
    steps = np.linspace(-0.5, 0.5, STEPS) if motion is not None else np.zeros(1)
    for t in steps:
        by = t * (motion if motion is not None else np.zeros(2))
        inside = [diameter / 2 - np.hypot(AT - u, (AT[:, None] - v) / squeeze) for u, v in centres + by]
        s = np.max(inside, axis=0)
        if limb is not None:
            s = np.minimum(s, limb[2] - limb[0] * AT - limb[1] * AT[:, None])
        fine = gaussian_filter(np.clip(s * FINE + 0.5, 0, 1), blur * FINE)
        total += fine.reshape(SIDE, FINE, SIDE, FINE).mean((1, 3))
    return np.asarray(total / len(steps))


def photo(shares: Sequence[Floats], rng: np.random.Generator, peak: float = 190.0) -> Images:
    """Images of light (n, SIDE, SIDE)."""
    grey = 12 + peak * np.array(shares)
    return np.clip(np.rint(grey + NOISE * rng.normal(size=grey.shape)), 0, 255).astype(np.uint8)


def pair(apart: float, rng: np.random.Generator) -> Floats:
    """(2, 2) px; two centres so far apart, in any direction and at any place in the pixel."""
    turn = rng.uniform(0, 2 * np.pi)
    half = apart / 2 * np.array([np.cos(turn), np.sin(turn)])
    return np.stack([half, -half]) + rng.uniform(-0.5, 0.5, 2)


def triple(apart: float, rng: np.random.Generator) -> Floats:
    """(3, 2) px; the second so far from the first, the third from the second, at any angle that is 60° or more."""
    turn, bend = rng.uniform(0, 2 * np.pi), rng.uniform(-2, 2) * np.pi / 3
    ends = apart * np.array([[-np.cos(turn), -np.sin(turn)], [0, 0], [np.cos(turn + bend), np.sin(turn + bend)]])
    return np.asarray(ends - ends.mean(0) + rng.uniform(-0.5, 0.5, 2))


def hidden(share: float, d: float, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Light and centre of a disc of which this share of the diameter is behind a straight limb."""
    turn, centre = rng.uniform(0, 2 * np.pi), rng.uniform(-0.5, 0.5, (1, 2))
    x, y = np.cos(turn), np.sin(turn)
    return light(centre, d, limb=(x, y, (0.5 - share) * d + centre[0] @ [x, y])), centre


def print_found(what: str, groups: list[tuple[Floats, Floats]], rng: np.random.Generator) -> None:
    """A line on groups, each its light and the places (n, 2) of its discs."""
    blobs = detect_frames(photo([share for share, _ in groups], rng), method=Centroids(noise_sd=NOISE))
    ends = np.cumsum(blobs.counts)[:-1]
    good, offs, squares = 0, [], []
    for uv, cov, (_, places) in zip(np.split(blobs.uv, ends), np.split(blobs.cov, ends), groups, strict=True):
        nearest = np.linalg.norm(uv[:, None] - MIDDLE - places, axis=-1).argmin(1)
        if len(uv) == len(places) == len(set(nearest)):
            off = uv - MIDDLE - places[nearest]
            good += bool(np.linalg.norm(off, axis=1).max() < 0.1)
            offs.append(off)
            squares.append(np.einsum("ni,nij,nj->n", off, np.linalg.inv(cov), off) / 2)
    rms = np.sqrt(np.mean(np.concatenate(offs) ** 2))
    print(f"{what:38s} {100 * good / len(groups):10.1f} % {rms:15.4f} {np.concatenate(squares).mean():16.2f}")


def print_together(cases: int, rng: np.random.Generator) -> None:
    print(f"{str(cases) + ' each':38s}  within 0.1 px   RMS error px   error²/variance")
    for d in (8.0, 10.0, 12.0, 16.0):
        kinds: list[tuple[str, float, Callable[[float, np.random.Generator], Floats]]]
        kinds = [("two", 0.5, pair), ("two", 0.7, pair), ("two", 0.9, pair), ("three", 0.75, triple)]
        for name, apart, make in kinds:
            places = [make(apart * d, rng) for _ in range(cases)]
            groups = [(light(centres, d), centres) for centres in places]
            print_found(f"{name} of {d:g} px, {apart:g} diameters apart", groups, rng)
        for share in (0.1, 0.2, 0.3, 0.5):
            print_found(f"one of {d:g} px, {share:g} hidden", [hidden(share, d, rng) for _ in range(cases)], rng)


def single(kind: str, rng: np.random.Generator) -> Floats:
    """Light of one marker of 5 to 16 px."""
    d, centre, turn = rng.uniform(5, 16), rng.uniform(-0.5, 0.5, (1, 2)), rng.uniform(0, 2 * np.pi)
    along = np.array([np.cos(turn), np.sin(turn)])
    if kind == "in motion":
        return light(centre, d, motion=rng.uniform(0.2, 1.0) * d * along)
    if kind == "aslant":
        drawn = light(centre, d, squeeze=rng.uniform(0.5, 0.95))
        return drawn if rng.random() < 0.5 else drawn.T
    if kind == "brighter on one side":
        rise = (along[0] * (np.arange(SIDE) - MIDDLE) + along[1] * (np.arange(SIDE)[:, None] - MIDDLE)) / d
        return np.asarray(light(centre, d, squeeze=rng.uniform(0.7, 1.0)) * np.clip(1 + 0.6 * rise, 0.3, 1.3))
    return light(centre, d, blur=1.0 if kind == "blurred" else 0.4)


def print_single(cases: int, rng: np.random.Generator) -> None:
    print(f"\n{'single markers of 5 to 16 px':38s}      split   taken for hidden ones")
    plain = Centroids(noise_sd=NOISE, max_discs=1, correct_occlusion=False)
    for kind in ("sharp", "blurred", "aslant", "brighter on one side", "in motion"):
        number = cases if kind == "in motion" else 4 * cases
        images = photo([single(kind, rng) for _ in range(number)], rng)
        before, after = detect_frames(images, method=plain), detect_frames(images, method=Centroids(noise_sd=NOISE))
        split = after.counts != before.counts
        moved = after.uv[~np.repeat(split, after.counts)] != before.uv[~np.repeat(split, before.counts)]
        print(f"{kind:38s} {split.sum():10d} {moved.any(1).sum():12d}   of {number}")


def print_cost(rng: np.random.Generator) -> None:
    print(f"\n{'ms a frame of 40 groups of 8 px':38s} told apart   not told apart")
    groups: dict[str, Callable[[], Floats]] = {
        "single discs": lambda: np.zeros((1, 2)),
        "pairs, 0.7 diameters apart": lambda: pair(5.6, rng),
        "triples, 0.75 diameters apart": lambda: triple(6.0, rng),
    }
    for what, make in groups.items():
        cells = photo([light(make(), 8.0) for _ in range(40)], rng)
        frame = cells.reshape(5, 8, SIDE, SIDE).transpose(0, 2, 1, 3).reshape(5 * SIDE, 8 * SIDE)
        images = np.ascontiguousarray(frame[None].repeat(4, 0))
        times = [least_time(images, m) for m in (Centroids(), Centroids(max_discs=1, correct_occlusion=False))]
        print(f"{what:38s} {times[0]:10.2f} {times[1]:14.2f}")


def least_time(images: Images, method: Centroids) -> float:
    """Of several runs, ms a frame."""
    best = np.inf
    for _ in range(10):
        begin = time.perf_counter()
        detect_frames(images, method=method)
        best = min(best, time.perf_counter() - begin)
    return 1000 * best / len(images)


# ---- The picture ----


def draw(path: Path) -> None:
    """Six groups as pixels, and what is found in them."""
    rng, zoom, d = np.random.default_rng(3), 4, 11.0
    ring = 0.75 * d / np.sqrt(2) * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    panels = [
        ("two, 0.7 diameters apart", photo([light(pair(0.7 * d, rng), d)], rng)),
        ("two, 0.6, saturated", photo([light(pair(0.6 * d, rng), d)], rng, peak=500)),
        ("three", photo([light(triple(0.8 * d, rng), d)], rng)),
        ("four: one centroid, unsure", photo([light(ring, d)], rng)),
        ("a third hidden", photo([hidden(0.33, d, rng)[0]], rng)),
        ("in motion: one marker", photo([light(np.zeros((1, 2)), d, motion=np.array([7.0, 4.0]))], rng)),
    ]
    lines, side = [], SIDE * zoom
    for k, (caption, image) in enumerate(panels):
        blobs = detect_frames(image, method=Centroids(noise_sd=NOISE))
        lines.append(f'<g transform="translate({k % 3 * (side + 10)} {k // 3 * (side + 24) + 16})">')
        lines.append(f'<text y="-4">{caption}</text>{picture(image[0], zoom)}{shapes(blobs, zoom)}</g>')
    width, height = 3 * (side + 10) - 10, 2 * (side + 24)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}"'
    head += ' font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="#fff"/>'
    path.write_text("\n".join([head, *lines, "</svg>", ""]), encoding="utf-8")


def picture(grey: Images, zoom: int) -> str:
    data = base64.b64encode(png(grey[..., None].repeat(3, -1))).decode()
    size = f'width="{grey.shape[1] * zoom}" height="{grey.shape[0] * zoom}"'
    return f'<image {size} style="image-rendering:pixelated" href="data:image/png;base64,{data}"/>'


def shapes(blobs: Blobs, zoom: int) -> str:
    """Outlines as wide and high as detections, and two standard deviations about centroids; yellow: merged."""
    text = ""
    for k, (u, v) in enumerate((blobs.uv + 0.5) * zoom):
        colour = "#e09a00" if blobs.merged[k] else "#16b455"
        sd = 2 * zoom * np.sqrt(np.diagonal(blobs.cov[k]))
        for rx, ry in ((blobs.width[k] / 2 * zoom, blobs.height[k] / 2 * zoom), np.maximum(sd, 2.0)):
            text += f'<ellipse cx="{u:.1f}" cy="{v:.1f}" rx="{rx:.1f}" ry="{ry:.1f}" fill="none" stroke="{colour}" '
            text += 'stroke-width="1.6"/>'
    return text


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="?", type=int, default=300)
    parser.add_argument("--figure", type=Path, help="an SVG of what is found in six groups")
    wanted = parser.parse_args()
    rng = np.random.default_rng(0)
    print_together(wanted.cases, rng)
    print_single(wanted.cases, rng)
    print_cost(rng)
    if wanted.figure:
        draw(wanted.figure)


if __name__ == "__main__":
    main()
