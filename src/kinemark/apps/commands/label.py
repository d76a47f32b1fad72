"""`kinemark label`: names for the markers of files, and checks of names that they have."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ...data import KinemarkError
from ...io.marker_sets import read_marker_set
from ...io.track_names import read_track_names
from ..output import BAD_VERDICT, Json, print_errors, print_note, print_result
from ..progress import at_work

if TYPE_CHECKING:  # these take long to import, and --help does without
    from ...engine.naming.check_files import CheckedNames
    from ...engine.naming.subject_templates import Known


def label(
    source: Path,
    *sources: Path,
    template: Annotated[
        list[Path] | None, Parameter(name=("--template", "-t"), consume_multiple=True, negative="")
    ] = None,
    output: Annotated[Path | None, Parameter(name=("--output", "-o"))] = None,
    marker_set: str | None = None,
    markers: str = "",
    static: bool = False,
    cluster: Annotated[tuple[str, ...], Parameter(negative="")] = (),
    subject: Annotated[list[str] | None, Parameter(name="--subject", negative="")] = None,
    scale: float | None = None,
    height_mm: float | None = None,
    heights_mm: Annotated[
        list[float] | None, Parameter(name="--heights-mm", consume_multiple=True, negative="")
    ] = None,
    names: Path | None = None,
    unsure: bool = False,
    computed: bool = False,
    by_location: Path | None = None,
    up: str = "z",
    check: bool = False,
    json: Json = False,
) -> None:
    """Name the markers of trials by what is known of the subject; what is not sure stays unnamed.

    Args:
        source: a file of trajectories, with or without names: C3D, TDF, TRC, CSV, HDF5 or TDC; or a folder, for all its
            C3D, TRC, TDF and TDC files but those of --template.
        sources: and others, which go into a folder under their names.
        template: labelled trials of the subject, or a template that was kept (NAME.template.h5), or both. Without it a
            marker set and a height give names that are never sure.
        output: the file to write, or a folder; an existing file is not replaced.
        marker_set: what the subject wears: one of `kinemark marker-set list`, or a TOML file.
        markers: names that the template learns, as LASI,RASI,SACR; those of the marker set, or all, where none is
            given.
        static: the template's trials show no motion; with a marker set, its segments say which distances stay.
        cluster: markers that sit on one segment, of a static trial without a marker set, as "left thigh=A,B,C"; may be
            given again. Those and the segment's landmarks keep their distances.
        subject: of several in one volume, a name and a template or labelled trial: A=anna.template.h5; one each. The
            name stands before those of markers, as in A:LKNE.
        scale: the template is of another subject; height of this one over that of the other.
        height_mm: of the subject, mm.
        heights_mm: the templates are of other subjects; height of each, mm.
        names: a TOML or CSV file of names that are stated of tracks; they are facts.
        unsure: also take names that are not sure.
        computed: also learn and name points that were computed of markers, as segments' axes and joint centres are;
            without it they stay as they are, with the names that they have.
        by_location: a labelled trial of whatever subject with the same markers, instead of a template: tracks are named
            by height, side and front alone, which asks nothing of distances between markers.
        up: the axis that points upwards, for that: x, y or z.
        check: write nothing; list exchanged markers, swapped sides and stretches with a wrong name in files that have
            names; status 3 where there are any.
    """
    from ...engine.clusters_said import clusters_of
    from ...engine.folders import trials_in
    from ...engine.naming.subject_templates import Known

    every = trials_in((source, *sources), besides=template or (), say=print_note)
    if by_location is not None:
        _label_by_location(every, by_location, output, up=up, unsure=unsure, json=json)
        return
    known = Known(
        read_marker_set(marker_set) if marker_set else None, tuple(filter(None, markers.split(","))), static,
        height_mm=height_mm, heights_mm=tuple(heights_mm or ()), computed=computed, clusters=clusters_of(cluster),
        to_name=every, say=print_note,
    )  # fmt: skip
    if subject and (template or scale or heights_mm or check):
        raise KinemarkError("Of several subjects each has its template: give --subject alone, without --template, …")
    learnt = _learnt(template or [], subject or [], known, scale)
    if check:
        _check(every, learnt, json)
        return
    if output is None:
        raise KinemarkError("There is no output. Name the file to write with -o, or --check to write none.")
    stated = read_track_names(names) if names is not None else ()
    if stated and len(every) > 1:
        raise KinemarkError(
            "Names are stated of one file's tracks, and there are several files. Label them one by one."
        )
    _label(every, output, learnt, json=json, unsure=unsure, stated=stated, computed=computed)


def _learnt(template: list[Path], subject: list[str], known: Known, scale: float | None) -> Any:
    """The template, or one of each subject."""
    from ...engine.naming.files import template_of
    from ...engine.naming.subject_templates import templates_of_subjects

    with at_work() as tell:
        tell("learning the template")
        return templates_of_subjects(subject, known) if subject else template_of(template, known, scale=scale)


def _label(every: tuple[Path, ...], output: Path, learnt: Any, *, json: bool, **how: Any) -> None:
    """Name the markers of files; status 1 where one could not be read or written."""
    from ...engine.naming.files import LabelledFile, label_files, label_text

    with at_work() as tell:
        done = label_files(every, output, learnt, announce=lambda file: tell(f"naming the markers of {file}"), **how)
    found = {str(path): one for path, one in done.items() if isinstance(one, LabelledFile)}
    if json:
        figures = {path: one.figures for path, one in found.items()}
        print_result(figures if len(every) > 1 else figures[str(every[0])])
    else:
        print_result("\n\n".join(label_text(one) for one in found.values()))
    _exit_by_errors({str(path): one for path, one in done.items() if isinstance(one, KinemarkError)})


def _check(every: tuple[Path, ...], learnt: Any, json: bool) -> None:
    """Check the names that files have."""
    from ...engine.naming.check_files import check_files

    with at_work() as tell:
        checked = check_files(every, learnt, announce=lambda file: tell(f"checking the names of {file}"))
    _print_checks(checked, json)


def _label_by_location(
    sources: tuple[Path, ...], shown: Path, output: Path | None, *, up: str, unsure: bool, json: bool
) -> None:
    """Name the tracks of one file by where they are."""
    from ...engine.fill_files import own_name
    from ...engine.naming.by_location import label_file_by_location, location_text

    if output is None or len(sources) > 1:
        raise KinemarkError("By location one file is named at a time. Give one, and the file to write with -o.")
    target = output / own_name(sources[0]) if output.is_dir() or not output.suffix else output
    found = label_file_by_location(sources[0], target, shown, up=up, unsure=unsure)
    print_result(found.figures if json else location_text(found))


def _print_checks(done: dict[Path, CheckedNames | KinemarkError], json: bool) -> None:
    """What was found; status 1 where a file could not be checked, 3 where names are wrong."""
    from ...engine.naming.check_files import CheckedNames, check_figures, check_text

    found = {path: one for path, one in done.items() if isinstance(one, CheckedNames)}
    if json:
        print_result({str(path): check_figures(one) for path, one in found.items()})
    else:
        print_result("\n".join(check_text(path, one) for path, one in found.items()))
    _exit_by_errors({str(path): one for path, one in done.items() if isinstance(one, KinemarkError)})
    if not all(one.good for one in found.values()):
        sys.exit(BAD_VERDICT)


def _exit_by_errors(failed: dict[str, KinemarkError]) -> None:
    print_errors(failed)
    if failed:
        sys.exit(1)
