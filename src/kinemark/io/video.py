"""Video of one camera, decoded to grey values, and lossless video written."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain, islice
from pathlib import Path
from typing import Any

import av
import numpy as np

from ..data import KinemarkError
from ..data.array_types import Ints
from .ffv1 import intact
from .files import replacing
from .pixels import Image, check_pixels, grey

# real containers only: playlists and image patterns could make the decoder read other files
CONTAINERS = (
    "matroska,webm,mov,mp4,m4a,3gp,3g2,mj2,avi,mpeg,mpegts,mxf,dv,h264,hevc,m4v,mjpeg,ogg,flv,asf,yuv4mpegpipe,nut"
)
ROUNDING = 1.5e-3  # Matroska counts in ms; of the format
INDEXED = ("matroska", "avi")
"""Containers whose own index says when a frame is shown; edit lists of others may cut some off."""
STRICT = {"err_detect": "explode"}  # a damaged frame must fail, not be painted over
LOOKED_AT = 300
"""Packets of a video by which one sees whether all are key frames; chosen: longer than groups of frames are."""
GREY = {np.dtype(np.uint8): "gray", np.dtype(np.uint16): "gray16le"}


@dataclass(frozen=True, slots=True)
class VideoInfo:
    """What a video says of itself.

    Attributes:
        size: width and height, px.
        n_frames: frames stated in the container, or counted where it does not state them.
        rate: frames a second, Hz; None where unknown.
    """

    size: tuple[int, int]
    n_frames: int
    rate: float | None


def probe_video(path: Path | str) -> VideoInfo:
    """Size, length and rate of a video, without decoding it.

    Raises:
        KinemarkError: it is absent, no video, or shorter than its container promises.
    """
    try:
        with opened(path) as container:
            stream = video_stream(path, container)
            rate = float(stream.average_rate) if stream.average_rate else None
            check_pixels(str(path), stream.width, stream.height)
            if (n_frames := stream.frames or counted(path, container)) < 1:
                raise KinemarkError(f"{path} holds no frames. Copy the video again.")
            return VideoInfo((stream.width, stream.height), n_frames, rate)
    except av.FFmpegError as error:
        raise not_a_video(path, str(error)) from error


def opened(path: Path | str) -> av.container.InputContainer:
    """The container of a video."""
    if not Path(path).is_file():
        raise KinemarkError(f"{path} is not a file. Check the path.")
    return av.open(
        f"file:{Path(path)}",
        container_options={"format_whitelist": CONTAINERS, "protocol_whitelist": "file"},
        metadata_errors="replace",
    )


def video_stream(path: Path | str, container: av.container.InputContainer) -> av.VideoStream:
    """The first video stream, if there is one whose codec is known."""
    streams = container.streams.video
    if not streams or not streams[0].codec_context:
        raise not_a_video(path, "no video stream in a known codec")
    return streams[0]


def not_a_video(path: Path | str, why: str) -> KinemarkError:
    """The error for a file that cannot be opened as video."""
    return KinemarkError(
        f"{path} cannot be read as image or video ({why}). Copy it again, or convert it to .mkv with FFV1."
    )


def counted(path: Path | str, container: av.container.InputContainer) -> int:
    """Frames in the packets, checked against the duration that the container states.

    Raises:
        KinemarkError: frames are evenly spaced, and too few for that duration.
    """
    stream = container.streams.video[0]
    times = _times(path, container, stream)
    n, stated, rate = len(times), container.duration, stream.average_rate
    if n == 0 or not np.isfinite(times).all() or not stated or not rate or len(container.streams) > 1:
        return n
    step = (times[-1] - times[0]) / (n - 1) if n > 1 else float(1 / rate)
    even = np.abs(np.array(times) - times[0] - step * np.arange(n)).max() < 0.6 * step
    promised = stated / av.time_base / step
    if even and promised > n + 0.5 + ROUNDING / step:
        raise truncated(path, n, round(promised))
    return n


def _times(path: Path | str, container: av.container.InputContainer, stream: av.VideoStream) -> list[float]:
    """When the frames are shown, s, rising; NaN where a packet does not say it."""
    if (stored := stored_times(path, container)) is not None and stream.time_base:
        return np.asarray(stored * float(stream.time_base), float).tolist()
    return sorted(
        float(packet.pts * packet.time_base) if packet.pts is not None and packet.time_base else np.nan
        for packet in container.demux(stream)
        if packet.size
    )


def stored_times(path: Path | str, container: av.container.InputContainer) -> Ints | None:
    """The rising times that the container's own index has of frames that are all key frames, and shown as they come.

    Uncompressed video is such, and listing its packets would read all of it. None where this index has other frames,
    or not one in each period of the frame rate: an index may name some frames only.
    """
    stream = video_stream(path, container)
    if not (stream.codec.intra_only and any(name in container.format.name for name in INDEXED)):
        return None
    container.seek(0, stream=stream)  # the index of Matroska is read at the first
    entries = list(stream.index_entries)
    time = np.array([entry.timestamp for entry in entries], np.int64)
    if not (len(time) > 1 and stream.time_base and stream.average_rate and all(entry.is_keyframe for entry in entries)):
        return None
    periods = np.diff(time) * float(stream.time_base * stream.average_rate)
    return time if ((periods > 0.5) & (periods < 1.5)).all() else None


def truncated(path: Path | str, found: int, stated: int) -> KinemarkError:
    """The error for a video of another length than stated."""
    return KinemarkError(
        f"{path} gives {found} frames and states {stated}: it is truncated or damaged. Copy it again; to work with "
        f"what is left of it, convert it first: ffmpeg -i {Path(path).name} -c:v ffv1 part.mkv"
    )


def has_dependent_frames(path: Path) -> bool:
    """Whether frames of a video are decoded after others, by its first ones; False where it cannot be read."""
    try:
        with opened(path) as container:
            stream = video_stream(path, container)
            if stream.codec.intra_only:
                return False
            return not all(p.is_keyframe for p in islice(container.demux(stream), LOOKED_AT) if p.size)
    except (KinemarkError, av.FFmpegError):
        return False


def decode_video(path: Path | str, info: VideoInfo) -> Iterator[Image]:
    """The frames of a video as grey values (H, W), in order of presentation.

    Raises:
        KinemarkError: a frame is damaged or of another size, or there are not `info.n_frames` of them.
    """
    n = 0
    try:
        with opened(path) as container:
            stream = video_stream(path, container)
            stream.thread_type = "AUTO"
            stream.codec_context.options = STRICT
            for frame in decoded(path, container, stream):
                if frame.is_corrupt:
                    raise KinemarkError(f"{path}: frame {n + 1} is damaged. Copy the video again.")
                if (frame.width, frame.height) != info.size:
                    found = (frame.width, frame.height)
                    raise KinemarkError(f"{path}: frame {n + 1} has the size {found}, wanted {info.size}. Convert it.")
                n += 1
                yield grey(frame, str(path))
    except av.FFmpegError as error:
        raise KinemarkError(
            f"{path}: {n} of {info.n_frames} frames could be decoded, then it is damaged ({error}). Copy it again."
        ) from error
    if n != info.n_frames:
        raise truncated(path, n, info.n_frames)


def decoded(
    path: Path | str, container: av.container.InputContainer, stream: av.VideoStream
) -> Iterator[av.VideoFrame]:
    """The frames of a stream; where some packets of FFV1 have a right checksum, all must."""
    seen = {True: -1, False: -1}
    for n, packet in enumerate(container.demux(stream)):
        if stream.codec_context.name == "ffv1" and packet.size:
            seen[intact(bytes(packet))] = n
            if min(seen.values()) >= 0:
                raise KinemarkError(
                    f"{path}: frame {seen[False] + 1} has a wrong checksum: it is damaged. Copy it again."
                )
        yield from packet.decode()


def write_video(path: Path | str, frames: Iterable[Image], rate: float) -> None:
    """Write grey frames (H, W), uint8 or uint16, without loss: FFV1 in Matroska, with a checksum a slice.

    Raises:
        ValueError: there are no frames, they differ in shape or dtype, the rate is not positive, or `path` is no .mkv.
        KinemarkError: the file cannot be written.
    """
    images = iter(frames)
    first = next(images, None)
    if first is None or first.ndim != 2 or first.dtype not in GREY or not first.size:
        found = "none" if first is None else f"{first.dtype} {first.shape}"
        raise ValueError(f"frames must be (height, width) of uint8 or uint16, found {found}")
    if Path(path).suffix.lower() != ".mkv" or not 0 < rate < 1e6:
        raise ValueError(f"wanted a path ending in .mkv and a rate within 0 … 10⁶ Hz, found {path} and {rate}")
    with replacing(path) as beside:
        encode(beside, chain([first], images), first, rate)


def encode(path: Path, frames: Iterable[Image], first: Image, rate: float) -> None:
    """All frames, shaped like the first, to a file."""
    with av.open(str(path), "w", format="matroska") as container:
        stream = container.add_stream("ffv1", rate=Fraction(rate).limit_denominator(1_000_001))
        stream.height, stream.width = first.shape
        stream.pix_fmt = GREY[first.dtype]
        stream.codec_context.options = {"level": "3", "slicecrc": "1"}
        stream.codec_context.thread_type = "AUTO"
        for n, image in enumerate(frames):
            if image.shape != first.shape or image.dtype != first.dtype:
                raise ValueError(f"frame {n + 1} is {image.dtype} {image.shape}, the first {first.dtype} {first.shape}")
            pixels: Any = np.ascontiguousarray(image)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format=GREY[first.dtype])))
        container.mux(stream.encode(None))
