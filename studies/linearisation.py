"""Linearising cameras (KISS 3.2) with rendered dot grids, chessboards, and two dot targets.

1. The grid of 300 dots, rendered, found, ordered; how straight its lines are before and after; how far the lens found
   is from the true one over the whole image, px. From one picture the lens is known up to a perspective map, which
   whoever uses it fits anyway: RMS difference of the straightened images after the best homography. From several, the
   camera is known: RMS difference of the rays, in px, after the best rotation. OpenCV gets the same points.
2. What it is for: cameras calibrated from the 24 markers of the hanging rods, judged on points that took no part. The
   plain DLT; the DLT on pixels straightened by a linearisation from one picture of the grid; a camera's own parameters
   with a lens term from the rods alone; and with the lens held as linearised.
3. `chessboard_left`, 13 pictures with strong barrel distortion, beside OpenCV on the same corners and as published.
4. `dot_target_4cam` and `dot_body_splitter`: dots named from a few picked by hand; residuals of the DLT and of a camera
   with k1; by how much the DLT's pixel axes are off a right angle, which no camera's own are (a tilted sensor, a window
   or mirrors seen at a slant); and what the published calibration, where it is one of the same target, leaves.

Run: python studies/linearisation.py [--pictures FOLDER for the ordered grids] [--figure FILE.svg]
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from recordings import FOLDER, recording

from kinemark.calibrate import (
    ControlPoints,
    GridView,
    LensFit,
    Linearisation,
    assign_points,
    calibrate_control_points,
    find_corners,
    linearise,
    order_grid,
    part_of_grid,
    straightness,
)
from kinemark.data import Camera, KinemarkError
from kinemark.data.array_types import Floats
from kinemark.detect import Centroids, detect_frames
from kinemark.geometry import distort, fit_dlt, from_dlt, project, rays, rigid_align, undistort
from kinemark.geometry.sphere_offset import sphere_offset
from kinemark.io.images import read_image, write_png
from kinemark.synth import dot_grid, look_at, render, ring
from kinemark.synth.targets import control_frame

COLUMNS, ROWS, PITCH = 20, 15, 50.0
SIZE = (1280, 1024)
FOCAL = 1300.0
LENSES = {"weak barrel": (-0.12, 0.0, 0.0, 0.0, 0.0), "strong barrel": (-0.30, 0.10, 5e-4, -3e-4, 0.0)}
RADIUS = 4.0
XYZ = dot_grid(ROWS, COLUMNS, pitch_mm=PITCH, radius_mm=RADIUS).xyz[:, 0]
FRONT = ((8.0, -1060.0, 5.0), 2.0)
AROUND = (((520, -1150, 90), 1), ((-540, -1150, -60), 3), ((60, -1150, 480), 180), ((40, -700, -250), 90))
"""Where the camera stands besides, mm, and its roll, deg. From the last place it sees only a part of the grid."""


def camera_at(place: tuple[float, ...], roll: float, lens: tuple[float, ...]) -> Camera:
    return look_at("cam", place, (0.0, 0.0, 0.0), roll_deg=roll, focal_px=FOCAL, size=SIZE, distortion=lens)


def grid_view(camera: Camera, rng: np.random.Generator) -> tuple[GridView, int, int, NDArray[np.uint8]]:
    """A picture of the grid with its dots ordered; how many are wholly in the picture, and how many of them right."""
    image = render(camera, XYZ, RADIUS, rng=rng)
    uv, true = dots(image, Centroids()), project(camera, XYZ)
    try:
        index = order_grid(uv, columns=COLUMNS, rows=ROWS)
    except KinemarkError:
        index = part_of_grid(uv)
    node, seen = np.argwhere(index >= 0), uv[index[index >= 0]]
    inside = ((true > 2 * RADIUS) & (true < camera.size - 1 - 2 * RADIUS)).all(1)
    return (
        GridView(seen, np.asarray(PITCH * node[:, ::-1], np.float64)),
        int(inside.sum()),
        in_place(node, seen, true),
        image,
    )


def in_place(node: NDArray[np.int64], seen: Floats, true: Floats) -> int:
    """How many points are at their node of the grid; its quarter turns and, of a part, its first node are free."""
    off = np.linalg.norm(seen[:, None] - true, axis=2)
    place = np.column_stack(np.divmod(off.argmin(1), COLUMNS))
    counts = []
    for turn in (np.eye(2), -np.eye(2), np.array([[0, 1], [-1, 0]]), np.array([[0, -1], [1, 0]])):
        shift = place - node @ turn.T
        counts.append(int(((shift == np.median(shift, axis=0)).all(1) & (off.min(1) < 1)).sum()))
    return max(counts)


def dots(image: NDArray[np.uint8 | np.uint16], method: Centroids) -> Floats:
    blobs = detect_frames(image[None], method=method)
    return blobs.uv[blobs.validity == 0]


def sensor() -> Floats:
    """(N, 2) places all over the image, px."""
    u, v = np.meshgrid(np.linspace(0, SIZE[0] - 1, 33), np.linspace(0, SIZE[1] - 1, 27))
    return np.stack([u, v], -1).reshape(-1, 2)


def lens_error(found: Camera, true: Camera) -> float:
    """RMS difference, px, of the straightened images after the best homography."""
    a, b = undistort(found, sensor()), undistort(true, sensor())
    plane = np.column_stack([a, np.ones(len(a))])
    rows = [np.hstack([plane, 0 * plane, -b[:, :1] * plane]), np.hstack([0 * plane, plane, -b[:, 1:] * plane])]
    H = np.linalg.svd(np.concatenate(rows) / FOCAL, full_matrices=False)[2][-1].reshape(3, 3)
    h = plane @ H.T
    return float(np.sqrt(((h[:, :2] / h[:, 2:] - b) ** 2).sum(1).mean()))


def camera_error(found: Camera, true: Camera) -> float:
    """RMS difference, px, of the rays after the best rotation."""
    a, b = rays(found, sensor()), rays(true, sensor())
    R, _ = rigid_align(np.concatenate([a, -a]), np.concatenate([b, -b]))
    return FOCAL * float(np.sqrt(((a @ R.T - b) ** 2).sum(1).mean()))


def grids(pictures: Path | None, figure: Path | None) -> dict[str, LensFit]:
    print(f"grid of {ROWS} × {COLUMNS} dots, rendered at {SIZE[0]} × {SIZE[1]} px")
    print(f"  {'':32s}{'in view':>8s}{'right':>7s}{'before':>9s}{'after':>8s}{'lens':>14s}{'off, px':>10s}")
    single = {}
    for name, lens in LENSES.items():
        rng, true = np.random.default_rng(3), camera_at(*FRONT, lens)
        views = [grid_view(true, rng)]
        if pictures:
            write_png(pictures / f"{name.replace(' ', '_')}.png", drawn(views[0][3], views[0][0].uv))
        single[name] = one = linearise("cam", SIZE, [views[0][0]], diameter=2 * RADIUS)
        row(f"{name}, one picture", views, one, lens_error(one.camera, true))
    if figure:  # of the strong barrel, which comes last
        figure.write_text(svg(views[0][0], single[name].camera), encoding="utf-8")
    views += [grid_view(camera_at(place, roll, lens), rng) for place, roll in AROUND]
    several = linearise("cam", SIZE, [view for view, *_ in views], diameter=2 * RADIUS)
    row(f"{name}, {len(views)} pictures", views, several, camera_error(several.camera, true))
    print(f"    focal length {focal(several.camera)} px, true {FOCAL:.2f}")
    rival(several, [corrected(*both) for both in zip((v[0] for v in views), several.views, strict=True)], true)
    return single


def row(name: str, views: list[tuple[GridView, int, int, NDArray[np.uint8]]], fit: LensFit, error: float) -> None:
    inside, right = sum(v[1] for v in views), sum(v[2] for v in views)
    before, after = fit.straightness
    print(f"  {name:32s}{inside:8d}{right:7d}{before:9.3f}{after:8.3f}{terms(fit):>14s}{error:10.4f}")


def focal(camera: Camera) -> str:
    return f"{camera.K[0, 0]:.2f} ± {np.sqrt(camera.cov[0, 0]):.2f}"


def corrected(view: GridView, camera: Camera) -> GridView:
    """The view with what the spheres' centroids lie beside their centres taken off, as `linearise` does."""
    xyz = np.column_stack([view.xy, np.zeros(len(view.xy))])
    return view._replace(uv=view.uv - sphere_offset(camera, xyz, diameter=2 * RADIUS))


