"""Cameras from one waved LED: three published runs, from nothing but the images' sizes.

The runs of MultiCamSelfCal (Svoboda, Martinec & Pajdla 2005) with 3 and 4 cameras; for one of them its calibration is
there too. Its projections hold for pixels freed of the lens by a linearisation made beforehand. Residuals of both
programs are found alike: every point is placed by least squares from all cameras that saw it, wrong ones too, and
reprojected as the lens draws it. Camera centres are compared after the similarity that lays them upon each other; the
run's unit is taken for the metre.

Run: python studies/self_calibration.py [20090709 | 20100906 | 20130726 ...]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from recordings import recording

from kinemark.calibrate.bundle import Bundle, BundleFit, calibrate_points
from kinemark.calibrate.world_frame import similarity
from kinemark.data import Camera, Rig
from kinemark.data.array_types import Floats
from kinemark.geometry import decompose, distort, project, refine, triangulate, undistort
from kinemark.io.selfcal import SelfCal, read_selfcal

RUNS = {"20090709": "DATA20090709_111010", "20100906": "DATA20100906_134124", "20130726": "mcsc_output_20130726"}


def misses(rig: Rig, uv: Floats, lenses: Sequence[Camera] | None = None) -> Floats:
    """(C, N) distance of points seen at (C, N, 2) from where they reproject, px; with lenses, the rig has none."""
    own = lenses or rig.cameras
    ideal = np.stack([undistort(camera, x) for camera, x in zip(own, uv, strict=True)], 1)
    start = triangulate(ideal, rig.P)
    seen = ideal if lenses else uv.transpose(1, 0, 2)
    xyz = refine(rig.as_known(), start, seen, np.broadcast_to(np.eye(2), (*seen.shape, 2))).xyz
    drawn = [project(camera, xyz) for camera in rig]
    drawn = [distort(lens, x) for lens, x in zip(lenses, drawn, strict=True)] if lenses else drawn
    return np.asarray(np.linalg.norm(uv - np.stack(drawn), axis=-1))


def rms(x: Floats) -> float:
    return float(np.sqrt(np.nanmean(x**2)))


def theirs(run: SelfCal) -> Rig:
    """The other program's cameras, for ideal pixels."""
    assert run.lenses is not None and run.P is not None
    ideal = np.stack([undistort(lens, x) for lens, x in zip(run.lenses, run.uv, strict=True)], 1)
    front = np.nanmedian(triangulate(ideal, run.P), axis=0)
    parts = [decompose(P, front=front) for P in run.P]
    return Rig(tuple(Camera(n, s, *part) for n, s, part in zip(run.names, run.sizes, parts, strict=True)))


def tell(text: str, run: SelfCal, fit: BundleFit, seconds: float, reference: Rig | None) -> None:
    words = f"  {text:38s} {rms(misses(fit.rig, run.uv)):.3f}"
    if reference is not None:
        A, b, s = similarity(fit.rig.centres, reference.centres, scale=True)
        off = np.linalg.norm(s * fit.rig.centres @ A.T + b - reference.centres, axis=1)
        spread = np.linalg.norm(reference.centres - reference.centres.mean(0), axis=1)
        words += f"   {100 * rms(off) / rms(spread):.2f} %  {1000 * rms(off):.1f} mm"
    kept, seen = fit.kept.sum(), np.isfinite(run.uv[..., 0]).sum()
    print(
        f"{words}   kept {kept} of {seen}: {rms(np.linalg.norm(fit.residual, axis=-1)[fit.kept]):.3f}   {seconds:.1f} s"
    )
    for camera in fit.rig:
        sd = float(np.sqrt(camera.cov[0, 0]))
        print(
            f"    {camera.name:28s} f {camera.K[0, 0]:7.1f} ± {sd:4.1f}"
            f"   centre {camera.K[0, 2]:5.1f} {camera.K[1, 2]:5.1f}"
            f"   k1 {camera.distortion[0]:+.3f}  k2 {camera.distortion[1]:+.3f}"
        )


def study(folder: Path) -> None:
    run = read_selfcal(folder)
    print(f"\n{folder.name}: {len(run.names)} cameras, {run.uv.shape[1]} places; residual of all points, RMS px")
    reference = theirs(run) if run.P is not None else None
    if reference is not None and run.lenses is not None:
        print(f"  {'MultiCamSelfCal, lenses linearised':38s} {rms(misses(reference, run.uv, run.lenses)):.3f}")
    ways: dict[str, tuple[Bundle, Sequence[Camera] | None]] = {"from image sizes alone": (Bundle(), None)}
    if run.lenses is not None:
        ways["with the same lenses"] = (Bundle(), run.lenses)
    for text, (method, lenses) in ways.items():
        begun = time.perf_counter()
        fit = calibrate_points(run.names, run.sizes, run.uv, method=method, lenses=lenses)
        tell(text, run, fit, time.perf_counter() - begun, reference)


def main() -> None:
    folder = recording("cameras/single_led_selfcal")
    for name in sys.argv[1:] or RUNS:
        study(folder / RUNS[name])


if __name__ == "__main__":
    main()
