"""`kinemark fill`: the gaps of files."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...data import KinemarkError
from ..output import (
    FailOn,
    Json,
    LengthUnit,
    Partial,
    Rate,
    SelfContained,
    exit_by_verdict,
    print_errors,
    print_note,
    print_result,
)
from ..progress import progress


def fill(
    source: Path,
    *sources: Path,
    output: Annotated[Path | None, Parameter(name=("--output", "-o"))] = None,
    method: str = "auto",
    set: Annotated[list[str] | None, Parameter(name="--set", negative="")] = None,
    model: Path | None = None,
    limit_mm: float | None = None,
    ends: bool = False,
    trim: int = 0,
    static: Path | None = None,
    report: bool = False,
    table: Path | None = None,
    self_contained: SelfContained = False,
    rate_hz: Rate = None,
    length_unit: LengthUnit = None,
    partial: Partial = False,
    fail_on: Annotated[
        FailOn,
        Parameter(help="a verdict as bad as this ends the command with status 3; red where no gap could be filled."),
    ] = "never",
    json: Json = False,
) -> None:
    """Fill the gaps of a trial's markers, each with an expected error; what was measured stays as it was.

    Args:
        source: a file of trajectories: C3D, TDF, TRC, CSV, HDF5 or TDC; or a folder, for all its C3D, TRC, TDF and TDC
            files.
        sources: and others, which go into a folder under their names.
        output: the file to write, C3D, TRC, CSV, HDF5 or TDC, or a folder; an existing file is not replaced. Where none
            is given: NAME_filled beside the file; of several, and of a folder, a folder "filled" beside each.
        method: auto finds out for every gap which method is best; `kinemark methods fill` lists them.
        set: PARAMETER=VALUE of the method; may be repeated.
        model: an angle model (CSV) or another trial of the same motion, for limb_angles, kalman_angles and auto.
        limit_mm: gaps whose expected mean error is greater stay open; inf leaves none open for that. Where none is
            given: 20, or less where what is measured is smaller than a person.
        ends: also fill before a marker's first sample and after its last.
        trim: so many suspicious samples may be replaced on each side of a gap; 0 lists them and keeps all that was
            measured.
        static: a trial in which markers are seen that this one never shows.
        report: write a page beside the output on which every gap is drawn.
        table: CSV file with a row a gap of all files, for statistics; an earlier table is replaced, and no other file.
    """
    from ...engine.fill_files import (
        check_table,
        fill_files,
        fill_method,
        filled_figures,
        filled_text,
        gaps_of,
        targets_of,
    )
    from ...engine.folders import trials_in
    from ...io.gaps_csv import write_gaps_csv

    chosen = fill_method(method, set or (), model=model)
    every = trials_in((source, *sources), besides=(static,), say=print_note)
    targets = targets_of(every, output, alone=every == (source,))
    if table is not None:
        check_table(table, (*every, *targets.values(), static))
    with progress() as tell:
        done = fill_files(
            every, targets, report=report,
            progress=tell, method=chosen,
            name=method, limit_mm=limit_mm, ends=ends, trim=trim, static=static, rate_hz=rate_hz,
            length_unit=length_unit, partial=partial,
        )  # fmt: skip
    if table is not None:
        write_gaps_csv(table, gaps_of(done))
    filled = [found for found in done.values() if not isinstance(found, KinemarkError)]
    failed = {str(path): found for path, found in done.items() if isinstance(found, KinemarkError)}
    if json:
        print_result(filled_figures(done))
    elif filled:
        print_result(filled_text(done) + (f"\ntable:    {table}" if table else ""))
    if failed:
        print_errors(failed)
        sys.exit(1)
    exit_by_verdict([found.figures["verdict"]["grade"] for found in filled], fail_on)