def terms(fit: LensFit) -> str:
    radial = f"k1…k{fit.radial}" if fit.radial > 1 else "k1" if fit.radial else "none"
    return radial + (" p1 p2" if fit.tangential else "")


def rival(ours: LensFit, views: list[GridView], true: Camera) -> None:
    theirs = opencv(ours, views, SIZE)
    if theirs:
        rms, camera = theirs
        off = camera_error(camera, true)
        print(f"    OpenCV calibrateCamera: residual {rms:.4f} px (ours {ours.camera.residual:.4f}), off {off:.4f} px")


def opencv(ours: LensFit, views: list[GridView], size: tuple[int, int]) -> tuple[float, Camera] | None:
    """RMS residual and camera by `calibrateCamera`, with as many lens terms as ours; None where it is not installed."""
    try:
        import cv2
    except ImportError:
        return None
    seen = [np.isfinite(view.uv).all(1) for view in views]
    plane = [np.column_stack([v.xy[s], np.zeros(s.sum())]).astype(np.float32) for v, s in zip(views, seen, strict=True)]
    uv = [v.uv[s].astype(np.float32) for v, s in zip(views, seen, strict=True)]
    off = [cv2.CALIB_FIX_K1, cv2.CALIB_FIX_K2, cv2.CALIB_FIX_K3][ours.radial :]
    flags = sum(off) + (0 if ours.tangential else cv2.CALIB_ZERO_TANGENT_DIST)
    rms, K, k, _, _ = cv2.calibrateCamera(plane, uv, size, np.eye(3), np.zeros(5), flags=flags)
    lens = np.asarray(k, np.float64).ravel()[:5]
    return rms, Camera("cv2", np.array(size), np.asarray(K, np.float64), np.eye(3), np.zeros(3), lens)


