"""Videos whose every frame has its number drawn into it as a bar code, so that a wrong one is seen."""

from fractions import Fraction
from itertools import pairwise

import av
import numpy as np

BITS, BAR = 12, 8
WIDTH, HEIGHT = BITS * BAR, 32
BLACK, WHITE = 20, 230


def bars(n):
    """(HEIGHT, WIDTH) uint8: bit b of n is bar b."""
    row = np.repeat(np.where((n >> np.arange(BITS)) & 1, WHITE, BLACK), BAR)
    return np.ascontiguousarray(np.tile(row.astype(np.uint8), (HEIGHT, 1)))


def number(image):
    """What bars say, at any scale."""
    level = image.astype(float).mean(0)
    edges = np.linspace(0, len(level), BITS + 1).round().astype(int)
    mean = [level[a + 1 : b - 1].mean() for a, b in pairwise(edges)]
    return sum(1 << b for b, value in enumerate(mean) if value > (BLACK + WHITE) / 2)


def interlaced(n):
    """A frame of two fields: rows 0, 2, … say 2n and the others 2n + 1."""
    frame = bars(2 * n)
    frame[1::2] = bars(2 * n + 1)[1::2]
    return frame


def write_numbered(
    path, frames, *, codec="libx264", rate=Fraction(100), group=250, reordered=2, image=bars, options=None
):
    """A video of so many frames; `group` from key frame to key frame, `reordered` of them in a row."""
    pixels = {"mjpeg": "yuvj420p", "ffv1": "gray", "rawvideo": "gray"}.get(codec, "yuv420p")
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=rate)
        stream.height, stream.width = image(0).shape
        stream.pix_fmt, stream.options = pixels, options or {}
        stream.codec_context.gop_size = group
        if codec not in ("mjpeg", "ffv1", "rawvideo"):
            stream.codec_context.max_b_frames = reordered
        for n in range(frames):
            frame = av.VideoFrame.from_ndarray(image(n), format="gray").reformat(format=pixels)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path
