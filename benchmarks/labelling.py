"""Labelled trials without their names, whole or in pieces, among ghosts: which names come back, and how sure.

    python benchmarks/labelling.py [part of a row's name …] [--pieces 1 15] [--seeds 1 2]    the table
    python benchmarks/labelling.py --exchanges    tracks that go over from one marker to another: found, cut and named
    python benchmarks/labelling.py --exchanges --hidden 0.1    the same, both hidden for so many seconds about it
    python benchmarks/labelling.py --varied [--seeds 1 2]    all rows, shredded in many ways
    python benchmarks/labelling.py --beside 10 20 30    a marker taken off, another worn so many mm beside its place

How probabilities were measured, and how true they are of random shreds, is `labelling_shreds.py`.

`labelling_cases.py` and `labelling_parts.py` say which trials. Each marker is one track or is cut at random into 15; 2
ghosts a frame of 3 to 40 frames each are added, but where nameless tracks of the file are there, and all are shuffled.
For each row: samples with the right name, with a wrong one, and not sure, in % of all that markers have (a name that is
not sure counts as none); ghosts that have a sure name, in % of their samples; right and wrong if all names were taken;
frames all right; fit; CPU s. Below stands how often names are right by their probability, over the rows on which it was
tuned and over the rest.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import numpy as np
from labelling_cases import VARIED, Row, Shredding, more_rows, rows, walkers, with_one_beside
from labelling_parts import rows_of_parts
from labelling_scores import LabelScore, SwitchScore, cut_truth, reliability, score_labels, score_switches
from labelling_shredded import Shredded, shredded
from metrics import Metric

from kinemark.label import Distances, Labels, label, label_switching
from kinemark.label.bystanders import among_bystanders


class Result(NamedTuple):
    """Of one row: what came back, how it fitted, how long it took."""

    score: LabelScore
    labels: Labels
    cpu_s: float


def tracks_of(row: Row, how: Shredding, seed: int) -> Shredded:
    """A row's trial, shredded."""
    ghosts = 0.0 if row.nameless else how.ghosts
    return shredded(
        row.trial, how.pieces, ghosts, seed, kinds=how.kinds, absent=how.absent, extra=how.extra, still=how.still
    )


def result(row: Row, how: Shredding, seed: int) -> Result:
    """One row, shredded and labelled."""
    parts = tracks_of(row, how, seed)
    clock = time.process_time()
    found = label(parts.tracks, row.template)
    if row.wider is not None:
        found = among_bystanders(parts.tracks, found, row.template, row.wider)
    spent = time.process_time() - clock
    return Result(score_labels(found, parts, row.template.names if row.fits else ()), found, spent)


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
    for row in checked:
        cuts = cut_result(row, 1, 1).switches
        out.append(Metric(f"exchanges cut, {row.name}", 100 * cuts.found / cuts.of, "%", "more", absolute=0.5))
        out.append(Metric(f"false cuts, {row.name}", cuts.false, "", "less"))
    p, good = (np.concatenate([getattr(one, key) for one in scores]) for key in ("probability", "good"))
    return [*out, Metric("Brier score of probabilities", float(((p - good) ** 2).mean()), "1", "less", absolute=0.002)]


class Cut(NamedTuple):
    """Of one row with exchanges: cuts; labels without and with cutting."""

    switches: SwitchScore
    before: LabelScore
    after: LabelScore


EXCHANGES = {"exchanges": 2, "returns": 1, "takeovers": 2}
"""Pairs of markers whose tracks are exchanged, for good, for a while, or taken over; half as many of 15 markers."""


