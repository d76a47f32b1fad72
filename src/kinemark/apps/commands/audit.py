"""`kinemark audit`: what is probably wrong with the tracks and names of labelled files, of any system."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ...data import KinemarkError
from ..output import BAD_VERDICT, Json, print_errors, print_note, print_result
from ..progress import at_work

if TYPE_CHECKING:  # these take long to import, and --help does without
    from ...engine.audit import Audit


SHOWN = 6
"""Names of computed points that are listed; chosen: they tell which program computed them."""


def audit(
    source: Path,
    *sources: Path,
    template: Annotated[
        list[Path] | None, Parameter(name=("--template", "-t"), consume_multiple=True, negative="")
    ] = None,
    mend: Annotated[bool, Parameter(negative="")] = False,
    every: bool = False,
    by: str = "",
    json: Json = False,
) -> None:
    """List what is probably wrong with labelled files: swaps, spikes, wrong names, left and right; ends with 3 if any.

    Args:
        source: a file of trajectories: C3D, TDF, TRC, CSV or HDF5; or SESSION/TRIAL; or a folder, for all its C3D, TRC,
            TDF and TDC files.
        sources: and others.
        template: labelled trials of the subject, or a kept template (NAME.template.h5), by which names are judged;
            what a file is itself like where none is given.
        mend: write what is sure into the journal beside the file, edits/NAME.jsonl; kinemark edits apply writes another
            file with it, and kinemark edits undo takes it back.
        every: also list what is not worth a look.
        by: who mends; the user of the machine where not given.
    """
    from ...engine.audit import Audit, audit_files
    from ...engine.folders import trials_in
    from ...engine.naming.files import template_of

    learnt = template_of(template).template if template else None
    trials = trials_in((source, *sources), say=print_note)
    with at_work() as tell:
        done = audit_files(trials, template=learnt, mend=mend, by=by, announce=lambda file: tell(f"looking at {file}"))
    found = {str(path): one for path, one in done.items() if isinstance(one, Audit)}
    if json:
        print_result({path: _figures(one) for path, one in found.items()})
    else:
        print_result("\n\n".join(f"{path}\n{_text(one, every)}" for path, one in found.items()))
    failed = {str(path): one for path, one in done.items() if isinstance(one, KinemarkError)}
    print_errors(failed)
    if failed:
        sys.exit(1)
    if any(one.found.asked for one in found.values()):
        sys.exit(BAD_VERDICT)


def _figures(one: Audit) -> dict[str, object]:
    from ..edits_output import problems_figures

    return problems_figures(one.found) | {"mended": [problem.words for problem in one.mended], "computed": [*one.aside]}


def _text(one: Audit, every: bool) -> str:
    from ..edits_output import problems_text

    said = [f"mended: {problem.words}" for problem in one.mended]
    if one.aside:
        some = ", ".join([*one.aside[:SHOWN], *["…"][: len(one.aside) - SHOWN]])
        said.append(f"not looked at: {len(one.aside)} points that were computed of markers ({some})")
    return "\n".join([*said, problems_text(one.found, every=every)])
