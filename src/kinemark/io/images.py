"""The images of one camera as a source of grey frames: a sequence of files, a video or a single image.

An interlaced frame holds two fields taken one after the other: its rows 0, 2, … (top) and 1, 3, … (bottom). Each
becomes a frame of half the height. Line k of a top field is row 2k, line k of a bottom field row 2k + 1 = 2 (k + ½), so
a point at v in a bottom field lies at v + ½ in the lines of the top field: that ½ is `v_offset`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from fractions import Fraction
from itertools import islice, pairwise
from pathlib import Path
from typing import Any, Literal

import av
import numpy as np

from ..data import KinemarkError
from ..data.array_types import Ints
from .batch_memory import batch_memory
from .exact_video import frames_at, key_frames_near
from .files import read_bytes, replacing
from .pixels import MOST_PIXELS, Image, check_pixels, grey, plane
from .raw_video import raw_batches
from .video import VideoInfo, decode_video, probe_video

Interlaced = Literal[False, "top", "bottom"]
MAGIC = (
    (b"\x89PNG\r\n\x1a\n", "png"),
    (b"II*\0", "tiff"),
    (b"MM\0*", "tiff"),
    (b"\xff\xd8\xff", "mjpeg"),
    (b"BM", "bmp"),
    (b"P1", "pbm"),
    (b"P2", "pgm"),
    (b"P3", "ppm"),
    (b"P4", "pbm"),
    (b"P5", "pgm"),
    (b"P6", "ppm"),
)
BATCH_BYTES = 24 << 20
"""Of frames that are given together, so that those of large images take no more memory; chosen for that."""
COARSENESS = "5"
"""Of the quantiser of JPEG, from 2, the finest, to 31; chosen."""
NUMBER = re.compile(r"%(0\d+)?d")


@dataclass(frozen=True, slots=True)
class ImageSource:
    """The frames of one camera.

    Attributes:
        paths: the image files in order, or the one video.
        size: width and height of a frame, px; of a field where interlaced.
        n_frames: how many frames there are; two an image where interlaced.
        rate: Hz; None for image files, which do not say it.
        interlaced: which field comes first, "top" or "bottom"; False for whole frames.
        video: what the video says of itself; None for image files.
        every: one frame, or field, of so many is taken; numbers of frames, `n_frames` and `rate` are of those.
    """

    paths: tuple[Path, ...]
    size: tuple[int, int]
    n_frames: int
    rate: float | None
    interlaced: Interlaced = False
    video: VideoInfo | None = None
    every: int = 1

    def __len__(self) -> int:
        return self.n_frames

    def __iter__(self) -> Iterator[Image]:
        return self.frames()

    def v_offset(self, f: int) -> float:
        """What to add to v in frame f so that both fields share one image plane: 0, or 0.5 px (field lines)."""
        field = f * self.every % 2
        bottom = (field == 0) if self.interlaced == "bottom" else (field == 1)
        return 0.5 if self.interlaced and bottom else 0.0

    def frames(self) -> Iterator[Image]:
        """The frames (H, W), uint8 or uint16, decoded as they are asked for.

        Raises:
            KinemarkError: an image is damaged or unlike the first, or the video ends too early.
        """
        if self.video or self.interlaced:
            yield from islice(self._all_frames(), 0, None, self.every)
        else:
            yield from decode_images(self.paths[:: self.every])

    def _all_frames(self) -> Iterator[Image]:
        """Those that are not taken, too."""
        for image in decode_video(self.paths[0], self.video) if self.video else decode_images(self.paths):
            if not self.interlaced:
                yield image
                continue
            top, bottom = image[0::2].copy(), image[1::2].copy()
            yield from (top, bottom) if self.interlaced == "top" else (bottom, top)

    def frames_at(self, wanted: Ints) -> Image:
        """Frames (n, H, W) of these rising numbers (n), without decoding all before them.

        Raises:
            KinemarkError: as `frames`.
        """
        fields, wanted = 2 if self.interlaced else 1, wanted * self.every
        numbers = np.unique(wanted // fields).tolist()
        if self.video:
            images = frames_at(self.paths[0], self.video, numbers)
        else:
            images = [*decode_images(tuple(self.paths[n] for n in numbers))]
        return self._shown(dict(zip(numbers, images, strict=True)), wanted)

    def frames_near(self, wanted: Ints) -> tuple[Ints, Image]:
        """Numbers (n) of frames near these rising ones, and the frames (n, H, W), at the least cost of decoding.

        They are the wanted ones, or the key frames of a video where these are at least half as many and all frames
        are taken.

        Raises:
            KinemarkError: as `frames`.
        """
        if self.every > 1:
            return wanted, self.frames_at(wanted)
        fields = 2 if self.interlaced else 1
        found = key_frames_near(self.paths[0], self.video, np.unique(wanted // fields).tolist()) if self.video else {}
        if len(found) * 2 * fields < len(wanted):
            return wanted, self.frames_at(wanted)
        frames = np.array(list(found))
        before = np.maximum(np.searchsorted(frames, wanted // fields, side="right") - 1, 0)
        near = np.unique(frames[before] * fields + wanted % fields)
        return near, self._shown(found, near)

    def _shown(self, whole: Mapping[int, Image], wanted: Ints) -> Image:
        """Frames or fields (n, H, W) of these numbers from whole images by their numbers."""
        if not self.interlaced:
            return np.stack([whole[f] for f in wanted.tolist()])
        first = int(self.interlaced == "bottom")
        return np.stack([whole[f // 2][(f + first) % 2 :: 2] for f in wanted.tolist()])

    def batches(self, n: int) -> Iterator[Image]:
        """The frames, at most n at a time and no more than fit in `BATCH_BYTES`: (n, H, W), the last batch mostly
        shorter.

        Raises:
            ValueError: n is not positive.
            KinemarkError: as `frames`.
        """
        if n < 1:
            raise ValueError(f"n is {n}, wanted at least 1")
        few, done = min(n, max(1, BATCH_BYTES // math.prod(self.size))), 0
        if self.video and not self.interlaced and self.every == 1:
            for batch in raw_batches(self.paths[0], self.video, few):
                done += len(batch)
                yield batch
        if done < self.n_frames:
            yield from self._decoded(n, done)

    def _decoded(self, n: int, done: int) -> Iterator[Image]:
        """The batches after so many frames that are done, by a decoder."""
        frames = islice(self.frames(), done, None)
        for first in frames:
            few = min(n, max(1, BATCH_BYTES // first.nbytes))
            batch = batch_memory(few * first.nbytes).batch((few, *first.shape), first.dtype)
            batch[0], found = first, 1
            for image in islice(frames, few - 1):  # copied once, from where the decoder left it
                batch[found] = image
                found += 1
            yield batch[:found]


def open_images(pattern: Path | str, *, interlaced: Interlaced = False, every: int = 1) -> ImageSource:
    """The frames that a pattern names.

    Args:
        pattern: a file (image or video); a printf pattern such as `cam1/%06d.png`, whose numbers must be without
            gaps; or a glob such as `cam1/*.png`, taken in natural order (`2.png` before `10.png`).
        interlaced: "top" or "bottom" for the field that was taken first; False for whole frames.
        every: one frame, or field, of so many is taken, beginning with the first.

    Raises:
        ValueError: `interlaced` is something else.
        KinemarkError: no file matches, a number is missing, the first file is neither image nor video, or `every` is
            less than 1.
    """
    if interlaced not in (False, "top", "bottom"):
        raise ValueError(f"interlaced is {interlaced!r}, wanted False, 'top' or 'bottom'")
    if every < 1:
        raise KinemarkError(f"Of every {every} frames none can be taken. Say 1 for all, 2 for every other one.")
    paths = files_of(Path(pattern))
    video = None if codec_of(paths[0]) else probe_video(paths[0])
    if video and len(paths) > 1:
        raise KinemarkError(f"{pattern} matches {len(paths)} videos, wanted one a camera. Narrow the pattern.")
    if video:
        (width, height), n, rate = video.size, video.n_frames, video.rate
    else:
        (height, width), n, rate = read_image(paths[0]).shape, len(paths), None
    if interlaced and height % 2:
        raise KinemarkError(f"{pattern} has {height} rows, wanted an even number: it is not interlaced.")
    fields = 2 if interlaced else 1
    own_rate, taken = fields * rate / every if rate else None, len(range(0, fields * n, every))
    return ImageSource(paths, (width, height // fields), taken, own_rate, interlaced, video, every)


def files_of(pattern: Path) -> tuple[Path, ...]:
    """The files that a pattern names, in order; at least one."""
    if pattern.is_file():
        return (pattern,)
    if NUMBER.search(pattern.name):
        return numbered(pattern)
    names = (p for p in pattern.parent.glob("*") if fnmatchcase(p.name, pattern.name))
    found = sorted((p for p in names if p.is_file() and not p.name.startswith(".")), key=natural)
    if not found:
        raise KinemarkError(f"{pattern} names no file. Check the folder and the pattern.")
    return tuple(found)


def natural(path: Path) -> tuple[list[tuple[int, str]], str]:
    """A key by which numbers in names sort as numbers."""
    parts = re.split(r"([0-9]+)", path.name)
    return [(int(p), "") if k % 2 else (-1, p) for k, p in enumerate(parts) if p], path.name


def numbered(pattern: Path) -> tuple[Path, ...]:
    """The files of a printf pattern, by number.

    Raises:
        KinemarkError: the pattern has more than one number, no file matches, or a number is missing.
    """
    parts = NUMBER.split(pattern.name)
    if len(parts) != 3:
        raise KinemarkError(f"{pattern} has more than one %d, wanted one number. Write the others out.")
    width = int(parts[1] or 0)
    before, after = (re.escape(part.replace("%%", "%")) for part in (parts[0], parts[2]))
    name = re.compile(rf"{before}([0-9]{{{max(width, 1)}}}|[1-9][0-9]{{{max(width, 1)},17}}){after}")
    found = {int(m[1]): p for p in pattern.parent.glob("*") if (m := name.fullmatch(p.name)) and p.is_file()}
    if not found:
        raise KinemarkError(f"{pattern} names no file. Check the folder and the pattern.")
    numbers = sorted(found)
    if numbers[-1] - numbers[0] + 1 != len(numbers):
        gap = next(a + 1 for a, b in pairwise(numbers) if b != a + 1)
        raise KinemarkError(
            f"{pattern} has {len(numbers)} files from {numbers[0]} to {numbers[-1]}; {gap} is the first one missing. "
            "Restore it, or use a glob if gaps are meant."
        )
    return tuple(found[k] for k in numbers)


def codec_of(path: Path) -> str | None:
    """The decoder for an image file, by its first bytes; None if it is not an image."""
    try:
        with path.open("rb") as file:
            start = file.read(8)
    except OSError as error:
        raise KinemarkError(f"{path} cannot be read: {error}") from error
    return next((codec for magic, codec in MAGIC if start.startswith(magic)), None)


def read_image(path: Path | str) -> Image:
    """(H, W) grey values of an image file: PNG, TIFF (its first page), JPEG, BMP, PGM, PPM or PBM.

    Raises:
        KinemarkError: the file is absent, empty, damaged or no such image.
    """
    path = Path(path)
    data = read_bytes(path, most=4 * MOST_PIXELS)
    if (codec := codec_of(path)) is None:
        raise KinemarkError(f"{path} is not a PNG, TIFF, JPEG, BMP, PGM, PPM or PBM image. Convert it to PNG.")
    try:
        context = av.CodecContext.create(codec, "r")
        # FFmpeg's TIFF decoder calls ordinary files damaged when it is strict
        strict = {} if codec == "tiff" else {"err_detect": "crccheck+explode"}
        context.options = {"max_pixels": str(MOST_PIXELS), **strict}
        frames = [*context.decode(av.Packet(data)), *context.decode(None)]  # type: ignore[attr-defined]
    except (av.FFmpegError, MemoryError) as error:
        raise KinemarkError(f"{path} is a damaged {codec} image ({error}). Copy it again.") from error
    if len(frames) != 1 or frames[0].is_corrupt:
        raise KinemarkError(f"{path} is a damaged {codec} image: it gives {len(frames)} whole frames. Copy it again.")
    check_pixels(str(path), frames[0].width, frames[0].height)
    return grey(frames[0], str(path))


def decode_images(paths: tuple[Path, ...]) -> Iterator[Image]:
    """Image files of one size and depth, one by one."""
    first: Image | None = None
    for path in paths:
        image = read_image(path)
        first = image if first is None else first
        if image.shape != first.shape or image.dtype != first.dtype:
            raise KinemarkError(
                f"{path} is {image.dtype} {image.shape}, {paths[0].name} is {first.dtype} {first.shape}. "
                "Keep images of different cameras or modes apart."
            )
        yield image


def png_bytes(image: Image) -> bytes:
    """Grey values (H, W), uint8 or uint16, as a PNG file has them.

    Raises:
        ValueError: `image` has another shape or dtype.
    """
    if image.ndim != 2 or image.dtype not in (np.uint8, np.uint16) or not image.size:
        raise ValueError(f"image must be (height, width) of uint8 or uint16, found {image.dtype} {image.shape}")
    depth = "gray" if image.dtype == np.uint8 else "gray16be"
    context = av.CodecContext.create("png", "w")
    context.height, context.width = image.shape
    context.pix_fmt, context.time_base = depth, Fraction(1)
    pixels: Any = np.ascontiguousarray(image)
    packets = [*context.encode(av.VideoFrame.from_ndarray(pixels, format=depth)), *context.encode(None)]
    return b"".join(map(bytes, packets))


def jpeg_bytes(image: Image) -> bytes:
    """Grey values (H, W), uint8, as a JPEG file has them.

    Raises:
        ValueError: `image` has another shape or dtype.
    """
    if image.ndim != 2 or image.dtype != np.uint8 or not image.size:
        raise ValueError(f"image must be (height, width) of uint8, found {image.dtype} {image.shape}")
    context = av.CodecContext.create("mjpeg", "w")
    context.height, context.width = image.shape
    context.pix_fmt, context.time_base = "yuvj420p", Fraction(1)
    context.options = {"qmin": COARSENESS, "qmax": COARSENESS}
    pixels: Any = np.ascontiguousarray(image)
    frame = av.VideoFrame.from_ndarray(pixels, format="gray").reformat(format="yuvj420p")
    return b"".join(map(bytes, [*context.encode(frame), *context.encode(None)]))


def scaled(image: Image, width: int, height: int) -> Image:
    """Grey values (H, W), uint8, made smaller: each pixel the mean of those that it covers."""
    pixels: Any = np.ascontiguousarray(image)
    frame = av.VideoFrame.from_ndarray(pixels, format="gray")
    small = frame.reformat(width=width, height=height, interpolation="AREA")
    return plane(small, 8)


def write_png(path: Path | str, image: Image) -> None:
    """Write grey values (H, W), uint8 or uint16, as PNG.

    Raises:
        ValueError: `image` has another shape or dtype.
        KinemarkError: the file cannot be written.
    """
    content = png_bytes(image)
    with replacing(path) as beside:
        beside.write_bytes(content)
