"""KISS's tests of accuracy under its own conditions, beside Kinemark's (`accuracy.py`).

    python studies/accuracy_kiss.py [rounds, 5]

The conditions of the paper: six cameras with fields of 752 × 291 px, whose lines lie two pixels apart; markers of 25
mm; a control volume of 1.4 × 2.4 × 2 m; the mean of an image's white pixels for its centroid; the lens linearised with
a grid, and cameras calibrated with the DLT from 24 surveyed markers; tests as of its sections 3.3 and 5.1. What the
paper does not tell is assumed: cameras 4.2 m from the middle with 770 px of focal length across and 385 down, which
just see the volume; a barrel of k1 = −0.12; a survey good to 0.5 mm; images blurred by 0.7 px, noise of 2 grey levels.

The noise of centroids is not assumed but measured, in fields of such markers drawn at random places of the volume and
found by KISS's own detection, and by Kinemark's. Errors of white pixels depend on where a marker meets the pixels; they
enter as if they were independent and normal.

The column "quoted" is from Shafiq, Tümer and Güler (2001); all others are computed, root mean squares of rounds.
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np
from accuracy import LENS, NOISE, Noise, Row, calibrations, static, stick, thrown

from kinemark.data import Rig
from kinemark.data.array_types import Floats
from kinemark.data.method import Method
from kinemark.detect import Centroids, KissScanning, detect_frames
from kinemark.geometry import project
from kinemark.synth import Optics, control_frame, render, ring

WAYS = ("DLT", "linearised", "lens terms")
"""Of `accuracy`, without the wand, which the paper did not have."""
RADIUS_MM = 12.5  # of a marker; of the paper, 1
NEAR_PX = 3.0  # farther than this from the truth, a centroid is another's; chosen


class Conditions(NamedTuple):
    """A laboratory: its cameras, and the noise of their centroids."""

    name: str
    rig: Rig
    noise: Noise


def fields() -> Rig:
    """The paper's cameras."""
    return ring(6, size=(752, 291), focal_px=(770.0, 385.0), distortion=LENS)


def measured_noise(rig: Rig, method: Method, images: int, seed: int) -> Noise:
    """RMS errors along u and v, px, of single markers at random places of the volume, as the method finds them."""
    rng, off = np.random.default_rng(seed), []
    for _ in range(images):
        camera = rig[int(rng.integers(len(rig)))]
        xyz = rig.volume[0] + rng.random((1, 3)) * (rig.volume[1] - rig.volume[0])
        true = project(camera, xyz)[0]
        image = render(camera, xyz, RADIUS_MM, optics=Optics(), rng=rng)
        away = detect_frames(image[None], method=method).uv - true
        off += [near for near in away if np.hypot(*near) < NEAR_PX]
    along: Floats = np.sqrt(np.mean(np.square(off), 0))
    return float(along[0]), float(along[1])


def conditions(images: int = 300) -> list[Conditions]:
    """KISS's cameras with its own centroids and with Kinemark's, and Kinemark's cameras."""
    rig = fields()
    white = measured_noise(rig, KissScanning(min_ratio=0.25, max_ratio=1.25), images, 1)
    grey = measured_noise(rig, Centroids(threshold=60.0, aspect=0.5), images, 1)
    return [
        Conditions("KISS", rig, white),
        Conditions("its fields, our centroids", rig, grey),
        Conditions("ours", ring(6, distortion=LENS), NOISE),
    ]


def table(what: Conditions, rounds: int) -> list[Row]:
    """All rows, each the root mean square over rounds of other noise."""
    tables = []
    for seed in range(rounds):
        rng = np.random.default_rng(seed)
        known = control_frame(what.rig.volume).xyz.reshape(-1, 3)
        ways = calibrations(what.rig, known, rng, seed, WAYS, noise=what.noise)
        rows = static(ways, what.rig, known, rng, what.noise) + stick(ways, what.rig, rng, seed, what.noise)
        tables.append(rows + thrown(ways, what.rig, rng, what.noise))
    return [
        Row(same[0].what, same[0].paper, {w: float(np.sqrt(np.mean([r.figures[w] ** 2 for r in same]))) for w in WAYS})
        for same in zip(*tables, strict=True)
    ]


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    there = conditions()
    for what in there:
        size = " × ".join(str(n) for n in what.rig[0].size)
        print(f"{what.name}: {size} px, noise {what.noise[0]:.3f} px across, {what.noise[1]:.3f} px down")
    tables = [table(what, rounds) for what in there]
    print(f"\n{'':48}{'quoted':>8}" + "".join(f"{what.name:>27}" for what in there))
    print(f"{'':56}" + "".join("".join(f"{way[:8]:>9}" for way in WAYS) for _ in there))
    for same in zip(*tables, strict=True):
        cells = "".join(f"{row.figures[way]:9.3g}" for row in same for way in WAYS)
        print(f"{same[0].what:<48}{same[0].paper:>8}{cells}")


if __name__ == "__main__":
    main()
