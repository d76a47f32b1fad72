"""Sub-marker detection (KISS 2.3.1): small groups that lie, almost, in a larger group's rectangle belong to it.

A group is small if it has fewer white pixels than a limit and no more than a few rows: two in the paper, whose fields
show markers about six lines high. The second condition keeps markers that are far away. It lies almost within another's
bounding rectangle if most of its own does:

    |brect_j ∩ brect_i| ≥ q |brect_j|,   q above one half by default                       (A)

It joins the group for which this share is greatest, the larger one where shares are equal. Only groups that are not
small themselves take others in, and all shares are those before any merging, so that no order matters.

Source: Shafiq, Tümer and Güler 2001 (KISS), 2.3.1. "Most of" is in the text; its number is ours.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Ints
from .pixel_groups import KissGroups, Rectangles, numbered, rectangles, white_pixels


def merge_sub_markers(
    groups: KissGroups, *, small_area: float, small_rows: int, inside: float, height: int
) -> KissGroups:
    """The groups of frames of this height, px, with small ones joined to those in whose rectangles they lie."""
    brect, white = rectangles(groups), white_pixels(groups)
    small = (white < small_area) & (brect.height <= small_rows)
    label = np.arange(len(white))
    frames = np.searchsorted(groups.frame, np.arange(groups.frame[-1] + 2)) if len(white) else np.zeros(0, np.int64)
    for j in np.flatnonzero(small).tolist():
        in_frame = slice(*frames[groups.frame[j] : groups.frame[j] + 2])
        share = np.where(small[in_frame], 0.0, _shared(brect, j, in_frame) / brect.total_pixels[j])
        if share.max(initial=0.0) >= inside:  # (A)
            label[j] = in_frame.start + np.lexsort((white[in_frame], share))[-1]
    if (label == np.arange(len(label))).all():
        return groups
    order = np.lexsort((groups.first, groups.y))
    runs = (column[order] for column in (groups.y, groups.first, groups.last, label[groups.of]))
    return numbered(*runs, height=height)


def _shared(brect: Rectangles, j: int, others: slice) -> Ints:
    """Pixels that rectangle j shares with each of the others."""
    wide = np.minimum(brect.right[j], brect.right[others]) - np.maximum(brect.left[j], brect.left[others]) + 1
    high = np.minimum(brect.bottom[j], brect.bottom[others]) - np.maximum(brect.top[j], brect.top[others]) + 1
    return np.maximum(wide, 0) * np.maximum(high, 0)
