"""Do the error bars of gait hold what they say? A virtual laboratory whose every error is drawn.

Each draw is another subject's session: markers off their landmarks, skin moved over the bone, hips elsewhere than the
regression has them, widths measured wrongly, plates off where their corners say, noise on markers and plates, and
torsions and wands that are known. Truth are the segments and the loads that moved the markers. `holds` is the share of
frames, over all draws, in which the truth is within 1.96 stated standard deviations, with its own standard error, as
the frames of a session go together; 95 % is right. `size` is the root mean square of error over standard deviation; 1
is right. `exact` is the greatest error without any error drawn, in % of the range. Moments count where the foot stands
on its plate and where it swings.

The method was made with the first laboratory, at 100 Hz and the errors that are usual. The others have 50, 100 or 200
Hz, noise of 0.1 to 0.8 mm, faster walkers, and errors of 0.4 to 1.6 of the usual ones, which are stated as they are.

    python studies/gait_errors.py [--draws 100] [--seed 1]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kinemark.data.subject_measures import SIDES, LegMeasures, SubjectMeasures
from kinemark.gait import Physical, analyse_gait, marker_points, with_static_offsets
from kinemark.gait.gait_trial import GaitTrial
from kinemark.gait.uncertainty import GaitErrors, gait_uncertainty, with_uncertainty
from kinemark.synth import GaitLaboratory, WalkingBody, gait_laboratory

SHOWN = ("HipAngles", "KneeAngles", "AnkleAngles", "PelvisAngles", "HipMoment", "KneeMoment", "AnkleMoment")
ERRORS = GaitErrors(draws=8)
SIZES = ("placement_mm", "hip_mm", "width_mm", "tissue_mm", "plate_mm")
"""Of `ERRORS`, that other laboratories have otherwise."""
NOTHING = 1e-7
"""deg or N·m/kg, below which a deviation is rounding."""
Sessions = dict[str, list[tuple[np.ndarray, np.ndarray]]]
LEAST = 1e-3
"""Of a range that an error is a share of, deg or N·m/kg: one component of the ankle does not move."""


def measures(rng: np.random.Generator) -> SubjectMeasures:
    """A subject with known torsions and wands."""
    leg = rng.uniform(700, 980)
    legs = [
        LegMeasures(
            leg, rng.uniform(85, 120), rng.uniform(58, 78), torsion_deg=rng.uniform(-10, 30),
            thigh_wand_deg=rng.uniform(-10, 10), shank_wand_deg=rng.uniform(-10, 10),
        )
        for _ in SIDES
    ]  # fmt: skip
    return SubjectMeasures(legs[0], legs[1], mass_kg=rng.uniform(30, 100))


class Laboratory(NamedTuple):
    """Hz, mm of noise, of which speed in mm/s its subjects are at most, and errors that it states."""

    rate: float
    noise_mm: float
    fastest: float
    errors: GaitErrors


def usual(rng: np.random.Generator) -> Laboratory:
    """The one that the method was made with."""
    return Laboratory(100.0, 0.3, 1400.0, ERRORS)


def other(rng: np.random.Generator) -> Laboratory:
    """One of the others."""
    sizes = {name: getattr(ERRORS, name) * rng.uniform(0.4, 1.6) for name in SIZES}
    return Laboratory(float(rng.choice((50, 100, 200))), rng.uniform(0.1, 0.8), 1700.0, replace(ERRORS, **sizes))


def drawn(
    rng: np.random.Generator, errors: GaitErrors, laboratory: Laboratory | None = None
) -> tuple[GaitLaboratory, SubjectMeasures]:
    """A recording with errors, and the measures that its laboratory believes."""
    lab = laboratory or usual(rng)
    true = measures(rng)
    names = WalkingBody(true).names
    body = WalkingBody(
        true,
        speed_mm_s=rng.uniform(700, lab.fastest),
        placement_mm={name: errors.placement_mm * rng.normal(size=3) for name in names},
        tissue_mm={name: errors.tissue_mm * rng.normal(size=3) for name in names if name[1:] in ("THI", "KNE", "TIB")},
        hip_error_mm={side: errors.hip_mm * rng.normal(size=3) for side in SIDES},
    )
    off = tuple(errors.plate_mm * rng.normal(size=2))
    recorded = gait_laboratory(
        body, duration_s=2.6, rate=lab.rate, noise_mm=lab.noise_mm, force_noise_n=1.0, plates_off_mm=(off[0], off[1]),
        seed=int(rng.integers(2**31)),
    )  # fmt: skip
    believed = [
        replace(leg, knee_mm=leg.knee_mm + errors.width_mm * rng.normal(), ankle_mm=leg.ankle_mm
                + errors.width_mm * rng.normal())
        for leg in (true.left, true.right)
    ]  # fmt: skip
    return recorded, replace(true, left=believed[0], right=believed[1])


def analysed(lab: GaitLaboratory, believed: SubjectMeasures, errors: GaitErrors | None) -> GaitTrial:
    """As a laboratory does it, with error bars where errors are stated."""
    static = marker_points(lab.static)
    found = analyse_gait(lab.walk, with_static_offsets(believed, static, flat_foot=True), method=Physical())
    if errors is None:
        return found
    causes = gait_uncertainty(lab.walk, believed, method=Physical(), errors=errors, static=static)
    return replace(found, signals=with_uncertainty(found.signals, causes))


def counting(found: GaitTrial, lab: GaitLaboratory, name: str, *, swing: bool = True) -> np.ndarray:
    """(n) frames that count: of moments those in which the foot stands on its plate, and those in which it swings."""
    weight = np.abs(lab.signals[f"{name[0]}GroundReactionForce"].values[:, 2])
    frames = np.zeros(len(weight), bool)
    frames[6:-6] = True
    if not name.endswith(("Moment", "Force", "Power")):
        return frames
    known = (weight < LEAST) & swing
    for one in found.contacts:
        if one.side is not None and one.side[0].upper() == name[0] and not one.reason:
            known[one.first + 1 : one.stop - 1] = True
    return frames & known


def compared(lab: GaitLaboratory, found: GaitTrial, *, swing: bool = True) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """(n, 3) errors and stated deviations by quantity, of both sides; moments of the swing too, where it is asked."""
    out: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for signal in lab.signals:
        if signal.name[1:] not in SHOWN:
            continue
        other = found.signals[signal.name]
        off = other.values - signal.values
        if signal.kind == "angle":
            off = np.remainder(off + 180, 360) - 180
        frames = counting(found, lab, signal.name, swing=swing)
        sd = np.sqrt(np.diagonal(other.cov, axis1=1, axis2=2))
        frames &= np.isfinite(off + sd).all(1)
        pair = (off[frames], sd[frames])
        before = out.get(signal.name[1:])
        out[signal.name[1:]] = pair if before is None else tuple(map(np.concatenate, zip(before, pair, strict=True)))  # type: ignore[assignment]
    return out


def exact(rng: np.random.Generator) -> dict[str, float]:
    """Greatest error in % of the range, of a recording without errors, nothing smoothed."""
    lab = gait_laboratory(WalkingBody(measures(rng)), duration_s=2.6)
    known = with_static_offsets(lab.body.measures, marker_points(lab.static), flat_foot=True)
    found = analyse_gait(lab.walk, known, method=Physical(smoothing="none"))
    worst: dict[str, float] = {}
    for signal in lab.signals:
        if signal.name[1:] in SHOWN:
            frames = counting(found, lab, signal.name)
            off, own = (found.signals[signal.name].values - signal.values)[frames], signal.values[frames]
            share = 100 * np.nanmax(np.abs(off), axis=0) / np.maximum(np.ptp(own, axis=0), LEAST)
            worst[signal.name[1:]] = max(worst.get(signal.name[1:], 0.0), float(share.max()))
    return worst


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    worst = exact(np.random.default_rng(given.seed))
    for title, laboratory in (("the laboratory that it was made with", usual), ("other laboratories", other)):
        rng = np.random.default_rng([given.seed, laboratory is other])
        table(title, sessions(rng, given.draws, laboratory), worst)


def sessions(rng: np.random.Generator, n: int, laboratory: Callable[[np.random.Generator], Laboratory]) -> Sessions:
    """(frames, 3) errors and deviations by quantity of each session."""
    found: Sessions = {}
    for _ in range(n):
        one = laboratory(rng)
        lab, believed = drawn(rng, one.errors, one)
        for name, pair in compared(lab, analysed(lab, believed, one.errors)).items():
            found.setdefault(name, []).append(pair)
    return found


def table(title: str, found: Sessions, worst: dict[str, float]) -> None:
    """A row a quantity."""
    print(f"{title}: {len(found[SHOWN[0]])} sessions; first, second and third component")
    print(f"{'quantity':14s} {'holds, %':>32s} {'size':>18s} {'sd':>24s} {'exact, %':>9s}")
    for name in SHOWN:
        each = [held(*pair) for pair in found[name] if len(pair[0])]
        off, sd = (np.concatenate(parts) for parts in zip(*found[name], strict=True))
        share, error = pooled(np.array([s for s, _ in each]), np.array([n for _, n in each]))
        holds = " ".join(f"{share[k]:6.1f} ±{error[k]:3.1f}" for k in range(3))
        moves = sd > NOTHING
        z = np.where(moves, off, 0.0) / np.where(moves, sd, 1.0)
        size = " ".join(f"{np.sqrt(np.sum(z[:, k] ** 2) / moves[:, k].sum()):5.2f}" for k in range(3))
        typical = " ".join(f"{np.sqrt(np.mean(sd[:, k] ** 2)):7.3f}" for k in range(3))
        print(f"{name:14s} {holds:>32s} {size:>18s} {typical:>24s} {worst[name]:9.2f}")
    print()


def held(off: np.ndarray, sd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(3) share of a session's frames that are held, and (3) their number; those that are nothing by definition, as a
    moment about an axis that nothing loads, do not count."""
    moves = sd > NOTHING
    n = moves.sum(0)
    return np.sum((np.abs(off) < 1.96 * sd) & moves, axis=0) / np.maximum(n, 1), n


def pooled(share: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(3) % of all frames of (S, 3) sessions, and its standard error, with sessions as what is independent."""
    weight = n / n.sum(0)
    mean = (weight * share).sum(0)
    return 100 * mean, 100 * np.sqrt((weight**2 * (share - mean) ** 2).sum(0))


if __name__ == "__main__":
    main()
