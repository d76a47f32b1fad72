"""Templates of subjects: learnt from what there is, shown, and grown with further trials."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from ...io.files import check_new
from ...io.marker_sets import read_marker_set
from ..output import Json, print_note, print_result

template = App(name="template", help=__doc__)
Heights = Annotated[
    list[float] | None,
    Parameter(name="--heights-mm", consume_multiple=True, negative="", help="Of the others whose files are given."),
]


@template.command
def learn(
    *files: Path,
    output: Annotated[Path, Parameter(name=("--output", "-o"))],
    marker_set: str | None = None,
    markers: str = "",
    static: bool = False,
    cluster: Annotated[tuple[str, ...], Parameter(negative="")] = (),
    subject: str = "",
    height_mm: float | None = None,
    heights_mm: Heights = None,
    json: Json = False,
) -> None:
    """Learn a subject's template and keep it in a file.

    Args:
        files: labelled trials of the subject; with --heights-mm, labelled trials or templates of other subjects; none
            where nothing but the marker set and the height is known.
        output: the file to write, NAME.template.h5; an existing file is not replaced.
        marker_set: what the subject wears: one of `kinemark marker-set list`, or a TOML file.
        markers: names to learn, as LASI,RASI,SACR; those of the marker set, or all, where none is given.
        static: the trials show no motion.
        cluster: markers that sit on one segment, of a static trial without a marker set, as "left thigh=A,B,C"; may be
            given again.
        subject: name of the subject.
        height_mm: of the subject, mm.
        heights_mm: of the other subjects, mm, one for each file.
    """
    from ...engine.clusters_said import clusters_of
    from ...engine.naming.subject_templates import Known, subject_template, template_figures, template_text
    from ...engine.naming.template_files import save_template

    check_new(output)
    worn = read_marker_set(marker_set) if marker_set else None
    names = tuple(filter(None, markers.split(",")))
    known = Known(
        worn, names, static, subject, height_mm, tuple(heights_mm or ()), clusters=clusters_of(cluster), say=print_note
    )
    found = subject_template(files, known)
    save_template(output, found)
    print_result(template_figures(found) if json else template_text(found))


@template.command
def show(file: Path, *, json: Json = False) -> None:
    """Show what a template holds: markers, subject, and the trials that it was learnt from.

    Args:
        file: NAME.template.h5.
    """
    from ...engine.naming.subject_templates import template_figures, template_text
    from ...engine.naming.template_files import load_template

    found = load_template(file)
    print_result(template_figures(found) if json else template_text(found))


@template.command
def grow(file: Path, trial: Path, *trials: Path, json: Json = False) -> None:
    """Add labelled trials of the subject to a template; one that contradicts it is refused, and nothing is written.

    Args:
        file: NAME.template.h5, which is replaced.
        trial: labelled, and looked through.
        trials: and others.
    """
    from ...engine.naming.subject_templates import template_figures, template_text, with_trial
    from ...engine.naming.template_files import load_template, save_template

    found = load_template(file)
    for one in (trial, *trials):
        found = with_trial(found, one, say=print_note)
    save_template(file, found)
    print_result(template_figures(found) if json else template_text(found))
