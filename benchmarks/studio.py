"""How soon the studio answers: edits, undo, opening and images of a trial of 60 markers in 10 000 frames.

    python benchmarks/studio.py [--frames N] [--markers N] [--cameras N] [--edits N]

CPU time of the server from an act to its answer in JSON, written through to the disk, beside the time of copying the
trial's positions once; and of the images of eight cameras at frames in random order.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import av
import numpy as np
from metrics import Metric

from kinemark.apps.studio.acts import act
from kinemark.apps.studio.acts_messages import Act, ClaimAct, EraseAct, ExchangeAct, UndoAct
from kinemark.apps.studio.desk import OpenDocument
from kinemark.apps.studio.edit_messages import ActBody
from kinemark.apps.studio.paths import DEFAULT, encoded
from kinemark.apps.studio.shelf import Place
from kinemark.data import Camera, Detections, MarkerTrajectory, Rig, Trajectories
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.pictures.mosaics import Mosaics
from kinemark.geometry import project
from kinemark.io.images import open_images

MARKERS, FRAMES, CAMERAS = 60, 10_000, 8
RUNS = 15
RATE = 100.0


def rig_of(cameras: int) -> Rig:
    """Cameras in a ring of 4 m that look at its middle."""
    found = []
    for k in range(cameras):
        a = 2 * np.pi * k / cameras
        forward = np.array([-np.cos(a), -np.sin(a), 0.0])
        R = np.array([np.cross(forward, [0, 0, 1.0]), [0, 0, -1.0], forward])
        K = np.array([[1000.0, 0, 640], [0, 1000, 512], [0, 0, 1]])
        found.append(Camera(f"c{k}", np.array([1280, 1024]), K, R, R @ (4000 * forward)))
    return Rig(tuple(found))


def trial(folder: Path, markers: int, frames: int, cameras: int) -> OpenDocument:
    """An open trial of markers that swing, nine in ten of them named; seen by cameras where there are any."""
    rng, t = np.random.default_rng(0), np.arange(frames) / RATE
    phase, centre = rng.uniform(0, 6, (markers, 1, 3)), rng.uniform(-800, 800, (markers, 1, 3))
    xyz = centre + 100 * np.sin(2 * t[None, :, None] + phase)
    names = [f"M{k:02d}" if k % 10 else f"*{k + 1}" for k in range(markers)]
    rig = rig_of(cameras) if cameras else None
    rows = np.arange(cameras * frames * markers).reshape(cameras, frames, markers)
    paths = [
        MarkerTrajectory.measured(
            name, xyz[m], cov=np.broadcast_to(0.04 * np.eye(3), (frames, 3, 3)), detection=rows[:, :, m].T
        )
        for m, name in enumerate(names)
    ]
    detections = None
    if rig is not None:
        points = xyz.transpose(1, 0, 2).reshape(-1, 3)
        uv = np.concatenate([project(camera, points) for camera in rig])
        detections = Detections.build(rig.names, RATE, np.full((cameras, frames), markers), uv)
    trajectories = Trajectories(tuple(paths), RATE)
    editing = Editing("trial", Journal.of(folder, "trial"), trajectories, detections, rig, by="bench")
    return OpenDocument(Place(folder / "trial.c3d"), editing, editing.journal.read(), editing.edited())


def cpu(work: Callable[[], Any]) -> float:
    """Seconds."""
    began = time.process_time()
    work()
    return time.process_time() - began


def said(document: OpenDocument, one: Act) -> float:
    """CPU seconds from an act to its answer."""
    return cpu(lambda: act(document, ActBody(head=document.head, act=one, why="")).model_dump_json())


def times(markers: int, frames: int, cameras: int, edits: int) -> dict[str, float]:
    """Median CPU seconds of each thing, after so many edits."""
    with tempfile.TemporaryDirectory() as name:
        document = trial(Path(name), markers, frames, cameras)
        rng = np.random.default_rng(1)
        for _ in range(edits):
            a, first = f"M{rng.integers(1, 10):02d}", int(rng.integers(1, frames - 60))
            said(document, EraseAct(kind="erase", marker=a, first=first, last=first + 20))
        found: dict[str, list[float]] = {}

        def note(what: str, seconds: float) -> None:
            found.setdefault(what, []).append(seconds)

        for k in range(RUNS):
            first = frames // 10 + 10 * k
            note("exchange", said(document, ExchangeAct(kind="exchange", a="M01", b="M02", first=first)))
            note("undo", said(document, UndoAct(kind="undo")))
            note("claim", said(document, ClaimAct(kind="claim", track="*1", name=f"N{k}", first=first)))
            note("undo", said(document, UndoAct(kind="undo")))
            note("erase", said(document, EraseAct(kind="erase", marker="M03", first=first, last=first + 9)))
            note("copy", cpu(lambda: np.array([path.xyz for path in document.now.trajectories])))
            document.blobs.clear()
            note("samples", cpu(lambda: encoded(document, document.now.trajectories.paths, DEFAULT)))
    return {what: statistics.median(some) for what, some in found.items()}


def mosaic_times(cameras: int, frames: int = 200, seeks: int = 60) -> float:
    """Median CPU seconds of a mosaic that was not made before, from H.264 of 1280 × 1024 px in groups of 30."""
    with tempfile.TemporaryDirectory() as name:
        folder, rng = Path(name), np.random.default_rng(2)
        video = folder / "c.mp4"
        with av.open(str(video), "w") as container:
            stream = container.add_stream("libx264", rate=100)
            stream.width, stream.height, stream.pix_fmt, stream.codec_context.gop_size = 1280, 1024, "yuv420p", 30
            for n in range(frames):
                image = np.zeros((1024, 1280), np.uint8)
                image[100 : 110 + n, 200:220] = 200
                container.mux(
                    stream.encode(av.VideoFrame.from_ndarray(image, format="gray").reformat(format="yuv420p"))
                )
            container.mux(stream.encode(None))
        mosaics = Mosaics({f"c{k}": open_images(video) for k in range(cameras)}, folder / "kept")
        mosaics._ahead = lambda asked: None  # type: ignore[method-assign]  # only what is asked for is timed
        found = [cpu(lambda n=n: mosaics.jpeg(n)) for n in rng.permutation(frames)[:seeks].tolist()]  # type: ignore[misc]
        mosaics.close()
    return statistics.median(found)


def metrics() -> list[Metric]:
    """Ratios to copying the positions of the trial once."""
    found = times(MARKERS, FRAMES, 0, 0)
    return [
        Metric(f"CPU by a copy of all positions: {what}", seconds / found["copy"], "ratio", "less", relative=0.6)
        for what, seconds in found.items()
        if what != "copy"
    ]


def main() -> None:
    """Print milliseconds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--markers", type=int, default=MARKERS)
    parser.add_argument("--frames", type=int, default=FRAMES)
    parser.add_argument("--cameras", type=int, default=CAMERAS)
    parser.add_argument("--edits", type=int, nargs="*", default=[0, 50])
    given = parser.parse_args()
    for cameras in (0, given.cameras):
        for edits in given.edits:
            found = times(given.markers, given.frames, cameras, edits)
            text = ", ".join(f"{what} {1000 * seconds:.1f}" for what, seconds in found.items())
            print(f"{cameras} cameras, after {edits} edits, CPU ms: {text}", flush=True)
    print(f"mosaic of {given.cameras} cameras, CPU ms: {1000 * mosaic_times(given.cameras):.0f}")


if __name__ == "__main__":
    main()
