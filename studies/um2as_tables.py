"""Chapter 4 of the UM²AS thesis line by line: the bound of eq. 4.7, tables 4.1 and 4.2, and its 12.5 and 25 px.

    python studies/um2as_tables.py [draws, 2000]

In the laboratory that `um2as_experiment` puts together from what the thesis prints: eight control balls,
three cameras 2.4 m from where their axes meet. All columns headed "quoted" are from Giles (1994), chapter 4; all
others are computed here. Centroids of balls and markers are off by 0.5 px in random directions, which is the thesis'
bound of what lens and quantisation leave; control balls are measured by tape to 1 mm.

Table 4.1 measures six distances of four markers. The markers here have the distances that were measured, in random
places and attitudes, and the distances are calculated as the thesis does, from pairs of cameras and by its rule.
"""

from __future__ import annotations

import sys
from itertools import combinations
from typing import NamedTuple

import numpy as np
from um2as_bound import first_order_bound, parameter_bound
from um2as_equations import fit_parameters, pair_points, project, rows
from um2as_experiment import (
    CALIBRATION_PX,
    DISTANCE_MM,
    FOCAL_PX,
    MARKER_PX,
    PER_MM,
    PERTURBED_4_2,
    SIZE,
    TABLE_4_2,
    LinearisedErrors,
    calibration_experiment,
    laboratory,
    pairs_mean,
)
from um2as_sampling import Sampling, circle

from kinemark.data.array_types import Floats

TABLE_4_1 = {(4, 1): (30.5, -1.18), (4, 2): (31.1, -1.07), (4, 3): (30.2, -1.14),
             (1, 2): (30.4, -0.39), (1, 3): (30.5, -0.49), (2, 3): (30.3, -1.11)}  # fmt: skip
"""Measured distances, cm, of pairs of markers, and their relative errors as printed, %; of the thesis."""
TAPE_MM = 1.0  # "to an accuracy of plus or minus 1mm"; of the thesis, chapter IV
BALL_MM = 34.0  # diameter of a ping-pong ball; of the thesis, 2.2
SPACE_MM = 1000.0  # side of the viewing space; of the thesis, 2.3.1
BALL_PX = 25.0  # diameter of the nearest marker's image; of the thesis, 4.2


def bounds(lab: LinearisedErrors) -> None:
    printed = LinearisedErrors.of_parameters(TABLE_4_2)
    cameras = [("table 4.2", printed, 0), *((f"camera {c + 1}", lab, c) for c in range(3))]
    print(f"The analytic bound (eq. 4.7) and its condition κ < 1 (eq. 4.8), control balls off by {CALIBRATION_PX} px")
    print(f"{'':12}{'κ, cm':>8}{'κ, mm':>8}{'κ, columns of unit length':>27}{'bound %':>9}{'possible %':>12}", end="")
    print(f"{'first order, % by (4.11)':>27}{'possible %':>12}")
    for name, camera, c in cameras:
        points, uv = camera.points, camera.uv[c]
        cm, mm = (parameter_bound(points / unit, uv, CALIBRATION_PX) for unit in (10.0, 1.0))
        unit = parameter_bound(points, uv, CALIBRATION_PX, unit_columns=True)
        found = calibration_experiment(camera, c, method=Sampling(samples=20_000)).max_percent
        print(f"{name:12}{cm.kappa:8.0f}{mm.kappa:8.0f}{unit.kappa:27.4f}{unit.percent:9.2f}", end="")
        print(
            f"{possible_of_unit_columns(camera, c):12.2f}{first_order_bound(points, uv, CALIBRATION_PX):27.3f}", end=""
        )
        print(f"{found:12.3f}")
    print("quoted      “this condition was not met by the perturbed matrices”")


def possible_of_unit_columns(camera: LinearisedErrors, c: int) -> float:
    """Percent; the largest error of 20 000 samples of the parameters, each times the length of its column of A."""
    size = np.linalg.norm(rows(camera.points, camera.uv[c]).reshape(-1, 11), axis=0)
    theta = np.random.default_rng(0).uniform(0, 2 * np.pi, (20_000, len(camera.points)))
    moved = fit_parameters(camera.points, camera.uv[c] + circle(theta, CALIBRATION_PX))
    off = np.linalg.norm((moved - camera.L[c]) * size, axis=1)
    return float(100 * off.max() / np.linalg.norm(camera.L[c] * size))


