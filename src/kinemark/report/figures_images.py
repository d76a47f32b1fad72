"""The image of every camera: where calibration points were, how they miss, and how sure the camera is of the rest."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..calibrate.quality import Evidence
from ..data.array_types import Floats
from .drawing import Figure
from .panels import image_axes, panel, panels
from .theme import FAINT, HUES, empty, even_scale, labels

BLUES = even_scale(
    *("rgb(247,251,255)", "rgb(222,235,247)", "rgb(198,219,239)", "rgb(158,202,225)", "rgb(107,174,214)"),
    *("rgb(66,146,198)", "rgb(33,113,181)", "rgb(8,81,156)", "rgb(8,48,107)"),
)
"""Of Brewer; the same on dark pages, as these are not written as the hues are that the page recolours."""
COLUMNS = 3  # pictures side by side; chosen
MOST_POINTS, OF_ONE = 3000, 400
"""Drawn of all cameras, and of one; chosen (see benchmarks/pages.py)."""
ARROW = 0.08
"""Longest arrow, as a share of the image's width; chosen."""


def images_figure(cameras: list[dict[str, Any]], evidence: Evidence) -> Figure:
    """A panel a camera: its points, their residuals as lines much enlarged, their hull, and (1) of `quality.images`."""
    if not len(evidence.uv):
        return empty("The calibration came as a file, which does not say what it was made from.")
    rows = -(-len(cameras) // COLUMNS)
    scale, enlarged = _enlargement(cameras, evidence)
    titles = labels(camera["name"] for camera in cameras)
    columns = min(COLUMNS, len(cameras))
    sizes = [camera["size_px"] or 2 * np.array(camera["principal_point_px"]) for camera in cameras]
    fig = panels(
        85 + 270 * rows, (rows, columns), [image_axes(width - 0.5, height - 0.5) for width, height in sizes],
        titles=titles, gaps=(0.05, 0.28 / rows), margin={"l": 50, "r": 20, "t": 40, "b": 66},
    )  # fmt: skip
    for c, camera in enumerate(cameras):
        place = panel(c)
        _background(fig, camera, place)
        _points(fig, evidence, c, enlarged, place)
        _hull(fig, camera, place)
    high = max([camera["aim_corner_px"] or 0 for camera in cameras] + [0.01])
    bar = {"title": {"text": "px"}, "thickness": 14}
    fig.arrange(coloraxis={"colorscale": BLUES, "cmin": 0, "cmax": high, "colorbar": bar})
    note = f"residuals drawn {scale:,.0f} times as long" if scale else ""
    return fig.annotate(
        text=note, showarrow=False, x=1, y=0, xref="paper", yref="paper", yshift=-50, xanchor="right",
        font={"color": FAINT, "size": 12},
    )  # fmt: skip


def _enlargement(cameras: list[dict[str, Any]], evidence: Evidence) -> tuple[float, float]:
    """A round factor that makes large residuals visible."""
    length = np.linalg.norm(evidence.residual[evidence.kept], axis=-1)
    if not len(length) or not length.max() > 0:
        return 0.0, 0.0
    widths = [camera["size_px"][0] for camera in cameras if camera["size_px"]]
    factor = ARROW * (float(np.median(widths)) if widths else 1000.0) / float(np.quantile(length, 0.95))
    power = 10.0 ** np.floor(np.log10(factor))
    factor = float(power * max(k for k in (1, 2, 5) if k * power <= factor))
    return factor, factor


def _background(fig: Figure, camera: dict[str, Any], place: dict[str, str]) -> None:
    aim = np.array(camera["aim_px"], np.float64)
    if np.isfinite(aim).any():
        fig.add(
            "heatmap",
            z=aim.astype(np.float32), x=camera["aim_u_px"], y=camera["aim_v_px"], coloraxis="coloraxis", zsmooth="best",
            hovertemplate="uncertain by %{z:.2f} px<extra></extra>", **place,
        )  # fmt: skip


def _points(fig: Figure, evidence: Evidence, c: int, enlarged: float, place: dict[str, str]) -> None:
    seen = np.isfinite(evidence.uv[c]).all(1)
    for used, colour, symbol in ((True, HUES[1], "circle"), (False, "#B3261E", "x")):
        rows = np.flatnonzero(seen & (evidence.kept[c] == used))
        rows = rows[:: max(1, -(-len(rows) // min(OF_ONE, MOST_POINTS // len(evidence.uv))))]
        uv, names = evidence.uv[c, rows], labels(evidence.names[n] for n in rows if n < len(evidence.names))
        fig.add(
            "scatter", x=uv[:, 0].astype(np.float32), y=uv[:, 1].astype(np.float32), mode="markers", text=names or None,
            marker={"size": 4 if used else 6, "color": colour, "symbol": symbol},
            hovertemplate="%{text}<extra></extra>", **place,
        )  # fmt: skip
        if used and enlarged:
            line = _segments(uv, uv + enlarged * np.nan_to_num(evidence.residual[c, rows]))
            x, y = line.T.astype(np.float32)
            style = {"color": HUES[1], "width": 1.2}
            fig.add("scatter", x=x, y=y, mode="lines", line=style, hoverinfo="skip", **place)


def _hull(fig: Figure, camera: dict[str, Any], place: dict[str, str]) -> None:
    """What the points lie within."""
    hull = np.array(camera["hull_px"], np.float64).reshape(-1, 2)
    if len(hull):
        x, y = np.concatenate([hull, hull[:1]]).T
        line = {"color": FAINT, "width": 1.2, "dash": "dot"}
        fig.add("scatter", x=x, y=y, mode="lines", line=line, hoverinfo="skip", **place)


def _segments(a: Floats, b: Floats) -> Floats:
    """(3 n, 2) lines from a to b with breaks between."""
    return np.stack([a, b, np.full_like(a, np.nan)], 1).reshape(-1, 2)
