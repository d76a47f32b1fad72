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

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, chdtri, fdtrc  # scipy.stats has the same and takes a second to import

from ...geometry import project
from .fit import ControlFit
from .mistaken import exchanged_words
from .survey import Displaced, displaced_points, refused_everywhere, suspicious

GRADES = ("good", "usable", "bad")
GOOD = 2000
BAD = 300
SURE = 0.95
CHANCE = 1e-3
TOO_NOISY = 3.0
LOOSE = 20
NEAR = 5.0
FEW = 10
ALIKE = 0.3
MUCH_LESS = 0.7
EXACT = 1e-3  # px
MOST_NAMED = 6


class Judgement(NamedTuple):
    """A grade, "good", "usable" or "bad"; the reasons, the weightiest first; and the best grade that each allows."""

    grade: str
    sentences: tuple[str, ...]
    allowed: tuple[str, ...]


class Finding(NamedTuple):
    """A reason, and the best grade that it allows: its index in `GRADES`."""

    grade: int
    sentence: str


def judge_control_points(fit: ControlFit) -> Judgement:
    """Whether a calibration from control points is good, and why not."""
    findings = [_accuracy(fit), *_cameras(fit), *_noise(fit), *_images(fit), *_loose(fit), *_unseen(fit)]
    worst = max(f.grade for f in findings)
    if suspicious(fit) or worst > 0:
        findings[1:1] = _survey(fit, displaced_points(fit), worst)
    findings = sorted(findings, key=lambda f: -f.grade)
    allowed = tuple(GRADES[f.grade] for f in findings)
    return Judgement(allowed[0], tuple(f.sentence for f in findings), allowed)


def limits(e: float, nu: int) -> tuple[float, float]:
    """(3): between which limits the truth lies, given an estimate from nu equations left over."""
    tails = np.array([(1 + SURE) / 2, (1 - SURE) / 2])
    low, high = e * np.sqrt(nu / chdtri(max(nu, 1), 1 - tails))
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
    trusted = ~refused_everywhere(fit) & np.isfinite(fit.left_out_xyz[:, 0])
    off = np.linalg.norm(fit.left_out_xyz[trusted], axis=1)
    nu = int(fit.freedom.sum())
    if len(off) < 6:
        return _by_residual(fit)
    rms = float(np.sqrt((off**2).mean()))
    size = float(np.linalg.norm(np.ptp(fit.xyz[np.isfinite(fit.xyz).all(1)], axis=0)))
    low, high = limits(rms / size, min(nu, 3 * len(off)))
    worst = np.flatnonzero(trusted)[off.argmax()]
    words = (
        f"Control points that took no part come back {rms:.2g} mm from where they were surveyed (RMS; worst "
        f"{fit.points[worst]}, {off.max():.2g} mm), 1 part in {_parts(rms / size)} of the volume's diagonal of "
        f"{size / 1000:.2g} m."
    )
    return _graded(low, high, words)


def _by_residual(fit: ControlFit) -> Finding:
    s, nu = scatter(fit, list(range(len(fit.rig))))
    ratio = max(_image_ratio(fit, c, s) for c in range(len(fit.rig)))
    if nu < 1:
        return Finding(1, "As many equations as parameters: the residuals say nothing. Use eight points or more.")
    low, high = limits(ratio, nu)
    alone = len(fit.rig) < 2
    why = "One camera alone places no points" if alone else "The points are too few to leave one out as a test"
    words = (
        f"{why}. By the residuals, with {nu} equations left over, points are {np.sqrt(2) * s:.2g} px off, 1 part in "
        f"{_parts(high)} to {_parts(low)} of the images' extent."
    )
    return _graded(low, high, words)


def _graded(low: float, high: float, words: str) -> Finding:
    grade = grade_of(low, high)
    limit = ("", f" A good calibration has 1 part in {GOOD} or less for certain.", f" More than 1 in {BAD} is bad.")
    return Finding(grade, words + limit[grade])


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
        findings.append(Finding(2, f"{_missing(fit, bad)} RMS, more than 1 part in {BAD} of the images' extent."))
    if worse:
        findings.append(Finding(1, f"{_missing(fit, worse)} RMS, at least {TOO_NOISY:g} times as far as the others."))
    return findings


def _beyond(ratio: float, nu: int, nu_others: int, tried: int) -> bool:
    """Whether chance makes one of so many cameras so much worse than the others."""
    return bool(fdtrc(nu, nu_others, ratio**2) < CHANCE / tried)


def _missing(fit: ControlFit, cameras: list[int]) -> str:
    """How far these cameras miss their points."""
    names = ", ".join(fit.rig.names[c] for c in cameras)
    off = ", ".join(f"{fit.rig[c].residual:.2g}" for c in cameras)
    one = len(cameras) == 1
    return f"Camera{'' if one else 's'} {names} miss{'es its' if one else ' their'} control points by {off} px"


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
    if ratio < TOO_NOISY or chdtrc(nu, total) > CHANCE:
        return []
    s, _ = scatter(fit, [int(c) for c in stated])
    return [
        Finding(
            1,
            f"Residuals of {s:.2g} px are {ratio:.0f} times what the noise of the centroids explains. Lens terms, the "
            "survey or the points themselves are wrong by the rest.",
        )
    ]


