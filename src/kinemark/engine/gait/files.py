"""From files of walks, a standing trial and a subject's measures to a gait report: what `kinemark gait` does."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...data import Finding, KinemarkError
from ...data.gait_curves import GaitCurves, GaitReference
from ...data.marker_sides import without_subject
from ...data.subject_measures import SIDES, SubjectMeasures
from ...findings.gait import GaitOfTrial, gait_figures
from ...findings.gait_subjects import BodyOfTrial, of_left_out
from ...gait.clusters import Clusters, usual_clusters, with_wands
from ...gait.lower_limb import check_markers, leg_seen
from ...gait.same_motion import same_motion
from ...gait.standard_trial import with_absent_leg
from ...gait.static_axes import with_knees
from ...io.c3d import write_c3d
from ...io.files import write_json
from ...io.gait_csv import write_curves_csv, write_key_values_csv, write_time_distance_csv
from ...io.measures_toml import read_measures
from ...io.notes import FileNote, read_notes
from ...io.trial import read_trial
from ...report.drawing_library import assets_for
from ...report.gait_page import write_gait_page
from ...report.words import with_words
from ..identities import identity_of_file
from .bodies import bodies_of
from .doubts import feet_otherwise
from .exports import export_files, exports_of, write_exports
from .reference import read_band
from .settings import GaitSettings
from .trial_files import check_targets, trial_names
from .walks import (
    KnownMeasures,
    Recorded,
    SubjectGait,
    completed,
    how,
    known_measures,
    recorded,
    renamed,
    subject_gait,
    with_gait,
    with_hips,
)


def with_stated_clusters(static: Recorded, stated: Clusters) -> Recorded:
    """A standing trial with clusters whose markers are called as its file does, or as the gait model does.

    Args:
        static: whose markers of the model have the model's names. stated: markers by segment.
    """
    model = {without_subject(own): marker for marker, own in static.standard.known.items()}
    clusters = {
        segment: tuple(model.get(plain := without_subject(name), plain) for name in own)
        for segment, own in stated.items()
    }
    return replace(static, clusters=clusters)


def with_usual_clusters(static: Recorded, walks: Sequence[Recorded], settings: GaitSettings) -> Recorded:
    """A standing trial with the clusters that the walks want and whose names tell them, besides those it has.

    Args:
        static: with the clusters that were stated. walks: not completed. settings: say by which method; by Plug-in
            Gait's there are no clusters.
    """
    if settings.method == "plug_in_gait" or not walks:
        return static
    shared = set.intersection(*(set(_seen(walk)) for walk in walks))
    names = [name for name in _seen(walks[0]) if name in shared]
    stood = {name: xyz for name, xyz in static.points.items() if np.isfinite(xyz).any()}
    found = usual_clusters(names, with_wands(stood), static.clusters)
    return replace(static, clusters={**static.clusters, **found}, by_names=tuple(found)) if found else static


def _seen(walk: Recorded) -> list[str]:
    """Markers that are anywhere."""
    return [name for name, xyz in walk.points.items() if np.isfinite(xyz).any()]


PAGE, FIGURES = "gait.html", "gait.json"
CURVES, TIME_DISTANCE, KEY_VALUES = "curves.csv", "time_distance.csv", "key_values.csv"


class GaitResult(NamedTuple):
    """The gait of a subject, and where the files are; unusable: walks that were left out, and why."""

    trials: tuple[GaitOfTrial, ...]
    curves: tuple[GaitCurves, ...]
    figures: dict[str, Any]
    folder: Path
    notes: tuple[FileNote, ...]
    unusable: Mapping[Path, KinemarkError]


def gait_of_files(
    walks: Sequence[Path],
    *,
    left_out: Sequence[Path] = (),
    static: Path | None = None,
    functional: Path | None = None,
    measures: Path | SubjectMeasures | None = None,
    markers: Mapping[str, str] | None = None,
    reference: Path | None = None,
    mvc: Path | None = None,
    clusters: Clusters | None = None,
    folder: Path | None = None,
    exports: str = "",
    settings: GaitSettings | None = None,
    self_contained: bool = False,
) -> GaitResult:
    """Read walks, compute gait, and write page, tables, figures, and each walk as C3D with its results.

    Where one of several walks cannot be used, the others are; the page says why.

    Args:
        walks: trials of one subject with named markers; a recording that is given twice counts once.
        left_out: files of the same recordings in another format, which are told and kept.
        static: a standing trial, for the feet.
        functional: a motion that turns the hips in all directions, which shows their centres.
        measures: the subject's, or a TOML file of them; as the files state them, else estimated, where none are given.
        markers: the files' names of markers by the gait model's, where they are neither those nor usual ones.
        reference: band of controls, drawn grey, and scored against.
        mvc: of the muscles' greatest contractions, which are 100 % of the EMG.
        clusters: names of markers by the segment that they carry, one of `gait.clusters.SEGMENTS`; need a static trial.
        folder: of the results; beside the first walk, its name and `_gait`, where none is given.
        exports: for other programs, as "trc,mot,sto,gcd".
        settings: all else. self_contained: the page holds the drawing library.

    Raises:
        KinemarkError: there are no walks, none of them can be read or has the markers, another file cannot be read, the
            folder cannot be written, or a file of the results would overwrite one that was given.
    """
    settings, kinds = settings or GaitSettings(), exports_of(exports)
    if not walks:
        raise KinemarkError("There is no walk. Give one or more trials of the subject.")
    walks = list({path.resolve(): path for path in reversed(walks)}.values())[::-1]
    names = trial_names([*walks, *(path for path in (static, functional) if path is not None)])
    into = folder or walks[0].with_name(f"{walks[0].stem}_gait")
    stated_in = measures if isinstance(measures, Path) else None
    check_targets(
        _targets(into, [names[path.resolve()] for path in walks], kinds),
        [*walks, *left_out, static, functional, stated_in, reference, mvc],
    )
    band = None if reference is None else read_band(reference)

    def read(path: Path, like: Recorded | None = None) -> Recorded:
        return _read(path, names, markers, settings, like)

    given, still, unusable = _walks_and_standing(walks, static, read, clusters, settings)
    whole, repeated = _once(given)
    stated = measures if isinstance(measures, SubjectMeasures) or measures is None else read_measures(measures)
    known = known_measures(stated, whole, still)
    moved = None if functional is None else read(functional, still)
    if moved is not None:
        known = with_hips(known, completed(moved, still) if still is not None and still.clusters else moved, settings)
    found = subject_gait(whole, known, still, settings, None if mvc is None else read_trial(mvc))
    files = {names[path.resolve()]: str(path) for path in walks}
    no_use = [*of_left_out({names[path.resolve()]: str(error) for path, error in unusable.items()}, repeated)]
    bodies = bodies_of(whole, still, moved)
    figures = _figures(whole, still, found, known, static, band, settings, files, bodies, no_use,
                       contractions=mvc is not None)  # fmt: skip
    figures["emg_whole"] = settings.emg_to if mvc is None else mvc.name
    figures["identity"] = identity_of_file(whole[0].given, Path(files[whole[0].name]))
    notes = _written(into, whole, found, figures, band, self_contained=self_contained)
    write_exports(
        into, kinds, [(walk.name, walk.trial, one) for walk, one in zip(whole, found.trials, strict=True)],
        found.curves, counts=settings.made.mechanics.counts, mass_kg=known.measures.mass_kg,
    )  # fmt: skip
    if left_out:
        notes = (FileNote("left_out", "files", tuple(str(path) for path in left_out)), *notes)
    return GaitResult(found.trials, found.curves, figures, into, notes, unusable)


def _walks_and_standing(
    walks: Sequence[Path], static: Path | None, read: Callable[..., Recorded], clusters: Clusters | None,
    settings: GaitSettings,
) -> tuple[list[Recorded], Recorded | None, dict[Path, KinemarkError]]:  # fmt: skip
    """The walks with the points that clusters carry, the standing trial with its clusters, and why walks are left out.

    The walks are read before the usual clusters are known, for these are the ones that walks want; read: makes one of
    both.

    Raises:
        KinemarkError: there are clusters and no standing trial, that cannot be read, or no walk can be used.
    """
    if clusters and static is None:
        raise KinemarkError("Clusters are calibrated in a standing trial. Give one: --static standing.c3d")
    still = None if static is None else read(static)
    if still is not None and clusters:
        still = with_stated_clusters(still, clusters)
    found, unread = _each({path: path for path in walks}, lambda path: read(path, still))
    if still is not None:
        still = with_usual_clusters(still, list(found.values()), settings)
        still = replace(still, standard=with_absent_leg(still.standard))
    whole, incomplete = _each(found, lambda walk: _stood(completed(walk, still), still))
    unusable = unread | incomplete
    if not whole:
        raise next(iter(unusable.values()))
    if still is not None:
        _check_standing(still, list(whole.values()))
    return list(whole.values()), still, unusable


def _check_standing(still: Recorded, walks: Sequence[Recorded]) -> None:
    """Whether the standing trial has the model's markers.

    Raises:
        KinemarkError: it does not.
    """
    try:
        check_markers(with_wands(with_knees(still.points)))
    except KinemarkError as error:
        raise KinemarkError(f"{still.name}: {error}{_or_none(still, walks)}") from None


def _or_none(still: Recorded, walks: Sequence[Recorded]) -> str:
    """That these walks can be measured without the standing trial, where they wear all markers themselves."""
    if still.clusters or any(walk.standard.heels for walk in walks):
        return ""
    return (
        " Or leave the standing trial out (no --static; in a session, no trial of the kind static): walks are measured "
        "without it, with ankle and foot angles of the line from ankle to toe."
    )


def _stood(walk: Recorded, still: Recorded | None) -> Recorded:
    """The walk, where the standing trial shows each of its legs: ankles without offsets are some 10° off.

    Raises:
        KinemarkError: it does not.
    """
    if still is None:
        return walk
    bare = [side for side in SIDES if leg_seen(walk.points, side) and not leg_seen(still.points, side)]
    if bare:
        raise KinemarkError(
            f"{walk.name}: The standing trial {still.name} never shows the {' and the '.join(bare)} leg, so that there "
            "are no offsets of the foot. Name the leg's markers there, or give another standing trial."
            f"{_or_none(still, [walk])}"
        )
    return walk


def _each(
    given: Mapping[Path, Any], make: Callable[[Any], Recorded]
) -> tuple[dict[Path, Recorded], dict[Path, KinemarkError]]:
    """What is made of each walk, and why nothing can be made of the others."""
    made, failed = dict[Path, Recorded](), dict[Path, KinemarkError]()
    for path, walk in given.items():
        try:
            made[path] = make(walk)
        except KinemarkError as error:
            failed[path] = error
    return made, failed


def _once(walks: Sequence[Recorded]) -> tuple[list[Recorded], dict[str, str]]:
    """Each recording once, as the first of its files has it; and that file's name by the name of each other.

    Steps that count twice would make the spread between strides, and all that rests on it, too small.
    """
    kept, repeated = list[Recorded](), dict[str, str]()
    for walk in walks:
        rate = walk.trial.trajectories.rate
        like = (one for one in kept if one.trial.trajectories.rate == rate and same_motion(one.points, walk.points))
        if (first := next(like, None)) is None:
            kept.append(walk)
        else:
            repeated[walk.name] = first.name
    return kept, repeated


def _read(
    path: Path, names: Mapping[Path, str], markers: Mapping[str, str] | None, settings: GaitSettings,
    static: Recorded | None = None,
) -> Recorded:  # fmt: skip
    """A file; markers that it does not have are missed where they are wanted."""
    name = names[path.resolve()]
    return recorded(name, replace(read_trial(path), name=name), markers or {}, settings, like=static)


def _targets(folder: Path, names: Sequence[str], kinds: Sequence[str]) -> Iterable[Path]:
    """All files that the results may be."""
    whole = [folder / name for name in (PAGE, FIGURES, CURVES, TIME_DISTANCE, KEY_VALUES)]
    return [*whole, *(_c3d(folder, name) for name in names), *export_files(folder, kinds, names)]


def _c3d(folder: Path, name: str) -> Path:
    """Of a walk with its results."""
    return folder / f"{name}_gait.c3d"


def _figures(
    walks: Sequence[Recorded], still: Recorded | None, found: SubjectGait, known: KnownMeasures, static: Path | None,
    band: GaitReference | None, settings: GaitSettings, files: Mapping[str, str], bodies: Sequence[BodyOfTrial],
    left_out: Sequence[Finding], *, contractions: bool,
) -> dict[str, Any]:  # fmt: skip
    """All figures, with their words."""
    stated = {one.name: str(one.given.about.get("subject") or "") for one in (*walks, still) if one is not None}
    subject = settings.subject or next((stated[walk.name] for walk in walks if stated[walk.name]), "")
    feet = None if still is None else feet_otherwise(still.given, still.points, flat_foot=settings.flat_foot)
    return with_words(
        gait_figures(
            found.trials, found.curves, found.causes, subject=subject, measures=found.measures,
            method=how(settings, known.hips), static=None if static is None else static.name, reference=band,
            estimated=known.estimated, hips=known.hips, axes=found.axes, clusters=found.clusters,
            heels=sorted({name for walk in walks for name in walk.standard.heels}), renamed=renamed(*walks),
            stated=stated, files=files, feet=feet, bodies=bodies, left_out=left_out,
            contractions=contractions,
        )
    )  # fmt: skip


def _written(
    folder: Path, walks: Sequence[Recorded], found: SubjectGait, figures: dict[str, Any], band: GaitReference | None,
    *, self_contained: bool,
) -> tuple[FileNote, ...]:  # fmt: skip
    """All files of the results."""
    folder.mkdir(parents=True, exist_ok=True)
    notes: list[FileNote] = []
    for walk, one in zip(walks, found.trials, strict=True):
        notes += read_notes(walk.given.notes)
        notes += write_c3d(_c3d(folder, walk.name), with_gait(walk, one))
    write_curves_csv(folder / CURVES, found.curves)
    write_time_distance_csv(folder / TIME_DISTANCE, {one.name: one.strides for one in found.trials})
    write_key_values_csv(folder / KEY_VALUES, {one.name: one.keys for one in found.trials})
    write_json(folder / FIGURES, figures)
    write_gait_page(
        folder / PAGE, figures=figures, curves=found.curves, reference=band,
        assets=None if self_contained else assets_for(folder),
    )  # fmt: skip
    return tuple(notes)
