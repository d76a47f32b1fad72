"""How errors of centroids travel: chapter 4 of the UM²AS thesis again, its chain to joint angles, and a real trial.

    python studies/um2as_sensitivity.py [--samples 1000000] [--figure FILE.svg]

Three parts. The thesis' experiment in a laboratory put together from what it prints; what the same noise makes of an
arm's joint angles, to first order and by simulation; and what limits a recorded gait trial, from its stored tracks.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from um2as_equations import fit_parameters
from um2as_equations import project as project_dlt
from um2as_experiment import (
    CALIBRATION_PX,
    MARKER_PX,
    PERTURBED_4_2,
    TABLE_4_2,
    LinearisedErrors,
    Moved,
    calibration_experiment,
    laboratory,
    linear_points,
    marker,
    marker_error,
    marker_experiment,
    pairs_mean,
)
from um2as_sampling import Sampling, sample

from kinemark.data import Detections, KinemarkError, Rig, Trajectories
from kinemark.data.array_types import Floats
from kinemark.findings.sensitivity_figures import sensitivity_figures
from kinemark.geometry import project
from kinemark.io.model_toml import load_model
from kinemark.io.tdf import read_tdf
from kinemark.report.terminal_summary import sensitivity_summary
from kinemark.report.theme import FAINT, HUES, INK
from kinemark.sensitivity import (
    Kinematics,
    SampledFrames,
    angle_jacobian,
    angle_spread,
    cycle_weights,
    mean_spread,
    placed_points,
    rank,
)
from kinemark.sensitivity.joints import kinematics_of
from kinemark.synth import arm

DATA = Path(os.environ.get("KINEMARK_DATA", Path(__file__).parents[2] / "shared" / "data"))


def thesis(samples: int, picture: Path | None) -> None:
    lab, method = laboratory(), Sampling(samples=samples)
    printed = 100 * np.linalg.norm(PERTURBED_4_2 - TABLE_4_2) / np.linalg.norm(TABLE_4_2)
    print(f"table 4.2 of the thesis by its equation 4.11: {printed:.2f} % (quoted: 0.70)")
    print(f"\ncontrol balls moved by R: percent error of the eleven parameters (4.11), {samples} samples")
    print("  R px  camera    median   95 %   max, sampled    max possible")
    largest = [parameters(lab, c, radius, method) for radius in (0.5, 1.0, 1.5, 2.0) for c in range(3)][:3]
    parameters(LinearisedErrors.of_parameters(TABLE_4_2), 0, CALIBRATION_PX, method, name="table 4.2")
    half = Sampling(samples=samples, turn=np.pi)
    for c in range(3):
        parameters(lab, c, CALIBRATION_PX, half, name=f"{c + 1}, 0–180°")
    place = marker(lab)
    print(f"\na marker moved by R in every image: mm, and percent of |X| = {np.linalg.norm(place):.0f} mm (4.12)")
    print("  R px   parameters            median mm  95 % mm  max, sampled        max possible      s")
    for radius in (3.0, 4.0, 7.0, 12.9):
        moved(lab, place, "right", radius, method)
    right = moved(lab, place, "right", MARKER_PX, method)
    moved(lab, place, "largest of part one", MARKER_PX, method, L=np.array(largest))
    anew = moved(lab, place, "wrong by 0.5 px, anew", MARKER_PX, method, calibration_radius=CALIBRATION_PX)
    print(
        "  the thesis, quoted                                   32.8 mm, 4.56 %; with wrong parameters 33.2 mm, 4.62 %"
    )
    workers(lab, place, method)
    if picture is not None:
        changed = [calibration_experiment(lab, c, method=method).percent for c in range(3)]
        picture.write_text(drawing(changed, right.mm, anew.mm), encoding="utf-8")


def parameters(lab: LinearisedErrors, c: int, radius: float, method: Sampling, *, name: str = "") -> Floats:
    """Prints a row; the parameters (11) of the greatest error possible."""
    found = calibration_experiment(lab, c, radius=radius, method=method)
    print(
        f"  {radius:4.1f}  {name or c + 1!s:9s} {np.median(found.percent):6.3f} "
        f"{np.quantile(found.percent, 0.95):6.3f} {found.percent.max():14.3f} {found.max_percent:15.3f}"
    )
    return found.max_L


def moved(
    lab: LinearisedErrors,
    place: Floats,
    name: str,
    radius: float,
    method: Sampling,
    *,
    L: Floats | None = None,
    calibration_radius: float = 0.0,
) -> Moved:
    began = time.perf_counter()
    found = marker_experiment(lab, place, radius=radius, L=L, calibration_radius=calibration_radius, method=method)
    print(
        f"  {radius:4.1f}   {name:21s} {np.median(found.mm):9.2f} {np.quantile(found.mm, 0.95):8.2f} "
        f"{found.mm.max():7.2f} mm {found.percent.max():.2f} % {found.max_mm:8.2f} mm {found.max_percent:.2f} % "
        f"{time.perf_counter() - began:6.1f}"
    )
    return found


def workers(lab: LinearisedErrors, place: Floats, method: Sampling) -> None:
    """One and two workers give the same samples."""
    error = marker_error(lab, place, MARKER_PX)
    few = {n: Sampling(samples=min(method.samples, 200_000), workers=n) for n in (1, 2)}
    found = {}
    for n, each in few.items():
        began = time.perf_counter()
        found[n] = sample(error, 3, each).error
        print(
            f"  {n} worker{'s' if n > 1 else ' '}: "
            f"{1e6 * (time.perf_counter() - began) / len(found[n]):.2f} s a million"
        )
    print(f"  the same samples: {np.array_equal(found[1], found[2])}")


PANEL = (430, 250)
"""Width and height of the axes of a panel, px."""


def drawing(changed: Sequence[Floats], right: Floats, anew: Floats) -> str:
    """Both distributions as SVG: percent of the parameters, camera by camera, and mm of the marker."""
    cameras = {f"camera {c + 1}": (percent, HUES[c]) for c, percent in enumerate(changed)}
    marks = {"right parameters": (right, HUES[0]), "wrong by 0.5 px, anew": (anew, HUES[1])}
    left = panel(cameras, 0.8, 0.1, "error of the eleven parameters (%), balls off by 0.5 px", 0.70)
    other = panel(marks, 36.0, 6.0, "distance that the marker moves (mm), centroids off by 13 px", 32.8)
    width, height = 2 * (PANEL[0] + 60), PANEL[1] + 80
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
        f'font-size="13"><rect width="{width}" height="{height}" fill="white"/>'
        f'<g transform="translate(30 30)">{left}</g>'
        f'<g transform="translate({PANEL[0] + 90} 30)">{other}</g></svg>\n'
    )


def panel(named: dict[str, tuple[Floats, str]], top: float, step: float, title: str, thesis_max: float) -> str:
    """Histograms as lines over 0 … top, with the thesis' maximum as a dotted one."""
    width, height = PANEL
    edges = np.linspace(0, top, 121)
    shares = {name: np.histogram(values, edges)[0] / len(values) for name, (values, _) in named.items()}
    high = 1.08 * max(float(share.max()) for share in shares.values())
    x = (edges[:-1] + edges[1:]) / 2 * width / top
    peak = int(sum(shares.values(), np.zeros(120)).argmax())
    clear = 6 if peak > 60 else width * 0.6  # names stand on the side where nothing is drawn
    parts = [f'<path d="M0 {height}H{width}" stroke="{FAINT}"/>']
    for i, (name, (_, colour)) in enumerate(named.items()):
        line = "L".join(f"{a:.1f} {height * (1 - b / high):.1f}" for a, b in zip(x, shares[name], strict=True))
        parts.append(f'<path d="M{line}" fill="none" stroke="{colour}" stroke-width="2"/>')
        parts.append(f'<text x="{clear}" y="{32 + 18 * i}" fill="{colour}">{name}</text>')
    at = thesis_max * width / top
    parts.append(f'<path d="M{at:.1f} 0V{height}" stroke="{FAINT}" stroke-dasharray="2 4"/>')
    parts.append(f'<text x="{at - 5:.1f}" y="12" fill="{FAINT}" text-anchor="end">maximum of the thesis</text>')
    for tick in np.arange(0, top + step / 2, step):
        place = tick * width / top
        parts.append(f'<text x="{place:.1f}" y="{height + 18}" fill="{INK}" text-anchor="middle">{tick:.3g}</text>')
    parts.append(f'<text x="{width / 2}" y="{height + 40}" fill="{INK}" text-anchor="middle">{title}</text>')
    return "".join(parts)