def _images(fit: ControlFit) -> list[Finding]:
    """(6): images that single cameras left out, and of few points those that should be."""
    findings = []
    mistaken = np.isfinite(fit.uv[..., 0]) & ~fit.kept & ~refused_everywhere(fit)
    for c, name in enumerate(fit.rig.names):
        rows = np.flatnonzero(mistaken[c])
        if len(rows):
            findings.append(Finding(int(4 * len(rows) > fit.kept[c].sum()), _left_out_words(fit, c, rows)))
        elif fit.kept[c].sum() <= FEW and _image_ratio(fit, c, scatter(fit, [c])[0]) > 1 / GOOD:
            here = np.flatnonzero(fit.kept[c])
            words = exchanged_words(fit.xyz[here], fit.uv[c, here], [fit.points[i] for i in here])
            if words:
                findings.append(Finding(2, f"Camera {name}:{words}"))
    return findings


def _left_out_words(fit: ControlFit, c: int, rows: NDArray[np.int64]) -> str:
    """Which images a camera left out, how far off they are, and where they seem to belong."""
    expected = project(fit.rig[c], fit.xyz)
    s, _ = scatter(fit, [c])
    listed = []
    for i in rows[:MOST_NAMED]:
        off = np.linalg.norm(expected - fit.uv[c, i], axis=1)
        j = int(np.where(np.isfinite(off) & (np.arange(len(off)) != i), off, np.inf).argmin())
        like = off[j] < min(max(NEAR * np.sqrt(2) * s, EXACT), off[i] / 2)
        listed.append(f"{fit.points[i]} ({off[i]:.1f} px off{f', where {fit.points[j]} belongs' if like else ''})")
    return f"Camera {fit.rig.names[c]} left out {len(rows)} of its points: {_and_more(listed, len(rows))}."


def _loose(fit: ControlFit) -> list[Finding]:
    """(7)."""
    findings = []
    for camera in fit.rig:
        share = float(np.sqrt(max(camera.cov[0, 0], camera.cov[1, 1])) / abs(camera.K[0, 0]))
        if share > 1 / LOOSE:
            findings.append(
                Finding(
                    1,
                    f"Camera {camera.name}: its points leave the focal length uncertain by {100 * share:.0f} %. They "
                    "are few, nearly in a plane, or fill only a part of the image.",
                )
            )
    return findings


def _unseen(fit: ControlFit) -> list[Finding]:
    """Points with a surveyed place that no camera has, or less than half of them."""
    seen = np.isfinite(fit.uv[..., 0]).sum(0)
    known, findings = np.isfinite(fit.xyz).all(1), []
    for rows, who in (
        (np.flatnonzero(known & (seen == 0)), "No camera sees"),
        (np.flatnonzero(known & (seen > 0) & (2 * seen < len(fit.rig))), "Less than half of the cameras see"),
    ):
        if len(rows):
            names = _and_more([fit.points[i] for i in rows], len(rows))
            findings.append(Finding(0, f"{who} {names}: hidden, or not where the description says."))
    return findings


def _survey(fit: ControlFit, wrong: Displaced | None, worst: int) -> list[Finding]:
    """Points that all cameras see elsewhere, (6): harmless where no camera used them, else as grave as all the rest."""
    if wrong is None:
        return []
    everyone = list(range(len(fit.rig)))
    before, after = scatter(fit, everyone)[0], scatter(wrong.rest, everyone)[0]
    harmless = bool(refused_everywhere(fit)[wrong.rows].all())
    if not harmless and after > MUCH_LESS * before:
        return []
    far = np.linalg.norm(wrong.offset, axis=1)
    most = far > far.max() / 2
    effect = "No camera used them." if harmless else f"Without them residuals fall from {before:.2g} to {after:.2g} px."
    words = f"By the word of all cameras, {_elsewhere(fit, wrong.rows[most], wrong.offset[most])}. "
    less = [f"{fit.points[i]} ({d:.2g} mm)" for i, d in zip(wrong.rows[~most], far[~most], strict=True)]
    words += f"Less far off: {_and_more(less, len(less))}. " if less else ""
    return [Finding(worst if harmless else max(worst, 1), f"{words}Measure again, or leave out. {effect}")]


def _elsewhere(fit: ControlFit, rows: NDArray[np.int64], offset: NDArray[np.float64]) -> str:
    """Where points are instead: at each other's places, all shifted alike, or here and there."""
    names = _and_more([fit.points[i] for i in rows], len(rows))
    points, are = ("control points", "are") if len(rows) > 1 else ("control point", "is")
    who = f"{points} {names} {are} not at the surveyed place"
    found, far = fit.xyz[rows] + offset, np.linalg.norm(offset, axis=1)
    if len(rows) == 2 and np.linalg.norm(found - fit.xyz[rows[::-1]], axis=1).max() < ALIKE * far.min():
        return f"{who} but each at that of the other"
    mean = offset.mean(0)
    if np.linalg.norm(offset - mean, axis=1).max() < ALIKE * np.linalg.norm(mean):
        alike = " alike" if len(rows) > 1 else ""
        by = ", ".join(f"{x:.1f}" for x in mean)
        return f"{who} but {np.linalg.norm(mean):.3g} mm away,{alike} by ({by}) mm"
    return f"{who} but {far.min():.3g} to {far.max():.3g} mm away"


def _and_more(names: list[str], n: int) -> str:
    return ", ".join(names[:MOST_NAMED]) + (f" and {n - MOST_NAMED} more" if n > MOST_NAMED else "")


def _parts(ratio: float) -> str:
    """1 part in so many, to two digits."""
    return f"{float(f'{1 / max(ratio, 1e-9):.2g}'):.0f}"
