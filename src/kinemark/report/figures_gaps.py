"""Each gap as a small drawing: the marker on both sides, what was put in between, how sure it is, and its neighbours.

There may be hundreds of gaps in a trial, so these are plain SVG, a few kilobytes each, which need no script.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from ..data import MarkerTrajectory, Origin, Trajectories
from ..data.array_types import Floats
from ..numerics.runs import true_runs
from .formatting import number
from .templating import render
from .theme import STATES

WIDTH, HEIGHT, LEFT, TOP, BOTTOM, APART = 360, 110, 46, 6, 16, 8
"""px; of a panel, of its margins, and between panels; chosen."""
CONTEXT = 1.0
"""Of the gap's length shown on either side, and at least CONTEXT_S; chosen."""
CONTEXT_S = 0.25  # s shown on either side at least; chosen
MOST = 80
"""Points of a line; chosen (see benchmarks/pages.py)."""
NINETY_FIVE = 1.96  # standard deviations on each side that hold 95 %; the normal distribution's, by definition
NEIGHBOUR = "#9AA5B1"
SHOWN_MM = 1000.0
"""From the curve; a replaced sample farther off is outside the panel, so that the curve can still be seen; chosen."""


class Line(NamedTuple):
    """An SVG path with its colour and width, px."""

    d: str
    colour: str
    width: float


class Label(NamedTuple):
    """Text at a place, px, and which end of it is there."""

    x: float
    y: float
    text: str
    anchor: str
    colour: str = "var(--faint)"  # of the page


class Panel(NamedTuple):
    """One axis: the gap's first and last place, px, lines, bands (polygons), dots and labels."""

    first: float
    last: float
    lines: list[Line]
    bands: list[str]
    dots: list[tuple[float, float]]
    labels: list[Label]


def gap_figure(
    trajectories: Trajectories,
    marker: str,
    start: int,
    stop: int,
    references: tuple[str, ...] = (),
    replaced: Mapping[int, Floats] | None = None,
) -> Markup:
    """Three panels, x, y and z against time, as one SVG.

    Args:
        trajectories: the trial after filling.
        marker: its name; start, stop: its missing frames, stop excluded.
        references: markers drawn beside it in grey, moved to where the marker is at the edges of the gap; those that
            the trial no longer has, as nameless tracks that were dropped after filling, are left out.
        replaced: what was measured (3) in or beside the gap and is replaced or suspicious, drawn as dots.
    """
    path, rate = trajectories[marker], trajectories.rate
    margin = round(max(CONTEXT * (stop - start), CONTEXT_S * rate, 2))
    frames = np.arange(max(start - margin, 0), min(stop + margin, len(path)))
    frames = np.unique(
        np.concatenate([frames[:: max(1, len(frames) // MOST)], np.clip([start - 1, stop], 0, frames[-1])])
    )
    near = [trajectories[name].xyz[frames] for name in references if name != marker and name in trajectories.names]
    panels = [_panel(path, frames, axis, near, (start, stop), rate, replaced or {}) for axis in range(3)]
    sizes = {"width": WIDTH, "height": HEIGHT, "left": LEFT, "top": TOP, "bottom": HEIGHT - BOTTOM, "apart": APART}
    return render("gap.html", panels=panels, whole=3 * WIDTH + 2 * APART, filled=STATES["filled"], **sizes)


def _panel(
    path: MarkerTrajectory,
    frames: NDArray[np.int64],
    axis: int,
    near: list[Floats],
    gap: tuple[int, int],
    rate: float,
    replaced: Mapping[int, Floats],
) -> Panel:
    """One axis."""
    value, sd = path.xyz[frames, axis], np.sqrt(path.cov[frames, axis, axis])
    filled = path.origin[frames] == Origin.FILLED
    band = np.where(filled, NINETY_FIVE * np.nan_to_num(sd), 0.0)
    median = np.nanmedian(value) if np.isfinite(value).any() else 0.0
    dots = [xyz[axis] for xyz in replaced.values() if abs(xyz[axis] - median) < SHOWN_MM]
    low, high = _span(np.concatenate([value - band, value + band, dots]))
    x = LEFT + (WIDTH - LEFT) * (frames - frames[0]) / max(frames[-1] - frames[0], 1)

    def y(v: Floats) -> Floats:
        return np.clip(TOP + (HEIGHT - TOP - BOTTOM) * (high - v) / (high - low), -HEIGHT, 2 * HEIGHT)

    lines = [
        *(_line(x, y(other[:, axis] - _offset(other[:, axis], value)), NEIGHBOUR, 0.7) for other in near),
        _line(x, y(np.where(filled, np.nan, value)), STATES["measured"], 1.6),
        _line(x, y(np.where(_widened(filled), value, np.nan)), STATES["filled"], 1.8),
    ]
    bands = [_band(x[run], y(value + band)[run], y(value - band)[run]) for run in _runs(filled, np.isfinite(value))]
    return Panel(
        float(np.interp(gap[0] - 0.5, frames, x)),
        float(np.interp(gap[1] - 0.5, frames, x)),
        [line for line in lines if line.d],
        [points for points in bands if points],
        [(float(np.interp(frame, frames, x)), float(y(xyz[axis]))) for frame, xyz in replaced.items()],
        [
            Label(LEFT - 4, TOP + 8, number(high, 0), "end"),
            Label(LEFT - 4, HEIGHT - BOTTOM, number(low, 0), "end"),
            Label(LEFT - 4, (HEIGHT - BOTTOM + TOP) / 2 + 4, f"{'xyz'[axis]} mm", "end", "var(--ink)"),
            Label(LEFT, HEIGHT - 4, f"{frames[0] / rate:.2f} s", "start"),
            Label(WIDTH, HEIGHT - 4, f"{frames[-1] / rate:.2f} s", "end"),
        ],
    )


def _span(values: Floats) -> tuple[float, float]:
    """Least and greatest, not nearer to each other than 2 mm."""
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 0.0)
    return (low, high) if high - low > 2 else ((low + high) / 2 - 1, (low + high) / 2 + 1)


def _offset(other: Floats, value: Floats) -> float:
    """How far another marker's line is moved to lie where the marker is."""
    both = np.isfinite(other) & np.isfinite(value)
    return float(np.median((other - value)[both])) if both.any() else 0.0


def _runs(mask: NDArray[np.bool_], known: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """Each run of the mask, with one more on either side where it is known: there the band begins and ends."""
    runs = [np.arange(max(a - 1, 0), min(b + 1, len(mask))) for a, b in true_runs(mask)]
    return [run[known[run]] for run in runs]


def _widened(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """With one more on either side, so that the line reaches what was measured."""
    out = mask.copy()
    out[1:] |= mask[:-1]
    out[:-1] |= mask[1:]
    return out


def _line(x: Floats, y: Floats, colour: str, width: float) -> Line:
    """A line that is broken where it is not known."""
    known = np.isfinite(y)
    steps = np.where(np.concatenate([[True], ~known[:-1]]), "M", "L")
    d = "".join(f"{s}{a:.1f} {b:.1f}" for s, a, b in zip(steps[known], x[known], y[known], strict=True))
    return Line(d, colour, width)


def _band(x: Floats, upper: Floats, lower: Floats) -> str:
    """The corners of the area between two lines; none of a single place."""
    if len(x) < 2:
        return ""
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip([*x, *x[::-1]], [*upper, *lower[::-1]], strict=True))
