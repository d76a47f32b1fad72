"""C3D: laws of the round trips, on recordings made here."""

import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Analog, Events, KinemarkError, MarkerTrajectory, Origin, Trajectories, Trial, same
from kinemark.io.c3d import (
    C3D,
    ByteOrder,
    Group,
    HeaderEvent,
    Parameter,
    decode_document,
    document_of,
    encode_document,
    read_c3d,
    read_document,
    trial_of,
    with_parameters,
    write_c3d,
    write_document,
)
from support.trials import made_trial

FORMATS = [(order, floats) for order in ByteOrder for floats in (True, False)]


def blank(points, word=None, groups=(), **facts):
    """A document of these points in file units."""
    points = np.asarray(points, float)
    word = np.zeros(points.shape[:2]) if word is None else np.asarray(word, float)
    none = np.zeros((0, 0))
    return C3D(**{
        "order": ByteOrder.INTEL, "floats": True, "rate": 100.0, "points": points, "word": word, "analog": none,
        "samples": 0, "groups": tuple(groups), **facts,
    })  # fmt: skip


def again(doc):
    return decode_document(encode_document(doc), name="made")


def test_text_is_read_as_utf8_or_latin1_and_its_bytes_are_kept():
    p = Parameter("UNITS", np.frombuffer("°  µ\0xµ".encode("latin-1"), np.uint8).reshape(1, 7))
    assert p.texts == ("°  µ",)
    assert Parameter.text("UNITS", ["µV", "N"]).texts == ("µV", "N")
    assert same(again(blank(np.ones((1, 1, 3)), groups=[Group(1, "ANALOG", (p,))])).get("analog", "units"), p)


def test_hundreds_of_parameters_and_127_groups_come_back():
    many = tuple(Parameter.real(f"P{i}", i) for i in range(1000))
    doc = blank(np.ones((2, 1, 3)), groups=[Group(i, f"G{i}", many if i == 9 else ()) for i in range(1, 128)])
    assert same(again(doc).groups, doc.groups)
    with pytest.raises(ValueError, match="127"):
        with_parameters(doc, "ONE_MORE", [])


# Round trips


@pytest.mark.parametrize(("order", "floats"), FORMATS)
def test_a_trial_comes_back_in_every_format(tmp_path, order, floats):
    trial = made_trial()
    write_c3d(tmp_path / "t.c3d", trial, order=order, floats=floats)
    back = read_c3d(tmp_path / "t.c3d")
    assert back.trajectories.names == trial.trajectories.names
    assert (back.trajectories.rate, back.trajectories.first_frame) == (100.0, 7)
    doc, a, b = back.source, trial.trajectories, back.trajectories
    assert (doc.order, doc.floats) == (order, floats)
    single = a.xyz.astype(np.float32).astype(float)
    if floats:
        assert np.array_equal(b.xyz, single, equal_nan=True)
    else:
        assert np.nanmax(np.abs(b.xyz - a.xyz)) <= doc.scale * 0.5001
    for old, new in zip(a, b, strict=True):
        assert np.array_equal(old.origin, new.origin)
        assert np.array_equal(old.cameras, new.cameras)
        assert np.array_equal(np.isnan(old.residual), np.isnan(new.residual))
        assert np.nanmax(np.abs(old.residual - new.residual)) <= doc.scale
    channels, found = trial.analog[0], back.analog[0]
    assert (found.names, found.units, found.rate) == (channels.names, channels.units, 400.0)
    error = np.abs(found.values - channels.values).max(1) / np.abs(channels.values).max(1)
    assert error.max() <= (1e-7 if floats else 0.51 / 32000)
    assert same(back.plates, trial.plates)
    assert (back.events.label, back.events.side) == (trial.events.label, trial.events.side)
    assert np.allclose(back.events.time, trial.events.time, atol=1e-6)


