"""C3D: rotations and whatever else stands behind the last frame come back, and other readers find them."""

import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark.data import KinemarkError, Trajectories, Trial, same
from kinemark.engine.fill_files import fill_file
from kinemark.fill import Linear
from kinemark.io.c3d import ByteOrder, decode_document, document_of, encode_document, read_c3d, trial_of, write_c3d
from kinemark.io.trial import read_trial, write_trial
from support.examples import examples
from support.poses import made_poses
from support.trials import made_trial

EZC3D = """
import pickle, sys, ezc3d
c = ezc3d.c3d(sys.argv[2])
labels = c["parameters"]["ROTATION"]["LABELS"]["value"]
pickle.dump((c["data"]["rotations"], labels, c["data"]["points"]), open(sys.argv[1], "wb"))
"""


def by_ezc3d(path, folder):
    """Rotations (R, N, 4, 4), labels and points (4, M, F), read in another process, which may crash."""
    subprocess.run([sys.executable, "-c", EZC3D, str(folder / "out"), str(path)], check=True, timeout=100)
    rotations, labels, points = pickle.loads((folder / "out").read_bytes())
    return np.moveaxis(rotations, (2, 3), (0, 1)), labels, points


def with_poses(**how):
    return replace(made_trial(), poses=(made_poses(**how),))


def reread(trial, **how):
    return trial_of(decode_document(encode_document(document_of(trial, **how)), name="made"), name=trial.name)


@settings(max_examples=examples(20), deadline=None)
@given(
    order=st.sampled_from(list(ByteOrder)),
    floats=st.booleans(),
    ratio=st.integers(1, 4),
    segments=st.sampled_from([1, 3, 300]),
    cut=st.tuples(st.integers(0, 15), st.integers(16, 40)),
)
def test_poses_come_back_in_every_format(order, floats, ratio, segments, cut):
    names = [f"segment {i + 1}" for i in range(segments)]
    trial = with_poses(names=names, n=40 * ratio, rate=100.0 * ratio)
    back = reread(trial, order=order, floats=floats)
    assert same(back.poses, trial.poses)
    assert same(document_of(back), back.source)
    part = reread(back.frames(*cut)).poses[0]
    rows = slice(cut[0] * ratio, cut[1] * ratio)
    assert np.array_equal(part.T_world_segment, trial.poses[0].T_world_segment[:, rows], equal_nan=True)
    assert np.array_equal(part.reliability, trial.poses[0].reliability[:, rows])


@pytest.mark.parametrize("order", [ByteOrder.INTEL])  # ezc3d does not write or read the others
@pytest.mark.parametrize("floats", [True, False])
def test_ezc3d_reads_what_fill_writes(tmp_path, order, floats):
    trial = with_poses(n=80, rate=200.0)
    write_c3d(tmp_path / "a.c3d", trial, order=order, floats=floats)
    done = fill_file(tmp_path / "a.c3d", tmp_path / "b.c3d", method=Linear(), name="linear", limit_mm=np.inf)
    for name in "ab":
        rotations, labels, points = by_ezc3d(tmp_path / f"{name}.c3d", tmp_path)
        wanted = trial.poses[0].T_world_segment
        assert rotations.shape == wanted.shape and list(labels) == list(trial.poses[0].names)
        known = np.isfinite(wanted).all((2, 3))
        assert np.array_equal(rotations[known], wanted[known])
    assert np.isfinite(points[:3, :, 3:11]).all() and same(done.trial.poses, trial.poses)


def test_what_ezc3d_writes_is_read_and_written_again(tmp_path):
    code = """
import ezc3d, numpy as np, sys
c = ezc3d.c3d()
c["parameters"]["POINT"]["RATE"]["value"] = [50.0]
c["parameters"]["POINT"]["LABELS"]["value"] = ["a"]
c["data"]["points"] = np.ones((4, 1, 12))
c["data"]["analogs"] = np.zeros((1, 0, 12))
c.add_parameter("ROTATION", "LABELS", ["p", "q"])
c["data"]["rotations"] = np.arange(4 * 4 * 2 * 36.0).reshape(4, 4, 2, 36)
c.write(sys.argv[1])
"""
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "a.c3d")], check=True, timeout=100)
    trial = read_c3d(tmp_path / "a.c3d")
    (poses,) = trial.poses
    assert (poses.names, poses.rate) == (("p", "q"), 150.0)
    wanted = np.moveaxis(np.arange(4 * 4 * 2 * 36.0).reshape(4, 4, 2, 36), (2, 3), (0, 1))
    assert np.array_equal(poses.T_world_segment, wanted)
    write_c3d(tmp_path / "b.c3d", trial.frames(3, 9))
    assert np.array_equal(by_ezc3d(tmp_path / "b.c3d", tmp_path)[0], wanted[:, 9:27])


