"""The stages of a trial, in one of three graphs.

detect → track → fill → quality → write                          trackers that match by themselves
detect → match → reconstruct → track → fill → quality → write    matching first, then tracks of points
detect → track → fill → quality → write                          an operator has said which marker is which
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..data import (
    Cloud,
    Detections,
    Fills,
    Finding,
    KinemarkError,
    Matches,
    Rig,
    Step,
    Tracks,
    Trajectories,
    Trial,
    make_finding,
)
from ..digitise import called, identified_matches, identified_tracks
from ..edit import Edited, cropped
from ..fill import Filled, FilledGap, Rays, fill_recording
from ..findings.gaps import filling_figures
from ..findings.quality import write_quality
from ..geometry.ideal_pixels import check_cameras
from ..geometry.weighted_points import inside_volume
from ..io.c3d import on_frames, write_c3d
from ..io.files import replacing
from ..io.records import load, save
from ..match import match
from ..reconstruct import LeastSquares, image_errors, reconstruct
from ..report.figures_detections import fullest_frames
from ..report.filling_page import write_filling_page
from ..report.page import write_report
from ..report.trial_quality import quality
from ..track import matches_itself, to_trajectories, track
from ..track.simultaneous import (
    AmbiguousDecision,
    Simultaneous,
    ambiguous_decisions,
    diagnose,
    diagnose_points,
    diagnose_tracks,
    track_detections,
    track_simultaneously,
)
from ..track.simultaneous.diagnostics_of_points import points_left_out
from .calibration.calibrated import Calibrated
from .edit_stage import cropped_fill, edit_stage, unreviewed, with_edits
from .graph import Graph, Records, Stage
from .identities import identity_of_entry, stated_identity, with_identity
from .keys import rig_key
from .settings import Settings
from .sources import OperatorIdentities, TrialSource, identifies
from .store import Store
from .swapped_cameras import swapped_cameras

Record = TypeVar("Record")

DECISIONS, GAPS, REPORT, QUALITY = "ambiguous_decisions.json", "gaps.html", "report.html", "quality.json"


@dataclass(frozen=True, slots=True)
class TrialInputs:
    """What the stages of a trial are given besides each other's records.

    Attributes:
        name: of the trial; folder: of its results.
        settings: of the session.
        source: of the detections.
        calibrated: the cameras, and how good they are.
        store: of the results, which knows how the stages were done.
        threads: how many detection may use; None leaves it to the machine.
        assets: folder of what pages share; None where each page is to hold it.
    """

    name: str
    folder: Path
    settings: Settings
    source: TrialSource
    calibrated: Calibrated
    store: Store
    threads: int | None = None
    assets: Path | None = None

    @property
    def rig(self) -> Rig:
        """The calibrated cameras."""
        return self.calibrated.rig


class Tracked(NamedTuple):
    """Tracks, the decisions of the tracker that were close, and what it found of its input."""

    tracks: Tracks
    ambiguous_decisions: tuple[AmbiguousDecision, ...] = ()
    diagnostics: tuple[Finding, ...] = ()


def trial_graph(name: str, settings: Settings, source: TrialSource, calibrated: Calibrated) -> Graph[TrialInputs]:
    """The stages of a trial by its settings."""
    s, rig = settings, rig_key(calibrated.rig)
    detecting = Stage("detect", (), ("detections.h5",), _detect, save, _reader(Detections), s.detect)
    detecting = replace(detecting, given=(source.key(),), in_place=source.of.entry.answers is not None)
    detecting = replace(detecting, cameras=s.detect_cameras)
    stages = [detecting]
    tracks = Tracking(("tracks.h5", DECISIONS))
    if identifies(source):
        stages.append(tracks.stage(_as_operated, ("detect",), None, (rig, s.digitise, s.reconstruct)))
    elif matches_itself(s.track):
        stages.append(tracks.stage(_from_detections, ("detect",), s.track, (rig, s.reconstruct)))
    else:
        matched, cloud = _reader(Matches), _reader(Cloud)
        stages.append(Stage("match", ("detect",), ("matches.h5",), _match, save, matched, s.match, (rig,)))
        places = ("detect", "match")
        stages.append(Stage("reconstruct", places, ("cloud.h5",), _reconstruct, save, cloud, s.reconstruct))
        stages.append(tracks.stage(_from_points, ("detect", "reconstruct"), s.track, ()))
    needs: tuple[str, ...] = ("detect", "track")
    edits = edit_stage(source.of.root, name, calibrated.rig, needs, measured_of)
    stages += edits
    needs = (*needs, *(stage.name for stage in edits))
    if s.fill is not None:
        stages.append(Stage("fill", needs, ("fills.h5",), _fill, save, _reader(Fills), s.fill))
        needs = (*needs, "fill")
    made = [(step.input, step.method) for step in calibrated.steps]
    stated = (s.name, asdict(stated_identity(s, source.of.entry)), s.match, s.reconstruct, made, calibrated.figures)
    stages.append(Stage("quality", needs, (QUALITY,), _quality, write_quality, _load_quality, given=stated))
    outputs = (f"{name}.c3d", REPORT, *((GAPS,) if s.fill is not None else ()))
    stages.append(Stage("write", (*needs, "quality"), outputs, _write, _done, _nothing, in_place=True))
    return Graph(tuple(stages))


class Tracking(NamedTuple):
    """What the ways of tracking have in common: the files that they leave."""

    files: tuple[str, ...]

    def stage(
        self,
        compute: Callable[[TrialInputs, Records], Tracked],
        needs: tuple[str, ...],
        method: Any,
        given: tuple[Any, ...],
    ) -> Stage[TrialInputs]:
        """The stage `track`, done in this way."""
        return Stage("track", needs, self.files, compute, _save_tracked, _load_tracked, method, given)


def measured_of(inputs: TrialInputs, records: Records) -> Trajectories:
    """The trajectories as they were measured, named where an operator said how."""
    measured = to_trajectories(records["track"].tracks, inputs.rig)
    if inputs.source.of.frames is not None:
        measured = replace(measured, first_frame=inputs.source.of.frames[0])
    operated = inputs.source.operated()
    return measured if operated is None else called(measured, operated.names, records["detect"].n_frames)


def edits_of(inputs: TrialInputs, records: Records) -> Edited:
    """The trajectories as people said they are."""
    return records["edit"].edited if "edit" in records else Edited(measured_of(inputs, records))


def filled_of(inputs: TrialInputs, records: Records) -> Filled:
    """The trajectories with what was filled, and what became of every gap."""
    measured = edits_of(inputs, records).trajectories
    if "fill" not in records:
        return Filled(measured, ())
    fills: Fills = records["fill"]
    return Filled(fills.on(measured), tuple(FilledGap(**json.loads(text)) for text in fills.gaps))


def _detect(inputs: TrialInputs, records: Records) -> Detections:
    return inputs.source.detections(inputs.threads)


def _match(inputs: TrialInputs, records: Records) -> Matches:
    return match(records["detect"], inputs.rig, method=inputs.settings.match)


def _reconstruct(inputs: TrialInputs, records: Records) -> Cloud:
    method = inputs.settings.reconstruct
    return reconstruct(records["match"], records["detect"], inputs.rig, method=method)


def _as_operated(inputs: TrialInputs, records: Records) -> Tracked:
    """Tracks of the markers that an operator named."""
    detections, operated = records["detect"], inputs.source.operated()
    assert isinstance(operated, OperatorIdentities)
    check_cameras(detections, inputs.rig)
    matches = identified_matches(detections, operated.marker)
    cloud = reconstruct(matches, detections, inputs.rig, method=inputs.settings.reconstruct)
    tracks = identified_tracks(cloud, operated.marker)
    return Tracked(tracks, diagnostics=tuple(_left_outside(inputs, matches, detections, operated, tracks)))


def _left_outside(
    inputs: TrialInputs, matches: Matches, detections: Detections, operated: OperatorIdentities, tracks: Tracks
) -> Iterator[Finding]:
    """About named markers outside the control volume, which would else look as if nobody had seen them."""
    method: Any = inputs.settings.reconstruct  # every one has a volume
    rig = inputs.rig
    if not method.within_volume or np.isnan(rig.volume).any() or len(tracks.cloud) == len(matches.frame):
        return
    whole = reconstruct(matches, detections, rig, method=replace(method, within_volume=False))
    out = ~inside_volume(whole.xyz, rig.volume, margin=method.volume_margin)
    if out.any():
        gone = set(identified_tracks(whole, operated.marker).id[out].tolist()) - set(tracks.id.tolist())
        names = [operated.names[m] for m in sorted(gone)]
        yield points_left_out(whole.xyz[out], len(tracks.cloud), method.volume_margin, rig.volume, names)


def _from_detections(inputs: TrialInputs, records: Records) -> Tracked:
    """Tracks straight from the detections; Kinemark's own tracker lists its ambiguous decisions."""
    detections, rig = records["detect"], inputs.rig
    method, place = inputs.settings.track, inputs.settings.reconstruct
    check_cameras(detections, rig)
    if not isinstance(method, Simultaneous) or not isinstance(place, LeastSquares):
        tracks = track_detections(detections, rig, method=method)
        return Tracked(tracks, diagnostics=tuple(diagnose_tracks(detections, rig, tracks)))
    margin = place.volume_margin if place.within_volume else None
    result = track_simultaneously(detections, rig, method, errors=image_errors(place), volume_margin=margin)
    volume = None if np.isnan(rig.volume).any() else rig.volume
    found = *diagnose(detections, rig, result), *diagnose_points(result, method, margin, volume)
    return Tracked(result.tracks, tuple(ambiguous_decisions(result, method)), found)


