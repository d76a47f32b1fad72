"""Memory that tracking takes: peak of a process that has the detections and tracks them.

    python benchmarks/memory.py                      20 000 frames of 39 markers, six cameras: at most 1000 MB
    python benchmarks/memory.py --frames 40000 --cameras 8

Images of the scene merge unmarked, and its calibration is 0.3 px off, so that every stage of the tracker is needed.
"""

from __future__ import annotations

import argparse
import os
import pickle
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from kinemark.track.simultaneous import track_detections
from support.scenes import make, scene

RATE = 100.0
"""Of the scene, Hz."""


def write_scene(path: Path, frames: int, cameras: int, seed: int) -> None:
    """The detections and cameras of a walk on a treadmill, kept in a file."""
    own = scene(seed)._replace(markers=39, cameras=cameras, motion="walk", rate=RATE, seconds=frames / RATE)
    optics = own.optics._replace(noise=0.3, false=0.5, merge=6.0, marked=False, dropout=0.01)
    made = make(own._replace(treadmill=True, placement="ring", optics=optics))
    with path.open("wb") as file:
        pickle.dump((made.detections, made.rig), file, protocol=5)


def measure(path: Path) -> None:
    """Track what a file keeps, and print what it took."""
    with path.open("rb") as file:
        detections, rig = pickle.load(file)
    before, begin = _peak_mb(), time.process_time()
    tracks = track_detections(detections, rig)
    seconds = time.process_time() - begin
    print(f"{len(detections)} images, {len(tracks.cloud)} points, {seconds:.0f} s of the processor")
    print(f"{before:.0f} MB before, {_peak_mb():.0f} MB at most")


def _peak_mb() -> float:
    """Of this process itself: what `getrusage` says also holds what its parent had, who made the scene."""
    status = Path("/proc/self/status")
    if status.is_file():
        return next(float(line.split()[1]) * 1024 / 1e6 for line in status.open() if line.startswith("VmHWM"))
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=20_000)
    parser.add_argument("--cameras", type=int, default=6)
    parser.add_argument("--seed", type=int, default=38)
    parser.add_argument("--of", type=Path, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.of:
        return measure(asked.of)
    with tempfile.TemporaryDirectory() as folder:
        kept = Path(folder) / "scene"
        write_scene(kept, asked.frames, asked.cameras, asked.seed)
        subprocess.run([sys.executable, __file__, "--of", str(kept)], check=True)


if __name__ == "__main__":
    main()
