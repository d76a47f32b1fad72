"""Random shreds of labelled trials: how often names are right by their probability, and the coefficients of it.

    python benchmarks/labelling_shreds.py static:31000-31060 …    reliability of these seeds
    python benchmarks/labelling_shreds.py --fit                   the coefficients of `label.margin` by `FITTED`

Kinds are own (the subject's walks), static (static trials), other (another subject's template), crowded (own or
static, with 1 to 40 further markers on the body, up to 3 points that stand still and ghosts that are twins of
markers) and parts (own or static, a part of the body alone). A row of `labelling_cases.py` is drawn at random; two in
five shreds are of the whole trial, the others windows of 0.4 to 3 s; two in five have neither absent nor extra markers,
the others up to 4 and 3; 1 to 25 pieces a marker; 0 to 5 ghosts a frame of all kinds. Names of one label are right or
wrong together, so that each label of a shred counts once; and names of one shred often are, so that intervals (95 %)
are by drawing whole shreds.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import numpy as np
import scipy
from labelling_cases import (
    CHILDREN,
    MIXED,
    TWINS,
    Row,
    halves,
    other_child,
    placed_otherwise,
    same_subject,
    several_children,
    static_children,
    static_sets,
    static_trials,
    walkers,
    walkers_of_many_kinds,
)
from labelling_scores import BINS
from labelling_shredded import shredded

from kinemark.data import Trajectories
from kinemark.data.array_types import Bools, Floats, Ints
from kinemark.label import Distances
from kinemark.label.decided_sides import at_most_even, decided_sides
from kinemark.label.distances import probability_of_all
from kinemark.label.evidence import PairScore
from kinemark.label.margin import (
    BETA_TRACK,
    GAINED,
    GAINED_OTHER,
    MOST_OF_LABEL,
    Margins,
    first_factors,
    label_features,
    margins,
    track_features,
)
from kinemark.label.solve import solve
from kinemark.label.stretches import stretches_of

FITTED = (
    "static:30000-30140",
    "own:30000-30060",
    "own:9000-9050",
    "other:9000-9110",
    "other:9500-9560",
    "other:30000-30020",
)
"""Seeds by which the coefficients were measured; chosen: as many shreds as an hour labels."""
FORMER = {
    False: (-3.49, 0.44, 1.70, 0.32, 0.0, 3.39, 1.92, 1.34, 0.0, 11.09, 5.35, 3.91, 1.65, 0.0, 0.0),
    True: (-3.26, 0.79, 0.0, 0.31, 0.0, 2.12, 2.25, 2.38, 1.0, 2.0, 4.0, 0.0, 0.0, 0.0, 0.0),
}
"""Coefficients of the subject's own template and of another's, to which the new ones are drawn; measured on 7 749
labels of 190 shreds and on 117 shreds, when trials with nothing left over were not told apart."""
RIDGE = {False: 10.0, True: 1.0}
"""On the squares of what a coefficient's change does by one standard deviation of its feature; chosen: subjects left
out in turn told 0.3 to 10 alike; of these the one by which most right names of 130 further shreds were sure."""
RIDGE_PIECE = 0.3
"""The same of pieces, whose coefficients are drawn to those of whole tracks; chosen: 0.3 and 3 tell subjects that are
left out alike."""

PART = (0.3, 0.75)
"""Shares of the markers that a part of the body has, the least and the greatest; chosen: legs and upper bodies alone
have 0.35 to 0.65."""
LEAST_OF_PART = 7
"""Markers of it; chosen: fewer are mostly refused."""
LOOSE = 5.0
"""How much longer a step along the body is by a standard deviation of the distance; chosen: hands are far from thighs.
"""
DRAWS = 2000
"""Of shreds, for an interval; chosen."""


class Shred(NamedTuple):
    """Of T tracks with a name: what is known of each, what it is called and is.

    Attributes:
        row, seed: of which. doubted: the template is another subject's. about: margins of all tracks.
        weight: (T) independent frames. label, truth: (T) −1 and below for none. probability: (T).
        samples: (T). real: samples of markers that the template knows.
    """

    row: str
    seed: int
    doubted: bool
    about: Margins
    weight: Floats
    label: Ints
    truth: Ints
    probability: Floats
    samples: Ints
    real: int


@cache
def rows_of(kind: str) -> tuple[Row, ...]:
    """From which a row is drawn."""
    if kind == "other":
        pairs = [row for name in CHILDREN for row in other_child(name)]
        scaled = [row for row in walkers_of_many_kinds() if "scaled" in row.name]
        return (*pairs, *[*several_children()] * 2, *scaled, *placed_otherwise())
    if kind == "crowded":
        return (*rows_of("static"), *same_subject(), *halves())
    if kind == "parts":
        return (*[*static_sets()] * 2, *same_subject())
    if kind == "static":
        return (*[*static_trials()] * 2, *static_sets(), *static_children())
    kinds = [row for row in walkers_of_many_kinds() if "scaled" not in row.name and "frame" not in row.name]
    return (*same_subject(), *halves(), *walkers(), *kinds)


def drawn(kind: str, seed: int) -> tuple[Row, dict[str, Any]]:
    """A row, its trial cut to a window, and the arguments of `shredded`."""
    rng, rows = np.random.default_rng([seed, 1616]), rows_of(kind)
    row = rows[int(rng.integers(len(rows)))]
    F, rate, many = row.trial.n_frames, row.trial.rate, len(row.trial) > 20
    whole, pieces, clean = rng.random() < 0.4, int(rng.choice([1, 1, 1, 2, 4, 8, 15, 25])), rng.random() < 0.4
    how: dict[str, Any] = {
        "ghosts": float(rng.choice([0, 1, 2, 3, 5])),
        "kinds": (("walk",), MIXED)[rng.integers(2)],
        "absent": 0 if clean else int(rng.choice([0, 0, 1, 2, 3, 4] if many else [0, 0, 1])),
        "extra": 0 if clean else int(rng.choice([0, 0, 1, 2, 3] if many else [0, 1])),
    }
    if kind == "crowded":
        how |= {
            "kinds": TWINS,
            "extra": int(rng.choice([1, 2, 5, 10, 20, 40])),
            "still": int(rng.choice([0, 0, 1, 3])),
        }
    n = F if whole else int(np.clip(rng.uniform(0.4, 3) * rate, 20, F))
    first = int(rng.integers(0, F - n + 1))
    trial = row.trial.frames(first, first + n)
    if kind == "parts":
        trial = part_of(trial, float(rng.uniform(*PART)), rng)
    return row._replace(trial=trial), how | {"pieces": max(1, min(pieces, n // 4))}


def part_of(trial: Trajectories, share: float, rng: np.random.Generator) -> Trajectories:
    """A marker at random, and those nearest to it along the body, so that there is this share of the markers.

    Along the body is from marker to marker whose distance keeps: a hand is not near to the thigh that it passes by.
    """
    d = np.linalg.norm(trial.xyz[:, None] - trial.xyz[None], axis=3)
    seen = np.isfinite(d)
    n = np.maximum(seen.sum(2), 1)
    mean = np.where(seen, d, 0.0).sum(2) / n
    spread = np.sqrt(np.where(seen, (d - mean[..., None]) ** 2, 0.0).sum(2) / n)
    step = scipy.sparse.csr_array(np.where(seen.any(2), (mean + LOOSE * spread) ** 2, 0.0))
    along = scipy.sparse.csgraph.dijkstra(step, directed=False, indices=[int(rng.integers(len(trial)))])
    kept = np.argsort(along[0], kind="stable")[: max(LEAST_OF_PART, round(share * len(trial)))]
    return trial.select([trial.names[i] for i in sorted(kept.tolist())])


def shred(kind: str, seed: int) -> Shred | None:
    """One, labelled; None where it was refused."""
    row, how = drawn(kind, seed)
    parts, method, template = shredded(row.trial, seed=seed, **how), Distances(), row.template
    stretches, pairs = stretches_of(parts.tracks, template.size), PairScore.of_template(template)
    found = solve(
        stretches, template, pairs,
        key_frames=method.key_frames, beam=method.beam, least_fit=method.least_track_fit,
    )  # fmt: skip
    sides = decided_sides(stretches, found.label, template, pairs)
    if found.score < method.least_fit * template.own_fit * found.expected:
        return None
    after = found.after if (sides.label == found.label).all() else None
    about = margins(stretches, sides.label, template, pairs, after)
    p = probability_of_all(parts.tracks, template, after or pairs, sides.label, about, stretches.weight, method)
    number = {name: k for k, name in enumerate(template.names)}
    truth = np.array([-1 if name is None else number.get(name, -2) for name in parts.truth])
    n = stretches.seen.sum(1)
    return Shred(
        row.name, seed, bool(np.any(template.doubt)), about, stretches.weight, sides.label, truth,
        at_most_even(p, sides.undecided), n, int(n[truth >= 0].sum()),
    )  # fmt: skip


class Cases(NamedTuple):
    """Of labels of shreds: features (n, k) of (4), its first two factors (n), whether they are right, on what."""

    x: Floats
    odds: Floats
    right: Bools
    doubted: Bools


def cases(shreds: Sequence[Shred]) -> Cases:
    """Each label of each shred, by its longest track."""
    x, odds, right, doubted = [], [], [], []
    for one in shreds:
        features, odd = label_features(one.about), first_factors(one.about, GAINED_OTHER if one.doubted else GAINED)
        for a in np.unique(one.label[one.label >= 0]).tolist():
            own = np.flatnonzero(one.label == a)
            longest = own[one.samples[own].argmax()]
            x.append(features[longest])
            odds.append(odd[longest])
            right.append(one.samples[own][one.truth[own] == a].sum() > 0.5 * one.samples[own].sum())
            doubted.append(one.doubted)
    return Cases(np.array(x), np.array(odds), np.array(right), np.array(doubted))


def piece_cases(shreds: Sequence[Shred]) -> Cases:
    """Each piece of labels that are right, by features of (3); its odds are 1."""
    x, right, doubted = [], [], []
    for one in shreds:
        features = track_features(one.about, one.weight)
        for a in np.unique(one.label[one.label >= 0]).tolist():
            own = np.flatnonzero(one.label == a)
            good = one.truth[own] == a
            if one.samples[own][good].sum() > 0.5 * one.samples[own].sum():
                pieces = one.about.share[own] < MOST_OF_LABEL
                x.append(features[own][pieces])
                right.append(good[pieces])
                doubted.append(np.full(pieces.sum(), one.doubted))
    good = np.concatenate(right)
    return Cases(np.concatenate(x), np.ones(len(good)), good, np.concatenate(doubted))


def fitted(x: Floats, odds: Floats, right: Bools, former: Floats, ridge: float) -> Floats:
    """β of (3) or (4), the most probable one; none but the first is below 0.

    What fits better makes no name less sure.
    """
    scale = np.r_[0.0, x[:, 1:].std(0)]

    def loss(beta: Floats) -> tuple[float, Floats]:
        own = 1 / (1 + np.exp(-np.clip(x @ beta, -30, 30)))
        p = np.clip(own * odds, 1e-12, 1 - 1e-12)
        slope = np.where(right, 1 - own, -p / (1 - p) * (1 - own))
        held = ridge * scale**2 * (beta - former)
        return float(-np.log(np.where(right, p, 1 - p)).sum() + (beta - former) @ held), -slope @ x + 2 * held

    bounds = [(None, None), *[(0, None)] * (x.shape[1] - 1)]
    return np.asarray(scipy.optimize.minimize(loss, former, jac=True, method="L-BFGS-B", bounds=bounds).x)


class Named(NamedTuple):
    """Of N tracks with a name: shred, probability, whether it is right, samples, and what each counts as a label."""

    shred: Ints
    p: Floats
    right: Bools
    samples: Ints
    share: Floats

    @classmethod
    def of(cls, shreds: Sequence[Shred]) -> Named:
        """All of them; the tracks of a label count one together."""
        kept = [(one, one.label >= 0) for one in shreds]
        return cls(
            np.repeat(np.arange(len(kept)), [own.sum() for _, own in kept]),
            np.concatenate([one.probability[own] for one, own in kept]),
            np.concatenate([(one.label == one.truth)[own] for one, own in kept]),
            np.concatenate([one.samples[own] for one, own in kept]),
            np.concatenate([1 / np.bincount(one.label[own])[one.label[own]] for one, own in kept]),
        )


def interval(part: Floats, of: Floats, shred: Ints) -> tuple[float, float]:
    """Of Σ part / Σ of, by drawing shreds with replacement; those without any tell nothing."""
    shred = np.unique(shred, return_inverse=True)[1]
    n = int(shred.max()) + 1
    drawn_ones = np.random.default_rng(0).integers(0, n, (DRAWS, n))
    above, below = (np.bincount(shred, each, n)[drawn_ones].sum(1) for each in (part, of))
    low, high = np.quantile(above / np.maximum(below, 1e-9), [0.025, 0.975])
    return float(low), float(high)


def reliability_text(every: Named) -> list[str]:
    """A line a bin: labels, of how many shreds, their probability, how many are right, and right less probability."""
    out = []
    for low, high in pairwise(BINS):
        own = (every.p >= low) & ((every.p < high) | (high >= 1))
        if own.any():
            w, off = every.share[own], every.right[own] - every.p[own]
            less, more = interval(w * off, w, every.shred[own])
            out.append(
                f"  {low:.2f}–{high:.2f} {w.sum():8.1f} labels of {len(np.unique(every.shred[own])):4d} shreds  mean p "
                f"{w @ every.p[own] / w.sum():.4f}  right {w @ every.right[own] / w.sum():.4f}  difference "
                f"{w @ off / w.sum():+.3f} ({less:+.3f} to {more:+.3f})"
            )
    return out


def table(shreds: Sequence[Shred]) -> None:
    """Reliability of tracks, each label of a shred counting once, and what is sure and right, or sure and wrong."""
    every = Named.of(shreds)
    print(*reliability_text(every), sep="\n")
    real, sure = sum(one.real for one in shreds), every.p >= Distances().sure
    right, n, log = every.right, every.samples, -np.log(np.clip(np.where(every.right, every.p, 1 - every.p), 1e-6, 1))
    wrong = (sure & ~right).astype(float)
    print(
        f"  {len(shreds)} shreds; samples sure and right {100 * n[sure & right].sum() / real:.2f} %, sure and wrong "
        f"{100 * n[sure & ~right].sum() / real:.3f} %, right if all are taken {100 * n[right].sum() / real:.2f} %; "
        f"log score {every.share @ log / every.share.sum():.4f}"
    )
    for what, count in (("tracks", np.ones(len(n))), ("labels", every.share)):
        less, more = (100 * one for one in interval(wrong * count, sure * count, every.shred))
        print(
            f"  of {count[sure].sum():.0f} sure {what} {wrong @ count:.1f} are wrong, "
            f"{100 * (wrong @ count) / max(count[sure].sum(), 1):.3f} % ({less:.3f} to {more:.3f})"
        )


def seeds_of(part: str) -> list[tuple[str, int]]:
    """Kind and seed, from `kind:from-to`."""
    kind, both = part.split(":")
    first, stop = map(int, both.split("-"))
    return [(kind, seed) for seed in range(first, stop)]


def main() -> None:
    """Do what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seeds", nargs="*", help="kind:from-to")
    parser.add_argument("--fit", action="store_true")
    asked = parser.parse_args()
    jobs = [job for part in asked.seeds or FITTED for job in seeds_of(part)]
    with ProcessPoolExecutor(2) as pool:
        shreds = [one for one in pool.map(shred, *zip(*jobs, strict=True), chunksize=4) if one is not None]
    for doubted in (False, True):
        own_kind = [one for one in shreds if one.doubted == doubted]
        if own_kind:
            print("another subject's template" if doubted else "the subject's own template")
            table(own_kind)
    if asked.fit:
        every = cases(shreds)
        for name, own in (("BETA_LABEL", ~every.doubted), ("BETA_OTHER", every.doubted)):
            if own.any():
                other = name == "BETA_OTHER"
                beta = fitted(every.x[own], every.odds[own], every.right[own], np.array(FORMER[other]), RIDGE[other])
                print(name, "=", tuple(np.round(beta, 2).tolist()))
        pieces = piece_cases(shreds)
        own = ~pieces.doubted
        if own.any():
            beta = fitted(pieces.x[own], pieces.odds[own], pieces.right[own], np.array(BETA_TRACK), RIDGE_PIECE)
            print("BETA_PIECE =", tuple(np.round(beta, 2).tolist()))


if __name__ == "__main__":
    main()
