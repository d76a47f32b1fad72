"""Images and video: every grey value as it was stored, or a clear refusal."""

import shutil

import cv2
import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.io import images
from kinemark.io.images import open_images, read_image, write_png
from kinemark.io.video import write_video
from support.shared import shared_data

RNG = np.random.default_rng(0)
BYTES = RNG.integers(0, 256, (12, 48, 66), dtype=np.uint8)
WORDS = RNG.integers(0, 65536, (12, 48, 66), dtype=np.uint16)
WEIGHTS = np.array([0.299, 0.587, 0.114])


def stack(source):
    return np.stack(list(source))


# --- grey values -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("frames", [BYTES, WORDS], ids=["uint8", "uint16"])
@pytest.mark.parametrize("rate", [25.0, 50.0, 59.94, 250.0, 1000.0])
def test_lossless_video_is_lossless(tmp_path, frames, rate):
    write_video(tmp_path / "v.mkv", frames, rate)
    source = open_images(tmp_path / "v.mkv")
    assert (source.size, source.n_frames) == ((66, 48), 12)
    assert source.rate == pytest.approx(rate, rel=1e-4)
    read = stack(source)
    assert read.dtype == frames.dtype and np.array_equal(read, frames)
    assert [len(batch) for batch in source.batches(5)] == [5, 5, 2]
    assert np.array_equal(np.concatenate(list(source.batches(5))), frames)


def test_batches_have_no_more_frames_than_fit_in_their_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(images, "BATCH_BYTES", 3 * BYTES[0].nbytes + 1)
    write_video(tmp_path / "v.mkv", BYTES, 50.0)
    parts = list(open_images(tmp_path / "v.mkv").batches(5))
    assert [len(part) for part in parts] == [3, 3, 3, 3] and np.array_equal(np.concatenate(parts), BYTES)
    monkeypatch.setattr(images, "BATCH_BYTES", 1)
    assert {len(part) for part in open_images(tmp_path / "v.mkv").batches(5)} == {1}


@pytest.mark.parametrize("image", [BYTES[0], WORDS[0], BYTES[0, :1, :1], WORDS[1, :7, :3]])
def test_png_is_exact_for_us_and_for_opencv(tmp_path, image):
    write_png(tmp_path / "a.png", image)
    for read in (read_image(tmp_path / "a.png"), cv2.imread(str(tmp_path / "a.png"), cv2.IMREAD_UNCHANGED)):
        assert read.dtype == image.dtype and np.array_equal(read, image)


@pytest.mark.parametrize(
    ("ending", "dtype", "colour"),
    [
        *((ending, dtype, colour) for ending in ("png", "tif") for dtype in (np.uint8, np.uint16) for colour in (0, 1)),
        *(("bmp", np.uint8, colour) for colour in (0, 1)),
        *(("pgm", dtype, 0) for dtype in (np.uint8, np.uint16)),
        *(("ppm", dtype, 1) for dtype in (np.uint8, np.uint16)),
    ],
)
def test_images_that_opencv_writes(tmp_path, ending, dtype, colour):
    grey = (BYTES if dtype == np.uint8 else WORDS)[0]
    bgr = np.stack([grey, grey[::-1], grey[:, ::-1]], -1)
    path = tmp_path / f"a.{ending}"
    cv2.imwrite(str(path), bgr if colour else grey)
    wanted = np.rint(bgr[..., ::-1] @ WEIGHTS) if colour else grey
    read = read_image(path)
    assert read.dtype == dtype and np.array_equal(read, wanted)


def test_grey_stored_as_colour_stays_what_it_is(tmp_path):
    cv2.imwrite(str(tmp_path / "a.png"), np.repeat(BYTES[0, :, :, None], 3, -1))
    assert np.array_equal(read_image(tmp_path / "a.png"), BYTES[0])


@pytest.mark.parametrize(
    ("folder", "names", "tolerance"),
    [
        ("dot_target_4cam/cal", "cam1.tif cam2.tif cam3.tif cam4.tif", 0),
        ("dot_body_splitter/cal", "cam1.png cam2.png Cal_2-1.png", 0),
        ("chessboard_left", "left01.jpg left02.jpg left14.jpg", 2),  # decoders of JPEG may round differently
    ],
)
def test_recorded_images_are_what_opencv_reads(folder, names, tolerance):
    for name in names.split():
        path = shared_data(f"cameras/{folder}/{name}")
        wanted = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE).astype(int)
        assert np.abs(read_image(path).astype(int) - wanted).max() <= tolerance


def test_recorded_video():
    sources = [open_images(shared_data(f"cameras/ir_4cam_footage/calibration1_{c}.mp4")) for c in range(4)]
    assert {(source.size, source.n_frames) for source in sources} == {((640, 480), 1202)}
    shapes = [(image.shape, image.dtype.name) for image in sources[3]]
    assert shapes == [((480, 640), "uint8")] * 1202


