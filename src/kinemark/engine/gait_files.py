"""From walks, a standing trial and a subject's measures to gait: what `kinemark gait` does."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..data import Events, KinemarkError, Trial
from ..data.array_types import Floats
from ..data.gait_curves import GaitCurves, GaitReference
from ..data.strides import FootEvent
from ..data.subject_measures import SubjectMeasures
from ..findings.gait import GaitOfTrial, gait_figures
from ..gait import with_static_offsets
from ..gait.emg import Emg, emg
from ..gait.foot_events import foot_events
from ..gait.gait_cycles import emg_curves, gait_curves
from ..gait.gait_trial import analyse_gait, marker_points, measured_only
from ..gait.lower_limb import check_markers
from ..gait.time_distance import strides
from ..gait.uncertainty import gait_uncertainty, with_uncertainty
from ..io.c3d import write_c3d
from ..io.c3d.subject_measures import measures_of
from ..io.files import replacing
from ..io.gait_csv import write_curves_csv, write_time_distance_csv
from ..io.gait_reference import read_reference
from ..io.measures_toml import read_measures
from ..io.notes import FileNote, read_notes
from ..io.trial import read_trial
from ..report.drawing_library import assets_for
from ..report.gait_page import write_gait_page
from ..report.words import with_words
from .gait_exports import exports_of, write_exports
from .gait_settings import GaitSettings
from .identities import identity_of_file

FORCE_UNITS = ("N", "NM", "NMM", "NCM")
"""Of channels that are a force plate's, without other letters."""


class GaitResult(NamedTuple):
    """The gait of a subject, and where the files are."""

    trials: tuple[GaitOfTrial, ...]
    curves: tuple[GaitCurves, ...]
    figures: dict[str, Any]
    folder: Path
    notes: tuple[FileNote, ...]


def gait_of_files(
    walks: Sequence[Path],
    *,
    static: Path | None = None,
    measures: Path | None = None,
    reference: Path | None = None,
    folder: Path | None = None,
    exports: str = "",
    settings: GaitSettings | None = None,
    self_contained: bool = False,
) -> GaitResult:
    """Read walks, compute gait, and write page, tables, figures, and each walk as C3D with its results.

    Args:
        walks: trials of one subject with named markers.
        static: a standing trial, for the feet.
        measures: TOML file of the subject's measures; as the files state them where none is given.
        reference: band of controls, drawn grey, and scored against.
        folder: of the results; beside the first walk, its name and `_gait`, where none is given.
        exports: for other programs, as "trc,mot,sto,gcd".
        settings: all else. self_contained: the page holds the drawing library.

    Raises:
        KinemarkError: there are no walks, a file cannot be read, a marker or the measures are missing, or the folder
            cannot be written.
    """
    settings, kinds = settings or GaitSettings(), exports_of(exports)
    if not walks:
        raise KinemarkError("There is no walk. Give one or more trials of the subject.")
    band = None if reference is None else read_reference(reference)
    read = [read_trial(path) for path in walks]
    still = None if static is None else read_trial(static)
    for path, trial in zip(walks, read, strict=True):
        _check(path, trial)
    bare = subject_measures(measures, read, still)
    stood = None if still is None else marker_points(still)
    known = bare if stood is None else _with_offsets(bare, stood, static, settings)
    given = bare if stood is not None else known
    causes: dict[str, dict[str, Floats]] = {}
    trials = []
    for trial in read:
        own = _uncertain(trial, given, stood, settings)
        trials.append(gait_of_trial(trial, known, settings, own))
        causes = causes or own
    curves = _joined(
        [(*gait_curves(one.gait.signals, one.strides), *emg_curves(one.emg, one.strides)) for one in trials]
    )
    subject = next((t.about["subject"] for t in read if t.about.get("subject")), "")
    figures = with_words(
        gait_figures(
            trials, curves, causes, subject=subject, measures=known, method={"name": settings.method} | _how(settings),
            static=None if static is None else static.name, reference=band,
        )
    )  # fmt: skip
    figures["identity"] = identity_of_file(read[0], walks[0])
    into = folder or walks[0].with_name(f"{walks[0].stem}_gait")
    notes = _written(into, walks, read, trials, curves, figures, band, self_contained=self_contained)
    write_exports(
        into, kinds, [(p.stem, t, one) for p, t, one in zip(walks, read, trials, strict=True)], curves,
        counts=settings.made.mechanics.counts, mass_kg=known.mass_kg,
    )  # fmt: skip
    return GaitResult(tuple(trials), curves, figures, into, notes)


def subject_measures(path: Path | None, walks: Sequence[Trial], static: Trial | None) -> SubjectMeasures:
    """Of the file where there is one, else of the static trial, else of the first walk that states them.

    Raises:
        KinemarkError: nobody states them.
    """
    if path is not None:
        return read_measures(path)
    for trial in ([] if static is None else [static], walks)[0:2]:
        for one in trial:
            found = measures_of(one.source)
            if found is not None:
                return found
    raise KinemarkError(
        "No file states the subject's measures. Give them: --measures anna.toml with mass_kg, and under [left] and "
        "[right] leg_mm, knee_mm and ankle_mm."
    )


