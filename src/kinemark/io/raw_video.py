"""Uncompressed grey video, read from where its frames lie in the file, many by one call.

A decoder reads each frame into memory of its own, from which it is copied to the others of a batch. Yet the frames of
uncompressed video are in the file as they are, with a few bytes of the container between. So many are read by one
call: each into its place in the batch, and what is between into memory beside. The next frame is expected as far from
a frame as that is from the one before; what is between tells whether it is there. Where it is not, the elements of the
container are followed to it, and fewer are read the next time.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import av
import numpy as np

from .batch_memory import batch_memory
from .pixels import Image, grey
from .video import VideoInfo, opened, video_stream

HEAD = 32  # bytes that hold the beginning of any element of a container; of the formats
ELEMENTS = 64
"""Of a container between two frames at most; chosen: Matroska has five, and AVI some more where a gigabyte ends."""
GAP = 256  # bytes between frames that are expected again; chosen: more is an index, which comes seldom
AT_ONCE = 500  # frames that are read by one call at most, as the system takes 1024 parts; by definition


class Element(NamedTuple):
    """Of a container: bytes from its begin to its content, and to the next element; and whose frame it is, if any."""

    content: int
    end: int
    owner: bytes = b""


class Layout(NamedTuple):
    """How a container has its frames.

    element: what the first bytes of an element say. owner: whose a frame is by the 8 bytes before it. block: bytes from
    where the demuxer says that a frame is to its pixels. align: elements begin at multiples of so many bytes.
    """

    element: Callable[[bytes], Element]
    owner: Callable[[bytes], bytes]
    block: int
    align: int


def raw_batches(path: Path, info: VideoInfo, n: int) -> Iterator[Image]:
    """The frames of a video, at most n at a time (n, H, W), as far as they are uncompressed and found in the file.

    There are none of any other video, and too few where something is wrong: a decoder says what that is.
    """
    if not hasattr(os, "preadv") or (found := _first_frame(path)) is None:
        return
    width, height = info.size
    memory = batch_memory(n * width * height)
    with suppress(OSError), path.open("rb", buffering=0) as file:
        reader = _Reader(file.fileno(), *found, width * height)
        for done in range(0, info.n_frames, n):
            images = memory.batch((min(n, info.n_frames - done), height, width), np.dtype(np.uint8))
            last = done + len(images) == info.n_frames
            if reader.fill(images) < len(images) or (last and reader.start is not None):
                return
            yield images


def _first_frame(path: Path) -> tuple[Layout, int] | None:
    """The container's layout, and where the first frame begins; None where it is not in the file as it is shown."""
    try:
        with opened(path) as container, path.open("rb") as file:
            codec = video_stream(path, container).codec_context
            layout = next((way for name, way in LAYOUTS.items() if name in container.format.name), None)
            if layout is None or codec.name != "rawvideo" or codec.pix_fmt != "gray" or codec.extradata:
                return None
            packet = next(container.demux(video_stream(path, container)))
            shown = [grey(frame, str(path)).tobytes() for frame in packet.decode()]
            start = max(packet.pos or 0, 0) + layout.block
            file.seek(start)
            return (layout, start) if shown == [file.read(packet.size)] else None
    except (av.FFmpegError, OSError):
        return None


class _Reader:
    """Where reading stands in a file: at `start` of the next frame, None where there is none."""

    def __init__(self, file: int, layout: Layout, start: int, size: int) -> None:
        """At the first frame, of frames of this size in bytes."""
        self.file, self.layout, self.size = file, layout, size
        self.start: int | None = start
        self.owner = layout.owner(os.pread(file, 8, start - 8))
        self.gap, self.ahead = 0, 1

    def fill(self, images: Image) -> int:
        """Read the next frames; how many there were."""
        found = 0
        while found < len(images) and self.start is not None:
            found += self._run(images[found : found + self.ahead], self.start)
        return found

    def _run(self, images: Image, start: int) -> int:
        """Read frames that are as far from each other as expected, at least one where it is there."""
        gaps = np.zeros((len(images), self.gap), np.uint8)
        step = self.size + self.gap
        parts: list[Any] = [part for pair in zip(images, gaps, strict=True) for part in pair]
        read = os.preadv(self.file, parts, start)
        for k, gap in enumerate(gaps):
            end = start + k * step + self.size
            if start + read < end:
                self.start = None
                return k
            if self._after(0, gap.tobytes()) != self.gap:
                self.start, self.ahead = self._after(end), 1
                self.gap = self.start - end if self.start and self.start - end <= GAP else self.gap
                return k + 1
        self.start, self.ahead = start + len(images) * step, min(2 * self.ahead, AT_ONCE)
        return len(images)

    def _after(self, end: int, known: bytes | None = None) -> int | None:
        """Where the next frame begins after the end of one, in the file or in these bytes; None where none does."""
        at = end + self.size % self.layout.align
        for _ in range(ELEMENTS):
            head = os.pread(self.file, HEAD, at) if known is None else known[at : at + HEAD]
            if not head:
                return None
            element = self.layout.element(head.ljust(HEAD, b"\0"))
            if element.owner == self.owner:  # of another size it is a frame that is for a decoder
                return at + element.content if element.end - element.content == self.size else None
            at += element.end + element.end % self.layout.align
        return None


def _chunk(head: bytes) -> Element:
    """Of AVI: lists are entered, other chunks are passed over."""
    size = int.from_bytes(head[4:8], "little")
    return Element(12, 12) if head[:4] in (b"RIFF", b"LIST") else Element(8, 8 + size, head[:2])


def _ebml(head: bytes) -> Element:
    """Of Matroska: clusters and groups of blocks are entered, all else is passed over."""
    name = 9 - head[0].bit_length()
    digits = 9 - head[name].bit_length()
    content = name + digits
    size = int.from_bytes(head[name:content], "big") & ((1 << 7 * min(digits, 8)) - 1)
    if head[:name] in (b"\x1f\x43\xb6\x75", b"\xa0"):
        return Element(content, content)
    if head[:name] not in (b"\xa3", b"\xa1"):
        return Element(content, content + size)
    laced = head[content + 3] & 6 != 0  # then the number of frames follows the track, the time and these flags
    return Element(content + 4 + laced, content + size, head[content : content + 1])


LAYOUTS = {
    "matroska": Layout(_ebml, lambda before: before[4:5], 4, 1),
    "avi": Layout(_chunk, lambda before: before[:2], 0, 2),
}
