"""The accuracy tests of the papers, for four ways to calibrate, side by side with the papers' own figures.

In simulation: six cameras 1280 × 1024 with a lens of k1 = −0.12 about a volume of 1.4 × 2.4 × 2 m; centroids off by
0.1 px, control points surveyed to 0.5 mm along each axis. These are today's cameras and not KISS's, whose fields
`accuracy_kiss.py` takes. The calibrations are

    DLT          eleven parameters, no lens
    linearised   the lens from views of a grid, then the DLT and least squares (KISS 3.2)
    lens terms   the DLT and least squares with k1, from the same 24 control points
    wand         400 poses of a wand with two markers, from the image sizes alone; its world from the control points

and the tests

    static       the reference markers of the control frame, as reconstructed (KISS 3.3)
    stick        502.5 mm long, moved through the volume for 4 s, 200 samples (KISS 5.1)
    thrown       parabolas through the path of a thrown marker, mean of three throws (KISS 5.1)
    under water  the same stick, lenses of k1 = 0.25, k2 = 0.1 (Silvatti et al. 2012: nonlinear DLT 6.2 mm, wand 1.2 mm)
    walk         the markers of a walking person in images without noise: what the calibration alone is off
    distances    four markers, three cameras, eight control balls (UM²AS table 4.1)

Standard deviations that the covariances predict stand below those that were measured. Components of the throw are root
mean squares over the rounds, which have no sign. The column "quoted" is of the papers, or of the best open program.

On real files: the wands and the thrown object of easyWand, by easyWand's own calibration and by ours.

Run: python studies/accuracy.py [rounds] [simulation | files]
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from recordings import recording
from scipy.spatial.transform import Rotation
from scipy.stats import t as student

from kinemark.calibrate import ControlPoints, calibrate_control_points
from kinemark.calibrate.bundle import Bundle, BundleFit, FreePoints, bundle, calibrate_points, sticks_through
from kinemark.calibrate.control_points.fit_camera import Dlt
from kinemark.calibrate.lens.linearisation import GridView, Linearisation, linearise
from kinemark.calibrate.wand import KNOWN_LENS, calibrate_wand, wand_lengths
from kinemark.calibrate.world_frame import fit_moved_to, fit_scaled
from kinemark.data import Camera, KinemarkError, Rig
from kinemark.data.array_types import Floats, Ints
from kinemark.geometry import from_dlt, project_all, refine, rigid_align, triangulate, undistort
from kinemark.io.easywand import EasyWand, read_easywand
from kinemark.synth import calibration_box, control_frame, observe, ring, thrown_ball, walking, wand

LENS = (-0.12, 0.0, 0.0, 0.0, 0.0)
NOISE = (0.1, 0.1)
"""px along u and v."""
SURVEY = 0.5
STICK = 502.5
GRAVITY = 9.80665
FIELD = 2400.0
WAYS = ("DLT", "linearised", "lens terms", "wand")


Noise = tuple[float, float]
"""Standard deviations along u and v, px."""


class Calibrated(NamedTuple):
    """A rig, and the joint covariance of its parameters where there is one."""

    rig: Rig
    joint: Floats | None = None


class Row(NamedTuple):
    """A line of the table: what, the paper's figure, and one figure a calibration."""

    what: str
    paper: str
    figures: dict[str, float]


def seen(rig: Rig, xyz: Floats, rng: np.random.Generator, noise: Noise = NOISE) -> Floats:
    """(C, N, 2) px of points (N, 3), NaN outside the images."""
    uv = project_all(rig, xyz) + rng.normal(0.0, noise, (len(rig), len(xyz), 2))
    sizes = np.array([camera.size for camera in rig])[:, None]
    return np.where(((uv > 0) & (uv < sizes - 1)).all(-1, keepdims=True), uv, np.nan)


