"""The four sample tests of marker detection in KISS, section 3, by the paper's two methods and by Kinemark's own.

1. The manually created image: 12 markers, drawn so that each step of the advanced analysis has something to do. The
   paper finds 10 markers without advanced analysis, 8 with sub-marker detection alone, 12 with all tests but the size,
   and calls four of these invalid with it.
2. The linearisation grid: 300 points, barrel distortion, out of focus. Exactly 300.
3. The calibration frame with the strobe of the opposite camera: 24 valid, the strobe invalid.
4. A gait trial of 148 fields with 15 markers: all markers in all fields, in less than 2 s on a Pentium II. (At 50 Hz
   they last 2.96 s, where the paper says 2 s.)

The images of 2 to 4 are rendered, so that the truth is known; their parameters are what `propose` makes of them. Times
are those of detection from images in memory.

The paper's "computational time reduced to almost half of the former method" is measured with both methods in turns on
the same fields, from images in memory to detections, and from white pixels on, which is where the paper's software
began.

Run: python studies/kiss_detection.py [--figure FILE.svg] [--pictures FOLDER]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from detection_pictures import enclosing, panels, stacked_svg, write_picture
from numpy.typing import NDArray

from kinemark.data import Camera, Rig, Validity
from kinemark.data.array_types import Floats
from kinemark.detect import Blobs, Centroids, KissNearest, KissScanning, detect_frames
from kinemark.detect.kiss.white import runs_of
from kinemark.detect.proposal import DetectionProposal, propose
from kinemark.geometry import project
from kinemark.report.field_pictures import FieldPicture
from kinemark.signal import assign
from kinemark.synth import (
    Optics,
    control_frame,
    dot_grid,
    film,
    look_at,
    place_camera,
    render,
    ring,
    rods_subject,
    truth,
    walking,
)

Images = NDArray[np.uint8]
Method = KissScanning | KissNearest | Centroids

FIELD = np.array([1.0, 2.0])  # px of a frame that a px of a field counts
FIELDS = 148
COVERED = 0.4
MARGIN = 12  # px of a field about the markers of Fig. 12; chosen
BARE = KissScanning(sub_markers=False, overlaps=False, long_wide=False, check_sizes=False)
STEPS: dict[str, tuple[KissScanning, int]] = {
    "without advanced analysis": (BARE, 10),
    "with sub-marker detection": (replace(BARE, sub_markers=True), 8),
    "with all tests but the size": (KissScanning(check_sizes=False), 12),
}


class Row(NamedTuple):
    """A line of the table: what was counted, the paper's number, and ours by each method."""

    what: str
    paper: str
    ours: tuple[str, ...]


# --- 1. the manually created image ----------------------------------------------------------------


def manual_image() -> Images:
    """(240, 320) twelve markers in eight white places, and a little noise; sharp discs of grey level 200 on 10.

    What preliminary grouping makes of each is said beside it; all parameters are the defaults.
    """
    image = np.full((240, 320), 10, np.uint8)
    discs = [
        # Overlapped, upper-left. The lower marker's first two lines, and the upper one's last two, lie beside the other
        # marker with mid-points of their own, 10 px away: a cluster of three groups, two of them of two rows.
        (50, 60, 12), (60, 67, 12),
        # Overlapped, upper-right, near enough in x for their mid-points to follow each other: one group.
        (118, 58, 12), (110, 66, 12),
        # A long one, 11 × 19 px: two markers one below the other; 4 px from the next.
        (60, 118, 11), (60, 126, 11),
        # A wide one, 20 × 13 px: two markers side by side.
        (76, 122, 12), (83, 122, 12),
        # Two infrared strobes of facing cameras, 2290 and 2828 px²: too large.
        (220, 70, 54), (232, 160, 60),
    ]  # fmt: skip
    y, x = np.mgrid[:240, :320]
    for u, v, diameter in discs:
        image[(x - u) ** 2 + (y - v) ** 2 <= diameter**2 / 4] = 200
    for u, v in ((130, 180), (150, 190)):  # specks of three pixels, too small: the corner of two rows and two columns
        image[v : v + 2, u : u + 2] = [[200, 200], [200, 10]]
    image[30, 30] = image[200, 40:44] = image[210:214, 100] = 200  # noise: a lonely pixel, one line, one column
    return image


