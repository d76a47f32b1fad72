"""Parameters of detection that images propose for themselves.

The threshold comes from the gap between noise and markers (`stability`), the limits of size from the sizes of what is
brighter (`sizes`). Every proposed number stands with the measured ones that it follows from, and images that look
wrong (dark, white, dark markers, clipped light, no gap) are said to do so. It is a proposal: whoever knows the
laboratory decides.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .centroids_method import Centroids, check_images, grey_scale
from .kiss import KissNearest, KissScanning
from .sizes import Sizes, marker_sizes
from .source import FrameSource
from .stability import LevelGap, groups_above, marker_gap, peaks_of

Images = NDArray[np.uint8 | np.uint16]

FRAMES = 12
BATCH = 16
WIDE_GAP = 1.3
"""Contrast at the gap's end by that at its beginning that is called clear."""
MUCH = 0.1
"""Share of the pixels that are bright and no marker that is called much."""


class Reason(NamedTuple):
    """A parameter, its proposed value, and why."""

    parameter: str
    value: float
    why: str


@dataclass(frozen=True, slots=True)
class DetectionProposal:
    """What the images of a camera propose.

    Attributes:
        size: width and height, px. frames: how many were looked at. white: the brightest level the camera can give.
        gap: levels of background, noise and markers, in the images' own grey levels (of the negative, where inverted).
        sizes: of the markers; None where there are none.
        inverted: whether markers are dark on a bright ground.
        centroids, scanning, nearest: the methods with the proposed parameters; defaults where there are no markers.
        reasons: a parameter each. warnings: what looks wrong; empty where nothing does.
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
    warnings: tuple[str, ...]

    def text(self) -> str:
        """The proposal as part of a session file, the reasons beside the values."""
        return "\n".join(_lines(self)) + "\n"


def propose(images: Images | FrameSource, *, frames: int = FRAMES) -> DetectionProposal:
    """Parameters for images (n, H, W) or for what a camera recorded; of many frames, so many spread over all.

    Raises:
        ValueError: no frames, or they are no stack of grey images.
    """
    stack = _spread(images, frames)
    check_images(stack)
    white = _white_level(stack)
    gap, inverted = marker_gap(stack), False
    negative = np.subtract(white, np.minimum(stack, white)).astype(stack.dtype)
    if gap.background > 0.25 * white and _wider(dark := marker_gap(negative), gap):
        stack, gap, inverted = negative, dark, True
    sizes = None
    if np.isfinite(gap.threshold):
        groups = groups_above(stack, gap.threshold)
        sizes = marker_sizes(groups, height=stack.shape[1], width=stack.shape[2], frames=len(stack))
    reasons = tuple(_reasons(gap, sizes, white, grey_scale(stack.dtype), inverted)) if sizes else ()
    return DetectionProposal(
        (stack.shape[2], stack.shape[1]),
        len(stack),
        white,
        gap,
        sizes,
        inverted,
        *_methods({reason.parameter: reason.value for reason in reasons}, inverted),
        reasons,
        tuple(_warnings(stack, white, gap, sizes, inverted)),
    )


def _spread(images: Images | FrameSource, frames: int) -> Images:
    """So many frames, spread evenly."""
    n = len(images) if isinstance(images, np.ndarray) else images.n_frames
    if n == 0 or frames < 1:
        raise ValueError(f"{frames} of {n} frames cannot be looked at, wanted at least one")
    wanted = np.unique(np.linspace(0, n - 1, min(frames, n)).astype(int))
    if isinstance(images, np.ndarray):
        return images[wanted]
    found, first = [], 0
    for batch in images.batches(BATCH):
        found += [batch[k - first] for k in wanted.tolist() if first <= k < first + len(batch)]
        first += len(batch)
        if first > wanted[-1]:
            break
    return np.stack(found)


def _white_level(images: Images) -> int:
    """The brightest level that a camera of 8, 10, 12, 14 or 16 bits can give, whichever holds the images."""
    top = int(images.max())
    levels = (255,) if images.dtype == np.uint8 else (1023, 4095, 16383, 65535)
    return next(level for level in levels if top <= level)


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
        f"background {b:.3g}, noise {gap.noise / scale:.2g}, markers' median peak {peak:.3g}{_of_negative(inverted)}; "
        f"from {low:.3g} to {high:.3g} the number of groups hardly changes, {gap.groups:.3g} a frame",
    )
    found = f"markers have {sizes.least:.0f} to {sizes.greatest:.0f} px², median {sizes.area:.0f}"
    below = f"{sizes.specks:.2g} smaller groups a frame" if sizes.specks else "nothing smaller was seen"
    above = f"{sizes.strobes:.2g} larger groups a frame" if sizes.strobes else "nothing larger was seen"
    yield Reason("min_area", max(4, int(sizes.low)), f"{found}; {below}")
    yield Reason("max_area", max(8, int(np.ceil(sizes.high))), f"{found}; {above}")
    narrow = min(sizes.width, sizes.height)
    median = f"markers are {sizes.width:.3g} px wide and {sizes.height:.3g} px high, the median of each"
    yield Reason("min_width", 2 if narrow < 9 else 3, median)
    yield Reason(
        "max_aspect", round(max(2.5, 1.6 * sizes.aspect), 1), f"half of the markers are below {sizes.aspect:.2f} to 1"
    )
    yield from _kiss_reasons(sizes)


def _kiss_reasons(sizes: Sizes) -> Iterator[Reason]:
    """What the paper's method needs besides; the shares are those that part simulated pairs of markers best."""
    rows = max(2, int(np.ceil(0.4 * sizes.height)))
    yield Reason("near_x", float(max(2, np.ceil(0.6 * sizes.width))), "0.6 of the median width")
    yield Reason(
        "small_area", float(np.ceil(max(8.0, 0.7 * sizes.width * rows))), f"{rows} rows of 0.7 of the median width"
    )
    yield Reason("small_rows", rows, "0.4 of the median height: rows above the notch of two markers side by side")
    ratio = sizes.height / sizes.width
    ratio = 1.0 if 0.75 < ratio < 1.33 else ratio
    room = _room(min(sizes.width, sizes.height))
    yield Reason("min_ratio", round(ratio / room, 3), f"{room:.3g} times wider for its height than a marker is")
    yield Reason("max_ratio", round(ratio * room, 3), f"{room:.3g} times higher for its width than a marker is")


