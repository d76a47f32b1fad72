"""The order of the stages, and the only place that knows it.

detect → match → reconstruct → track → trajectories → C3D, quality.json and report.html.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from .data import Analog, Cloud, Detections, KinemarkError, Matches, Rig, Step, Tracks, Trajectories, Trial
from .detect import Centroids
from .io.c3d import write_c3d
from .io.records import load, save
from .ledger import Ledger, digest
from .match import EpipolarTriplets, match
from .reconstruct import LeastSquares, reconstruct
from .report.page import write_report
from .report.quality import quality, write_quality
from .track import ExtrapolationLadder, to_trajectories, track

Record = TypeVar("Record")

Progress = Callable[[str, int, int], None]
"""Called with the stage, how much of it is done, and how much there is."""


def silent(stage: str, done: int, total: int) -> None:
    """Shows nothing."""


@dataclass(frozen=True, slots=True)
class Methods:
    """How each stage is done."""

    detect: Centroids = field(default_factory=Centroids)
    match: EpipolarTriplets = field(default_factory=EpipolarTriplets)
    reconstruct: LeastSquares = field(default_factory=LeastSquares)
    track: ExtrapolationLadder = field(default_factory=ExtrapolationLadder)


@dataclass(frozen=True, slots=True)
class Source:
    """Where the detections of a trial come from.

    Attributes:
        key: changes when the input does.
        detections: reads or detects them, given the method and a progress callback.
        doubts: what contradicts itself in the input, for the report.
        beside: analog channels, force plates and events of the same recording, in a trial without markers.
    """

    key: str
    detections: Callable[[Centroids, Progress], Detections]
    doubts: tuple[str, ...] = ()
    beside: Trial | None = None


@dataclass(frozen=True, slots=True)
class Results:
    """What a run made.

    Attributes:
        folder: where it is on disk.
        computed: the stages that had to be computed; the others were unchanged.
    """

    folder: Path
    rig: Rig
    detections: Detections
    tracks: Tracks
    trajectories: Trajectories
    quality: dict[str, object]
    steps: tuple[Step, ...]
    computed: tuple[str, ...]


def rig_key(rig: Rig) -> str:
    """A key of all that a rig says about geometry."""
    cameras = [part for c in rig for part in (c.name, c.size, c.K, c.distortion, c.R, c.t, c.cov)]
    return digest(*cameras, rig.volume)


def run(
    source: Source,
    rig: Rig,
    folder: Path,
    *,
    session: str = "",
    methods: Methods | None = None,
    calibration: Sequence[Step] = (),
    progress: Progress = silent,
) -> Results:
    """One trial from its source to C3D and report; what is unchanged since the last run is read instead of computed.

    Args:
        source: of the detections.
        rig: the calibrated cameras.
        folder: for the results; its name is the trial's.
        session: its name, for the report.
        methods: of the stages; all defaults where None.
        calibration: the steps that made the rig, for the report.
        progress: told what is being done.

    Raises:
        KinemarkError: the input is unusable; the message says what to do.
    """
    methods = methods or Methods()
    ledger = Ledger.open(folder)
    detections, tracks, key = _stages(ledger, source, rig, methods, progress)
    trajectories = to_trajectories(tracks, rig)
    steps = tuple(ledger.steps)
    figures = quality(
        session=session,
        trial=folder.name,
        rig=rig,
        detections=detections,
        tracks=tracks,
        trajectories=trajectories,
        steps=(*calibration, *steps),
        notes=source.doubts,
    )
    outputs = [folder / f"{folder.name}.c3d", folder / "quality.json", folder / "report.html"]
    key = digest(key, session, source.doubts, [(step.input, step.method) for step in calibration])
    if not ledger.stands("write", key) or not all(path.is_file() for path in outputs):
        progress("write", 0, 1)
        beside = source.beside or Trial("", trajectories)
        write_c3d(outputs[0], replace(together(beside, trajectories), name=folder.name, steps=steps))
        write_quality(outputs[1], figures)
        write_report(
            outputs[2], quality=figures, rig=rig, detections=detections, tracks=tracks, trajectories=trajectories
        )
        progress("write", 1, 1)
    ledger.note("write", key)  # only now: what was cut off before is written again
    return Results(folder, rig, detections, tracks, trajectories, figures, steps, tuple(ledger.computed))


def _whole(ratio: float) -> bool:
    """Whether a ratio of rates is a whole number."""
    return abs(ratio - round(ratio)) < 1e-6 and round(ratio) >= 1


def alongside(analog: Sequence[Analog], rate: float, n_frames: int) -> tuple[Analog, ...]:
    """Channels as a C3D file can hold them: one record, as many samples to every frame, from the first to the last.

    Channels whose rate is no multiple of the frame rate, or that start later, are left out; they stay in their own
    file. What was recorded beyond the last frame is cut, and what is missing before it is NaN.
    """
    fitting = [a for a in analog if a.start == 0 and _whole(a.rate / rate)]
    if not fitting:
        return ()
    fastest = max(a.rate for a in fitting)
    samples = round(fastest / rate) * n_frames
    rows = []
    for a in fitting:
        held = np.repeat(a.values, round(fastest / a.rate), axis=1)[:, :samples] if _whole(fastest / a.rate) else None
        if held is not None:
            rows.append((a, np.pad(held, ((0, 0), (0, samples - held.shape[1])), constant_values=np.nan)))
    names = tuple(name for a, _ in rows for name in a.names)
    units = tuple(unit for a, _ in rows for unit in a.units)
    return (Analog(names, units, fastest, np.concatenate([values for _, values in rows])),)


def _stages(
    ledger: Ledger, source: Source, rig: Rig, methods: Methods, progress: Progress
) -> tuple[Detections, Tracks, str]:
    """The stages in their order, each from its file where that still holds; and the key of the last."""

    def told(stage: str, make: Callable[[], Record]) -> Callable[[], Record]:
        def made() -> Record:
            progress(stage, 0, 1)
            record = make()
            progress(stage, 1, 1)
            return record

        return made

    detections, key = ledger.do(
        "detect",
        methods.detect,
        source.key,
        file="detections.h5",
        make=lambda: source.detections(methods.detect, progress),
        save=save,
        load=_reader(Detections),
    )
    matches, key = ledger.do(
        "match",
        methods.match,
        digest(key, rig_key(rig)),
        file="matches.h5",
        make=told("match", lambda: match(detections, rig, method=methods.match)),
        save=save,
        load=_reader(Matches),
    )
    cloud, key = ledger.do(
        "reconstruct",
        methods.reconstruct,
        key,
        file="cloud.h5",
        make=told("reconstruct", lambda: reconstruct(matches, detections, rig, method=methods.reconstruct)),
        save=save,
        load=_reader(Cloud),
    )
    tracks, key = ledger.do(
        "track",
        methods.track,
        key,
        file="tracks.h5",
        make=told("track", lambda: track(cloud, method=methods.track)),
        save=save,
        load=_reader(Tracks),
    )
    return detections, tracks, key


def together(beside: Trial, trajectories: Trajectories) -> Trial:
    """The trajectories with what was recorded beside them, as far as a C3D file can hold it."""
    analog = alongside(beside.analog, trajectories.rate, trajectories.n_frames)
    kept = {name for a in analog for name in a.names}
    plates = tuple(plate for plate in beside.plates if set(plate.channels) <= kept)
    return replace(beside, trajectories=trajectories, analog=analog, plates=plates)


def _reader(kind: type[Record]) -> Callable[[Path], Record]:
    """Reads a record of this kind, and takes any other for a damaged file."""

    def read(path: Path) -> Record:
        record = load(path)
        if not isinstance(record, kind):
            raise KinemarkError(f"{path} holds {type(record).__name__}, wanted {kind.__name__}. Delete it.")
        return record

    return read