def manual(folder: Path | None) -> Iterator[Row]:
    """The steps of the analysis one after another."""
    image = manual_image()[None]
    for what, (step, paper) in STEPS.items():
        yield Row(f"manual image, {what}", f"{paper}", (f"{len(detect_frames(image, method=step).uv)}", "", ""))
    methods: tuple[Method, ...] = (KissScanning(), KissNearest(), Centroids())
    found = {m: detect_frames(image, method=m) for m in methods}
    yield Row("  with size limits: markers", "12", tuple(f"{len(b.uv)}" for b in found.values()))
    yield Row("  of these invalid", "4", tuple(f"{(b.validity > 0).sum()}" for b in found.values()))
    if folder:
        for method, blobs in found.items():
            write_picture(folder / f"manual_{type(method).__name__}.png", image[0], blobs)


def figure() -> str:
    """An SVG of the manual image and what each step finds in it, like the paper's Fig. 9."""
    image = manual_image()[None]
    results: list[tuple[str, Blobs | None]] = [("the image", None)]
    for what, (step, _) in STEPS.items():
        blobs = detect_frames(image, method=step)
        results.append((f"{what}: {len(blobs.uv)}", blobs))
    blobs = detect_frames(image, method=KissScanning())
    results.append((f"with size limits: {len(blobs.uv)}, of these {(blobs.validity > 0).sum()} invalid", blobs))
    blobs = detect_frames(image, method=KissNearest())
    results.append((f"the former method: {len(blobs.uv)}", blobs))
    return panels(image[0] > KissScanning().threshold, results)


# --- 2. and 3. grid and calibration frame ---------------------------------------------------------


def grid_image() -> tuple[Images, Floats]:
    """(1, 582, 752) px a grid of 15 × 20 points, near, barrel distorted, out of focus; where they are (300, 2) px."""
    camera = place_camera(
        "near", (0, -700, 0), (0, 0, 0), focal_px=560, size=(752, 582), distortion=(-0.22, 0.05, 0, 0, 0)
    )
    grid, blurred = dot_grid(pitch_mm=43.0, radius_mm=6.0), Optics(blur_px=2.2, read_noise=3.0, strobe_radius_mm=0.0)
    image = render(camera, grid.xyz[:, 0], grid.radius_mm, optics=blurred, rng=np.random.default_rng(1))
    return image[None], project(camera, grid.xyz[:, 0])


def frame_image() -> tuple[Images, Floats]:
    """(1, 582, 752) px the control frame and the strobe of the opposite camera; the 24 markers (24, 2) px."""
    rig, rods = ring(4, size=(752, 582), focal_px=770.0), rods_subject(control_frame())
    optics, strobe = Optics(read_noise=3.0), rig.centres[2:3]
    image = render(rig[0], rods.xyz[:, 0], rods.radius_mm, strobes=strobe, optics=optics, rng=np.random.default_rng(2))
    return image[None], project(rig[0], rods.xyz[:, 0])


def still_image(what: str, image: Images, points: Floats, folder: Path | None, paper: tuple[str, str]) -> Iterator[Row]:
    """How many of the points each method finds, and how many detections are not valid or no point."""
    methods = methods_of(propose(image), aspect=1.0)
    blobs = [detect_frames(image, method=m) for m in methods]
    valid = [b.uv[b.validity == Validity.VALID] for b in blobs]
    hits = [len(assign(np.linalg.norm(points[:, None] - uv, axis=-1), np.full(len(points), 2.0))[0]) for uv in valid]
    found = tuple(f"{len(uv)}" + ("" if n == len(uv) else f" ({n} true)") for uv, n in zip(valid, hits, strict=True))
    yield Row(f"{what}, valid", paper[0], found)
    yield Row(f"{what}, invalid", paper[1], tuple(f"{(b.validity > 0).sum()}" for b in blobs))
    if folder:
        write_picture(folder / f"{what.replace(' ', '_')}.png", image[0], blobs[0])


# --- 4. a gait trial ------------------------------------------------------------------------------


class Truth(NamedTuple):
    """Of M markers in F fields: uv (M, F, 2) px of a field; diameter (M, F) px of a frame.

    whole, partly (M, F): in sight wholly, or by half at least, and apart from all others; overlapping (M, F): wholly in
    sight of the limbs, but touching another's image; covered (M, F): such with centres nearer than `COVERED` diameters,
    which the paper's methods cannot tell from one marker; any (M, F): a bit in sight.
    """

    uv: Floats
    diameter: Floats
    whole: NDArray[np.bool_]
    partly: NDArray[np.bool_]
    overlapping: NDArray[np.bool_]
    covered: NDArray[np.bool_]
    any: NDArray[np.bool_]


