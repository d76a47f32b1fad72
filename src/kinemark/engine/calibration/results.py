"""Calibrating a session, judging the calibration, and keeping what was there before.

results/rig.toml                      the calibration, with its residuals and quality in [metadata]
results/calibration.json              every figure of the judgement
results/calibration.html              the same as a page
results/calibrations/…-rig.toml       former calibrations, by the time when they were made
"""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, replace
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...calibrate.quality import Change, Evidence, compare, points_of, volume_grid
from ...data import KinemarkError, Rig
from ...data.progress import listening
from ...findings.calibration_quality import calibration_figures, headline_figures, judged_volume
from ...findings.quality import write_quality
from ...io.files import replacing
from ...io.rig_toml import read_rig_toml, write_rig_toml
from ...io.um2as import files_of_set
from ...numerics.blas_threads import one_blas_thread
from ...report.calibration_page import write_calibration_page
from ...report.drawing_library import ASSETS, relink
from ...report.words import with_words
from ..identities import file_date, stated_identity
from ..keys import code_key, digest, file_key, rig_key
from ..progress import SILENT, Watch, check_threads
from ..recordings import files_of, masks_key
from ..settings import Settings
from ..store import WAITING, Store
from .from_known_points import from_control_frame, from_control_points, from_file, is_cp
from .from_moved_target import from_single_marker, from_wand
from .task import Calibrated, RigWithEvidence, Task

RIG, FIGURES, PAGE, FORMER = "rig.toml", "calibration.json", "calibration.html", "calibrations"
LOCK = ".calibration.lock"
COMPARED_PLACES = 200
"""Of the volume, by whose images calibrations are compared; chosen for speed."""


class LastCalibration(NamedTuple):
    """The cameras, the figures of calibration.json, when they were made, and whether a run would take them as they
    are."""

    rig: Rig
    figures: dict[str, Any]
    made: datetime
    current: bool


class EarlierCalibration(NamedTuple):
    """A former calibration: when it was made, its cameras, and how those of now differ from them."""

    made: str
    rig: Rig
    change: Change


WAYS: dict[str, Callable[[Task], RigWithEvidence]] = {
    "file": from_file,
    "control_points": from_control_points,
    "control_frame": from_control_frame,
    "wand": from_wand,
    "single_marker": from_single_marker,
}
"""What does each way of `settings.WAYS`."""


def calibrate(
    root: Path, results: Path, settings: Settings, *, watch: Watch = SILENT, threads: int | None = None
) -> Calibrated:
    """The calibration of a session in the folder `root`, read where it is unchanged, else made, judged and written.

    Args:
        root: the session's folder.
        results: where what is computed goes.
        settings: what its session.toml says.
        watch: receives progress, and may cancel.
        threads: how many detection may use; all processors where None.

    Raises:
        KinemarkError: what the calibration needs is absent or unusable, or it has fewer than two cameras.
        Cancelled: the watch says so.
    """
    check_threads(threads)
    task = Task(root, settings, watch, threads)
    with (
        one_blas_thread(),
        Store.open(results, results / LOCK, watch.of(WAITING)) as store,
        listening(watch.of("calibrate")),
    ):
        rig, figures = store.do(
            "calibrate",
            None if settings.calibration.file else settings.calibrate,
            calibration_key(task),
            files=(RIG, FIGURES, PAGE),
            make=lambda: _made(task, results),
            save=_save,
            load=_load,
        )
        relink(results / PAGE, results / ASSETS, self_contained=settings.report.self_contained)
        return Calibrated(rig, figures, tuple(store.steps), bool(store.computed), results)


def last_calibration(root: Path, results: Path, settings: Settings) -> LastCalibration | None:
    """What was calibrated last, read and not computed; None where there is none, or it is damaged."""
    try:
        rig, figures = _load(results / RIG)
        current = Store.read(results).holds("calibrate", calibration_key(Task(root, settings, SILENT)), (RIG, FIGURES))
    except KinemarkError:
        return None
    made = datetime.fromtimestamp((results / RIG).stat().st_mtime)
    return LastCalibration(rig, figures, made, current)


def earlier_calibrations(results: Path, now: LastCalibration) -> list[EarlierCalibration]:
    """The former calibrations of a session, the last first, each compared with the one that counts now.

    One that cannot be read, or has none of the cameras, is left out.
    """
    places = points_of(volume_grid(now.figures["volume"]["corners_mm"], places=COMPARED_PLACES))
    found = []
    for path in sorted((results / FORMER).glob(f"*-{RIG}"), reverse=True):
        with suppress(KinemarkError):
            rig = read_rig_toml(path)
            if {*rig.names} & {*now.rig.names}:
                found.append(EarlierCalibration(path.name.removesuffix(f"-{RIG}"), rig, compare(rig, now.rig, places)))
    return found