def linearised(rig: Rig, rng: np.random.Generator, noise: Noise = NOISE) -> list[Camera]:
    """The lens of every camera from four close views of a grid of 15 × 20 points, turned this way and that."""
    row, column = np.mgrid[:15, :20].reshape(2, -1)
    xy = 50.0 * np.column_stack([column - 9.5, row - 7.0])
    lenses = []
    for camera in rig:
        views = []
        for turn in ((25, 0), (-25, 10), (0, 25), (10, -25)):
            turned = Rotation.from_euler("xy", turn, degrees=True).as_matrix()[:, :2]
            world = (xy @ turned.T + [0.0, 0.0, 1250.0] - camera.t) @ camera.R
            uv = seen(Rig((camera,)), world, rng, noise)[0]
            there = np.isfinite(uv).all(1)
            cov = np.tile(np.diag(np.square(noise)), (int(there.sum()), 1, 1))
            views.append(GridView(uv[there], xy[there], cov))
        lenses.append(linearise(camera.name, camera.size, views, method=Linearisation(2, False)).camera)
    return lenses


def calibrations(
    rig: Rig,
    known: Floats,
    rng: np.random.Generator,
    seed: int,
    ways: Sequence[str] = WAYS,
    *,
    poses: int = 400,
    noise: Noise = NOISE,
) -> dict[str, Calibrated]:
    """The rig calibrated in each of the ways, from control points known (N, 3), mm, to `SURVEY`, and a wand."""
    sizes = np.array([camera.size for camera in rig])
    surveyed = known + rng.normal(0.0, SURVEY, known.shape)
    uv = seen(rig, known, rng, noise)

    def points(method: Dlt | ControlPoints, lenses: Sequence[Camera] | None = None) -> Calibrated:
        return Calibrated(calibrate_control_points(rig.names, sizes, surveyed, uv, method=method, lenses=lenses))

    def waved() -> Calibrated:
        mean = float(np.sqrt(np.mean(np.square(noise))))
        subject = wand((0.0, 500.0), duration_s=poses / 25, rate=25.0, seed=seed, volume=rig.volume)
        observed = observe(rig, subject, noise_px=mean, false_per_frame=0.05, dropout=0.02, seed=seed)
        fit = calibrate_wand(observed.detections, lengths=[500.0], sizes=sizes)
        fit = fit_moved_to(fit, reconstructed(Calibrated(fit.rig), uv), surveyed)
        return Calibrated(fit.rig, fit.joint)

    make: dict[str, Callable[[], Calibrated]] = {
        "DLT": lambda: points(Dlt()),
        "linearised": lambda: points(ControlPoints(), linearised(rig, rng, noise)),
        "lens terms": lambda: points(ControlPoints(radial=1)),
        "wand": waved,
    }
    return {way: make[way]() for way in ways}


def reconstructed(calibrated: Calibrated, uv: Floats, noise: Noise = NOISE) -> Floats:
    """(N, 3) mm from uv (C, N, 2) px."""
    rig = calibrated.rig
    ideal = np.stack([undistort(camera, x) for camera, x in zip(rig, uv, strict=True)], 1)
    alike = np.broadcast_to(np.diag(np.square(noise)), (*ideal.shape, 2))
    return refine(rig, triangulate(ideal, rig.P), uv.transpose(1, 0, 2), alike).xyz


def static(
    ways: dict[str, Calibrated], rig: Rig, known: Floats, rng: np.random.Generator, noise: Noise = NOISE
) -> list[Row]:
    """The reference markers, and places between them that no calibration saw."""
    inside = rig.volume[0] + (0.1 + 0.8 * rng.random((200, 3))) * (rig.volume[1] - rig.volume[0])
    rows = []
    for what, paper, xyz in (("reference markers", "0.6", known), ("other places", "", inside)):
        uv = seen(rig, xyz, rng, noise)
        off = {way: reconstructed(cal, uv, noise) - xyz for way, cal in ways.items()}
        rows.append(Row(f"static: {what}, mean error, mm", paper, {w: _mean_norm(d) for w, d in off.items()}))
    return rows


def _mean_norm(off: Floats) -> float:
    return float(np.nanmean(np.linalg.norm(off, axis=1)))