def gait(every: int) -> tuple[Images, Truth]:
    """(F, 291, 752) fields of a walk, every n-th of 148, and the truth of them."""
    camera = look_at("side", (1500.0, -3000.0, 1100.0), (1200.0, 700.0, 850.0), focal_px=1050.0, size=(752, 582))
    subject = walking(duration_s=FIELDS / 50, rate=50.0, speed_mm_s=700.0, seed=3)
    fields = np.arange(0, FIELDS, every)
    capsules = subject.capsules
    some = replace(
        subject,
        xyz=subject.xyz[:, fields],
        capsules=replace(capsules, a=capsules.a[:, fields], b=capsules.b[:, fields]),
    )
    frames = film(camera, some, optics=Optics(read_noise=3.0), seed=4)
    images = np.stack([frame[f % 2 :: 2] for f, frame in zip(fields, frames, strict=True)])
    return images, truth_of(camera, some, fields % 2)


def truth_of(camera: Camera, subject: object, parity: NDArray[np.int64]) -> Truth:
    """Which markers the fields show, and how."""
    sight = truth(Rig((camera,), "side"), subject)  # type: ignore[arg-type]
    uv, visible, diameter = sight.uv[0], sight.visible[0], 2 * np.sqrt(sight.area[0] / np.pi)
    between = np.linalg.norm(uv[:, None] - uv[None], axis=-1)
    between[np.arange(len(uv)), np.arange(len(uv))] = np.inf
    between = np.where(visible[None] > 0, between, np.inf)
    covered = between.min(1) < COVERED * diameter
    nearest = (between - (diameter[:, None] + diameter[None]) / 2).min(1)  # px of dark between images
    inside = ((uv > diameter[..., None]) & (uv < camera.size - diameter[..., None])).all(-1)
    field = (uv - np.stack([np.zeros(len(parity)), parity], -1)) / FIELD
    clear, half = inside & (visible > 0.99), inside & (visible >= 0.5) & (visible <= 0.99)
    free = nearest > 2.5  # below 2 px a field may have no dark line between two images
    close = clear & ~free
    return Truth(field, diameter, clear & free, half & free, close & ~covered, close & covered, visible > 0)


def hits_of(blobs: Blobs, true: Truth) -> tuple[NDArray[np.bool_], int]:
    """(M, F) whether a valid detection is within half a diameter of a marker, one to one; detections of no marker."""
    ends = np.cumsum(blobs.counts)
    hit, false = np.zeros(true.any.shape, np.bool_), 0
    for f, (stop, count) in enumerate(zip(ends, blobs.counts, strict=True)):
        uv = blobs.uv[stop - count : stop][blobs.validity[stop - count : stop] == Validity.VALID]
        cost = np.linalg.norm((true.uv[:, f, None] - uv) * FIELD, axis=-1)
        there = np.flatnonzero(true.any[:, f])
        markers, rows = assign(cost[there], true.diameter[there, f] / 2)
        hit[there[markers], f] = True
        false += len(uv) - len(rows)
    return hit, false


def gait_trial(every: int, folder: Path | None) -> Iterator[Row]:
    """Markers found in the fields, and the time."""
    images, true = gait(every)
    methods = methods_of(propose(images), aspect=0.5)
    results, seconds = in_turns(images, methods[:2])
    own, own_seconds = in_turns(images, methods[2:], turns=1)
    results, seconds = results + own, seconds + own_seconds
    hits = [hits_of(blobs, true) for blobs in results]
    fields = f"gait, {len(images)} fields"
    for what, paper, of in (
        ("whole", "all", true.whole),
        ("close or overlapping", "", true.overlapping),
        ("half hidden", "", true.partly),
        ("one upon the other", "", true.covered),
    ):
        yield Row(f"{fields}: {what} markers of {of.sum()}", paper, tuple(f"{(hit & of).sum()}" for hit, _ in hits))
    yield Row("  detections of no marker", "0", tuple(f"{false}" for _, false in hits))
    yield Row("  seconds", "2", tuple(f"{s:.3f}" for s in seconds))
    yield Row("  time by the time of the former method", "0.5", (f"{seconds[0] / seconds[1]:.2f}", "1.00", ""))
    white = seconds_of_white_pixels(images, KissScanning().threshold)
    share = (seconds[0] - white) / (seconds[1] - white)
    yield Row("  the same from white pixels on", "0.5", (f"{share:.2f}", "1.00", ""))
    five = five_fields(true)
    of_five = [(hit & (true.whole | true.overlapping))[:, five] for hit, _ in hits]
    wanted = (true.whole | true.overlapping)[:, five].sum()
    yield Row(f"  fig. 12, five fields: markers of {wanted}", "all", tuple(f"{hit.sum()}" for hit in of_five))
    if folder:
        (folder / "gait.svg").write_text(figure_12(images[five], five, methods[0]), encoding="utf-8")