def _room(side: float) -> float:
    """How much longer than a marker of this shorter side, px, a group is before it is split.

    A fifth, for motion blur, and a pixel at either end; parts of what is split need √2, and touching markers have 2.
    """
    return float(np.clip(1.2 * (side + 1) / max(side - 1, 1), 1.43, 1.7))


def _of_negative(inverted: bool) -> str:
    return " (of the negative)" if inverted else ""


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


def _warnings(images: Images, white: int, gap: LevelGap, sizes: Sizes | None, inverted: bool) -> Iterator[str]:
    """What looks wrong."""
    share = float((images >= white).mean())
    if not inverted and (gap.background >= 0.95 * white or share > 0.5):
        yield f"The images are white: {share:.0%} of the pixels have the brightest level. Shorten the exposure."
    elif sizes is None:
        yield (
            f"Nothing stands out: the brightest pixel has {gap.brightest:.0f} of {white}, the background "
            f"{gap.background:.0f} with a noise of {gap.noise:.2g}. Is the light on, are markers in view?"
        )
    if inverted:
        yield "The markers are dark on a bright ground: `inverted = true` is part of the proposal."
    if np.isfinite(gap.low) and gap.high - gap.background < WIDE_GAP * (gap.low - gap.background):
        yield (
            f"There is no clear gap between noise and markers: only from {gap.low:.0f} to {gap.high:.0f} of {white} "
            "the number of groups is steady. Look at the detections before you trust them."
        )
    if sizes is not None and (much := _no_markers(images, gap, sizes)) > MUCH:
        yield (
            f"{much:.0%} of the pixels stand out and are no markers: windows, lamps, a bright floor? Mask them or "
            "raise the threshold; KISS's long/wide test would break them to pieces."
        )
    if sizes is not None and not inverted:
        clipped = float((peaks_of(images, groups_above(images, gap.threshold)) >= white).mean())
        if clipped > 0.3:
            yield f"The light is clipped: {clipped:.0%} of the groups reach the brightest level. Shorten the exposure."
    if images.dtype == np.uint16 and white < 65535:
        yield f"The images have 16 bits, but no level above {white} is used: hence the low numbers of the thresholds."


def _no_markers(images: Images, gap: LevelGap, sizes: Sizes) -> float:
    """Share of the pixels that are above the threshold in groups of another size than markers have."""
    area = groups_above(images, gap.threshold).area
    return float(area[(area < sizes.low) | (area > sizes.high)].sum() / images.size)


def _lines(proposal: DetectionProposal) -> Iterator[str]:
    width, height = proposal.size
    yield f"# {proposal.frames} frames of {width} × {height} px, white is {proposal.white}"
    yield from (f"# ! {warning}" for warning in proposal.warnings)
    if not proposal.reasons:
        yield "# No parameters can be proposed."
        return
    yield "[detect]"
    if proposal.inverted:
        yield "inverted = true"
    kiss = False
    for reason in proposal.reasons:
        if not kiss and not hasattr(proposal.centroids, reason.parameter):
            kiss = True
            yield '# and for method = "kiss_scanning", in the place of min_width and max_aspect:'
        yield f"{'# ' if kiss else ''}{reason.parameter} = {reason.value:g}  # {reason.why}"
