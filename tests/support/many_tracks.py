"""A trial of very many tracks, as a recording leaves it in which markers are lost and found again all the time."""

import numpy as np

from kinemark.data import Cloud, Detections, MarkerTrajectory, Tracks, Trajectories
from support.captures import RATE, judge, ring


def fragments(tracks, frames, *, length=400, name="*{}"):
    """Paths of markers that are there for some hundred frames each, somewhere in the trial."""
    rng = np.random.default_rng(0)
    cov = np.broadcast_to(0.25 * np.eye(3), (frames, 3, 3))
    paths = []
    for m in range(tracks):
        xyz = np.full((frames, 3), np.nan)
        start = rng.integers(0, max(1, frames - length))
        n = len(xyz[start : start + length])
        walk = np.cumsum(rng.normal(0, 3, (n, 3)), 0)
        xyz[start : start + n] = walk + rng.uniform((-800, -800, 100), (800, 800, 1800))
        xyz[start + n // 3 : start + n // 3 + 5] = np.nan
        paths.append(MarkerTrajectory.measured(name.format(m + 1), xyz, cov=cov))
    return Trajectories(tuple(paths), RATE)


def long_trial(tracks, frames, *, cameras=8, **more):
    """The arguments of `report.page.page` for such a trial, with decisions and loose points by the thousand."""
    rig, trajectories = ring(cameras), fragments(tracks, frames, **more)
    rng = np.random.default_rng(1)
    counts = np.full((cameras, frames), 3)
    uv = rng.uniform(0, 480, (int(counts.sum()), 2))
    validity = (rng.random(len(uv)) < 0.1).astype(np.uint8)
    detections = Detections.build(rig.names, RATE, counts, uv, validity=validity)
    loose = Cloud(RATE, np.arange(frames + 1), rng.uniform(0, 1000, (frames, 3)), np.tile(np.eye(3), (frames, 1, 1)),
                  np.zeros(frames), np.full((frames, cameras), -1))  # fmt: skip
    found = Tracks(loose, np.full(frames, -1))
    records = {"detections": detections, "tracks": found, "trajectories": trajectories}
    pictures = [rng.integers(0, 256, (480, 640)).astype(np.uint8) for _ in range(cameras)]
    quality = judge(rig, records)
    quality["ambiguous_decisions"] = [
        {"kind": "swap", "first_frame": k, "last_frame": k + 1, "time_s": k / RATE,
         "trajectories": [f"*{k % tracks + 1}"], "reason": "found_again", "values": {"sd_mm": 20.0}}
        for k in range(3000)
    ]  # fmt: skip
    return {"quality": quality, "rig": rig, "pictures": pictures, **records}
