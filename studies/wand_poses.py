"""How many poses of a wand a calibration needs, and whether it knows how good it is.

Six cameras 1280 × 1024 about 1.4 × 2.4 × 2 m, lenses of k1 = −0.12, known by nothing but the size of their images, see
a wand with two markers 500 mm apart: noise of 0.1 px, one false point in fifty images, 2 % of the markers 5 to 30 px
off. Then a walking person's markers, in images without noise, are reconstructed and laid on the
truth: what is left is the calibration's own error. Its joint covariance predicts it.

Run: python studies/wand_poses.py [--rounds N] [--figure FILE.svg]
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kinemark.calibrate.bundle import BundleFit
from kinemark.calibrate.quality import predicted_covariance
from kinemark.calibrate.wand import calibrate_wand
from kinemark.data import Detections, Rig
from kinemark.geometry import project_all, refine, rigid_align, triangulate, undistort
from kinemark.synth import observe, ring, walking, wand

POSES = (25, 50, 100, 200, 400, 800)
BAR, BEST_OPEN = 0.15, 0.11


class Walk(NamedTuple):
    """RMSE of the markers, and what the covariance predicts of it, mm."""

    error: float
    predicted: float


def with_wrong(seen: Detections, share: float, rng: np.random.Generator) -> Detections:
    """The detections, a share of them 5 to 30 px off."""
    uv = seen.uv.copy()
    bad = rng.random(len(uv)) < share
    turn = 2 * np.pi * rng.random(int(bad.sum()))
    uv[bad] += rng.uniform(5, 30, (len(turn), 1)) * np.column_stack([np.cos(turn), np.sin(turn)])
    return Detections.build(seen.cameras, seen.rate, seen.counts, uv, seen.cov, width=seen.width)


def calibrated(rig: Rig, poses: int, seed: int) -> BundleFit:
    """The rig from a wand."""
    waved = wand((0.0, 500.0), duration_s=16.0, rate=poses / 16, seed=seed, volume=rig.volume)
    seen = observe(rig, waved, noise_px=0.1, false_per_frame=0.02, merge_px=5.0, seed=seed).detections
    sizes = [camera.size for camera in rig]
    return calibrate_wand(with_wrong(seen, 0.02, np.random.default_rng(seed)), lengths=[500.0], sizes=sizes)


def on_a_walk(rig: Rig, fit: BundleFit) -> Walk:
    """How far a walking person's markers, seen by the true rig, are off in the calibrated one."""
    xyz = walking().xyz[:, ::10].reshape(-1, 3)
    uv = project_all(rig, xyz)
    ideal = np.stack([undistort(camera, x) for camera, x in zip(fit.rig, uv, strict=True)], 1)
    alike = np.broadcast_to(0.01 * np.eye(2), (*ideal.shape, 2))
    found = refine(fit.rig, triangulate(ideal, fit.rig.P), uv.transpose(1, 0, 2), alike).xyz
    R, t = rigid_align(found, xyz)
    cov = predicted_covariance(fit.rig, found, centroid_sd=1e-3, joint=fit.joint)
    off = ((found @ R.T + t - xyz) ** 2).sum(1).mean()
    return Walk(float(np.sqrt(off)), float(np.sqrt(np.trace(cov, axis1=1, axis2=2).mean())))


def svg(walks: dict[int, list[Walk]]) -> str:
    """Error by poses, both on logarithmic scales: dots, one a calibration; the line is the prediction."""
    width, height, left, top = 640, 360, 80, 40
    low, high = np.log10([0.01, 1.0])

    def at(poses: float, mm: float) -> tuple[float, float]:
        x = left + width * np.log(poses / POSES[0]) / np.log(POSES[-1] / POSES[0])
        return float(x), float(top + height * (high - np.log10(mm)) / (high - low))

    parts = []
    for mm in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0):
        y = at(POSES[0], mm)[1]
        parts.append(f'<line x1="{left}" x2="{left + width}" y1="{y:.1f}" y2="{y:.1f}" stroke="#ddd"/>')
        parts.append(f'<text x="{left - 10}" y="{y + 5:.1f}" text-anchor="end">{mm:g}</text>')
    for mm, words in ((BAR, "aim"), (BEST_OPEN, "best open program, no wrong points")):
        y = at(POSES[0], mm)[1]
        parts.append(
            f'<line x1="{left}" x2="{left + width}" y1="{y:.1f}" y2="{y:.1f}" stroke="#c33" stroke-dasharray="6"/>'
        )
        parts.append(f'<text x="{left + width}" y="{y - 5:.1f}" text-anchor="end" fill="#c33">{words}</text>')
    for poses in walks:
        x = at(poses, 1)[0]
        parts.append(f'<text x="{x:.1f}" y="{top + height + 24}" text-anchor="middle">{poses}</text>')
        parts += [f'<circle cx="{x:.1f}" cy="{at(poses, w.error)[1]:.1f}" r="5" fill="#247"/>' for w in walks[poses]]
    line = [at(poses, rms([w.predicted for w in found])) for poses, found in walks.items()]
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in line)
    parts.append(f'<polyline points="{places}" fill="none" stroke="#247" stroke-width="2"/>')
    parts.append(f'<text x="{left}" y="22">RMSE of a walking person\'s markers, mm, by poses of the wand</text>')
    frame = f'viewBox="0 0 {left + width + 30} {top + height + 40}" font-family="sans-serif" font-size="15"'
    ground = '<rect width="100%" height="100%" fill="white"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {frame}>{ground}{"".join(parts)}</svg>\n'


def rms(x: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(x))))


def study(*, poses: tuple[int, ...] = POSES, rounds: int = 3) -> dict[int, list[Walk]]:
    """The walks of every number of poses, printed."""
    rig = ring(6, distortion=(-0.12, 0.0, 0.0, 0.0, 0.0))
    print(
        f"poses   RMSE on a walk, mm   predicted   largest    "
        f"({rounds} calibrations each; quoted: aim {BAR}, best {BEST_OPEN})"
    )
    walks = {}
    for n in poses:
        walks[n] = [on_a_walk(rig, calibrated(rig, n, seed)) for seed in range(rounds)]
        error, predicted = rms([w.error for w in walks[n]]), rms([w.predicted for w in walks[n]])
        print(f"{n:5d}   {error:18.4f}   {predicted:9.4f}   {max(w.error for w in walks[n]):7.4f}", flush=True)
    return walks


def main(rounds: int, figure: Path | None) -> None:
    walks = study(rounds=rounds)
    if figure:
        figure.write_text(svg(walks), encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="How many poses of a wand a calibration needs.")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--figure", type=Path)
    main(**vars(parser.parse_args()))
