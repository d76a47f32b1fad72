"""Sessions of detections of a walker with fifteen markers, whom an earlier trial names."""

from functools import cache

import numpy as np

from kinemark.data import Trial
from kinemark.io.c3d import write_c3d
from kinemark.io.records import save
from kinemark.io.rig_toml import write_rig_toml
from kinemark.synth import observe, ring, walking

RIG = ring(6, focal_px=1100.0)
HEAD = 'name = "named"\nmarker_set = "kiss-15"\n[calibration]\nfile = "rig.toml"\n'


@cache
def walk(seed, speed=1000.0, phase=0.3, seconds=0.8):
    """Of one person; the markers are where they are whatever the seed."""
    return walking(
        duration_s=seconds, rate=50.0, seed=seed, wobble_mm=2.0, marker_radius_mm=7.0, speed_mm_s=speed, phase=phase
    )


STAND = {"speed": 1.0, "phase": 0.8, "seconds": 1.6}
MOTIONS = {"stand": (7, STAND), "walk01": (2, {}), "walk02": (3, {"phase": 0.7})}


def motion(name):
    """The walker of a trial."""
    seed, options = MOTIONS[name]
    return walk(seed, **options)


def session_of(folder, *names, label='template = ["earlier.c3d"]', more="", first=()):
    """A session of these trials, with what `[label]` says."""
    write_rig_toml(folder / "rig.toml", RIG)
    write_c3d(folder / "earlier.c3d", Trial("earlier", walk(1, 1100.0, 0.8, 1.0).trajectories))
    rows = []
    for name in names:
        save(folder / f"{name}.h5", observe(RIG, motion(name), noise_px=0.1, seed=4).detections)
        kind = "motion" if name not in first else "static" if name == "stand" else "range_of_motion"
        rows.append(f'[[trials]]\nname = "{name}"\ndetections = "{name}.h5"\nkind = "{kind}"\n')
    (folder / "session.toml").write_text(f"{HEAD}[label]\n{label}\n{more}\n" + "".join(rows))
    return folder


def share_right(trajectories, subject):
    """Of the samples that have a name, the share that lie within 15 mm of the marker of that name."""
    right = total = 0
    for path in trajectories:
        own = np.isfinite(path.xyz[:, 0]) & (not path.name.startswith("*"))
        if own.any():
            away = np.linalg.norm(path.xyz - subject.xyz[subject.names.index(path.name)], axis=1)
            right, total = right + (away[own] < 15.0).sum(), total + own.sum()
    return right / max(total, 1)