def linearised_dlt(single: dict[str, LensFit]) -> None:
    print("\nthe hanging rods' 24 markers, noise 0.05 px, six cameras: RMS error on unseen points, px")
    xyz = control_frame().xyz.reshape(-1, 3)
    unseen = np.random.default_rng(1).uniform([150, 100, 150], [2250, 1300, 1850], (300, 3))
    for name, lens in LENSES.items():
        rig = ring(6, distortion=lens, focal_px=FOCAL, size=SIZE)
        noise = np.random.default_rng(2).normal(0, 0.05, (6, len(xyz), 2))
        off: dict[str, list[Floats]] = {"DLT": [], "linearised DLT": [], "lens from the rods": [], "lens held": []}
        for c, camera in enumerate(rig):
            uv, truth, fixed = project(camera, xyz) + noise[c], project(camera, unseen), single[name].camera
            off["DLT"].append(sent(fit_dlt(xyz, uv), unseen) - truth)
            straight = sent(fit_dlt(xyz, undistort(fixed, uv)), unseen)
            off["linearised DLT"].append(distort(fixed, straight) - truth)
            for key, lenses in (("lens from the rods", None), ("lens held", [fixed])):
                found = calibrate_control_points([camera.name], [SIZE], xyz, uv[None], lenses=lenses)[0]
                off[key].append(project(found, unseen) - truth)
        figures = "   ".join(f"{key} {np.sqrt((np.array(d) ** 2).sum(-1).mean()):.3f}" for key, d in off.items())
        print(f"  {name:16s}{figures}")


def sent(L: Floats, xyz: Floats) -> Floats:
    h = np.column_stack([xyz, np.ones(len(xyz))]) @ from_dlt(L).T
    return np.asarray(h[:, :2] / h[:, 2:])


def chessboards(folder: Path, pictures: Path | None) -> None:
    xy = 25.0 * np.array([(c, r) for r in range(6) for c in range(9)], np.float64)
    views, start = [], time.perf_counter()
    for path in sorted(folder.glob("*.jpg")):
        image = read_image(path)
        views.append(GridView(find_corners(image, columns=9, rows=6).reshape(-1, 2), xy))
        if pictures:
            write_png(pictures / f"{path.stem}.png", drawn(image.astype(np.uint8), views[-1].uv))
    found = sum(int(np.isfinite(view.uv[:, 0]).sum()) for view in views)
    took = (time.perf_counter() - start) / len(views)
    print(f"\nchessboard_left: {found} of {54 * len(views)} corners in {len(views)} pictures, {took:.2f} s each")
    print("  quoted, as published (OpenCV): residual 0.409 px, f 536.1 px, k1 -0.265")
    for method in (Linearisation(1, False), Linearisation()):
        fit = linearise("left", (640, 480), views, method=method)
        (before, after), lens = fit.straightness, fit.camera.distortion
        print(
            f"  {terms(fit):14s} residual {fit.camera.residual:.3f} px   f {focal(fit.camera)} px   k1 {lens[0]:.3f}   "
            f"lines {before:.2f} → {after:.3f} px"
        )
        theirs = opencv(fit, views, (640, 480))
        if theirs:
            print(f"    OpenCV, same corners: {theirs[0]:.3f} px   f {theirs[1].K[0, 0]:.2f} px")


