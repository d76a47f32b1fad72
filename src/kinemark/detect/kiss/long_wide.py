"""Long/wide test (KISS 2.3.3): groups much higher than wide, or wider than high, are markers in a row.

With ratio = h / w a group is long if ratio > max R and wide if ratio < min R, and is broken into as many equal parts as
suitable so that each has its ratio between the limits. Of all such numbers n the most suitable is the one whose parts
have the ratio nearest to the middle M = √(min R · max R), counted in the logarithm:

    n = k where √((k − 1) k) < q ≤ √(k (k + 1)),   q = max(ratio / M, M / ratio)          (A)

and n ≥ 2. Parts are then within a factor √2 of M, so there is always such a number if max R ≥ 2 min R (B).

Source: Shafiq, Tümer and Güler 2001 (KISS), 2.3.3. "As many as suitable" is in the text, (A) is ours.
"""

from __future__ import annotations

import numpy as np

from .pixel_groups import KissGroups, Rectangles, rectangles, separated


def split_long_and_wide(groups: KissGroups, *, min_ratio: float, max_ratio: float) -> KissGroups:
    """The groups, those with a ratio beyond the limits in equal parts; groups separated before stay as they are."""
    brect = rectangles(groups)
    ratio = brect.height / brect.width
    is_long = (ratio > max_ratio) & ~groups.separated
    beyond = np.flatnonzero(is_long | ((ratio < min_ratio) & ~groups.separated))
    middle = np.sqrt(min_ratio * max_ratio)
    q = np.maximum(ratio[beyond] / middle, middle / ratio[beyond])
    most = np.where(is_long, brect.height, brect.width)[beyond]  # a part has a pixel at least
    number = np.minimum(np.ceil(np.sqrt(q * q + 0.25) - 0.5), most)  # (A): k (k + 1) ≥ q²
    number = np.maximum(number, 2).astype(np.int64)
    parent, n = np.repeat(beyond, number), np.repeat(number, number)
    k = np.arange(len(n)) - np.repeat(np.cumsum(number) - number, number)
    left, right, top, bottom = (side[parent] for side in brect)
    high, wide = (bottom - top + 1), (right - left + 1)
    cut_rows = is_long[parent]
    return separated(
        groups,
        parent,
        Rectangles(
            np.where(cut_rows, left, left + k * wide // n),
            np.where(cut_rows, right, left + (k + 1) * wide // n - 1),
            np.where(cut_rows, top + k * high // n, top),
            np.where(cut_rows, top + (k + 1) * high // n - 1, bottom),
        ),
    )
