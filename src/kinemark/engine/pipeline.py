"""The order of the stages, and the only place that knows it.

detect → track → trajectories → C3D, quality.json and report.html, where tracking is matching at the same time; else
detect → match → reconstruct → track → …
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..data import Analog, Cloud, Detections, Fills, KinemarkError, Matches, Rig, Step, Tracks, Trajectories, Trial
from ..data.method import Method
from ..detect import DETECT
from ..digitise import called, identified_matches, identified_tracks
from ..fill import Filled, FilledGap, Filling, Rays, fill_recording
from ..findings.gaps import filling_figures
from ..findings.quality import quality, write_quality
from ..io.c3d import write_c3d
from ..io.files import replacing
from ..io.records import load, save
from ..match import MATCH, check_cameras, match
from ..reconstruct import RECONSTRUCT, LeastSquares, reconstruct
from ..report.figures_detections import Picture, telling_frames
from ..report.filling_page import write_filling_page
from ..report.page import write_report
from ..track import TRACK, matches_itself, to_trajectories, track
from ..track.simultaneous import (
    AmbiguousDecision,
    Simultaneous,
    ambiguous_decisions,
    diagnose,
    diagnose_tracks,
    track_detections,
    track_simultaneously,
)
from .store import Store, digest
from .swapped_cameras import swapped_cameras

Record = TypeVar("Record")

DOUBTS, GAPS = "ambiguous_decisions.json", "gaps.html"

Progress = Callable[[str, int, int], None]
"""Called with the stage, how much of it is done, and how much there is."""


def silent(stage: str, done: int, total: int) -> None:
    """Shows nothing."""


@dataclass(frozen=True, slots=True)
class Methods:
    """How each stage is done; gaps are filled where `fill` says how."""

    detect: Method = field(default_factory=DETECT.make)
    match: Method = field(default_factory=MATCH.make)
    reconstruct: Method = field(default_factory=RECONSTRUCT.make)
    track: Method = field(default_factory=TRACK.make)
    fill: Filling | None = None


class OperatorIdentities(NamedTuple):
    """What an operator said of a trial: names (M) of its markers, the marker of each detection (D), and figures."""

    names: Callable[[], Sequence[str]]
    markers: Callable[[], NDArray[np.int64]]
    figures: Callable[[], Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class TrialSource:
    """Where the detections of a trial come from.

    Attributes:
        key: changes when the input does.
        detections: reads or detects them, given the method and a progress callback.
        contradictions: what contradicts itself in the input, for the report.
        beside: analog channels, force plates and events of the same recording, in a trial without markers.
        pictures: gives one image (H, W) of each camera, of the frames (C) asked for; None where there are no images.
        operated: which marker each detection is, where an operator said it; then nothing is matched or tracked.
    """

    key: str
    detections: Callable[[Method, Progress], Detections]
    contradictions: tuple[str, ...] = ()
    beside: Trial | None = None
    pictures: Callable[[Sequence[int]], Sequence[Picture]] | None = None
    operated: OperatorIdentities | None = None


class Tracked(NamedTuple):
    """Tracks, the decisions of the tracker that were close, and what it found of its input, in sentences."""

    tracks: Tracks
    ambiguous_decisions: tuple[AmbiguousDecision, ...] = ()
    diagnostics: tuple[str, ...] = ()


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
    source: TrialSource,
    rig: Rig,
    folder: Path,
    *,
    session: str = "",
    methods: Methods | None = None,
    calibration: Sequence[Step] = (),
    judged: Mapping[str, Any] | None = None,
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
        judged: how good the rig is, as `report.calibration_figures` tells, for the report.
        progress: told what is being done.

    Raises:
        KinemarkError: the input is unusable; the message says what to do.
    """
    methods = methods or Methods()
    ledger = Store.open(folder)
    detections, (tracks, unsure, odd), key = _stages(ledger, source, rig, methods, progress)
    measured = to_trajectories(tracks, rig)
    if source.operated is not None:
        measured = called(measured, source.operated.names(), detections.n_frames)
    filled, key = _filled(ledger, measured, Rays.left_by(tracks, detections, rig), methods.fill, key, progress)
    trajectories = filled.trajectories
    steps = tuple(ledger.steps)
    notes = (
        *source.contradictions,
        *swapped_cameras(detections, rig, tracks.cloud, matching=methods.match, placing=methods.reconstruct),
    )
    figures = quality(
        session=session,
        trial=folder.name,
        rig=rig,
        detections=detections,
        tracks=tracks,
        trajectories=trajectories,
        steps=(*calibration, *steps),
        notes=notes,
        ambiguous_decisions=unsure,
        diagnostics=odd,
        judged=judged,
        filling=_gap_figures(folder.name, filled, measured, methods.fill),
    )
    if source.operated is not None:
        figures["digitising"] = dict(source.operated.figures())
    outputs = [folder / f"{folder.name}.c3d", folder / "quality.json", folder / "report.html"]
    outputs += [folder / GAPS] if methods.fill else []
    made = [(step.input, step.method) for step in calibration]
    key = digest(key, session, notes, made, figures["calibration"])
    if not ledger.stands("write", key) or not all(path.is_file() for path in outputs):
        progress("write", 0, 1)
        beside = source.beside or Trial("", trajectories)
        write_c3d(outputs[0], replace(together(beside, trajectories), name=folder.name, steps=steps))
        write_quality(outputs[1], figures)
        write_report(
            outputs[2],
            quality=figures,
            rig=rig,
            detections=detections,
            tracks=tracks,
            trajectories=trajectories,
            judged=judged,
            pictures=source.pictures(telling_frames(detections)) if source.pictures else None,
        )
        if methods.fill:
            write_filling_page(folder / GAPS, figures=figures["filling"], trajectories=trajectories, before=measured)
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
    ledger: Store, source: TrialSource, rig: Rig, methods: Methods, progress: Progress
) -> tuple[Detections, Tracked, str]:
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
    key = digest(key, rig_key(rig))
    track_method: object = methods.track
    if source.operated is not None:
        operated, place, track_method = source.operated, methods.reconstruct, None
        key = digest(key, list(operated.names()), type(place).__name__, asdict(place))
        make = told("track", lambda: _as_operated(detections, rig, operated.markers(), methods))
    elif matches_itself(methods.track):
        key = digest(key, methods.reconstruct)
        make = told("track", lambda: _followed(detections, rig, methods))
    else:
        cloud, key = _cloud(ledger, detections, rig, methods, key, told)
        make = told("track", lambda: _linked(detections, rig, cloud, methods))
    tracked, key = ledger.do(
        "track", track_method, key, file="tracks.h5", make=make, save=_save_tracked, load=_load_tracked
    )
    return detections, tracked, key


