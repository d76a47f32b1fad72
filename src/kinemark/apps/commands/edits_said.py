"""What is said of a trial: names, erased samples, gaps, places, verdicts, trims; commands of `kinemark edits`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...data import KinemarkError
from ...data.edits import SmoothingFunction
from ..output import Json

Why = Annotated[str, Parameter(help="Why, in your words; kept in the journal.")]
By = Annotated[str, Parameter(help="Who says it; the user of the machine where not given.")]
Span = Annotated[
    str | None,
    Parameter(help="Frames A-B, numbers in the recording; A- or -B follows the path to its end; all where not given."),
]


def claim(
    trial: Path,
    *,
    track: str,
    name: str | None = None,
    no_marker: Annotated[bool, Parameter(negative="")] = False,
    frames: Span = None,
    anyway: Annotated[bool, Parameter(negative="")] = False,
    why: Why = "",
    by: By = "",
    json: Json = False,
) -> None:
    """Say which marker a trajectory is, or that it is none.

    Where another trajectory has the name already, it is first looked whether the two can be one marker.

    Args:
        trial: SESSION/NAME or a file.
        track: the trajectory, as it is called now: '*12', or a name.
        name: of the marker.
        no_marker: it is none: a ghost.
        frames: of the stretch that is meant.
        anyway: join two that do not seem to be one marker.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import print_said, span_of

    if (name is None) != no_marker:
        raise KinemarkError("Say either --name NAME or --no-marker.")
    editing = open_editing(trial, by=by)
    first, last = span_of(frames)
    joined = None if name is None or frames is not None else editing.connection(track, name)
    if joined is not None and not joined.connectable and not anyway:
        where = f"overlap in {joined.overlap} frames" if joined.overlap else f"are {joined.gap} frames apart"
        raise KinemarkError(
            f"{track} does not go on {name}: they {where}, and are {joined.off_mm:.1f} mm off, "
            f"{joined.deviations:.1f} standard deviations. Join them with --anyway, or name frames with --frames."
        )
    print_said(editing.claim(track, name, first=first, last=last, why=why), json)


def exchange(
    trial: Path, one: str, other: str, *, frames: Span = None, why: Why = "", by: By = "", json: Json = False
) -> None:
    """Give two trajectories each other's names.

    Args:
        trial: SESSION/NAME or a file.
        one: a marker.
        other: the marker that it was taken for.
        frames: in which they are exchanged: 751- from frame 751 on.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import print_said, span_of

    first, last = span_of(frames)
    print_said(open_editing(trial, by=by).exchange(one, other, first=first, last=last, why=why), json)


def erase(trial: Path, marker: str, *, frames: str, why: Why = "", by: By = "", json: Json = False) -> None:
    """Say that samples of a marker are wrong; they become a gap.

    Args:
        trial: SESSION/NAME or a file.
        marker: its name.
        frames: A-B, or one.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import closed_span, print_said

    print_said(open_editing(trial, by=by).erase(marker, *closed_span(frames), why=why), json)


def gap(trial: Path, marker: str, *, frames: str, method: str, why: Why = "", by: By = "", json: Json = False) -> None:
    """Choose how gaps of a marker are filled.

    Args:
        trial: SESSION/NAME or a file.
        marker: its name.
        frames: A-B; every gap that reaches into them is meant.
        method: one of `kinemark methods fill`; best for the least expected error; open for not at all.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import closed_span, print_said

    print_said(open_editing(trial, by=by).gap(marker, *closed_span(frames), method, why=why), json)


def put(
    trial: Path,
    marker: str,
    *,
    frame: int,
    at: tuple[float, float, float] | None = None,
    image: Annotated[list[str] | None, Parameter(negative="")] = None,
    sd: float = 1.0,
    why: Why = "",
    by: By = "",
    json: Json = False,
) -> None:
    """Put a marker at a place by hand, in space or by two images.

    Args:
        trial: SESSION/NAME or a file.
        marker: its name.
        frame: number in the recording.
        at: X Y Z in mm.
        image: where it is in an image, as cam1:312.5,204; twice or more, instead of --at.
        sd: standard deviation of each axis, mm; of images it is computed.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import image_of, print_said

    if (at is None) == (not image):
        raise KinemarkError("Say either --at X Y Z or --image CAMERA:U,V for two cameras or more.")
    editing = open_editing(trial, by=by)
    if at is not None:
        print_said(editing.put(marker, frame, at, sd_mm=sd, why=why), json)
    else:
        print_said(editing.put_in_images(marker, frame, dict(map(image_of, image or [])), why=why), json)


