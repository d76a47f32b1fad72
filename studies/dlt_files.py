"""The eleven-parameter DLT on published recordings, against the figures known for them.

1. `resection_5cam`: hundreds of control points a camera (flydra); a fresh fit and its residual.
2. `kinemat_running_3cam`: three film cameras, six control points, a runner with 24 markers and three fixed marks. The
   cameras ran at slightly different speeds and the film shifted in the digitiser, so frames are aligned by a straight
   line of time for each camera and images by the fixed marks. The stored coordinates were smoothed.
3. `dltdv_thermal_3cam`: stored coefficients, pixels and coordinates of DLTdv; a wand of known length and a thrown
   object of easyWand, whose lens terms are undone first.
4. `bad_control_frame_8cam`: a control frame whose fifth pole stands elsewhere than the survey says; what the judgement
   of it and of the first two says.

Run: python studies/dlt_files.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from recordings import recording
from scipy.interpolate import CubicSpline
from scipy.io import loadmat
from scipy.optimize import minimize

from kinemark.calibrate import control_point_quality, judge_control_points, reference_shift
from kinemark.data import Camera
from kinemark.data.array_types import Floats
from kinemark.geometry import fit_dlt, from_dlt, triangulate, undistort
from kinemark.io.dlt_csv import read_dlt_csv, read_dltdv_xy, read_dltdv_xyz
from kinemark.report.words import text_of

Case = tuple[str, Floats, Floats, tuple[int, int]]

MARKERS = 24  # of the runner; the three fixed marks come behind them
DIGITISED = 10.0  # units by which an operator misses a fixed mark, at most


def rms_residual(L: Floats, xyz: Floats, uv: Floats) -> float:
    """Root mean square distance of control points (N, 2) from their reprojections, in the images' units."""
    x = np.column_stack([xyz, np.ones(len(xyz))]) @ from_dlt(L).T
    return float(np.sqrt(((x[:, :2] / x[:, 2:] - uv) ** 2).sum(1).mean()))


def resection(folder: Path) -> None:
    residuals = []
    for c in range(1, 6):
        table = np.loadtxt(folder / f"cam{c}.points4cal.dat")
        residuals.append(rms_residual(fit_dlt(table[:, :3], table[:, 4:6]), table[:, :3], table[:, 4:6]))
    print("resection_5cam: RMS residual of a fresh DLT, px (quoted: 0.19–0.86)")
    print("  " + "  ".join(f"{r:.2f}" for r in residuals))


def runner(folder: Path) -> None:
    points = np.loadtxt(folder / "calframe.txt")
    marks = [np.loadtxt(folder / f"r1cam{c}.cal") for c in (1, 2, 3)]
    L = np.array([fit_dlt(points, m[:6]) for m in marks])
    residuals = [rms_residual(row, points, m[:6]) for row, m in zip(L, marks, strict=True)]
    print("\nkinemat_running_3cam: RMS residual of the DLT, digitiser units (quoted: 0.35  1.68  1.20)")
    print("  " + "  ".join(f"{r:.2f}" for r in residuals))
    films = [np.loadtxt(folder / f"r1cam{c}.raw").reshape(-1, MARKERS + 3, 2) for c in (1, 2, 3)]
    shifts = [
        reference_shift(m[None, 6:], film[None, :, MARKERS:], tolerance=DIGITISED)[0]
        for film, m in zip(films, marks, strict=True)
    ]
    still = [film - shift[:, None] for film, shift in zip(films, shifts, strict=True)]
    stored = loadmat(folder / "result.mat")["H"].reshape(-1, MARKERS + 3, 5)[:, :MARKERS, :3]
    P = from_dlt(L)
    start = np.concatenate([line_of_time(film, stored, p) for film, p in zip(still, P, strict=True)])

    def difference(lines: Floats, images: list[Floats]) -> Floats:
        return np.linalg.norm(runner_at(lines, images, len(stored), P) - stored, axis=-1)[5:-5]

    def mean_difference(lines: Floats) -> float:
        return float(difference(lines, still).mean())

    best = minimize(mean_difference, start.ravel(), method="Nelder-Mead", options={"adaptive": True})
    for text, images, known in (("as digitised", films, 5.4), ("shifted by the fixed marks", still, 1.4)):
        mean = difference(best.x, images).mean()
        print(f"  mean difference from the stored coordinates, {text}: {mean:.2f} mm (quoted: {known})")


def line_of_time(film: Floats, stored: Floats, P: Floats) -> Floats:
    """Frame of the film at stored frame 0, and frames of the film to a stored frame, where images agree best."""
    fine = np.linspace(0, len(film) - 1, 20 * len(film))
    images = CubicSpline(np.arange(len(film)), film[:, :MARKERS])(fine)
    x = np.concatenate([stored, np.ones((*stored.shape[:2], 1))], -1) @ P.T
    off = np.linalg.norm(images - (x[..., :2] / x[..., 2:])[:, None], axis=-1).mean(-1)
    slope, first = np.polyfit(np.arange(len(stored)), fine[off.argmin(1)], 1)
    return np.array([first, slope])


