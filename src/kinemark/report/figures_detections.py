"""What each camera saw: one of its images, with the spots that count, those that do not, and why.

A frame that shows more kinds of trouble tells more, so of the first `LOOKED_AT` frames of a camera that one is shown
in which most spots are invalid or were separated from others; the earliest of several.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data import Detections, Validity
from ..data.array_types import GreyLevels
from ..io.images import png_bytes
from .drawing import Figure
from .formatting import number
from .panels import image_axes, panel, panels
from .theme import empty, labels

LOOKED_AT = 100  # frames of a camera among which one is chosen; for speed
DARK = "rgb(28,39,51)"
"""Behind the spots, like a dark image; written so that dark pages leave it as it is (they recolour #RRGGBB)."""
COLUMNS = 3  # pictures side by side; chosen
WIDEST = 320
"""Columns of a picture in the page; of each block of pixels the brightest is shown, so that no spot is lost; chosen."""
LEAST_WIDE = 40  # columns of a picture, however many cameras there are; chosen
LEVELS = 15
"""Grey levels above black of such a picture; noise below a step is not kept, which makes it small; chosen."""
MOST_BYTES = 60_000
"""Of the pictures of all cameras; a picture with more is drawn coarser; chosen (see benchmarks/pages.py)."""
MOST_FAULTS = 2400
"""Invalid spots of other frames that are drawn, of all cameras; chosen (see benchmarks/pages.py)."""
MOST_SPOTS = 1500
"""Spots of the frames shown, of all cameras; chosen (see benchmarks/pages.py)."""
VALID, SEPARATED = "valid", "valid, separated from another"
KINDS = {
    VALID: ("#56B4E9", "circle-open"),
    SEPARATED: ("#00D19A", "diamond-open"),
    "too small": ("#E69F00", "x-thin-open"),
    "too large": ("#FF6A3D", "square-open"),
    "not round": ("#E78AC3", "cross-thin-open"),
    "at edge": ("#F0E442", "triangle-up-open"),
    "masked": ("rgb(174,184,194)", "x-open"),
}
"""Colour and symbol of each kind of spot, bright on a dark image and different in shape."""


def fullest_frames(detections: Detections) -> list[int]:
    """The frame of each camera (C), from 0, that is shown: most spots that are invalid or merged, then most spots."""
    if not detections.n_frames:
        return [0] * len(detections.cameras)
    faulty = np.zeros(detections.counts.shape, np.int64)
    np.add.at(faulty, (detections.camera, detections.frame), ~detections.valid | detections.merged)
    fullness = faulty * (detections.counts.max(initial=0) + 1) + detections.counts
    return [int(f) for f in fullness[:, :LOOKED_AT].argmax(1)]


def spots_figure(
    detections: Detections,
    cameras: list[dict[str, Any]],
    pictures: Sequence[GreyLevels] | None = None,
    *,
    first_frame: int = 1,
) -> Figure:
    """A panel a camera: its picture (H, W) of the frame of `fullest_frames`, the spots in it, and all invalid ones.

    `first_frame` is the number of the first frame in the recording.
    """
    if not len(detections):
        return empty("No camera saw anything.")
    rows, columns = -(-len(cameras) // COLUMNS), min(COLUMNS, len(cameras))
    shown = fullest_frames(detections)
    names = labels(camera["name"] for camera in cameras)
    titles = [f"{name}, frame {number(f + first_frame)}" for name, f in zip(names, shown, strict=True)]
    extents = [_extent(camera, detections.uv[detections.camera == c]) for c, camera in enumerate(cameras)]
    axes = [image_axes(width - 0.5, height - 0.5, scaleanchor=False) for width, height in extents]
    fig = panels(
        110 + 290 * rows, (rows, columns), axes, titles=titles,
        gaps=(0.05, 0.24 / rows), plot_bgcolor=DARK, margin={"l": 50, "r": 20, "t": 60, "b": 60}, showlegend=True,
        legend={"orientation": "h", "y": -0.1 / rows, "yanchor": "top", "x": 0, "bgcolor": "#E4E8EC"},
    )  # fmt: skip
    kinds = kinds_of(detections)
    legends = _Legend(fig)
    for c in range(len(cameras)):
        place = panel(c)
        here = np.arange(*detections.rows(c, shown[c]).indices(len(detections))[:2])
        here = here[:: max(1, -(-len(here) * len(cameras) // MOST_SPOTS))]
        if pictures is not None:
            _picture(fig, pictures[c], place, most=MOST_BYTES // len(cameras))
        _elsewhere(fig, detections, kinds, c, place, most=MOST_FAULTS // len(cameras))
        legends.draw(detections, kinds, here, place)
    return fig


def kinds_of(detections: Detections) -> NDArray[np.str_]:
    """(D) the kind of each spot, as in `KINDS`."""
    names = np.array([VALID if v == Validity.VALID else v.name.lower().replace("_", " ") for v in Validity])
    kinds = names[detections.validity].astype("U40")
    kinds[detections.valid & detections.merged] = SEPARATED
    return kinds


class _Legend:
    """Draws spots, each kind once in the legend."""

    def __init__(self, fig: Figure) -> None:
        self.fig, self.in_legend = fig, set[str]()

    def draw(
        self, detections: Detections, kinds: NDArray[np.str_], rows: NDArray[np.int64], place: dict[str, str]
    ) -> None:
        """The spots of these rows."""
        for kind, (colour, symbol) in KINDS.items():
            of_kind = rows[kinds[rows] == kind]
            if not len(of_kind):
                continue
            self.fig.add(
                "scatter",
                x=detections.uv[of_kind, 0].astype(np.float32), y=detections.uv[of_kind, 1].astype(np.float32),
                mode="markers", name=kind, legendgroup=kind, showlegend=kind not in self.in_legend,
                marker={"size": 10, "color": colour, "symbol": symbol, "line": {"color": colour, "width": 1.6}},
                text=[_size_text(detections, int(row)) for row in of_kind],
                hovertemplate=f"{kind}<br>%{{x:.1f}}, %{{y:.1f}} px<br>%{{text}}<extra></extra>", **place,
            )  # fmt: skip
            self.in_legend.add(kind)


def _elsewhere(
    fig: Figure, detections: Detections, kinds: NDArray[np.str_], c: int, place: dict[str, str], *, most: int
) -> None:
    """Dots where spots of any frame were invalid: what stays in one place is no marker."""
    rows = np.flatnonzero((detections.camera == c) & ~detections.valid)
    rows = rows[:: max(1, -(-len(rows) // max(most, 1)))]
    if not len(rows):
        return
    fig.add(
        "scatter",
        x=detections.uv[rows, 0].astype(np.float32), y=detections.uv[rows, 1].astype(np.float32), mode="markers",
        marker={"size": 3, "opacity": 0.6, "color": [KINDS[str(kind)][0] for kind in kinds[rows]]},
        showlegend=False, hoverinfo="skip", **place,
    )  # fmt: skip


def _size_text(detections: Detections, row: int) -> str:
    """Size and brightness of a spot, as far as they are known."""
    area, peak = float(detections.area[row]), float(detections.peak[row])
    return f"area {number(area, 1)} px², peak {number(peak, 0)}" if np.isfinite(area) else ""


def _picture(fig: Figure, picture: GreyLevels, place: dict[str, str], *, most: int) -> None:
    """The image in grey, coarser where it is large, and in few levels, as a compressed picture."""
    k = max(1, -(-picture.shape[1] // WIDEST))
    while len(content := _png(brightest(picture, k))) > most and picture.shape[1] > 2 * k * LEAST_WIDE:
        k += 1
    data = base64.b64encode(content).decode()
    fig.add(
        "image",
        source=f"data:image/png;base64,{data}",
        x0=(k - 1) / 2,
        dx=k,
        y0=(k - 1) / 2,
        dy=k,
        hoverinfo="skip",
        **place,
    )


def _png(grey: GreyLevels) -> bytes:
    """A picture in a few levels from black to its brightest."""
    level = np.rint(LEVELS * (grey / max(int(grey.max()), 1))).astype(np.uint8)
    return png_bytes(level * np.uint8(255 // LEVELS))


def brightest(picture: GreyLevels, k: int) -> GreyLevels:
    """The brightest pixel of each block of k × k; what is left over at the right and lower edge falls away."""
    height, width = (n // k * k for n in picture.shape)
    return picture[:height, :width].reshape(height // k, k, width // k, k).max((1, 3))


def _extent(camera: dict[str, Any], uv: NDArray[np.float64]) -> tuple[float, float]:
    """Width and height of the images, px; where unknown, of what was seen."""
    if camera["size_px"]:
        return float(camera["size_px"][0]), float(camera["size_px"][1])
    if not len(uv):
        return 1.0, 1.0
    return float(np.nanmax(uv[:, 0])) + 10, float(np.nanmax(uv[:, 1])) + 10
