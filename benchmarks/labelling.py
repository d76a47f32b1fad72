"""Labelled trials without their names, whole or in pieces, among ghosts: which names come back, and how sure.

    python benchmarks/labelling.py [part of a row's name …] [--pieces 1 15] [--seeds 1 2] [--fit]

Real trials come from KINEMARK_DATA (default ../shared/data); those that are absent are left out. Each marker is
one track or is cut at random into 15; 2 ghosts a frame of 3 to 40 frames each are added, and all are shuffled. For each
row: samples with the right name, with a wrong one, and not sure, in % of all that markers have (a name that is not sure
counts as none); ghosts that have a sure name, in % of their samples; right and wrong if all names were taken; fit; CPU
s. Below stands how often names are right by their probability, over the rows on which it was tuned and over the rest.

References mended: LWRA and LWRB are exchanged in all three files of HC030A (the left wrist has the handedness of the
right one); RHLX and RNAV are exchanged in HC032A18 from about frame 150 on.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise, permutations
from pathlib import Path
from typing import NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import numpy as np
import scipy
from metrics import Metric
from numpy.typing import NDArray

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.io.trial import read_trial
from kinemark.label import Distances, Labels, Template, label, learn_template
from kinemark.label.evidence import PairScore
from kinemark.label.margin import features, margins
from kinemark.label.stretches import stretches_of
from kinemark.synth import walking, with_markers

ROOT = Path(os.environ.get("KINEMARK_DATA", Path(__file__).parents[2] / "shared" / "data")) / "mocap3d"
TUNED = (
    "HC030A05",
    "HC002D",
    "HC031A",
    "prone",
    "whole body static",
    "walker 15 seed 1",
    "other child HC002D by HC030A",
    "wrong: child",
)
"""Rows by whose names the probability was tuned, and all parameters with them; the others are checks."""
FIRST_WALKS = (
    "pig_gait_child/HC030A05",
    "pig_gait_children/HC002D06",
    "pig_gait_children/HC031A06",
    "pig_gait_children/HC032A03",
    "pig_gait_children/HC033A10",
)
"""One walk of each child."""
MARKERS_OF_CHILD = """
    LFHD LBHD RFHD RBHD C7 T2 T6 T10 T12 RBAK CLAV STRN LSHO LELB LWRA LWRB LFIN RSHO RELB RWRA RWRB RFIN SACR RASI
    LASI LTHI LKNE LHFB LTUB LTIB LSHN LANK LHEE LCPG LLCA LSTL LNAV LP1M LP5M LD5M LTOE LHLX RTHI RKNE RHFB RTUB RTIB
    RSHN RANK RHEE RCPG RLCA RSTL RNAV RP1M RP5M RD5M RTOE RHLX"""
CHILD = tuple(MARKERS_OF_CHILD.split())
SIDE = {
    "thigh": "THI KNE THAP HTAD THAD KNM",
    "shank": "HFB TUB TIB SHN ANK TIAP TIAD KNE KNM MED",
    "foot": "ANK HEE CPG LCA STL NAV P1M D1M P5M D5M TOE FMH SMH VMH MED",
    "upper arm": "SHO UPA ELB",
    "forearm": "ELB FRM WRA WRB",
}
BODY = {
    "head": "LFHD LBHD RFHD RBHD",
    "trunk": "C7 T2 T6 T10 T12 RBAK CLAV STRN",
    "pelvis": "LASI RASI LPSI RPSI SACR",
}
SEGMENTS = {name: markers.split() for name, markers in BODY.items()} | {
    f"{side} {name}": [side + marker for marker in markers.split()] for side in "LR" for name, markers in SIDE.items()
}
STATIC = 0.14
"""Relative spread of distances that a static trial does not show ; chosen, see docs/theory/label.md."""


class Row(NamedTuple):
    """A template, and the trial that it labels, with the names that there are."""

    name: str
    template: Template
    trial: Trajectories
    fits: bool = True


def read(file: str) -> Trajectories:
    """A trial of the data folder, with its names mended."""
    trial = read_trial(ROOT / file).trajectories
    if "HC030A" in file:
        other = {"LWRA": "LWRB", "LWRB": "LWRA"}
        return replace(trial, paths=tuple(replace(path, name=other.get(path.name, path.name)) for path in trial))
    return _mended_foot(trial) if "HC032A18" in file else trial


def _mended_foot(trial: Trajectories) -> Trajectories:
    """RHLX and RNAV as they were at first: the navicular bone is the one nearer to the heel."""
    a, b, heel = trial["RHLX"].xyz, trial["RNAV"].xyz, trial["RHEE"].xyz
    turned = (np.linalg.norm(a - heel, axis=1) < np.linalg.norm(b - heel, axis=1))[:, None]
    new = {"RHLX": np.where(turned, b, a), "RNAV": np.where(turned, a, b)}
    return replace(
        trial,
        paths=tuple(MarkerTrajectory.measured(p.name, new[p.name]) if p.name in new else p for p in trial),
    )


def only(trial: Trajectories, names: Sequence[str]) -> Trajectories:
    """Those of the markers that the trial has."""
    return trial.select([name for name in names if name in trial.names])


def shredded(trial: Trajectories, pieces: int, ghosts: float, seed: int) -> tuple[Trajectories, tuple[str | None, ...]]:
    """Tracks without names, each marker in `pieces`, `ghosts` a frame; and whose each is, None for ghosts."""
    rng, F = np.random.default_rng(seed), trial.n_frames
    parts: list[tuple[NDArray[np.float64], str | None]] = []
    for path in trial:
        cuts = np.sort(rng.choice(np.arange(1, F), pieces - 1, replace=False)) if pieces > 1 else np.zeros(0, int)
        for a, b in zip([0, *cuts], [*cuts, F], strict=True):
            xyz = np.full((F, 3), np.nan)
            xyz[a:b] = path.xyz[a:b]
            if np.isfinite(xyz).any():
                parts.append((xyz, path.name))
    whole = trial.xyz
    for _ in range(int(ghosts * F / 20)):
        a = int(rng.integers(F))
        b = min(F, a + int(rng.integers(3, 40)))
        now = whole[:, a][np.isfinite(whole[:, a, 0])]
        if len(now):
            xyz = np.full((F, 3), np.nan)
            place = now.mean(0) + rng.normal(0, 1, 3) * now.std(0)
            xyz[a:b] = place + np.cumsum(rng.normal(0, 3, (b - a, 3)), 0)
            parts.append((xyz, None))
    order = [parts[i] for i in rng.permutation(len(parts))]
    paths = tuple(MarkerTrajectory.measured(f"*{k}", xyz) for k, (xyz, _) in enumerate(order, 1))
    return Trajectories(paths, trial.rate), tuple(name for _, name in order)


def height(trial: Trajectories) -> float:
    """Head to heel, mm: what one would measure of a subject."""
    ends = [(a, b) for a in ("LFHD", "RFHD") for b in ("LHEE", "RHEE")]
    return max(float(np.nanmedian(np.linalg.norm(trial[a].xyz - trial[b].xyz, axis=1))) for a, b in ends)


def rows() -> Iterator[Row]:
    """All cases whose files are here."""
    if ROOT.is_dir():
        yield from same_subject()
        yield from static_trials()
        yield from other_children()
        yield from wrong_templates()
    yield from walkers()


def walkers() -> Iterator[Row]:
    """One synthetic walk labels another."""
    for n in (15, 39):
        for seed in (1, 2, 3):
            one, two = (
                with_markers(walking(duration_s=4, rate=100.0, seed=k, wobble_mm=1.0), n, seed=seed).trajectories
                for k in (seed, seed + 10)
            )
            yield Row(f"walker {n} seed {seed}", learn_template(one), two)


def same_subject() -> Iterator[Row]:
    """Another trial, or the other half of one."""
    for child, one, two in (
        ("pig_gait_child/HC030A", "05", "22"),
        ("pig_gait_children/HC002D", "06", "25"),
        ("pig_gait_children/HC031A", "06", "23"),
        ("pig_gait_children/HC032A", "03", "18"),
        ("pig_gait_children/HC033A", "10", "22"),
    ):
        a, b = (only(read(f"{child}{n}.c3d"), CHILD) for n in (one, two))
        yield Row(f"{child[-6:]}{one} labels {two}", learn_template(a), b)
        yield Row(f"{child[-6:]}{two} labels {one}", learn_template(b), a)
    gait, prone = read("qualisys_gait/Gait - CGM2 1.c3d"), read("labelling/PronetoRun01.c3d")
    yield Row("qualisys, first half labels second", learn_template(gait.frames(0, 172)), gait.frames(172, 344))
    yield Row("prone to run, end labels begin", learn_template(prone.frames(626, 1253)), prone.frames(0, 626))
    move = only(read("pig_wholebody/Movement_trial.c3d"), list(_whole_body().names))
    yield Row("whole body, first half labels second", learn_template(move.frames(0, 160)), move.frames(160, 323))


def _whole_body() -> Trajectories:
    static = read("pig_wholebody/Static_trial.c3d")
    return replace(static, paths=static.paths[:39])  # the markers; the others are segments' axes and ghosts


def static_trials() -> Iterator[Row]:
    """A static trial and segments."""
    gait, move = read("qualisys_gait/Gait - CGM2 1.c3d"), read("pig_wholebody/Movement_trial.c3d")
    body = _whole_body()
    for name, static, trial in (
        (
            "HC030A static",
            only(read("pig_gait_child/HC030A01.c3d"), CHILD),
            only(read("pig_gait_child/HC030A22.c3d"), CHILD),
        ),
        ("qualisys static", read("qualisys_gait/Static - CGM2 1.c3d"), gait),
        ("whole body static", body, only(move, list(body.names))),
    ):
        yield Row(f"{name}, segments", learn_template(static, relative_spread=STATIC, segments=SEGMENTS), trial)


def other_children() -> Iterator[Row]:
    """The template of one child, scaled by height, for each other child."""
    trials = {file[-8:-2]: only(read(f"{file}.c3d"), CHILD) for file in FIRST_WALKS}
    for a, b in permutations(trials, 2):
        ratio = height(trials[b]) / height(trials[a])
        yield Row(f"other child {b} by {a}", learn_template(trials[a]).of_another(ratio), trials[b])


def wrong_templates() -> Iterator[Row]:
    """Nothing should be named."""
    gait, prone = read("qualisys_gait/Gait - CGM2 1.c3d"), read("labelling/PronetoRun01.c3d")
    child = only(read("pig_gait_child/HC030A05.c3d"), CHILD)
    yield Row("wrong: child labels qualisys", learn_template(child), gait, False)
    yield Row("wrong: prone labels qualisys", learn_template(prone), gait, False)
    yield Row("wrong: qualisys labels prone", learn_template(gait), prone, False)


class Result(NamedTuple):
    """Shares of samples in %, and what the reliability is made of: probability, right, samples of each named track."""

    right: float
    wrong: float
    unsure: float
    ghosts: float
    all_right: float
    all_wrong: float
    fit: float
    refused: bool
    cpu_s: float
    p: NDArray[np.float64]
    good: NDArray[np.bool_]
    samples: NDArray[np.int64]


def result(row: Row, pieces: int, seed: int) -> tuple[Result, Trajectories, Labels]:
    """One row, shredded."""
    tracks, truth = shredded(row.trial, pieces, 2.0, seed)
    clock = time.process_time()
    found = label(tracks, row.template)
    spent = time.process_time() - clock
    n = np.isfinite(tracks.xyz[..., 0]).sum(1)
    known = np.array([name is not None and (name in row.template.names or not row.fits) for name in truth])
    has = np.array([name is not None for name in found.names])
    good = has & row.fits & np.array([a == b for a, b in zip(found.names, truth, strict=True)])
    sure, total = np.array([s == "sure" for s in found.state]), max(n[known].sum(), 1)
    share = [100 * n[part].sum() / total for part in (good & sure, has & ~good & known & sure)]
    return (
        Result(
            share[0], share[1], 100 - sum(share), 100 * n[has & sure & ~known].sum() / max(n[~known].sum(), 1),
            100 * n[good].sum() / total, 100 * n[has & ~good & known].sum() / total,
            found.fit, found.refused is not None, spent, found.probability[has], good[has], n[has],
        ),
        tracks, found,
    )  # fmt: skip


BINS = (0.0, 0.5, 0.7, 0.9, 0.95, 0.99, 1.0 + 1e-9)
"""Of probability in the table of reliability; chosen."""


def reliability(results: list[Result]) -> list[str]:
    """A line a bin: names, mean probability, share right; by tracks and by samples."""
    p, good, n = (np.concatenate([getattr(one, name) for one in results]) for name in ("p", "good", "samples"))
    lines = []
    for low, high in pairwise(BINS):
        own = (p >= low) & (p < high)
        if own.any():
            by_sample = (good[own] * n[own]).sum() / n[own].sum()
            lines.append(
                f"  {low:.2f}–{min(high, 1):.2f} {own.sum():7d} names  mean p {p[own].mean():.3f}  "
                f"right {good[own].mean():.3f}  samples right {by_sample:.4f}"
            )
    return lines


def fitted(rows_of: list[Row], pieces: list[int], seeds: list[int]) -> NDArray[np.float64]:
    """β of `label.margin` (2) from the tuned rows: logistic regression, each row with the same weight."""
    X, y, w = [], [], []
    for row in rows_of:
        for k in pieces:
            for seed in seeds:
                tracks, truth = shredded(row.trial, k, 2.0, seed)
                found = label(tracks, row.template, method=Distances(least_fit=0.0, least_placed=0.0))
                stretches = stretches_of(tracks, row.template.size)
                place = {name: i for i, name in enumerate(row.template.names)}
                number = np.array([-1 if name is None else place[name] for name in found.names])
                about = margins(stretches, number, row.template, PairScore.of_template(row.template), found.fit)
                own = number >= 0
                X.append(features(about, stretches.weight)[own])
                y.append(np.array([row.fits and a == b for a, b in zip(found.names, truth, strict=True)])[own])
                w.append(np.full(own.sum(), 1 / max(own.sum(), 1)))
    x, right, weight = np.concatenate(X), 2.0 * np.concatenate(y) - 1, np.concatenate(w)

    def loss(beta: NDArray[np.float64]) -> float:
        return float(
            (weight * np.logaddexp(0, -right * (x @ beta))).sum() / weight.sum() + 1e-4 * (beta[1:] ** 2).sum()
        )

    return np.asarray(scipy.optimize.minimize(loss, np.zeros(x.shape[1])).x)


def metrics() -> list[Metric]:
    """For `compare.py`: the synthetic walkers, which are everywhere."""
    checked = [row for row in walkers() if row.name in ("walker 15 seed 2", "walker 39 seed 2")]
    out = []
    for row in checked:
        for pieces in (1, 15):
            one = result(row, pieces, 1)[0]
            name = f"{row.name}, ×{pieces}"
            out.append(Metric(f"right, {name}", one.right, "%", "more", absolute=0.5))
            out.append(Metric(f"wrong, {name}", one.wrong, "%", "less", absolute=0.05))
    return out


def main() -> None:
    """Do what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--pieces", type=int, nargs="*", default=[1, 15])
    parser.add_argument("--seeds", type=int, nargs="*", default=[1])
    parser.add_argument("--fit", action="store_true")
    asked = parser.parse_args()
    chosen = [row for row in rows() if not asked.names or any(name in row.name for name in asked.names)]
    if asked.fit:
        tuned = [row for row in chosen if row.name.startswith(TUNED)]
        print("beta", np.round(fitted(tuned, asked.pieces, asked.seeds), 2))
        return
    head = ("right", "wrong", "unsure", "ghosts", "all r.", "all w.", "fit", "CPU s")
    print(f"{'':40s}{'':>4s}" + "".join(f"{one:>8s}" for one in head))
    kept: dict[bool, list[Result]] = {True: [], False: []}
    for row in chosen:
        for pieces in asked.pieces:
            for seed in asked.seeds:
                one = result(row, pieces, seed)[0]
                kept[row.name.startswith(TUNED)].append(one)
                figures = "".join(f"{value:8.2f}" for value in (*one[:7], one.cpu_s))
                print(f"{row.name:40s}{'×' + str(pieces):>4s}{figures}{'  refused' if one.refused else ''}", flush=True)
    for own, title in ((True, "tuned"), (False, "checked")):
        if kept[own]:
            print(f"reliability, {title}", *reliability(kept[own]), sep="\n")


if __name__ == "__main__":
    main()
