"""Each gap as a small drawing: the marker on both sides, what was put in between, how sure it is, and its neighbours.

There may be hundreds of gaps in a trial, so these are plain SVG, a few kilobytes each, which need no script.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..data import MarkerTrajectory, Origin, Trajectories
from ..data.array_types import Floats
from ..numerics.runs import true_runs
from .formatting import number
from .theme import FAINT, GRID, INK, STATES

WIDTH, HEIGHT, LEFT, TOP, BOTTOM = 360, 110, 46, 6, 16
"""px; of a panel, and of its margins; chosen."""
CONTEXT = 1.0
"""Of the gap's length shown on either side, and at least CONTEXT_S; chosen."""
CONTEXT_S = 0.25  # s shown on either side at least; chosen
MOST = 160
"""Points of a line; chosen."""
NINETY_FIVE = 1.96  # standard deviations on each side that hold 95 %; the normal distribution's, by definition
NEIGHBOUR = "#9AA5B1"
SHOWN_MM = 1000.0
"""From the curve; a replaced sample farther off is outside the panel, so that the curve can still be seen; chosen."""


def gap_figure(
    trajectories: Trajectories,
    marker: str,
    start: int,
    stop: int,
    references: tuple[str, ...] = (),
    replaced: Mapping[int, Floats] | None = None,
) -> str:
    """Three panels, x, y and z against time, as one SVG.

    Args:
        trajectories: the trial after filling.
        marker: its name; start, stop: its missing frames, stop excluded.
        references: markers drawn beside it in grey, moved to where the marker is at the edges of the gap.
        replaced: what was measured (3) in frames of the gap and is not trusted, drawn as dots.
    """
    path, rate = trajectories[marker], trajectories.rate
    margin = round(max(CONTEXT * (stop - start), CONTEXT_S * rate, 2))
    frames = np.arange(max(start - margin, 0), min(stop + margin, len(path)))
    frames = np.unique(
        np.concatenate([frames[:: max(1, len(frames) // MOST)], np.clip([start - 1, stop], 0, frames[-1])])
    )
    near = [trajectories[name].xyz[frames] for name in references if name != marker]
    panels = [_panel(path, frames, axis, near, (start, stop), rate, replaced or {}) for axis in range(3)]
    body = "".join(f'<g transform="translate({i * (WIDTH + 8)},0)">{panel}</g>' for i, panel in enumerate(panels))
    width = 3 * WIDTH + 16
    return (
        f'<svg viewBox="0 0 {width} {HEIGHT}" width="100%" role="img" font-size="10" fill="none" '
        f'font-family="system-ui, sans-serif">{body}</svg>'
    )


def _panel(
    path: MarkerTrajectory,
    frames: NDArray[np.int64],
    axis: int,
    near: list[Floats],
    gap: tuple[int, int],
    rate: float,
    replaced: Mapping[int, Floats],
) -> str:
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

    def dot(frame: int, xyz: Floats) -> str:
        at = np.interp(frame, frames, x)
        return f'<circle cx="{at:.1f}" cy="{float(y(xyz[axis])):.1f}" r="1.8" fill="{INK}" fill-opacity="0.6"/>'

    first, last = np.interp([gap[0] - 0.5, gap[1] - 0.5], frames, x)
    parts = [
        f'<path d="M{first:.1f} {TOP}V{HEIGHT - BOTTOM}H{last:.1f}V{TOP}Z" fill="#F5F7F8"/>',
        f'<path d="M{LEFT} {TOP}V{HEIGHT - BOTTOM}H{WIDTH}" stroke="{GRID}"/>',
        *(_line(x, y(other[:, axis] - _offset(other[:, axis], value)), NEIGHBOUR, 0.7) for other in near),
        *(_band(x[run], y(value + band)[run], y(value - band)[run]) for run in _runs(filled, np.isfinite(value))),
        _line(x, y(np.where(filled, np.nan, value)), STATES["measured"], 1.6),
        _line(x, y(np.where(_widened(filled), value, np.nan)), STATES["filled"], 1.8),
        *(dot(frame, xyz) for frame, xyz in replaced.items()),
        _text(LEFT - 4, TOP + 8, number(high, 0), "end"),
        _text(LEFT - 4, HEIGHT - BOTTOM, number(low, 0), "end"),
        _text(LEFT - 4, (HEIGHT - BOTTOM + TOP) / 2 + 4, f"{'xyz'[axis]} mm", "end", INK),
        _text(LEFT, HEIGHT - 4, f"{frames[0] / rate:.2f} s", "start"),
        _text(WIDTH, HEIGHT - 4, f"{frames[-1] / rate:.2f} s", "end"),
    ]
    return "".join(parts)


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


def _line(x: Floats, y: Floats, colour: str, width: float) -> str:
    """A line that is broken where it is not known."""
    known = np.isfinite(y)
    steps = np.where(np.concatenate([[True], ~known[:-1]]), "M", "L")
    d = "".join(f"{s}{a:.1f} {b:.1f}" for s, a, b in zip(steps[known], x[known], y[known], strict=True))
    return f'<path d="{d}" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"/>' if d else ""


def _band(x: Floats, upper: Floats, lower: Floats) -> str:
    """The area between two lines."""
    if len(x) < 2:
        return ""
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip([*x, *x[::-1]], [*upper, *lower[::-1]], strict=True))
    return f'<polygon points="{points}" fill="{STATES["filled"]}" fill-opacity="0.25"/>'


def _text(x: float, y: float, text: str, anchor: str, colour: str = FAINT) -> str:
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}" fill="{colour}">{text}</text>'
