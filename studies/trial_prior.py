"""Do the other problems of a file tell how likely one is?

Each file of other systems is looked at as it is and with faults, at its own rate and at lower ones, as in
`probable_errors`. Of each problem that paths show (exchanges, leaps, spikes, pieces) it is known what it is said to be
by itself, how much else of its trial is surely wrong, and how much may be; from these (3) of
`edit/probable_errors/probability.py` says anew how likely it is. Its coefficients are fitted to all laboratories; what
is told of each is by those fitted to the others, with those of all beside it.

Run: python studies/trial_prior.py
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple
from unittest import mock

import numpy as np
import scipy
from probable_errors import both, labelled, listed, truth_of
from probable_errors_tables import Judged, classes, table

from kinemark.data.array_types import Floats
from kinemark.edit.probable_errors.probability import LEAST, SURE, UNLIKELY

OF_PATHS: Any = sys.modules["kinemark.engine.problems.of_paths"]
KINDS = ("swap", "join", "spike")


class Told(NamedTuple):
    """A problem: its laboratory, kind, what is said of it by itself, what tells of its trial (3), whether it is one,
    and which trial it is of."""

    laboratory: str
    kind: str
    wrong: float
    evidence: tuple[float, ...]
    true: bool
    trial: int


def laboratory(file: str) -> str:
    """The children's recordings are of one, and those of one trial that was processed in several ways."""
    return {"HC0": "children", "PiG": "PiG"}.get(file[:3], file)


def told() -> list[Told]:
    rows = []
    with mock.patch.object(OF_PATHS, "by_trial", lambda found: found):
        OF_PATHS._found.cache_clear()
        for k, known in enumerate(known for part in (0, 1) for known in both(labelled(part))):
            some = [one for one in listed(known).items if one.kind in KINDS and "nats_a_frame" not in one.values]
            wrong = np.array([one.wrong for one in some])
            for one, evidence in zip(some, of_trial(wrong), strict=True):
                true = truth_of(known, one)
                if true is not None:
                    rows.append(Told(laboratory(known.name), one.kind, one.wrong, tuple(evidence.tolist()), true, k))
    return rows


def of_trial(wrong: Floats) -> Floats:
    """(N, 3) of the problems of a trial."""
    sure, unsure = wrong >= SURE, (wrong >= UNLIKELY) & (wrong < SURE)
    others = np.where(sure, wrong, 0.0).sum() - np.where(sure, wrong, 0.0), unsure.sum() - unsure
    return np.column_stack([scipy.special.logit(np.clip(wrong, LEAST, 1 - LEAST)), *np.log1p(others)])


def fit(rows: Sequence[Told]) -> Floats:
    """Coefficients of (3), drawn to a hundredth of nothing."""
    x, y = np.array([(1.0, *row.evidence) for row in rows]), np.array([float(row.true) for row in rows])

    def cost(c: Floats) -> float:
        z = x @ c
        return float((np.logaddexp(0, z) - y * z).sum() + 0.05 * (c[1:] ** 2).sum())

    return np.asarray(scipy.optimize.minimize(cost, np.zeros(4)).x)


def judged(rows: Sequence[Told], c: Floats | None) -> list[Judged]:
    """By these coefficients, or as they are by themselves."""
    out = []
    for row in rows:
        wrong = row.wrong if c is None else float(scipy.special.expit(c[0] + np.dot(c[1:], row.evidence)))
        out.append(Judged(row.laboratory, row.kind, wrong, row.true, wrong >= 0.05))
    return out


def say(title: str, some: Sequence[Judged]) -> None:
    print(title)
    table("all", list(some))
    classes(some)
    left = [row for row in some if not row.asked]
    print(f"  below the stop rule: expected {sum(row.wrong for row in left):.1f}, true {sum(row.true for row in left)}")


def unsure(some: Sequence[Judged]) -> str:
    """How many are neither sure nor unlikely, and how many of them are expected and true."""
    rows = [one for one in some if 0.05 <= one.wrong < 0.5]
    return f"{len(rows)}, {sum(one.wrong for one in rows):.1f} expected, {sum(one.true for one in rows)} true"


def report(rows: Sequence[Told], fit: Callable[[Sequence[Told]], Floats]) -> None:
    """What is told of each laboratory by the others, and by all."""
    places = sorted({row.laboratory for row in rows})
    by_others = {
        place: judged([row for row in rows if row.laboratory == place], fit([r for r in rows if r.laboratory != place]))
        for place in places
    }
    say("Each by itself", judged(rows, None))
    say("By its trial, each laboratory by the others", [one for place in places for one in by_others[place]])
    for place in places:
        mine = [row for row in rows if row.laboratory == place]
        print(f"  {place:20} said to be wrong with 5 to 50 %: {unsure(by_others[place])}; by themselves "
              f"{unsure(judged(mine, None))}")  # fmt: skip
    say("By its trial, by the coefficients of all", judged(rows, c := fit(rows)))
    print(f"  coefficients: {', '.join(f'{k:.2f}' for k in c)}")


def main() -> None:
    report(told(), fit)


if __name__ == "__main__":
    main()
