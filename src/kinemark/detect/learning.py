"""What a method leaves open, learned from the recording of one camera.

Frames spread over the whole recording propose a threshold and limits of size (`proposal`). The threshold is the usual
share of white, where that lies in the gap between noise and markers, or barely above its end (`ABOVE`), clear of noise
where the ground is brightest, and not clearly above what is proposed, as a low threshold keeps more of each marker;
else the proposed one. Limits of size are
only wide: a marker may be nearer, farther, half hidden or on another one in the frames that were not looked at. So
areas begin at the lesser, and end at the greater, of the usual and the proposed limit (1), save where every other frame
shows something larger than all markers, as strobes and lamps do: then they end between the two, no nearer than `NEARER`
times the greatest marker (2).

Where the ground is uneven it is learned first, and all else from the frames without it (`ground`). Of lamps parts are
left that are dim; there the threshold is `FAINT` of the way to the usual peak at least.

Frames in which nothing stands out are left aside. Where none shows any marker, the threshold is the usual share of the
camera's white, or that far above bright ground (3), and limits are the usual ones.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import GreyLevels
from .background_noise import background
from .centroids_method import USUAL, Centroids, Limits, grey_scale
from .frame_source import FrameSource, spread, spread_at
from .ground import Ground, is_uneven
from .ground_learning import Spots, before_dark, hides_ground, static_ground, that_flickers, uncovered
from .proposal import measured, white_level
from .sizes import Sizes

FRAMES = 12  # looked at in each recording; chosen for speed
STANDS_OUT = 10.0  # standard deviations of noise that a frame's brightest pixel must be above the ground; chosen
NEARER = 4.0  # times the area of the greatest marker seen: at half its distance; chosen
NEAR = 0.75  # of the usual threshold, down to which a proposed one is no better; chosen
ABOVE = 1.1  # times the contrast of the gap's end, where the dimmest marker has twice that; chosen
OFTEN = 0.5  # share of frames with larger things that are lamps, and no markers on each other or nearer; chosen
FAINT = 0.25  # of the usual marker's contrast, where a ground is taken away; chosen: less is what lamps leave of it
STILL = 2.0  # times the area of the greatest marker that moves: still ones may be nearer, lamps are larger; chosen
LONG = 48  # frames of a recording whose ground is subtracted unasked; chosen: four times `FRAMES`, so that markers move


class Learned(NamedTuple):
    """A method with nothing left open, and the ground that is taken from the images first; None: nothing is."""

    method: Centroids
    ground: Ground | None = None


def learned(method: Centroids, source: FrameSource) -> Learned:
    """The method with a threshold and limits for what it leaves open, from the recording of a camera."""
    own = {name: getattr(method, name) for name in Limits._fields}
    wanted = method.background == "subtract" and source.n_frames >= FRAMES
    opened = method.relative_threshold is None and None in own.values()
    if not (wanted or opened) or source.n_frames == 0:
        return Learned(method)  # a relative threshold is measured in the first frames that show something: `levels`
    numbers, images = spread(source, FRAMES)
    if not len(images):  # the recording ends before it begins, which is said where it is read
        return Learned(method)
    found = learned_limits(images, inverted=method.inverted)
    may = method.background == "auto" and own["threshold"] is None and source.n_frames >= LONG
    ground = None
    if (wanted or (opened and may and is_uneven(images, found.threshold * grey_scale(images.dtype)))) and (
        under := _without_ground(method, source, numbers, images, sure=wanted)
    ):
        ground, found = under
    own["threshold"] = _from_ground(own["threshold"], ground, images)
    open_ones: dict[str, Any] = {name: value for name, value in found._asdict().items() if own[name] is None}
    stated = {} if own["threshold"] is None else {"threshold": own["threshold"]}
    return Learned(replace(method, **stated, **(_consistent(own, open_ones) if opened else {})), ground)


def _without_ground(
    method: Centroids, source: FrameSource, numbers: NDArray[np.int64], images: GreyLevels, *, sure: bool
) -> tuple[Ground, Limits] | None:
    """The ground, save markers that stand still, and the limits seen without it; None where nothing stands out then."""
    field = numbers * 0
    if source.v_offset(0) != source.v_offset(1):  # as many frames of the other field
        numbers = np.unique(np.concatenate([numbers // 2 * 2, numbers // 2 * 2 + 1]))
        numbers, images = spread_at(source, numbers[numbers < source.n_frames])
        field = numbers % 2
    white = white_level(images) if method.inverted else None
    whole = static_ground(images, field, white=white)
    spots = _spots(whole.under(images, numbers), method)
    ground = that_flickers(uncovered(whole, images, field, spots), spots.contrast)
    seen = ground.under(images, numbers)
    if hides_ground(ground, seen, field, spots):
        ground = before_dark(ground, images, field, spots)
        seen = ground.under(images, numbers)
    found = _measured_limits(seen, inverted=method.inverted, least=FAINT)
    if found is None and not sure:
        return None
    return ground, found or learned_limits(seen, inverted=method.inverted)


def _spots(images: GreyLevels, method: Centroids) -> Spots:
    """What still markers look like beside those that move in images without all ground; where none does, by noise."""
    ground, variance = background(images)
    proposed = measured(images, inverted=method.inverted)
    if proposed is None:
        far = STANDS_OUT * float(np.sqrt(np.median(variance)))
        return Spots(far, USUAL.max_area, USUAL.max_aspect, float(np.median(ground)) + 2 * far)
    said, sizes, gap = proposed
    contrast = abs(said.threshold * grey_scale(images.dtype) - float(np.median(ground)))
    contrast = max(contrast, FAINT * (gap.peak - gap.background))
    return Spots(contrast, STILL * sizes.greatest, max(said.max_aspect, USUAL.max_aspect), gap.peak)


def _from_ground(threshold: float | None, ground: Ground | None, images: GreyLevels) -> float | None:
    """A stated threshold, which counts from the ground where that is subtracted, in the images without it."""
    if threshold is None or ground is None:
        return threshold
    scale = grey_scale(images.dtype)
    level = (ground.white - ground.level) / scale - threshold if ground.white else ground.level / scale + threshold
    return float(np.clip(level, 0, 254.99))


def _consistent(own: dict[str, Any], open_ones: dict[str, Any]) -> dict[str, Any]:
    """The learned values, areas no nearer than what is stated of the other limit."""
    if "min_area" in open_ones and own["max_area"] is not None:
        open_ones["min_area"] = min(open_ones["min_area"], own["max_area"])
    if "max_area" in open_ones and own["min_area"] is not None:
        open_ones["max_area"] = max(open_ones["max_area"], own["min_area"])
    return open_ones


def learned_limits(images: GreyLevels, *, inverted: bool = False) -> Limits:
    """Threshold and limits of size that frames (n, H, W) of one camera show."""
    found = _measured_limits(images, inverted=inverted)
    return found or USUAL._replace(threshold=_usual_threshold(images, *background(images), inverted))


def _measured_limits(images: GreyLevels, *, inverted: bool, least: float = 0.0) -> Limits | None:
    """The same; None where no marker is seen."""
    ground, variance = background(images)
    brightest = images.min((1, 2)) if inverted else images.max((1, 2))
    out = (ground - brightest if inverted else brightest - ground) > STANDS_OUT * np.sqrt(variance)
    proposed = measured(images if out.all() else images[out], inverted=inverted) if out.any() else None
    if proposed is None:
        return None
    said, sizes, gap = proposed
    faint = gap.background + least * (gap.peak - gap.background)
    said = said._replace(threshold=_beyond(said.threshold, faint, images, inverted))
    usual = USUAL.threshold * white_level(images) / 255
    end = gap.background + ABOVE * (gap.high - gap.background)
    if not inverted and max(gap.low, gap.clear, faint) <= usual < min(end, gap.threshold / NEAR):
        said = said._replace(threshold=usual / grey_scale(images.dtype))
    return _wide(said, sizes)


def _beyond(threshold: float, least: float, images: GreyLevels, inverted: bool) -> float:
    """A threshold of 8 bits no nearer the ground than a level of the images, of their negative where inverted."""
    scale = grey_scale(images.dtype)
    return min(threshold, (white_level(images) - least) / scale) if inverted else max(threshold, float(least) / scale)


def _wide(said: Limits, sizes: Sizes) -> Limits:
    """The threshold, and limits by (1) and (2)."""
    lamps = sizes.strobe_frames >= OFTEN
    most = max(sizes.high, NEARER * sizes.greatest) if lamps else max(sizes.high, USUAL.max_area)  # (2), (1)
    return Limits(
        said.threshold,
        min(said.min_area, USUAL.min_area),
        int(np.ceil(most)),
        min(said.min_width, USUAL.min_width),
        max(said.max_aspect, USUAL.max_aspect),
    )


def _usual_threshold(
    images: GreyLevels, ground: NDArray[np.float64], variance: NDArray[np.float64], inverted: bool
) -> float:
    """(3), in grey levels of 8 bits."""
    white = white_level(images)
    share = USUAL.threshold * white / 255
    b, far = float(np.median(ground)), STANDS_OUT * float(np.sqrt(np.median(variance)))
    level = b - max(far, share / 2) if inverted else max(share, b + max(far, share / 2))
    return float(np.clip(level / grey_scale(images.dtype), 0, 254.99))
