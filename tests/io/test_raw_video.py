"""Uncompressed video is read from the file as a decoder gives it, and whatever is not so is left to the decoder."""

from itertools import islice

import av
import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.io.batch_memory import batch_memory
from kinemark.io.images import open_images
from kinemark.io.raw_video import raw_batches
from kinemark.io.video import VideoInfo, decode_video, probe_video

KINDS = ["avi", "mkv"]
SIZES = [(64, 48), (61, 47), (1, 1), (3, 1), (130, 200)]


def film(n, size=(64, 48), seed=0):
    return np.random.default_rng(seed).integers(0, 256, (n, size[1], size[0]), np.uint8)


def write(path, frames, rate=100, pix_fmt="gray", sound=False):
    with av.open(str(path), "w") as container:
        stream = container.add_stream("rawvideo", rate)
        stream.height, stream.width, stream.pix_fmt = *frames.shape[1:], pix_fmt
        voice = container.add_stream("pcm_s16le", 8000, layout="mono") if sound else None
        for k, frame in enumerate(frames):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="gray").reformat(format=pix_fmt)))
            if voice:
                spoken = av.AudioFrame.from_ndarray(np.full((1, 80), k, np.int16), format="s16", layout="mono")
                spoken.sample_rate, spoken.pts = 8000, 80 * k
                container.mux(voice.encode(spoken))
        container.mux(stream.encode(None))
    return path


def read(path, n=16):
    return list(raw_batches(path, probe_video(path), n))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", SIZES)
def test_frames_are_those_of_the_decoder(tmp_path, kind, size):
    path = write(tmp_path / f"v.{kind}", frames := film(70, size))
    np.testing.assert_array_equal(np.concatenate(read(path)), frames)
    np.testing.assert_array_equal(np.stack(list(decode_video(path, probe_video(path)))), frames)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("n", [1, 7, 1200])
def test_batches_are_full_over_any_change_of_what_is_between_frames(tmp_path, kind, n):
    path = write(tmp_path / f"v.{kind}", frames := film(1300, (16, 4)), rate=10)  # times of one to three bytes
    parts = read(path, n)
    assert {len(part) for part in parts[:-1]} <= {n}
    np.testing.assert_array_equal(np.concatenate(parts), frames)


@pytest.mark.parametrize("kind", KINDS)
def test_sound_between_frames_is_passed_over(tmp_path, kind):
    path = write(tmp_path / f"v.{kind}", frames := film(40), sound=True)
    np.testing.assert_array_equal(np.concatenate(read(path)), frames)


JUNK = {
    "avi": (b"00dc\0\x0c\0\0", b"JUNK\5\1\0\0" + bytes(262)),
    "mkv": (b"\x1f\x43\xb6\x75", b"\xec\x43\xe8" + bytes(1000)),
}
"""What is before each frame, and an element of the container without content."""


@pytest.mark.parametrize("kind", KINDS)
def test_other_elements_between_frames_are_passed_over(tmp_path, kind):
    header, other = JUNK[kind]
    path = write(tmp_path / f"v.{kind}", frames := np.maximum(film(40), 1))
    info, parts = probe_video(path), path.read_bytes().split(header)
    parts[20] += other
    path.write_bytes(header.join(parts))
    np.testing.assert_array_equal(np.concatenate(list(raw_batches(path, info, 16))), frames)


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_damaged_video_has_and_says_is_as_by_the_decoder(tmp_path, kind):
    whole = write(tmp_path / f"whole.{kind}", film(40)).read_bytes()
    path = tmp_path / f"v.{kind}"
    path.write_bytes(whole)
    source = open_images(path)
    for left in np.random.default_rng(1).integers(3000, len(whole), 20).tolist():
        path.write_bytes(whole[:left])
        ways = [source.frames(), (image for batch in source.batches(7) for image in batch)]
        gone = []
        for way in ways:
            shown = []
            with pytest.raises(KinemarkError) as error:
                shown.extend(way)
            gone.append(str(error.value))
        assert gone[0] == gone[1]


@pytest.mark.parametrize("kind", KINDS)
def test_any_damage_ends_in_frames_or_in_an_error(tmp_path, kind):
    whole, frames = write(tmp_path / f"whole.{kind}", film(20)).read_bytes(), film(20)
    info, path, rng = probe_video(tmp_path / f"whole.{kind}"), tmp_path / f"v.{kind}", np.random.default_rng(2)
    for _ in range(100):
        damaged = np.frombuffer(whole, np.uint8).copy()
        begin = whole.find(frames[rng.integers(1, 20)].tobytes()) - rng.integers(1, 25)
        damaged[begin : begin + rng.integers(1, 20)] = rng.choice([0, 1, 255, rng.integers(256)])
        path.write_bytes(damaged.tobytes())
        assert sum(map(len, raw_batches(path, info, 7))) <= 20


def test_a_frame_that_was_dropped_is_left_to_the_decoder(tmp_path):
    path = write(tmp_path / "v.avi", film(20))
    info, parts = probe_video(path), path.read_bytes().split(b"00dc\0\x0c\0\0")
    path.write_bytes(
        b"00dc\0\x0c\0\0".join(parts[:11]) + b"00dc\0\0\0\0" + b"".join(b"00dc\0\x0c\0\0" + p for p in parts[11:])
    )
    assert sum(map(len, raw_batches(path, info, 5))) == 10


@pytest.mark.parametrize("kind", KINDS)
def test_a_video_with_more_frames_than_stated_is_left_to_the_decoder(tmp_path, kind):
    path = write(tmp_path / f"v.{kind}", film(20))
    assert sum(map(len, raw_batches(path, VideoInfo((64, 48), 15, None), 5))) == 10


@pytest.mark.parametrize("pix_fmt", ["yuyv422", "bgr24", "yuv420p"])
def test_pixels_of_other_kinds_are_left_to_the_decoder(tmp_path, pix_fmt):
    path = write(tmp_path / "v.avi", film(5), pix_fmt=pix_fmt)
    assert read(path) == []
    assert sum(map(len, open_images(path).batches(2))) == 5


@pytest.mark.parametrize("codec", ["rawvideo", "ffv1"])
def test_batches_that_are_kept_stay_as_they_are_and_the_memory_of_others_is_used_again(tmp_path, codec):
    with av.open(str(tmp_path / "v.mkv"), "w") as container:
        stream = container.add_stream(codec, 100)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "gray"
        for frame in (frames := film(200)):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="gray")))
        container.mux(stream.encode(None))
    source = open_images(tmp_path / "v.mkv")
    kept = [batch[1:3, 4:] for batch in islice(source.batches(4), 25)]
    np.testing.assert_array_equal(
        np.concatenate(kept), frames[:100].reshape(25, 4, 48, 64)[:, 1:3, 4:].reshape(50, 44, 64)
    )
    places = {batch.ctypes.data for batch in source.batches(4)}
    assert len(places) < 5


def test_memory_that_no_batch_uses_is_given_back():
    first = batch_memory(1000)
    assert batch_memory(1000) is first
    lent = first.batch((2, 5), np.dtype(np.uint16))
    known = id(first)
    del first
    assert id(batch_memory(1000)) == known
    del lent
    assert len(batch_memory(1000)._free) == 0