def cut_result(row: Row, pieces: int, seed: int, *, exchanged: bool = True, hidden_s: float = 0.0) -> Cut:
    """One row whose tracks go over to other markers, labelled as they are, and cut; or whole tracks, as a check.

    Both markers of a change are hidden for a while about it.
    """
    few = len(row.template) < 20
    how: dict[str, Any] = {key: (n + 1) // 2 if few else n for key, n in EXCHANGES.items()} if exchanged else {}
    parts = shredded(row.trial, pieces, 2.0, seed, hidden=round(hidden_s * row.trial.rate), **how)
    found = label_switching(parts.tracks, row.template)
    before, after = (
        label(parts.tracks, row.template),
        score_labels(found.labels, cut_truth(found, parts), names_of(row)),
    )
    return Cut(score_switches(found, parts), score_labels(before, parts, names_of(row)), after)


def names_of(row: Row) -> tuple[str, ...]:
    """That the row's template can know."""
    return row.template.names if row.fits else ()


def cut_table(chosen: Sequence[Row], pieces: Sequence[int], seeds: Sequence[int], hidden_s: float = 0.0) -> None:
    """A line each: cut to within five frames, cut wrongly, and wrongly of the same trial without exchanges."""
    head = ("cut", "of", "false", "of whole", "right", "→", "wrong", "→", "best r.", "→", "best w.", "→")
    print(f"{'':46s}{'':>4s}" + "".join(f"{one:>9s}" for one in head))
    total = np.zeros(4, int)
    for row in chosen:
        for n in pieces:
            for seed in seeds:
                one = cut_result(row, n, seed, hidden_s=hidden_s)
                plain = cut_result(row, n, seed, exchanged=False)
                counts = (*one.switches, plain.switches.false)
                total += counts
                shares = [100 * getattr(s, key) for key in CUT_SHARES for s in (one.before, one.after)]
                figures = "".join(f"{k:9d}" for k in counts) + "".join(f"{x:9.2f}" for x in shares)
                print(f"{row.name:46s}{'×' + str(n):>4s}{figures}", flush=True)
    print(f"{'':46s}{'':>4s}" + "".join(f"{k:9d}" for k in total))


BESIDES = 5
"""Markers of a row that are taken off, one after the other."""


class Beside(NamedTuple):
    """Of one trial: whether the marker worn beside has a name, a sure one, and is told to be beside by mm (NaN where
    not); how many others are told."""

    has_name: bool
    sure: bool
    mm: float
    others: int


def worn_beside(row: Row, name: str, mm: float, seed: int) -> Beside:
    """A marker of the row is taken off, and another worn so many mm beside."""
    parts = shredded(with_one_beside(row.trial, name, mm, seed), 1, 2.0, seed)
    found = label(parts.tracks, row.template)
    own = [k for k, one in enumerate(parts.truth) if one == "+1" and found.names[k] is not None]
    called, told = {found.names[k] for k in own}, dict(found.displaced)
    by = [told[one] for one in called if one in told]
    return Beside(bool(own), any(found.state[k] == "sure" for k in own), by[0] if by else np.nan, len(told) - len(by))


def beside_table(chosen: Sequence[Row], every_mm: Sequence[float], seeds: Sequence[int]) -> None:
    """A line each: in how many trials the marker worn beside has a name, is told, and by how many mm."""
    for row in chosen:
        for mm in every_mm:
            found = []
            for seed in seeds:
                names = sorted(set(row.template.names) & set(row.trial.names))
                some = np.random.default_rng(seed).choice(names, BESIDES, replace=False).tolist()
                found += [worn_beside(row, name, mm, seed) for name in some]
            by = [one.mm for one in found if np.isfinite(one.mm)]
            span = f"{min(by):.0f} to {max(by):.0f} mm" if by else "–"
            print(
                f"{row.name:46s}{mm:5g} mm  named {sum(one.has_name for one in found):3d} of {len(found):3d}, "
                f"surely {sum(one.sure for one in found):3d}; told {len(by):3d} ({span}), of the sure ones "
                f"{sum(one.sure and np.isfinite(one.mm) for one in found):3d}; others {sum(f.others for f in found)}",
                flush=True,
            )


CUT_SHARES = ("right", "wrong", "best_right", "best_wrong")
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
    parser.add_argument("--exchanges", action="store_true")
    parser.add_argument("--beside", type=float, nargs="*", default=[], help="mm")
    parser.add_argument("--hidden", type=float, default=0.0, help="s, about exchanges")
    asked = parser.parse_args()
    every = [*rows(), *rows_of_parts(), *(more_rows() if asked.varied else ())]
    chosen = [row for row in every if not asked.names or any(name in row.name for name in asked.names)]
    if asked.beside:
        beside_table([row for row in chosen if row.fits], asked.beside, asked.seeds)
    elif asked.exchanges:
        cut_table([row for row in chosen if row.fits], asked.pieces, asked.seeds, asked.hidden)
    elif asked.varied:
        table([(row, VARIED[(k + 3) % len(VARIED)]) for k, row in enumerate(chosen)], asked.seeds)
    else:
        table([(row, Shredding(pieces)) for row in chosen for pieces in asked.pieces], asked.seeds)


if __name__ == "__main__":
    main()
