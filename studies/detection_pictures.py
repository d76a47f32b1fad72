"""Pictures of what detection makes of an image: SVG panels of white pixels, and PNG files of grey levels."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from kinemark.data import Validity
from kinemark.detect import Blobs
from kinemark.numerics.runs import true_runs_of_rows
from kinemark.report.field_pictures import LETTERS, FieldPicture, field_svg, shown_size

Images = NDArray[np.uint8]

VALID, SEPARATED, INVALID = "#16b455", "#e09a00", "#e02828"
GAP, CAPTION = 12, 16


def panels(white: NDArray[np.bool_], results: Sequence[tuple[str, Blobs | None]], *, columns: int = 3) -> str:
    """An SVG with the white pixels (H, W) once a result, its detections framed: their rectangles about their centroids.

    Valid ones are green, those cut out of a larger group yellow, invalid ones red.
    """
    height, width = white.shape
    step_x, step_y = width + GAP, height + GAP + CAPTION
    rows = -(-len(results) // columns)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {columns * step_x} {rows * step_y}" '
        f'width="{columns * step_x}" font-family="sans-serif" font-size="11">',
        f'<defs><path id="white" d="{_runs(white)}" fill="#cfd6de"/></defs>',
        '<rect width="100%" height="100%" fill="#fff"/>',
    ]
    for k, (caption, blobs) in enumerate(results):
        lines += [
            f'<g transform="translate({k % columns * step_x + GAP / 2} {k // columns * step_y + CAPTION})">',
            f'<text y="-4">{caption}</text>',
            f'<rect width="{width}" height="{height}" fill="#10151c"/><use href="#white"/>',
            *(_frames(blobs) if blobs else ()),
            "</g>",
        ]
    return "\n".join([*lines, "</svg>", ""])


def _runs(white: NDArray[np.bool_]) -> str:
    """The white pixels as the path of an SVG, a rectangle a run."""
    return "".join(f"M{a} {v}h{b - a}v1h{a - b}z" for v, a, b in true_runs_of_rows(white))


def _frames(blobs: Blobs) -> list[str]:
    """A rectangle and a dot for each detection."""
    shapes = []
    for (u, v), w, h, validity, merged in zip(
        blobs.uv + 0.5, blobs.width, blobs.height, blobs.validity, blobs.merged, strict=True
    ):
        colour = INVALID if validity != Validity.VALID else SEPARATED if merged else VALID
        shapes.append(
            f'<rect x="{u - w / 2 - 1:.1f}" y="{v - h / 2 - 1:.1f}" width="{w + 2:.0f}" height="{h + 2:.0f}" '
            f'fill="none" stroke="{colour}" stroke-width="1.2"/>'
            f'<circle cx="{u:.1f}" cy="{v:.1f}" r="1.3" fill="{colour}"/>'
        )
    return shapes


def enclosing(blobs: Sequence[Blobs], size: tuple[int, int], margin: int) -> tuple[int, int, int, int]:
    """The region of images of `size` (width, height) px that encloses all valid detections, and so many px more.

    Raises:
        ValueError: there is no valid detection.
    """
    valid = [one.validity == Validity.VALID for one in blobs]
    uv = np.concatenate([one.uv[v] for one, v in zip(blobs, valid, strict=True)])
    if not len(uv):
        raise ValueError("there is no valid detection: nothing can be enclosed")
    half = np.concatenate([np.stack([b.width, b.height], 1)[v] / 2 for b, v in zip(blobs, valid, strict=True)])
    low = np.maximum(np.floor((uv - half).min(0)) - margin, 0).astype(int)
    high = np.minimum(np.ceil((uv + half).max(0)) + margin, np.array(size) - 1).astype(int)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def stacked_svg(pictures: Sequence[FieldPicture], captions: Sequence[str]) -> str:
    """Pictures one below another as one SVG of its own, each with its caption above."""
    sizes = [shown_size(picture) for picture in pictures]
    wide = max(size[0] for size in sizes)
    letters, y, parts = wide * LETTERS, 0.0, Markup("")
    for picture, caption, (width, height) in zip(pictures, captions, sizes, strict=True):
        parts += Markup('<text x="0" y="{:.1f}" font-size="{:.1f}">{}</text>').format(
            y + 1.2 * letters, letters, caption
        )
        parts += Markup('<svg y="{:.1f}" width="{}" height="{}">{}</svg>').format(
            y + 1.6 * letters, width, height, field_svg(picture)
        )
        y += height + 2.2 * letters
    return Markup(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {} {:.0f}" font-family="sans-serif">'
        '<rect width="100%" height="100%" fill="#fff"/>{}</svg>\n'
    ).format(wide, y, parts)


def write_picture(path: Path, image: Images, blobs: Blobs, zoom: int = 3) -> None:
    """A PNG of the image (H, W) with the rectangles of the detections: valid green, separated yellow, invalid red."""
    picture = np.repeat(np.repeat(image, zoom, 0), zoom, 1)[..., None].repeat(3, -1)
    colours = np.where(
        blobs.validity[:, None] > 0, (255, 40, 40), np.where(blobs.merged[:, None], (255, 210, 0), (0, 230, 0))
    )
    for (u, v), w, h, colour in zip(blobs.uv, blobs.width, blobs.height, colours, strict=True):
        left, right = (int(np.clip(zoom * (u + s * (w / 2 + 1) + 0.5), 0, picture.shape[1] - 1)) for s in (-1, 1))
        top, bottom = (int(np.clip(zoom * (v + s * (h / 2 + 1) + 0.5), 0, picture.shape[0] - 1)) for s in (-1, 1))
        picture[[top, bottom], left : right + 1] = picture[top : bottom + 1, [left, right]] = colour
        picture[int(zoom * (v + 0.5)), int(zoom * (u + 0.5)) - 2 : int(zoom * (u + 0.5)) + 3] = colour
    path.write_bytes(png(picture))


def png(picture: Images) -> bytes:
    """An RGB picture (H, W, 3) as a PNG file."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width, _ = picture.shape
    lines = np.pad(picture.reshape(height, 3 * width), ((0, 0), (1, 0)))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(lines.tobytes()))
        + chunk(b"IEND", b"")
    )