# --- fields ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("first", ["top", "bottom"])
def test_fields_are_the_rows_of_a_frame(tmp_path, first):
    write_video(tmp_path / "v.mkv", BYTES, 25.0)
    fields = open_images(tmp_path / "v.mkv", interlaced=first)
    assert (fields.size, fields.n_frames, fields.rate) == ((66, 24), 24, 50.0)
    read = stack(fields)
    woven = np.empty_like(BYTES)
    for f, field in enumerate(read):
        bottom = fields.v_offset(f) == 0.5
        woven[f // 2, int(bottom) :: 2] = field
    assert np.array_equal(woven, BYTES)
    assert fields.v_offset(0) == (0.0 if first == "top" else 0.5)
    assert open_images(tmp_path / "v.mkv").v_offset(1) == 0.0


@pytest.mark.parametrize("first", ["top", "bottom"])
def test_the_offset_puts_both_fields_on_one_image_plane(tmp_path, first):
    """A blob that does not move has one centroid in all fields, once the offset is added."""
    v, u = np.mgrid[:80, :60]
    blob = np.round(200 * np.exp(-((u - 30.2) ** 2 + (v - 41.3) ** 2) / (2 * 6.0**2))).astype(np.uint8)
    write_png(tmp_path / "000.png", blob)
    source = open_images(tmp_path / "%03d.png", interlaced=first)
    lines = np.arange(40)
    centres = [float((field.sum(1) @ lines) / field.sum()) + source.v_offset(f) for f, field in enumerate(source)]
    assert centres == pytest.approx([41.3 / 2] * 2, abs=0.02)


def test_an_odd_height_is_not_interlaced(tmp_path):
    write_png(tmp_path / "a.png", BYTES[0, :47])
    with pytest.raises(KinemarkError, match="47 rows"):
        open_images(tmp_path / "a.png", interlaced="top")
    with pytest.raises(ValueError, match="interlaced is True"):
        open_images(tmp_path / "a.png", interlaced=True)


# --- sequences -------------------------------------------------------------------------------------------------------


def test_a_printf_pattern_goes_by_number(tmp_path):
    for k in range(8, 12):
        write_png(tmp_path / f"a%{k}.png", BYTES[k - 8])
        write_png(tmp_path / f"b{k:03d}.png", BYTES[k - 8])
    write_png(tmp_path / "b7.png", BYTES[0])  # not three digits
    for pattern in ("a%%%d.png", "b%03d.png"):
        source = open_images(tmp_path / pattern)
        assert np.array_equal(stack(source), BYTES[:4]) and source.rate is None
    (tmp_path / "b009.png").unlink()
    with pytest.raises(KinemarkError, match="3 files from 8 to 11; 9 is the first one missing"):
        open_images(tmp_path / "b%03d.png")


def test_a_glob_goes_in_natural_order(tmp_path):
    order = ["f1.png", "f2.png", "f10.png", "f10b.png", "f100.png"]
    for k, name in enumerate(order):
        write_png(tmp_path / name, BYTES[k])
    (tmp_path / ".f3.png").write_bytes(b"hidden")
    assert [p.name for p in open_images(tmp_path / "*.png").paths] == order
    assert np.array_equal(stack(open_images(str(tmp_path / "f?.png"))), BYTES[:2])


@pytest.mark.parametrize("pattern", ["*.png", "%06d.png", "a.png", "none/*.png", "none/%d.png", "", "[", "**x"])
def test_nothing_found_is_said(tmp_path, pattern):
    with pytest.raises(KinemarkError, match="names no file"):
        open_images(tmp_path / pattern if pattern else tmp_path)


def test_two_numbers_in_a_pattern_are_refused(tmp_path):
    with pytest.raises(KinemarkError, match="more than one %d"):
        open_images(tmp_path / "c%d_%05d.png")


def test_images_of_one_camera_are_alike(tmp_path):
    write_png(tmp_path / "0.png", BYTES[0])
    write_png(tmp_path / "1.png", BYTES[1, :40])
    write_png(tmp_path / "2.png", WORDS[1])
    for k in (1, 2):
        shutil.copy(tmp_path / f"{k}.png", tmp_path / "b1.png")
        shutil.copy(tmp_path / "0.png", tmp_path / "b0.png")
        with pytest.raises(KinemarkError, match=r"b1\.png is .* b0\.png is uint8"):
            list(open_images(tmp_path / "b%d.png"))


def test_one_video_a_camera(tmp_path):
    for name in "ab":
        write_video(tmp_path / f"{name}.mkv", BYTES, 25.0)
    assert open_images(tmp_path / "a*").n_frames == 12
    with pytest.raises(KinemarkError, match="2 videos"):
        open_images(tmp_path / "*.mkv")


# --- damage ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", ["png", "tif", "bmp", "pgm", "jpg"])
def test_a_truncated_image_is_refused(tmp_path, ending):
    cv2.imwrite(str(tmp_path / f"a.{ending}"), BYTES[0])
    data = (tmp_path / f"a.{ending}").read_bytes()
    part = tmp_path / f"part.{ending}"
    for cut in np.linspace(0, len(data), 30).astype(int)[:-1]:
        part.write_bytes(data[:cut])
        with pytest.raises(KinemarkError, match="part"):
            stack(open_images(part))


def test_a_truncated_video_is_refused(tmp_path):
    write_video(tmp_path / "v.mkv", BYTES, 250.0)
    data = (tmp_path / "v.mkv").read_bytes()
    part, counted, whole = tmp_path / "part.mkv", 0, 0
    for cut in [*np.linspace(0, len(data), 60).astype(int)[:-1], len(data) - 10]:
        part.write_bytes(data[:cut])
        try:
            read = stack(open_images(part))
        except KinemarkError as error:
            counted += "and states 12" in str(error)
        else:  # only the index at the end was lost
            assert np.array_equal(read, BYTES)
            whole += 1
    assert counted > 40 and whole == 1


def test_damage_in_lossless_video_is_always_found(tmp_path):
    write_video(tmp_path / "v.mkv", BYTES, 25.0)
    data, part, rng = (tmp_path / "v.mkv").read_bytes(), tmp_path / "part.mkv", np.random.default_rng(3)
    refused = 0
    for at in rng.integers(0, len(data), 150):
        damaged = bytearray(data)
        damaged[at] ^= 1 << int(rng.integers(8))
        part.write_bytes(damaged)
        try:
            read = stack(open_images(part))
        except KinemarkError:
            refused += 1
        else:
            assert np.array_equal(read, BYTES)
    assert refused > 100


def test_a_damaged_header_never_crashes(tmp_path):
    write_video(tmp_path / "v.mkv", BYTES[:2], 25.0)
    data, part, rng = (tmp_path / "v.mkv").read_bytes(), tmp_path / "part.mkv", np.random.default_rng(7)
    refused = 0
    for _ in range(150):
        damaged = bytearray(data)
        for at in rng.integers(0, 700, 3):
            damaged[at] = rng.integers(256)
        part.write_bytes(damaged)
        try:
            list(open_images(part))
        except KinemarkError:
            refused += 1
    assert refused > 20


def test_a_recorded_video_cut_or_damaged_is_refused(tmp_path):
    data = shared_data("cameras/ir_4cam_footage/calibration1_0.mp4").read_bytes()
    part = tmp_path / "part.mp4"
    for cut in (1, 1000, len(data) // 2, len(data) - 100):
        part.write_bytes(data[:cut])
        with pytest.raises(KinemarkError, match="cannot be read as image or video"):
            open_images(part)
    part.write_bytes(data[:30000] + bytes(200) + data[30200:])
    with pytest.raises(KinemarkError, match="of 1202 frames could be decoded"):
        list(open_images(part))


@pytest.mark.parametrize(
    "data", [b"", b"\0" * 4096, b"#EXTM3U\n#EXTINF:1,\n/etc/hostname\n", b"ffconcat version 1.0\nfile x\n"]
)
def test_what_is_neither_image_nor_video_is_refused(tmp_path, data):
    for name in ("a.mkv", "a.png", "a.m3u8"):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(KinemarkError, match="cannot be read as image or video"):
            open_images(tmp_path / name)


def test_an_image_of_absurd_size_is_refused_unread(tmp_path):
    (tmp_path / "a.pgm").write_bytes(b"P5\n60000 60000\n255\n" + bytes(1000))
    with pytest.raises(KinemarkError, match="pgm"):
        read_image(tmp_path / "a.pgm")


# --- writing ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "frames", [[], [BYTES], [BYTES[0].astype(float)], [BYTES[0], BYTES[0, :9]], [BYTES[0], WORDS[0]]]
)
def test_only_grey_frames_of_one_shape_are_written(tmp_path, frames):
    (tmp_path / "v.mkv").write_text("before")
    with pytest.raises(ValueError, match="frame"):
        write_video(tmp_path / "v.mkv", frames, 25.0)
    assert [p.name for p in tmp_path.iterdir()] == ["v.mkv"] and (tmp_path / "v.mkv").read_text() == "before"
    with pytest.raises(ValueError, match="image"):
        write_png(tmp_path / "a.png", BYTES)
    with pytest.raises(ValueError, match="mkv"):
        write_video(tmp_path / "v.mp4", BYTES, 25.0)
