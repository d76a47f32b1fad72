"""Records as HDF5."""

from dataclasses import fields, replace

import h5py
import numpy as np
import pytest

from kinemark.data import (
    Analog,
    Cloud,
    Detections,
    Events,
    Fills,
    ForcePlate,
    KinemarkError,
    MarkerTrajectory,
    Matches,
    Origin,
    Signal,
    Signals,
    Step,
    Tracks,
    Trajectories,
    Trial,
    same,
)
from kinemark.io.records import FORMER, load, save, seal


def detections(rng, n_frames=5):
    counts = rng.integers(0, 4, (3, n_frames))
    n = counts.sum()
    shape = {name: rng.normal(size=n) for name in ("area", "width", "height", "peak")}
    made = Detections.build(
        ("a", "b é", ""), 59.94, counts, rng.normal(size=(n, 2)), rng.normal(size=(n, 2, 2)), **shape
    )
    return replace(made, validity=rng.integers(0, 6, n), peak=np.where(made.peak > 0, np.nan, made.peak))


def cloud(rng, n_frames=6):
    counts = rng.integers(0, 3, n_frames)
    n = counts.sum()
    start = np.concatenate([[0], np.cumsum(counts)])
    return Cloud(
        250.0,
        start,
        rng.normal(size=(n, 3)),
        rng.normal(size=(n, 3, 3)),
        rng.normal(size=n),
        rng.integers(-1, 9, (n, 4)),
    )


def matches(rng, n=8):
    return Matches(np.sort(rng.integers(0, 12, n)), rng.integers(-1, 9, (n, 3)), rng.normal(size=n), 12)


def tracks(rng):
    points = cloud(rng)
    return Tracks(points, np.arange(len(points)) - points.start[points.frame] - 1)


def trajectories(rng, n=7):
    """One marker whose images are known, one whose are not."""
    seen = MarkerTrajectory.measured("a é", rng.normal(size=(n, 3)), detection=rng.integers(-1, 9, (n, 4)))
    xyz = np.where(np.arange(n)[:, None] == 2, np.nan, rng.normal(size=(n, 3)))
    other = MarkerTrajectory.measured("b", xyz, cov=rng.normal(size=(n, 3, 3)), residual=rng.random(n), cameras=[5] * n)
    return Trajectories((seen, other), 59.94, 12)


def fills(rng):
    before = trajectories(rng)
    path = before.paths[1]
    origin = np.where(path.origin == Origin.MISSING, Origin.FILLED, path.origin)
    filled = replace(path, xyz=np.nan_to_num(path.xyz), origin=origin)
    return Fills.between(before, replace(before, paths=(before.paths[0], filled)), ('{"marker": "b"}',))


def signals(rng):
    knee = Signal(
        "knee", "moment", "N·m/kg", ("x", "y"), 50.0, rng.normal(size=(4, 2)), rng.random((4, 2, 2)), -0.5, "of"
    )
    return Signals((knee, Signal.of("hip", "angle", "deg", rng.normal(size=(6, 3)), rate=100.0)))


def trial(rng):
    analog = Analog(("a", "b"), ("V", ""), 333.3, rng.normal(size=(2, 9)), 0.125)
    plates = (
        ForcePlate(4, rng.normal(size=(4, 3)), rng.normal(size=3), ("a", "b"), rng.normal(size=(6, 6))),
        ForcePlate(2, np.full((4, 3), np.nan), np.zeros(3), ()),
    )
    events = Events(("Foot Strike", "x"), ("Left", ""), np.array([0.25, np.nan]))
    steps = (Step("detect", "Centroids", {"threshold": 40, "of": [1.5, None]}, "0.1.0", "abc", 1.5),)
    return Trial("walk é", trajectories(rng), (analog, analog), plates, events, None, steps, signals(rng))


EMPTY = (
    Detections.build((), 50.0, np.zeros((0, 4)), np.zeros((0, 2))),
    cloud(np.random.default_rng(0), 0),
    matches(np.random.default_rng(0), 0),
    Trajectories((), 50.0),
    Signals(),
    Trial("", Trajectories((), 50.0)),
)
MAKERS = (detections, cloud, matches, tracks, trajectories, fills, signals, trial)


@pytest.mark.parametrize("make", MAKERS)
@pytest.mark.parametrize("seed", range(5))
def test_a_record_comes_back_the_same(tmp_path, make, seed):
    record = make(np.random.default_rng(seed))
    save(tmp_path / "r.h5", record)
    assert same(load(tmp_path / "r.h5"), record)


@pytest.mark.parametrize("record", EMPTY, ids=lambda r: type(r).__name__)
def test_an_empty_record_comes_back_the_same(tmp_path, record):
    save(tmp_path / "r.h5", record)
    assert same(load(tmp_path / "r.h5"), record)


def test_the_file_says_what_it_holds(tmp_path):
    save(tmp_path / "r.h5", tracks(np.random.default_rng(0)))
    with h5py.File(tmp_path / "r.h5") as file:
        assert (file.attrs["format"], file.attrs["version"], file.attrs["record"]) == ("kinemark", 1, "Tracks")
        units = {name: data.attrs["unit"] for name, data in file["cloud"].items()}
        assert units == {"xyz": "mm", "cov": "mm2", "residual": "px", "detection": "1", "start": "1"}
        assert file["cloud"].attrs["rate_Hz"] == 250.0