# In a process of its own, because ezc3d can crash and c3d warns.
READERS = """
import pickle, sys, ezc3d, c3d, numpy as np
out = {}
for path in sys.argv[2:]:
    with open(path, "rb") as file:
        frames = [(points.copy(), analog.copy()) for _, points, analog in c3d.Reader(file).read_frames()]
    analog = np.array([analog for _, analog in frames])
    analog = np.concatenate(analog, 1) if analog.ndim == 3 else np.zeros((0, len(frames)))
    out[path, "c3d"] = np.array([points[:, :3] for points, _ in frames]), analog
    if "SGI" not in path:  # which ezc3d does not read
        found = ezc3d.c3d(path)
        points = found["data"]["points"][:3].transpose(2, 1, 0)
        out[path, "ezc3d"] = points, found["data"]["analogs"][0]
pickle.dump(out, open(sys.argv[1], "wb"))
"""


def test_other_readers_find_what_was_written(tmp_path):
    trial, paths = made_trial(), []
    for order, floats in FORMATS:
        paths.append(str(tmp_path / f"{order.name}-{floats}.c3d"))
        write_c3d(paths[-1], trial, order=order, floats=floats)
    long = Trial("long", Trajectories((MarkerTrajectory.measured("a", np.ones((70001, 3))),), 100.0))
    paths.append(str(tmp_path / "long.c3d"))
    write_c3d(paths[-1], long)
    subprocess.run([sys.executable, "-c", READERS, tmp_path / "out", *paths], check=True, timeout=100)
    found = pickle.loads((tmp_path / "out").read_bytes())
    assert len(found) == 2 * len(paths) - 2
    for (path, _), (points, analog) in found.items():
        doc = read_document(path)
        seen = doc.word >= 0
        assert points.shape == doc.points.shape
        assert np.allclose(points[seen], doc.points[seen], rtol=1e-6, atol=0)
        values = [record.values for record in trial_of(doc, name="t").analog] or [analog]
        assert np.allclose(analog, values[0], rtol=1e-5, atol=1e-6 * np.abs(values[0]).max(initial=0))


@pytest.mark.parametrize(("order", "floats"), FORMATS)
def test_what_was_read_is_written_again_number_by_number(tmp_path, order, floats):
    write_c3d(tmp_path / "a.c3d", made_trial(), order=order, floats=floats)
    first = read_c3d(tmp_path / "a.c3d")
    write_c3d(tmp_path / "b.c3d", first)
    assert (tmp_path / "a.c3d").read_bytes() == (tmp_path / "b.c3d").read_bytes()
    assert same(document_of(first), first.source)


@pytest.mark.parametrize(("order", "floats"), FORMATS)
def test_documents_come_back(tmp_path, order, floats):
    rng = np.random.default_rng(2)
    counts, unsigned = rng.integers(-32768, 32768, (9, 4, 3)), rng.integers(0, 65536, (3, 18))
    doc = blank(
        counts * 0.25, rng.integers(-1, 32767, (9, 4)), order=order, floats=floats, scale=0.25, analog=unsigned,
        samples=2, first_frame=300, max_gap=10, header_events=(HeaderEvent("RHS ", 1.5, 1), HeaderEvent("LTO ", 2, 0)),
        groups=[Group(3, "ANALOG", (Parameter.text("FORMAT", "UNSIGNED"), Parameter.whole("USED", 3)))],
    )  # fmt: skip
    write_document(tmp_path / "d.c3d", doc)
    assert same(read_document(tmp_path / "d.c3d"), doc)


def test_more_than_255_points_channels_and_events(tmp_path):
    names, n = [f"marker{i}" for i in range(600)], 3
    xyz = np.random.default_rng(3).normal(size=(600, n, 3)) * 100
    trial = Trial(
        "many",
        Trajectories(tuple(MarkerTrajectory.measured(name, x) for name, x in zip(names, xyz, strict=True)), 50.0),
        (Analog(tuple(f"c{i}" for i in range(300)), ("V",) * 300, 50.0, np.arange(900.0).reshape(300, 3)),),
        events=Events(tuple(f"e{i}" for i in range(300)), ("Left",) * 300, np.arange(300.0)),
    )
    write_c3d(tmp_path / "t.c3d", trial)
    back = read_c3d(tmp_path / "t.c3d")
    assert back.trajectories.names == tuple(names)
    assert back.source.get("POINT", "LABELS3").values.shape[0] == 90
    assert same(back.analog, trial.analog) and same(back.events, trial.events)
    fewer = replace(back, trajectories=replace(back.trajectories, paths=back.trajectories.paths[100:300]))
    write_c3d(tmp_path / "f.c3d", fewer)
    assert read_c3d(tmp_path / "f.c3d").trajectories.names == tuple(names[100:300])


