"""Hidden gaps in complete trials, filled by every method: how far off, and whether the error bars say so.

    python benchmarks/gaps.py [trial …] [--lengths 0.5 2] [--hide one three segment occlusion] [--gaps 20]
                              [--methods body pca] [--speed]

Real trials come from KINEMARK_DATA (default ../shared/data); those that are absent are named and left out. `one` hides
one marker, `three` a marker and its two nearest neighbours, `segment` all that move with it as one body, and
`occlusion` what the limbs hide of a walker from five cameras around it, laid on the trial's markers by their height. A
gap's error is the mean distance from the truth over its frames. For each row and method: median and 95th percentile of
it, how many of the coordinates lie within their 95 % intervals, the median error expected of the gaps, ms a gap with
its hold-out gaps, and gaps that it could not fill. All methods are calibrated by the same hold-out gaps, as `fill` does
it; `auto` is what `fill` does with all of them. At the end stand its figures over all trials, and over the walks.
"""

from __future__ import annotations

import argparse
import os
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import numpy as np
from metrics import Metric

from kinemark.data import MarkerTrajectory as Path3D
from kinemark.data import Origin, Trajectories
from kinemark.fill import FILL, Auto, Gap, MarkerArray, fill, find_gaps
from kinemark.fill.fill import evaluate_candidates
from kinemark.fill.judge.choice import CandidateFill, choose_candidate
from kinemark.fill.judge.hold_out import distances
from kinemark.fill.reference_ranking import ranked
from kinemark.io.trial import read_trial
from kinemark.synth import observe, ring, walking, with_markers

ROOT = Path(os.environ.get("KINEMARK_DATA", Path(__file__).parents[2] / "shared" / "data")) / "mocap3d"
LENGTHS = (0.1, 0.25, 0.5, 1.0, 2.0)
Wanted = Callable[[int, str], bool]
Gaps = list[Gap]


def _child(k: int, name: str) -> bool:
    return 76 <= k < 135  # LFHD … RHLX: the markers; before and behind them are segments' axes and angles


TRIALS: dict[str, tuple[str, Wanted]] = {
    "walk, 16 markers": ("pig_gait_3plates_emg/PiG_Motion3_FF.c3d", lambda k, _: k < 16),
    "walk, 49 markers": ("qualisys_gait/Gait - CGM2 1.c3d", lambda *_: True),
    "walk, 52 markers": ("gait_emg_ccby/2014001_C1_01.c3d", lambda *_: True),
    "walk, 41 markers": ("opensim_gait/subject01_walk.trc", lambda *_: True),
    "walk, child": ("pig_gait_child/HC030A05.c3d", _child),
    "acrobatics": ("fullbody_cmu/85_02.c3d", lambda *_: True),
    "tennis serve": ("tennis_serve_gap_pair/kinematics_tennis_serve.c3d", lambda *_: True),
    "arm": ("ulema_hand_to_head/HTH1.c3d", lambda k, _: k < 20),
}
"""File and which of its points are markers that were measured all through."""


class Result(NamedTuple):
    """One gap filled by one method: mean error mm (NaN: not filled), expected, share covered, method, s it took."""

    error: float
    expected: float
    covered: float
    chosen: str
    seconds: float


Rows = dict[tuple[str, str, float], list[Result]]
"""Results of `auto` by trial, what is hidden, and length in s."""


def trial(name: str) -> MarkerArray:
    """A complete trial, or a synthetic walk of ten seconds.

    Raises:
        FileNotFoundError: the file is not on this machine.
    """
    if name == "synthetic walk":
        subject = with_markers(walking(duration_s=10, rate=100.0, wobble_mm=1.0, seed=3), 39, seed=3)
        noise = np.random.default_rng(3).normal(0, 0.3, subject.xyz.shape)
        return MarkerArray(subject.xyz + noise, subject.rate, subject.names)
    file, wanted = TRIALS[name]
    if not (ROOT / file).exists():
        raise FileNotFoundError(f"{ROOT / file} is absent")
    trajectories: Trajectories = read_trial(ROOT / file).trajectories
    motion = MarkerArray.of(trajectories)
    rows = [k for k, label in enumerate(motion.names) if wanted(k, label) and motion.seen[k].all()]
    return MarkerArray(motion.xyz[rows], motion.rate, tuple(motion.names[k] for k in rows))


def hide(motion: MarkerArray, how: str, seconds: float, n: int, seed: int) -> Iterator[Gaps]:
    """n sets of gaps; all of one set are hidden at once."""
    rng = np.random.default_rng(seed)
    if how == "occlusion":
        yield _occluded(motion, seed)
        return
    length, frames = round(seconds * motion.rate), motion.xyz.shape[1]
    if length > frames - 10:
        return
    for _ in range(n):
        marker, start = int(rng.integers(len(motion.names))), int(rng.integers(5, frames - length - 5))
        yield [Gap(k, start, start + length) for k in _company(motion, marker, how)]


