"""Are frames that a system lost or doubled, and jumps of the whole world, told as what they are, each as one problem?

The markers of all files of trajectories, at their own rates and at a half to an eighth of them, none below 20 Hz, are
looked at as they are, and with one fault of all markers, twice of each kind, beside which one or two markers jump away
for three frames:

    lost      1 to 8 frames are missing, and nothing says so
    held      1 to 8 frames repeat the one before
    doubled   1 to 8 copies of a frame are put in, so that what follows is late
    moved     from a frame on all is turned by 0.05° to 5° and shifted by 3 to 300 mm
    shaken    the same for 1 to 8 frames

A third of the movements is smeared over 2 to 5 frames, as filters do. The coefficients of `lost` and `moved` are
fitted to all laboratories but those of FRESH, which had not been looked at when constants were chosen;
what is told of those is by these, and of each other one by those of the others.

Then the list of problems is made of some of them, with and without looking for causes: how long it is, and whether the
faults of single markers are still found.

Run: python studies/whole_trial_faults.py
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numpy as np
import scipy
from filled_samples import NATURAL, files, of, written
from probable_errors_faults import smeared_over
from probable_errors_fits import fitted
from probable_errors_tables import Judged, classes, table

from kinemark.data import Trajectories
from kinemark.data.array_types import Floats
from kinemark.data.problems import OF_WHOLE, Problem
from kinemark.edit.probable_errors import Break, Paths, breaks
from kinemark.edit.probable_errors.probability import COEFFICIENTS
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.problems import problems

KINDS = ("lost", "held", "doubled", "moved", "shaken")
FITTED = ("lost", "moved")  # few files rest, so that of repeated frames they are chosen
FAMILY = {"held": "repeated", "doubled": "repeated", "shaken": "moved"}
FRESH = ("arm_box_lift_gaps", "opensim_gait", "qualisys_gait", "ulema_hand_to_head", "wheelchair_racing_gaps")
NEAR = 8  # frames from a fault at which a break is the same
EVERY = 23  # of the trials with faults whose list of problems is made
OF_PATHS: Any = sys.modules["kinemark.engine.problems.of_paths"]
SEEN_MM = 5.0  # median step that a loss or a movement makes, below which nobody sees it


class Seeded(NamedTuple):
    """A trial with a fault of all markers after frame `before` (from 0), of so many frames, that moves them by `mm`,
    the median; and the markers that are wrong by themselves, each with its first frame."""

    xyz: Floats
    kind: str
    before: int
    frames: int
    mm: float
    single: tuple[tuple[int, int], ...]


class Told(NamedTuple):
    """What tells of one break, whether it is one, its kind, whose file it is, and by how much markers are off, mm."""

    evidence: tuple[float, ...]
    true: bool
    kind: str
    laboratory: str


def seeded(xyz: Floats, kind: str, rng: np.random.Generator) -> Seeded:
    """Trajectories (M, F, 3) with a fault, and with some of single markers."""
    F = xyz.shape[1]
    f, n = int(rng.integers(10, F - 20)), round(float(np.exp(rng.uniform(0, np.log(8)))))
    out, single = single_faults(xyz, f, rng)
    if kind == "lost":
        off = step(out, f, f + 1 + n) - step(out, f, f + 1)
        single = tuple((p, g - n if g > f else g) for p, g in single if not f < g <= f + n)
        return Seeded(np.delete(out, slice(f + 1, f + 1 + n), axis=1), kind, f, n, off, single)
    if kind == "held":
        out[:, f + 1 : f + 1 + n] = out[:, f : f + 1]
        return Seeded(out, kind, f, n, step(out, f, f + 1 + n), single)
    if kind == "doubled":
        out = np.concatenate([out[:, : f + 1], np.repeat(out[:, f : f + 1], n, axis=1), out[:, f + 1 :]], axis=1)
        return Seeded(out, kind, f, n, step(xyz, f, f + 1) * n, tuple((p, g + n if g > f else g) for p, g in single))
    moved = elsewhere(out, rng)
    inside = np.zeros(F)
    inside[f + 1 : None if kind == "moved" else f + 1 + n] = 1
    if rng.random() < 0.33:
        inside = smeared_over(inside, int(rng.integers(2, 6)))
    off = float(np.nanmedian(np.linalg.norm(moved - out, axis=2)))
    return Seeded(out + inside[:, None] * (moved - out), kind, f, n, off, single)


def step(xyz: Floats, f: int, g: int) -> float:
    """mm that markers go from frame f to g, the median."""
    far = np.linalg.norm(xyz[:, g] - xyz[:, f], axis=1)
    return float(np.nanmedian(far)) if np.isfinite(far).any() else 0.0


def elsewhere(xyz: Floats, rng: np.random.Generator) -> Floats:
    """All as in another world."""
    middle, axis, shift = np.nanmean(xyz.reshape(-1, 3), axis=0), rng.normal(size=3), rng.normal(size=3)
    degrees, mm = (float(np.exp(rng.uniform(*np.log(some)))) for some in ((0.05, 5.0), (3.0, 300.0)))
    turn = scipy.spatial.transform.Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis)).as_matrix()
    return np.asarray((xyz - middle) @ turn.T + middle + mm * shift / np.linalg.norm(shift))


def single_faults(xyz: Floats, f: int, rng: np.random.Generator) -> tuple[Floats, tuple[tuple[int, int], ...]]:
    """One or two markers jump 40 to 100 mm away for three frames within 30 frames of frame f, where they are seen."""
    out, done = xyz.copy(), []
    for p in rng.permutation(len(xyz))[: int(rng.integers(1, 3))].tolist():
        g = int(np.clip(f + rng.choice([-1, 1]) * rng.integers(12, 30), 8, xyz.shape[1] - 12))
        if np.isfinite(xyz[p, g - 6 : g + 9]).all():
            out[p, g : g + 3] += rng.uniform(40, 100) * (v := rng.normal(size=3)) / np.linalg.norm(v)
            done.append((p, g))
    return out, tuple(done)


def is_that(one: Break, of: Seeded | None) -> bool:
    """Whether a break is the one that was seeded."""
    if of is None:
        return False
    same = FAMILY.get(one.kind, one.kind) == FAMILY.get(of.kind, of.kind)
    inside = of.frames if of.kind in ("held", "doubled", "shaken") else 0
    return same and one.after >= of.before - NEAR and one.before <= of.before + inside + NEAR


def listed(trial: Trajectories, *, causes: bool = True, one_by_one: bool = False) -> tuple[Problem, ...]:
    """The problems worth a look, with causes of all markers looked for, or without."""
    OF_PATHS._found.cache_clear()
    looked = mock.patch.object(OF_PATHS, "breaks", OF_PATHS.breaks if causes else lambda paths: [])
    with looked, tempfile.TemporaryDirectory() as folder:
        editing = Editing("trial", Journal.of(Path(folder), "trial"), trial, None, None)
        return problems(editing, one_by_one=one_by_one).asked


def trials() -> Iterator[tuple[str, Trajectories, Seeded | None]]:
    """Laboratory, trial and fault."""
    rng = np.random.default_rng(41)
    for where, trial in files():
        yield where, of(trial, written(trial.xyz, rng), trial.rate), None
        for kind in KINDS * 2:
            fault = seeded(trial.xyz, kind, rng)
            yield where, of(trial, written(fault.xyz, rng), trial.rate), fault


def fit(rows: list[Told], kind: str) -> Floats:
    rows = [row for row in rows if row.kind == kind for _ in range(1 if row.true else NATURAL)]
    return fitted(np.array([row.evidence for row in rows]), np.array([float(row.true) for row in rows]))


def judged(rows: list[Told]) -> Iterator[Judged]:
    """By coefficients of the other laboratories, those of FRESH left out."""
    for where in sorted({row.laboratory for row in rows}):
        others = [row for row in rows if row.laboratory not in (where, *FRESH)]
        of_kind = {kind: fit(others, kind) for kind in FITTED} | {"repeated": np.array(COEFFICIENTS["repeated"])}
        for row in rows:
            if row.laboratory == where:
                c = of_kind[row.kind]
                wrong = float(1 / (1 + np.exp(-np.clip(c[0] + np.dot(c[1:], row.evidence), -50, 50))))
                yield Judged(where, row.kind, wrong, row.true, wrong >= 0.05)


class Count:
    """Of what is seeded: how many are found, as what they are, and how many problems there are."""

    def __init__(self) -> None:
        self.found: dict[tuple[str, bool], list[tuple[bool, bool]]] = {}
        self.lists: list[tuple[int, int, int]] = []
        self.single = [0, 0]

    def see(self, fault: Seeded, said: list[Break]) -> None:
        """What is said of a trial with a fault."""
        mine = [one for one in said if is_that(one, fault)]
        number = {"lost": fault.frames, "doubled": -fault.frames, "held": 0}.get(fault.kind)
        right = any(number is None or one.frames == number for one in mine)
        self.found.setdefault((fault.kind, fault.mm >= SEEN_MM), []).append((bool(mine), right))

    def list_of(self, trial: Trajectories, fault: Seeded) -> None:
        """The problems of a trial with a fault, with and without causes."""
        after, before = listed(trial), listed(trial, causes=False)
        own = [one for one in listed(trial, one_by_one=True) if one.kind not in OF_WHOLE]
        self.lists.append((len(before), len(after), sum(one.kind in OF_WHOLE for one in after)))
        for p, frame in fault.single:
            near = (abs(one.frame - 1 - frame) < NEAR and trial.names[p] in one.tracks for one in own)
            self.single = [self.single[0] + any(near), self.single[1] + 1]

    def tell(self) -> None:
        """All that was seen."""
        for (kind, seen), some in sorted(self.found.items()):
            size = f"{'at least' if seen else 'below'} {SEEN_MM:.0f} mm"
            hits, right = np.array(some).sum(0)
            print(f"  {kind:8} {size:13} found {hits} of {len(some)}, with the number of frames {right}")
        if self.lists:
            before, after, whole = np.array(self.lists).T
            print(f"  problems worth a look in {len(before)} trials: median {np.median(before):.0f}, most"
                  f" {before.max()} without causes, {np.median(after):.0f} and {after.max()} with them;"
                  f" {whole.mean():.2f} causes a trial;"
                  f" {self.single[0]} of {self.single[1]} single faults are told besides")  # fmt: skip


def main() -> None:
    rows, old, new, natural = list[Told](), Count(), Count(), list[int]()
    for k, (where, trial, fault) in enumerate(trials()):
        said = breaks(Paths.of(trial))
        rows += [Told(tuple(one.evidence), is_that(one, fault), FAMILY.get(one.kind, one.kind), where) for one in said]
        count = new if where in FRESH else old
        if fault is None:
            natural.append(sum(one.wrong >= 0.05 for one in said))
        else:
            count.see(fault, [one for one in said if one.wrong >= 0.05])
            if k % EVERY == 0:
                count.list_of(trial, fault)
    told = list(judged(rows))
    for title, some in (
        (
            "Laboratories that had been looked at, each by the others",
            [row for row in told if row.recording not in FRESH],
        ),
        ("The others, by those", [row for row in told if row.recording in FRESH]),
    ):
        print(f"{title}: {len(some)} breaks of {len({row.recording for row in some})} laboratories")
        for kind in ("all", "lost", "moved", "repeated"):
            table(kind, [row for row in some if kind in ("all", row.kind)])
        classes(some)
    for title, count in (("Laboratories that had been looked at", old), ("The others", new)):
        print(f"\n{title}: faults with a problem worth a look, by the coefficients that are kept")
        count.tell()
    print(f"\nAs they are: {sum(natural)} causes worth a look in {len(natural)} trials")
    seen = [row for row in rows if row.laboratory not in FRESH]
    for kind in FITTED:
        print(f"  coefficients of {kind}: {', '.join(f'{c:.2f}' for c in fit(seen, kind))}")


if __name__ == "__main__":
    main()