def stick(
    ways: dict[str, Calibrated], rig: Rig, rng: np.random.Generator, seed: int, noise: Noise = NOISE
) -> list[Row]:
    """Errors of the length of the moving stick."""
    moved = wand((0.0, STICK), duration_s=4.0, rate=50.0, seed=seed, volume=rig.volume)
    uv = seen(rig, moved.xyz.reshape(-1, 3), rng, noise).reshape(len(rig), 2, -1, 2).transpose(0, 2, 1, 3)
    cov = np.broadcast_to(np.diag(np.square(noise)), (*uv.shape, 2))
    came = {way: wand_lengths(cal.rig, uv, along=[0.0, STICK], cov=cov, joint=cal.joint) for way, cal in ways.items()}
    error = {way: c.error[np.isfinite(c.error)] for way, c in came.items()}
    mean = {way: float(np.abs(e).mean()) for way, e in error.items()}
    sd = {way: float(e.std(ddof=1)) for way, e in error.items()}
    root = {way: float(np.sqrt(np.mean(e**2))) for way, e in error.items()}
    expected = {way: float(np.sqrt(np.nanmean(came[way].sd ** 2))) for way in came}
    return [
        Row("stick: mean absolute error, mm", "1.1", mean),
        Row("stick: standard deviation, mm", "1.5", sd),
        Row("stick: RMS error, mm", "", root),
        Row("stick: RMS error predicted, mm", "", expected),
        Row("stick: resolution, mm", "0.3", {way: resolution(e) for way, e in error.items()}),
        Row("stick: accuracy, 1 part in", "2000", {way: FIELD / m for way, m in mean.items()}),
        Row("stick: precision, 1 part in", "1600", {way: FIELD / s for way, s in sd.items()}),
    ]


def resolution(error: Floats) -> float:
    """The least difference of two lengths that n samples show, by Student's t at 99 %, with KISS's rounding errors."""
    n = len(error)
    return float(student.ppf(0.995, n - 1) * error.std(ddof=1) / np.sqrt(n)) + 0.002


def under_water(rng: np.random.Generator, seed: int) -> list[Row]:
    """The stick as four cameras behind flat windows see it under water, which bends lines outwards."""
    rig = ring(4, distortion=(0.25, 0.1, 0.0, 0.0, 0.0))
    known = control_frame(rig.volume).xyz.reshape(-1, 3)
    ways = calibrations(rig, known, rng, seed, ("DLT", "lens terms", "wand"), poses=200)
    row = stick(ways, rig, rng, seed)[0]
    return [row._replace(what="under water, stick: mean absolute error, mm", paper="6.2; 1.2")]


def walk(ways: dict[str, Calibrated], rig: Rig, rng: np.random.Generator) -> Row:
    """A walking person's markers, laid on the truth, since each calibration has a world of its own."""
    xyz = walking().xyz[:, ::10].reshape(-1, 3)
    uv, root = seen(rig, xyz, rng, (0.0, 0.0)), {}
    for way, cal in ways.items():
        found = reconstructed(cal, uv)
        there = np.isfinite(found).all(1)
        R, t = rigid_align(found[there], xyz[there])
        root[way] = float(np.sqrt(((found[there] @ R.T + t - xyz[there]) ** 2).sum(1).mean()))
    return Row("walk, laid on the truth: RMSE, mm (quoted: best open)", "0.11", root)


def thrown(ways: dict[str, Calibrated], rig: Rig, rng: np.random.Generator, noise: Noise = NOISE) -> list[Row]:
    """The acceleration of a thrown marker, the mean of three throws."""
    fits: dict[str, list[tuple[Floats, float]]] = {way: [] for way in ways}
    for start, velocity in (((100, 700, 900), (2900, 0, 3300)), ((2300, 300, 1000), (-2800, 800, 3000)),
                            ((300, 1200, 1100), (2700, -1000, 2800))):  # fmt: skip
        ball = thrown_ball(start=start, velocity=velocity, gravity=1000 * GRAVITY)
        uv = seen(rig, ball.xyz[0], rng, noise)
        for way, cal in ways.items():
            fits[way].append(free_flight(reconstructed(cal, uv, noise), ball.rate))
    a = {way: np.mean([acceleration for acceleration, _ in f], 0) for way, f in fits.items()}
    return [
        Row("thrown: vertical, m/s² (9.806)", "9.724", {way: -float(x[2]) for way, x in a.items()}),
        Row("thrown: horizontal, first component, m/s²", "0.109", {way: float(x[0]) for way, x in a.items()}),
        Row("thrown: horizontal, second component, m/s²", "-0.055", {way: float(x[1]) for way, x in a.items()}),
        Row("thrown: |g| off by, %", "< 1", {w: 100 * (float(np.linalg.norm(x)) / GRAVITY - 1) for w, x in a.items()}),
        Row("thrown: ± by the scatter about the parabola, %", "",
            {way: 100 * float(np.sqrt(np.mean([sd**2 for _, sd in f]) / 3)) / GRAVITY for way, f in fits.items()}),
    ]  # fmt: skip