def _from_points(inputs: TrialInputs, records: Records) -> Tracked:
    """Tracks of points that were matched before."""
    tracks = track(records["reconstruct"], method=inputs.settings.track)
    return Tracked(tracks, diagnostics=tuple(diagnose_tracks(records["detect"], inputs.rig, tracks)))


def _fill(inputs: TrialInputs, records: Records) -> Fills:
    """What filling adds, by `[fill]`."""
    method, edited = inputs.settings.fill, edits_of(inputs, records)
    assert method is not None  # else there is no such stage
    rays = Rays.left_by(records["track"].tracks, records["detect"], inputs.rig)
    measured = edited.trajectories
    filled = fill_recording(measured, rays, method=method, choices=edited.choices)
    return Fills.between(measured, filled.trajectories, tuple(json.dumps(asdict(gap)) for gap in filled.gaps))


def _quality(inputs: TrialInputs, records: Records) -> dict[str, Any]:
    """Every figure of the trial."""
    s, detections, tracked, of = inputs.settings, records["detect"], records["track"], inputs.source.of
    edited, beside = edits_of(inputs, records), inputs.source.beside()
    filled = cropped_fill(filled_of(inputs, records), edited)
    swapped = swapped_cameras(detections, inputs.rig, tracked.tracks.cloud, matching=s.match, placing=s.reconstruct)
    figures = quality(
        session=s.name,
        trial=inputs.name,
        rig=inputs.rig,
        detections=detections,
        tracks=tracked.tracks,
        trajectories=filled.trajectories,
        steps=(*inputs.calibrated.steps, *inputs.store.steps),
        findings=(
            *inputs.source.contradictions(),
            *subtracted(detections),
            *_channels(beside, filled.trajectories),
            *swapped,
            *tracked.diagnostics,
            *(records["edit"].findings if "edit" in records else ()),
        ),
        ambiguous_decisions=unreviewed(tracked.ambiguous_decisions, edited),
        judged=inputs.calibrated.figures,
        filling=_gap_figures(inputs, filled, cropped(edited.trajectories, edited)),
        identity=identity_of_entry(of.root, s, of.entry, beside.about if beside else None),
    )
    if "edit" in records:
        figures["edits"] = records["edit"].figures
    operated = inputs.source.operated()
    if operated is not None:
        figures["digitising"] = dict(operated.figures)
    return figures