def _as_operated(detections: Detections, rig: Rig, marker: NDArray[np.int64], methods: Methods) -> Tracked:
    """Tracks of the markers (D) that an operator named."""
    check_cameras(detections, rig)
    cloud = reconstruct(identified_matches(detections, marker), detections, rig, method=methods.reconstruct)
    return Tracked(identified_tracks(cloud, marker))


def _followed(detections: Detections, rig: Rig, methods: Methods) -> Tracked:
    """Tracks straight from the detections; Kinemark's own tracker lists its ambiguous decisions."""
    method, place = methods.track, methods.reconstruct
    check_cameras(detections, rig)
    if not isinstance(method, Simultaneous) or not isinstance(place, LeastSquares):
        tracks = track_detections(detections, rig, method=method)
        return Tracked(tracks, diagnostics=tuple(diagnose_tracks(detections, rig, tracks)))
    result = track_simultaneously(detections, rig, method, place=place)
    return Tracked(result.tracks, tuple(ambiguous_decisions(result, method)), tuple(diagnose(detections, rig, result)))


def _linked(detections: Detections, rig: Rig, cloud: Cloud, methods: Methods) -> Tracked:
    """Tracks of points that were matched before."""
    tracks = track(cloud, method=methods.track)
    return Tracked(tracks, diagnostics=tuple(diagnose_tracks(detections, rig, tracks)))


def _cloud(ledger: Store, detections: Detections, rig: Rig, methods: Methods, key: str, told: Any) -> tuple[Cloud, str]:
    """Points without an identity, matched and reconstructed."""
    matches, key = ledger.do(
        "match",
        methods.match,
        key,
        file="matches.h5",
        make=told("match", lambda: match(detections, rig, method=methods.match)),
        save=save,
        load=_reader(Matches),
    )
    return ledger.do(
        "reconstruct",
        methods.reconstruct,
        key,
        file="cloud.h5",
        make=told("reconstruct", lambda: reconstruct(matches, detections, rig, method=methods.reconstruct)),
        save=save,
        load=_reader(Cloud),
    )


def _filled(
    ledger: Store, measured: Trajectories, rays: Rays, method: Filling | None, key: str, progress: Progress
) -> tuple[Filled, str]:
    """The trajectories with their gaps filled where a method says how, and the key of that."""
    if method is None:
        return Filled(measured, ()), key

    def make() -> Fills:
        progress("fill", 0, 1)
        filled = fill_recording(measured, rays, method=method)
        progress("fill", 1, 1)
        return Fills.between(measured, filled.trajectories, tuple(json.dumps(asdict(gap)) for gap in filled.gaps))

    fills, key = ledger.do("fill", method, key, file="fills.h5", make=make, save=save, load=_reader(Fills))
    gaps = tuple(FilledGap(**json.loads(text)) for text in fills.told)
    return Filled(fills.on(measured), gaps), key


def _gap_figures(trial: str, filled: Filled, measured: Trajectories, method: Filling | None) -> dict[str, Any] | None:
    """What is to be said of the gaps."""
    if method is None:
        return None
    return filling_figures(filled, measured, source=trial, method=method.name, limit_mm=method.limit_mm)


def _save_tracked(path: Path, record: Tracked) -> None:
    """The tracks, and beside them what was doubted."""
    said = {
        "ambiguous_decisions": [decision._asdict() for decision in record.ambiguous_decisions],
        "diagnostics": record.diagnostics,
    }
    with replacing(path.with_name(DOUBTS)) as beside:
        beside.write_text(json.dumps(said, indent=1, ensure_ascii=False) + "\n", "utf-8")
    save(path, record.tracks)


def _load_tracked(path: Path) -> Tracked:
    """What an earlier run left; damaged files count as none."""
    try:
        said = json.loads(path.with_name(DOUBTS).read_text("utf-8"))
        unsure = tuple(
            AmbiguousDecision(**{**row, "tracks": tuple(row["tracks"])}) for row in said["ambiguous_decisions"]
        )
        return Tracked(_reader(Tracks)(path), unsure, tuple(said["diagnostics"]))
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise KinemarkError(f"{path.with_name(DOUBTS)} is damaged: {error}. Delete it.") from error


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
