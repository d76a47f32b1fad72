"""How far the Conventional Gait Model is off when what it assumes is not so (KISS, section 6, errors (iii) to (v)).

In the virtual gait laboratory a body walks without noise. One assumption at a time fails by a stated amount; angles and
moments are those of the model, which knows nothing of it, in mode `physical` without smoothing:

    hip centre       the hip is elsewhere in the pelvis than the regression has it, along one axis
    knee axis        the flexion axis is not in the plane of the thigh's wand, which stands so many degrees off it
    ankle axis       the shank's wand likewise; torsion: the tibia's, which is taken for 0
    knee is a hinge  the shank glides forward on the thigh, in proportion to flexion, by so much at 60 degrees
    skin on bone     a marker has moved over the bone since standing, forward
    rigid foot       TOE is lifted against the foot, as where the midfoot yields
    knee width       is measured too large
    inertia          the body's segments are de Leva's, the model's Winter's

A row has the root mean square errors over both legs, both signs and all subjects; moments in stance on the plates.
`stated` is what a report says as standard deviation by default, and a number is marked with * where the error is
greater. The last row has all but inertia together as squares, as if each failed by its first amount.

    python studies/gait_assumptions.py [--subjects 2] [--seed 1]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from gait_errors import ERRORS, SHOWN, analysed, compared, counting

from kinemark.data.array_types import Floats
from kinemark.data.subject_measures import LETTER, SIDES, TO_THE_LEFT, LegMeasures, SubjectMeasures
from kinemark.gait import Physical, analyse_gait, marker_points, with_static_offsets
from kinemark.synth import WalkingBody, gait_laboratory

DURATION_S = 2.6
COLUMNS = tuple(name for name in SHOWN if name != "PelvisAngles")
Errors = dict[str, Floats]


class Failing(NamedTuple):
    """An assumption, the amounts by which it fails (the first is a usual one), their unit, and the body and inertia of
    a subject for which it fails by an amount."""

    name: str
    amounts: tuple[float, ...]
    unit: str
    body: Callable[[SubjectMeasures, float], WalkingBody]
    inertia: str = "winter"


def _legs(measures: SubjectMeasures, **changed: Any) -> SubjectMeasures:
    """Both legs with other measures."""
    return replace(measures, left=replace(measures.left, **changed), right=replace(measures.right, **changed))


def _hip(axis: int) -> Callable[[SubjectMeasures, float], WalkingBody]:
    def body(measures: SubjectMeasures, by: float) -> WalkingBody:
        off = {side: by * np.eye(3)[axis] * (TO_THE_LEFT[side] if axis == 1 else 1) for side in SIDES}
        return WalkingBody(measures, hip_error_mm=off)

    return body


def _skin(*markers: str, axis: int = 0) -> Callable[[SubjectMeasures, float], WalkingBody]:
    def body(measures: SubjectMeasures, by: float) -> WalkingBody:
        return WalkingBody(
            measures, tissue_mm={LETTER[side] + name: by * np.eye(3)[axis] for side in SIDES for name in markers}
        )

    return body


def _measure(name: str) -> Callable[[SubjectMeasures, float], WalkingBody]:
    def body(measures: SubjectMeasures, by: float) -> WalkingBody:
        return WalkingBody(_legs(measures, **{name: getattr(measures.left, name) + by}))

    return body


ASSUMPTIONS: tuple[Failing, ...] = (
    Failing("hip centre, forward", (10, 20), "mm", _hip(0)),
    Failing("hip centre, outward", (10, 20), "mm", _hip(1)),
    Failing("hip centre, upward", (10, 20), "mm", _hip(2)),
    Failing("knee axis, about the thigh", (5, 10), "deg", _measure("thigh_wand_deg")),
    Failing("ankle axis, about the shank", (5, 10), "deg", _measure("shank_wand_deg")),
    Failing("torsion of the tibia", (10, 20), "deg", _measure("torsion_deg")),
    Failing("knee is a hinge", (10, 20), "mm", lambda measures, by: WalkingBody(measures, glide_mm=by)),
    Failing("skin at THI", (10, 20), "mm", _skin("THI")),
    Failing("skin at KNE", (5, 10), "mm", _skin("KNE")),
    Failing("skin at TIB", (5, 10), "mm", _skin("TIB")),
    Failing("rigid foot, TOE", (5, 10), "mm", _skin("TOE")),
    Failing("knee width", (5, 10), "mm", _measure("knee_mm")),
    Failing("inertia, de Leva", (0,), "", lambda measures, by: WalkingBody(measures), inertia="de_leva_male"),
)


def subjects(n: int, seed: int) -> list[SubjectMeasures]:
    """Subjects of several sizes, whose wands and tibiae are as the model takes them to be."""
    rng, found = np.random.default_rng(seed), []
    for _ in range(n):
        legs = LegMeasures(rng.uniform(700, 980), rng.uniform(85, 120), rng.uniform(58, 78))
        found.append(SubjectMeasures(legs, legs, mass_kg=rng.uniform(30, 100)))
    return found


def errors_of(failing: Failing, by: float, believed: SubjectMeasures) -> Errors:
    """(n, 3) errors by quantity of one subject."""
    lab = gait_laboratory(failing.body(believed, by), duration_s=DURATION_S, inertia=failing.inertia)
    known = with_static_offsets(believed, marker_points(lab.static), flat_foot=True)
    found = analyse_gait(lab.walk, known, method=Physical(smoothing="none"))
    off: dict[str, list[Floats]] = {}
    for signal in lab.signals:
        if signal.name[1:] in COLUMNS:
            by_frame = found.signals[signal.name].values - signal.values
            if signal.kind == "angle":
                by_frame = np.remainder(by_frame + 180, 360) - 180
            frames = counting(found, lab, signal.name, swing=False) & np.isfinite(by_frame).all(1)
            off.setdefault(signal.name[1:], []).append(by_frame[frames])
    return {name: np.concatenate(parts) for name, parts in off.items()}


def squares(failing: Failing, by: float, believed: list[SubjectMeasures]) -> Errors:
    """(3) root mean squares by quantity, over subjects and both signs."""
    signs = (-1, 1) if by else (1,)
    each = [errors_of(failing, sign * by, one) for one in believed for sign in signs]
    return {name: np.sqrt(np.mean(np.concatenate([one[name] for one in each]) ** 2, axis=0)) for name in COLUMNS}


def stated(believed: list[SubjectMeasures]) -> Errors:
    """(3) standard deviations by quantity that a report states."""
    found: dict[str, list[Floats]] = {}
    for one in believed:
        lab = gait_laboratory(WalkingBody(one), duration_s=DURATION_S)
        for name, (_, sd) in compared(lab, analysed(lab, one, ERRORS), swing=False).items():
            found.setdefault(name, []).append(sd)
    return {name: np.sqrt(np.mean(np.concatenate(found[name]) ** 2, axis=0)) for name in COLUMNS}


def line(words: str, row: Errors, limit: Errors | None = None) -> str:
    """One row; * where an error is above its limit."""
    cells = []
    for name in COLUMNS:
        digits = 1 if name.endswith("Angles") else 3
        for k in range(3):
            mark = "*" if limit is not None and row[name][k] > limit[name][k] else " "
            cells.append(f"{row[name][k]:{digits + 5}.{digits}f}{mark}")
    return f"{words:36s}" + "".join(cells)


def table(believed: list[SubjectMeasures]) -> Iterator[str]:
    """Lines."""
    yield f"{len(believed)} subjects; three components each, deg and N m/kg"
    widths = [3 * (7 if name.endswith("Angles") else 9) for name in COLUMNS]
    yield " " * 36 + "".join(f"{name:>{width}s}" for name, width in zip(COLUMNS, widths, strict=True))
    limit = stated(believed)
    yield line("stated standard deviation", limit)
    together = {name: np.zeros(3) for name in COLUMNS}
    for failing in ASSUMPTIONS:
        for k, by in enumerate(failing.amounts):
            row = squares(failing, by, believed)
            yield line(f"{failing.name} {f'{by:g} {failing.unit}' if by else ''}", row, limit)
            if k == 0 and by:
                together = {name: together[name] + row[name] ** 2 for name in COLUMNS}
    yield line("all by their first amount", {name: np.sqrt(value) for name, value in together.items()}, limit)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--subjects", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    for text in table(subjects(given.subjects, given.seed)):
        print(text, flush=True)


if __name__ == "__main__":
    main()
