"""The images of all cameras in one frame, side by side in one small picture: a mosaic; made once and kept.

A page that shows eight cameras at a frame asks for one file instead of eight, always by the frame's number; and for a
part of one camera's image in its own pixels where somebody looks closer than a mosaic shows.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

import numpy as np

from ...data import KinemarkError
from ...data.progress import Cancelled
from ...io.exact_frames import ExactImages
from ...io.files import replacing
from ...io.images import ImageSource, jpeg_bytes, png_bytes
from ...io.pixels import Image
from .small_videos import SmallImages
from .tiles import Smaller, Tile, layout_of

Name = TypeVar("Name")


class KeptFiles:
    """Contents by name that can be made again, up to so many bytes: those that were not used for longest go.

    They are in memory where the folder cannot be written. For any number of threads.
    """

    def __init__(self, folder: Path, *, most: int, most_in_memory: int) -> None:
        """Nothing is read yet; `most` and `most_in_memory` in bytes."""
        self.folder, self.most, self.most_in_memory = folder, most, most_in_memory
        self._lock = threading.Lock()
        self._sizes: dict[Path, int] | None = None  # of the files, the longest unused first
        self._memory: dict[str, bytes] = {}

    def get(self, name: str) -> bytes | None:
        """What is kept by this name; None where nothing is."""
        with self._lock:
            if name in self._memory:
                self._memory[name] = self._memory.pop(name)
                return self._memory[name]
            try:
                found = (self.folder / name).read_bytes()
            except OSError:
                return None
            self._used(self.folder / name, len(found))
            return found

    def put(self, name: str, content: bytes) -> None:
        """Keep it, and let go of what is too much."""
        file = self.folder / name
        with self._lock:
            try:
                file.parent.mkdir(parents=True, exist_ok=True)
                with replacing(file) as beside:
                    beside.write_bytes(content)
            except (KinemarkError, OSError):
                self._memory[name] = content
                for old in _too_many({one: len(held) for one, held in self._memory.items()}, self.most_in_memory):
                    del self._memory[old]
                return
            sizes = self._used(file, len(content))
            for unused in _too_many(sizes, self.most):
                del sizes[unused]
                with suppress(OSError):
                    unused.unlink()

    def _used(self, file: Path, size: int) -> dict[Path, int]:
        """The sizes, with this one last."""
        if self._sizes is None:
            there = sorted((found.stat().st_mtime_ns, found, found.stat().st_size) for found in self._files())
            self._sizes = {found: length for _, found, length in there}
        self._sizes.pop(file, None)
        self._sizes[file] = size
        return self._sizes

    def _files(self) -> Iterator[Path]:
        """Those that are there from before."""
        return (found for found in self.folder.rglob("*") if found.is_file())


def _too_many(sizes: dict[Name, int], most: int) -> list[Name]:
    """The first of them that must go for the rest to be as small; never the last."""
    total, names = sum(sizes.values()), list[Name]()
    for name, size in list(sizes.items())[:-1]:
        if total <= most:
            break
        total, names = total - size, [*names, name]
    return names


AHEAD, BACK = 240, 48
"""Frames that are made after the one asked for, and before it in blocks; chosen: some seconds of most recordings to go
on in, half a second to go back in. To decode backwards costs a group of frames each time, so a block is made forwards.
"""
KEPT = 1_000_000_000
"""Bytes of mosaics that are kept on disk for a trial; chosen: 25 000 frames of eight cameras."""
ImageAt = Callable[[str, int], int]
"""By a camera and a frame of the recording, from 0, the number of the image that shows it."""
IN_MEMORY = 20_000_000
"""Bytes that are kept where nothing can be written; chosen: ten seconds of a recording."""
WORKERS = 4
"""Threads that decode cameras side by side; chosen: more than most machines have to spare."""


class Mosaics:
    """The mosaics of one trial's recording."""

    def __init__(
        self,
        sources: Mapping[str, ImageSource],
        folder: Path,
        *,
        recording: str = "",
        most: int = KEPT,
        small: Mapping[str, SmallImages] = MappingProxyType({}),
        image_at: ImageAt = lambda camera, n: n,
    ) -> None:
        """Nothing is opened yet; mosaics are kept in the folder, where it can be written.

        Args:
            sources: by camera. folder: of the mosaics of a trial. recording: tells them from those of what was
                recorded there before. most: bytes that are kept, the longest unused going first. small: by camera,
                pictures that were made of it before. image_at: where cameras took their images at times of their own;
                where there is no image of that number, the tile is black.
        """
        self.sources, self.recording = dict(sources), recording
        self._kept = KeptFiles(folder, most=most, most_in_memory=IN_MEMORY)
        self.layout = layout_of(sources)
        self.n_frames = max(source.n_frames for source in sources.values())
        self._open: dict[str, ExactImages] = {}
        self._locks = {name: threading.Lock() for name in sources}
        self._smaller = {tile.camera: Smaller(tile) for tile in self.layout.tiles}
        self._small, self._image_at = dict(small), image_at
        self._pool = ThreadPoolExecutor(WORKERS, "tiles")
        self._behind = ThreadPoolExecutor(1, "mosaics")
        self._asked: tuple[int, int] | None = None
        self._made = set[int]()
        self._drawn: dict[int, list[Image]] = {}  # the tiles of frames that are no files yet
        self._making = threading.Lock()

    def jpeg(self, n: int) -> bytes:
        """The mosaic of frame n, from 0; those after it, in the direction of asking, are made behind.

        Raises:
            KinemarkError: there is no such frame, or an image is damaged.
        """
        self._check(n)
        before, _ = self._asked or (n, 0)
        self._asked = asked = n, n - before  # from here on nothing more is decoded behind
        found = self._mosaic(n)
        self._behind.submit(self._ahead, asked)
        return found

    def begin(self) -> None:
        """Make the first frames behind, unless a frame was asked for: somebody is about to look at them."""
        if self._asked is None:
            self._asked = asked = -1, 1
            self._behind.submit(self._ahead, asked)

    def ready(self, n: int) -> bytes | None:
        """The same where it was made already; nothing is decoded for it."""
        return self._encoded(n) or self._kept.get(self._name(n))

    def crop(self, camera: str, n: int, x: int, y: int, width: int, height: int) -> bytes:
        """A part of one camera's image as PNG, in its own pixels.

        Raises:
            KinemarkError: there is no such camera, frame or part.
        """
        if camera not in self.sources:
            raise KinemarkError(f"There is no camera {camera}; there are {', '.join(self.sources)}.")
        w, h = self.sources[camera].size
        if not (0 <= x < x + width <= w and 0 <= y < y + height <= h):
            raise KinemarkError(f"{camera} has {w} × {h} px; {width} × {height} from ({x}, {y}) is no part of that.")
        self._check(n)
        image = self._image(camera, self._image_at(camera, n))
        shown = self._smaller[camera].in_eight_bits(image)
        return png_bytes(np.ascontiguousarray(shown[y : y + height, x : x + width]))

    def _check(self, n: int) -> None:
        if not 0 <= n < self.n_frames:
            raise KinemarkError(f"There are frames 1 to {self.n_frames}, and {n + 1} was asked for.")

    def close(self) -> None:
        """Nothing more is asked."""
        self._asked = -1, 0
        self._behind.shutdown(cancel_futures=True)
        self._pool.shutdown()
        for images in self._open.values():
            images.close()
        for small in self._small.values():
            small.close()

    def _mosaic(self, n: int, go_on: Callable[[], None] = lambda: None) -> bytes:
        """Kept, or made now, unless `go_on` raises."""
        found = self.ready(n)
        if found is None:
            with self._making:  # by turns, or each would lead the decoders away from where the other needs them
                found = self.ready(n) or self._made_now(n, go_on)
        self._made.add(n)
        return found

    def _made_now(self, n: int, go_on: Callable[[], None]) -> bytes:
        """And those that are decoded on the way to it, which are encoded behind."""
        first = self._start(n)
        new = [k for k in range(first, n + 1) if k == n or not (k in self._made or k in self._drawn)]
        by_camera = self._pool.map(lambda tile: self._tiles(tile, new, go_on), self.layout.tiles)
        frames = list(zip(*by_camera, strict=True))
        content = self._kept_as_file(n, list(frames.pop()))
        self._drawn.update((k, list(small)) for k, small in zip(new, frames, strict=False))
        return content

    def _encoded(self, n: int) -> bytes | None:
        """The file of a frame that was drawn; None where it was not."""
        small = self._drawn.get(n)
        if small is None:
            return None
        content = self._kept_as_file(n, small)
        self._drawn.pop(n, None)
        return content

    def _kept_as_file(self, n: int, small: list[Image]) -> bytes:
        content = jpeg_bytes(self._side_by_side(small))
        self._kept.put(self._name(n), content)
        self._made.add(n)
        return content

    def _start(self, n: int) -> int:
        """The first of the frames before frame n that are decoded for it anyway: they are kept as well."""
        back = self._pool.map(lambda camera: self._images_before(camera, self._image_at(camera, n)), self.sources)
        return max(n - max(back, default=0), n - BACK, 0)

    def _images_before(self, camera: str, n: int) -> int:
        """How many images are decoded for image n before it."""
        return n - self._decoded_from(camera, n)

    def _decoded_from(self, camera: str, n: int) -> int:
        """The first image that is decoded for image n."""
        if not 0 <= n < self.sources[camera].n_frames:
            return n
        if (small := self._small.get(camera)) is not None and n in small.frames:
            return n
        with self._locks[camera]:
            return self._images(camera).decoded_from(n)

    def _name(self, n: int) -> str:
        return str(Path(self.recording) / f"{n:07d}.jpg")

    def _ahead(self, asked: tuple[int, int]) -> None:
        """Frames about the one that was asked for, until another one is: then not one image more is decoded."""
        for k in list(self._drawn):
            self._encoded(k)

        def go_on() -> None:
            if self._asked != asked:
                raise Cancelled

        with suppress(KinemarkError, Cancelled):  # whoever asks for the damaged frame is told
            for k in _about(*asked, self.n_frames):
                go_on()
                if k not in self._made:
                    self._mosaic(k, go_on)

    def _side_by_side(self, small: list[Image]) -> Image:
        """(H, W) uint8."""
        whole = np.zeros((self.layout.height, self.layout.width), np.uint8)
        for tile, image in zip(self.layout.tiles, small, strict=True):
            whole[tile.y : tile.y + tile.height, tile.x : tile.x + tile.width] = image
        return whole

    def _tiles(self, tile: Tile, wanted: list[int], go_on: Callable[[], None]) -> list[Image]:
        """A camera's images of some frames, rising, small: one image is decoded after the other, while it may go on."""
        found = []
        for k in (self._image_at(tile.camera, frame) for frame in wanted):
            for before in range(self._decoded_from(tile.camera, k), k):
                go_on()
                self._image(tile.camera, before)
            go_on()
            found.append(self._small_image(tile.camera, k))
        return found

    def _small_image(self, camera: str, n: int) -> Image:
        if (small := self._small.get(camera)) is not None and n in small.frames:
            try:
                with self._locks[camera]:
                    return small.frame(n).copy()
            except KinemarkError:
                self._small.pop(camera, None)  # damaged: made again of the images
        return self._smaller[camera](self._image(camera, n))

    def _image(self, camera: str, n: int) -> Image:
        """Image n of a camera, black where it took none."""
        source = self.sources[camera]
        if not 0 <= n < source.n_frames:
            return np.zeros(source.size[::-1], np.uint8)
        with self._locks[camera]:
            return self._images(camera).frame(n).copy()  # the decoder's own memory otherwise

    def _images(self, camera: str) -> ExactImages:
        if camera not in self._open:
            self._open[camera] = ExactImages(self.sources[camera])
        return self._open[camera]


def _about(n: int, step: int, n_frames: int) -> Iterator[int]:
    """The frames beside frame n, those in the direction of the step first, each run of them rising."""
    block = n - n % BACK
    before = [range(max(block, 0), n), range(max(block - BACK, 0), block)]
    after = [range(n + 1, min(n + AHEAD, n_frames))]
    return chain.from_iterable(before + after if step < 0 else after + before)
