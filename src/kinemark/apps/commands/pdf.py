"""`kinemark pdf`: reports on paper."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...data import KinemarkError
from ..output import Json, print_result


def pdf(
    source: Path, *sources: Path, output: Annotated[Path | None, Parameter(alias="-o")] = None, json: Json = False
) -> None:
    """Print reports to PDF, A4, by the Chromium, Chrome or Edge that is installed.

    Args:
        source: a page, as results/walk01/report.html or anna/gait.html; or a folder: the reports of a session's trials,
            or every page that lies in it.
        sources: and others.
        output: folder of the PDFs; each lies beside its page where it is not given.
    """
    from ..pdf import print_pdf

    pages = [page for one in (source, *sources) for page in _pages(one)]
    targets = [_target(page, output) for page in pages]
    if len(set(targets)) < len(targets):
        raise KinemarkError(
            "Two of the pages would be written to one PDF. Print them one after the other, or without --output."
        )
    made = []
    for page, target in zip(pages, targets, strict=True):
        made.append({"page": str(page), "pdf": str(print_pdf(page, target))})
        if not json:
            print_result(made[-1]["pdf"])
    if json:
        print_result(made)


def _pages(source: Path) -> list[Path]:
    """What is to be printed; raises a KinemarkError where a folder holds no page."""
    if not source.is_dir():
        return [source]
    found = sorted(source.glob("results/*/report.html")) or sorted(source.glob("*.html"))
    if not found:
        raise KinemarkError(f"{source} holds no report. Run the session first, or name the page that is to be printed.")
    return found


def _target(page: Path, output: Path | None) -> Path:
    """Beside the page; in a folder, reports of trials by the names of their trials."""
    if output is None:
        return page.with_suffix(".pdf")
    return output / f"{page.resolve().parent.name if page.stem == 'report' else page.stem}.pdf"