@pytest.mark.parametrize("first_frame", [1, 70000])
def test_more_than_65535_frames(tmp_path, first_frame):
    n = 70001
    xyz = np.arange(3 * n).reshape(n, 3).astype(np.float32)
    trial = Trial("long", Trajectories((MarkerTrajectory.measured("a", xyz + 1),), 1000.0, first_frame))
    write_c3d(tmp_path / "t.c3d", trial)
    back = read_c3d(tmp_path / "t.c3d")
    assert back.trajectories.first_frame == first_frame
    assert np.array_equal(back.trajectories["a"].xyz, xyz + 1)
    assert back.source.number("POINT", "LONG_FRAMES", 0) == n


@pytest.mark.parametrize("stated", [Parameter.whole("FRAMES", 70001 - 65536), Parameter.real("FRAMES", 70001.0)])
@pytest.mark.parametrize("last", [65535, 70001 - 65536])
def test_wrapped_and_float_counts_of_frames(stated, last):
    raw = bytearray(encode_document(blank(np.ones((70001, 1, 3)), groups=[Group(1, "POINT", (stated,))])))
    raw[8:10] = last.to_bytes(2, "little")
    doc = decode_document(bytes(raw), name="made")
    assert len(doc.points) == 70001 and same(doc.groups[0].parameters, (stated,))


@pytest.mark.parametrize(("unit", "mm"), [("mm", 1), ("m", 1000), ("cm", 10), ("in", 25.4), ("Metres", 1000), ("", 1)])
def test_only_lengths_are_converted(tmp_path, unit, mm):
    point = [Parameter.text("UNITS", unit), Parameter.text("LABELS", ["LASI", "LKneeAngles", "LGRF"])]
    point += [Parameter.text("ANGLES", ["LKneeAngles"]), Parameter.text("FORCES", ["LGRF"])]
    doc = blank([[[1, 2, 3]] * 3] * 2, [[5] * 3] * 2, groups=[Group(1, "POINT", tuple(point))], scale=0.5)
    trial = trial_of(doc, name="t")
    assert np.allclose(trial.trajectories.xyz[:, 0], [[mm, 2 * mm, 3 * mm]])
    assert np.array_equal([s.values[0] for s in trial.signals], [[1, 2, 3], [1, 2, 3]])
    assert trial.trajectories["LASI"].residual[0] == 2.5 * mm
    assert trial.trajectories.names == ("LASI",) and trial.signals.names == ("LKneeAngles", "LGRF")
    moved = replace(trial.trajectories["LASI"], xyz=trial.trajectories["LASI"].xyz + mm)
    write_c3d(tmp_path / "t.c3d", replace(trial, trajectories=replace(trial.trajectories, paths=(moved,))))
    assert np.allclose(read_document(tmp_path / "t.c3d").points[0], [[2, 3, 4], [1, 2, 3], [1, 2, 3]])


def test_an_unknown_unit_is_refused_until_it_is_stated(tmp_path):
    write_document(
        tmp_path / "t.c3d", blank([[[1, 2, 3]]], groups=[Group(1, "POINT", (Parameter.text("UNITS", "elle"),))])
    )
    with pytest.raises(KinemarkError, match="elle"):
        read_c3d(tmp_path / "t.c3d")
    trial = read_c3d(tmp_path / "t.c3d", units="cm")
    assert np.array_equal(trial.trajectories.xyz[0], [[10, 20, 30]])
    write_c3d(tmp_path / "u.c3d", trial)
    assert same(read_c3d(tmp_path / "u.c3d").trajectories, trial.trajectories)


