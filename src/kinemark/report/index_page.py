"""The trials of a session with their verdicts, key figures and pages, as one page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from .formatting import identity_text, measure, number, percent
from .templating import render, write_text

NAV = {"calibration": "Calibration", "trials": "Trials"}
"""Sections of the page, in their order."""
HEAD = ("trial", "verdict", "recorded", "markers", "complete in view", "gaps", "median residual", "σ per axis", "pages")


class Link(NamedTuple):
    """A file beside the page, and what it is called."""

    address: str
    name: str


class IndexRow(NamedTuple):
    """A trial: its name, verdict (None where it was not processed), figures, files, how many are named, and why it
    could not be processed."""

    name: str
    verdict: Mapping[str, Any] | None
    about: str
    cells: Sequence[str]
    links: Sequence[Link]
    named: str = ""
    why: str = ""

    def with_names(self) -> IndexRow:
        """With how many of its markers are named, where it was processed."""
        return self._replace(cells=[*self.cells[:2], self.named or "–", *self.cells[2:]] if self.cells else [])


def index_row(
    name: str, quality: Mapping[str, Any] | None, files: Sequence[tuple[str, str]], *, why: str = ""
) -> IndexRow:
    """A trial by its figures, and its files, each as its path beside the page and its title.

    Figures are of an earlier run, and left out, where `why` says that the last one came to nothing.
    """
    links = [Link(quote(path), title) for path, title in files]
    if quality is None or why:
        return IndexRow(name, None, "", [], links, why=why)
    trajectories, recording = quality["trajectories"], quality["recording"]
    cells = [
        f"{measure(recording['duration_s'], 2, 's')}, {number(recording['rate_hz'])} Hz",
        number(trajectories["count"]),
        percent(trajectories["completeness_in_view_share"]),
        number(trajectories["gaps"]),
        measure(quality["points"]["residual_median_px"], 2, "px"),
        measure(trajectories["sd_per_axis_mean_mm"], 2, "mm"),
    ]
    return IndexRow(name, quality["verdict"], identity_text(quality.get("identity")), cells, links, _named(quality))


def _named(quality: Mapping[str, Any]) -> str:
    """How many of the markers that there should be have a name; empty where nobody was to name them."""
    labels = quality.get("labels")
    if labels is None:
        return ""
    return f"{sum(one['state'] in ('sure', 'stated') for one in labels['markers'])} of {len(labels['markers'])}"


def index_page(
    *, session: str, calibration: Mapping[str, Any] | None, rows: Sequence[IndexRow], version: str,
    gait: tuple[str, bool] | None = None,
) -> str:  # fmt: skip
    """The page as text.

    Args:
        session: its name. calibration: what calibration.json holds, None where there is none yet. rows: its trials.
        version: of Kinemark. gait: a sentence of the gait report, and whether there is a page; None without `[gait]`.
    """
    about = {row.about for row in rows if row.about}
    named = any(row.named for row in rows)
    return render(
        "index.html",
        library=None,
        heading=f"Session {session}",
        below=" · ".join([*(about if len(about) == 1 else ()), f"Kinemark {version}"]),
        nav=NAV,
        calibration=calibration,
        head=(*HEAD[:4], "named", *HEAD[4:]) if named else HEAD,
        rows=[row.with_names() for row in rows] if named else rows,
        apart=len(about) > 1,
        gait=gait,
    )


def write_index(path: Path, **content: Any) -> None:
    """Write `index_page` of this content, whole or not at all; a page that says the same stays as it is.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    text = index_page(**content)
    if not path.is_file() or path.read_text("utf-8") != text:
        write_text(path, text)