def runner_at(lines: Floats, films: list[Floats], n: int, P: Floats) -> Floats:
    """The runner's markers (n, 24, 3) mm at the stored frames, given each camera's line of time."""
    images = []
    for (first, slope), film in zip(lines.reshape(-1, 2), films, strict=True):
        at = np.clip(first + slope * np.arange(n), 0, len(film) - 1)
        images.append(CubicSpline(np.arange(len(film)), film[:, :MARKERS])(at))
    return triangulate(np.stack(images, 2).reshape(-1, len(films), 2), P).reshape(n, MARKERS, 3)


def bats(folder: Path) -> None:
    P = from_dlt(read_dlt_csv(folder / "2018-08-17_wand_dltCoefs_round4.csv"))
    name = "DLTdv7_data_2018-08-17_P03_1000TMC"
    uv, stored = read_dltdv_xy(folder / f"{name}xypts.csv"), read_dltdv_xyz(folder / f"{name}xyzpts.csv")
    xyz = triangulate(uv.reshape(len(P), -1, 2).transpose(1, 0, 2), P).reshape(stored.shape)
    print("\ndltdv_thermal_3cam")
    print(f"  largest difference from the stored coordinates: {np.nanmax(np.abs(xyz - stored)):.1e} m (quoted: 5e-7)")
    easy = loadmat(folder / "round3_2018-07-28_easyWandData.mat", squeeze_me=True, struct_as_record=False)[
        "easyWandData"
    ]
    wand = easy_points(easy, easy.wandPts.reshape(-1, 2, 3, 2))
    length = np.linalg.norm(wand[:, 0] - wand[:, 1], axis=1)
    median, n = np.nanmedian(length), np.isfinite(length).sum()
    print(f"  wand of {easy.wandLen} m: median {median:.4f} m of {n} (quoted: 0.6602)")
    thrown = easy_points(easy, easy.axisPts.reshape(-1, 1, 3, 2))[:, 0]
    seen = np.isfinite(thrown).all(1)
    t = np.flatnonzero(seen) / 25
    g = np.linalg.norm([2 * np.polyfit(t, thrown[seen, k], 2)[0] for k in range(3)])
    print(f"  thrown object: |g| = {g:.2f} m/s² from {seen.sum()} frames (quoted: 10.03)")


def judgements(root: Path) -> None:
    """Whether control point calibrations are good, in Kinemark's words."""
    print("\njudgement of control points")
    for name, xyz, uv, size in (six_points(root), moving_light(root), five_poles(root)):
        fit = control_point_quality([f"cam{c + 1}" for c in range(len(uv))], [size] * len(uv), xyz, uv)
        grade, findings = judge_control_points(fit)
        print(f"  {name}: {grade}")
        for found in findings[:2]:
            print(f"    {text_of(found)}")


def six_points(root: Path) -> Case:
    folder = root / "kinemat_running_3cam"
    uv = np.stack([np.loadtxt(folder / f"r1cam{c}.cal")[:6] for c in (1, 2, 3)])
    return "kinemat_running_3cam", np.loadtxt(folder / "calframe.txt"), uv, (0, 0)


def moving_light(root: Path) -> Case:
    """Places that several cameras saw are one point."""
    folder = root / "resection_5cam/tests/sample_calibration"
    tables = [np.loadtxt(folder / f"cam{c}.points4cal.dat") for c in range(1, 6)]
    xyz, which = np.unique(np.concatenate([t[:, :3] for t in tables]).round(6), axis=0, return_inverse=True)
    uv = np.full((5, len(xyz), 2), np.nan)
    camera = np.repeat(np.arange(5), [len(t) for t in tables])
    uv[camera, which.ravel()] = np.concatenate([t[:, 4:6] for t in tables])
    return "resection_5cam", xyz, uv, (656, 491)


def five_poles(root: Path) -> Case:
    folder = root / "bad_control_frame_8cam"
    xyz = 1000 * np.loadtxt(folder / "ref3d_realworld/ref3d_realworld.csv", delimiter=",")
    rows = [
        np.loadtxt(folder / f"pixelcorrds/c0{c}_markers_1_line.csv", delimiter=",", skiprows=1, ndmin=2)[0, 1:]
        for c in range(1, 9)
    ]
    return "bad_control_frame_8cam", xyz, np.stack(rows).reshape(8, -1, 2), (1920, 1080)


def easy_points(easy: object, uv: Floats) -> Floats:
    """Points (N, M, 3) m from easyWand's pixels (N, M, C, 2), through its lens terms and coefficients."""
    n_cameras = uv.shape[2]
    ideal = np.empty_like(uv)
    for c in range(n_cameras):
        f, (cx, cy), lens = easy.focalLengths[c], easy.ppts[2 * c : 2 * c + 2], easy.nlin[5 * c : 5 * c + 5]  # type: ignore[attr-defined]
        K = np.array([[f, 0, cx], [0, f, cy], [0, 0, 1.0]])
        ideal[:, :, c] = undistort(
            Camera(f"cam{c}", np.zeros(2, np.int64), K, np.eye(3), np.zeros(3), lens), uv[:, :, c]
        )
    P = from_dlt(easy.coefs.T)  # type: ignore[attr-defined]
    return triangulate(ideal.reshape(-1, n_cameras, 2), P).reshape(*uv.shape[:2], 3)


def main() -> None:
    resection(recording("cameras/resection_5cam/tests/sample_calibration"))
    runner(recording("cameras/kinemat_running_3cam"))
    bats(recording("cameras/dltdv_thermal_3cam"))
    judgements(recording("cameras"))


if __name__ == "__main__":
    main()