def test_the_three_codings_of_a_gap_are_read_and_kept():
    nan = np.nan
    points = [[[0, 0, 0]], [[0, 0, 0]], [[nan, nan, nan]], [[9, 9, 9]], [[1, 0, 0]]]
    doc = blank(points, [[-1], [0], [0], [-1], [0]])
    trial = trial_of(doc, name="t")
    assert list(trial.trajectories.paths[0].origin) == [0, 0, 0, 0, 1]
    stored = document_of(trial)
    assert np.array_equal(stored.points, doc.points, equal_nan=True) and np.array_equal(stored.word, doc.word)


def test_a_force_of_zero_is_no_gap_and_an_angle_of_zero_is():
    point = (Parameter.text("LABELS", ["A", "F"]), Parameter.text("ANGLES", ["A"]), Parameter.text("FORCES", ["F"]))
    trial = trial_of(blank(np.zeros((1, 2, 3)), groups=[Group(1, "POINT", point)]), name="t")
    assert np.isnan(trial.signals["A"].values).all() and not trial.signals["F"].values.any()


def test_a_file_that_marks_everything_as_missing_is_read_and_stays_readable_when_edited():
    doc = blank([[[1, 2, 3], [1e9, 1e9, 1e9]], [[4, 5, 6], [7, 8, 9]]], -np.ones((2, 2)))
    trial = trial_of(doc, name="t")
    assert [list(path.origin) for path in trial.trajectories] == [[1, 1], [0, 1]]
    assert same(document_of(trial).word, doc.word)
    first = trial.trajectories.paths[0]
    edited = replace(first, xyz=first.xyz + np.array([[1, 0, 0], [0, 0, 0]]))
    back = trial_of(again(document_of(replace(trial, trajectories=replace(
        trial.trajectories, paths=(edited, trial.trajectories.paths[1])
    )))), name="t")  # fmt: skip
    assert np.array_equal(back.trajectories.xyz[0], [[2, 2, 3], [4, 5, 6]])
    assert [list(path.origin) for path in back.trajectories] == [[1, 1], [0, 1]]


@pytest.mark.parametrize("floats", [True, False])
def test_a_marker_at_the_origin_is_not_lost(floats):
    trial = Trial("o", Trajectories((MarkerTrajectory.measured("a", [[0, 0, 0], [320, 0, 0]]),), 10.0))
    back = trial_of(again(document_of(trial, floats=floats)), name="o")
    assert list(back.trajectories["a"].origin) == [1, 1]
    assert np.abs(back.trajectories["a"].xyz[0]).max() <= back.source.scale


def test_samples_without_cameras_among_those_with_were_filled():
    trial = trial_of(blank(np.ones((3, 2, 3)), [[0x0105, 0], [0, 0], [0x0200, 5]]), name="t")
    assert [list(path.origin) for path in trial.trajectories] == [[1, Origin.FILLED, 1], [1, 1, 1]]


# What a trial is changed into


def test_edited_markers_keep_their_own_bytes_and_take_their_descriptions_along(tmp_path):
    write_c3d(tmp_path / "a.c3d", made_trial())
    trial = read_c3d(tmp_path / "a.c3d")
    doc = with_parameters(trial.source, "POINT", [Parameter.text("DESCRIPTIONS", [f"about {i}" for i in range(5)])])
    old = trial.trajectories
    extra = MarkerTrajectory.measured("new", np.full((40, 3), 5000.0))
    paths = (old["M3"], extra, replace(old["M0"], name="renamed"), old["M1"])
    changed = replace(trial, trajectories=replace(old, paths=paths), source=doc)
    back = trial_of(again(document_of(changed)), name="a")
    assert back.trajectories.names == ("M3", "new", "renamed", "M1")
    assert back.source.texts("POINT", "DESCRIPTIONS") == ("about 3", "", "", "about 1")
    assert same(back.trajectories["M1"], old["M1"])
    assert np.array_equal(back.trajectories["renamed"].xyz, old["M0"].xyz, equal_nan=True)
    assert same(back.plates, trial.plates)


