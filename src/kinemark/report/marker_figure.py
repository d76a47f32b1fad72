"""A marker set as a picture: one who stands, from the front and from the back, with the markers at their places.

Seen from the front the subject's left is on the right of the picture, as in a room. Coordinates of the drawing are
shares of the body's height times `SCALE`, y downwards.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import NamedTuple

from ..data import KinemarkError, MarkerSet
from .theme import FAINT, GRID, HUES, INK, PAPER, shortened

SCALE = 640.0
"""Of the body's height, in units of the drawing; chosen for a screen."""
WIDTH, TOP, FOOT = 440.0, 64.0, 60.0
"""Of a view, and room above and below the figure, in the same units; chosen."""
LINE, RADIUS, LETTERS = 15.0, 4.5, 12
"""Least distance of two labels, size of a marker, of a letter; chosen."""
LEADER = "#B4BDC6"
"""Colour of the lines from names to markers: on the body as well as beside it."""
SIDE = {"left": HUES[0], "right": HUES[1], "middle": INK}
LIMBS = (
    (0.085, ((0.05, 0.5), (0.07, 0.29), (0.085, 0.05))),
    (0.05, ((0.07, 0.29), (0.085, 0.045), (0.098, 0.022))),
    (0.052, ((0.112, 0.79), (0.15, 0.635))),
    (0.042, ((0.15, 0.635), (0.187, 0.49), (0.203, 0.44))),
    (0.06, ((0.0, 0.8), (0.0, 0.9))),
)
"""Width, and places to the left and up, of limbs of the drawn body, in shares of its height; chosen."""
TRUNK = ((0.125, 0.812), (0.1, 0.64), (0.105, 0.5), (0.0, 0.47))
"""Outline of its left half; chosen."""
HEAD = (0.93, 0.052, 0.068)
"""Its middle and half axes; chosen."""


class Spot(NamedTuple):
    """A marker in a view: name, place in units of the drawing, and the side of the body that it is on."""

    name: str
    x: float
    y: float
    side: str


def marker_set_svg(of: MarkerSet) -> str:
    """The picture as SVG, front view and back view side by side.

    Raises:
        KinemarkError: the set says no places.
    """
    if not any(name in of.places for name in of.names):
        raise KinemarkError(f"The marker set {of.name} says no places. Give its markers `place = [forward, left, up]`.")
    height = TOP + SCALE + FOOT
    views = [_view(of, view, k * WIDTH) for k, view in enumerate(("front", "back"))]
    title = escape(f"{of.name}: {len(of)} markers" if of.name else f"{len(of)} markers")
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {2 * WIDTH:g} {height:g}" role="img" '
            f'font-family="system-ui, sans-serif" font-size="{LETTERS}">',
            f"<title>{title}</title>",
            f'<rect width="100%" height="100%" fill="{PAPER}"/>',
            f'<text x="{WIDTH:g}" y="22" text-anchor="middle" font-size="16" fill="{INK}">{title}</text>',
            *views,
            _legend(of, height - 16),
            "</svg>\n",
        ]
    )


def _view(of: MarkerSet, view: str, x0: float) -> str:
    """One of the two views, from x0 on."""
    sign = 1.0 if view == "front" else -1.0
    spots = _spots(of, view, sign)
    places = {spot.name: spot for spot in spots}
    lines = [(places[a], places[b]) for a, b in _links(of) if a in places and b in places]
    left, right = ("right", "left") if view == "front" else ("left", "right")
    half = WIDTH / 2 - 8
    sides = (
        ""
        if not of.pairs
        else (
            f'<text x="{-half:g}" y="46" fill="{SIDE[left]}">{left}</text>'
            f'<text x="{half:g}" y="46" text-anchor="end" fill="{SIDE[right]}">{right}</text>'
        )
    )
    return "\n".join(
        [
            f'<g transform="translate({x0 + WIDTH / 2:g} 0)">',
            f'<text y="46" text-anchor="middle" fill="{FAINT}">{view}</text>{sides}',
            _body() if _is_body(of) else "",
            *(_line(a.x, a.y, b.x, b.y, FAINT, 1.2) for a, b in lines),
            *_labels(of, [spot for spot in spots if spot.x < 0], -1.0),
            *_labels(of, [spot for spot in spots if spot.x >= 0], 1.0),
            *(_dot(of, spot) for spot in spots),
            "</g>",
        ]
    )


def _spots(of: MarkerSet, view: str, sign: float) -> list[Spot]:
    """The markers that are seen in a view, from the top down; what is no standing body fills the picture."""
    low, high = (0.0, 1.0) if _is_body(of) else _range(of.places[name][2] for name in of.names if name in of.places)
    out = []
    for name in of.names:
        if name in of.places and of.faces.get(name, "both") in (view, "both"):
            _, left, up = of.places[name]
            side = next((side for side, k in (("left", 0), ("right", 1)) if name in (p[k] for p in of.pairs)), "middle")
            y = TOP + SCALE * (1 - (up - low) / (high - low))
            wide = 1.0 if _is_body(of) else min(1.0, 0.25 * WIDTH / SCALE / max(_widest(of), 1e-9))
            out.append(Spot(name, sign * left * SCALE * wide, y, side))
    return sorted(out, key=lambda spot: spot.y)


def _is_body(of: MarkerSet) -> bool:
    """Whether the places are those of one who stands as the drawn body does: joints have places there too."""
    return any(joint in of.places for joint in of.joints)


def _range(values: Iterable[float]) -> tuple[float, float]:
    every = list(values)
    return min(every), max(max(every), min(every) + 1e-6)


