"""What a wand's calibration states of its own errors, in laboratories of another generator, beside the truth.

    python benchmarks/room.py 0-29                 a line a laboratory, and the table
    python benchmarks/room.py 0-29 --radial 1      with fewer lens terms than the lenses have
    python benchmarks/room.py 0-29 --sideways      lenses with p1 and p2, which are not fitted

Laboratories: `tests/support/waved_above.py`, 3 to 10 cameras, noise of 0.1 to 0.5 px, the L-frame on the floor below
the wand, at the height of a table, or among its poses. Markers that rest at 27 places are reconstructed from the mean
of 25 images a camera.

**moved**: how far all of them lie from where they are in the room, mm; **σ room**: as `world_pose` states it there;
**d²**: that motion's six parameters, squared, by their stated covariance: 6 on average where it is true. **apart** and
**in the room**: how many of the 95 % ellipsoids hold the true place, without and with it (4); **rest**: once that
motion is taken away; **trend**: cameras whose residuals go with the place in the image (`lens_trend`).
"""

from __future__ import annotations

import argparse
import os

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

from typing import NamedTuple

import numpy as np
from tracking_scenes import numbers

from kinemark.calibrate.bundle import BundleFit
from kinemark.calibrate.l_frame import resting_l_frame
from kinemark.calibrate.quality import WorldPose, predicted_covariance, world_pose
from kinemark.calibrate.quality.calibration_evidence import residual_deviation
from kinemark.calibrate.quality.lens_trend import lens_trend
from kinemark.calibrate.wand import Wand, calibrate_wand
from kinemark.calibrate.world_frame import fit_moved_to
from kinemark.data import Detections, KinemarkError, Rig
from kinemark.data.array_types import Floats
from kinemark.geometry import refine, triangulate, undistort
from kinemark.match import EpipolarTriplets, match
from kinemark.numerics.vectors import cross_matrix
from kinemark.reconstruct import LeastSquares, reconstruct
from support.scenes.placements import seen
from support.waved_above import ARMS, GAPS, Laboratory, laboratory

INSIDE = 7.815  # χ² of three, 95 %
IMAGES = 25  # of a resting marker


class Judged(NamedTuple):
    """Of one laboratory, as the module says; mm, and shares."""

    cameras: int
    moved: float
    stated: float
    d2: float
    apart: float
    room: float
    rest: float
    trend: float


def markers(detections: Detections, rig: Rig) -> list[Floats]:
    """What the rig sees of every frame (n, 3) mm."""
    pairs = match(detections, rig, method=EpipolarTriplets(pairs="best"))
    cloud = reconstruct(pairs, detections, rig, method=LeastSquares(within_volume=False))
    return [np.asarray(cloud[f]) for f in range(cloud.n_frames)]


def calibrated(lab: Laboratory, method: Wand) -> tuple[BundleFit, WorldPose | None, float]:
    """The rig in the room, how well that is known, and the centroids' noise by its residuals, px."""
    fit = calibrate_wand(lab.wand, lengths=GAPS, sizes=[camera.size for camera in lab.true], method=method)
    frame = resting_l_frame(fit.rig, markers(lab.frame, fit.rig), long=ARMS[0], short=ARMS[1], tolerance=0.05)
    fit = fit_moved_to(fit, frame.seen, frame.known)
    sd = residual_deviation(fit.residual[fit.kept], fit.freedom)
    return fit, world_pose(fit.rig, fit.joint, frame.known, centroid_sd=sd, frames=frame.frames - frame.moved), sd


def images(true: Rig, places: Floats, noise: float, rng: np.random.Generator) -> Floats:
    """(N, C, 2) px."""
    uv = np.stack([seen(camera, places)[0] for camera in true], 1)
    uv = uv + noise * rng.normal(size=uv.shape)
    size = np.array([camera.size for camera in true])
    return np.where(((uv > 0) & (uv < size - 1)).all(-1, keepdims=True), uv, np.nan)