def test_cutting_frames_keeps_time_and_numbers(tmp_path):
    write_c3d(tmp_path / "a.c3d", made_trial())
    trial = read_c3d(tmp_path / "a.c3d")
    cut = tuple(
        MarkerTrajectory(p.name, p.xyz[10:], p.cov[10:], p.origin[10:], p.residual[10:], p.cameras[10:])
        for p in trial.trajectories
    )
    analog = replace(trial.analog[0], values=trial.analog[0].values[:, 40:])
    shorter = replace(trial, trajectories=Trajectories(cut, 100.0, 17), analog=(analog,))
    doc = document_of(shorter)
    assert np.array_equal(doc.points, trial.source.points[10:]) and np.array_equal(doc.word, trial.source.word[10:])
    back = trial_of(again(doc), name="a")
    assert back.trajectories.first_frame == 17 and back.trajectories.n_frames == 30
    assert same(back.analog, (analog,)) and same(back.events, trial.events)


def test_changed_events_take_their_properties_along_and_leave_the_header():
    event = [
        Parameter.whole("USED", 2), Parameter.text("LABELS", ["a", "b"]), Parameter.text("CONTEXTS", ["Left", "Right"]),
        Parameter.real("TIMES", [0, 1.5, 1, 2.5]), Parameter.whole("ICON_IDS", [7, 8]),
    ]  # fmt: skip
    doc = blank([[[1, 2, 3]]], groups=[Group(1, "EVENT", tuple(event))], header_events=(HeaderEvent("X   ", 9.0),))
    trial = trial_of(doc, name="t")
    assert trial.events.side == ("Left", "Right") and np.array_equal(trial.events.time, [1.5, 62.5])
    changed = Events(("b", "c"), ("Right", "General"), np.array([62.5, 3.0]))
    back = trial_of(again(document_of(replace(trial, events=changed))), name="t")
    assert same(back.events, changed) and list(back.source.numbers("EVENT", "ICON_IDS")) == [8, 0]
    none = trial_of(again(document_of(replace(trial, events=Events()))), name="t")
    assert len(none.events) == 0


def test_header_events_stand_in_for_an_absent_group():
    doc = blank([[[1, 2, 3]]], header_events=(HeaderEvent("RHS ", 0.5, 1), HeaderEvent("LTO ", 1.25)))
    assert same(trial_of(again(doc), name="t").events, Events(("RHS", "LTO"), ("", ""), np.array([0.5, 1.25])))


def test_analog_without_any_parameter_and_with_unsigned_offsets():
    raw = np.arange(6.0).reshape(2, 3) + 32768
    bare = trial_of(again(blank(np.ones((3, 1, 3)), analog=raw, samples=1)), name="t")
    assert bare.analog[0].names == ("channel 1", "channel 2") and np.array_equal(bare.analog[0].values, raw)
    analog = [
        Parameter.text("FORMAT", "UNSIGNED"),
        Parameter.whole("OFFSET", [32768] * 2),
        Parameter.real("SCALE", [2, 3]),
    ]
    doc = blank(np.ones((3, 1, 3)), analog=raw, samples=1, groups=[Group(1, "ANALOG", tuple(analog))])
    assert np.array_equal(trial_of(again(doc), name="t").analog[0].values, (raw - 32768) * [[2], [3]])


def test_repeated_labels_are_told_apart_and_written_as_they_were():
    labels = Parameter.text("LABELS", ["A", "A", "", "A"])
    trial = trial_of(blank(np.ones((1, 4, 3)), groups=[Group(1, "POINT", (labels,))]), name="t")
    assert trial.trajectories.names == ("A", "A [2]", "*3", "A [3]")
    assert same(document_of(trial).get("POINT", "LABELS"), labels)


# What cannot be


def test_missing_samples_of_channels_are_nan_and_no_integers():
    trial = made_trial()
    analog = trial.analog[0]
    gap = replace(analog, values=np.where(np.arange(160) < 3, np.nan, analog.values))
    assert np.isnan(trial_of(again(document_of(replace(trial, analog=(gap,)))), name="t").analog[0].values[:, :3]).all()
    with pytest.raises(ValueError, match="integers"):
        document_of(replace(trial, analog=(gap,)), floats=False)


def test_a_plate_without_its_channels_is_refused():
    with pytest.raises(ValueError, match="Fx1"):
        document_of(replace(made_trial(), analog=()))


