"""C3D: covariances and origins of markers come back, and no other reader minds them."""

import json
import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark.data import MarkerTrajectory, Origin, Trajectories, Trial, same
from kinemark.engine.angles.of_trial import AngleSettings, angles_of_file
from kinemark.io.c3d import ByteOrder, decode_document, document_of, encode_document, read_c3d, trial_of, write_c3d
from kinemark.io.trial import write_trial
from kinemark.synth.arm import arm
from support.examples import examples
from support.poses import made_poses
from support.trials import made_trial

READERS = """
import pickle, sys, ezc3d, c3d, numpy as np
with open(sys.argv[2], "rb") as file:
    frames = [(points.copy(), analog.copy()) for _, points, analog in c3d.Reader(file).read_frames()]
found = ezc3d.c3d(sys.argv[2])["data"]
one = np.array([points[:, :3] for points, _ in frames]), np.concatenate([analog for _, analog in frames], 1)
two = found["points"][:3].transpose(2, 1, 0), found["analogs"][0]
pickle.dump((one, two), open(sys.argv[1], "wb"))
"""


def certain(trial, seed=3):
    """The trial with covariances at most of its samples and some that were edited."""
    rng, paths = np.random.default_rng(seed), []
    for path in trial.trajectories:
        half = rng.normal(size=(len(path), 3, 3))
        cov = (half @ half.swapaxes(1, 2)).astype(np.float32).astype(float)
        cov[(rng.random(len(path)) < 0.2) | (path.origin == Origin.MISSING)] = np.nan
        edited = (rng.random(len(path)) < 0.1) & (path.origin == Origin.MEASURED)
        paths.append(replace(path, cov=cov, origin=np.where(edited, Origin.EDITED, path.origin)))
    return replace(trial, trajectories=replace(trial.trajectories, paths=tuple(paths)))


@settings(max_examples=examples(12), deadline=None)
@given(
    order=st.sampled_from(list(ByteOrder)),
    floats=st.booleans(),
    shape=st.sampled_from([(1, 1), (40, 5), (3, 260)]),
    first=st.sampled_from([1, 725, 70000]),
    poses=st.booleans(),
    seed=st.integers(0, 1000),
)
def test_covariances_and_origins_come_back(order, floats, shape, first, poses, seed):
    n, m = shape
    trial = certain(made_trial(n=n, m=m, first_frame=first), seed) if n == 40 else certain(simple(n, m, first), seed)
    trial = replace(trial, poses=(made_poses(n=n, rate=trial.trajectories.rate),) if poses else ())
    back = trial_of(
        decode_document(encode_document(document_of(trial, order=order, floats=floats)), name="m"), name="m"
    )
    for old, new in zip(trial.trajectories, back.trajectories, strict=True):
        assert np.array_equal(old.cov, new.cov, equal_nan=True) and np.array_equal(old.origin, new.origin)
    assert not any("positions" in note for note in back.notes) and same(back.poses, trial.poses)
    assert encode_document(document_of(back)) == encode_document(back.source)
    again = trial_of(decode_document(encode_document(document_of(back.frames(0, n // 2 + 1))), name="m"), name="m")
    assert same(again.trajectories, back.frames(0, n // 2 + 1).trajectories)


@pytest.mark.parametrize("order", list(ByteOrder))
@pytest.mark.parametrize("floats", [True, False])
def test_a_coordinate_just_below_zero_does_not_lose_the_covariances(order, floats):
    """Rounded to a count, or stored as −0, it comes back as 0."""
    xyz = np.array([[-1e-9, 200.0, 300.0], [-0.0, 201.0, 301.0]])
    cov = np.broadcast_to(np.eye(3), (2, 3, 3))
    path = replace(MarkerTrajectory.measured("m", xyz), cov=cov)
    doc = document_of(Trial("t", Trajectories((path,), 100.0)), order=order, floats=floats)
    back = trial_of(decode_document(encode_document(doc), name="m"), name="m")
    assert np.array_equal(back.trajectories["m"].cov, cov) and not back.notes


def simple(n, m, first):
    xyz = np.random.default_rng(n).normal(0, 500, (m, n, 3)).astype(np.float32)
    return Trial(
        "s", Trajectories(tuple(MarkerTrajectory.measured(f"m{i}", x) for i, x in enumerate(xyz)), 50.0, first)
    )


@pytest.mark.parametrize("floats", [True, False])
def test_other_readers_read_the_file(tmp_path, floats):
    write_c3d(tmp_path / "a.c3d", certain(made_trial()), floats=floats)
    write_c3d(tmp_path / "b.c3d", made_trial(), floats=floats)
    found = []
    for name in "ab":
        command = [sys.executable, "-c", READERS, str(tmp_path / name), str(tmp_path / f"{name}.c3d")]
        subprocess.run(command, check=True, timeout=100)
        found.append(pickle.loads((tmp_path / name).read_bytes()))
    for with_table, without in zip(*found, strict=True):
        for ours, theirs in zip(with_table, without, strict=True):
            assert np.array_equal(ours, theirs, equal_nan=True)


def test_more_than_65535_frames_with_covariances(tmp_path):
    n = 70001
    xyz = np.arange(3 * n).reshape(n, 3).astype(np.float32) + 1
    path = MarkerTrajectory.measured("a", xyz, cov=np.broadcast_to(np.eye(3), (n, 3, 3)))
    write_c3d(tmp_path / "a.c3d", Trial("long", Trajectories((path,), 1000.0)))
    back = read_c3d(tmp_path / "a.c3d").trajectories
    assert back.n_frames == n and same(back["a"].cov, path.cov) and same(back["a"].xyz, path.xyz)


def test_a_table_of_other_positions_is_not_used():
    doc = document_of(certain(made_trial()))
    moved = replace(doc, points=doc.points + (doc.points != 0))
    trial = trial_of(decode_document(encode_document(moved), name="m"), name="m")
    assert all(np.isnan(path.cov).all() for path in trial.trajectories)
    assert any("other positions" in note for note in trial.notes)


def test_damage_of_the_table_never_harms():
    raw = encode_document(document_of(certain(made_trial())))
    start, rng = raw.index(b"KINEMARK SAMPLES"), np.random.default_rng(0)
    wanted = trial_of(decode_document(raw, name="m"), name="m").trajectories
    for at in rng.integers(start, len(raw), 100):
        damaged = bytearray(raw)
        damaged[at] ^= 1 << int(rng.integers(8))
        found = trial_of(decode_document(bytes(damaged), name="m", partial=True), name="m").trajectories
        assert same(found.xyz, wanted.xyz)


def test_angles_of_our_own_file_keep_their_error_bars(tmp_path):
    moving = arm(duration_s=1.0, seed=2)
    cov = np.broadcast_to(np.diag([0.04, 0.09, 0.16]), (moving.xyz.shape[1], 3, 3))
    paths = tuple(MarkerTrajectory.measured(n, x, cov=cov) for n, x in zip(moving.names, moving.xyz, strict=True))
    found = {}
    for ending in (".c3d", ".h5"):
        write_trial(Trial("a", Trajectories(paths, 50.0)), tmp_path / f"a{ending}")
        result = angles_of_file(
            tmp_path / f"a{ending}", model="um2as", folder=tmp_path / ending[1:], settings=AngleSettings()
        )
        assert "As the covariance of each marker" in json.dumps(result.figures)
        found[ending] = result.angles.cov
    assert np.allclose(found[".c3d"], found[".h5"], rtol=1e-3, equal_nan=True)