PICKED = {
    1: ((742, 153), (356, 67), (217, 191), (711, 672), (335, 582), (197, 722)),
    2: ((143, 184), (510, 89), (685, 207), (179, 708), (535, 606), (707, 740)),
    3: ((201, 131), (326, 265), (694, 164), (250, 644), (374, 763), (752, 663)),
    4: ((189, 179), (541, 278), (693, 134), (154, 676), (516, 772), (669, 639)),
}
"""Where each camera has the first, fourth and seventh dot of the first and last row of the body with 105 dots, px."""


PRINTED = Centroids(max_discs=1, correct_occlusion=False)
"""Dots of a print neither overlap nor hide each other."""


def dot_targets() -> None:
    print("\ndot targets: dots named, RMS residual of the DLT, and how far its pixel axes are off a right angle;")
    print(
        "residual, focal length and straightness of a camera with k1; what the one quoted leaves, and its focal length"
    )
    heads = f"{'dots':>10s}{'DLT, px':>10s}{'deg':>6s}{'k1, px':>9s}{'f, px':>12s}{'lines, px':>18s}"
    heads += f"{'quoted':>17s}"
    print(f"  {'':20s}{heads}")
    folder = recording("cameras/dot_target_4cam")
    clicked = np.loadtxt(folder / "man_ori.dat")
    for camera, side, first in ((1, 1, 0), (2, 2, 0), (3, 2, 0), (4, 1, 4)):
        xyz = np.loadtxt(folder / "cal" / f"target_on_a_side{side}.txt")[:, 1:]
        corners = [(-67.5, 30), (67.5, 30), (-67.5, -30), (67.5, -30)]
        picked = np.array([np.abs(xyz[:, :2] - corner).sum(1).argmin() for corner in corners])
        uv = dots(read_image(folder / "cal" / f"cam{camera}.tif"), replace(PRINTED, min_area=50))
        published = folder / "cal" / f"cam{camera}.tif.ori" if side == 2 else None
        named(f"dot_target_4cam {camera}", uv, xyz, picked, clicked[first : first + 4], published)
    folder = recording("cameras/dot_body_splitter")
    xyz = np.loadtxt(folder / "cal" / "splitter_target.txt")[:, 1:]
    for camera, places in PICKED.items():
        uv = dots(read_image(folder / "cal" / f"cam{camera}.png"), PRINTED)
        named(f"dot_body_splitter {camera}", uv, xyz, np.array([0, 3, 6, 98, 101, 104]), np.array(places, np.float64))


def named(
    what: str, uv: Floats, xyz: Floats, picked: NDArray[np.int64], at: Floats, published: Path | None = None
) -> None:
    index = assign_points(uv, xyz, picked=picked, at=at)
    xyz, uv = xyz[index >= 0], uv[index[index >= 0]]
    L = fit_dlt(xyz, uv)
    own = calibrate_control_points(["a"], [(0, 0)], xyz, uv[None], method=ControlPoints(reject=np.inf))[0]
    f, sd = own.K[0, 0], np.sqrt(own.cov[0, 0])
    straight = f"{levels(uv, xyz):.3f} → {levels(undistort(own, uv), xyz):.3f}"
    print(
        f"  {what:20s}{len(uv):4d} of {len(index)}{rms(sent(L, xyz) - uv):8.3f}{skewed(L):8.2f}{own.residual:9.3f}"
        f"{f:9.0f} ± {sd:4.0f}{straight:>17s}{against(published, uv, xyz)}"
    )


def levels(uv: Floats, xyz: Floats) -> float:
    """Straightness of the rows and columns on each level of a target, px RMS."""
    each = [(at.sum(), straightness(uv[at], xyz[at, :2])) for at in (xyz[:, 2] == z for z in np.unique(xyz[:, 2]))]
    n, off = np.array([row for row in each if np.isfinite(row[1])]).T
    return float(np.sqrt((n * off**2).sum() / n.sum()))


