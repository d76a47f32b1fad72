"""TDF: laws on a recorded gait trial, on files built here, and on broken ones."""

import struct

import numpy as np
import pytest

from kinemark.data import KinemarkError, same
from kinemark.engine.formats import convert
from kinemark.geometry import project
from kinemark.io.tdf import TDF_PARTS, Tdf, read_tdf
from support.shared import shared_data
from support.tdf_files import floats, label, segments, tracks_block, write

F4, F8, I4, I2, U2 = "<f4", "<f8", "<i4", "<i2", "<u2"


@pytest.fixture(scope="module")
def gait():
    return read_tdf(shared_data("cameras/gait9_bts/gait9.tdf"))


def test_stored_3d_reprojects_on_stored_2d(gait):
    """The figure that came with the recording: median 0.144 px, 95.3 % of the centroids belong to the tracks."""
    xyz, nearest, taken = gait.trajectories.xyz, [], 0
    for c, camera in enumerate(gait.rig):
        uv = project(camera, xyz)
        for f in range(gait.detections.n_frames):
            seen, wanted = gait.detections[c, f], uv[:, f]
            distance = np.linalg.norm(seen[:, None] - wanted[np.isfinite(wanted).all(1)], axis=-1)
            if distance.size:
                best = distance.min(1)
                nearest.append(best[best < 2])
                taken += (best < 2).sum()
    assert np.median(np.concatenate(nearest)) == pytest.approx(0.144, abs=0.01)
    assert taken / len(gait.detections) == pytest.approx(0.953, abs=0.01)


def test_what_the_recording_holds(gait):
    assert gait.rig.names == gait.detections.cameras == tuple(f"cam{c}" for c in range(1, 8))
    assert (gait.detections.counts.sum(), gait.detections.n_frames, gait.detections.rate) == (203944, 1686, 250.0)
    assert (len(gait.trajectories), gait.trajectories.n_frames, gait.trajectories.first_frame) == (30, 1686, 1)
    assert sum(name.startswith("Mk") for name in gait.trajectories.names) == 6
    assert gait.detections.valid.all() and np.isnan(gait.detections.cov).all()
    assert [(len(a), a.rate, set(a.units)) for a in gait.analog] == [
        (12, 1000.0, {"N", "mm", "N·m"}),
        (6, 1000.0, {"V"}),
    ]


def test_markers_cameras_and_plates_lie_where_they_can(gait):
    low, high = gait.rig.volume
    xyz = gait.trajectories.xyz.reshape(-1, 3)
    corners = np.concatenate([plate.corners for plate in gait.plates])
    for points in (xyz[np.isfinite(xyz).all(1)], corners):
        assert ((points > low) & (points < high)).all()
    assert (np.abs(corners[:, 1]) < 5).all()  # Y is up, and plates lie in the floor
    assert (gait.rig.centres[:, 1] > 2000).all()