def arm_angles(simulations: int = 400, centroid_sd: float = 0.3, calibration_sd: float = 0.25) -> None:
    """Centroid → calibration → point → joint angle → mean over two cycles: predicted, and as simulated."""
    lab, body = laboratory(), arm("feeding", rate=8 / 3, duration_s=6.4, shoulder=(350, 300, 600), unsteady_deg=0.5)
    names, angles = kinematics_of(load_model("um2as"), body.names)
    jacobian = angle_jacobian(angles, body.xyz)
    points = linear_points(lab, body.xyz, centroid_sd=centroid_sd, calibration_sd=calibration_sd)
    each = angle_spread(points, jacobian)
    W = cycle_weights([0, 8, 16], body.xyz.shape[1], points=9)
    mean = mean_spread(each, W)
    placed = angle_spread(placed_points(body.xyz.shape[:2], placement_sd=5.0), jacobian)
    turned = simulated_arm(lab, body.xyz, angles, simulations, centroid_sd, calibration_sd)
    averaged = np.einsum("pf,nfa->npa", W, turned)
    print(
        f"\njoint angles of an arm that eats, centroids {centroid_sd} px, control balls {calibration_sd} px; sd in deg"
    )
    print("  angle                       a frame: predicted, simulated; mean of 2: predicted, simulated; placed ± 5 mm")
    for a, name in enumerate(names):
        cov = each.cov[:, a, 0, 0], mean.cov[:, a, 0, 0], placed.cov[:, a, 0, 0]
        first, second, third = (float(np.sqrt(part.mean())) for part in cov)
        found = [float(np.sqrt(part[..., a].var(0).mean())) for part in (turned, averaged)]
        print(f"  {name:46s} {first:8.3f} {found[0]:9.3f} {second:9.3f} {found[1]:9.3f} {third:9.2f}")


