"""What is said of a trial: names, erased samples, gaps, places, verdicts, trims; commands of `kinemark edits`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ...data import KinemarkError
from ...data.edits import SmoothingFunction
from ..edits_output import closed_span, image_of, print_said, span_of
from ..output import Json

if TYPE_CHECKING:  # it takes long to import, and --help does without
    from ...engine.editing.editing import Editing

Edited = Annotated[Path, Parameter(help="SESSION/NAME or a file.")]
OfSession = Annotated[Path, Parameter(help="SESSION/NAME.")]
Why = Annotated[str, Parameter(help="Why, in your words; kept in the journal.")]
By = Annotated[str, Parameter(help="Who says it; the user of the machine where not given.")]
Span = Annotated[
    str | None,
    Parameter(help="Frames A-B, numbers in the recording; A- or -B follows the path to its end; all where not given."),
]
Flag = Annotated[bool, Parameter(negative="")]


@Parameter(name="*")
@dataclass(frozen=True, slots=True)
class Saying:
    """Why something is said and by whom, and how what came of it is printed."""

    why: Why = ""
    by: By = ""
    json: Json = False

    def of(self, trial: Path) -> Editing:
        """The trial, edited in the name of whoever says it."""
        from ...engine.editing.files import open_editing

        return open_editing(trial, by=self.by)


NOTHING = Saying()


def claim(
    trial: Edited, *, track: str, name: str | None = None, no_marker: Flag = False, frames: Span = None,
    anyway: Flag = False, saying: Saying = NOTHING,
) -> None:  # fmt: skip
    """Say which marker a trajectory is, or that it is none.

    Where another trajectory has the name already, it is first looked whether the two can be one marker.

    Args:
        track: the trajectory, as it is called now: '*12', or a name.
        name: of the marker.
        no_marker: it is none: a ghost.
        anyway: join two that do not seem to be one marker.
    """
    _check_named(name, no_marker)
    editing = saying.of(trial)
    first, last = span_of(frames)
    joined = None if name is None or frames is not None else editing.connection(track, name)
    if joined is not None and not joined.connectable and not anyway:
        where = f"overlap in {joined.overlap} frames" if joined.overlap else f"are {joined.gap} frames apart"
        raise KinemarkError(
            f"{track} does not go on {name}: they {where}, and are {joined.off_mm:.1f} mm off, "
            f"{joined.deviations:.1f} standard deviations. Join them with --anyway, or name frames with --frames."
        )
    print_said(editing.claim(track, name, first=first, last=last, why=saying.why), saying.json)


def _check_named(name: str | None, no_marker: bool) -> None:
    """Raises KinemarkError where neither is said, or both."""
    if (name is None) != no_marker:
        raise KinemarkError("Say either --name NAME or --no-marker.")


def exchange(trial: Edited, one: str, other: str, *, frames: Span = None, saying: Saying = NOTHING) -> None:
    """Give two trajectories each other's names.

    Args:
        one: a marker.
        other: the marker that it was taken for.
    """
    first, last = span_of(frames)
    print_said(saying.of(trial).exchange(one, other, first=first, last=last, why=saying.why), saying.json)


def erase(trial: Edited, marker: str, *, frames: str, saying: Saying = NOTHING) -> None:
    """Say that samples of a marker are wrong; they become a gap.

    Args:
        marker: its name.
        frames: A-B, or one.
    """
    print_said(saying.of(trial).erase(marker, *closed_span(frames), why=saying.why), saying.json)


def gap(trial: Edited, marker: str, *, frames: str, method: str, saying: Saying = NOTHING) -> None:
    """Choose how gaps of a marker are filled.

    Args:
        marker: its name.
        frames: A-B; every gap that reaches into them is meant.
        method: one of `kinemark methods fill`; best for the least expected error; open for not at all.
    """
    print_said(saying.of(trial).gap(marker, *closed_span(frames), method, why=saying.why), saying.json)


def put(
    trial: Edited, marker: str, *, frame: int, at: tuple[float, float, float] | None = None,
    image: Annotated[list[str] | None, Parameter(negative="")] = None, sd: float = 1.0, saying: Saying = NOTHING,
) -> None:  # fmt: skip
    """Put a marker at a place by hand, in space or by two images.

    Args:
        marker: its name.
        frame: number in the recording.
        at: X Y Z in mm.
        image: where it is in an image, as cam1:312.5,204; twice or more, instead of --at.
        sd: standard deviation of each axis, mm; of images it is computed.
    """
    if (at is None) == (not image):
        raise KinemarkError("Say either --at X Y Z or --image CAMERA:U,V for two cameras or more.")
    editing = saying.of(trial)
    if at is not None:
        print_said(editing.put(marker, frame, at, sd_mm=sd, why=saying.why), saying.json)
    else:
        places = dict(map(image_of, image or []))
        print_said(editing.put_in_images(marker, frame, places, why=saying.why), saying.json)


def image(
    trial: OfSession, camera: str, *, frame: int, at: tuple[float, float], name: str | None = None,
    no_marker: Flag = False, saying: Saying = NOTHING,
) -> None:  # fmt: skip
    """Say where a marker is in an image, or that the image there is none; its sample is worked out again.

    Args:
        camera: its name.
        frame: number in the recording.
        at: U V in px.
        name: of the marker.
        no_marker: the image there is no marker's.
    """
    _check_named(name, no_marker)
    print_said(saying.of(trial).image(camera, frame, *at, name, why=saying.why), saying.json)


def review(
    trial: OfSession, decision: int, *, right: Annotated[bool, Parameter(negative="--wrong")] = True,
    saying: Saying = NOTHING,
) -> None:  # fmt: skip
    """Give a verdict on an ambiguous decision of the tracking, which then leaves the report.

    Args:
        decision: its number, from 1, in ambiguous_decisions.json.
        right: it was right, or --wrong.
    """
    print_said(saying.of(trial).review(decision, right=right, why=saying.why), saying.json)


def smooth(
    trial: Edited, marker: str, *, frames: str, cutoff: float, function: SmoothingFunction = "butterworth",
    saying: Saying = NOTHING,
) -> None:  # fmt: skip
    """Low-pass filter a stretch of a marker, without lag.

    Args:
        marker: its name.
        frames: A-B.
        cutoff: in Hz.
        function: that smooths: a Butterworth filter of fourth order, Woltring's quintic spline or the moving average.
    """
    editing, span = saying.of(trial), closed_span(frames)
    print_said(editing.smooth(marker, *span, cutoff, function=function, why=saying.why), saying.json)


def trim(trial: Edited, *, frames: str, saying: Saying = NOTHING) -> None:
    """Let all markers begin and end at these frames.

    Args:
        frames: A-B.
    """
    print_said(saying.of(trial).trim(*closed_span(frames), why=saying.why), saying.json)


def finish(trial: Edited, *, frames: Span = None, saying: Saying = NOTHING) -> None:
    """Drop what has no name, and trim all markers to the frames that they have in common."""
    first, last = span_of(frames)
    print_said(saying.of(trial).finish(first=first, last=last, why=saying.why), saying.json)


def retrack(trial: OfSession, *, saying: Saying = NOTHING) -> None:
    """Track again with what was said until now as facts, so that a correction mends its neighbourhood.

    Claimed stretches, erased samples, places by hand and corrected images hold; the rest is tracked around them, now
    and whenever the trial is processed, until this entry is undone.
    """
    said = saying.of(trial).track_again(why=saying.why)
    applied = saying.of(trial).edited().applied
    print_said(said._replace(applied=tuple(one for one in applied if one.entry <= said.entry.id)), saying.json)


def event(trial: Edited, label: str, *, time: float, side: str = "General", saying: Saying = NOTHING) -> None:
    """Add an event.

    Args:
        label: what, such as 'Foot Strike'.
        time: s from frame 1 of the recording.
        side: Left, Right or General.
    """
    print_said(saying.of(trial).event(label, side, time, why=saying.why), saying.json)