def table_4_2() -> None:
    camera = LinearisedErrors.of_parameters(TABLE_4_2)
    changed = calibration_experiment(camera, 0, method=Sampling(samples=200_000))
    sampled = fit_parameters(camera.points, camera.uv[0] + circle(changed.sampled.largest, CALIBRATION_PX))
    print("\nTable 4.2, by parameter (px and cm): the thesis' worst case of 10⁶ (quoted), ours of 2·10⁵, ours possible")
    print(f"{'':4}{'actual':>14}{'quoted':>14}{'%':>8}{'sampled':>14}{'%':>8}{'possible':>14}{'%':>8}")
    for k, (actual, *others) in enumerate(
        zip(*((TABLE_4_2, PERTURBED_4_2, sampled, changed.max_L) / PER_MM), strict=True)
    ):
        cells = "".join(f"{x:14.7f}{100 * abs(x / actual - 1):8.2f}" for x in others)
        print(f"L{k + 1:<3}{actual:14.7f}{cells}")
    whole = [
        100 * np.linalg.norm(x - TABLE_4_2) / np.linalg.norm(TABLE_4_2) for x in (PERTURBED_4_2, sampled, changed.max_L)
    ]
    print(f"{'(4.11)':18}" + "".join(f"{'':14}{x:8.2f}" for x in whole))


def placed(measured: Floats) -> Floats:
    """(4, 3) places of markers 1 to 4 with these distances (4, 4), about their middle."""
    centred = np.eye(4) - 0.25
    value, vector = np.linalg.eigh(-0.5 * centred @ measured**2 @ centred)
    return vector[:, 1:] * np.sqrt(value[1:])


class Cause(NamedTuple):
    """What is wrong: px of balls and of markers, mm of the tape, px that the lens moves the image's edge outwards."""

    balls: float = 0.0
    tape: float = 0.0
    markers: float = 0.0
    lens: float = 0.0


CAUSES = {
    "markers off by 0.5 px": Cause(markers=0.5),
    "balls off by 0.5 px": Cause(balls=0.5),
    "balls measured to 1 mm": Cause(tape=TAPE_MM),
    "all three": Cause(0.5, TAPE_MM, 0.5),
    "lens, 5 px at the edge": Cause(lens=5.0),
    "lens, -5 px at the edge": Cause(lens=-5.0),
    "lens, -10 px at the edge": Cause(lens=-10.0),
    "all four, lens -10 px": Cause(0.5, TAPE_MM, 0.5, -10.0),
}
RULE = "rule of 2.8"


def distances(lab: LinearisedErrors, draws: int) -> None:
    found = {name: draw(lab, cause, draws) for name, cause in CAUSES.items()}
    print(
        f"\nTable 4.1: relative errors of six distances, %, {draws} draws; measured less calculated, as in the thesis"
    )
    ways = list(found["all three"])
    print(
        f"  all three causes{'':10}quoted" + "".join(f"{way:>16}" for way in ways) + "   (standard deviation, largest)"
    )
    for p, ((i, j), (_, printed)) in enumerate(TABLE_4_1.items()):
        cells = "".join(f"{e[:, p].std():8.2f}{np.abs(e[:, p]).max():8.2f}" for e in found["all three"].values())
        print(f"  {i} - {j}{'':20}{printed:7.2f}{cells}")
    print(f"\n  {'standard deviation of a distance, %':38}" + "".join(f"{way:>14}" for way in ways), end="")
    print("   by the rule: mean |error|, mean error, of one sign, as in the thesis")
    for name, errors in found.items():
        rule = errors[RULE]
        alike, mean = (np.sign(rule) == np.sign(rule[:, :1])).all(1), np.abs(rule).mean(1)
        worse = 100 * (alike & (mean >= 0.90)).mean()
        print(f"  {name:38}" + "".join(f"{each.std():14.2f}" for each in errors.values()), end="")
        print(f"{mean.mean():26.2f}{rule.mean():12.2f}{100 * alike.mean():10.0f} %{worse:12.1f} %")
    print(f"  {'quoted':38}{'':56}{0.90:26.2f}{-0.90:12.2f}{'all six':>12}")
    print(WHY)


