"""C3D files that are cut off, damaged or made to harm: a clear error, in bounded time and memory, or sound data."""

import tracemalloc
from itertools import product

import numpy as np
import pytest

from kinemark.data import Analog, Events, KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.io.c3d import ByteOrder, decode_document, document_of, encode_document, read_c3d, trial_of


def small(order=ByteOrder.INTEL, floats=True):
    """A small file: 3 markers, 20 frames, 2 channels, one event."""
    rng = np.random.default_rng(4)
    paths = tuple(MarkerTrajectory.measured(f"M{i}", rng.normal(0, 300, (20, 3))) for i in range(3))
    analog = Analog(("a", "b"), ("V", "V"), 200.0, rng.normal(size=(2, 40)))
    trial = Trial("s", Trajectories(paths, 100.0), (analog,), events=Events(("x",), ("Left",), np.array([0.1])))
    return encode_document(document_of(trial, order=order, floats=floats))


def outcome(raw, partial):
    """Whether the bytes were read; any error but KinemarkError escapes."""
    try:
        trial_of(decode_document(bytes(raw), name="damaged", partial=partial), name="damaged")
    except KinemarkError as error:
        assert len(str(error)) > 20
        return False
    return True


@pytest.mark.parametrize(("order", "floats"), list(product(ByteOrder, (True, False))))
def test_a_truncated_file_is_refused_unless_asked_for_in_part(order, floats):
    raw = small(order, floats)
    doc = decode_document(raw, name="whole")
    end = (doc.data_block - 1) * 512 + 20 * (12 + 4) * (4 if floats else 2)
    for stop in range(0, end, 29):
        assert not outcome(raw[:stop], partial=False)
        outcome(raw[:stop], partial=True)
    assert outcome(raw[:end], partial=False)


def test_the_frames_before_a_cut_are_read_and_the_rest_is_named():
    raw = small()
    doc = decode_document(raw, name="whole")
    cut = raw[: (doc.data_block - 1) * 512 + 7 * 64 + 10]
    with pytest.raises(KinemarkError, match=r"frames 8 to 20 of 20.*--partial"):
        decode_document(cut, name="cut")
    part = decode_document(cut, name="cut", partial=True)
    assert np.array_equal(part.points, doc.points[:7]) and "frames 8 to 20" in part.notes[0]
    again = decode_document(encode_document(part), name="what was left")
    assert np.array_equal(again.points, part.points) and not again.notes  # its parameters count what it holds


def test_a_name_of_garbage_does_not_fill_the_message():
    raw = small()
    nameless = bytes([127, 1]) + b"\x01" * 127 + bytes([4, 0, 5, 0])  # a parameter of group 1, of no known type
    damaged = raw[:516] + nameless + raw[516:]
    with pytest.raises(KinemarkError) as stop:
        decode_document(damaged, name="damaged")
    assert r"\x01" * 40 in str(stop.value) and r"\x01" * 41 not in str(stop.value)


def test_damaged_bytes_never_give_another_error():
    rng = np.random.default_rng(5)
    files = [small(order, floats) for order, floats in product(ByteOrder, (True, False))]
    read = 0
    for i in range(1500):
        raw = bytearray(files[i % 6])
        section = 512 if i % 3 else 2560
        for at in rng.integers(0, section, rng.integers(1, 6)):
            raw[at] = rng.choice([0, 1, 127, 128, 255, rng.integers(256)])
        read += outcome(raw, partial=bool(i % 2))
    assert 0 < read < 1500


def test_sizes_that_a_file_only_claims_are_not_allocated():
    raw = bytearray(small())
    raw[2:6] = b"\xff\xff\xff\xff"  # points and analog numbers a frame
    raw[8:10] = b"\xfe\xff"  # last frame
    used = raw.index(b"USED") + 8
    raw[used : used + 2] = b"\xff\xff"
    tracemalloc.start()
    assert not outcome(raw, partial=False)
    assert tracemalloc.get_traced_memory()[1] < 20e6
    tracemalloc.stop()


def chain(*entries):
    """A file whose parameter section holds these bytes."""
    section = b"\x01\x50\x01\x54" + b"".join(entries)
    section += bytes(-len(section) % 512)
    raw = bytearray(small()[:512]) + section
    raw[16:18] = (2 + len(section) // 512).to_bytes(2, "little")
    raw[2:6], raw[6:10] = bytes(4), b"\x01\x00\x00\x00"
    return bytes(raw)


def test_pointers_that_lead_nowhere():
    group = b"\x05\xffPOINT\x03\x00\x00"
    assert outcome(chain(group, b"\x00\x00"), partial=False)
    assert not outcome(chain(group, b"\x01\x01X\x01\x00\x02\x00\x05\x00\x00\xff"), partial=False)  # into itself
    assert not outcome(chain(group, b"\x01\x01X\xff\xff\x02\x07" + b"\xff" * 600), partial=False)  # 255^7 values
    assert outcome(chain(group, b"\x01\x01X\x00\x00\x02\x00\x05\x00\x00"), partial=False)  # 0: the last
    assert not outcome(chain(group, b"\x01\x01X\x08\x00\x02\x02\x02\xff\x00\x09"), partial=False)  # too short
    assert not outcome(chain(b"\x01\x01X\x06\x00\x63\x00\x05\x00\x00"), partial=False)  # unknown type


def test_very_many_entries_end_in_bounded_time():
    assert not outcome(chain(b"\x01\x01X\x05\x00\x01\x00\x05" * 70_000), partial=False)


@pytest.mark.parametrize(
    ("at", "value", "says"),
    [(1, 0x51, "begins with"), (0, 0, "begins with"), (0, 255, "before its parameters"), (515, 83, "processor")],
)
def test_bytes_that_make_it_no_c3d_file(tmp_path, at, value, says):
    raw = bytearray(small())
    raw[at] = value
    (tmp_path / "t.c3d").write_bytes(raw)
    with pytest.raises(KinemarkError, match=says):
        read_c3d(tmp_path / "t.c3d")


@pytest.mark.parametrize("raw", [b"", b"C3D", bytes(512), bytes(5000), b"\x02\x50" * 300])
def test_what_is_no_c3d_file_at_all(tmp_path, raw):
    (tmp_path / "t.c3d").write_bytes(raw)
    with pytest.raises(KinemarkError, match=r"t\.c3d"):
        read_c3d(tmp_path / "t.c3d")
    with pytest.raises(KinemarkError):
        read_c3d(tmp_path / "absent.c3d")
