"""Problems of a trial, and what can be done, in a line each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...data.problems import Action, ProblemKind
from ..formatting import span_of_frames

SEVERAL = 3
"""Frames that are named one by one, at most; chosen: what a line holds."""
FAR_MM = 10_000.0
"""mm from which on a distance is none that anybody measured, as of a motion carried on over a long gap; chosen."""


def _far(mm: float) -> str:
    """A distance as a person reads it."""
    return "more than 10 m" if mm > FAR_MM else f"{mm:.0f} mm" if mm >= 1 else f"{mm:.1f} mm"


def problem_text(kind: ProblemKind, tracks: Sequence[str], first: int, last: int, mm: float) -> str:
    """What it is."""
    frames = span_of_frames(first, last)
    known = np.isfinite(mm)
    one, other = tracks[0], (tracks[1] if len(tracks) > 1 else "")
    if kind == "swap":
        return f"{one} and {other} may be exchanged from {frames} on" + (f": a jump of {_far(mm)}" if known else "")
    text = {
        "join": f"{one} and {other} may be one marker" if other else f"{one} may be two markers, before and after",
        "ghost": f"{one} may be no marker",
        "spike": f"{one} jumps away and back",
        "filled": f"{one} may be filled, not measured: it stands still or goes straight",
        "label": f"{one} may be called so by mistake",
        "sides": "left and right may be exchanged",
        "lost": "all markers go on as if frames were lost",
        "repeated": "all markers stand still as in the frame before",
        "moved": "all markers jump as one body",
        "shaken": "all markers stand off as one body",
        "gap": f"{one} has a gap",
        "edit": "an edit no longer finds its place",
    }[kind]
    return f"{text}, {frames}" + (f", {_far(mm)}" if known else "")


def untold_text(kind: ProblemKind, tracks: Sequence[str], first: int, last: int) -> str:
    """What it is where it lies in a gap so long that motion says nothing of it."""
    return f"{problem_text(kind, tracks, first, last, float('nan'))}; the gap is too long for motion to tell"


def gaps_text(markers: int, first: int, last: int, mm: float) -> str:
    """Gaps of many markers in the same frames; mm off, at most, where they are filled."""
    off = f", {_far(mm)}" if np.isfinite(mm) else ""
    return f"{markers} markers have a gap, {span_of_frames(first, last)}{off}"


def break_text(kind: ProblemKind, first: int, last: int, frames: int, mm: float, degrees: float = 0.0) -> str:
    """What happened to all markers between two frames that are right, or in those between them.

    Args:
        kind: of it. first, last: the last frame before it and the first one after.
        frames: that were lost besides those between, negative where what follows comes late. mm, degrees: of a jump.
    """
    inside = span_of_frames(first + 1, last - 1) if last > first + 1 else ""
    between, by = f"between frames {first} and {last}", f"{_far(mm)}, {degrees:.1f}°"
    late = "" if not frames else f", and {_count(frames)} were lost" if frames > 0 else f"; {_late(frames)}"
    lost = f"all markers skip {_count(abs(frames))} {between}, {_far(mm)}: the recording lost them"
    return {
        "lost": lost if frames > 0 else f"all markers go on after {inside} as if no time had passed: {_late(frames)}",
        "repeated": f"all markers repeat frame {first} in {inside}{late}",
        "moved": f"all markers jump as one body {between}, {by}: another calibration or origin",
        "shaken": f"all markers stand off as one body in {inside}, {by}: a calibration was wrong there",
    }[kind]


def breaks_text(kind: ProblemKind, first: int, last: int, places: int, frames: int) -> str:
    """The same at many places, so many frames in all; `first` and `last` as of the first of them."""
    if kind == "lost":
        between = f"first between frames {first} and {last}"
        return (
            f"all markers skip frames at {places} places, {_count(frames)} in all, {between}: the recording lost them"
        )
    inside = span_of_frames(first + 1, last - 1)
    return f"all markers repeat the frame before at {places} places, {_count(frames)} in all, first in {inside}"


def _late(frames: int) -> str:
    return f"what follows is {_count(-frames)} late"


def _count(frames: int) -> str:
    return f"{frames} frame{'s' if frames > 1 else ''}"


def _samples(n: int) -> str:
    return f"{n} sample{'s' if n != 1 else ''}"


def exchanged_text(tracks: Sequence[str], first: int, last: int) -> str:
    """Two markers that seem to jump away and back at once."""
    return f"{tracks[0]} and {tracks[1]} may be exchanged in {span_of_frames(first, last)}"


def exchange_text(tracks: Sequence[str], first: int, last: int) -> str:
    """What mends it."""
    return f"exchange {tracks[0]} and {tracks[1]} in {span_of_frames(first, last)}"


def together_text(track: str, first: int, last: int, places: int) -> str:
    """A path that jumps at several places."""
    return f"{track} jumps at {places} places, {span_of_frames(first, last)}"


def chain_text(pieces: int, first: int, last: int) -> str:
    """Loose pieces one after another."""
    return f"{pieces} pieces without a name follow one another, {span_of_frames(first, last)}: some may be one marker"


def apart_text(pieces: int) -> str:
    """They are of as many markers, or of none."""
    return f"right as they are: no two of the {pieces} are one marker"


def all_one_text(pieces: int) -> str:
    """They are of one marker."""
    return f"all {pieces} are one marker"


def mend_text(track: str, erased: int, cuts: Sequence[int]) -> str:
    """What mends them: so many samples erased, and cut at these frames."""
    parts = [f"erase {_samples(erased)}"] if erased else []
    places = (
        f"{len(cuts)} places" if len(cuts) > SEVERAL else f"frame{'s' * (len(cuts) > 1)} {', '.join(map(str, cuts))}"
    )
    parts += [f"cut {track} at {places}"] if cuts else []
    return " and ".join(parts)


def action_text(action: Action, tracks: Sequence[str], frame: int, mm: float, name: str = "") -> str:
    """What an alternative does; `name` is what it calls something, or the method of filling."""
    one, other = tracks[0], (tracks[1] if len(tracks) > 1 else "")
    off = f" ({_far(mm)} off)" if np.isfinite(mm) else ""
    jump = off and f" (a jump of {_far(mm)})"
    return {
        "keep": f"right as it is{jump}",
        "exchange": f"exchange {one} and {other} from frame {frame} on{jump}",
        "cut": f"cut {one} at frame {frame}: two markers",
        "join": f"{one} and {other} are one marker{jump}",
        "no_marker": f"{one} is no marker",
        "erase": f"erase these samples{jump}",
        "rename": f"it is {name}",
        "fill": f"fill by {name}{off}",
        "leave_open": "leave it open",
        "drop_edit": "drop the edit",
        "wait": "keep it, and wait",
        "note": f"it is so; {name}",
    }[action]