def test_translations_have_the_unit_of_the_points(tmp_path):
    write_c3d(tmp_path / "a.c3d", with_poses())
    metres, mm = (read_c3d(tmp_path / "a.c3d", units=unit).poses[0].T_world_segment for unit in ("m", "mm"))
    assert np.allclose(metres[..., :3, 3], 1000 * mm[..., :3, 3], equal_nan=True)
    assert np.array_equal(metres[..., :3, :3], mm[..., :3, :3], equal_nan=True)


def test_a_file_that_ends_within_its_rotations_is_refused_or_read_in_part(tmp_path):
    write_c3d(tmp_path / "a.c3d", with_poses())
    raw = (tmp_path / "a.c3d").read_bytes()
    cut = raw[: len(raw) - 2000]
    with pytest.raises(KinemarkError, match="rotations"):
        decode_document(cut, name="cut")
    part = trial_of(decode_document(cut, name="cut", partial=True), name="cut")
    whole = read_c3d(tmp_path / "a.c3d")
    assert same(part.trajectories, whole.trajectories) and any("rotations" in note for note in part.notes)


def test_a_useless_pointer_is_replaced_by_the_end_of_the_data():
    doc = document_of(with_poses())
    raw = bytearray(encode_document(doc))
    at = raw.index(b"DATA_START", raw.index(b"ROTATION")) + len("DATA_START") + 4
    raw[at : at + 2] = (1).to_bytes(2, "little")
    assert same(decode_document(bytes(raw), name="made").rotations, doc.rotations)


def test_hdf5_keeps_poses_and_all_of_a_c3d_file(tmp_path):
    write_c3d(tmp_path / "a.c3d", with_poses())
    trial = read_c3d(tmp_path / "a.c3d")
    assert write_trial(trial, tmp_path / "b.h5") == ()
    back = read_trial(tmp_path / "b.h5")
    assert same(back, trial)
    write_trial(back, tmp_path / "c.c3d")
    assert (tmp_path / "c.c3d").read_bytes() == (tmp_path / "a.c3d").read_bytes()


def test_poses_of_another_clock_are_named(tmp_path):
    trial = replace(made_trial(), poses=(made_poses(rate=130.0), made_poses(("other",))))
    notes = write_c3d(tmp_path / "a.c3d", trial)
    assert [(n.kind, n.what, n.names) for n in notes if n.what == "poses"] == [
        ("not_written", "poses", ("other",)),
        ("not_written", "poses", ("pelvis", "thigh", "shank")),
    ]


@pytest.mark.parametrize("size", [512, 1024])
def test_a_block_of_zeros_that_fills_a_file_up_is_kept_and_not_worth_a_word(size):
    """As ezc3d writes it where the last frame ends with a block."""
    raw = encode_document(document_of(made_trial())) + bytes(size)
    doc = decode_document(raw, name="made")
    assert not any("not understood" in note for note in doc.notes) and encode_document(doc) == raw


@pytest.mark.parametrize("size", [512, 700, 5000])
@pytest.mark.parametrize("poses", [True, False])
def test_bytes_that_nobody_understands_are_kept(size, poses):
    trial = with_poses() if poses else made_trial()
    rest = np.random.default_rng(1).integers(1, 255, size).astype(np.uint8).tobytes()
    raw = encode_document(document_of(trial)) + rest
    doc = decode_document(raw, name="made")
    assert doc.tail.lstrip(b"\0") == rest and any("not understood" in note for note in doc.notes)
    assert encode_document(doc) == raw
    shorter = encode_document(document_of(trial_of(doc, name="t").frames(2, 30)))
    assert decode_document(shorter, name="made").tail.lstrip(b"\0") == rest


@pytest.mark.parametrize("floats", [True, False])
def test_a_trial_of_poses_alone_comes_back(tmp_path, floats):
    """As systems without markers write it."""
    trial = Trial("poses", Trajectories((), 50.0), poses=(made_poses(n=90, rate=150.0),))
    write_c3d(tmp_path / "a.c3d", trial, floats=floats)
    back = read_c3d(tmp_path / "a.c3d")
    assert same(back.poses, trial.poses)
    write_c3d(tmp_path / "b.c3d", back)
    assert same(read_c3d(tmp_path / "b.c3d").poses, trial.poses)
    assert by_ezc3d(tmp_path / "b.c3d", tmp_path)[0].shape == (3, 90, 4, 4)
