"""Drawing of the figures of `missing_markers`: x, y and z of one marker through time, as SVG on a page."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinemark.data.array_types import Floats
from kinemark.numerics.runs import true_runs

WIDTH, HEIGHT, LEFT, TOP, DEEP = 460, 240, 52, 24, 190


class Curve(NamedTuple):
    """A path (F, 3) mm with its name and colour."""

    name: str
    colour: str
    path: Floats


class Figure(NamedTuple):
    """One figure: number in the thesis, what it shows, the true path (F, 3) mm, where it was hidden (F), curves, and
    the band's lower and upper edge (F, 3) mm."""

    number: str
    words: str
    truth: Floats
    hidden: NDArray[np.bool_]
    curves: list[Curve]
    band: tuple[Floats, Floats]


LEGEND = """<h1>Missing markers, after Swamidas (1997)</h1>
<p>Black: where the marker was, thick where it was hidden (grey ground). Pale band: region of acceptance (4.14 to 4.18),
or ±2 standard deviations of <i>limbs</i> (4.19 to 4.21). The motions are rebuilt, so the curves have the character of
the thesis' and not their shape.</p>"""


def page(figures: list[Figure]) -> str:
    """All figures as HTML."""
    head = '<!doctype html><html lang="en"><meta charset="utf-8"><title>Missing markers, after Swamidas (1997)</title>'
    style = "<style>body{font:14px sans-serif;margin:24px;max-width:1420px}svg{vertical-align:top}</style>"
    return "\n".join([head + style, LEGEND, *(_figure(figure) for figure in figures), "</html>", ""])


def _figure(figure: Figure) -> str:
    names = ", ".join(f'<span style="color:{curve.colour}">{curve.name}</span>' for curve in figure.curves)
    panels = "".join(_panel(figure, axis) for axis in range(3))
    return f"<h2>Like figure {figure.number}</h2><p>{figure.words}. {names}.</p>{panels}"


class _Frame(NamedTuple):
    """Scales of a panel: x (F) px of frames; lengths from low to high mm."""

    x: Floats
    low: float
    high: float

    def y(self, values: Floats) -> Floats:
        """Px, kept within the panel."""
        return TOP + (self.high - np.clip(values, self.low, self.high)) * DEEP / (self.high - self.low)


def _frame(figure: Figure, axis: int) -> _Frame:
    shown = [figure.truth[:, axis], *(curve.path[figure.hidden, axis] for curve in figure.curves)]
    values = np.concatenate(shown)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    margin = 0.06 * (high - low) + 1
    n = len(figure.truth)
    return _Frame(LEFT + (WIDTH - LEFT - 8) * np.arange(n) / (n - 1), low - margin, high + margin)


def _panel(figure: Figure, axis: int) -> str:
    frame = _frame(figure, axis)
    size = f'width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}"'
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="11">']
    parts += [*_ground(figure, frame, axis), polyline(frame.x, frame.y(figure.truth[:, axis]), "#000", 1.0)]
    for first, last in _runs(figure.hidden):
        x = frame.x[first:last]
        parts.append(polyline(x, frame.y(figure.truth[first:last, axis]), "#000", 2.4))
        for curve in figure.curves:
            own = curve.path[first:last, axis]
            if np.isfinite(own).all():
                parts.append(polyline(x, frame.y(own), curve.colour, 1.5))
    return "".join([*parts, *_words(frame, axis), "</svg>"])


def _ground(figure: Figure, frame: _Frame, axis: int) -> list[str]:
    """Where the marker was hidden, and the band."""
    parts = []
    for first, last in _runs(figure.hidden):
        wide = f'{frame.x[last - 1] - frame.x[first]:.1f}" height="{DEEP}'
        parts.append(f'<rect x="{frame.x[first]:.1f}" y="{TOP}" width="{wide}" fill="#eef0f2"/>')
    lower, upper = (edge[:, axis] for edge in figure.band)
    for first, last in _runs(figure.hidden & np.isfinite(lower)):
        x = frame.x[first:last]
        edge = [*zip(x, frame.y(lower[first:last]), strict=True)]
        edge += [*zip(x, frame.y(upper[first:last]), strict=True)][::-1]
        parts.append(f'<polygon points="{_points(edge)}" fill="#56B4E9" opacity="0.35"/>')
    return parts


def _words(frame: _Frame, axis: int) -> list[str]:
    parts = [f'<text x="{LEFT}" y="14">{"xyz"[axis]}, mm, against frames</text>']
    for value in frame.low + np.array([0.05, 0.5, 0.95]) * (frame.high - frame.low):
        at = float(frame.y(np.array(value))) + 4
        parts.append(f'<text x="{LEFT - 6}" y="{at:.1f}" text-anchor="end">{value:.0f}</text>')
    for k in range(0, len(frame.x), 50):
        parts.append(f'<text x="{frame.x[k]:.1f}" y="{HEIGHT - 10}" text-anchor="middle">{k}</text>')
    return parts


def _runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    return [(int(a), int(b)) for a, b in true_runs(mask) if b - a > 1]


def _points(pairs: list[tuple[float, float]]) -> str:
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in pairs)


def polyline(x: Floats, y: Floats, colour: str, width: float) -> str:
    """Through points x, y (F) px."""
    pairs = _points([*zip(x, y, strict=True)])
    return f'<polyline points="{pairs}" fill="none" stroke="{colour}" stroke-width="{width}"/>'
