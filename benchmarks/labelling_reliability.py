"""Whether stated probabilities are true: labels of random shreds, kept with what was known of each.

    python benchmarks/labelling_reliability.py                                the table, by the coefficients as they are
    python benchmarks/labelling_reliability.py --keep parts:400000-400040 …   label these shreds, and add their labels

Kinds of shreds are those of `labelling_shreds.py`. Each label counts once, by its longest track, as its tracks are
right or wrong together. All labels that were below `SURELY` or are wrong are kept, and of the others of a shred one in
`OF_MANY`, which counts for those of them that there are. What is kept is what the probability is made of
(`label.margin`), so that other coefficients are judged without labelling anew; a change of what names tracks, or of
what is measured of them, wants new shreds.
`tests/label/test_reliability.py` holds the file against the coefficients. Needs KINEMARK_DATA, as `labelling.py`.
"""

from __future__ import annotations

import argparse
import csv
import os
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import numpy as np
from labelling_scores import BINS
from labelling_shredded import Shredded, shredded
from labelling_shreds import drawn, seeds_of

import kinemark.label.distances as of_distances
from kinemark.data.array_types import Bools, Floats
from kinemark.label import Distances, Labels, Template, label
from kinemark.label.calibration import calibrated_shift
from kinemark.label.distances import probability_by
from kinemark.label.margin import Margins

KEPT = Path(__file__).with_name("labelling_reliability.csv")
"""Labels of shreds that no coefficient was chosen on when they were labelled."""
SURELY, OF_MANY = 0.995, 20
"""Probability from which on right labels are counted, and one in so many is kept; chosen, to keep the file small."""
FIRST = ("shred", "row", "name", "right", "counts", "another", "most", "weight", "shift")
"""Columns before those of `Margins`."""


class Known(NamedTuple):
    """Of tracks, what was known when their probabilities (T) were stated, and the names that they had."""

    tracks: tuple[str, ...]
    names: tuple[str | None, ...]
    p: Floats
    about: Margins
    weight: Floats
    shift: float
    another: bool


class Kept(NamedTuple):
    """N labels: of which shred, whether right, how many each counts for, and the probability as it is stated now."""

    shred: tuple[str, ...]
    right: Bools
    counts: Floats
    p: Floats


class Bin(NamedTuple):
    """Labels whose probability is from `low` to below `high`: how many, of how many shreds, their probability and the
    share of right ones in the mean, and the standard error of the difference of both, the greater of those with shreds
    and with labels as independent ones."""

    low: float
    high: float
    labels: float
    shreds: int
    p: float
    right: float
    error: float


def watched(parts: Shredded, template: Template) -> tuple[Labels, list[Known]]:
    """The labels of a shred, and what was known each time that probabilities were stated."""
    known, shifts = list[Known](), list[float]()
    stated = of_distances.probability_of_all

    def shift_seen(*args: Any, **more: Any) -> float:
        shifts.append(calibrated_shift(*args, **more))
        return shifts[-1]

    def stated_seen(tracks: Any, template: Any, pairs: Any, label: Any, about: Any, weight: Any, method: Any) -> Floats:
        p = stated(tracks, template, pairs, label, about, weight, method)
        names = tuple(template.names[a] if a >= 0 else None for a in label.tolist())
        known.append(Known(tracks.names, names, p, about, weight, shifts[-1], bool(np.any(template.doubt))))
        return p

    with patch.multiple(of_distances, probability_of_all=stated_seen, calibrated_shift=shift_seen):
        return label(parts.tracks, template), known


