"""Images of cameras with what is detected in them: each spot framed, invalid ones coloured and with their reason.

All that is drawn is SVG over the image itself, so that a page needs no script and a picture can be enlarged.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from ..data import Validity
from ..data.array_types import GreyLevels
from ..detect import Blobs
from ..io.images import png_bytes
from .figures_detections import COLUMNS, KINDS, SEPARATED, VALID
from .templating import render, write_text

ROOM = 2
"""px of the image between a spot and its frame; chosen."""
LETTERS = 1 / 40
"""Height of the reasons by the width of what is shown; chosen: readable with three pictures side by side."""
MOST_SPOTS = 2000
"""Drawn in one picture; chosen: more cannot be told apart."""


class FieldPicture(NamedTuple):
    """One image of a camera and what is detected in it.

    Attributes:
        camera: its name. frame: number of the frame.
        image: (H, W) 8 bits, as it was recorded; of a field, where interlaced.
        blobs: the detections, in px of this image.
        tall: lines of a frame that a line of this image stands for: 2 for fields, else 1.
        region: (4) px, u and v of the first and last pixel that are shown; all where None.
    """

    camera: str
    frame: int
    image: GreyLevels
    blobs: Blobs
    tall: int = 1
    region: tuple[int, int, int, int] | None = None

    @property
    def valid(self) -> int:
        """How many detections go on to matching."""
        return int((self.blobs.validity == Validity.VALID).sum())

    @property
    def invalid(self) -> int:
        """How many do not."""
        return len(self.blobs.validity) - self.valid


def field_svg(picture: FieldPicture) -> Markup:
    """The picture as SVG: the image, a frame about each spot in its kind's colour, the reason of invalid ones."""
    height, width = picture.image.shape
    u0, v0, u1, v1 = picture.region or (0, 0, width - 1, height - 1)
    wide, high = shown_size(picture)
    seen = np.ascontiguousarray(picture.image[v0 : v1 + 1, u0 : u1 + 1])
    data = base64.b64encode(png_bytes(seen)).decode()
    shown = (picture.blobs.uv >= (u0 - 0.5, v0 - 0.5)) & (picture.blobs.uv <= (u1 + 0.5, v1 + 0.5))
    rows = np.flatnonzero(shown.all(1))[:MOST_SPOTS]
    spots = Markup("").join(_spot(picture.blobs, int(row), u0, v0, picture.tall, wide) for row in rows)
    return Markup(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}" width="100%" role="img" '
        'aria-label="{name}, frame {frame}: {valid} markers, {invalid} invalid" font-family="sans-serif">'
        '<image href="data:image/png;base64,{data}" width="{wide}" height="{high}" preserveAspectRatio="none" '
        'style="image-rendering: pixelated"/>{spots}</svg>'
    ).format(
        wide=wide, high=high, name=picture.camera, frame=picture.frame, valid=picture.valid, invalid=picture.invalid,
        data=data, spots=spots,
    )  # fmt: skip


def _spot(blobs: Blobs, row: int, u0: int, v0: int, tall: int, shown: int) -> Markup:
    """A frame about a spot; of an invalid one its kind above it, inside the columns that are shown."""
    kind = kind_of(blobs.validity[row], merged=bool(blobs.merged[row]))
    colour, (u, v) = KINDS[kind][0], blobs.uv[row]
    wide, high = blobs.width[row] + 2 * ROOM, (blobs.height[row] + 2 * ROOM) * tall
    x, y = u - u0 + 0.5 - wide / 2, (v - v0 + 0.5) * tall - high / 2
    frame = Markup(
        '<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="none" stroke="{}" '
        'vector-effect="non-scaling-stroke" stroke-width="1.5"><title>{}</title></rect>'
    ).format(x, y, wide, high, colour, kind)
    if kind in (VALID, SEPARATED):
        return frame
    letters, end = shown * LETTERS, u - u0 > shown / 2
    return frame + Markup(
        '<text x="{:.1f}" y="{:.1f}" font-size="{:.1f}" fill="{}" text-anchor="{}">{}</text>'
    ).format(
        min(x + wide, shown) if end else max(x, 0), max(y - letters / 4, letters), letters, colour,
        "end" if end else "start", kind,
    )  # fmt: skip


def kind_of(validity: np.uint8 | Validity, *, merged: bool) -> str:
    """The kind of a spot, as in `figures_detections.KINDS`."""
    if validity == Validity.VALID:
        return SEPARATED if merged else VALID
    return Validity(int(validity)).name.lower().replace("_", " ")


def write_fields_page(path: Path | str, rows: Sequence[Sequence[FieldPicture]], *, heading: str, below: str) -> None:
    """Write a page with the images of all cameras, frame by frame.

    Args:
        path: of the page.
        rows: for each frame the picture of every camera.
        heading, below: what stands above, as the trial and its session.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    kinds = [(name, colour) for name, (colour, _) in KINDS.items()]
    frames = [(row[0].frame, [(one, field_svg(one)) for one in row]) for row in rows]
    nav = {f"frame-{frame}": f"Frame {frame}" for frame, _ in frames}
    columns = min(COLUMNS, max(len(row) for row in rows))
    page = {"heading": heading, "below": below, "nav": nav, "frames": frames, "kinds": kinds, "columns": columns}
    write_text(path, render("fields.html", library=None, **page))


def shown_size(picture: FieldPicture) -> tuple[int, int]:
    """Width and height of what is shown, in columns of the image."""
    height, width = picture.image.shape
    u0, v0, u1, v1 = picture.region or (0, 0, width - 1, height - 1)
    return u1 - u0 + 1, (v1 - v0 + 1) * picture.tall