def against(published: Path | None, uv: Floats, xyz: Floats) -> str:
    """Residual, px RMS, and focal length, px, of the published calibration with the pixel pitch that suits it best."""
    if not published:
        return ""
    plane, f = openptv(published, xyz)
    y = uv - 511.5
    scale = float((plane * y).sum() / (plane**2).sum())
    return f"{rms(y - scale * plane):10.3f}{f * scale:8.0f}"


def rms(off: Floats) -> float:
    return float(np.sqrt((off**2).sum(1).mean()))


def skewed(L: Floats) -> float:
    """How far the axes of the pixels, as the DLT has them, are off a right angle, deg."""
    across, down = (np.cross(row, from_dlt(L)[2, :3]) for row in from_dlt(L)[:2, :3])
    return float(abs(90 - np.degrees(np.arccos(across @ down / np.linalg.norm(across) / np.linalg.norm(down)))))


def openptv(orientation: Path, xyz: Floats) -> tuple[Floats, float]:
    """Points (N, 3) mm on the sensor (N, 2), from its middle to the right and down, and the focal length, all mm.

    OpenPTV's file has the camera's place, three angles, the rotation, the principal point and the focal length.
    """
    v = np.array(orientation.read_text(encoding="utf-8").split(), np.float64)
    q = (xyz - v[:3]) @ v[6:15].reshape(3, 3)
    plane = (v[15:17] - v[17] * q[:, :2] / q[:, 2:]) * [1.0, -1.0]
    return plane, float(v[17])


def drawn(image: NDArray[np.uint8], uv: Floats) -> NDArray[np.uint8]:
    """The picture, dimmed, with a bright path through the points in order."""
    canvas = (image // 2).astype(np.uint8)
    path = uv[np.isfinite(uv).all(1)]
    for a, b in pairwise(path):
        line = np.rint(a + np.linspace(0, 1, 200)[:, None] * (b - a)).astype(int)
        line = line[((line >= 0) & (line < image.shape[::-1])).all(1)]
        canvas[line[:, 1], line[:, 0]] = 255
    return canvas


def svg(view: GridView, lens: Camera) -> str:
    """The grid's rows and columns as seen and as straightened, each with the straight line between its ends."""
    parts = []
    for k, (uv, words) in enumerate(((view.uv, "as seen"), (undistort(lens, view.uv), "straightened"))):
        shift = np.array([k * (SIZE[0] + 40) + SIZE[0] / 2, SIZE[1] / 2 + 50])
        at = (uv - uv.mean(0)) * (0.9 * SIZE[0] / np.ptp(uv[:, 0])) + shift
        for axis in (0, 1):
            for level in np.unique(view.xy[:, axis]):
                line = at[view.xy[:, axis] == level]
                parts.append(path(line[[0, -1]], "#d33"))
                parts.append(path(line, "#247"))
        parts += [f'<circle cx="{u:.1f}" cy="{v:.1f}" r="4" fill="#247"/>' for u, v in at]
        off = straightness(uv, view.xy)
        parts.append(
            f'<text x="{shift[0]:.0f}" y="36" text-anchor="middle">{words}: {off:.3f} px RMS off straight</text>'
        )
    frame = f'viewBox="0 0 {2 * SIZE[0] + 40} {SIZE[1] + 60}" font-family="sans-serif" font-size="36"'
    ground = '<rect width="100%" height="100%" fill="white"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {frame}>{ground}{"".join(parts)}</svg>\n'


def path(points: Floats, colour: str) -> str:
    places = " ".join(f"{u:.1f},{v:.1f}" for u, v in points)
    return f'<polyline points="{places}" fill="none" stroke="{colour}" stroke-width="2"/>'


def main(pictures: Path | None = None, figure: Path | None = None) -> None:
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    linearised_dlt(grids(pictures, figure))
    if not (FOLDER / "cameras/chessboard_left").exists():
        print("\nThe real pictures are absent. Name the folder of the recordings in KINEMARK_DATA.")
        return
    chessboards(recording("cameras/chessboard_left"), pictures)
    dot_targets()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Linearising cameras.")
    parser.add_argument("--pictures", type=Path)
    parser.add_argument("--figure", type=Path)
    main(**vars(parser.parse_args()))
