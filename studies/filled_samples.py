"""Are samples that nobody measured told from what is at rest, in files of a laboratory that was not seen before?

The markers of all files of trajectories, at their own rates and at a half to an eighth of them, none below 20 Hz, are
looked at as they are, and twice with fillings: of every sixth marker 0.05 to 1.5 s are straight or held, or it is held
to its end or from its beginning. Numbers are as they were, in single precision, or multiples of 0.001 to 0.1 mm.

The coefficients of `filling` are fitted to all laboratories; what is told of each is by those fitted to the others.
What the files have as they are counts as measured, and for three; but for the tennis serve, which has straight lines
through five to eight samples to a ten thousandth of a millimetre, and a standing trial in which some markers keep
their place to a hundred thousandth for seconds.

Run: python studies/filled_samples.py
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from probable_errors_fits import fitted
from probable_errors_tables import Judged, classes, table
from recordings import FOLDER as DATA

from kinemark.data import KinemarkError, MarkerTrajectory, Origin, Trajectories
from kinemark.data.array_types import Bools, Floats
from kinemark.edit.probable_errors import Paths, fillings
from kinemark.engine.put_aside import put_aside
from kinemark.io.trial import read_trial

LEFT_OUT = ("malformed", "six_formats", "probing", "serve", "static.trc", "N18", "noFF")
"""Parts of names of files that are others once more, are filled, or are not to be read."""
EVERY, LEAST_HZ, LONGEST = (1, 2, 4, 8), 20.0, 1500
STEPS_MM = (0.001, 0.01, 0.1)
NATURAL = 3  # times that what is not seeded counts: files have more than what is filled of every sixth marker


class Told(NamedTuple):
    """What tells of one run, whether it was seeded, and whose file it is."""

    evidence: tuple[float, ...]
    seeded: bool
    laboratory: str


def files() -> Iterator[tuple[str, Trajectories]]:
    """Laboratory, and trajectories of each file and rate."""
    for file in sorted(path for path in (DATA / "mocap3d").rglob("*") if path.suffix.lower() in (".c3d", ".trc")):
        if any(part in str(file) for part in LEFT_OUT):
            continue
        try:
            whole = put_aside(read_trial(file)).rest
        except KinemarkError:
            continue
        whole = whole.frames(0, min(whole.n_frames, LONGEST))
        seen = [p.name for p in whole if (p.origin != Origin.MISSING).sum() > 50 and not p.name.startswith("*")]
        if len(seen) >= 8:
            for k in EVERY:
                if whole.rate / k >= LEAST_HZ and whole.n_frames // k >= 40:
                    yield laboratory(file), of(whole.select(seen), whole.select(seen).xyz[:, ::k], whole.rate / k)


def laboratory(file: Path) -> str:
    """The children's recordings are of one."""
    return file.parent.name.replace("children", "child")


def of(trial: Trajectories, xyz: Floats, rate: float) -> Trajectories:
    pairs = zip(trial.names, xyz, strict=True)
    return Trajectories(tuple(MarkerTrajectory.measured(name, path) for name, path in pairs), rate)


def filled(xyz: Floats, rate: float, rng: np.random.Generator) -> tuple[Floats, Bools]:
    """Trajectories (M, F, 3) with fillings, and where (M, F)."""
    out, where = xyz.copy(), np.zeros(xyz.shape[:2], bool)
    for p in rng.permutation(len(xyz))[: max(6, len(xyz) // 6)].tolist():
        n = max(4, round(float(np.exp(rng.uniform(np.log(0.05), np.log(1.5)))) * rate))
        own = np.flatnonzero(np.isfinite(xyz[p, :, 0]))
        if len(own) < n + 10:
            continue
        f = int(rng.choice(own[3 : -n - 3]))
        if not np.isfinite(xyz[p, f - 1 : f + n + 1]).all():
            continue
        kind = str(rng.choice(["straight", "straight", "held", "end", "beginning"]))
        frames = {"end": own[own >= f], "beginning": own[own < f]}.get(kind, np.arange(f, f + n))
        share = (frames[:, None] - (f - 1)) / (n + 1)
        a, b = xyz[p, f - 1], xyz[p, f + n]
        out[p, frames] = a * (1 - share) + b * share if kind == "straight" else xyz[p, f] if kind == "beginning" else a
        where[p, frames] = True
    return out, where


def written(xyz: Floats, rng: np.random.Generator) -> Floats:
    """As files have it."""
    how = rng.random()
    if how < 0.4:
        step = float(rng.choice(STEPS_MM))
        return np.asarray(np.round(xyz / step) * step)
    return xyz.astype(np.float32).astype(np.float64) if how < 0.7 else xyz


def told() -> Iterator[Told]:
    rng = np.random.default_rng(77)
    for where, trial in files():
        for k in range(3):
            xyz, made = filled(trial.xyz, trial.rate, rng) if k else (trial.xyz, np.zeros(trial.xyz.shape[:2], bool))
            for one in fillings(Paths.of(of(trial, written(xyz, rng), trial.rate))):
                seeded = bool(made[one.path, one.first : one.last + 1].mean() > 0.5)
                yield Told(tuple(one.evidence), seeded, where)


def fit(rows: list[Told]) -> Floats:
    rows = [row for row in rows for _ in range(1 if row.seeded else NATURAL)]
    return fitted(np.array([row.evidence for row in rows]), np.array([float(row.seeded) for row in rows]))


def main() -> None:
    rows = list(told())
    judged = []
    for where in sorted({row.laboratory for row in rows}):
        c = fit([row for row in rows if row.laboratory != where])
        for row in rows:
            if row.laboratory == where:
                wrong = float(1 / (1 + np.exp(-c[0] - np.dot(c[1:], row.evidence))))
                judged.append(Judged(where, "filled", wrong, row.seeded, wrong >= 0.05))
    print(f"{len(judged)} runs of {len({row.laboratory for row in rows})} laboratories, each by the others")
    table("filled", judged)
    classes(judged)
    print(f"  coefficients of all: {', '.join(f'{k:.2f}' for k in fit(rows))}")


if __name__ == "__main__":
    main()