def five_fields(true: Truth) -> list[int]:
    """Indices of five fields, spread over the trial; the middle one is that with most markers that touch another."""
    n = true.any.shape[1]
    spread = np.linspace(0, n - 1, 5).round().astype(int)
    middle = np.arange(spread[1] + 1, spread[3])
    spread[2] = middle[true.overlapping[:, middle].sum(0).argmax()]
    return [int(f) for f in spread]


def figure_12(fields: Images, numbers: Sequence[int], method: Method) -> str:
    """An SVG of five fields of one camera, like the paper's Fig. 12: the region that encloses all markers."""
    blobs = [detect_frames(image[None], method=method) for image in fields]
    region = enclosing(blobs, (fields.shape[2], fields.shape[1]), MARGIN)
    pictures = [
        FieldPicture("side", f, image, found, tall=2, region=region)
        for f, image, found in zip(numbers, fields, blobs, strict=True)
    ]
    return stacked_svg(pictures, [f"field {one.frame}: {one.valid} markers, {one.invalid} invalid" for one in pictures])


# --- helpers --------------------------------------------------------------------------------------


def methods_of(proposal: DetectionProposal, *, aspect: float) -> tuple[Method, ...]:
    """The three methods with the proposed parameters; round markers have this ratio of height to width."""
    return proposal.scanning, proposal.nearest, replace(proposal.centroids, aspect=aspect)


def in_turns(images: Images, methods: Sequence[Method], turns: int = 9) -> tuple[list[Blobs], list[float]]:
    """What each method finds, and its shortest time of so many turns, s; in turns, as the machine has other work."""
    seconds = np.empty((turns, len(methods)))
    for turn in range(turns):
        for k, method in enumerate(methods):
            began = time.perf_counter()
            detect_frames(images, method=method)
            seconds[turn, k] = time.perf_counter() - began
    return [detect_frames(images, method=method) for method in methods], seconds.min(0).tolist()


def seconds_of_white_pixels(images: Images, threshold: float) -> float:
    """The shortest time of nine for finding the runs of white pixels, which the paper's hardware did, s."""
    seconds = []
    for _ in range(9):
        began = time.perf_counter()
        runs_of(images, threshold)
        seconds.append(time.perf_counter() - began)
    return min(seconds)


# --- the table ------------------------------------------------------------------------------------


def rows(folder: Path | None, every: int) -> Iterator[Row]:
    """All lines of the four tests."""
    yield from manual(folder)
    yield from still_image("linearisation grid", *grid_image(), folder, ("300", "0"))
    yield from still_image("calibration frame", *frame_image(), folder, ("24", "1"))
    yield from gait_trial(every, folder)


def show(lines: Iterator[Row], first: str = "quoted") -> None:
    print(f"{'':<56}{first:>7}{'KissScanning':>16}{'KissNearest':>16}{'Centroids':>16}")
    for row in lines:
        print(f"{row.what:<56}{row.paper:>7}" + "".join(f"{number:>16}" for number in row.ours), flush=True)


def main(arguments: argparse.Namespace) -> None:
    """Print the table, and write what is asked for."""
    if arguments.figure:
        arguments.figure.write_text(figure(), encoding="utf-8")
    if arguments.pictures:
        arguments.pictures.mkdir(parents=True, exist_ok=True)
    show(rows(arguments.pictures, arguments.every))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="The sample tests of KISS, section 3.")
    parser.add_argument("--figure", type=Path, help="an SVG of the manually created image, like the paper's Fig. 9")
    parser.add_argument("--pictures", type=Path, help="folder for pictures of all four tests; gait.svg is like Fig. 12")
    parser.add_argument("--every", type=int, default=1, help="of the gait trial, every so many fields only")
    main(parser.parse_args())
