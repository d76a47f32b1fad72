"""Would a file's own bulk of evidence tell better how likely one of its problems is than how many others may be?

Each file of 16 laboratories is looked at as it is and with faults, at its own rate and at lower ones, as in
`probable_errors`, every second with one or two faults only. Of each problem that paths show it is known what it is said
to be by itself, of log-odds z; S, the sum of the probabilities of the trial's others that are sure; the rate f; and how
common what tells of it is in its trial, by the others that are not sure, of which nearly all are motion:

    logit wrong' = c₀ + c₁ z + c₂ ln(1 + S) + c₃ ln(1 + n(z)) + c₄ ln(f / 60 Hz)                          (1)
    n(z) = max over z' ≥ z of Σ exp(−(z' − z_j)² / 2)                                                      (2)

Coefficients are fitted to all laboratories, each counting by the root of its trials; what is told of each is by those
fitted to the others. Kinemark does not use (1) yet: with these coefficients a lone leap of 95 mm in a trial that is
clean otherwise is likelier right than wrong, with those of four draws of faults a clean trial gets longer lists.

Run: python studies/trial_bulk.py
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from unittest import mock

import numpy as np
import scipy
from probable_errors import FILES, Known, labelled, listed, truth_of, with_faults
from probable_errors_faults import KINDS as FAULTS
from trial_prior import KINDS, OF_PATHS, Told, report

from kinemark.data.array_types import Bools, Floats
from kinemark.edit.probable_errors.probability import LEAST, SURE

OTHERS = (
    "arm_box_lift_gaps/*.c3d", "qualisys_gait/*.c3d", "ulema_hand_to_head/*.c3d", "wheelchair_racing_gaps/*.c3d",
    "force_plate_types/*.c3d", "c3d_malformed/Dance.c3d", "c3d_six_formats/pc_real.c3d",
)  # fmt: skip
LABORATORIES = {
    "HC0": "children", "PiG": "PiG", "Gait - CGM2": "qualisys_gait", "Static - CGM2": "qualisys_gait",
    "qualisys_cgm2": "qualisys_gait", "GHr": "ulema", "HTH1": "ulema", "calMARKERS": "ulema",
    "kinematics_racing": "wheelchair",
}  # fmt: skip


def laboratory(file: str) -> str:
    """The children's recordings are of one, and those of one trial that was processed in several ways."""
    return next((name for start, name in LABORATORIES.items() if file.startswith(start)), file)


def trials() -> Iterator[Known]:
    """Each as it is, and with faults: up to two of each kind, and of every second trial one or two in all."""
    some = (known for patterns in (FILES, OTHERS) for part in (0, 1) for known in labelled(part, patterns))
    for k, known in enumerate(some):
        yield known
        rng = np.random.default_rng([k, 5])
        few = dict(Counter(rng.choice(list(FAULTS), size=int(rng.integers(1, 3))).tolist()))
        yield with_faults(known, k, counts=few if k % 2 else None)


def told() -> list[Told]:
    rows = []
    with mock.patch.object(OF_PATHS, "by_trial", lambda found: found):
        OF_PATHS._found.cache_clear()
        for k, known in enumerate(trials()):
            some = [one for one in listed(known).items if one.kind in KINDS and "nats_a_frame" not in one.values]
            wrong = np.array([one.wrong for one in some])
            for one, evidence in zip(some, of_trial(wrong, known.trajectories.rate), strict=True):
                true = truth_of(known, one)
                if true is not None:
                    rows.append(Told(laboratory(known.name), one.kind, one.wrong, tuple(evidence.tolist()), true, k))
    return rows


def of_trial(wrong: Floats, rate: float) -> Floats:
    """(N, 4) of the problems of a trial."""
    sure, logit = wrong >= SURE, scipy.special.logit(np.clip(wrong, LEAST, 1 - LEAST))
    among = np.where(sure, wrong, 0.0).sum() - np.where(sure, wrong, 0.0)
    rates = np.full(len(wrong), np.log(rate / 60.0))
    return np.column_stack([logit, np.log1p(among), np.log1p(as_common(logit, sure)), rates])


def as_common(logit: Floats, sure: Bools) -> Floats:
    """(2) of the problems (N) of a trial."""
    unsure, order = logit[~sure], np.argsort(-logit, kind="stable")
    count = np.array([np.exp(-((unsure - z) ** 2) / 2).sum() for z in logit[order]], np.float64) - ~sure[order]
    out = np.zeros(len(logit))
    out[order] = np.maximum.accumulate(count)
    return out


def fit(rows: Sequence[Told]) -> Floats:
    """Coefficients of (1), slightly drawn to nothing."""
    x, y = np.array([(1.0, *row.evidence) for row in rows]), np.array([float(row.true) for row in rows])
    of = {place: {row.trial for row in rows if row.laboratory == place} for place in {row.laboratory for row in rows}}
    weight = np.array([len(of[row.laboratory]) ** -0.5 for row in rows])
    weight *= len(weight) / weight.sum()

    def cost(c: Floats) -> tuple[float, Floats]:
        z = x @ c
        slope = x.T @ (weight * (scipy.special.expit(z) - y)) + 0.1 * np.append(0.0, c[1:])
        return float((weight * (np.logaddexp(0, z) - y * z)).sum() + 0.05 * (c[1:] ** 2).sum()), slope

    return np.asarray(scipy.optimize.minimize(cost, np.zeros(5), jac=True, method="L-BFGS-B").x)


def main() -> None:
    report(told(), fit)


if __name__ == "__main__":
    main()
