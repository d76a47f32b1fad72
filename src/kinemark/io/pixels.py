"""Decoded frames as grey values, exactly as they are stored.

* Grey and Y′CbCr frames: the first plane, nothing scaled, so that limited-range video keeps its 16 … 235. (Asking a
  decoder for "gray" rescales it by up to 20 levels.)
* Colour: the luma of ITU-R BT.601, round(0.299 R + 0.587 G + 0.114 B); grey stored as colour comes out unchanged.
* 9 to 16 bits a sample give uint16 with the values as stored, all others uint8.
"""

from __future__ import annotations

import re
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

from ..data import KinemarkError

Image = NDArray[np.unsignedinteger[Any]]
"""(H, W) uint8 or uint16."""
LUMA = np.array([0.299, 0.587, 0.114])  # weights of red, green and blue (ITU-R BT.601)
MOST_PIXELS = 1 << 27  # of an image; chosen for memory
PLANAR = re.compile(r"gray(9|10|12|14|16)?(le|be)?|yuv[aj]?4\d\dp(9|10|12|14|16)?(le|be)?|nv(12|16|21|24|42)")
INTERLEAVED = {
    "ya8": (2, 0),
    "ya16le": (2, 0),
    "ya16be": (2, 0),
    "yuyv422": (2, 0),
    "yvyu422": (2, 0),
    "uyvy422": (2, 1),
}
"""Format → samples a pixel in the first plane, and which of them is the luma."""


def grey(frame: av.VideoFrame, where: str) -> Image:
    """(H, W) uint8 or uint16 grey values of a frame, which may be the frame's own memory.

    Args:
        frame: as decoded.
        where: the file, for the message.

    Raises:
        KinemarkError: the pixel format is one that is not read.
    """
    name, bits = frame.format.name, frame.format.components[0].bits
    if PLANAR.fullmatch(name) or name in INTERLEAVED:
        step, first = INTERLEAVED.get(name, (1, 0))
        samples = plane(frame, 16 if bits > 8 else 8)
        return samples if step == 1 else samples[:, first::step].copy()
    if name in ("monow", "monob"):
        return np.asarray(frame.to_ndarray(format="gray"), np.uint8)
    if (frame.format.is_rgb or frame.format.has_palette) and bits in (8, 16):
        colour: NDArray[Any] = frame.to_ndarray(format="rgb24" if bits == 8 else "rgb48le")
        return np.asarray(np.rint(colour @ LUMA), np.uint8 if bits == 8 else np.uint16)
    raise KinemarkError(
        f"{where} has the pixel format {name}, wanted grey, YUV or RGB. Convert it to 8- or 16-bit grey."
    )


def plane(frame: av.VideoFrame, bits: int) -> Image:
    """(H, n) the samples of the first plane in the machine's byte order, without the padding at the end of rows."""
    data = frame.planes[0]
    dtype = np.dtype("u1") if bits == 8 else np.dtype(">u2" if frame.format.name.endswith("be") else "<u2")
    n = frame.width * INTERLEAVED.get(frame.format.name, (1, 0))[0]
    rows = np.frombuffer(memoryview(data), np.uint8).reshape(-1, data.line_size)[: frame.height]
    samples: Image = np.ascontiguousarray(rows[:, : n * dtype.itemsize]).view(dtype)
    return samples.astype(dtype.newbyteorder("="), copy=False)


def check_pixels(where: str, width: int, height: int) -> None:
    """Refuse images that are empty or beyond all cameras.

    Raises:
        KinemarkError: there are no pixels, or more than 2²⁷.
    """
    if not 0 < width * height <= MOST_PIXELS:
        raise KinemarkError(f"{where} has {width} × {height} pixels, wanted 1 … {MOST_PIXELS}. Check the file.")