def image(
    trial: Path,
    camera: str,
    *,
    frame: int,
    at: tuple[float, float],
    name: str | None = None,
    no_marker: Annotated[bool, Parameter(negative="")] = False,
    why: Why = "",
    by: By = "",
    json: Json = False,
) -> None:
    """Say where a marker is in an image, or that the image there is none; its sample is worked out again.

    Args:
        trial: SESSION/NAME.
        camera: its name.
        frame: number in the recording.
        at: U V in px.
        name: of the marker.
        no_marker: the image there is no marker's.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import print_said

    if (name is None) != no_marker:
        raise KinemarkError("Say either --name NAME or --no-marker.")
    print_said(open_editing(trial, by=by).image(camera, frame, *at, name, why=why), json)


def review(
    trial: Path,
    decision: int,
    *,
    right: Annotated[bool, Parameter(negative="--wrong")] = True,
    why: Why = "",
    by: By = "",
    json: Json = False,
) -> None:
    """Give a verdict on an ambiguous decision of the tracking, which then leaves the report.

    Args:
        trial: SESSION/NAME.
        decision: its number, from 1, in ambiguous_decisions.json.
        right: it was right, or --wrong.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import print_said

    print_said(open_editing(trial, by=by).review(decision, right=right, why=why), json)


def smooth(
    trial: Path,
    marker: str,
    *,
    frames: str,
    cutoff: float,
    function: SmoothingFunction = "butterworth",
    why: Why = "",
    by: By = "",
    json: Json = False,
) -> None:
    """Low-pass filter a stretch of a marker, without lag.

    Args:
        trial: SESSION/NAME or a file.
        marker: its name.
        frames: A-B.
        cutoff: in Hz.
        function: that smooths: a Butterworth filter of fourth order, Woltring's quintic spline or the moving average.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import closed_span, print_said

    editing, span = open_editing(trial, by=by), closed_span(frames)
    print_said(editing.smooth(marker, *span, cutoff, function=function, why=why), json)


def trim(trial: Path, *, frames: str, why: Why = "", by: By = "", json: Json = False) -> None:
    """Let all markers begin and end at these frames.

    Args:
        trial: SESSION/NAME or a file.
        frames: A-B.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import closed_span, print_said

    print_said(open_editing(trial, by=by).trim(*closed_span(frames), why=why), json)


def finish(trial: Path, *, frames: Span = None, why: Why = "", by: By = "", json: Json = False) -> None:
    """Drop what has no name, and trim all markers to the frames that they have in common.

    Args:
        trial: SESSION/NAME or a file.
        frames: A-B instead of those.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import print_said, span_of

    first, last = span_of(frames)
    print_said(open_editing(trial, by=by).finish(first=first, last=last, why=why), json)


def retrack(trial: Path, *, why: Why = "", by: By = "", json: Json = False) -> None:
    """Track again with what was said until now as facts, so that a correction mends its neighbourhood.

    Claimed stretches, erased samples, places by hand and corrected images hold; the rest is tracked around them, now
    and whenever the trial is processed, until this entry is undone.

    Args:
        trial: SESSION/NAME.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import print_said

    said = open_editing(trial, by=by).track_again(why=why)
    applied = open_editing(trial, by=by).edited().applied
    print_said(said._replace(applied=tuple(one for one in applied if one.entry <= said.entry.id)), json)


def event(
    trial: Path, label: str, *, time: float, side: str = "General", why: Why = "", by: By = "", json: Json = False
) -> None:
    """Add an event.

    Args:
        trial: SESSION/NAME or a file.
        label: what, such as 'Foot Strike'.
        time: s from frame 1 of the recording.
        side: Left, Right or General.
        why: in your words.
        by: who says it.
        json: print it for a machine.
    """
    from ...engine.editing.files import open_editing
    from ..edits_output import print_said

    print_said(open_editing(trial, by=by).event(label, side, time, why=why), json)
