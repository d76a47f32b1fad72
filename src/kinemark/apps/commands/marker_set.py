"""Marker sets: which there are, what they hold, and one learnt from a labelled trial."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from ...io.marker_sets import read_marker_set
from ..output import Json, print_result

marker_set = App(name="marker-set", help=__doc__)


@marker_set.command(name="list")
def list_sets(*, json: Json = False) -> None:
    """List the marker sets that come with Kinemark."""
    from ...engine.naming.marker_set_files import list_text, listed

    print_result(listed() if json else list_text())


@marker_set.command
def show(name: str, *, figure: Path | None = None, json: Json = False) -> None:
    """Show a marker set: markers in words, segments, joints, left and right.

    Args:
        name: one of `kinemark marker-set list`, or a TOML file.
        figure: draw it there, front and back: an SVG, or an HTML page with tables; an existing file is not replaced.
    """
    from ...engine.naming.marker_set_files import draw_set, set_figures, set_text

    found = read_marker_set(name)
    if figure is not None:
        draw_set(figure, found)
    print_result(set_figures(found) if json else set_text(found))


@marker_set.command(name=("from", "FROM"))
def learn(
    trial: Path,
    *,
    output: Annotated[Path, Parameter(name=("--output", "-o"))],
    markers: str = "",
    json: Json = False,
) -> None:
    """Learn a marker set from a labelled trial: segments, links with their length, left and right.

    What never moves against each other in the trial becomes one segment: give one in which all joints move, as a range
    of motion, and correct the file by hand.

    Args:
        trial: labelled, of any program.
        output: the TOML file to write; an existing file is not replaced.
        markers: names that belong to the set, as LASI,RASI,SACR; all where none is given, but for
            points that were computed of others, such as segments' axes.
    """
    from ...engine.naming.marker_set_files import set_figures, set_from_file, set_text

    found = set_from_file(trial, output, names=tuple(filter(None, markers.split(","))))
    print_result(set_figures(found) if json else set_text(found))
