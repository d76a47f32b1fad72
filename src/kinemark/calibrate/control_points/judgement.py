"""Is a calibration from control points good, and if not, why?

What counts is how far points that took no part come back from where they are, relative to the volume: the RMS of
`ControlFit.left_out_xyz` over the diagonal of the points' box (1). Where no point can be left out, or one camera is
alone, the scatter of residuals takes its place, √2 s with s² = Σ r² / ν, over the diagonal of the points' images (2).

Either is an estimate from ν equations left over, and the truth lies with 95 % between the two limits

    e √(ν / χ²(0.975; ν))    and    e √(ν / χ²(0.025; ν))                 (3)

A calibration is good if even the upper limit is below 1 / `GOOD`, bad if even the lower limit is above 1 / `BAD`, and
usable in between: few points are good or bad only where these limits leave no doubt. The volume of KISS 3.3 has a
diagonal of 3.4 m: good is 1.7 mm, bad 11 mm, and the paper has 0.6 mm. A single camera is judged by (2) as well.

No grade is better than usable where something contradicts itself:

- residuals larger than the centroids' stated noise explains: χ² beyond chance and `TOO_NOISY` times as large (4)
- a camera that fits worse than the others: the ratio of its s² to theirs beyond F's upper tail, and `TOO_NOISY` (5)
- points that all cameras see elsewhere than surveyed (`survey`), and images taken for another (`mistaken`) (6)
- points that determine a camera poorly: the focal length is uncertain by more than 1 / `LOOSE` (7)
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy

from ...data import Finding, Severity, make_finding
from ...data.array_types import Floats, Ints
from ...data.finding import most_severe_first
from ...geometry import project
from .fit import ControlFit
from .mistaken import mistaken_points
from .survey import Displaced, displaced_points, refused_everywhere, suspicious

GRADES = ("good", "usable", "bad")
GOOD = 2000  # 1 part in so many, of the volume; chosen (see studies/calibration_quality.py)
BAD = 300  # 1 part in so many, of the volume; chosen (see studies/calibration_quality.py)
SURE = 0.95  # probability of the limits of an error; conventional
CHANCE = 1e-3  # probability below which something is not taken for chance; conventional
TOO_NOISY = 3.0  # times the variance expected; chosen: less is no cause for alarm
LOOSE = 20  # 1 part in so many, of the focal length's standard deviation; chosen (see studies/calibration_quality.py)
NEAR = 5.0
"""Standard deviations within which a point is taken for another's place; chosen (see
studies/calibration_quality.py)."""
FEW = 10
"""Points of a camera up to which its image says more than the left-out errors; chosen (see
studies/calibration_quality.py)."""
ALIKE = 0.3  # of a distance, within which errors are called alike; chosen (see studies/calibration_quality.py)
MUCH_LESS = 0.7
"""Of the error before, which leaving a point out must come below; chosen (see studies/calibration_quality.py)."""
EXACT = 1e-3  # px of residual, below which images are simulated ones; chosen
WEIGHT: tuple[Severity, ...] = ("info", "amber", "red")
"""Of a reason that allows each of `GRADES` at best."""
LIMIT = (None, GOOD, BAD)
"""1 part in how many: the limit that each grade is said to have missed."""


class Judgement(NamedTuple):
    """A grade, "good", "usable" or "bad", and the reasons, the weightiest first.

    A reason of severity "info" allows the grade "good", "amber" allows "usable" at best, "red" only "bad".
    """

    grade: str
    findings: tuple[Finding, ...]


def judge_control_points(fit: ControlFit) -> Judgement:
    """Whether a calibration from control points is good, and why not."""
    findings = [
        _accuracy(fit),
        *_cameras(fit),
        *_noise(fit),
        *_images(fit),
        *_focal_length_findings(fit),
        *_unseen(fit),
    ]
    highest = max(map(_grade, findings))
    if suspicious(fit) or highest > 0:
        findings[1:1] = _survey(fit, displaced_points(fit), highest)
    findings = most_severe_first(findings)
    return Judgement(GRADES[_grade(findings[0])], tuple(findings))


def _grade(found: Finding) -> int:
    """The best grade that a reason allows, as an index in `GRADES`."""
    return WEIGHT.index(found.severity)


def limits(e: float, nu: int) -> tuple[float, float]:
    """(3): between which limits the truth lies, given an estimate from nu equations left over."""
    tails = np.array([(1 + SURE) / 2, (1 - SURE) / 2])
    low, high = e * np.sqrt(nu / scipy.special.chdtri(max(nu, 1), 1 - tails))
    return float(low), float(high)


def grade_of(low: float, high: float) -> int:
    """The grade of an error between these limits, relative to the volume."""
    return 0 if high <= 1 / GOOD else 2 if low > 1 / BAD else 1


def scatter(fit: ControlFit, cameras: list[int]) -> tuple[float, int]:
    """s, px, along one axis, of some cameras together and the number of equations left over, as in (2)."""
    squares = sum(float((fit.residual[c, fit.kept[c]] ** 2).sum()) for c in cameras)
    nu = int(fit.freedom[cameras].sum())
    return float(np.sqrt(squares / max(nu, 1))), nu


def _accuracy(fit: ControlFit) -> Finding:
    """(1), or (2)."""
    usable = ~refused_everywhere(fit) & np.isfinite(fit.left_out_xyz[:, 0])
    error = np.linalg.norm(fit.left_out_xyz[usable], axis=1)
    nu = int(fit.freedom.sum())
    if len(error) < 6:
        return _by_residual(fit)
    rms = float(np.sqrt((error**2).mean()))
    size = float(np.linalg.norm(np.ptp(fit.xyz[np.isfinite(fit.xyz).all(1)], axis=0)))
    low, high = limits(rms / size, min(nu, 3 * len(error)))
    grade = grade_of(low, high)
    return make_finding(
        "control_points_return",
        severity=WEIGHT[grade],
        rms_mm=rms,
        max_point=fit.points[np.flatnonzero(usable)[error.argmax()]],
        max_mm=error.max(),
        parts=size / max(rms, 1e-9),
        diagonal_m=size / 1000,
        limit_parts=LIMIT[grade],
    )


def _by_residual(fit: ControlFit) -> Finding:
    s, nu = scatter(fit, list(range(len(fit.rig))))
    ratio = max(_image_ratio(fit, c, s) for c in range(len(fit.rig)))
    if nu < 1:
        return make_finding("no_equations_left")
    low, high = limits(ratio, nu)
    grade = grade_of(low, high)
    return make_finding(
        "control_points_by_residual",
        severity=WEIGHT[grade],
        alone=len(fit.rig) < 2,
        equations=nu,
        error_px=np.sqrt(2) * s,
        parts_least=1 / max(high, 1e-9),
        parts_most=1 / max(low, 1e-9),
        limit_parts=LIMIT[grade],
    )


def _image_ratio(fit: ControlFit, c: int, s: float) -> float:
    """(2) of one camera."""
    diagonal = float(np.linalg.norm(np.ptp(fit.uv[c, fit.kept[c]], axis=0)))
    return float(np.sqrt(2) * s / max(diagonal, 1e-9))


def _cameras(fit: ControlFit) -> list[Finding]:
    """Cameras that are bad by (2) themselves, and those that are worse than the others by (5)."""
    bad, worse = [], []
    every = list(range(len(fit.rig)))
    for c in every:
        s, nu = scatter(fit, [c])
        others, nu_others = scatter(fit, [o for o in every if o != c])
        ratio = s / max(others, EXACT)
        if nu > 0 and grade_of(*limits(_image_ratio(fit, c, s), nu)) == 2:
            bad.append(c)
        elif min(nu, nu_others) > 0 and ratio > TOO_NOISY and s > EXACT and _beyond(ratio, nu, nu_others, len(every)):
            worse.append(c)
    findings = []
    if bad:
        findings.append(make_finding("cameras_miss_control_points", limit_parts=BAD, **_missed(fit, bad)))
    if worse:
        findings.append(make_finding("cameras_worse_than_others", limit_ratio=TOO_NOISY, **_missed(fit, worse)))
    return findings


def _beyond(ratio: float, nu: int, nu_others: int, comparisons: int) -> bool:
    """Whether chance makes one of so many cameras so much worse than the others."""
    return bool(scipy.special.fdtrc(nu, nu_others, ratio**2) < CHANCE / comparisons)


def _missed(fit: ControlFit, cameras: list[int]) -> dict[str, Any]:
    """By how much these cameras miss their points."""
    return {
        "cameras": [fit.rig.names[c] for c in cameras],
        "residual_px_list": [fit.rig[c].residual for c in cameras],
    }


def _noise(fit: ControlFit) -> list[Finding]:
    """(4), over all cameras whose centroids' noise is stated."""
    stated = np.flatnonzero(fit.stated)
    nu = int(fit.freedom[stated].sum())
    if nu < 1:
        return []
    total = 0.0
    for c in stated:
        r, Q = fit.residual[c, fit.kept[c]], fit.cov[c, fit.kept[c]]
        total += float(np.einsum("ni,nij,nj->", r, np.linalg.inv(Q), r))
    ratio = float(np.sqrt(total / nu))
    if ratio < TOO_NOISY or scipy.special.chdtrc(nu, total) > CHANCE:
        return []
    s, _ = scatter(fit, [int(c) for c in stated])
    return [make_finding("residuals_above_noise", residual_px=s, ratio=ratio)]


