"""The stages of a trial, in one of three graphs.

detect → track → fill → quality → write                          trackers that match by themselves
detect → match → reconstruct → track → fill → quality → write    matching first, then tracks of points
detect → track → fill → quality → write                          an operator has said which marker is which

Where a session has `[label]`, the stage `label` follows on `track`; where somebody has said something of the trial,
`edit` follows on that; where it has `[angles]`, `angles` comes before `quality`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

from ..data import (
    Cloud,
    Detections,
    Fills,
    Finding,
    Matches,
    Rig,
    Step,
    Trajectories,
    Trial,
    make_finding,
)
from ..data.edits import Claim
from ..data.trial import UP
from ..edit import cropped
from ..fill import Filled, Rays, fill_recording
from ..findings.cameras import AsGiven
from ..findings.gaps import filling_figures
from ..findings.quality import write_quality
from ..findings.trial_records import AboutTrial, TrialRecords
from ..io.c3d import on_frames, write_c3d
from ..io.notes import UNREADABLE
from ..io.records import save
from ..match import match
from ..reconstruct import reconstruct
from ..report.figures_detections import fullest_frames
from ..report.filling_page import write_filling_page
from ..report.page import write_report
from ..report.trial_quality import quality
from ..track import matches_itself
from .angles.stage import ANGLE_FILES, compute_angles, found_by_angles, model_key
from .calibration.task import Calibrated
from .camera_checks.pixel_axes import pixel_axes
from .camera_checks.same_images import same_images
from .camera_checks.start_times import with_start_times
from .camera_checks.swapped_cameras import swapped_cameras
from .editing.retracking import retrack_stage
from .editing.stage import cropped_fill, edit_stage, unreviewed, with_edits
from .graph import Graph, Records, Stage
from .identities import identity_of_entry, stated_identity, with_identity
from .keys import rig_key
from .length_unit import length_unit
from .naming import FILES, Earlier, NamedTracks, load_named, save_named
from .naming.claims import claims_of
from .naming.label_stage import given_of, name_trial, static_of
from .naming.naming import with_names
from .settings import Settings
from .sources import TrialSource, beside_key, identifies, recorded_beside
from .store import load_figures
from .tracking_in_time import Tracked, puts_in_time
from .tracking_stage import (
    DECISIONS,
    TRACKS,
    Tracking,
    as_operated,
    from_detections,
    from_points,
    reader,
    told_by_calibration,
    with_angle_model,
)
from .trial_inputs import (
    TrialInputs,
    detections_of,
    edits_of,
    filled_of,
    last_tracked,
    measured_of,
    seen_of,
    tracks_of,
    trial_rig,
    with_placed,
)
from .trial_rig import RIG

GAPS, REPORT, QUALITY = "gaps.html", "report.html", "quality.json"
IN_TRACKS = ("match", "reconstruct")
"""Stages whose records the tracks hold, so that no later stage asks for them."""


def trial_graph(
    name: str, settings: Settings, source: TrialSource, calibrated: Calibrated, earlier: tuple[Earlier, ...] = ()
) -> Graph[TrialInputs]:
    """The stages of a trial by its settings; `earlier` are those by whose names its own are found."""
    s = settings
    stages = _to_tracks(name, s, source, calibrated)

    def needs() -> tuple[str, ...]:
        return tuple(stage.name for stage in stages if stage.name not in IN_TRACKS)

    if s.label is not None:
        claims = () if identifies(source) else claims_of(source.of.root, name)
        given, compute = given_of(source.of, earlier, claims), partial(_label, claims)
        stages.append(Stage("label", needs(), FILES, compute, save_named, load_named, s.label, given))
    stages += edit_stage(source.of.root, name, calibrated.rig, needs(), measured_of)
    if s.fill is not None:
        stages.append(Stage("fill", needs(), ("fills.h5",), _fill, save, reader(Fills), s.fill))
    if s.angles is not None:
        given = (s.angles, model_key(source.of), beside_key(source))
        stages.append(Stage("angles", needs(), ANGLE_FILES, _angles, _done, load_figures, given=given, in_place=True))
    made = [(step.input, step.method) for step in calibrated.steps]
    about = asdict(stated_identity(s, source.of.entry))
    stated = (s.name, about, s.match, s.reconstruct, made, calibrated.figures, beside_key(source))
    stages.append(Stage("quality", needs(), (QUALITY,), _quality, write_quality, load_figures, given=stated))
    outputs = (f"{name}.c3d", REPORT, *((GAPS,) if s.fill is not None else ()))
    stages.append(Stage("write", needs(), outputs, _write, _done, _nothing, in_place=True))
    return Graph(tuple(stages))


def _to_tracks(name: str, s: Settings, source: TrialSource, calibrated: Calibrated) -> list[Stage[TrialInputs]]:
    """The stages from the images to the tracks of the trial."""
    rig = rig_key(calibrated.rig)
    detecting = Stage("detect", (), ("detections.h5",), _detect, save, reader(Detections), s.detect)
    detecting = replace(detecting, given=(source.key(),), in_place=source.of.entry.answers is not None)
    stages = [replace(detecting, cameras=s.detect_cameras)]
    tracks = Tracking((TRACKS, DECISIONS, RIG))
    kept = rig, calibrated.rig.method, [camera.residual for camera in calibrated.rig]  # all that the trial's rig says
    if identifies(source):
        return [*stages, tracks.stage(as_operated, ("detect",), None, (kept, s.digitise, s.reconstruct))]
    if matches_itself(s.track):
        told = told_by_calibration(calibrated, s)
        stages.append(tracks.stage(from_detections, ("detect",), s.track, (kept, s.reconstruct, told)))
    else:
        matched, cloud = reader(Matches), reader(Cloud)
        stages.append(Stage("match", ("detect",), ("matches.h5",), _match, save, matched, s.match, (rig,)))
        places = ("detect", "match")
        stages.append(Stage("reconstruct", places, ("cloud.h5",), _reconstruct, save, cloud, s.reconstruct))
        method = with_angle_model(s.track, source.of.root)
        stages.append(tracks.stage(from_points, ("detect", "match", "reconstruct"), method, (kept,)))
    return [*stages, *retrack_stage(source, name, calibrated.rig, s.track, s.reconstruct)]


def _detect(inputs: TrialInputs, records: Records) -> Detections:
    return inputs.source.detections(inputs.threads)


def _match(inputs: TrialInputs, records: Records) -> Matches:
    return match(records["detect"], inputs.rig, method=inputs.settings.match)


def _reconstruct(inputs: TrialInputs, records: Records) -> Cloud:
    method = inputs.settings.reconstruct
    return reconstruct(records["match"], records["detect"], inputs.rig, method=method)


def _label(claims: tuple[Claim, ...], inputs: TrialInputs, records: Records) -> NamedTracks:
    """Names for the tracks, by `[label]` and by what people claimed."""
    if inputs.source.operated() is None:
        named = None
    else:  # what an operator said are facts
        named = measured_of(inputs, {key: record for key, record in records.items() if key != "label"})
    tracks, cameras = last_tracked(records).tracks, trial_rig(records)
    return name_trial(inputs.source.of, tracks, inputs.earlier, named, claims, detections_of(records), cameras)


def _fill(inputs: TrialInputs, records: Records) -> Fills:
    """What filling adds, by `[fill]`."""
    method, edited = inputs.settings.fill, edits_of(inputs, records)
    assert method is not None  # else there is no such stage
    rays = Rays.left_by(tracks_of(records), seen_of(records), trial_rig(records).rig)
    measured = edited.trajectories
    static = static_of(inputs.earlier, inputs.settings.subjects_of(inputs.source.of.entry))
    filled = fill_recording(measured, rays, method=method, static=static, choices=edited.choices)
    before = with_placed(measured, filled.gaps)
    return Fills.between(before, filled.trajectories, tuple(json.dumps(asdict(gap)) for gap in filled.gaps))


def _angles(inputs: TrialInputs, records: Records) -> dict[str, Any]:
    """Joint angles, by `[angles]`."""
    return compute_angles(_trial(inputs, records), inputs.source.of, inputs.folder, inputs.earlier, inputs.assets)


def _trial(inputs: TrialInputs, records: Records) -> Trial:
    """The trial as people said it is, with what was recorded beside it."""
    trajectories = filled_of(inputs, records).trajectories
    beside = recorded_beside(inputs.source, trajectories.rate) or Trial("", trajectories)
    return with_edits(replace(beside, trajectories=trajectories, name=inputs.name), edits_of(inputs, records))


def _quality(inputs: TrialInputs, records: Records) -> dict[str, Any]:
    """Every figure of the trial."""
    s, detections, tracked, of = inputs.settings, detections_of(records), last_tracked(records), inputs.source.of
    cameras = trial_rig(records)
    edited, beside = edits_of(inputs, records), recorded_beside(inputs.source, detections.rate)
    filled = cropped_fill(filled_of(inputs, records), edited)
    measured = TrialRecords(
        rig=cameras.rig,
        detections=cameras.timed(detections),
        tracks=tracks_of(records),
        trajectories=filled.trajectories,
        ambiguous_decisions=unreviewed(tracked.ambiguous_decisions, edited),
        track_names=records["label"].tracker_names if "label" in records else None,
        given=AsGiven(inputs.rig, detections),
    )
    identity = identity_of_entry(of.root, s, of.entry, beside.about if beside else None)
    figures = quality(
        measured,
        about=AboutTrial(s.name, inputs.name, of.first_frame, identity),
        steps=(*inputs.calibrated.steps, *inputs.store.steps),
        findings=(
            *inputs.source.contradictions(),
            *subtracted(detections),
            *_channels(beside, filled.trajectories),
            *_cameras(inputs, detections, cameras.rig, tracked),
            *_of_stages(inputs, records, detections, tracked),
        ),
        judged=inputs.calibrated.figures,
        filling=_gap_figures(inputs, filled, cropped(edited.trajectories, edited)),
    )
    if "edit" in records:
        figures["edits"] = records["edit"].figures
    operated = inputs.source.operated()
    if "label" in records:
        figures["labels"] = dict(records["label"].figures)
    if operated is not None:
        figures["digitising"] = dict(operated.figures)
    return figures


def _cameras(inputs: TrialInputs, detections: Detections, rig: Rig, tracked: Tracked) -> Iterator[Finding]:
    """What is wrong with whole cameras."""
    cloud = tracked.tracks.cloud
    yield from same_images(detections, tracked.diagnostics)
    how: dict[str, Any] = {"matching": inputs.settings.match, "placing": inputs.settings.reconstruct}
    yield from swapped_cameras(detections, rig, cloud, **how)  # a mirrored ring is one with cameras swapped
    yield from pixel_axes(detections, rig, cloud, **how)
    yield from length_unit(detections, rig, cloud)


def _of_stages(inputs: TrialInputs, records: Records, detections: Detections, tracked: Tracked) -> Iterator[Finding]:
    """What tracking, naming, editing and joint angles found."""
    told, rig, tried = _diagnostics(tracked, records), trial_rig(records).rig, puts_in_time(inputs.settings)
    found = [*with_start_times(told, detections, rig, whole=not tried)]
    found += records["label"].findings if "label" in records else ()
    yield from (one.numbered(inputs.source.of.first_frame) for one in found)
    yield from records["edit"].findings if "edit" in records else ()
    yield from found_by_angles(records["angles"]) if "angles" in records else ()


def _diagnostics(tracked: Tracked, records: Records) -> tuple[Finding, ...]:
    """What the tracker found, with the names that its tracks have now."""
    if "label" not in records or not records["label"].tracker_names:
        return tracked.diagnostics
    named = [with_names(found, records["label"].tracker_names) for found in tracked.diagnostics]
    return tuple(found for found in named if found is not None)


def subtracted(detections: Detections) -> Iterator[Finding]:
    """From the images of which cameras a static ground was subtracted."""
    if detections.ground_subtracted:
        yield make_finding("ground_subtracted", cameras=detections.ground_subtracted)


def _channels(beside: Trial | None, trajectories: Trajectories) -> Iterator[Finding]:
    """What of the recording could not be read, and what the C3D file cannot hold of its channels."""
    for kind, own in ("recording_partly_read", True), ("recording_notes", False):
        notes = [] if beside is None else [one for one in beside.notes if one.startswith(UNREADABLE) == own]
        if notes:
            yield make_finding(kind, parts_list=[one.removeprefix(UNREADABLE) for one in notes])
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
    measured = with_placed(measured, filled.gaps)
    return filling_figures(filled, measured, source=inputs.name, method=method.name, limit_mm=method.limit_mm)


def _write(inputs: TrialInputs, records: Records) -> None:
    """The trial for other programs, and for a person who reads."""
    trial, figures, edited = _trial(inputs, records), records["quality"], edits_of(inputs, records)
    folder, name, trajectories = inputs.folder, inputs.name, trial.trajectories
    about = {UP: "+Z"} | with_identity(trial.about, figures["identity"])
    write_c3d(folder / f"{name}.c3d", replace(trial, steps=_own(tuple(inputs.store.steps)), about=about))
    write_report(
        folder / REPORT,
        quality=figures,
        rig=trial_rig(records).rig,
        detections=records["detect"],
        tracks=tracks_of(records),
        trajectories=trajectories,
        judged=inputs.calibrated.figures,
        pictures=inputs.source.pictures(fullest_frames(records["detect"])),
        assets=inputs.assets,
    )
    if inputs.settings.fill is not None:
        before = cropped(with_placed(edited.trajectories, filled_of(inputs, records).gaps), edited)
        drawn = figures["filling"] | {"identity": figures["identity"]}
        write_filling_page(folder / GAPS, figures=drawn, trajectories=trajectories, before=before)


def _own(steps: Sequence[Step]) -> tuple[Step, ...]:
    """The steps that made the trajectories."""
    return tuple(step for step in steps if step.stage not in ("angles", "quality", "write"))


def _done(path: Path, record: None) -> None:
    """Nothing is left to save: the stage has written its files itself."""


def _nothing(path: Path) -> None:
    """What is written is for others to read."""
