"""Do the other problems of a file tell how likely one is?

Each file of 16 laboratories is looked at as it is and with faults, at its own rate and at lower ones, as in
`probable_errors`; with faults twice: up to two of each kind, and one or two in all. Of each change, leap and spike it
is known what it is said to be by itself, and by the others of its trial (`edit/probable_errors/probability.py`, (3) and
(5)). The four coefficients are fitted to all laboratories; what is told of each is by those fitted to the others.

What files show as they are is no error, but for what somebody looked at and found to be one (NATURAL of
`probable_errors`), which is left out.

Run: python studies/trial_bulk.py [fit]         fit: print coefficients of changes too, by the laboratories of FILES
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple
from unittest import mock

import numpy as np
import scipy
from probable_errors import FILES, Known, labelled, listed, truth_of, with_faults
from probable_errors_faults import KINDS as FAULTS
from probable_errors_tables import Judged, classes, table

from kinemark.data.array_types import Floats
from kinemark.data.problems import Problem
from kinemark.edit.probable_errors import Evidence, Moment
from kinemark.edit.probable_errors.leaps import LeapEvidence
from kinemark.edit.probable_errors.probability import (
    COEFFICIENTS,
    TAIL,
    evidence_of_trial,
    logit_in_trial,
    told_by_trial,
)
from kinemark.edit.probable_errors.spikes import SpikeEvidence

PROBLEMS: Any = sys.modules["kinemark.engine.problems"]
OF_PATHS: Any = sys.modules["kinemark.engine.problems.of_paths"]
OTHERS = (
    "arm_box_lift_gaps/*.c3d", "qualisys_gait/*.c3d", "ulema_hand_to_head/*.c3d", "wheelchair_racing_gaps/*.c3d",
    "force_plate_types/*.c3d", "c3d_malformed/Dance.c3d", "c3d_six_formats/pc_real.c3d",
)  # fmt: skip
LABORATORIES = {
    "HC0": "children", "PiG": "PiG", "Gait - CGM2": "qualisys_gait", "Static - CGM2": "qualisys_gait",
    "qualisys_cgm2": "qualisys_gait", "GHr": "ulema", "HTH1": "ulema", "calMARKERS": "ulema",
    "kinematics_racing": "wheelchair",
}  # fmt: skip
KINDS = {"change": Evidence._fields, "leap": LeapEvidence._fields, "spike": SpikeEvidence._fields}


class Told(NamedTuple):
    """A problem: its laboratory, kind, what is said of it by itself, evidence of its trial (3), whether it is one,
    which trial it is of and its rate, what tells of it, and where it is."""

    laboratory: str
    kind: str
    wrong: float
    of_trial: tuple[float, ...]
    true: bool
    trial: int
    rate: float
    values: Mapping[str, float]
    moment: Moment


def laboratory(file: str) -> str:
    """The children's recordings are of one, and those of one trial that was processed in several ways."""
    return next((name for start, name in LABORATORIES.items() if file.startswith(start)), file)


def trials(patterns: Sequence[str]) -> Iterator[Known]:
    """Each as it is; with up to two faults of each kind; and with one or two in all."""
    groups = [[one for one in patterns if one in some] for some in (FILES, OTHERS)]
    some = (known for group in groups for part in (0, 1) for known in labelled(part, group))
    for k, known in enumerate(some):
        rng = np.random.default_rng([k, 5])
        few = dict(Counter(rng.choice(list(FAULTS), size=int(rng.integers(1, 3))).tolist()))
        yield from (known, with_faults(known, k), with_faults(known, k, counts=few))


def kind_of(one: Problem) -> str | None:
    """Of KINDS, by what tells of it; a change in a long gap has besides what was assumed of it."""
    return next((kind for kind, fields in KINDS.items() if set(fields) <= set(one.values)), None)


def told(patterns: Sequence[str] = (*FILES, *OTHERS)) -> list[Told]:
    rows = []
    names = mock.patch.object(PROBLEMS, "of_names", lambda *_: ())  # they are another matter, and take longest
    with names, mock.patch.object(OF_PATHS, "by_trial", lambda found: found):
        OF_PATHS._found.cache_clear()
        for k, known in enumerate(trials(patterns)):
            some = [
                (one, kind, true)
                for one in listed(known).items
                if (kind := kind_of(one)) is not None and (true := truth_of(known, one)) is not None
            ]
            rate, moments = known.trajectories.rate, [moment_of(known, one) for one, _, _ in some]
            of = evidence_of_trial(np.array([one.wrong for one, _, _ in some]), rate, moments)
            for (one, kind, true), its, at in zip(some, of, moments, strict=True):
                rows.append(Told(laboratory(known.name), kind, one.wrong, tuple(its), true, k, rate, one.values, at))
    return rows


def moment_of(known: Known, one: Problem) -> Moment:
    return Moment((one.first + one.last) / 2, frozenset(map(known.trajectories.names.index, one.tracks)))