def _images(fit: ControlFit) -> list[Finding]:
    """(6): images that single cameras left out, and of few points those that should be."""
    findings = []
    mistaken = np.isfinite(fit.uv[..., 0]) & ~fit.kept & ~refused_everywhere(fit)
    for c, name in enumerate(fit.rig.names):
        rows = np.flatnonzero(mistaken[c])
        if len(rows):
            findings.append(_left_out(fit, c, rows))
        elif fit.kept[c].sum() <= FEW and _image_ratio(fit, c, scatter(fit, [c])[0]) > 1 / GOOD:
            here = np.flatnonzero(fit.kept[c])
            found = mistaken_points(fit.xyz[here], fit.uv[c, here], [fit.points[i] for i in here], camera=name)
            findings += [found] if found else []
    return findings


def _left_out(fit: ControlFit, c: int, rows: Ints) -> Finding:
    """Which images a camera left out, how far off they are, and where they seem to belong."""
    expected = project(fit.rig[c], fit.xyz)
    s, _ = scatter(fit, [c])
    far, places = [], []
    for i in rows:
        distance = np.linalg.norm(expected - fit.uv[c, i], axis=1)
        j = int(np.where(np.isfinite(distance) & (np.arange(len(distance)) != i), distance, np.inf).argmin())
        like = distance[j] < min(max(NEAR * np.sqrt(2) * s, EXACT), distance[i] / 2)
        far.append(distance[i])
        places.append(fit.points[j] if like else None)
    return make_finding(
        "control_points_left_out",
        severity=WEIGHT[int(4 * len(rows) > fit.kept[c].sum())],
        cameras=[fit.rig.names[c]],
        points_list=[fit.points[i] for i in rows],
        off_px_list=far,
        place_of_list=places,
    )