def _company(motion: MarkerArray, marker: int, how: str) -> list[int]:
    """The marker and those that vanish with it."""
    if how == "one":
        return [marker]
    if how == "three":
        return [int(k) for k in np.argsort(np.nan_to_num(distances(motion, marker)))[:3]]
    near = ranked(motion, marker)[:4]
    apart = np.linalg.norm(motion.xyz[near] - motion.xyz[marker], axis=-1)
    return [marker, *(int(k) for k in near[apart.std(1) < 12])]


def _occluded(motion: MarkerArray, seed: int) -> Gaps:
    """Gaps of up to 2 s that limbs make in a walker's markers, laid on this trial's by height."""
    M, F = motion.xyz.shape[:2]
    subject = with_markers(
        walking(duration_s=F / motion.rate + 0.1, rate=motion.rate, seed=seed), max(M, 16), seed=seed
    )
    seen = observe(ring(5), subject, seed=seed).sight.visible[..., :F].sum(0) >= 2
    height = np.argsort(np.nanmean(subject.xyz[..., 2], 1))[np.linspace(0, len(subject.names) - 1, M).astype(int)]
    mask = np.zeros((M, F), bool)
    mask[np.argsort(motion.xyz[..., 2].mean(1))] = ~seen[height]
    blank = motion._replace(xyz=np.where(mask[..., None], np.nan, motion.xyz))
    return [gap for gap in find_gaps(blank) if gap.length <= 2 * motion.rate]


def results(motion: MarkerArray, gaps: Gaps, names: list[str]) -> dict[str, list[Result]]:
    """Every method's gaps, and auto's, from one set of hold-out gaps."""
    hidden, answers, seconds = motion.hidden(gaps), [], []
    for name in names:
        clock = time.process_time()
        answers += evaluate_candidates(hidden, gaps, [FILL.make(name)])
        seconds.append((time.process_time() - clock) / len(gaps))
    out = {
        name: [_judge(motion, hidden, gaps, k, [answer], spent) for k in range(len(gaps))]
        for name, answer, spent in zip(names, answers, seconds, strict=True)
    }
    if len(names) > 1:
        out["auto"] = [_judge(motion, hidden, gaps, k, answers, sum(seconds)) for k in range(len(gaps))]
    return out


def _judge(
    motion: MarkerArray, hidden: MarkerArray, gaps: Gaps, index: int, answers: list[CandidateFill], seconds: float
) -> Result:
    gap = gaps[index]
    found, prediction, cov = choose_candidate(hidden, gaps, index, answers)
    error = prediction.xyz - motion.xyz[gap.marker, gap.start : gap.stop]
    with np.errstate(invalid="ignore"):
        inside = np.abs(error) <= 1.959964 * np.sqrt(np.diagonal(cov, axis1=-2, axis2=-1))
    mean, covered = float(np.linalg.norm(error, axis=1).mean()), float(inside.mean())
    return Result(mean, found.expected_mm, covered if np.isfinite(cov).all() else np.nan, found.method, seconds)


def table(found: dict[str, list[Result]]) -> None:
    """One row of the benchmark, a line a method, the best first."""
    error = {name: np.nan_to_num([r.error for r in of], nan=np.inf) for name, of in found.items()}
    median = {name: float(np.median(e)) for name, e in error.items()}
    for name in sorted(found, key=lambda name: median[name]):
        able = [r for r in found[name] if np.isfinite(r.error)]
        p95 = np.percentile([r.error for r in able], 95) if able else np.nan
        cover = 100 * np.mean([r.covered for r in able]) if able else np.nan
        expected = np.median([r.expected for r in able]) if able else np.nan
        print(
            f"    {name:17s} {median[name]:8.2f} {p95:8.2f} mm   cover {cover:5.1f} %   expected {expected:7.2f} mm"
            f"   {1e3 * np.mean([r.seconds for r in found[name]]):6.0f} ms   unfilled {len(found[name]) - len(able)}"
        )
    if "auto" in found:
        singles = [name for name in found if name != "auto"]
        best = [min(singles, key=lambda s: error[s][k]) for k in range(len(found["auto"]))]
        hits = 100 * np.mean([b == r.chosen for b, r in zip(best, found["auto"], strict=True)])
        ratio = median["auto"] / min(median[name] for name in singles)
        print(f"    auto chose the best for {hits:.0f} %; its median is {ratio:.2f} of the best method's")


