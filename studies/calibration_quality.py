"""Predicted and observed precision of many simulated calibrations, judged by truth.

Four cameras round a volume of 2.4 × 1.4 × 2 m are calibrated again and again with the 24 markers of a control frame,
seen with noise of 0.3 px, and then place other markers, with all cameras and without each of them. What was predicted
at every place before is compared with the root mean square error found there. The same with a wand, in fewer
calibrations.

    python studies/calibration_quality.py [--calibrations 60] [--figure FILE.svg]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from kinemark.calibrate import calibrate_control_points
from kinemark.calibrate.bundle import calibrate_sticks
from kinemark.calibrate.quality import predicted_covariance, visible
from kinemark.calibrate.world_frame import fit_moved_to
from kinemark.data import Rig
from kinemark.data.array_types import Floats
from kinemark.geometry import project_all, refine, triangulate, undistort
from kinemark.synth import control_frame, ring, wand

NOISE, WAND_NOISE = 0.3, 0.1  # px
RIG = ring(4, distortion=(-0.1, 0.0, 0.0, 0.0, 0.0))
SIZES = [camera.size for camera in RIG]
COLUMNS, ROWS, LEVEL = 9, 6, 1000.0
ALONG = np.array([0.0, 500.0])
CELL = 42
COLOURS = ((0, 34, 78), (124, 123, 120), (254, 232, 56))  # of Cividis, low, middle and high


def seen(rig: Rig, xyz: Floats, noise: float, rng: np.random.Generator) -> Floats:
    """(C, N, 2) px, NaN outside the images."""
    uv = project_all(rig, xyz) + noise * rng.normal(size=(len(rig), len(xyz), 2))
    uv[~visible(rig, xyz)] = np.nan
    return uv


def placed(rig: Rig, uv: Floats, noise: float) -> Floats:
    """(N, 3) mm from (C, N, 2) px, as any trial is reconstructed."""
    each = uv.transpose(1, 0, 2)
    ideal = np.stack([undistort(camera, each[:, c]) for c, camera in enumerate(rig)], 1)
    return refine(rig, triangulate(ideal, rig.P), each, np.broadcast_to(noise**2 * np.eye(2), (*each.shape, 2))).xyz


def places() -> Floats:
    """(N, 3) mm: a level cut through the volume."""
    x, y = (np.linspace(low, high, n) for low, high, n in zip((0, 0), (2400, 1400), (COLUMNS, ROWS), strict=True))
    return np.stack([*np.meshgrid(x, y), np.full((ROWS, COLUMNS), LEVEL)], -1).reshape(-1, 3)


def errors(rig: Rig, xyz: Floats, noise: float, rng: np.random.Generator, joint: Floats | None = None) -> Floats:
    """(1 + C, 2, N) mm² per axis, predicted and observed, with all cameras and without each."""
    uv = seen(RIG, xyz, noise, rng)
    both = []
    for without in ((), *((c,) for c in range(len(rig)))):
        cov = predicted_covariance(rig, xyz, centroid_sd=noise, joint=joint, without=without)
        left = uv.copy()
        left[list(without)] = np.nan
        found = ((placed(rig, left, noise) - xyz) ** 2).mean(1)
        both.append([np.trace(cov, axis1=1, axis2=2) / 3, found])
    return np.array(both)


def by_control_points(calibrations: int) -> Floats:
    """(1 + C, 2, N) mm per axis over many calibrations."""
    frame, xyz, each = control_frame().xyz.reshape(-1, 3), places(), []
    for seed in range(calibrations):
        rng = np.random.default_rng(seed)
        rig = calibrate_control_points(RIG.names, SIZES, frame, seen(RIG, frame, NOISE, rng))
        each.append(errors(rig, xyz, NOISE, rng))
    return np.sqrt(np.mean(each, axis=0))


def by_wand(calibrations: int) -> Floats:
    """As `by_control_points`; each calibration laid on the laboratory by the wand's own poses."""
    poses = wand(ALONG, duration_s=32.0, rate=2.5).xyz.transpose(1, 0, 2)
    xyz, each = places(), []
    for seed in range(calibrations):
        rng = np.random.default_rng(seed)
        uv = seen(RIG, poses.reshape(-1, 3), WAND_NOISE, rng).reshape(len(RIG), *poses.shape[:2], 2)
        fit = calibrate_sticks(RIG.names, SIZES, uv, along=ALONG)
        good = np.isfinite(fit.xyz).all(1)
        fit = fit_moved_to(fit, fit.xyz[good], poses.reshape(-1, 3)[good])
        each += [errors(fit.rig, xyz, WAND_NOISE, rng, fit.joint) for _ in range(4)]
    return np.sqrt(np.mean(each, axis=0))


