"""Laws of the records: shapes are checked, arrays cannot be changed, and slices and offsets agree."""

import pickle
from dataclasses import FrozenInstanceError, fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinemark.data import (
    Analog,
    Angles,
    Cloud,
    Detections,
    Events,
    ForcePlate,
    MarkerSet,
    MarkerTrajectory,
    Matches,
    Origin,
    Rig,
    Tracks,
    Trajectories,
    Validity,
    same,
)
from support.laboratory import ring


def some_detections(counts, seed=0):
    counts = np.asarray(counts)
    rng = np.random.default_rng(seed)
    n = counts.sum()
    return Detections.build(
        tuple(f"c{i}" for i in range(len(counts))),
        50.0,
        counts,
        rng.normal(size=(n, 2)),
        area=rng.random(n),
        validity=rng.integers(0, 3, n),
    )


def some_cloud(counts=(2, 0, 3), cameras=2):
    n = sum(counts)
    return Cloud(
        100.0,
        np.concatenate([[0], np.cumsum(counts)]),
        np.arange(3.0 * n).reshape(n, 3),
        np.tile(np.eye(3), (n, 1, 1)),
        np.ones(n),
        np.zeros((n, cameras), int),
    )


RECORDS = [
    ring(2)[0],
    ring(2),
    some_detections([[1, 2], [0, 3]]),
    Matches(np.array([0, 0, 1]), np.zeros((3, 2), int), np.zeros(3), 2),
    some_cloud(),
    Tracks(some_cloud(), np.array([0, 1, -1, 0, 1])),
    MarkerTrajectory.measured("a", np.zeros((4, 3))),
    Trajectories((MarkerTrajectory.measured("a", np.zeros((4, 3))),), 50.0),
    MarkerSet(("a", "b"), {"s": ("a",)}, np.array([[0, 1]]), np.array([1.0]), np.array([0.1]), (("a", "b"),)),
    Events(("Foot Strike",), ("Left",), np.array([0.5])),
    Angles(("knee",), ("zxy",), np.zeros((1, 4, 3)), np.zeros((1, 4, 3, 3)), 50.0),
    Analog(("Fz",), ("N",), 1000.0, np.zeros((1, 9))),
    ForcePlate(2, np.zeros((4, 3)), np.zeros(3), ("Fz",), np.eye(6)),
]


@pytest.mark.parametrize("record", RECORDS, ids=lambda r: type(r).__name__)
def test_a_record_cannot_be_changed(record):
    first = fields(record)[0].name
    with pytest.raises(FrozenInstanceError):
        setattr(record, first, None)
    arrays = [getattr(record, f.name) for f in fields(record) if isinstance(getattr(record, f.name), np.ndarray)]
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    assert same(record, record)


@pytest.mark.parametrize("record", RECORDS, ids=lambda r: type(r).__name__)
def test_a_record_shares_memory_with_what_it_was_made_of(record):
    for f in fields(record):
        array = getattr(record, f.name)
        if isinstance(array, np.ndarray) and array.size and f.name not in ("start",):
            assert array.base is not None


@given(st.lists(st.lists(st.integers(0, 4), min_size=5, max_size=5), min_size=1, max_size=4))
def test_offsets_and_columns_of_detections_agree(counts):
    d = some_detections(counts)
    assert (d.counts == counts).all()
    for c in range(len(counts)):
        for f in range(5):
            own = (d.camera == c) & (d.frame == f)
            assert (d[c, f] == d.uv[own]).all()
            assert np.shares_memory(d[c, f], d.uv) or not own.any()


@given(
    st.lists(st.lists(st.integers(0, 4), min_size=6, max_size=6), min_size=1, max_size=3),
    st.integers(0, 6),
    st.integers(0, 6),
)
def test_slicing_detections_in_two_is_slicing_once(counts, a, b):
    d = some_detections(counts)
    whole = d.frames(a, b)
    assert whole.n_frames == max(0, b - a)
    for c in range(len(counts)):
        for f in range(whole.n_frames):
            assert (whole[c, f] == d[c, a + f]).all()
    assert same(d.frames(a, 6).frames(0, max(0, b - a)), whole)
    assert same(d.frames(0, 6), d)


def test_keeping_the_valid_rows_keeps_their_place():
    d = some_detections([[3, 1, 2], [0, 4, 1]], seed=1)
    kept = d.keep(d.valid)
    assert (kept.validity == Validity.VALID).all()
    assert (kept.frame == d.frame[d.valid]).all()
    assert (kept.camera == d.camera[d.valid]).all()
    assert (kept.uv == d.uv[d.valid]).all()


def test_selecting_cameras_reorders_them():
    d = some_detections([[3, 1, 2], [0, 4, 1], [1, 1, 1]])
    turned = d.select(["c2", "c0"])
    assert turned.cameras == ("c2", "c0")
    for f in range(3):
        assert (turned[0, f] == d[2, f]).all()
        assert (turned[1, f] == d[0, f]).all()
    assert same(turned.select(["c0"]), d.select(["c0"]))
    with pytest.raises(ValueError, match="c9"):
        d.select(["c9"])