def speed(names: list[str]) -> None:
    """Seconds for 200 gaps of 0.1 to 2 s in 60 s of 40 markers at 100 Hz, hold-out gaps and all."""
    subject = with_markers(walking(duration_s=60, rate=100.0, wobble_mm=1.0, seed=5), 40, seed=5)
    rng = np.random.default_rng(5)
    xyz = subject.xyz + rng.normal(0, 0.3, subject.xyz.shape)
    gaps = {
        Gap(int(rng.integers(40)), start, start + int(10 * 20 ** rng.random()))
        for start in rng.integers(5, 5700, 200).tolist()
    }
    whole = MarkerArray(xyz, subject.rate, subject.names)
    paths = [Path3D.measured(n, x) for n, x in zip(whole.names, whole.hidden(gaps).xyz, strict=True)]
    for name in names:
        clock = time.process_time()
        found = fill(Trajectories(tuple(paths), 100.0), method=FILL.make(name), limit_mm=np.inf)
        seconds = time.process_time() - clock
        error = [
            np.linalg.norm(path.xyz - true, axis=1)[path.origin == Origin.FILLED].mean()
            for path, true in zip(found.trajectories, whole.xyz, strict=True)
        ]
        print(f"{name:17s} {seconds:6.2f} s   mean error {np.mean(error):7.2f} mm   {len(found.gaps)} gaps", flush=True)


SOME = ["linear", "quintic", "rigid_body", "pca", "low_rank_kalman", "local_regression", "body"]


def metrics() -> list[Metric]:
    """Gaps of half a second in the synthetic walk, by some methods and by `auto` with these."""
    motion, found = trial("synthetic walk"), dict[str, list[Result]]()
    for gap in hide(motion, "one", 0.5, 6, 1):
        for method, more in results(motion, gap, SOME).items():
            found.setdefault(method, []).extend(more)
    measured = []
    for method, of in found.items():
        error, covered = np.median([r.error for r in of]), 100 * np.mean([r.covered for r in of])
        measured.append(Metric(f"median error, {method}", float(error), "mm", "less", relative=0.02))
        measured.append(Metric(f"95 % interval, {method}", float(covered), "%", "near", absolute=2.0))
    expected = np.median([r.expected for r in found["auto"]])
    return [*measured, Metric("expected error, auto", float(expected), "mm", "near", relative=0.02)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trials", nargs="*", help=f"of {', '.join([*TRIALS, 'synthetic walk'])}; any part of a name")
    parser.add_argument("--lengths", nargs="+", type=float, default=LENGTHS, help="s")
    parser.add_argument("--hide", nargs="+", default=["one", "three", "segment", "occlusion"])
    parser.add_argument("--methods", nargs="+", default=list(Auto().candidates))
    parser.add_argument("--gaps", type=int, default=20, help="sets of gaps a row")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--speed", action="store_true", help="only how long 200 gaps take")
    asked = parser.parse_args()
    if asked.speed:
        speed([*asked.methods, "auto"])
        return
    every: Rows = {}
    for name in [*TRIALS, "synthetic walk"]:
        if asked.trials and not any(part in name for part in asked.trials):
            continue
        try:
            every |= rows(name, trial(name), asked)
        except FileNotFoundError as absent:
            print(f"{name}: left out, {absent}")
    summary(every)


def summary(every: Rows) -> None:
    """What `auto` does over all trials."""
    walks = {at: found for at, found in every.items() if at[0].startswith("walk")}  # the real ones
    for title, some in (("walks", walks), ("all", every)):
        for how, seconds in dict.fromkeys((how, s) for _, how, s in some):
            here = [r for at, found in some.items() if at[1:] == (how, seconds) for r in found]
            able = [r for r in here if np.isfinite(r.error)]
            median, cover = np.median([r.error for r in able]), 100 * np.mean([r.covered for r in able])
            print(f"{title}, {how} {seconds:g} s: {len(here)} gaps, auto {median:.2f} mm, cover {cover:.1f} %")
    covered = [r.covered for found in every.values() for r in found if np.isfinite(r.covered)]
    if covered:
        print(f"cover of all: {100 * np.mean(covered):.1f} %")


def rows(name: str, motion: MarkerArray, asked: argparse.Namespace) -> Rows:
    """All rows of one trial; of `auto` its results."""
    every: Rows = {}
    for how in asked.hide:
        for seconds in asked.lengths if how != "occlusion" else (0.0,):
            found: dict[str, list[Result]] = {}
            for gaps in hide(motion, how, seconds, asked.gaps, asked.seed):
                for method, more in results(motion, gaps, asked.methods).items():
                    found.setdefault(method, []).extend(more)
            if found:
                length = f" {seconds:g} s" if seconds else ""
                print(f"{name}, {how}{length}: {len(next(iter(found.values())))} gaps", flush=True)
                table(found)
                if "auto" in found:
                    every[name, how, seconds] = found["auto"]
    return every


if __name__ == "__main__":
    warnings.simplefilter("ignore", RuntimeWarning)
    main()