def test_a_failed_write_leaves_the_old_file(tmp_path):
    (tmp_path / "t.c3d").write_bytes(b"old")
    with pytest.raises(ValueError, match="DEC"):
        write_document(tmp_path / "t.c3d", blank(np.full((1, 1, 3), 2e38), order=ByteOrder.DEC))
    assert (tmp_path / "t.c3d").read_bytes() == b"old" and len(list(tmp_path.iterdir())) == 1


# Which samples were filled


def filled_trial(first_frame=7, seed=2):
    """A trial whose source states no cameras, with runs of filled samples."""
    rng = np.random.default_rng(seed)
    paths = []
    for name, runs in (("LKNE", [(3, 6), (30, 40)]), ("RKNE", []), ("LANK", [(0, 1), (39, 40)])):
        path = MarkerTrajectory.measured(name, rng.normal(0, 600, (40, 3)))
        origin = path.origin.copy()
        for a, b in runs:
            origin[a:b] = Origin.FILLED
        paths.append(replace(path, origin=origin))
    return Trial("f", Trajectories(tuple(paths), 100.0, first_frame))


def test_filled_samples_are_told_where_no_camera_is_stated():
    trial = filled_trial()
    back = trial_of(again(document_of(trial)), name="f")
    for path in trial.trajectories:
        assert np.array_equal(back.trajectories[path.name].origin, path.origin)
    rewritten = document_of(back)
    assert rewritten.texts("KINEMARK", "FILLED_POINTS") == ("LKNE", "LKNE", "LANK", "LANK")
    assert rewritten.numbers("KINEMARK", "FILLED_FRAMES").tolist() == [10, 12, 37, 46, 7, 7, 46, 46]


def test_what_was_measured_since_is_not_called_filled():
    doc = again(document_of(filled_trial()))
    word = doc.word.copy()
    word[4, 0] = 5  # another program has measured this one
    back = trial_of(replace(doc, word=word), name="f").trajectories["LKNE"].origin
    assert back[3] == back[5] == Origin.FILLED and back[4] == Origin.MEASURED


def test_a_file_without_fills_gets_no_group_and_nonsense_in_it_is_passed_over():
    plain = Trial("p", Trajectories((MarkerTrajectory.measured("a", np.ones((4, 3))),), 10.0))
    assert not any(group.name == "KINEMARK" for group in document_of(plain).groups)
    group = Group(40, "KINEMARK", parameters=(
        Parameter.text("FILLED_POINTS", ["*1", "nobody", "*1"]),
        Parameter.real("FILLED_FRAMES", [[3.0, 1.0], [1.0, 2.0], [np.nan, 1e30]]),
    ))  # fmt: skip
    trial = trial_of(blank(np.ones((3, 1, 3)), groups=[group]), name="t")
    assert (trial.trajectories["*1"].origin == Origin.MEASURED).all()


def test_integers_of_a_saturated_coordinate_come_back_as_they_are(tmp_path):
    counts = np.random.default_rng(0).integers(-4000, 4000, (9, 4, 3))
    counts[3, 1, 0] = -32768  # one coordinate of three: a position, though an odd one
    trial = trial_of(blank(counts * 0.25, floats=False, scale=0.25), name="made")
    write_c3d(tmp_path / "a.c3d", trial)
    assert np.array_equal(read_c3d(tmp_path / "a.c3d").trajectories.xyz, trial.trajectories.xyz, equal_nan=True)


def test_names_beyond_the_formats_room_are_cut_told_and_still_differ(tmp_path):
    long = "ä" * 70  # 140 bytes
    names = (f"{long}left", f"{long}right", "short", "b" * 127)
    paths = tuple(MarkerTrajectory.measured(name, np.full((3, 3), 10.0 * k)) for k, name in enumerate(names))
    notes = write_c3d(tmp_path / "long.c3d", Trial("long", Trajectories(paths, 100.0)))
    assert [(note.kind, note.what, note.names) for note in notes] == [("shortened", "markers", names[:2])]
    labels = read_c3d(tmp_path / "long.c3d").source.texts("POINT", "LABELS")
    assert labels == ("ä" * 63, "ä" * 62 + "~2", "short", "b" * 127)