def draw(lab: LinearisedErrors, cause: Cause, draws: int) -> dict[str, Floats]:
    """Way → (draws, 6) percent, measured less calculated by measured."""
    measured = np.zeros((4, 4))
    for (a, b), (true_cm, _) in TABLE_4_1.items():
        measured[a - 1, b - 1] = measured[b - 1, a - 1] = 10 * true_cm
    four, rng, middle = placed(measured), np.random.default_rng(0), (lab.points.min(0) + lab.points.max(0)) / 2
    i, j = np.array(list(TABLE_4_1)).T - 1
    names = [*(f"cameras {a + 1}, {b + 1}" for a, b in combinations(range(3), 2)), RULE]
    error: dict[str, list[Floats]] = {name: [] for name in names}
    for _ in range(draws):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        xyz = middle + rng.uniform(-200, 200, 3) + four @ turn.T
        seen = np.stack([project(each, xyz) for each in lab.L], 1)
        L = calibrated(lab, cause, rng)
        seen = through(seen, cause.lens) + circle(rng.uniform(0, 2 * np.pi, seen.shape[:2]), cause.markers)
        each = np.concatenate([pair_points(L, seen), pairs_mean(L, seen)[:, None]], 1)
        for k, name in enumerate(names):
            error[name].append(100 * (1 - np.linalg.norm(each[i, k] - each[j, k], axis=1) / measured[i, j]))
    return {name: np.array(rows) for name, rows in error.items()}


def calibrated(lab: LinearisedErrors, cause: Cause, rng: np.random.Generator) -> Floats:
    """(3, 11) parameters from control balls that are off."""
    taped = lab.points + rng.uniform(-cause.tape, cause.tape, lab.points.shape)
    moved = through(lab.uv, cause.lens) + circle(rng.uniform(0, 2 * np.pi, lab.uv.shape[:2]), cause.balls)
    return np.stack([fit_parameters(taped, uv) for uv in moved])


def through(uv: Floats, lens: float) -> Floats:
    """Images (…, 2) px that a lens moves outwards with the cube of their radius, `lens` px at the edge."""
    half = SIZE[0] / 2
    out = uv - (half - 0.5)
    return np.asarray(uv + lens * out * (np.hypot(*np.moveaxis(out, -1, 0))[..., None] ** 2) / half**3)


WHY = """
  The thesis takes table 4.1 for the 0.5 px that lens and quantisation leave. Such errors make a quarter of it, and of
  either sign. A barrel distortion of some 10 px at the image's edge makes all of it, with its sign; the bar of section
  4.1 does not show one, as it turns about the image's middle, where a lens changes a length alike in all attitudes."""


def nearest_marker() -> None:
    near = DISTANCE_MM - SPACE_MM / 2
    print(f"\nA marker of {BALL_MM:g} mm at the near face of the viewing space, {near:g} mm from the camera")
    for name, focal in (("across", FOCAL_PX[0]), ("down", FOCAL_PX[1])):
        print(
            f"  {name}: {BALL_MM * focal / near:.1f} px; {BALL_PX:g} px (quoted) at {BALL_MM * focal / BALL_PX:.0f} mm"
        )
    edge = [SIZE[k] * near / FOCAL_PX[k] for k in range(2)]
    print(f"  the image is {edge[0]:.0f} × {edge[1]:.0f} mm there, and {SIZE[0] * DISTANCE_MM / FOCAL_PX[0]:.0f} × "
          f"{SIZE[1] * DISTANCE_MM / FOCAL_PX[1]:.0f} mm in the middle")  # fmt: skip
    print(f"Centroid of what is left of a disc of {BALL_PX:g} px behind a straight edge: px off its centre")
    hidden = np.array([0.1, 0.25, 0.5, 0.75, 0.9, 0.99, 0.999])
    print("  share of the area hidden " + "".join(f"{100 * h:8.1f} %" for h in hidden) + f"     → {BALL_PX / 2:g} px")
    print("  px                       " + "".join(f"{segment_offset(h) * BALL_PX / 2:10.2f}" for h in hidden))
    print(
        f"With {CALIBRATION_PX} px of lens and quantisation {BALL_PX / 2 + CALIBRATION_PX:g} px (quoted: {MARKER_PX:g})"
    )


def segment_offset(hidden: float) -> float:
    """Distance of a unit disc's centre from the centroid of what a straight edge leaves, for this share hidden."""
    half = np.linspace(0, np.pi, 20_001)  # of the segment's arc; its area is half − sin half cos half
    share = (half - np.sin(half) * np.cos(half)) / np.pi
    angle = np.interp(1 - hidden, share, half)
    return float(2 / 3 * np.sin(angle) ** 3 / (angle - np.sin(angle) * np.cos(angle)))


def main() -> None:
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    lab = laboratory()
    bounds(lab)
    table_4_2()
    distances(lab, draws)
    nearest_marker()


if __name__ == "__main__":
    main()
