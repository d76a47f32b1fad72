"""From files of walks, a standing trial and a subject's measures to a gait report: what `kinemark gait` does."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...data import KinemarkError
from ...data.gait_curves import GaitCurves, GaitReference
from ...data.marker_sides import without_subject
from ...data.subject_measures import SIDES, SubjectMeasures
from ...findings.gait import gait_figures
from ...findings.gait_records import GaitOfTrial, GivenFiles, MeasuredSubject, StandingShown
from ...findings.gait_subjects import of_left_out
from ...gait.clusters import Clusters, usual_clusters, with_wands
from ...gait.lower_limb import check_markers, leg_seen
from ...gait.same_motion import same_motion
from ...gait.standard_trial import with_absent_leg
from ...gait.static_axes import with_knees
from ...io.c3d import write_c3d
from ...io.files import write_json
from ...io.gait_csv import write_curves_csv, write_key_values_csv, write_time_distance_csv
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
from .trial_files import SubjectFiles, check_targets
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


class GivenTrials(NamedTuple):
    """The trials of a subject as they were read.

    Attributes:
        walks: that can be used, each recording once. still: the standing trial. moved: the motion that shows the hips.
        unusable: why others cannot be used. repeated: which other walk is the same recording, by their names.
    """

    walks: list[Recorded]
    still: Recorded | None
    moved: Recorded | None
    unusable: dict[Path, KinemarkError]
    repeated: dict[str, str]


def gait_of_files(
    given: SubjectFiles,
    *,
    folder: Path | None = None,
    exports: str = "",
    settings: GaitSettings | None = None,
    self_contained: bool = False,
) -> GaitResult:
    """Read walks, compute gait, and write page, tables, figures, and each walk as C3D with its results.

    Where one of several walks cannot be used, the others are; the page says why.

    Args:
        given: the files of one subject. folder: of the results; beside the first walk, its name and `_gait`, where none
            is given. exports: for other programs, as "trc,mot,sto,gcd". settings: all else.
        self_contained: the page holds the drawing library.

    Raises:
        KinemarkError: there are no walks, none of them can be read or has the markers, another file cannot be read, the
            folder cannot be written, or a file of the results would overwrite one that was given.
    """
    settings, kinds = settings or GaitSettings(), exports_of(exports)
    if not given.walks:
        raise KinemarkError("There is no walk. Give one or more trials of the subject.")
    given = given.once()
    into = folder or given.walks[0].with_name(f"{given.walks[0].stem}_gait")
    check_targets(_targets(into, [given.name(path) for path in given.walks], kinds), given.every())
    band = None if given.reference is None else read_band(given.reference)
    trials = _trials(given, settings)
    known = _known(given.stated_measures(), trials, settings)
    contractions = None if given.mvc is None else read_trial(given.mvc)
    found = subject_gait(trials.walks, known, trials.still, settings, contractions)
    figures = _figures(given, trials, known, found, band, settings)
    notes = _written(into, trials.walks, found, figures, band, self_contained=self_contained)
    write_exports(
        into, kinds, [(walk.name, walk.trial, one) for walk, one in zip(trials.walks, found.trials, strict=True)],
        found.curves, counts=settings.made.mechanics.counts, mass_kg=known.measures.mass_kg,
    )  # fmt: skip
    if given.left_out:
        notes = (FileNote("left_out", "files", tuple(str(path) for path in given.left_out)), *notes)
    return GaitResult(found.trials, found.curves, figures, into, notes, trials.unusable)


def _trials(given: SubjectFiles, settings: GaitSettings) -> GivenTrials:
    """Walks, standing trial and motion of the hips; markers that they do not have are missed where they are wanted."""

    def read(path: Path, like: Recorded | None = None) -> Recorded:
        name = given.name(path)
        return recorded(name, replace(read_trial(path), name=name), given.markers, settings, like=like)

    walks, still, unusable = _walks_and_standing(given, read, settings)
    whole, repeated = _once(walks)
    moved = None if given.functional is None else read(given.functional, still)
    return GivenTrials(whole, still, moved, unusable, repeated)


def _known(stated: SubjectMeasures | None, trials: GivenTrials, settings: GaitSettings) -> KnownMeasures:
    """The subject's measures, with the hips that a motion shows."""
    walks, still, moved = trials.walks, trials.still, trials.moved
    known = known_measures(stated, walks, still)
    if moved is None:
        return known
    return with_hips(known, completed(moved, still) if still is not None and still.clusters else moved, settings)


