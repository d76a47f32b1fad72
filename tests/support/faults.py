"""A tracker that errs: faults put into the trajectories of a trial, of which the truth is known.

Three exchanges of two markers, one of them of left and right; two pieces without a name; four gaps; one ghost; one
spike. Nothing of the sort is in what the cameras saw, so that the images tell what is right.
"""

from dataclasses import dataclass, replace

import numpy as np

from kinemark.data import MarkerTrajectory, Origin

COLUMNS = ("xyz", "cov", "origin", "residual", "cameras", "detection")


@dataclass(frozen=True)
class Faults:
    """Where they are, in frames from 0 of a trial of `frames`: chosen so that none hides another."""

    swaps: tuple = (("LHEE", "LANK", 0.30), ("RKNE", "RTHI", 0.55), ("RTOE", "RHEE", 0.75))
    sides: tuple = ("LASI", "RASI", 0.40)
    pieces: tuple = (("LTIB", 0.62), ("SACR", 0.45))
    gaps: tuple = (("LTOE", 0.35, 6), ("LKNE", 0.50, 9), ("RTIB", 0.20, 5), ("RANK", 0.65, 14))
    ghost: tuple = ("LTHI", "RKNE", 0.15, 0.6)
    spike: tuple = ("RASI", 0.85, 2, 45.0)


def faulty(trajectories, faults=None):
    """The trajectories with the faults in them."""
    f, n = faults or Faults(), trajectories.n_frames
    columns = {path.name: {name: getattr(path, name).copy() for name in COLUMNS} for path in trajectories}
    for marker, at, length, off in [f.spike]:
        first = round(at * n)
        columns[marker]["xyz"][first : first + length] += np.array([off, -off / 2, off / 3])
    for one, other, at in (*f.swaps, f.sides):
        exchange(columns, one, other, round(at * n))
    for marker, at, length in f.gaps:
        first = round(at * n)
        blank(columns[marker], slice(first, first + length))
    for k, (marker, at) in enumerate(f.pieces):
        part = {name: column.copy() for name, column in columns[marker].items()}
        first = round(at * n)
        blank(part, slice(0, first + 2))
        blank(columns[marker], slice(first, n))
        columns[f"*{90 + k}"] = part
    columns["*95"] = ghost(columns, *f.ghost)
    return replace(trajectories, paths=tuple(MarkerTrajectory(name, **these) for name, these in columns.items()))


def exchange(columns, one, other, first):
    """Two markers go on as each other."""
    for name in COLUMNS:
        a, b = columns[one][name], columns[other][name]
        a[first:], b[first:] = b[first:].copy(), a[first:].copy()


def blank(of, where):
    """No samples there."""
    for name in ("xyz", "cov", "residual"):
        of[name][where] = np.nan
    of["origin"][where], of["cameras"][where], of["detection"][where] = Origin.MISSING, 0, -1


def ghost(columns, marker, other, first, last):
    """A path that is no marker: two cameras' images of two markers meet there by chance, and not well."""
    n = len(columns[marker]["xyz"])
    part = {name: column.copy() for name, column in columns[marker].items()}
    blank(part, slice(0, round(first * n)))
    blank(part, slice(round(last * n), n))
    seen = part["origin"] != Origin.MISSING
    part["xyz"][seen] += np.array([70.0, 160.0, 90.0])
    part["residual"][seen], part["cov"][seen] = 6.0, 25.0 * np.eye(3)
    own, others = part["detection"], columns[other]["detection"]
    a = int((own >= 0).sum(0).argmax())
    b = int(np.where(np.arange(others.shape[1]) == a, -1, (others[seen] >= 0).sum(0)).argmax())
    part["detection"] = np.full_like(own, -1)
    part["detection"][seen, a], part["detection"][seen, b] = own[seen, a], others[seen, b]
    return part
