"""Parameters of detection that images propose for themselves.

The threshold comes from the gap between noise and markers (`stability`), the limits of size from the sizes of what is
brighter (`sizes`). Every proposed number stands with the measured ones that it follows from, and findings say which
images look wrong (dark, white, dark markers, clipped light, no gap). It is a proposal: whoever knows the
laboratory decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..data import Finding, make_finding
from ..data.array_types import Floats, GreyLevels
from ..numerics.evenly import evenly
from .centroids_method import Centroids, Limits, check_images, grey_scale
from .frame_source import FrameSource, spread
from .kiss import KissNearest, KissScanning
from .sizes import Sizes, marker_sizes
from .stability import LevelGap, marker_gap, peaks_of, real_groups
from .standing import standing_spots

FRAMES = 12  # frames that a proposal looks at; chosen for speed
WIDE_GAP = 1.3
"""Contrast at the gap's end by that at its beginning that is called clear; chosen."""
MUCH = 0.1
"""Share of the pixels that are bright and no marker that is called much; chosen."""


class Reason(NamedTuple):
    """A parameter, its proposed value, and the measured numbers that it follows from, by name."""

    parameter: str
    value: float
    measured: Mapping[str, float | bool]


@dataclass(frozen=True, slots=True)
class DetectionProposal:
    """What the images of a camera propose.

    Attributes:
        size: width and height, px. frames: how many were looked at. white: the brightest level the camera can give.
        gap: levels of background, noise and markers, in the images' own grey levels (of the negative, where inverted).
        sizes: of the markers; None where there are none.
        inverted: whether markers are dark on a bright ground.
        centroids, scanning, nearest: the methods with the proposed parameters; defaults where there are no markers.
        reasons: a parameter each. findings: what looks wrong; empty where nothing does.
        masks: (4, 2) px each, of spots that never move while others do.
    """

    size: tuple[int, int]
    frames: int
    white: int
    gap: LevelGap
    sizes: Sizes | None
    inverted: bool
    centroids: Centroids
    scanning: KissScanning
    nearest: KissNearest
    reasons: tuple[Reason, ...]
    findings: tuple[Finding, ...]
    masks: tuple[Floats, ...] = ()


def propose(
    images: GreyLevels | FrameSource, *, frames: int = FRAMES, inverted: bool | None = None
) -> DetectionProposal:
    """Parameters for images (n, H, W) or for what a camera recorded; of many frames, so many spread over all.

    Args:
        images: of one camera.
        frames: how many are looked at.
        inverted: whether markers are dark on bright ground; None: as the images say.

    Raises:
        ValueError: no frames, or they are no stack of grey images.
    """
    stack = _spread(images, frames)
    check_images(stack)
    white = white_level(stack)
    stack, gap, inverted = _gap(stack, white, inverted)
    sizes = _sizes(stack, gap)
    reasons = tuple(_reasons(gap, sizes, white, grey_scale(stack.dtype), inverted)) if sizes else ()
    masks = _masks(stack, gap, sizes) if sizes else ()
    return DetectionProposal(
        (stack.shape[2], stack.shape[1]),
        len(stack),
        white,
        gap,
        sizes,
        inverted,
        *_methods({reason.parameter: reason.value for reason in reasons}, inverted),
        reasons,
        (*_findings(stack, white, gap, sizes, inverted), *_standing(masks)),
        masks,
    )


def measured(images: GreyLevels, *, inverted: bool) -> tuple[Limits, Sizes, LevelGap] | None:
    """What `propose` says of threshold and sizes, without the findings; None where there are no markers."""
    white = white_level(images)
    stack, gap, _ = _gap(images, white, inverted)
    if (sizes := _sizes(stack, gap)) is None:
        return None
    values = {one.parameter: one.value for one in _reasons(gap, sizes, white, grey_scale(stack.dtype), inverted)}
    return _methods(values, inverted)[0].limits, sizes, gap


