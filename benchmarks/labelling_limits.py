"""A raw trial of a subject whom no template knows, and how long labelling takes.

    python benchmarks/labelling_limits.py [raw] [speed]

`raw`: `S01_Pronetokneel01`, 76 tracks without names, 57 to 62 a frame, by the template of `PronetoRun01`, of another
subject with the same 62 markers. Nobody named it, so that names are compared with each other: of templates scaled by
0.95 to 1.05, and of the same trial cut into pieces. Shares of the samples, %.
`speed`: 62 labels, as whole tracks and as 1 000 fragments among ghosts, of the subject's own template and of another's;
CPU s, and the ratio of 3 400 frames to 1 700, which is 2 where time is linear in frames.
Files come from KINEMARK_DATA, as for `labelling.py`.
"""

from __future__ import annotations

import os
import sys
import time
from dataclasses import replace

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import numpy as np
from labelling_cases import ROOT, read
from labelling_shredded import shredded

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import Labels, Template, label, learn_template

KNOWN, RAW = "labelling/PronetoRun01.c3d", "labelling/S01_Pronetokneel01_mksrem.c3d"
RATIOS = (0.95, 1.0, 1.05)
FRAMES, PIECES = 1700, 16


def samples(trial: Trajectories, labels: Labels, state: str) -> float:
    """Share of the samples whose name is so."""
    seen = np.isfinite(trial.xyz[..., 0]).sum(1)
    return float(seen[[one == state for one in labels.state]].sum() / seen.sum())


def alike(trial: Trajectories, a: Labels, b: Labels) -> float:
    """Share of the samples with two names of which both are the same."""
    seen = np.isfinite(trial.xyz[..., 0]).sum(1)
    both = np.array([x is not None and y is not None for x, y in zip(a.names, b.names, strict=True)])
    same = np.array([x == y for x, y in zip(a.names, b.names, strict=True)])
    return float(seen[both & same].sum() / max(seen[both].sum(), 1))


def raw() -> None:
    """The trial without names, by another subject's template."""
    trial, template = read(RAW), learn_template(read(KNOWN))
    by = {ratio: label(trial, template.of_another(ratio)) for ratio in RATIOS}
    for ratio, found in by.items():
        shares = "".join(
            f"  {state} {100 * samples(trial, found, state):.2f}" for state in ("sure", "unsure", "unknown")
        )
        said = "refused" if found.refused else f"fit {found.fit:.2f}"
        print(f"template × {ratio:<5g}{said}{shares}  as × 1: {100 * alike(trial, found, by[1.0]):.2f}", flush=True)
    parts = shredded(trial, 15, 2.0, 1)
    found = label(parts.tracks, template.of_another(1.0))
    names = dict(zip(trial.names, by[1.0].names, strict=True))
    whole = replace(found, names=tuple(names.get(str(name)) for name in parts.truth))
    print(f"in 15 pieces      fit {found.fit:.2f}  sure {100 * samples(parts.tracks, found, 'sure'):.2f}"
          f"  as whole: {100 * alike(parts.tracks, found, whole):.2f}")  # fmt: skip


def longer(trial: Trajectories, frames: int) -> Trajectories:
    """The trial to and fro until it has so many frames."""
    xyz = np.concatenate([trial.xyz, trial.xyz[:, ::-1]], axis=1)
    xyz = np.tile(xyz, (1, 1 + frames // xyz.shape[1], 1))[:, :frames]
    paths = tuple(MarkerTrajectory.measured(name, one) for name, one in zip(trial.names, xyz, strict=True))
    return replace(trial, paths=paths)


def cpu_s(trial: Trajectories, template: Template, pieces: int) -> float:
    """Of labelling a trial in pieces, with 2 ghosts a frame where it is cut."""
    parts = shredded(trial, pieces, 2.0 if pieces > 1 else 0.0, 1)
    clock = time.process_time()
    label(parts.tracks, template)
    return time.process_time() - clock


def speed() -> None:
    """CPU of 62 labels."""
    trial = read(KNOWN)
    own = learn_template(trial)
    label(trial.frames(0, 20), own)  # what is loaded once
    for name, template in (("own template", own), ("another's", own.of_another(1.02))):
        for pieces in (1, PIECES):
            once, twice = (cpu_s(longer(trial, n * FRAMES), template, n * pieces if pieces > 1 else 1) for n in (1, 2))
            what = "whole" if pieces == 1 else f"{pieces * len(trial)} fragments"
            print(f"{name:14s}{what:16s}{FRAMES} frames {once:6.2f} s, twice as many × {twice / once:.2f}", flush=True)


def main() -> None:
    """Do what the arguments say, or both."""
    if not (ROOT / KNOWN).is_file():
        print(f"{ROOT / KNOWN} is not here; set KINEMARK_DATA")
        return
    for name, run in (("raw", raw), ("speed", speed)):
        if name in sys.argv[1:] or len(sys.argv) < 2:
            run()


if __name__ == "__main__":
    main()