def judged(seed: int, method: Wand, **made: object) -> Judged:
    """One laboratory."""
    lab = laboratory(seed, **made)
    fit, world, sd = calibrated(lab, method)
    assert world is not None
    sd /= np.sqrt(IMAGES)
    uv = images(lab.true, lab.places, lab.noise / np.sqrt(IMAGES), np.random.default_rng(seed + 1000))
    ideal = np.stack([undistort(camera, uv[:, c]) for c, camera in enumerate(fit.rig)], 1)
    xyz = refine(fit.rig, triangulate(ideal, fit.rig.P), uv, np.broadcast_to(np.eye(2) * sd**2, (*uv.shape, 2))).xyz
    own = predicted_covariance(fit.rig, lab.places, centroid_sd=sd, joint=fit.joint)
    good = np.isfinite(xyz[:, 0]) & np.isfinite(own[:, 0, 0])
    off, places, own = (xyz - lab.places)[good], lab.places[good], own[good]
    exact = images(lab.true, places, 0.0, np.random.default_rng(0))
    ideal = np.stack([undistort(camera, exact[:, c]) for c, camera in enumerate(fit.rig)], 1)
    plain = refine(fit.rig, triangulate(ideal, fit.rig.P), exact, np.broadcast_to(np.eye(2), (*exact.shape, 2))).xyz
    G = np.concatenate([-cross_matrix(places - world.centre), np.tile(np.eye(3), (len(places), 1, 1))], 2)
    p = np.linalg.pinv(G.reshape(-1, 6)) @ (plain - places).ravel()
    added = world.at(places)
    return Judged(
        len(lab.true),
        float(np.sqrt(((G @ p) ** 2).sum(1).mean())),
        float(np.sqrt(np.trace(added, axis1=1, axis2=2).mean())),
        float(p @ np.linalg.solve(world.cov[:6, :6], p)),
        inside(off, own),
        inside(off, own + added),
        inside(off - G @ p, own),
        float(np.mean([_trend(fit, c) for c in range(len(fit.rig))])),
    )


def _trend(fit: BundleFit, c: int) -> bool:
    """Whether camera c has a trend."""
    found = lens_trend(fit.rig[c], fit.xyz, np.where(fit.kept[c][:, None], fit.residual[c], np.nan))
    return found is not None and found.px > 0


def inside(off: Floats, cov: Floats) -> float:
    """Share of errors (N, 3) mm within the 95 % ellipsoids of (N, 3, 3) mm²."""
    return float((np.einsum("ni,ni->n", off, np.linalg.solve(cov, off[..., None])[..., 0]) < INSIDE).mean())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seeds", nargs="*", default=["0-29"], help="such as 3 or 40-49")
    parser.add_argument("--radial", type=int, default=2, help="lens terms that are fitted")
    parser.add_argument("--sideways", action="store_true", help="lenses have p1 and p2")
    chosen = parser.parse_args()
    found = []
    print("        cameras  moved  σ room     d²  apart  in the room  rest  trend")
    for seed in numbers(chosen.seeds):
        try:
            one = judged(seed, Wand(radial=chosen.radial), lens=(True, True, chosen.sideways))
        except KinemarkError as error:
            print(f"{seed:6d}  refused: {str(error)[:100]}", flush=True)
            continue
        found.append(one)
        print(f"{seed:6d} {row(one)}", flush=True)
    print(f"  mean {row(Judged(*np.mean(found, axis=0)))}")


def row(one: Judged) -> str:
    """A line of the table."""
    return (
        f"{one.cameras:8.3g} {one.moved:6.2f} {one.stated:7.2f} {one.d2:6.1f}"
        f" {one.apart:6.0%} {one.room:12.0%} {one.rest:5.0%} {one.trend:6.0%}"
    )


if __name__ == "__main__":
    main()