def test_force_plate_carries_the_subject_as_c3d_says_it(gait):
    plate, analog = gait.plates[1], gait.analog[0]
    c1, c2, c3, c4 = plate.corners  # C3D: (+x, +y), (−x, +y), (−x, −y), (+x, −y)
    x, y = c1 + c4 - c2 - c3, c1 + c2 - c3 - c4
    axes = np.column_stack([x / np.linalg.norm(x), y / np.linalg.norm(y), np.zeros(3)])
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    channels = np.array([analog[name] for name in plate.channels])
    force = axes @ channels[:3]
    stance = np.flatnonzero(force[1] > 500)
    assert 0.2 < len(stance) / analog.rate < 1.0
    assert 800 < np.median(force[1, stance]) < 1000  # the subject's weight, upwards
    point = plate.corners.mean(0)[:, None] + axes[:, :2] @ channels[3:5]
    toe = gait.trajectories["r met"].xyz[stance // 4]
    assert np.abs((point[:, stance].T - toe)[:, [0, 2]]).max() < 150  # under the right foot
    walking = np.sign(np.nanmean(np.diff(gait.trajectories["sacrum"].xyz[:, 2])))
    early, late = stance[: len(stance) // 4], stance[-len(stance) // 4 :]
    assert walking * force[2, early].mean() < -30  # the floor first brakes
    assert walking * force[2, late].mean() > 30  # and then drives


# --- files built here ------------------------------------------------------------------------------------------------


def rig_block(n=2, model=3, other=(0, 0, 0, 0), turn=None):
    turn = np.eye(3) if turn is None else turn
    head = struct.pack("<ii", n, model) + floats([3, 2, 6]) + floats(turn) + floats([-1, 0, -2])
    cameras = [
        floats(np.eye(3), F8) + floats([0, 1, -5], F8) + floats([600, 601, 255, 190, -0.3, 0.01, *other], F8)
        + struct.pack("<4i", 0, 0, 512, 384)
        for _ in range(n)
    ]  # fmt: skip
    return head + np.arange(n, dtype=I2).tobytes() + b"".join(cameras)


def detections_block(counts, uv, flags=0):
    n_frames, n = counts.shape
    head = struct.pack("<iiifI", n, n_frames, 100, 0.0, flags) + np.arange(n, dtype=U2).tobytes()
    return head + counts.astype(U2).tobytes() + floats(uv)


def wrench_block(form, rows, start=0.0):
    head = struct.pack("<iifi", len(rows), 1000, start, rows.shape[1]) + np.arange(len(rows), dtype=I2).tobytes()
    if form in (1, 3):
        return head + b"".join((label("plate") if form == 3 else b"") + segments(row) for row in rows)
    return head + (label("plate") * len(rows) if form == 4 else b"") + floats(rows.transpose(1, 2, 0))


def plates_block(form, corners):
    head = struct.pack("<ii", len(corners), 0) + np.arange(len(corners), dtype=I2).tobytes()
    second = label("") if form == 2 else b""
    return head + b"".join(label("plate") + floats([0.4, 0.6]) + floats(c) + second for c in corners)


def emg_block(form, values, names):
    head = struct.pack("<iifi", len(values), 1000, 0.0, values.shape[1]) + np.arange(len(values), dtype=I2).tobytes()
    if form == 1:
        return head + b"".join(label(n) + segments(v[:, None]) for n, v in zip(names, values, strict=True))
    return head + b"".join(map(label, names)) + floats(values.T)


def events_block(events):
    items = [label(name) + struct.pack("<ii", len(times) > 1, len(times)) + floats(times) for name, times in events]
    return struct.pack("<if", len(events), 0.0) + b"".join(items)


RNG = np.random.default_rng(5)
XYZ = RNG.uniform(-1, 1, (3, 9, 3)).astype(F4).astype(float)
XYZ[1, 2:4] = XYZ[2, 0] = XYZ[2, 8] = np.nan
ROWS = RNG.uniform(-100, 100, (2, 20, 6)).astype(F4).astype(float)
CORNERS = RNG.uniform(-1, 1, (2, 4, 3)).astype(F4).astype(float)
COUNTS = RNG.integers(0, 4, (9, 2))
UV = RNG.uniform(0, 500, (COUNTS.sum(), 2)).astype(F4).astype(float)
SIGNALS = RNG.normal(size=(2, 15)).astype(F4).astype(float)
WHOLE = (
    (2, 1, rig_block()),
    (4, 2, detections_block(COUNTS, UV)),
    (5, 1, tracks_block(1, XYZ, ["a", "", "c"])),
    (7, 1, plates_block(1, CORNERS)),
    (9, 1, wrench_block(1, ROWS)),
    (11, 1, emg_block(1, SIGNALS, ["tib", "gas"])),
    (16, 1, events_block([("strike", [0.5, 1.5]), ("off", [0.25])])),
)


def test_every_number_comes_back_in_our_units(tmp_path):
    tdf = read_tdf(write(tmp_path / "a.tdf", *WHOLE))
    assert np.array_equal(tdf.trajectories.xyz, 1000 * XYZ, equal_nan=True)
    assert tdf.trajectories.names == ("a", "*2", "c")
    assert np.array_equal(tdf.rig.volume, [[-1000, 0, -2000], [2000, 2000, 4000]])
    assert np.array_equal(tdf.rig[1].centre, [0, 1000, -5000])
    rows = iter(UV)
    for f in range(9):
        for c in range(2):
            assert np.array_equal(tdf.detections[c, f], [next(rows) for _ in range(COUNTS[f, c])] or np.zeros((0, 2)))
    assert np.array_equal(tdf.plates[0].corners, 1000 * CORNERS[0][[2, 3, 0, 1]])
    assert np.array_equal(tdf.analog[0]["Fz2"], -ROWS[1, :, 4]) and np.array_equal(
        tdf.analog[0]["Px1"], 1000 * ROWS[0, :, 0]
    )
    assert np.array_equal(tdf.analog[1]["gas"], SIGNALS[1])
    assert tdf.events.label == ("strike", "strike", "off") and tdf.events.time.tolist() == [0.5, 1.5, 0.25]


@pytest.mark.parametrize(
    ("kind", "forms", "block"),
    [
        (5, (1, 2, 3, 4), lambda form: tracks_block(form, XYZ, ["a", "b", "c"], 0.1)),
        (7, (1, 2), lambda form: plates_block(form, CORNERS)),
        (9, (1, 2, 3, 4), lambda form: wrench_block(form, ROWS, 0.25)),
        (11, (1, 2), lambda form: emg_block(form, SIGNALS, ["x", "y"])),
    ],
)
def test_formats_of_a_block_are_one_content(tmp_path, kind, forms, block):
    read = [read_tdf(write(tmp_path / f"{form}.tdf", (kind, form, block(form)))) for form in forms]
    assert all(same(read[0], other) for other in read[1:])
    assert not same(read[0], Tdf())


def test_times_count_from_the_first_frame(tmp_path):
    blocks = (5, 1, tracks_block(1, XYZ, "abc", 0.5)), (9, 1, wrench_block(1, ROWS, 0.75))
    tdf = read_tdf(write(tmp_path / "a.tdf", *blocks))
    assert (tdf.trajectories.first_frame, tdf.analog[0].start) == (51, 0.25)


def test_parts_that_are_left_out_are_not_looked_at(tmp_path):
    path = write(tmp_path / "a.tdf", *WHOLE[:2], (9, 5, b""))
    with pytest.raises(KinemarkError, match=r"format 5.*parts"):
        read_tdf(path, parts=TDF_PARTS)
    assert read_tdf(path, parts=("rig", "detections")).rig is not None
    assert same(read_tdf(path, parts=()), Tdf())
    with pytest.raises(ValueError, match="videos"):
        read_tdf(path, parts=("videos",))


@pytest.mark.parametrize(
    ("block", "says"),
    [
        ((2, 1, rig_block(model=1)), "lens model 1"),
        ((2, 1, rig_block(other=(0, 1e-3, 0, 0))), "not published"),
        ((2, 2, rig_block()), "format 2"),
        ((2, 1, struct.pack("<ii", -1, 3)), "cameras"),
        ((4, 2, detections_block(COUNTS, UV, flags=1)), "undistorted"),
        ((4, 2, detections_block(COUNTS, UV[:-1])), "promised"),
        ((4, 2, detections_block(COUNTS, np.full_like(UV, np.nan))), "finite"),
        ((5, 1, struct.pack("<iifi", 2**31 - 1, 100, 0.0, 2**31 - 1) + bytes(80)), "proportion"),
        ((5, 1, struct.pack("<iifi", 9, 0, 0.0, 1) + bytes(80)), "rate"),
        ((9, 1, struct.pack("<iifihiiii", 1, 1000, 0.0, 5, 0, 1, 0, 3, 9)), "segment outside"),
        ((16, 1, struct.pack("<if", 2**31 - 1, 0.0)), "promised"),
    ],
)
def test_what_cannot_be_read_is_refused_with_its_reason(tmp_path, block, says):
    with pytest.raises(KinemarkError, match=says):
        read_tdf(write(tmp_path / "a.tdf", block))


def test_a_rotated_volume_is_not_given(tmp_path):
    turn = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    assert np.isnan(read_tdf(write(tmp_path / "a.tdf", (2, 1, rig_block(turn=turn)))).rig.volume).all()


def test_every_truncation_is_refused(tmp_path):
    data = write(tmp_path / "a.tdf", *WHOLE).read_bytes()
    part = tmp_path / "part.tdf"
    for cut in {*range(0, len(data), 97), 16, 24, len(data) - 1}:
        part.write_bytes(data[:cut])
        with pytest.raises(KinemarkError):
            read_tdf(part)


@pytest.mark.parametrize("form", [1, 3])
def test_what_is_whole_of_a_file_that_is_cut_off_is_read_when_asked(tmp_path, form):
    """Blocks before its end, and tracks that stand one after the other; all else is named."""
    blocks = sorted(WHOLE, key=lambda block: block[0] == 5)  # tracks last
    blocks[-1] = (5, form, tracks_block(form, XYZ, ["a", "", "c"]))
    whole = read_tdf(write(tmp_path / "a.tdf", *blocks))
    (tmp_path / "cut.tdf").write_bytes((tmp_path / "a.tdf").read_bytes()[:-8])
    found = read_tdf(tmp_path / "cut.tdf", partial=True)
    assert same((found.rig, found.detections, found.analog), (whole.rig, whole.detections, whole.analog))
    (said,) = (note for note in found.notes if note.startswith("unreadable"))
    if form == 1:
        assert "tracks 3 to 3 of 3" in said
        assert np.array_equal(found.trajectories.xyz, whole.trajectories.xyz[:2], equal_nan=True)
    else:
        assert found.trajectories is None and "the tracks (block 5)" in said


def test_damage_is_read_or_refused_but_never_crashes(tmp_path):
    data = write(tmp_path / "a.tdf", *WHOLE).read_bytes()
    rng, part, refused = np.random.default_rng(1), tmp_path / "part.tdf", 0
    for _ in range(400):
        damaged = bytearray(data)
        for at in rng.integers(0, len(data), 8):
            damaged[at] = rng.integers(256)
        at = 4 * int(rng.integers(4, len(data) // 4))
        damaged[at : at + 4] = rng.choice([b"\xff\xff\xff\x7f", b"\xff\xff\xff\xff", b"\0\0\0\x80", b"\0\0\xc0\x7f"])
        part.write_bytes(damaged)
        try:
            refused += any(note.startswith("unreadable") for note in read_tdf(part).notes)
        except KinemarkError as error:
            refused += 1
            assert str(part) in str(error)
    assert refused > 50
    assert {*TDF_PARTS, "about", "notes"} == {f for f in Tdf.__dataclass_fields__}


# --- one block and the others ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("broken", range(len(WHOLE)))
@pytest.mark.parametrize("how", ["another format", "cut off", "noise"])
def test_a_block_that_cannot_be_read_keeps_none_of_the_others(tmp_path, broken, how):
    blocks, whole = list(WHOLE), read_tdf(write(tmp_path / "whole.tdf", *WHOLE))
    kind, form, data = blocks[broken]
    noise = np.random.default_rng(1).integers(128, 255, len(data)).astype(np.uint8).tobytes()
    blocks[broken] = (kind, *{"another format": (9, data), "cut off": (form, data[:8]), "noise": (form, noise)}[how])
    path = write(tmp_path / "a.tdf", *blocks)
    found = read_tdf(path)
    (said,) = (note for note in found.notes if note.startswith("unreadable"))
    assert f"(block {kind}), as it " in said and str(path) not in said and "parts" not in said
    lost = {2: "rig", 4: "detections", 5: "trajectories", 7: "plates", 9: "analog", 11: "analog", 16: "events"}[kind]
    for part in set(TDF_PARTS) - {lost, "plates"}:
        assert same(getattr(found, part), getattr(whole, part)), part
    with pytest.raises(KinemarkError, match=f"type {kind} "):
        read_tdf(path, parts=(lost,))


@pytest.mark.parametrize("lacking", [1, 49, 400])
def test_emg_by_channel_may_state_too_few_samples(tmp_path, lacking):
    values = RNG.normal(size=(3, 500)).astype(F4).astype(float)
    values[1, 30:60], values[2, 450:] = np.nan, np.nan
    block = bytearray(emg_block(1, values, "abc"))
    block[12:16] = struct.pack("<i", 500 - lacking)
    path = write(tmp_path / "a.tdf", *WHOLE[:5], (11, 1, bytes(block)))
    found = read_tdf(path)
    assert np.array_equal(found.analog[1].values, values, equal_nan=True)
    assert any(f"{500 - lacking} samples are stated and 500" in note for note in found.notes)


def test_the_date_labels_and_comments_of_a_file_are_kept(tmp_path, gait):
    assert gait.about == {
        "date": "2011-12-15T09:31:28",
        "plate 1": "Plate 1 [AMTI OR6-7:0003581]",
        "plate 2": "Plate 2 [AMTI OR6-7:0003582]",
        "up": "+Y",
    }
    assert any("block 12" in note for note in gait.notes)
    path = write(tmp_path / "a.tdf", *WHOLE)
    raw = bytearray(path.read_bytes())
    raw[64 + 288 * 2 + 32 : 64 + 288 * 2 + 41] = b"subject 7"
    path.write_bytes(raw)
    assert read_tdf(path).about == {
        "comment on block 5": "subject 7",
        "plate 1": "plate",
        "plate 2": "plate",
        "up": "+Y",
    }


def test_a_conversion_that_lacks_a_block_says_why_it_is_not_there(tmp_path):
    path = write(tmp_path / "a.tdf", *((kind, 9 if kind == 5 else form, data) for kind, form, data in WHOLE))
    with pytest.raises(KinemarkError, match=r"\.c3d can hold trajectories.*the tracks \(block 5\), as it has format 9"):
        convert(path, tmp_path / "a.c3d")
