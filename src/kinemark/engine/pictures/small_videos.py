"""Small pictures of a recording, made while its images are decoded for detection anyway.

Most compressed videos have few key frames: to show one frame of one camera, all frames from a key frame on must be
decoded. So much is not waited for where a video of small pictures lies beside the results. It is made of such videos
alone; of others, an image is as soon decoded as a small picture, and making these would cost as much as detection.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from contextlib import suppress
from glob import escape
from pathlib import Path
from typing import Protocol

from ...data import KinemarkError
from ...data.array_types import Ints
from ...detect.frame_source import FrameSource, RandomAccess
from ...io.exact_frames import ExactImages
from ...io.images import ImageSource, open_images
from ...io.pixels import Image
from ...io.small_video import SmallVideo
from ...io.video import has_dependent_frames
from .tiles import Smaller, layout_of, recording_key

FOLDER = "small_videos"
"""In a trial's folder of results."""
MOST = 500_000_000
"""Bytes of the small videos of a trial; chosen: 10 000 frames of eight cameras have half of it."""


class CameraFrames(FrameSource, RandomAccess, Protocol):
    """Frames in order, and single ones."""


class Watched:
    """What one camera recorded; while all of it is read in order, a small video is made of it."""

    def __init__(self, source: CameraFrames, small: Smaller, path: Path, *, most: int) -> None:
        """The small video is put at a path, unless it would have more than `most` bytes."""
        self.source, self.small, self.path, self.most = source, small, path, most

    @property
    def n_frames(self) -> int:
        """F."""
        return self.source.n_frames

    def batches(self, n: int) -> Iterator[Image]:
        """The frames in order, at most n at a time (n, H, W)."""
        video = SmallVideo(self.path, self.small.tile.width, self.small.tile.height, most=self.most)
        try:
            for images in self.source.batches(n):
                video.add(self.small(image) for image in images)
                yield images
            video.finish()
        finally:
            video.drop()  # what is finished stays

    def frames_at(self, wanted: Ints) -> Image:
        """Frames (n, H, W) of these rising numbers."""
        return self.source.frames_at(wanted)

    def frames_near(self, wanted: Ints) -> tuple[Ints, Image]:
        """Numbers (n) of frames near these rising ones, and the frames."""
        return self.source.frames_near(wanted)

    def v_offset(self, f: int) -> float:
        """What to add to v in frame f, px."""
        return self.source.v_offset(f)


def watched(
    images: Mapping[str, ImageSource], taken: Mapping[str, CameraFrames], first: int, results: Path, *, most: int = MOST
) -> list[CameraFrames]:
    """What is to be read of each camera, watched where single frames of it cost many.

    Args:
        images: of each camera, the whole recording; taken: what is read of it, which begins at frame `first`, from 0.
        results: folder of the trial's results; small videos of other recordings go from it. most: bytes of them all.
    """
    dependent = [name for name, source in images.items() if source.video and has_dependent_frames(source.paths[0])]
    folder = results / FOLDER / recording_key(images)
    with suppress(OSError):
        for other in [path for path in folder.parent.iterdir() if path != folder]:
            shutil.rmtree(other, ignore_errors=True)
    tiles = {tile.camera: tile for tile in layout_of(images).tiles}
    found = dict(taken)
    for name in dependent:
        path = folder / f"{name}_{first}.mkv"
        found[name] = Watched(taken[name], Smaller(tiles[name]), path, most=most // len(dependent))
    return list(found.values())


class SmallImages:
    """Small pictures of one camera that were made while its images were detected in; not for two threads at once."""

    def __init__(self, source: ImageSource, first: int) -> None:
        """Raises a KinemarkError where the video, of which the first picture is of frame `first`, cannot be read."""
        self.frames = range(first, first + source.n_frames)
        self._images = ExactImages(source)

    def frame(self, n: int) -> Image:
        """That of frame n, one of `frames`; raises a KinemarkError where it is damaged."""
        return self._images.frame(n - self.frames.start)

    def close(self) -> None:
        """Nothing more is asked."""
        self._images.close()


def small_images(images: Mapping[str, ImageSource], results: Path) -> dict[str, SmallImages]:
    """Those of each camera that has any; of several stretches the longest, as the latest may be a short trial run."""
    folder, found = results / FOLDER / recording_key(images), dict[str, SmallImages]()
    for tile in layout_of(images).tiles:
        readable = {}
        for path in folder.glob(f"{escape(tile.camera)}_*.mkv"):
            first = path.stem.removeprefix(f"{tile.camera}_")
            with suppress(KinemarkError):
                source = open_images(path)
                if first.isdecimal() and source.size == (tile.width, tile.height):
                    readable[int(first)] = source
        if readable:
            first_of_longest = max(readable, key=lambda first: readable[first].n_frames)
            with suppress(KinemarkError):
                found[tile.camera] = SmallImages(readable[first_of_longest], first_of_longest)
    return found