def fit(rows: Sequence[Told]) -> Floats:
    """c₁ and c₂ of (3), c₃ of (5) and c₄ of (3), as likely as they can be within what keeps them monotone."""
    x, y = np.array([row.of_trial for row in rows]), np.array([float(row.true) for row in rows])

    def cost(c: Floats) -> float:
        z = logit_in_trial(x, c)
        return float((np.logaddexp(0, z) - y * z).sum())

    bounds = [(0, None), (0, 0.99 * TAIL), (0, None), (0, None)]
    return np.asarray(scipy.optimize.minimize(cost, np.ones(4), method="L-BFGS-B", bounds=bounds).x)


def fit_changes(rows: Sequence[Told]) -> Floats:
    """Constant, factor of what is said without companions, and coefficients of `Evidence.left` and `beside`, as likely
    as they can be beside (3), which is worked out anew with them."""
    alone, b = COEFFICIENTS["change_in_file_alone"], np.array([0.0, 1.0, 0.0, 0.0])
    mine = [k for k, row in enumerate(rows) if row.kind == "change" and row.values["left"] > 0]
    of = np.array([[rows[k].values[name] for name in Evidence._fields] for k in mine])
    x = np.column_stack([np.ones(len(mine)), alone[0] + of @ np.array(alone[1:]), of[:, -2:]])
    y, rows = np.array([float(rows[k].true) for k in mine]), list(rows)
    for _ in range(4):
        for k, wrong in zip(mine, scipy.special.expit(x @ b), strict=True):
            rows[k] = rows[k]._replace(wrong=float(wrong))
        for trial in {row.trial for row in rows}:
            own = [k for k, row in enumerate(rows) if row.trial == trial]
            wrong, moments = np.array([rows[k].wrong for k in own]), [rows[k].moment for k in own]
            its = evidence_of_trial(wrong, rows[own[0]].rate, moments)
            for k, one in zip(own, its, strict=True):
                rows[k] = rows[k]._replace(of_trial=tuple(one))
        beside = told_by_trial(np.array([rows[k].of_trial for k in mine]), fit(rows))
        b = _likeliest(x, y, beside, b)
    return b


def _likeliest(x: Floats, y: Floats, known: Floats, first: Floats) -> Floats:
    """Coefficients of a logistic function beside log-odds that are known."""

    def cost(b: Floats) -> tuple[float, Floats]:
        z = known + x @ b
        return float((np.logaddexp(0, z) - y * z).sum()), x.T @ (scipy.special.expit(z) - y)

    return np.asarray(scipy.optimize.minimize(cost, first, jac=True, method="L-BFGS-B").x)


def judged(rows: Sequence[Told], c: Floats | None) -> list[Judged]:
    """By these coefficients, or as they are by themselves."""
    out = []
    for row in rows:
        wrong = row.wrong
        if c is not None:
            wrong = float(scipy.special.expit(logit_in_trial(np.array([row.of_trial]), c)[0]))
        out.append(Judged(row.laboratory, row.kind, wrong, row.true, wrong >= 0.05))
    return out


def say(title: str, some: Sequence[Judged]) -> None:
    print(title)
    for kind in ("all", *KINDS):
        table(kind, [row for row in some if kind in ("all", row.kind)])
    classes(some)
    left = [row for row in some if not row.asked]
    print(f"  below the stop rule: expected {sum(row.wrong for row in left):.1f}, true {sum(row.true for row in left)}")


def unsure(some: Sequence[Judged]) -> str:
    """How many are neither sure nor unlikely, and how many of them are expected and true."""
    rows = [one for one in some if 0.05 <= one.wrong < 0.5]
    return f"{len(rows)}, {sum(one.wrong for one in rows):.1f} expected, {sum(one.true for one in rows)} true"


def clean(rows: Sequence[Told], some: Sequence[Judged]) -> str:
    """How many problems of files as they are would be worth a look."""
    n = Counter(row.trial for row, one in zip(rows, some, strict=True) if row.trial % 3 == 0 and one.asked)
    return f"{sum(n.values())} in all, most in one trial {max(n.values(), default=0)}"


def spread(c: dict[str, Floats], k: int) -> str:
    return f"{min(one[k] for one in c.values()):.2f} to {max(one[k] for one in c.values()):.2f}"


def main(*what: str) -> None:
    if "fit" in what:
        print("changes of files:", fit_changes(told(FILES)).round(3))
    rows = told()
    places = sorted({row.laboratory for row in rows})
    c = {place: fit([row for row in rows if row.laboratory != place]) for place in places}
    by_others = [judged([row], c[row.laboratory])[0] for row in rows]
    say("Each by itself", judged(rows, None))
    say("By its trial, each laboratory by the others", by_others)
    print(f"  worth a look in files as they are: {clean(rows, by_others)}; "
          f"by themselves {clean(rows, judged(rows, None))}")  # fmt: skip
    for place in places:
        mine = [one for row, one in zip(rows, by_others, strict=True) if row.laboratory == place]
        alone = judged([row for row in rows if row.laboratory == place], None)
        print(f"  {place:20} said to be wrong with 5 to 50 %: {unsure(mine)}; by themselves {unsure(alone)}")
    say("By its trial, by the coefficients of all", judged(rows, c_all := fit(rows)))
    fitted, without_one = ", ".join(f"{k:.2f}" for k in c_all), ", ".join(spread(c, k) for k in range(4))
    print(f"  in_trial: {fitted}; without one laboratory {without_one}")


if __name__ == "__main__":
    main(*sys.argv[1:])