def table(what: str, both: Floats) -> None:
    """Predicted and observed, over all places, with all cameras and without each."""
    print(f"\n{what}: σ per axis, root mean square over {both.shape[2]} places, mm")
    print("                 predicted  observed   ratio   of single places")
    for name, (predicted, observed) in zip(("all cameras", *(f"without {n}" for n in RIG.names)), both, strict=True):
        a, b, ratio = np.sqrt((predicted**2).mean()), np.sqrt((observed**2).mean()), predicted / observed
        print(f"  {name:13s}  {a:8.3f}  {b:6.3f}  {a / b:6.2f}   {ratio.mean():.2f} ± {ratio.std():.2f}")


def picture(both: Floats) -> str:
    """An SVG of the level cut: predicted above observed, with all cameras and without the first."""
    low, high = float(both[:2].min()), float(both[:2].max())
    width, height = COLUMNS * CELL, ROWS * CELL
    parts = []
    for column, (k, name) in enumerate(((0, "all four cameras"), (1, f"without {RIG.names[0]}"))):
        for row, kind in enumerate(("predicted", "observed in simulation")):
            x0, y0 = 10 + column * (width + 30), 30 + row * (height + 40)
            parts.append(f'<text x="{x0}" y="{y0 - 8}" class="t">{name}: {kind}</text>')
            for n, value in enumerate(both[k, row]):
                x, y = x0 + n % COLUMNS * CELL, y0 + (ROWS - 1 - n // COLUMNS) * CELL
                light = (value - low) / (high - low)
                parts.append(f'<rect x="{x}" y="{y}" width="{CELL}" height="{CELL}" fill="{colour(light)}"/>')
                ink = "#111" if light > 0.4 else "#fff"
                parts.append(f'<text x="{x + CELL / 2}" y="{y + CELL / 2 + 4}" fill="{ink}">{value:.2f}</text>')
    size = f'width="{2 * width + 50}" height="{2 * height + 90}"'
    style = "text{font:12px sans-serif;text-anchor:middle}.t{font-size:14px;text-anchor:start;fill:#1c2733}"
    ground = '<rect width="100%" height="100%" fill="#fff"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}><style>{style}</style>{ground}{"".join(parts)}</svg>\n'


def colour(light: float) -> str:
    """From dark blue to yellow."""
    rgb = [np.interp(light, (0, 0.5, 1), channel) for channel in zip(*COLOURS, strict=True)]
    return "#" + "".join(f"{round(float(value)):02x}" for value in rgb)


def main() -> None:
    parser = argparse.ArgumentParser(description="Predicted and observed precision of simulated calibrations.")
    parser.add_argument("--calibrations", type=int, default=60)
    parser.add_argument("--figure", type=Path)
    options = parser.parse_args()
    both = by_control_points(options.calibrations)
    table(f"{options.calibrations} calibrations with a control frame, noise {NOISE} px", both)
    waves = max(options.calibrations // 10, 2)
    table(f"{waves} calibrations with a wand, noise {WAND_NOISE} px", by_wand(waves))
    if options.figure:
        options.figure.write_text(picture(both), encoding="utf-8")


if __name__ == "__main__":
    main()
