"""C3D: files that contradict themselves about their numbers are read as what they are."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark.data import KinemarkError, Origin, same
from kinemark.io.c3d import (
    ByteOrder,
    Parameter,
    decode_document,
    document_of,
    encode_document,
    trial_of,
    with_parameters,
)
from kinemark.io.c3d.numbers import encode_floats
from support.examples import examples
from support.poses import made_poses
from support.trials import made_trial

ODD = [1.0, 0.1, 0.0, -0.0, 1e30, -1e30, np.nan, -np.nan, 1e-40]


def with_scales(doc, header, parameter):
    """The bytes of a document with other scales in header and POINT:SCALE; None leaves one as it is."""
    if parameter is None:
        doc = replace(doc, groups=tuple(
            replace(g, parameters=tuple(p for p in g.parameters if p.name != "SCALE" or g.name != "POINT"))
            for g in doc.groups
        ))  # fmt: skip
    raw = bytearray(encode_document(doc))
    if header is not None:
        raw[12:16] = encode_floats(np.array([header]), doc.order).tobytes()
    if parameter is not None:
        at = raw.index(b"SCALE", raw.index(b"POINT")) + len("SCALE") + 4
        raw[at : at + 4] = encode_floats(np.array([parameter]), doc.order).tobytes()
    return bytes(raw)


@settings(max_examples=examples(40), deadline=None)
@given(
    order=st.sampled_from(list(ByteOrder)),
    floats=st.booleans(),
    odd=st.sampled_from(ODD),
    in_header=st.booleans(),
    poses=st.booleans(),
    n=st.sampled_from([23, 40, 200]),
)
def test_one_wrong_scale_does_not_harm(order, floats, odd, in_header, poses, n):
    """Positive, zero, huge or no number: the other scale and the size of the file tell."""
    if order is ByteOrder.DEC and not np.isnan(odd) and abs(odd) > 1e29:
        odd = np.copysign(1e20, odd)
    trial = replace(made_trial(n=n), poses=(made_poses(n=n),) if poses else ())
    right = document_of(trial, order=order, floats=floats)
    sign = -right.scale if floats else right.scale
    doc = with_parameters(right, "POINT", [Parameter.real("SCALE", sign)])
    raw = with_scales(doc, *((odd, sign) if in_header else (sign, odd)))
    found = decode_document(raw, name="made")
    assert found.floats == floats and found.points.shape == right.points.shape
    if floats or np.isnan(odd) or not 1e-12 <= abs(odd) <= 1e4:
        assert np.allclose(found.points, right.points, rtol=1e-6)
    assert np.array_equal(found.word, right.word)
    assert np.isfinite(found.scale) and found.scale < 1e4
    assert np.allclose(found.analog, right.analog)


@pytest.mark.parametrize("floats", [True, False])
def test_no_scale_at_all_is_settled_by_the_size_of_the_file(floats):
    right = document_of(made_trial(n=400), floats=floats)
    found = decode_document(with_scales(right, 0.0, None), name="made")
    assert found.floats == floats and found.scale == 1.0
    assert np.allclose(found.points, right.points / (1.0 if floats else right.scale), rtol=1e-6)


def test_a_file_that_tells_nothing_is_refused():
    tiny = document_of(made_trial(n=3, m=1).frames(0, 3))
    tiny = document_of(replace(trial_of(tiny, name="t"), analog=(), plates=()))
    with pytest.raises(KinemarkError, match="floats or integers"):
        decode_document(with_scales(replace(tiny, word=tiny.word), 0.0, None)[:-512] + bytes(300), name="made")


def unsigned_document(order, stated):
    """A document of integers around 0x8000, as boards with an offset of half their range give them."""
    rng = np.random.default_rng(4)
    doc = document_of(made_trial(), order=order, floats=False)
    counts = (32768 + np.cumsum(rng.integers(-300, 300, doc.analog.shape), axis=1)).astype(float)
    rows = len(counts)
    form = [Parameter.text("FORMAT", stated)] if stated else []
    parameters = [Parameter.whole("OFFSET", [32768] * rows), Parameter.real("SCALE", [0.01] * rows), *form]
    doc = replace(with_parameters(doc, "ANALOG", parameters), analog=(counts.astype(np.int64) + 32768) % 65536 - 32768)
    if stated:
        doc = replace(doc, analog=counts)
    return doc, (counts - 32768) * np.float32(0.01)


@pytest.mark.parametrize("order", list(ByteOrder))
@pytest.mark.parametrize("stated", ["UNSIGNED", "unsigned", ""])
def test_an_offset_of_0x8000_says_that_channels_are_unsigned(order, stated):
    doc, wanted = unsigned_document(order, "UNSIGNED" if stated else "")
    if stated:
        doc = with_parameters(doc, "ANALOG", [Parameter.text("FORMAT", stated)])
    else:
        doc = replace(doc, analog=doc.analog % 65536)
    trial = trial_of(decode_document(encode_document(doc), name="made"), name="t")
    assert np.allclose(trial.analog[0].values, wanted, atol=1e-4)
    assert same(trial_of(document_of(trial), name="t").analog, trial.analog)
    assert np.abs(np.diff(trial.analog[0].values)).max() < 400 * 0.01


@pytest.mark.parametrize("order", list(ByteOrder))
def test_an_offset_beyond_signed_numbers_says_so_also_as_a_float(order):
    doc, wanted = unsigned_document(order, "")
    doc = with_parameters(doc, "ANALOG", [Parameter.real("OFFSET", [40000.0] + [32768.0] * (len(doc.analog) - 1))])
    trial = trial_of(decode_document(encode_document(replace(doc, analog=doc.analog % 65536)), name="made"), name="t")
    assert np.allclose(trial.analog[0].values[0], wanted[0] - 7232 * np.float32(0.01), atol=1e-3)
    assert np.allclose(trial.analog[0].values[1:], wanted[1:], atol=1e-4)


@pytest.mark.parametrize(("stated", "noted"), [(50.0, True), (np.nan, False), (0.0, False), (200.01, False)])
def test_two_frame_rates_are_noted(stated, noted):
    doc = document_of(made_trial())
    raw = bytearray(encode_document(replace(doc, rate=200.0, groups=with_parameters(
        doc, "POINT", [Parameter.real("RATE", 200.0)]).groups)))  # fmt: skip
    raw[20:24] = encode_floats(np.array([stated]), doc.order).tobytes()
    found = decode_document(bytes(raw), name="made")
    assert found.rate == 200.0 and any("50 Hz" in note and "200" in note for note in found.notes) == noted


def test_signed_is_signed_when_the_file_says_so():
    doc, _ = unsigned_document(ByteOrder.INTEL, "")
    doc = with_parameters(doc, "ANALOG", [Parameter.text("FORMAT", "SIGNED")])
    found = trial_of(decode_document(encode_document(doc), name="made"), name="t")
    assert np.allclose(found.analog[0].values, (doc.analog + 32768) * np.float32(0.01), atol=1e-4)


@pytest.mark.parametrize("order", list(ByteOrder))
def test_marks_of_minus_32768_are_missing_and_clipped_samples_are_not(order):
    doc = document_of(made_trial(), order=order, floats=False)
    counts = doc.analog.copy()
    counts[0] = np.round(2000 * np.sin(np.arange(counts.shape[1]) / 9))
    counts[0, 30:50] = -32768  # marks
    counts[1] = np.clip(np.round(40000 * np.sin(np.arange(counts.shape[1]) / 9)), -32768, 32767)  # clipped
    points = doc.points.copy()
    points[7, 2] = -32768 * doc.scale
    raw = encode_document(replace(doc, analog=counts, points=points))
    trial = trial_of(decode_document(raw, name="made"), name="t")
    missing = np.isnan(trial.analog[0].values)
    assert np.flatnonzero(missing[0]).tolist() == list(range(30, 50)) and not missing[1:].any()
    assert any("−32 768" in note for note in trial.notes)
    assert trial.trajectories.paths[2].origin[7] == Origin.MISSING
    assert encode_document(document_of(trial)) == raw
