"""Labelled trials without their names, whole or in pieces, among ghosts: which names come back, and how sure.

    python benchmarks/labelling.py [part of a row's name …] [--pieces 1 15] [--seeds 1 2]    the table
    python benchmarks/labelling.py --varied [--seeds 1 2]    all rows, shredded in many ways
    python benchmarks/labelling.py --fit    the coefficients of `label.margin`, from the rows that are tuned on

`labelling_cases.py` says which trials. Each marker is one track or is cut at random into 15; 2 ghosts a frame of 3 to
40 frames each are added, and all are shuffled. For each row: samples with the right name, with a wrong one, and not
sure, in % of all that markers have (a name that is not sure counts as none); ghosts that have a sure name, in % of
their samples; right and wrong if all names were taken; frames all right; fit; CPU s. Below stands how often names are
right by their probability, over the rows on which it was tuned and over the rest.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from typing import NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import numpy as np
import scipy
from labelling_cases import VARIED, Row, Shredding, more_rows, rows, walkers
from metrics import Metric
from numpy.typing import NDArray

from kinemark.label import Distances, Labels, LabelScore, Shredded, label, reliability, score_labels, shredded
from kinemark.label.evidence import PairScore
from kinemark.label.margin import features, margins
from kinemark.label.stretches import stretches_of


class Result(NamedTuple):
    """Of one row: what came back, how it fitted, how long it took."""

    score: LabelScore
    labels: Labels
    cpu_s: float


def tracks_of(row: Row, how: Shredding, seed: int) -> Shredded:
    """A row's trial, shredded."""
    return shredded(row.trial, how.pieces, how.ghosts, seed, kinds=how.kinds, absent=how.absent, extra=how.extra)


def result(row: Row, how: Shredding, seed: int) -> Result:
    """One row, shredded and labelled."""
    parts = tracks_of(row, how, seed)
    clock = time.process_time()
    found = label(parts.tracks, row.template)
    spent = time.process_time() - clock
    return Result(score_labels(found, parts, row.template.names if row.fits else ()), found, spent)


def fitted(tuned: Sequence[Row]) -> NDArray[np.float64]:
    """β of `label.margin` (2): logistic regression, each case with the same weight."""
    X, y, w = [], [], []
    for k, row in enumerate(tuned):
        for seed, how in ((1, Shredding(15)), (101, VARIED[k % len(VARIED)])):
            parts = tracks_of(row, how, seed)
            found = label(parts.tracks, row.template, method=Distances(least_fit=0.0, least_placed=0.0))
            stretches = stretches_of(parts.tracks, row.template.size)
            place = {name: i for i, name in enumerate(row.template.names)}
            number = np.array([-1 if name is None else place[name] for name in found.names])
            about = margins(stretches, number, row.template, PairScore.of_template(row.template), found.fit)
            own = number >= 0
            X.append(features(about, stretches.weight)[own])
            y.append(np.array([row.fits and a == b for a, b in zip(found.names, parts.truth, strict=True)])[own])
            w.append(np.full(own.sum(), 1 / max(own.sum(), 1)))
    x, right, weight = np.concatenate(X), 2.0 * np.concatenate(y) - 1, np.concatenate(w)

    def loss(beta: NDArray[np.float64]) -> float:
        return float(
            (weight * np.logaddexp(0, -right * (x @ beta))).sum() / weight.sum() + 1e-4 * (beta[1:] ** 2).sum()
        )

    return np.asarray(scipy.optimize.minimize(loss, np.zeros(x.shape[1])).x)


def reliability_text(scores: Sequence[LabelScore]) -> list[str]:
    """A line a bin, and the share of sure tracks that are wrong."""
    p, good = (np.concatenate([getattr(one, name) for one in scores]) for name in ("probability", "good"))
    lines = [
        f"  {one.low:.2f}–{one.high:.2f} {one.names:7d} names  mean p {one.probability:.3f}  right {one.right:.3f}  "
        f"samples right {one.samples_right:.4f}"
        for one in reliability(scores)
    ]
    sure = p >= Distances().sure
    return [*lines, f"  of {sure.sum()} sure tracks {100 * (1 - good[sure].mean()):.3f} % are wrong"]


def metrics() -> list[Metric]:
    """For `compare.py`: the synthetic walkers, which are everywhere."""
    checked = [row for row in walkers() if row.name in ("walker 15 seed 2", "walker 39 seed 2")]
    out, scores = [], []
    for row in checked:
        for pieces in (1, 15):
            one = result(row, Shredding(pieces), 1).score
            scores.append(one)
            name = f"{row.name}, ×{pieces}"
            out.append(Metric(f"right, {name}", 100 * one.right, "%", "more", absolute=0.5))
            out.append(Metric(f"wrong, {name}", 100 * one.wrong, "%", "less", absolute=0.05))
            out.append(Metric(f"frames all right, {name}", 100 * one.frames, "%", "more", absolute=5.0))
            out.append(Metric(f"ghosts named, {name}", 100 * one.ghosts, "%", "less", absolute=0.5))
    p, good = (np.concatenate([getattr(one, key) for one in scores]) for key in ("probability", "good"))
    return [*out, Metric("Brier score of probabilities", float(((p - good) ** 2).mean()), "1", "less", absolute=0.002)]


HEAD = ("right", "wrong", "unsure", "ghosts", "best r.", "best w.", "frames")


def table(chosen: Sequence[tuple[Row, Shredding]], seeds: Sequence[int]) -> None:
    """A line each, and reliability below."""
    print(f"{'':46s}{'':>4s}" + "".join(f"{one:>8s}" for one in (*HEAD, "fit", "CPU s")))
    kept: dict[bool, list[LabelScore]] = {True: [], False: []}
    for row, how in chosen:
        for seed in seeds:
            one = result(row, how, seed)
            kept[row.tuned].append(one.score)
            figures = "".join(f"{100 * value:8.2f}" for value in one.score[:7])
            end = "  refused" if one.labels.refused else ""
            print(
                f"{row.name:46s}{'×' + str(how.pieces):>4s}{figures}{one.labels.fit:8.2f}{one.cpu_s:8.2f}{end}",
                flush=True,
            )
    for own, title in ((True, "tuned"), (False, "checked")):
        if kept[own]:
            print(f"reliability, {title}", *reliability_text(kept[own]), sep="\n")


def main() -> None:
    """Do what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--pieces", type=int, nargs="*", default=[1, 15])
    parser.add_argument("--seeds", type=int, nargs="*", default=[1])
    parser.add_argument("--varied", action="store_true")
    parser.add_argument("--fit", action="store_true")
    asked = parser.parse_args()
    every = [*rows(), *(more_rows() if asked.varied or asked.fit else ())]
    chosen = [row for row in every if not asked.names or any(name in row.name for name in asked.names)]
    if asked.fit:
        print("beta", np.round(fitted([row for row in chosen if row.tuned]), 2))
    elif asked.varied:
        table([(row, VARIED[(k + 3) % len(VARIED)]) for k, row in enumerate(chosen)], asked.seeds)
    else:
        table([(row, Shredding(pieces)) for row in chosen for pieces in asked.pieces], asked.seeds)


if __name__ == "__main__":
    main()