def subtracted(detections: Detections) -> Iterator[Finding]:
    """From the images of which cameras a static ground was subtracted."""
    if detections.ground_subtracted:
        yield make_finding("ground_subtracted", cameras=detections.ground_subtracted)


def _channels(beside: Trial | None, trajectories: Trajectories) -> Iterator[Finding]:
    """What of the recording could not be read, and what the C3D file cannot hold of its channels."""
    if beside is not None and beside.notes:
        yield make_finding("recording_partly_read", parts_list=beside.notes)
    if beside is None or not len(trajectories):
        return
    for note in on_frames(beside.analog, trajectories.rate, trajectories.n_frames)[1]:
        values: dict[str, Any] = {"channels": len(note.names), "channels_list": note.names}
        if note.kind == "cut":
            yield make_finding("channels_cut", **values, duration_s=note.values["seconds"])
        else:
            yield make_finding("channels_resampled", **values, **dict[str, Any](note.values))


def _gap_figures(inputs: TrialInputs, filled: Filled, measured: Trajectories) -> dict[str, Any] | None:
    """What is to be said of the gaps."""
    method = inputs.settings.fill
    if method is None:
        return None
    return filling_figures(filled, measured, source=inputs.name, method=method.name, limit_mm=method.limit_mm)


def _write(inputs: TrialInputs, records: Records) -> None:
    """The trial for other programs, and for a person who reads."""
    whole, figures, edited = filled_of(inputs, records).trajectories, records["quality"], edits_of(inputs, records)
    folder, name, steps = inputs.folder, inputs.name, tuple(inputs.store.steps)
    beside = inputs.source.beside() or Trial("", whole)
    about = with_identity(beside.about, figures["identity"])
    trial = with_edits(replace(beside, trajectories=whole, name=name, steps=_own(steps), about=about), edited)
    trajectories = trial.trajectories
    write_c3d(folder / f"{name}.c3d", trial)
    write_report(
        folder / REPORT,
        quality=figures,
        rig=inputs.rig,
        detections=records["detect"],
        tracks=records["track"].tracks,
        trajectories=trajectories,
        judged=inputs.calibrated.figures,
        pictures=inputs.source.pictures(fullest_frames(records["detect"])),
        assets=inputs.assets,
    )
    if inputs.settings.fill is not None:
        before = cropped(edited.trajectories, edited)
        drawn = figures["filling"] | {"identity": figures["identity"]}
        write_filling_page(folder / GAPS, figures=drawn, trajectories=trajectories, before=before)