def _sizes(stack: GreyLevels, gap: LevelGap) -> Sizes | None:
    """Of the groups above the threshold, where there is one."""
    if not np.isfinite(gap.threshold):
        return None
    groups = real_groups(stack, gap.threshold)
    return marker_sizes(groups, height=stack.shape[1], width=stack.shape[2], frames=len(stack))


def _gap(stack: GreyLevels, white: int, inverted: bool | None) -> tuple[GreyLevels, LevelGap, bool]:
    """The images or their negative, the gap in these, and whether it is the negative."""
    gap = marker_gap(stack)
    if inverted is False or (inverted is None and gap.background <= 0.25 * white):
        return stack, gap, False
    negative = np.subtract(white, np.minimum(stack, white)).astype(stack.dtype)
    dark = marker_gap(negative)
    return (negative, dark, True) if inverted or _wider(dark, gap) else (stack, gap, False)


def _spread(images: GreyLevels | FrameSource, frames: int) -> GreyLevels:
    """So many frames, spread evenly."""
    n = len(images) if isinstance(images, np.ndarray) else images.n_frames
    if n == 0 or frames < 1:
        raise ValueError(f"{frames} of {n} frames cannot be looked at, wanted at least one")
    return images[evenly(n, frames)] if isinstance(images, np.ndarray) else spread(images, frames)[1]


def white_level(images: GreyLevels) -> int:
    """The brightest level that a camera of 8, 10, 12, 14 or 16 bits can give, whichever holds the images."""
    if images.dtype == np.uint8:
        return 255
    top = int(images.max())
    return next(level for level in (1023, 4095, 16383, 65535) if top <= level)


def _wider(dark: LevelGap, bright: LevelGap) -> bool:
    """Whether the negative parts markers from noise better than the images do."""
    return bool(np.isfinite(dark.low)) and not (bright.high - bright.low >= dark.high - dark.low)


def _reasons(gap: LevelGap, sizes: Sizes, white: int, scale: float, inverted: bool) -> Iterator[Reason]:
    """Each parameter and why."""
    threshold = (white - gap.threshold if inverted else gap.threshold) / scale
    b, low, high, peak = (x / scale for x in (gap.background, gap.low, gap.high, gap.peak))
    yield Reason(
        "threshold",
        round(threshold, 1 if threshold >= 10 else 2),
        {
            "background": b,
            "noise": gap.noise / scale,
            "peak": peak,
            "inverted": inverted,
            "low": low,
            "high": high,
            "groups_per_frame": gap.groups,
        },
    )
    areas = {"least_px2": sizes.least, "greatest_px2": sizes.greatest, "median_px2": sizes.area}
    yield Reason("min_area", max(1, int(sizes.low)), areas | {"smaller_per_frame": sizes.specks})
    yield Reason("max_area", max(8, int(np.ceil(sizes.high))), areas | {"larger_per_frame": sizes.strobes})
    sides = {"width_px": sizes.width, "height_px": sizes.height}
    yield Reason("min_width", _least_width(min(sizes.width, sizes.height)), sides)
    yield Reason("max_aspect", round(max(2.5, 1.6 * sizes.aspect, _thin(sizes)), 1), {"median_aspect": sizes.aspect})
    yield from _kiss_reasons(sizes)


def _least_width(side: float) -> int:
    """Of markers whose shorter side, px, is this: small ones may be a single pixel wide between two rows."""
    return 1 if side < 4 else 2 if side < 9 else 3


def _thin(sizes: Sizes) -> float:
    """Longer by shorter side of small markers that lie in a single row, with a pixel of room at both ends."""
    return max(sizes.width, sizes.height) + 2 if _least_width(min(sizes.width, sizes.height)) == 1 else 1.0