def calibration_key(task: Task) -> str:
    """A key of all that the calibration depends on."""
    s = task.settings
    written, footage = _files_of(task)
    detected = [s.detect, s.detect_cameras] if footage else []
    masks = masks_key(task.root, s, s.cameras.names) if detected else []
    said = [s.name, asdict(stated_identity(s)), s.cameras, s.calibration, s.calibrate, s.volume_mm, detected]
    return digest(code_key(), file_key(*written, *footage), said, masks)


def _files_of(task: Task) -> tuple[list[Path], list[Path]]:
    """The files that the calibration rests on: those that state something, and footage."""
    s, c, root = task.settings, task.settings.calibration, task.root
    named = [c.file, c.control_points and c.control_points.points, c.control_frame and c.control_frame.rods]
    named += [c.world_points and c.world_points.points]
    written = [root / path for path in named if path]
    written += files_of_set(root / c.file, "cp") if c.file and is_cp(c.file) else []
    footage = []
    for pointed in (c.control_points, c.control_frame, c.linearisation, c.world_points):
        footage += files_of(root, s, pointed.images, s.cameras.names) if pointed and pointed.images else []
    distance = c.single_marker.distance if c.single_marker else None
    for seen in (c.wand, c.single_marker, distance, c.l_frame):
        footage += files_of(root, s, seen, s.cameras.names)
    return written, footage


def _made(task: Task, results: Path) -> tuple[Rig, dict[str, Any]]:
    """The calibration and its figures; the page is written, and the former calibration put aside."""
    rig, evidence = WAYS[task.settings.calibration.way](task)
    if task.settings.volume_mm is not None:
        rig = replace(rig, volume=np.array(task.settings.volume_mm))
    if len(rig) < 2:
        raise KinemarkError(
            f"The calibration has {len(rig)} camera, and a point in space needs two. Calibrate another camera."
        )
    since, change = _put_aside(results, rig, evidence)
    figures = with_words(calibration_figures(rig, evidence, session=task.settings.name, change=change, since=since))
    assets = None if task.settings.report.self_contained else results / ASSETS
    written, footage = _files_of(task)
    figures["identity"] = asdict(replace(stated_identity(task.settings), file_date=file_date(footage or written)))
    write_calibration_page(results / PAGE, figures=figures, rig=rig, evidence=evidence, assets=assets)
    write_quality(results / FIGURES, figures)
    return rig, figures


def _save(path: Path, record: tuple[Rig, dict[str, Any]]) -> None:
    rig, figures = record
    write_rig_toml(path, rig, metadata={**headline_figures(figures), "headline": figures["verdict"]["headline"]})


def _load(path: Path) -> tuple[Rig, dict[str, Any]]:
    """What an earlier run left; incomplete or damaged files count as none."""
    if not (path.parent / PAGE).is_file():
        raise KinemarkError(f"{path.parent / PAGE} is not there.")
    try:
        return read_rig_toml(path), json.loads((path.parent / FIGURES).read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise KinemarkError(f"{path.parent / FIGURES} is damaged: {error}") from error


def _put_aside(results: Path, rig: Rig, evidence: Evidence) -> tuple[str, Change | None]:
    """Keeps the former rig.toml, if it says something else; its name among the former, and what changed."""
    path = results / RIG
    if not path.is_file():
        return "", None
    try:
        old = read_rig_toml(path)
        if rig_key(old) == rig_key(rig):
            return "", None
        change = compare(old, rig, points_of(volume_grid(judged_volume(rig, evidence), places=COMPARED_PLACES)))
    except KinemarkError:  # a damaged one is kept all the same: somebody may mend it
        change = None
    kept = _free_name(results / FORMER, datetime.fromtimestamp(path.stat().st_mtime))
    with replacing(kept) as beside:
        beside.write_bytes(path.read_bytes())
    return f"{FORMER}/{kept.name}", change


def _free_name(folder: Path, made: datetime) -> Path:
    """A name by date and time that no file has yet."""
    stem = made.strftime("%Y-%m-%dT%H-%M-%S")
    names = (folder / f"{stem}{f'-{n}' if n else ''}-{RIG}" for n in range(1000))
    return next(path for path in names if not path.exists())