def former_names(group):
    for name, former in FORMER.items():
        if name in group:
            group.move(name, former)
        if name in group.attrs:
            group.attrs[former] = group.attrs[name]
            del group.attrs[name]
    for inner in filter(lambda one: isinstance(one, h5py.Group), group.values()):
        former_names(inner)


@pytest.mark.parametrize("make", [cloud, matches, tracks, trajectories, fills, trial])
def test_a_file_with_former_names_of_fields_is_read(tmp_path, make):
    record, path = make(np.random.default_rng(0)), tmp_path / "r.h5"
    save(path, record)
    with h5py.File(path, "r+") as file:
        former_names(file)
    assert path.read_bytes().count(b"view") + path.read_bytes().count(b"told") > 0
    seal(path)
    assert same(load(path), record)


@pytest.mark.parametrize("make", MAKERS)
def test_every_truncation_is_refused(tmp_path, make):
    path = tmp_path / "r.h5"
    save(path, make(np.random.default_rng(0)))
    data = path.read_bytes()
    for cut in range(0, len(data), 499):
        path.write_bytes(data[:cut])
        with pytest.raises(KinemarkError, match=r"r\.h5"):
            load(path)


def broken(path, change):
    save(path, detections(np.random.default_rng(0)))
    with h5py.File(path, "r+") as file:
        change(file)
    seal(path)


def unwritten(file):
    """A column that takes no room in the file and all of the memory."""
    del file["uv"]
    file.create_dataset("uv", (1 << 40, 2), "f8")


def outside(file):
    del file["uv"]
    file["uv"] = h5py.ExternalLink("other.h5", "/uv")


def retyped(name, dtype):
    def change(file):
        values = file[name][()].astype(dtype)
        del file[name]
        file[name] = values

    return change


CHANGES = {
    "no column": lambda file: file.__delitem__("uv"),
    "column of another type": retyped("uv", "f4"),
    "column of another length": lambda file: (file.__delitem__("area"), file.create_dataset("area", data=np.zeros(1))),
    "unwritten column": unwritten,
    "column outside": outside,
    "group for a column": lambda file: (file.__delitem__("uv"), file.create_group("uv")),
    "compressed": lambda file: (
        file.__delitem__("uv"),
        file.create_dataset("uv", data=np.zeros((9, 2)), compression=9),
    ),
    "offsets that fall": lambda file: file["start"].write_direct(file["start"][()][:, ::-1].copy()),
    "no rate": lambda file: file.attrs.__delitem__("rate_Hz"),
    "rate in words": lambda file: file.attrs.__setitem__("rate_Hz", "fast"),
    "cameras as a number": lambda file: file.attrs.__setitem__("cameras", 3),
    "later version": lambda file: file.attrs.__setitem__("version", 2),
    "version in words": lambda file: file.attrs.__setitem__("version", "new"),
    "another program's": lambda file: file.attrs.__delitem__("format"),
    "another record": lambda file: file.attrs.__setitem__("record", "Cloud"),
    "unknown record": lambda file: file.attrs.__setitem__("record", np.arange(3)),
}


@pytest.mark.parametrize("what", CHANGES)
def test_a_file_that_is_not_ours_is_refused(tmp_path, what):
    broken(tmp_path / "r.h5", CHANGES[what])
    with pytest.raises(KinemarkError, match=r"r\.h5"):
        load(tmp_path / "r.h5")


def test_every_damage_is_found(tmp_path):
    """The HDF5 library may crash on damaged files, so none may reach it."""
    path, rng = tmp_path / "r.h5", np.random.default_rng(0)
    save(path, tracks(rng))
    data = path.read_bytes()
    for at in rng.integers(0, len(data), 300):
        damaged = bytearray(data)
        damaged[at] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        with pytest.raises(KinemarkError, match=r"r\.h5"):
            load(path)


def test_other_files_are_refused(tmp_path):
    (tmp_path / "r.h5").write_bytes(b"frame,u,v\n" * 100)
    with h5py.File(tmp_path / "plain.h5", "w") as file:
        file["uv"] = np.zeros((3, 2))
    with pytest.raises(KinemarkError, match="not a file that Kinemark wrote"):
        load(tmp_path / "plain.h5")
    for path in (tmp_path / "r.h5", tmp_path / "absent.h5", tmp_path):
        with pytest.raises(KinemarkError):
            load(path)


def test_only_records_are_saved_and_nothing_is_left_behind(tmp_path):
    save(tmp_path / "r.h5", matches(np.random.default_rng(0)))
    before = (tmp_path / "r.h5").read_bytes()
    with pytest.raises(ValueError, match="Events"):
        save(tmp_path / "r.h5", Events())
    assert [p.name for p in tmp_path.iterdir()] == ["r.h5"] and (tmp_path / "r.h5").read_bytes() == before


@pytest.mark.parametrize("make", MAKERS)
def test_every_field_is_stored(tmp_path, make):
    """A field that is added to a record must not be lost on disk."""
    record = make(np.random.default_rng(0))
    save(tmp_path / "r.h5", record)
    with h5py.File(tmp_path / "r.h5") as file:
        stored = {name.removesuffix("_Hz") for name in (*file, *file.attrs)}
    assert {f.name for f in fields(record)} - {"source"} <= stored  # what a trial's own file held besides is not kept
