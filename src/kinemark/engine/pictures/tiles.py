"""Where each camera's image is in a mosaic, how it becomes so small, and what tells one recording from another."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...data.array_types import GreyLevels
from ...io.images import ImageSource, scaled
from ...io.pixels import Image
from ..keys import digest, file_key

WIDTHS = (960, 640, 480, 400)
"""px, of a tile where there are 1, 2, 3 or 4 cameras; chosen: what fits beside the rest on a screen of 1366 px."""
MANY = 320
"""px, of a tile where there are more; chosen, as above."""


class Tile(NamedTuple):
    """Where a camera's image is in the mosaic, px."""

    camera: str
    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True, slots=True)
class Layout:
    """Tiles in rows, and the size of the whole, px; both even."""

    tiles: tuple[Tile, ...]
    width: int
    height: int


def layout_of(sources: Mapping[str, ImageSource]) -> Layout:
    """Tiles of one size for all cameras, each with its image as large as fits; fields have their true height."""
    n = len(sources)
    columns = math.ceil(math.sqrt(n))
    largest = WIDTHS[n - 1] if n <= len(WIDTHS) else MANY
    cell_w = _even(min(largest, max(source.size[0] for source in sources.values())))
    shapes = {name: _fitted(source, cell_w) for name, source in sources.items()}
    cell_h = max(height for _, height in shapes.values())
    tiles = [
        Tile(name, k % columns * cell_w, k // columns * cell_h, *shape)
        for k, (name, shape) in enumerate(shapes.items())
    ]
    return Layout(tuple(tiles), columns * cell_w, math.ceil(n / columns) * cell_h)


def _fitted(source: ImageSource, width: int) -> tuple[int, int]:
    """Width and height of a tile."""
    w, h = source.size[0], source.size[1] * (2 if source.interlaced else 1)
    width = _even(min(width, w))
    return width, max(_even(round(width * h / w)), 2)


def _even(n: int) -> int:
    return max(n - n % 2, 2)


def recording_key(sources: Mapping[str, ImageSource]) -> str:
    """Changes with the images of any camera, and with which of them are taken."""
    files = [path for source in sources.values() for path in source.paths]
    taken = [(source.interlaced, source.every) for source in sources.values()]
    return digest(file_key(*files), list(sources), taken)


class Smaller:
    """Images of one camera, made as small as its tile."""

    def __init__(self, tile: Tile) -> None:
        """Which of its bits a camera uses is not known yet."""
        self.tile = tile
        self._shift = 0

    def in_eight_bits(self, image: Image) -> GreyLevels:
        """(H, W) uint8: the bits that a camera uses, by the brightest image that was seen of it."""
        if image.dtype == np.uint8:
            return image
        self._shift = max(int(image.max()).bit_length() - 8, self._shift)
        return (image >> self._shift).clip(0, 255).astype(np.uint8)

    def __call__(self, image: Image) -> Image:
        """(height, width) uint8, of the tile."""
        return scaled(self.in_eight_bits(image), self.tile.width, self.tile.height)