@pytest.mark.parametrize("start", [[[0, 2, 1, 5]], [[1, 2, 3, 5]], [[0, 2, 3, 4]]])
def test_wrong_offsets_are_refused(start):
    d = some_detections([[2, 1, 2]])
    with pytest.raises(ValueError, match="start"):
        Detections(**{f.name: getattr(d, f.name) for f in fields(d)} | {"start": np.array(start)})


def test_cloud_slices_are_views_and_keep_frames():
    cloud = some_cloud()
    assert np.shares_memory(cloud[2], cloud.xyz)
    assert len(cloud[1]) == 0
    kept = cloud.keep(np.array([True, False, False, True, True]))
    assert (kept.frame == [0, 2, 2]).all()
    assert (kept.xyz == cloud.xyz[[0, 3, 4]]).all()


def test_a_track_has_one_point_a_frame():
    with pytest.raises(ValueError, match="two points"):
        Tracks(some_cloud(), np.array([0, 0, -1, 0, 1]))
    assert (Tracks(some_cloud(), np.array([0, 1, 1, 0, -1])).lengths == [2, 2]).all()


def test_paths_know_their_gaps_and_missing_is_nan():
    xyz = np.ones((9, 3))
    xyz[[0, 3, 4, 7]] = np.nan
    path = MarkerTrajectory.measured("a", xyz)
    assert path.gaps == [(3, 5), (7, 8)]
    assert ((path.origin == Origin.MISSING) == np.isnan(path.xyz[:, 0])).all()
    half = np.ones((2, 3))
    half[0, 1] = np.nan
    assert np.isnan(MarkerTrajectory.measured("b", half).xyz[0]).all()
    with pytest.raises(ValueError, match="MISSING"):
        MarkerTrajectory("a", xyz, path.cov, np.ones(9), path.residual, path.cameras)


def test_trajectories_are_marker_major_and_of_one_length():
    a, b = MarkerTrajectory.measured("a", np.zeros((3, 3))), MarkerTrajectory.measured("b", np.ones((3, 3)))
    both = Trajectories((a, b), 50.0)
    assert both.xyz.shape == (2, 3, 3)
    assert (both["b"].xyz == 1).all()
    assert both.xyz[0].flags.c_contiguous
    with pytest.raises(ValueError, match="one length"):
        Trajectories((a, MarkerTrajectory.measured("c", np.zeros((4, 3)))), 50.0)
    with pytest.raises(KeyError, match="no marker 'x'"):
        both["x"]


def test_wrong_shapes_say_what_was_wanted():
    with pytest.raises(ValueError, match=r"uv has shape \(3,\), wanted"):
        Detections(("a",), 1.0, [[0, 3]], np.zeros(3), *(np.zeros(3) for _ in range(7)))
    with pytest.raises(ValueError, match="rotation"):
        type(ring(2)[0])("x", [0, 0], np.eye(3), 2 * np.eye(3), np.zeros(3))
    with pytest.raises(ValueError, match="differ"):
        Rig((ring(2)[0], ring(2)[0]))
    with pytest.raises(ValueError, match="unknown marker"):
        MarkerSet(("a",), {"s": ("b",)})


def test_a_rig_can_be_reordered_by_name():
    rig = ring(3)
    assert rig.select(["c2", "c0"]).names == ("c2", "c0")
    assert np.allclose(rig.select(["c1"]).centres, rig.centres[1:2])
    with pytest.raises(ValueError, match="c7"):
        rig.select(["c7"])


def test_a_column_of_which_all_rows_are_alike_is_in_memory_once_also_after_pickling():
    uv = np.arange(2000.0).reshape(-1, 2)
    seen = Detections.build(
        ("a",), 100.0, [[400, 600]], uv, cov=np.tile(0.09 * np.eye(2), (1000, 1, 1)), peak=uv[:, 0].copy()
    )
    kept = pickle.dumps(seen)
    assert len(kept) < 2.1 * uv.nbytes  # places, peaks, and two bytes a row
    for one in (seen, pickle.loads(kept), seen.keep(uv[:, 0] > 500)):
        assert one.area.shape == one.peak.shape == (len(one),)
        assert np.isnan(one.area).all() and (one.cov == 0.09 * np.eye(2)).all()
        assert one.area.strides == (0,) and one.cov.strides[0] == 0 and one.peak.strides == (8,)
    assert same(pickle.loads(kept), seen)


def test_detections_that_all_are_at_one_place_are_kept():
    seen = Detections.build(("a",), 100.0, [[2, 1]], np.broadcast_to((3.0, 4.0), (3, 2)))
    assert same(pickle.loads(pickle.dumps(seen)), seen)