def lines_of(
    shred: str, row: str, template: Sequence[str], found: Labels, parts: Shredded, known: Sequence[Known]
) -> Iterator[list[str]]:
    """A line of the file for each label that is kept."""
    n, plain = np.isfinite(parts.tracks.xyz[..., 0]).sum(1), list[list[str]]()
    for name in sorted({str(one) for one in found.names if one is not None}):
        own = [t for t, one in enumerate(found.names) if one == name]
        t = max(own, key=lambda t: n[t])
        right, p = parts.truth[t] == name and name in template, float(found.probability[t])
        at = [(one, one.tracks.index(parts.tracks.names[t])) for one in known if parts.tracks.names[t] in one.tracks]
        at = [(one, k) for one, k in at if one.names[k] == name and one.p[k] >= p - 1e-9]
        if at:
            one, k = min(at, key=lambda pair: float(pair[0].p[pair[1]]))
            line = [
                shred, row, name, f"{right:d}", "1", f"{one.another:d}",
                "1" if one.p[k] < p + 1e-9 else f"{p:.4g}", f"{one.weight[k]:.4g}", f"{one.shift:.4g}",
                *(f"{part[k]:.4g}" for part in one.about),
            ]  # fmt: skip
            if right and p >= SURELY:
                plain.append(line)
            else:
                yield line
    for first in range(0, len(plain), OF_MANY):
        of = plain[first : first + OF_MANY]
        of[0][FIRST.index("counts")] = f"{len(of)}"
        yield of[0]


def keep(shreds: Sequence[tuple[str, int]], file: Path = KEPT) -> None:
    """Label shreds, of kinds and seeds, and add their labels to the file."""
    new = not file.exists()
    with file.open("a", newline="") as stream:
        out = csv.writer(stream, lineterminator="\n")
        if new:
            out.writerow([*FIRST, *Margins._fields])
        for kind, seed in shreds:
            row, how = drawn(kind, seed)
            parts = shredded(row.trial, seed=seed, **how)
            found, known = watched(parts, row.template)
            out.writerows(lines_of(f"{kind}:{seed}", row.name, row.template.names, found, parts, known))
            stream.flush()


def kept_labels(file: Path = KEPT) -> Kept:
    """The labels of a file, with the probabilities that the coefficients as they are give them."""
    with file.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    column = {key: np.array([float(row[key]) for row in rows]) for key in (*FIRST[3:], *Margins._fields)}
    another, p = column["another"] > 0, np.zeros(len(rows))
    for other in (False, True):
        own = another == other
        about = Margins(*(column[key][own] for key in Margins._fields))
        p[own] = probability_by(about, column["weight"][own], another=other, shift=column["shift"][own])
    shred = tuple(row["shred"] for row in rows)
    return Kept(shred, column["right"] > 0, column["counts"], np.minimum(p, column["most"]))


def bins_of(kept: Kept) -> list[Bin]:
    """A line a bin of probabilities."""
    out = []
    for low, high in pairwise(BINS):
        own = np.flatnonzero((kept.p >= low) & ((kept.p < high) | (high >= 1)))
        if len(own):
            n, off = kept.counts[own], kept.counts[own] * (kept.right[own] - kept.p[own])
            each, at = np.unique([kept.shred[k] for k in own], return_inverse=True)
            by_shreds, by_labels = np.bincount(at, off), n * np.sqrt(kept.p[own] * (1 - kept.p[own]))
            error = float(np.sqrt(max((by_shreds**2).sum(), (by_labels**2).sum())) / n.sum())
            mean, right = (float((n * part[own]).sum() / n.sum()) for part in (kept.p, kept.right))
            out.append(Bin(low, high, float(n.sum()), len(each), mean, right, error))
    return out


def sure_wrong(kept: Kept) -> tuple[float, float]:
    """How many sure labels are wrong, and how many are sure."""
    sure = kept.counts * (kept.p >= Distances().sure)
    return float(sure[~kept.right].sum()), float(sure.sum())


def table(kept: Kept) -> list[str]:
    """Lines to be read."""
    lines = [
        f"{one.low:.2f}–{one.high:.2f} {one.labels:7.0f} labels of {one.shreds:4d} shreds  mean p {one.p:.4f}  "
        f"right {one.right:.4f}  difference {one.right - one.p:+.4f} ± {one.error:.4f}"
        for one in bins_of(kept)
    ]
    wrong, sure = sure_wrong(kept)
    return [*lines, f"of {sure:.0f} sure labels {wrong:.0f} are wrong, {100 * wrong / max(sure, 1):.3f} %"]


def main() -> None:
    """Do what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", nargs="*", default=[], help="kind:from-to")
    asked = parser.parse_args()
    if asked.keep:
        keep([one for part in asked.keep for one in seeds_of(part)])
    print(*table(kept_labels()), sep="\n")


if __name__ == "__main__":
    main()
