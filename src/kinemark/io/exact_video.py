"""Frames of a video by their numbers, exactly those that decoding it from its start would give.

A container says when a frame is shown, rounded, and players seek by that: they are off by a frame where rates are odd,
times are uneven, or a part is cut off by an edit list. Here the packets are listed once; sorted by time, their order is
the number of a frame, and a frame is found by decoding from the last key frame that is shown before it until the one
with its very time comes. Where the packets do not say it so, frames are counted from the start.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

import av
import numpy as np

from ..data import KinemarkError
from ..data.array_types import Ints
from .pixels import Image, check_pixels, grey
from .video import VideoInfo, decode_video, opened, stored_times, video_stream

CHECKED = 100
"""Frames that are decoded to see whether times are true, where a container has none of its own for each frame; chosen:
several groups of reordered frames."""
TIMED = ("matroska", "mov", "mp4")
"""Containers that say when each packet is shown; others have times that FFmpeg works out, and may be mistaken in."""


RECENT = 8
"""Decoded frames of a video that are kept, so that stepping back decodes a group of frames once in so many steps;
chosen: 10 MB of a camera of 1280 × 1024 px."""


class FrameIndex(NamedTuple):
    """When each frame is shown, in units of the stream, rising; and the numbers of the key frames, rising."""

    time: Ints
    key: Ints


def frame_index(path: Path, info: VideoInfo) -> FrameIndex | None:
    """The index of a video; None where its packets are not one a frame, each with a time of its own."""
    times, keys = [], []
    with opened(path) as container:
        if (stored := stored_times(path, container)) is not None and len(stored) == info.n_frames:
            return FrameIndex(stored, np.arange(len(stored)))
    with opened(path) as container:
        for packet in container.demux(video_stream(path, container)):
            if not packet.size or packet.is_discard:
                continue
            if packet.pts is None:
                return None
            times.append(packet.pts)
            keys += [packet.pts] if packet.is_keyframe else []
    time = np.unique(np.array(times, np.int64))
    if len(time) != len(times) or len(time) != info.n_frames or not keys or min(keys) != time[0]:
        return None
    return FrameIndex(time, np.searchsorted(time, np.unique(keys))) if _true(path, time) else None


def _true(path: Path, time: Ints) -> bool:
    """Whether the first frames come out of the decoder at these times."""
    with opened(path) as container:
        if any(name in container.format.name for name in TIMED):
            return True
        frames = islice(container.decode(video_stream(path, container)), CHECKED)
        return [frame.pts for frame in frames] == time[:CHECKED].tolist()


class ExactVideo:
    """A video that stays open; not for two threads at once."""

    def __init__(self, path: Path, info: VideoInfo) -> None:
        """Raises a KinemarkError where it cannot be read."""
        self.path, self.info = path, info
        self._next = 0  # number of the frame that decoding gives next; −1 where that is not known
        self._recent: dict[int, av.VideoFrame] = {}
        try:
            self.index = frame_index(path, info)
            self._container = opened(path)
            self._start()
        except av.FFmpegError as error:
            raise self._damaged(error) from error

    def frame(self, n: int) -> Image:
        """Frame n, from 0: (H, W), uint8 or uint16.

        Raises:
            KinemarkError: there is none, or it is damaged.
        """
        if not 0 <= n < self.info.n_frames:
            raise KinemarkError(f"{self.path.name} has frames 0 to {self.info.n_frames - 1}, and {n} was asked for.")
        try:
            found = self._counted(n) if self.index is None else self._sought(self.index, n)
        except av.FFmpegError as error:
            raise self._damaged(error) from error
        if found is None and self.index is not None:  # the decoder left out what the packets promise
            self.index = None
            self._restart()
            return self.frame(n)
        if found is None:
            raise KinemarkError(f"{self.path} ends before frame {n + 1}: it is truncated. Copy it again.")
        check_pixels(str(self.path), found.width, found.height)
        return grey(found, str(self.path))

    def decoded_from(self, n: int) -> int:
        """The first of the frames that have to be decoded for frame n; n itself where it is among the recent ones."""
        if n in self._recent:
            return n
        start = 0 if self.index is None else int(self.index.key[np.searchsorted(self.index.key, n, side="right") - 1])
        return self._next if start <= self._next <= n else start

    def close(self) -> None:
        """It is not asked again."""
        self._container.close()

    def __enter__(self) -> ExactVideo:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _sought(self, index: FrameIndex, n: int) -> av.VideoFrame | None:
        """By its time; decoding goes on where that leads to it sooner than a key frame does."""
        if n in self._recent:
            return self._recent[n]
        key = int(index.key[np.searchsorted(index.key, n, side="right") - 1])
        if not key <= self._next <= n:
            self._container.seek(int(index.time[key]), stream=self._stream)
            self._frames = self._decoded()
        wanted = int(index.time[n])
        for frame in self._frames:
            if frame.pts is None or frame.pts > wanted:
                return self._again_from_key(index, n, key)
            number = int(np.searchsorted(index.time, frame.pts))
            if index.time[number] == frame.pts:
                self._keep(number, frame)
            if frame.pts == wanted:
                self._next = n + 1
                return frame
        return None

    def _keep(self, number: int, frame: av.VideoFrame) -> None:
        """Among the recent ones, by its number."""
        self._recent[number] = frame
        while len(self._recent) > RECENT:
            del self._recent[next(iter(self._recent))]

    def _again_from_key(self, index: FrameIndex, n: int, key: int) -> av.VideoFrame | None:
        """Seeking went too far: from one key frame earlier, then by counting."""
        before = index.key[index.key < key]
        self._next = -1
        for start in [int(before[-1])] if len(before) else []:
            self._container.seek(int(index.time[start]), stream=self._stream)
            self._frames = self._decoded()
            for frame in self._frames:
                if frame.pts == index.time[n]:
                    self._next = n + 1
                    return frame
        return None

    def _counted(self, n: int) -> av.VideoFrame | None:
        """By counting from the start, or from where decoding stands."""
        if n in self._recent:
            return self._recent[n]
        if self._next > n:
            self._restart()
        for frame in self._frames:
            self._keep(self._next, frame)
            self._next += 1
            if self._next == n + 1:
                return frame
        return None

    def _decoded(self) -> Iterator[av.VideoFrame]:
        return self._container.decode(self._stream)

    def _start(self) -> None:
        """At the first frame."""
        self._stream = video_stream(self.path, self._container)
        self._stream.thread_type = "SLICE"  # threads by frames would decode many after each one that is wanted
        self._frames, self._next = self._decoded(), 0
        self._recent.clear()

    def _restart(self) -> None:
        self._container.close()
        self._container = opened(self.path)
        self._start()

    def _damaged(self, error: Exception) -> KinemarkError:
        return KinemarkError(f"{self.path} is damaged ({error}). Copy it again.")


def frames_at(path: Path, info: VideoInfo, wanted: Sequence[int]) -> list[Image]:
    """Some frames of a video, of these rising numbers.

    Raises:
        KinemarkError: as `decode_video`, which is asked where a frame has another size.
    """
    with ExactVideo(path, info) as video:
        found = [video.frame(n) for n in wanted]
    if all(image.shape == info.size[::-1] for image in found):
        return found
    numbers = set(wanted)
    return [image for n, image in enumerate(decode_video(path, info)) if n in numbers]


def key_frames_near(path: Path, info: VideoInfo, wanted: Sequence[int]) -> dict[int, Image]:
    """Number → frame: for each wanted number the last key frame up to it; none where times do not tell which they are.

    To decode frame n of a compressed video takes all frames from such a key frame on: these cost one frame each.
    """
    with ExactVideo(path, info) as video:
        if video.index is None:
            return {}
        key = video.index.key
        numbers = np.unique(key[np.searchsorted(key, np.asarray(wanted), side="right") - 1]).tolist()
        found = {n: video.frame(n) for n in numbers}
    return {n: image for n, image in found.items() if image.shape == info.size[::-1]}
