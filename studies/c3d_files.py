"""C3D files of many laboratories, read by Kinemark and by the library ezc3d: places, gaps, channels.

    python studies/c3d_files.py

A row a folder of the recordings. A place is compared where both have one; channels in the file's units, as a share of
the channel's greatest value. Samples that one of them alone gives are counted: Kinemark takes exact zeros and −32 768
of all axes for gaps, and ezc3d what the file marks alone. ezc3d reads in a process of its own, a file each, as it can
crash.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

import numpy as np
from recordings import recording

from kinemark import KinemarkError
from kinemark.data import Trial
from kinemark.data.array_types import Floats
from kinemark.io.c3d import C3D, read_c3d
from kinemark.io.c3d.points import mm_per_unit, point_names

THEIRS = """
import pickle, sys, ezc3d
c = ezc3d.c3d(sys.argv[1])
pickle.dump((c["data"]["points"][:3], c["data"]["analogs"][0]), open(sys.argv[2], "wb"))
"""


class Compared(NamedTuple):
    """What two readers say of a file: samples that both, Kinemark alone and ezc3d alone have, and how far apart they
    are at most: places, mm; channels, as a share of the greatest value of each."""

    both: int
    ours: int
    theirs: int
    apart_mm: float
    channels: int
    apart: float


def by_ezc3d(path: Path) -> tuple[Floats, Floats] | None:
    """(M, F, 3) the points in the file's unit and (A, N) the channels; None where ezc3d does not read the file."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "theirs"
        ran = subprocess.run([sys.executable, "-c", THEIRS, path, out], capture_output=True, timeout=120, check=False)
        if ran.returncode:
            return None
        points, channels = pickle.loads(out.read_bytes())
    return np.moveaxis(points, 0, 2), channels


def compared(trial: Trial, points: Floats, channels: Floats) -> Compared:
    """Kinemark's trial beside ezc3d's arrays."""
    doc = trial.source
    assert isinstance(doc, C3D)
    names = list(point_names(doc))
    theirs = points[[names.index(name) for name in trial.trajectories.names]] * mm_per_unit(doc)
    ours = trial.trajectories.xyz if len(trial.trajectories) else theirs  # signals alone
    seen, given = np.isfinite(ours).all(-1), np.isfinite(theirs).all(-1)
    both = seen & given
    own = np.concatenate([a.values.reshape(-1) for a in trial.analog]) if trial.analog else np.zeros(0)
    wide = own.size == channels.size and own.size > 0
    scale = np.abs(channels).max(1, keepdims=True) if wide else np.ones((1, 1))
    off = np.abs(own.reshape(channels.shape) - channels) / np.where(scale > 0, scale, 1) if wide else np.zeros(1)
    return Compared(
        int(both.sum()), int((seen & ~given).sum()), int((given & ~seen).sum()),
        float(np.abs(ours - theirs)[both].max(initial=0.0)), len(channels) if wide else 0, float(np.nanmax(off)),
    )  # fmt: skip


def main() -> None:
    """Print the table."""
    root = recording("mocap3d")
    rows: dict[str, list[Compared]] = defaultdict(list)
    alone: list[str] = []
    for path in sorted(path for path in root.rglob("*") if path.suffix.lower() == ".c3d"):
        name = path.relative_to(root)
        found = by_ezc3d(path)
        try:
            trial = read_c3d(path)
        except KinemarkError as error:
            alone.append(f"{name}: Kinemark refuses it, ezc3d {'refuses it too' if found is None else 'reads it'}: "
                         f"{str(error).replace(str(path), '').strip(' :')[:90]}")  # fmt: skip
            continue
        if found is None:
            alone.append(f"{name}: read by Kinemark alone")
        elif found[0].shape[:2] != trial.source.points.shape[1::-1]:
            alone.append(f"{name}: {found[0].shape[1]} frames by ezc3d, {trial.source.points.shape[0]} by Kinemark")
        else:
            rows[name.parts[0]].append(compared(trial, *found))
    heads = f"{'samples':>10}{'ours alone':>12}{'ezc3d alone':>12}{'apart mm':>10}{'channels':>10}{'apart':>8}"
    print(f"{'folder':24}{'files':>6}{heads}")
    for folder, all_of in rows.items():
        both, ours, theirs, channels = (
            sum(getattr(c, k) for c in all_of) for k in ("both", "ours", "theirs", "channels")
        )
        mm, share = max(c.apart_mm for c in all_of), max(c.apart for c in all_of)
        print(f"{folder:24}{len(all_of):6}{both:10}{ours:12}{theirs:12}{mm:10.1g}{channels:10}{share:8.0e}")
    print(*(f"\n{line}" for line in alone), sep="")


if __name__ == "__main__":
    main()