def _focal_length_findings(fit: ControlFit) -> list[Finding]:
    """(7)."""
    shares = [float(np.sqrt(max(c.cov[0, 0], c.cov[1, 1])) / abs(c.K[0, 0])) for c in fit.rig]
    return [
        make_finding("focal_length_uncertain", cameras=[name], sd_share=share)
        for name, share in zip(fit.rig.names, shares, strict=True)
        if share > 1 / LOOSE
    ]


def _unseen(fit: ControlFit) -> list[Finding]:
    """Points with a surveyed place that no camera has, or less than half of them."""
    seen = np.isfinite(fit.uv[..., 0]).sum(0)
    known = np.isfinite(fit.xyz).all(1)
    few = known & (seen > 0) & (2 * seen < len(fit.rig))
    kinds = (("control_points_unseen", known & (seen == 0)), ("control_points_seen_by_few", few))
    return [
        make_finding(kind, points_list=[fit.points[i] for i in np.flatnonzero(those)])
        for kind, those in kinds
        if those.any()
    ]


def _survey(fit: ControlFit, wrong: Displaced | None, highest: int) -> list[Finding]:
    """Points that all cameras see elsewhere, (6): harmless where no camera used them, else as severe as the rest."""
    if wrong is None:
        return []
    everyone = list(range(len(fit.rig)))
    before, after = scatter(fit, everyone)[0], scatter(wrong.rest, everyone)[0]
    refused = refused_everywhere(fit)[wrong.rows]
    if after > MUCH_LESS * before:  # those that cameras used may as well be right
        wrong, refused = Displaced(wrong.rows[refused], wrong.offset[refused], wrong.rest), refused[refused]
    if not len(wrong.rows):
        return []
    harmless = bool(refused.all())
    far = np.linalg.norm(wrong.offset, axis=1)
    most = far > far.max() / 2
    return [
        make_finding(
            "control_points_displaced",
            severity=WEIGHT[highest if harmless else max(highest, 1)],
            where=_elsewhere(fit, wrong.rows[most], wrong.offset[most]),
            points_list=[fit.points[i] for i in wrong.rows[most]],
            shift_mm_list=wrong.offset[most].mean(0),
            least_mm=far[most].min(),
            greatest_mm=far[most].max(),
            less_points_list=[fit.points[i] for i in wrong.rows[~most]],
            less_mm_list=far[~most],
            before_px=None if harmless else before,
            after_px=None if harmless else after,
        )
    ]


def _elsewhere(fit: ControlFit, rows: Ints, offset: Floats) -> str:
    """Where points are instead: "other", at each other's places, all shifted "alike", or here and there, "apart"."""
    found, far = fit.xyz[rows] + offset, np.linalg.norm(offset, axis=1)
    if len(rows) == 2 and np.linalg.norm(found - fit.xyz[rows[::-1]], axis=1).max() < ALIKE * far.min():
        return "other"
    mean = offset.mean(0)
    return "alike" if np.linalg.norm(offset - mean, axis=1).max() < ALIKE * np.linalg.norm(mean) else "apart"