def _kiss_reasons(sizes: Sizes) -> Iterator[Reason]:
    """What the paper's method needs besides; the shares are those that part simulated pairs of markers best."""
    rows = max(2, int(np.ceil(0.4 * sizes.height)))
    sides = {"width_px": sizes.width, "height_px": sizes.height}
    yield Reason("near_x", float(max(2, np.ceil(0.6 * sizes.width))), sides)
    yield Reason("small_area", float(np.ceil(max(8.0, 0.7 * sizes.width * rows))), sides | {"rows": rows})
    yield Reason("small_rows", rows, sides)
    ratio = sizes.height / sizes.width
    ratio = 1.0 if 0.75 < ratio < 1.33 else ratio
    room = _room(min(sizes.width, sizes.height))
    yield Reason("min_ratio", round(ratio / room, 3), {"factor": room})
    yield Reason("max_ratio", round(ratio * room, 3), {"factor": room})


def _room(side: float) -> float:
    """How much longer than a marker of this shorter side, px, a group is before it is split.

    A fifth, for motion blur, and a pixel at either end; parts of what is split need √2, and touching markers have 2.
    """
    return float(np.clip(1.2 * (side + 1) / max(side - 1, 1), 1.43, 1.7))


def _methods(value: dict[str, float], inverted: bool) -> tuple[Centroids, KissScanning, KissNearest]:
    """The methods with these values."""
    if not value:
        return Centroids(), KissScanning(), KissNearest()
    threshold, least, greatest = value["threshold"], int(value["min_area"]), int(value["max_area"])
    centroids = Centroids(
        threshold=threshold,
        inverted=inverted,
        min_area=least,
        max_area=greatest,
        min_width=int(value["min_width"]),
        max_aspect=value["max_aspect"],
    )
    scanning = KissScanning(
        threshold=threshold,
        inverted=inverted,
        min_area=least,
        max_area=greatest,
        near_x=value["near_x"],
        small_area=value["small_area"],
        small_rows=int(value["small_rows"]),
        min_ratio=value["min_ratio"],
        max_ratio=value["max_ratio"],
    )
    return centroids, scanning, KissNearest(threshold=threshold, inverted=inverted)


def _findings(images: GreyLevels, white: int, gap: LevelGap, sizes: Sizes | None, inverted: bool) -> Iterator[Finding]:
    """What looks wrong."""
    share = float((images >= white).mean())
    if not inverted and (gap.background >= 0.95 * white or share > 0.5):
        yield make_finding("images_white", white_share=share)
    elif sizes is None:
        yield make_finding(
            "nothing_stands_out",
            brightest=gap.brightest,
            white=white,
            background=gap.background,
            noise=gap.noise,
        )
    if inverted:
        yield make_finding("markers_dark")
    if np.isfinite(gap.low) and gap.high - gap.background < WIDE_GAP * (gap.low - gap.background):
        yield make_finding("no_clear_gap", low=gap.low, high=gap.high, white=white)
    if sizes is not None and (much := _no_markers(images, gap, sizes)) > MUCH:
        yield make_finding("bright_without_markers", pixels_share=much)
    if sizes is not None and not inverted:
        clipped = float((peaks_of(images, real_groups(images, gap.threshold)) >= white).mean())
        if clipped > 0.3:
            yield make_finding("light_clipped", groups_share=clipped)
    if images.dtype == np.uint16 and white < 65535:
        yield make_finding("few_bits_used", white=white)


def _masks(images: GreyLevels, gap: LevelGap, sizes: Sizes) -> tuple[Floats, ...]:
    """`DetectionProposal.masks` of images (n, H, W)."""
    groups = real_groups(images, gap.threshold)
    groups = groups.keep((groups.area >= sizes.low) & (groups.area <= sizes.high))
    return standing_spots(groups, height=images.shape[1], width=images.shape[2], frames=len(images))


def _standing(masks: tuple[Floats, ...]) -> Iterator[Finding]:
    """That spots stand, and where."""
    if masks:
        yield make_finding("spots_standing", at_list=["({:.0f}, {:.0f})".format(*mask.mean(0)) for mask in masks])


def _no_markers(images: GreyLevels, gap: LevelGap, sizes: Sizes) -> float:
    """Share of the pixels that are above the threshold in groups of another size than markers have."""
    area = real_groups(images, gap.threshold).area
    return float(area[(area < sizes.low) | (area > sizes.high)].sum() / images.size)
