"""A video of small pictures, each a JPEG of its own, written picture by picture: any of them is soon decoded."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import av
import numpy as np

from ..data.array_types import GreyLevels

RATE = 25
"""Pictures a second, of no meaning as they are asked for by number; chosen: the container counts in whole ms."""
COARSENESS = 5
"""Of the pictures, from 2 (finest) to 31; chosen, as that of one picture."""


class SmallVideo:
    """Written beside its place and put there when it is finished; where it cannot be written, there is none."""

    def __init__(self, path: Path, width: int, height: int, *, most: int) -> None:
        """Nothing is written before the first picture; there is no video where it would have more than `most` bytes."""
        self.path, self.size, self.most = path, (width, height), most
        self._beside = path.with_name(f".{path.name}.part")
        self._container: Any = None
        self._bytes = 0
        self._over = False

    def add(self, pictures: Iterable[GreyLevels]) -> None:
        """More pictures (height, width); they are not looked at where there will be no video."""
        if self._over:
            return
        try:
            for picture in pictures:
                self._write(picture)
        except (OSError, av.FFmpegError):
            self.drop()
        if self._bytes > self.most:
            self.drop()

    def finish(self) -> None:
        """All pictures were given."""
        if self._over or self._container is None:
            return
        try:
            self._mux(None)
            self._container.close()
            self._beside.replace(self.path)
        except (OSError, av.FFmpegError):
            self.drop()
        self._over = True

    def drop(self) -> None:
        """There is no video, unless it is finished; nothing else is left of it."""
        if self._over:
            return
        self._over = True
        with suppress(OSError, av.FFmpegError):
            if self._container is not None:
                self._container.close()
        with suppress(OSError):
            self._beside.unlink(missing_ok=True)

    def _write(self, picture: GreyLevels) -> None:
        if self._container is None:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._container = av.open(str(self._beside), "w", format="matroska")
            self._stream = self._container.add_stream("mjpeg", rate=RATE)
            self._stream.width, self._stream.height = self.size
            self._stream.pix_fmt = "yuvj420p"
            self._stream.codec_context.options = {"qmin": str(COARSENESS), "qmax": str(COARSENESS)}
        pixels: Any = np.ascontiguousarray(picture)
        self._mux(av.VideoFrame.from_ndarray(pixels, format="gray").reformat(format="yuvj420p"))

    def _mux(self, frame: av.VideoFrame | None) -> None:
        for packet in self._stream.encode(frame):
            self._bytes += packet.size
            self._container.mux(packet)