def _own(steps: Sequence[Step]) -> tuple[Step, ...]:
    """The steps that made the trajectories."""
    return tuple(step for step in steps if step.stage not in ("quality", "write"))


def _save_tracked(path: Path, record: Tracked) -> None:
    """The tracks, and beside them what was ambiguous."""
    decisions = [decision.as_dict() for decision in record.ambiguous_decisions]
    said = {"ambiguous_decisions": decisions, "diagnostics": [found.as_dict() for found in record.diagnostics]}
    with replacing(path.with_name(DECISIONS)) as beside:
        beside.write_text(json.dumps(said, indent=1, ensure_ascii=False) + "\n", "utf-8")
    save(path, record.tracks)


def _load_tracked(path: Path) -> Tracked:
    """What an earlier run left; damaged files count as none."""
    try:
        said = json.loads(path.with_name(DECISIONS).read_text("utf-8"))
        unsure = tuple(map(AmbiguousDecision.of, said["ambiguous_decisions"]))
        return Tracked(_reader(Tracks)(path), unsure, tuple(map(Finding.of, said["diagnostics"])))
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise KinemarkError(f"{path.with_name(DECISIONS)} is damaged: {error}. Delete it.") from error


def _load_quality(path: Path) -> dict[str, Any]:
    """The figures that an earlier run left."""
    try:
        return dict(json.loads(path.read_text("utf-8")))
    except (OSError, ValueError) as error:
        raise KinemarkError(f"{path} is damaged: {error}. Delete it.") from error


def _done(path: Path, record: None) -> None:
    """Nothing is left to save: the stage has written its files itself."""


def _nothing(path: Path) -> None:
    """What is written is for others to read."""


def _reader(kind: type[Record]) -> Callable[[Path], Record]:
    """Reads a record of this kind, and takes any other for a damaged file."""

    def read(path: Path) -> Record:
        record = load(path)
        if not isinstance(record, kind):
            raise KinemarkError(f"{path} holds {type(record).__name__}, wanted {kind.__name__}. Delete it.")
        return record

    return read