def _walks_and_standing(
    given: SubjectFiles, read: Callable[..., Recorded], settings: GaitSettings
) -> tuple[list[Recorded], Recorded | None, dict[Path, KinemarkError]]:
    """The walks with the points that clusters carry, the standing trial with its clusters, and why walks are left out.

    The walks are read before the usual clusters are known, for these are the ones that walks want; read: makes one of
    both.

    Raises:
        KinemarkError: there are clusters and no standing trial, that cannot be read, or no walk can be used.
    """
    if given.clusters and given.static is None:
        raise KinemarkError("Clusters are calibrated in a standing trial. Give one: --static standing.c3d")
    still = None if given.static is None else read(given.static)
    if still is not None and given.clusters:
        still = with_stated_clusters(still, given.clusters)
    found, unread = _each({path: path for path in given.walks}, lambda path: read(path, still))
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


def _targets(folder: Path, names: Sequence[str], kinds: Sequence[str]) -> Iterable[Path]:
    """All files that the results may be."""
    whole = [folder / name for name in (PAGE, FIGURES, CURVES, TIME_DISTANCE, KEY_VALUES)]
    return [*whole, *(_c3d(folder, name) for name in names), *export_files(folder, kinds, names)]


def _c3d(folder: Path, name: str) -> Path:
    """Of a walk with its results."""
    return folder / f"{name}_gait.c3d"


def _figures(
    given: SubjectFiles, trials: GivenTrials, known: KnownMeasures, found: SubjectGait, band: GaitReference | None,
    settings: GaitSettings,
) -> dict[str, Any]:  # fmt: skip
    """All figures, with their words."""
    files = _said(given, trials)
    subject = settings.subject or next((name for walk in trials.walks if (name := files.subjects[walk.name])), "")
    figures = with_words(
        gait_figures(
            found.trials, found.curves, found.causes,
            subject=MeasuredSubject(subject, found.measures, known.estimated, known.hips),
            method=how(settings, known.hips), standing=_standing(given, trials, found, settings), files=files,
            reference=band, contractions=given.mvc is not None,
        )
    )  # fmt: skip
    figures["emg_whole"] = settings.emg_to if given.mvc is None else given.mvc.name
    first = trials.walks[0]
    figures["identity"] = identity_of_file(first.given, Path(files.paths[first.name]))
    return figures


def _said(given: SubjectFiles, trials: GivenTrials) -> GivenFiles:
    """What the files say besides motion."""
    standing = [] if trials.still is None else [trials.still]
    unusable = {given.name(path): str(error) for path, error in trials.unusable.items()}
    return GivenFiles(
        paths={given.name(path): str(path) for path in given.walks},
        subjects={one.name: str(one.given.about.get("subject") or "") for one in (*trials.walks, *standing)},
        renamed=renamed(*trials.walks),
        bodies=bodies_of(trials.walks, trials.still, trials.moved),
        left_out=[*of_left_out(unusable, trials.repeated)],
    )


def _standing(given: SubjectFiles, trials: GivenTrials, found: SubjectGait, settings: GaitSettings) -> StandingShown:
    """What the standing trial has shown."""
    still = trials.still
    name = None if given.static is None else given.static.name
    feet = None if still is None else feet_otherwise(still.given, still.points, flat_foot=settings.flat_foot)
    heels = sorted({marker for walk in trials.walks for marker in walk.standard.heels})
    return StandingShown(name, found.axes, found.clusters, heels, feet)


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
