"""Noise removal (KISS 2.2): groups that are too small to be an image of anything leave no trace.

The four criteria of Shafiq, Tümer and Güler 2001: width and height below limits, the only one of the former method;
isolated pixels; groups one pixel wide; groups one pixel high.
"""

from __future__ import annotations

from .pixel_groups import KissGroups, rectangles, white_pixels


def remove_noise(
    groups: KissGroups, *, min_width: int, min_height: int, isolated: bool, one_wide: bool, one_high: bool
) -> KissGroups:
    """The groups without those narrower and lower than the limits, px, and without those that a criterion names."""
    brect = rectangles(groups)
    noise = (brect.width < min_width) & (brect.height < min_height)
    if isolated:
        noise |= white_pixels(groups) == 1
    if one_wide:
        noise |= brect.width == 1
    if one_high:
        noise |= brect.height == 1
    return groups.keep(~noise)
