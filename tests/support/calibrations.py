"""Calibrations for tests: a small laboratory, what it sees of a control frame, and sessions of it on disk."""

import numpy as np

from kinemark.calibrate.control_points import control_point_quality
from kinemark.calibrate.quality import visible
from kinemark.calibrate.quality.calibration_evidence import Evidence
from kinemark.engine.session import Session
from kinemark.geometry import project_all
from kinemark.io.detections_csv import write_detections_csv
from kinemark.synth import control_frame, ring, wand
from support.laboratory import observe

FRAME = control_frame()
POINTS = FRAME.xyz.reshape(-1, 3)
RIG = ring(4, distortion=(-0.1, 0.0, 0.0, 0.0, 0.0))

SMALL = ring(4, focal_px=650.0, size=(640, 480), distortion=(-0.1, 0.0, 0.0, 0.0, 0.0))
NAMES = ", ".join(f'"{name}"' for name in SMALL.names)
WAVED = wand((0.0, 500.0), duration_s=48.0, rate=2.5).xyz
TRIAL = np.random.default_rng(3).uniform(300, 1300, (3, 1, 3)) + np.linspace(0, 200, 30)[None, :, None]
HEAD = f"""\
name = "lab"
rate_hz = 50.0
volume_mm = [[0, 0, 0], [2400, 1400, 2000]]
[cameras]
names = [{NAMES}]
size_px = [640, 480]
"""
TAIL = """
[[trials]]
name = "one"
detections = "one.csv"
"""
BY_POINTS = 'control_points = { points = "points.csv" }'
BY_WAND = 'wand = { lengths_mm = [500.0], detections = "wand.csv" }'
L_FRAME = 'l_frame = { arms_mm = [800, 600], height_mm = 12.5, detections = "lframe.csv" }'


def seen(rig, xyz, noise, rng):
    """(C, N, 2) px of points in the images, NaN outside them."""
    uv = project_all(rig, xyz) + noise * rng.normal(size=(len(rig), len(xyz), 2))
    uv[~visible(rig, xyz)] = np.nan
    return uv


def of_control_points(uv, rig=RIG):
    """The rig calibrated from images (C, 24, 2) px of the control frame, and the evidence for it, not yet judged."""
    fit = control_point_quality(rig.names, [c.size for c in rig], POINTS, uv, points=FRAME.marker_names)
    evidence = Evidence(
        "control points",
        names=fit.points,
        xyz=fit.xyz,
        uv=fit.uv,
        residual=fit.residual,
        kept=fit.kept,
        left_out=np.linalg.norm(fit.left_out_error, axis=-1),
        left_out_mm=np.linalg.norm(fit.left_out_xyz, axis=-1),
        freedom=int(fit.freedom.sum()),
    )
    return fit.rig, evidence


def detected(xyz, rig=SMALL, *, noise=0.05, seed=0):
    """Detections of points (M, F, 3) mm."""
    return observe(rig, xyz, noise=noise, seed=seed)[0]


def session(folder, calibration, head=HEAD):
    """A session with a trial of three markers and this `[calibration]`."""
    folder.mkdir(parents=True, exist_ok=True)
    write_detections_csv(folder / "one.csv", detected(TRIAL))
    (folder / "session.toml").write_text(f"{head}[calibration]\n{calibration}\n{TAIL}")
    return Session.open(folder)


def off(rig, truth=SMALL, places=POINTS):
    """Median distance of images of the volume, px, between a rig and the truth in the same world."""
    return float(np.nanmedian(np.linalg.norm(project_all(rig, places) - project_all(truth, places), axis=-1)))


def points_csv(folder, *, uv=None, by=0.0):
    """The control frame's markers as control points, seen at (4, 24, 2) px, or where they are but for some noise.

    `by` (3) mm is how far the survey's origin lies from the laboratory's.
    """
    if uv is None:
        uv = project_all(SMALL, POINTS) + 0.05 * np.random.default_rng(1).normal(size=(4, len(POINTS), 2))
    rows = ["name,x_mm,y_mm,z_mm," + ",".join(f"{c}_{axis}_px" for c in SMALL.names for axis in "uv")]
    for n, (xyz, pixels) in enumerate(zip(POINTS + by, uv.transpose(1, 0, 2), strict=True)):
        rows.append(",".join([f"P{n + 1}", *map(str, xyz), *("" if np.isnan(p) else str(p) for p in pixels.ravel())]))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "points.csv").write_text("\n".join(rows) + "\n")


def lay_out_wand(folder):
    """Detections of a waved wand and of an L-frame on the floor."""
    folder.mkdir(parents=True, exist_ok=True)
    write_detections_csv(folder / "wand.csv", detected(WAVED))
    corner = np.array([[0, 0, 12.5], [800, 0, 12.5], [0, 600, 12.5]], float)
    write_detections_csv(folder / "lframe.csv", detected(corner[:, None], seed=1))
