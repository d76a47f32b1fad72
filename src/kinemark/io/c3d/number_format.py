"""Whether a file holds floats or integers, and of which scale, where its two statements contradict each other.

The scale stands in the header and in POINT:SCALE; below zero it says that points and channels are floats. Some writers
leave one of the two positive, zero or without sense. What fills the file up to its last block is then right.
"""

from __future__ import annotations

import math
from dataclasses import replace

from .document import C3D
from .header import C3DHeader
from .layout import layout_of
from .parameters import BLOCK

LEAST, MOST = 1e-12, 1e4
"""Units a count that a writer may mean; chosen, metres in 32 768 counts to thousands of mm a count and far beyond."""


def number_format(doc: C3D, header: C3DHeader, space: int) -> tuple[C3D, tuple[str, ...]] | None:
    """The document with `floats` and `scale`, and what was odd; None where the file does not tell.

    Args:
        doc: the document with its parameters, without data. header: the first block.
        space: bytes from the start of the data to where they may end.
    """
    both = (doc.number("POINT", "SCALE", 0.0), header.scale)
    stated = [scale for scale in both if math.isfinite(scale) and scale != 0]
    ways = list(dict.fromkeys(scale < 0 for scale in stated)) or [True, False]
    fitting = [floats for floats in ways if _fits(replace(doc, floats=floats), header, space)]
    if not stated and len(fitting) != 1:
        return None
    floats = (fitting or ways)[0]
    scales = sorted((abs(s) for s in stated), key=lambda s: not LEAST <= s <= MOST)  # stable: POINT:SCALE comes first
    scale = scales[0] if scales and (not floats or scales[0] <= MOST) else 1.0
    kind = "floats" if floats else "integers"
    odd = any(abs(s) != scale or (s < 0) != floats for s in both if s is not both[0] or doc.get("POINT", "SCALE"))
    note = f"scale: the header says {both[1]:g}, POINT:SCALE {both[0]:g}; taken as {kind} of scale {scale:g}"
    return replace(doc, floats=floats, scale=scale), (note,) if odd and doc.groups else ()


def _fits(doc: C3D, header: C3DHeader, space: int) -> bool:
    """Whether numbers of this size fill the space up to its last block."""
    layout = layout_of(header, doc, space)
    return 0 <= space - layout.frames * layout.width * (4 if doc.floats else 2) < BLOCK