def _widest(of: MarkerSet) -> float:
    return max(abs(of.places[name][1]) for name in of.names if name in of.places)


def _links(of: MarkerSet) -> list[tuple[str, str]]:
    return [(of.names[a], of.names[b]) for a, b in of.links.tolist()]


def _labels(of: MarkerSet, spots: list[Spot], sign: float) -> list[str]:
    """Names in a column beside the figure, each with a line to its marker; none upon another."""
    x = sign * (WIDTH / 2 - 76)
    shown = dict(zip(of.names, shortened(of.names, 12), strict=True))
    anchor = "end" if sign < 0 else "start"
    out = []
    for spot, y in zip(spots, _apart([spot.y for spot in spots]), strict=True):
        out.append(_line(spot.x, spot.y, x - sign * 3, y, LEADER, 1))
        out.append(
            f'<text x="{x:.1f}" y="{y + 4:.1f}" text-anchor="{anchor}" fill="{SIDE[spot.side]}">'
            f"{escape(shown[spot.name])}<title>{escape(of.meaning.get(spot.name, spot.name))}</title></text>"
        )
    return out


def _apart(wanted: list[float]) -> list[float]:
    """Heights in this order, at least `LINE` apart, near those that are wanted and within the figure."""
    out: list[float] = []
    for y in wanted:
        out.append(max(y, out[-1] + LINE) if out else y)
    lowest = TOP + SCALE + 8
    for k in range(len(out) - 1, -1, -1):
        out[k] = min(out[k], lowest - LINE * (len(out) - 1 - k))
    return out


def _dot(of: MarkerSet, spot: Spot) -> str:
    """Filled; hollow where the marker is not always worn."""
    worn = "" if spot.name not in (*of.optional, *of.static_only) else f' fill="{PAPER}"'
    fill = worn or f' fill="{SIDE[spot.side]}"'
    title = escape(f"{spot.name}: {of.meaning[spot.name]}" if spot.name in of.meaning else spot.name)
    return (
        f'<circle cx="{spot.x:.1f}" cy="{spot.y:.1f}" r="{RADIUS}" stroke="{SIDE[spot.side]}" stroke-width="1.5"{fill}>'
        f"<title>{title}</title></circle>"
    )


def _line(x1: float, y1: float, x2: float, y2: float, colour: str, width: float) -> str:
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" stroke-width="{width:g}"/>'


def _legend(of: MarkerSet, y: float) -> str:
    """What hollow markers are, where there are any."""
    kinds = [("optional", of.optional), ("static trial only", of.static_only)]
    said = "; ".join(f"{', '.join(names)}: {kind}" for kind, names in kinds if names)
    text = f"hollow: {said}" if said else ""
    return f'<text x="{WIDTH:g}" y="{y:g}" text-anchor="middle" fill="{FAINT}">{escape(text)}</text>'


def _body() -> str:
    """One who stands with the arms a little away, in grey."""
    limbs = [
        f'<polyline points="{_points((s * x, up) for x, up in line)}" fill="none" stroke-width="{width * SCALE:.0f}"/>'
        for width, line in LIMBS
        for s in (1.0, -1.0)
    ]
    outline = [*TRUNK, *((-x, up) for x, up in reversed(TRUNK))]
    middle, across, along = HEAD
    return "\n".join(
        [
            f'<g fill="{GRID}" stroke="{GRID}" stroke-linecap="round" stroke-linejoin="round">',
            *limbs,
            f'<polygon points="{_points(outline)}" stroke-width="{0.03 * SCALE:.0f}"/>',
            f'<ellipse cy="{TOP + SCALE * (1 - middle):.1f}" rx="{across * SCALE:.1f}" ry="{along * SCALE:.1f}"/>',
            "</g>",
        ]
    )


def _points(places: Iterable[tuple[float, float]]) -> str:
    return " ".join(f"{x * SCALE:.1f},{TOP + SCALE * (1 - up):.1f}" for x, up in places)


def marker_set_html(of: MarkerSet) -> str:
    """The picture and its tables as a page of its own."""
    rows = [(name, of.meaning.get(name, ""), _worn(of, name)) for name in of.names]
    segments = [(name, ", ".join(ms), _share(of.rigidity, name)) for name, ms in of.segments.items()]
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(of.name or "marker set")}</title>'
        f"<style>body{{font:15px system-ui,sans-serif;color:{INK};background:{PAPER};max-width:60rem;margin:2rem auto;"
        f"padding:0 1rem}}svg{{width:100%;height:auto}}td,th{{text-align:left;padding:.2rem 1rem .2rem 0;"
        f"border-bottom:1px solid {GRID}}}</style></head><body><h1>{escape(of.name or 'marker set')}</h1>"
        f"<p>{escape(of.description)}</p>{marker_set_svg(of)}"
        f"{_html_table(('marker', 'place', 'worn'), rows)}{_html_table(('segment', 'markers', 'spread'), segments)}"
        f"<p>{escape(of.source)}</p></body></html>\n"
    )


def _worn(of: MarkerSet, name: str) -> str:
    return "optional" if name in of.optional else "static trial only" if name in of.static_only else "always"


def _share(rigidity: Mapping[str, float], name: str) -> str:
    return f"{100 * rigidity[name]:.1f} %" if name in rigidity else ""


def _html_table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    lines = [f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows]
    return f"<h2>{head[0]}s</h2><table><tr>{''.join(f'<th>{h}</th>' for h in head)}</tr>{''.join(lines)}</table>"