def free_flight(xyz: Floats, rate: float) -> tuple[Floats, float]:
    """Acceleration (3) m/s² of the parabolas through a path (F, 3) mm, and its standard deviation along an axis."""
    there = np.isfinite(xyz).all(1)
    t = np.flatnonzero(there) / rate
    A = np.vander(t - t.mean(), 3)
    solution = np.linalg.lstsq(A, xyz[there] / 1000.0, rcond=None)[0]
    off = xyz[there] / 1000.0 - A @ solution
    variance = (off**2).sum() / (3 * (len(t) - 3)) * np.linalg.inv(A.T @ A)[0, 0]
    return 2 * solution[0], 2 * float(np.sqrt(variance))


def distances(rng: np.random.Generator, seed: int) -> list[Row]:
    """Four markers about 305 mm apart between eight control balls, three cameras at right angles, 640 × 480."""
    cube = np.array([[0.0, 0.0, 0.0], [1000.0, 1000.0, 1000.0]])
    rig = ring(3, radius=3000.0, height=(600.0, 3400.0, 500.0), target=(500.0, 500.0, 500.0), sweep_deg=90.0,
               focal_px=1150.0, size=(640, 480), distortion=(-0.3, 0.0, 0.0, 0.0, 0.0), volume=cube)  # fmt: skip
    balls = calibration_box().xyz[:, 0]
    ways = calibrations(
        rig, balls, rng, seed, ("DLT", "linearised", "wand"), poses=200
    )  # eight points leave no lens terms
    errors: dict[str, list[float]] = {way: [] for way in ways}
    for _ in range(10):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        middle = rng.uniform(300.0, 700.0, 3)
        four = middle + 305 / np.sqrt(8) * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) @ turn.T
        uv = seen(rig, four, rng)
        for way, cal in ways.items():
            errors[way] += list(100 * (_pairs(reconstructed(cal, uv)) / _pairs(four) - 1))
    e = {way: np.array(x) for way, x in errors.items()}
    return [
        Row("distances: mean relative error, %", "0.90", {way: float(np.nanmean(np.abs(x))) for way, x in e.items()}),
        Row("distances: largest relative error, %", "1.18", {way: float(np.nanmax(np.abs(x))) for way, x in e.items()}),
    ]


def _pairs(xyz: Floats) -> Floats:
    i, j = np.triu_indices(len(xyz), 1)
    return np.linalg.norm(xyz[i] - xyz[j], axis=1)


def simulated(rounds: int) -> list[Row]:
    """All rows, each the root mean square over rounds with different noise."""
    tables = []
    for seed in range(rounds):
        rng = np.random.default_rng(seed)
        rig = ring(6, distortion=LENS)
        known = control_frame(rig.volume).xyz.reshape(-1, 3)
        ways = calibrations(rig, known, rng, seed)
        rows = static(ways, rig, known, rng) + stick(ways, rig, rng, seed) + thrown(ways, rig, rng)
        rows.append(walk(ways, rig, rng))
        tables.append(rows + distances(rng, seed) + under_water(rng, seed))
    return [_mean(rows) for rows in zip(*tables, strict=True)]


def _mean(rows: Sequence[Row]) -> Row:
    figures = {way: float(np.sqrt(np.mean([row.figures[way] ** 2 for row in rows]))) for way in rows[0].figures}
    return Row(rows[0].what, rows[0].paper, figures)


def print_table(rows: Sequence[Row]) -> None:
    print(f"{'':<48}{'quoted':>8}" + "".join(f"{way:>12}" for way in WAYS))
    for row in rows:
        cells = "".join(f"{row.figures[way]:12.4g}" if way in row.figures else f"{'':12}" for way in WAYS)
        print(f"{row.what:<48}{row.paper:>8}{cells}")


