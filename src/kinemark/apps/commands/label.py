"""`kinemark label`: names for the markers of a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...data import KinemarkError
from ...engine.label_files import check_file, check_text, label_file, label_text, template_of
from ..output import Json, print_result


def label(
    source: Path,
    *,
    template: Annotated[list[Path], Parameter(name=("--template", "-t"), consume_multiple=True, negative="")],
    output: Annotated[Path | None, Parameter(name=("--output", "-o"))] = None,
    markers: str = "",
    static: bool = False,
    scale: float | None = None,
    unsure: bool = False,
    check: bool = False,
    json: Json = False,
) -> None:
    """Name the markers of a trial by labelled trials of the subject; what is not sure stays unnamed.

    Args:
        source: a file of trajectories, with or without names: C3D, TDF, TRC, CSV, HDF5 or TDC.
        template: one or more labelled trials of the subject.
        output: the file to write; an existing file is not replaced.
        markers: names that the template learns, as LASI,RASI,SACR; all where none is given. Name them where the files
            of the template also hold computed points, such as segments' axes.
        static: the template's trials show no motion.
        scale: the template is of another subject; height of this one over that of the other.
        unsure: also take names that are not sure.
        check: write nothing; list where names that the file has are exchanged.
        json: print name, probability and runner-up of each track for a machine.
    """
    learnt = template_of(template, markers=tuple(filter(None, markers.split(","))), static=static, scale=scale)
    if check:
        found = check_file(source, learnt)
        print_result([one._asdict() for one in found] if json else check_text(source, found))
        return
    if output is None:
        raise KinemarkError("There is no output. Name the file to write with -o, or --check to write none.")
    done = label_file(source, output, learnt, unsure=unsure)
    print_result(done.figures if json else label_text(done))