def gait_of_trial(
    trial: Trial, measures: SubjectMeasures, settings: GaitSettings, causes: Mapping[str, Mapping[str, Floats]]
) -> GaitOfTrial:
    """One walk: segments and loads with their error bars, events, strides, EMG.

    Raises:
        KinemarkError: a marker is missing, or a plate cannot be read.
    """
    points, rate, method = marker_points(trial), trial.trajectories.rate, settings.made
    events = foot_events(trial, points)
    found = measured_only(analyse_gait(trial, measures, method=method), events, method.mechanics.counts, rate)
    if causes:
        found = replace(found, signals=with_uncertainty(found.signals, causes))
    steps = strides(events, points, rate=rate, heel_sd_mm=_heel_sd(trial))
    start = (trial.trajectories.first_frame - 1) / rate
    return GaitOfTrial(trial.name, found, events, steps, trial.events, start, _emg(trial))


def _check(path: Path, trial: Trial) -> None:
    try:
        check_markers(marker_points(trial))
    except KinemarkError as error:
        raise KinemarkError(f"{path}: {error}") from None


def _with_offsets(
    measures: SubjectMeasures, stood: Mapping[str, Floats], static: Path | None, settings: GaitSettings
) -> SubjectMeasures:
    try:
        return with_static_offsets(
            measures, stood, flat_foot=settings.flat_foot, hip_centre=settings.made.mechanics.hip_centre
        )
    except KinemarkError as error:
        raise KinemarkError(f"{static}: {error}") from None


def _uncertain(
    trial: Trial, measures: SubjectMeasures, stood: Mapping[str, Floats] | None, settings: GaitSettings
) -> dict[str, dict[str, Floats]]:
    """By cause and name; empty where it is not asked for."""
    if not settings.uncertainty:
        return {}
    return gait_uncertainty(
        trial, measures, method=settings.made, errors=settings.errors, static=stood, flat_foot=settings.flat_foot
    )


def _heel_sd(trial: Trial) -> float:
    """mm along an axis, as the heels' covariance states it; 0 where it states none."""
    variances = [
        np.diagonal(p.cov, axis1=1, axis2=2).ravel() for p in trial.trajectories if p.name.endswith(("LHEE", "RHEE"))
    ]
    known = np.concatenate(variances) if variances else np.zeros(0)
    known = known[np.isfinite(known)]
    return float(np.sqrt(np.median(known))) if len(known) else 0.0


def _emg(trial: Trial) -> dict[str, Emg]:
    """Of each channel in volts, or whose name says EMG, that is no plate's."""
    plates = {name for plate in trial.plates for name in plate.channels}
    found: dict[str, Emg] = {}
    for record in trial.analog:
        for name, unit in zip(record.names, record.units, strict=True):
            letters = "".join(c for c in unit.upper() if c.isalpha())
            is_emg = "EMG" in name.upper() or letters in ("V", "MV", "UV", "ΜV")
            if name not in plates and is_emg and np.ptp(record[name]) > 0:
                found[name] = emg(record[name], rate=record.rate, start=record.start)
    return found


def _how(settings: GaitSettings) -> dict[str, Any]:
    if settings.method == "plug_in_gait":
        return {"flat_foot": settings.flat_foot}
    names = ("hip_centre", "inertia", "smoothing", "cutoff_hz", "flat_foot")
    return {name: getattr(settings, name) for name in names}


def _joined(each: Sequence[Sequence[GaitCurves]]) -> tuple[GaitCurves, ...]:
    """Curves of one name of all trials together."""
    by_name: dict[str, list[GaitCurves]] = {}
    for curves in each:
        for one in curves:
            by_name.setdefault(one.name, []).append(one)
    return tuple(
        same[0]._replace(
            values=np.concatenate([c.values for c in same]), sd=np.concatenate([c.sd for c in same]),
            foot_off=np.concatenate([c.foot_off for c in same]),
        )
        for same in by_name.values()
    )  # fmt: skip


def with_gait(trial: Trial, result: GaitOfTrial) -> Trial:
    """The trial with its results among the signals, and its events where it had none."""
    events = trial.events if len(trial.events) else as_events(result.events, result.start_s)
    return replace(trial, signals=trial.signals.updated(result.gait.signals), events=events)


def as_events(events: Sequence[FootEvent], start_s: float) -> Events:
    """As files have them."""
    return Events(
        tuple("Foot Strike" if e.strike else "Foot Off" for e in events),
        tuple(e.side.title() for e in events),
        np.array([e.time + start_s for e in events]),
    )


def _written(
    folder: Path, walks: Sequence[Path], read: Sequence[Trial], trials: Sequence[GaitOfTrial],
    curves: Sequence[GaitCurves], figures: dict[str, Any], band: GaitReference | None, *, self_contained: bool,
) -> tuple[FileNote, ...]:  # fmt: skip
    """All files of the results."""
    folder.mkdir(parents=True, exist_ok=True)
    notes: list[FileNote] = []
    for path, trial, one in zip(walks, read, trials, strict=True):
        notes += read_notes(trial.notes)
        notes += write_c3d(folder / f"{path.stem}_gait.c3d", with_gait(trial, one))
    write_curves_csv(folder / "curves.csv", curves)
    write_time_distance_csv(folder / "time_distance.csv", [stride for one in trials for stride in one.strides])
    with replacing(folder / "gait.json") as beside:
        beside.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    write_gait_page(
        folder / "gait.html", figures=figures, curves=curves, reference=band,
        assets=None if self_contained else assets_for(folder),
    )  # fmt: skip
    return tuple(notes)