def real_wand(title: str, easy: EasyWand, rate: float | None = None, *, lenses_too: bool = True) -> None:
    """The wand's length, and the thrown object's acceleration, by easyWand's calibration and by ours."""
    wand, point = (np.isfinite(x[..., 0]).sum(0) >= 2 for x in (easy.wand, easy.background))
    ends, single = np.flatnonzero(wand.any(1)), np.flatnonzero(point)  # most frames are not digitised
    easy = easy._replace(wand=easy.wand[:, ends], background=easy.background[:, single])
    order = np.argsort(np.concatenate([np.repeat(ends, 2), single]), kind="stable")
    print(f"\n{title}: wand of {easy.length:.1f} mm")
    along, names = [0.0, easy.length], [lens.name for lens in easy.lenses]
    theirs = by_easywand(easy, easy.wand.reshape(len(names), -1, 2)).reshape(-1, 2, 3)
    print_length("easyWand", np.linalg.norm(theirs[:, 1] - theirs[:, 0], axis=1), easy.length)
    ways = (("ours, from the image sizes", None), ("ours, easyWand's first lenses", easy.start))
    for text, lenses in ways if lenses_too else ways[:1]:
        try:
            fit = from_wand_and_points(easy, names, lenses, order)
        except KinemarkError as error:
            print(f"  {text}: refused. {error}")
            continue
        came = wand_lengths(fit.rig, easy.wand, along=along, joint=fit.joint)
        print_length(text, came.length, easy.length)
        if rate:
            print_throw(text, reconstructed(Calibrated(fit.rig), easy.axis), rate)
    if rate:
        print_throw("easyWand", by_easywand(easy, easy.axis), rate)


def from_wand_and_points(
    easy: EasyWand, names: Sequence[str], lenses: Sequence[Camera] | None, order: Ints
) -> BundleFit:
    """The rig from the wand and from the single points that were digitised besides it.

    The wand was digitised too seldom to start from it alone. So its ends start as single points like the others, and
    where both ends are seen their median distance gives the scale. A camera that was moved is told by points in the
    `order` of time, in which a file has its rows.
    """
    n, f = easy.wand.shape[:2]
    uv = np.concatenate([easy.wand.reshape(n, 2 * f, 2), easy.background], 1)
    method = Bundle(radial=1, tangential=False)
    loose, back = calibrate_points(names, easy.sizes, uv[:, order], method=method, lenses=lenses), np.argsort(order)
    ends = loose.xyz[back[: 2 * f]].reshape(f, 2, 3)
    scale = easy.length / float(np.nanmedian(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)))
    loose = fit_scaled(loose, scale)
    xyz = loose.xyz[back]
    parts = (sticks_through(xyz[: 2 * f].reshape(f, 2, 3), np.array([0.0, easy.length])), FreePoints(xyz[2 * f :]))
    known = None if lenses is None else [KNOWN_LENS] * n
    return bundle(loose.rig, parts, uv, freedoms=known, method=method)


def by_easywand(easy: EasyWand, uv: Floats) -> Floats:
    """(N, 3) mm from uv (C, N, 2) px by easyWand's lenses and coefficients."""
    ideal = np.stack([undistort(lens, x) for lens, x in zip(easy.lenses, uv, strict=True)], 1)
    return triangulate(ideal, from_dlt(easy.dlt))


def print_length(text: str, length: Floats, true: float) -> None:
    length = length[np.isfinite(length)]
    print(f"  {text + ':':<34} {length.mean():7.2f} ± {length.std(ddof=1):.2f} mm, of {len(length)} frames")


def print_throw(text: str, xyz: Floats, rate: float) -> None:
    a, sd = free_flight(xyz, rate)
    print(f"  {text + ', thrown object:':<34} |g| = {np.linalg.norm(a):.3f} ± {sd:.3f} m/s²")


def files(*, lenses_too: bool = True) -> None:
    """All real wands; `lenses_too` starts from easyWand's lenses as well."""
    thermal = recording("cameras/dltdv_thermal_3cam") / "round3_2018-07-28_easyWandData.mat"
    real_wand("dltdv_thermal_3cam", read_easywand(thermal), rate=25.0, lenses_too=lenses_too)
    for k in (1, 2):
        name = f"windtunnelCalibration{k}_extrinsicCalib_20230228_easyWandData.mat"
        easy = read_easywand(recording("cameras/dltdv_bats_4cam") / name)
        real_wand(f"dltdv_bats_4cam, {k}", easy, lenses_too=lenses_too)


def main(arguments: Sequence[str]) -> None:
    rounds = next((int(a) for a in arguments if a.isdigit()), 5)
    if "files" not in arguments:
        print_table(simulated(rounds))
    if "simulation" not in arguments:
        files()


if __name__ == "__main__":
    main(sys.argv[1:])