def simulated_arm(
    lab: LinearisedErrors, xyz: Floats, angles: Kinematics, n: int, centroid_sd: float, calibration_sd: float
) -> Floats:
    """(n, F, A) deg: angles measured with n calibrations, each of all frames."""
    rng, flat = np.random.default_rng(0), xyz.reshape(-1, 3)
    balls = lab.uv + calibration_sd * rng.standard_normal((n, *lab.uv.shape))
    L = np.stack([fit_parameters(lab.points, balls[:, c]) for c in range(len(lab.L))], 1)
    seen = np.stack([project_dlt(each, flat) for each in lab.L], 1)
    uv = seen + centroid_sd * rng.standard_normal((n, *seen.shape))
    found = pairs_mean(np.repeat(L, len(flat), 0), uv.reshape(-1, *seen.shape[1:])).reshape(n, *xyz.shape)
    all_frames = found.transpose(1, 0, 2, 3).reshape(len(xyz), -1, 3)
    return angles(all_frames).reshape(n, xyz.shape[1], -1)


def recorded_gait(path: Path) -> None:
    """What limits a clinical trial, from the tracks that the system itself stored."""
    tdf = read_tdf(path)
    if tdf.rig is None or tdf.detections is None or tdf.trajectories is None:
        raise KinemarkError(f"{path} lacks cameras, 2D points or tracks. Export the trial with all of them.")
    there = stored(tdf.rig, tdf.detections.select(tdf.rig.names), tdf.trajectories)
    ranking = rank(tdf.rig, there)
    figures = sensitivity_figures(ranking, session="gait9_bts", trial="stored tracks")
    print(f"\n{sensitivity_summary(figures)}")


def stored(
    rig: Rig, detections: Detections, trajectories: Trajectories, *, frames: int = 400, reach: float = 2.0
) -> SampledFrames:
    """Stored tracks with the detections nearest to where each camera must see them."""
    xyz_all = trajectories.xyz
    at = np.unique(np.linspace(0, xyz_all.shape[1] - 1, frames).round().astype(np.int64))
    xyz = xyz_all[:, at]
    uv = np.full((*xyz.shape[:2], len(rig), 2), np.nan)
    for c, camera in enumerate(rig):
        for i, f in enumerate(at):
            seen = detections[c, f]
            if not len(seen):
                continue
            away = np.linalg.norm(project(camera, xyz[:, i])[:, None] - seen, axis=2)
            near = np.nan_to_num(away, nan=np.inf)
            own = near.min(1) < reach
            uv[own, i, c] = seen[near.argmin(1)[own]]
    return SampledFrames(trajectories.names, xyz, uv, at / trajectories.rate)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=1_000_000)
    parser.add_argument("--figure", type=Path, help="an SVG file to draw both distributions in")
    given = parser.parse_args()
    thesis(given.samples, given.figure)
    arm_angles()
    gait = DATA / "cameras" / "gait9_bts" / "gait9.tdf"
    if gait.is_file():
        recorded_gait(gait)


if __name__ == "__main__":
    main()
