"""Marker files as text: TRC and CSV."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories, same
from kinemark.io.trajectories_csv import read_trajectories_csv, write_trajectories_csv
from kinemark.io.trc import read_trc, read_trc_trial, write_trc
from kinemark.io.trial import read_trial
from support.examples import examples
from support.shared import shared_data
from support.trc_dialects import DIALECTS, TrcText, written_as

FORMATS = {"trc": (read_trc, write_trc), "csv": (read_trajectories_csv, write_trajectories_csv)}


def markers(seed, n_markers=3, n_frames=20, rate=50.0, first=1):
    """Seeded markers with gaps, from whole numbers to awkward ones."""
    rng = np.random.default_rng(seed)
    xyz = rng.normal(size=(n_markers, n_frames, 3)) * 10.0 ** rng.integers(-6, 7, (n_markers, 1, 3))
    xyz[rng.random((n_markers, n_frames)) < 0.2] = np.nan
    names = [f"L.Knee {m}, é" for m in range(n_markers)]
    return Trajectories(tuple(MarkerTrajectory.measured(n, x) for n, x in zip(names, xyz, strict=True)), rate, first)


@pytest.mark.parametrize("form", FORMATS)
@settings(max_examples=examples(25), deadline=None)
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(1, 4),
    frames=st.integers(2, 30),
    rate=st.sampled_from([50.0, 59.94, 250.0, 1000.0, 100.5]),
    first=st.integers(1, 5000),
)
def test_what_is_written_reads_back_the_same(tmp_path_factory, form, seed, n, frames, rate, first):
    read, write = FORMATS[form]
    path = tmp_path_factory.mktemp("t") / f"a.{form}"
    before = markers(seed, n, frames, rate, first)
    write(path, before)
    assert same(read(path), before)


@pytest.mark.parametrize(("name", "n_frames", "n_markers"), [("static", 300, 49), ("walk", 151, 41)])
def test_opensims_files(tmp_path, name, n_frames, n_markers):
    path = shared_data(f"mocap3d/opensim_gait/subject01_{name}.trc")
    read = read_trc(path)
    assert (read.n_frames, len(read), read.rate, read.first_frame) == (n_frames, n_markers, 60.0, 1)
    table = np.genfromtxt(path, skip_header=6, delimiter="\t")
    assert np.array_equal(read.xyz.transpose(1, 0, 2).reshape(n_frames, -1), table[:, 2 : 2 + 3 * n_markers])
    write_trc(tmp_path / "again.trc", read)
    assert same(read_trc(tmp_path / "again.trc"), read)


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1), ("cm", 10), ("m", 1000), ("M", 1000)])
def test_units_become_mm(tmp_path, unit, factor):
    path = tmp_path / "a.trc"
    write_trc(path, markers(0))
    path.write_text(path.read_text("utf-8").replace("\tmm\t", f"\t{unit}\t"), "utf-8")
    assert np.array_equal(read_trc(path).xyz, markers(0).xyz * factor, equal_nan=True)


def test_windows_line_ends_and_encoding_are_read(tmp_path):
    for form, (read, write) in FORMATS.items():
        path = tmp_path / f"a.{form}"
        write(path, markers(3))
        path.write_bytes(path.read_text("utf-8").replace("\n", "\r\n").encode("cp1252"))
        assert same(read(path), markers(3))


def changed(path, line, change):
    """The file with one line (from 1) changed, or left out where `change` gives None."""
    lines = path.read_text("utf-8").split("\n")
    new = change(lines[line - 1])
    path.write_text("\n".join(lines[: line - 1] + ([] if new is None else [new]) + lines[line:]), "utf-8")


@pytest.mark.parametrize(
    ("line", "change", "says"),
    [
        (1, lambda s: "something else", "PathFileType"),
        (3, lambda s: s.replace("mm", "furlong"), "line 3: .*furlong"),
        (3, lambda s: s.replace("50.0", "fast"), "line 3: .*fast"),
        (3, lambda s: s.replace("50.0", "-1"), "line 3: DataRate"),
        (3, lambda s: s.replace("\t20\t3", "\t21\t3"), "20 frames, its header says 21"),
        (3, lambda s: s.replace("\t20\t3", "\t20\t4"), "line 4: has 3 markers, line 3 says 4"),
        (9, lambda s: s.replace("\t", "\tx", 1), "line 9: .*x"),
        (9, lambda s: s.rsplit("\t", 1)[0], "line 9: has 10 cells, wanted 11"),
        (9, lambda s: s + "\t1\t2\t3", "line 9: has 14 cells, wanted 11"),
        (9, lambda s: s + "\t1", "line 9: has 12 cells, wanted 11"),
        (10, lambda s: s.replace("4", "7", 1), "line 10: .*does not follow"),
        (10, lambda s: s.replace("4", "3.5", 1), "line 10: the frame is 3.5"),
        (10, lambda s: None, "19 frames, its header says 20"),
    ],
)
def test_a_broken_trc_names_the_line(tmp_path, line, change, says):
    path = tmp_path / "a.trc"
    write_trc(path, markers(0))
    changed(path, line, change)
    with pytest.raises(KinemarkError, match=says):
        read_trc(path)


@pytest.mark.parametrize(
    ("line", "change", "says"),
    [
        (1, lambda s: s.replace("frame", "f", 1), "line 1: wanted frame, time_s"),
        (1, lambda s: s.replace("_y_mm", "_y_m", 1), "line 1: wanted"),
        (4, lambda s: s + ",7", "line 4: has 12 cells, wanted 11"),
        (4, lambda s: "3,0.04,up" + ",1" * 8, "line 4: .*up"),
        (4, lambda s: None, "line 4: .*does not follow"),
        (21, lambda s: s.replace(",0.38,", ",,", 1), "rate"),
    ],
)
def test_a_broken_csv_names_the_line(tmp_path, line, change, says):
    path = tmp_path / "a.csv"
    write_trajectories_csv(path, markers(0))
    changed(path, line, change)
    with pytest.raises(KinemarkError, match=says):
        read_trajectories_csv(path)


def test_one_frame_needs_a_rate(tmp_path):
    path = tmp_path / "a.csv"
    write_trajectories_csv(path, markers(0, n_frames=1))
    with pytest.raises(KinemarkError, match="rate"):
        read_trajectories_csv(path)
    assert same(read_trajectories_csv(path, rate=50.0), markers(0, n_frames=1))


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize(
    "data", [b"", b"\0" * 100, b"\xff" * 100, b"PathFileType\n", b"\n\n\n\n\n\n", b'"' + b"x" * 200000]
)
def test_other_files_are_refused(tmp_path, form, data):
    path = tmp_path / f"a.{form}"
    path.write_bytes(data)
    with pytest.raises(KinemarkError):
        FORMATS[form][0](path)
    with pytest.raises(KinemarkError, match="not a file"):
        FORMATS[form][0](tmp_path / "absent")


def test_a_name_that_trc_cannot_hold_is_refused(tmp_path):
    bad = Trajectories((MarkerTrajectory.measured("a\tb", np.zeros((2, 3))),), 50.0)
    with pytest.raises(ValueError, match="tab"):
        write_trc(tmp_path / "a.trc", bad)
    assert not list(tmp_path.iterdir())


# What other programs write


def plainly_named(trajectories):
    """With names that may stand between commas."""
    paths = (replace(path, name=f"L.Knee {i} é") for i, path in enumerate(trajectories))
    return replace(trajectories, paths=tuple(paths))


@settings(max_examples=examples(60), deadline=None)
@given(
    seed=st.integers(0, 10**6),
    n_markers=st.sampled_from([1, 2, 3, 7, 260]),
    n_frames=st.integers(3, 12),
    rate=st.sampled_from([50.0, 59.94, 100.0, 250.0]),
    first=st.sampled_from([0, 1, 725]),
    dialects=st.sets(st.sampled_from(sorted(DIALECTS)), max_size=4),
)
def test_every_dialect_holds_the_same_markers(tmp_path_factory, seed, n_markers, n_frames, rate, first, dialects):
    before = plainly_named(markers(seed, n_markers, n_frames, rate, first))
    path = tmp_path_factory.mktemp("t") / "a.trc"
    path.write_bytes(written_as(before, dialects))
    found = read_trc(path, length_unit="mm")
    assert found.names == before.names
    assert found.rate == pytest.approx(rate, rel=1e-3) and found.first_frame == before.first_frame
    assert np.array_equal(found.xyz, before.xyz, equal_nan=True)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_each_dialect_is_read(tmp_path, dialect):
    """Each alone, with as many markers and gaps as in a real trial; what is taken for granted is said."""
    before = plainly_named(markers(5, 41, 60, 60.0))
    (tmp_path / "a.trc").write_bytes(written_as(before, {dialect}))
    trial = read_trc_trial(tmp_path / "a.trc")
    assert trial.trajectories.names == before.names and trial.trajectories.rate == pytest.approx(60.0, rel=1e-3)
    assert np.array_equal(trial.trajectories.xyz, before.xyz, equal_nan=True)
    assert bool(trial.notes) == DIALECTS[dialect].says


@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects_of_a_real_trial(tmp_path, dialect):
    real = read_trc(shared_data("mocap3d/opensim_gait/subject01_walk.trc"))
    (tmp_path / "a.trc").write_bytes(written_as(real, {dialect}))
    found = read_trc(tmp_path / "a.trc")
    assert found.names == real.names and np.array_equal(found.xyz, real.xyz, equal_nan=True)


@pytest.mark.parametrize(("size", "unit"), [(1000.0, "mm"), (1.0, "m")])
def test_a_file_without_a_unit_is_taken_by_its_extent_and_says_so(tmp_path, size, unit):
    xyz = np.random.default_rng(1).uniform(-1, 1, (4, 9, 3)) * size
    named = tuple(MarkerTrajectory.measured(f"m{k}", x) for k, x in enumerate(xyz))
    (tmp_path / "a.trc").write_bytes(written_as(Trajectories(named, 100.0), {"no unit"}))
    trial = read_trc_trial(tmp_path / "a.trc")
    factor = {"mm": 1.0, "m": 1000.0}
    assert np.allclose(trial.trajectories.xyz, xyz * factor[unit]) and "unit" in trial.notes[0]
    for said, mm in factor.items():
        assert np.allclose(read_trc(tmp_path / "a.trc", length_unit=said).xyz, xyz * mm)


def test_zeros_are_gaps_and_a_marker_at_the_origin_is_not(tmp_path):
    xyz = np.ones((6, 3))
    xyz[2], xyz[4] = 0, [0, 0, 1]
    text = TrcText.of(Trajectories((MarkerTrajectory.measured("a", xyz),), 50.0))
    (tmp_path / "a.trc").write_bytes(text.encoded())
    assert np.flatnonzero(np.isnan(read_trc(tmp_path / "a.trc").xyz[0]).any(1)).tolist() == [2]
    write_trc(tmp_path / "b.trc", Trajectories((MarkerTrajectory.measured("a", xyz),), 50.0))
    assert np.allclose(read_trc(tmp_path / "b.trc").xyz[0], xyz, atol=2e-6)


def test_a_heading_whose_value_is_no_number_says_so(tmp_path):
    """The words were Python's: could not convert string to float."""
    write_trc(tmp_path / "a.trc", markers(0))
    changed(tmp_path / "a.trc", 3, lambda s: "fast" + s[s.index("\t") :])
    with pytest.raises(KinemarkError, match="line 3: datarate is 'fast', wanted a number"):
        read_trc(tmp_path / "a.trc")


@pytest.mark.parametrize(("line", "change"), [(3, "\t21\t3"), (3, "\t20\t4")])
def test_what_a_heading_promises_too_much_is_read_in_part_when_asked(tmp_path, line, change):
    write_trc(tmp_path / "a.trc", markers(0))
    changed(tmp_path / "a.trc", line, lambda s: s.replace("\t20\t3", change))
    with pytest.raises(KinemarkError, match="--partial"):
        read_trc(tmp_path / "a.trc")
    assert same(read_trc(tmp_path / "a.trc", partial=True), markers(0))


def test_a_rate_is_taken_from_the_times_or_said(tmp_path):
    (tmp_path / "a.trc").write_bytes(written_as(markers(0, rate=40.0), {"no rate"}))
    assert read_trc(tmp_path / "a.trc").rate == 40.0
    assert read_trc(tmp_path / "a.trc", rate_hz=30.0).rate == 30.0
    write_trc(tmp_path / "b.trc", markers(0))
    changed(tmp_path / "b.trc", 3, lambda s: s.replace("50.0\t50.0", "75.0\t75.0", 1))
    trial = read_trc_trial(tmp_path / "b.trc")
    assert trial.trajectories.rate == 75.0 and "times" in trial.notes[0]


@pytest.mark.parametrize(("left_off", "frames"), [(12, 19), (2, 20)])
def test_a_file_that_ends_within_a_row_is_read_in_part_and_a_cut_number_is_no_measurement(tmp_path, left_off, frames):
    path, whole = tmp_path / "a.trc", markers(0, n_markers=2)
    xyz = np.round(np.nan_to_num(whole.xyz, nan=5.25) % 900, 3) + 0.0004
    write_trc(path, Trajectories(tuple(MarkerTrajectory.measured(n, x) for n, x in zip("AB", xyz, strict=True)), 50.0))
    path.write_text(path.read_text()[:-left_off])
    if frames < 20:
        with pytest.raises(KinemarkError, match=r"line 26: .*cut off.*--partial"):
            read_trc(path)
    trial = read_trc_trial(path, partial=True)
    assert trial.trajectories.n_frames == frames and "line 26" in trial.notes[0]
    seen = ~np.isnan(trial.trajectories.xyz).any(2)
    assert np.allclose(trial.trajectories.xyz[seen], xyz[:, :frames][seen], atol=1e-9)
    assert seen.sum() == 2 * frames - (frames == 20)


def test_a_last_line_without_its_end_is_whole_where_no_digit_lacks(tmp_path):
    path = tmp_path / "a.trc"
    write_trc(path, markers(3))
    path.write_text(path.read_text().rstrip("\n"))
    assert same(read_trc(path), markers(3))


@pytest.mark.parametrize(("mark", "comma"), [(";", False), (";", True), ("\t", True)])
def test_tables_saved_by_spreadsheets_are_read(tmp_path, mark, comma):
    path, one = tmp_path / "a.csv", replace(markers(1), paths=markers(1).paths[:1])
    write_trajectories_csv(path, Trajectories((replace(one.paths[0], name="A"),), 50.0))
    text = path.read_text().replace(",", mark)
    path.write_text(text.replace(".", ",") if comma else text)
    assert np.array_equal(read_trajectories_csv(path).xyz, one.xyz, equal_nan=True)


def test_markers_of_one_name_in_a_csv_are_told_apart(tmp_path):
    path = tmp_path / "a.csv"
    write_trajectories_csv(path, markers(0))
    changed(path, 1, lambda s: s.replace("L.Knee 1, é", "L.Knee 0, é").replace("L.Knee 2, é", ""))
    assert read_trajectories_csv(path).names == ("L.Knee 0, é", "L.Knee 0, é [2]", "*3")


def test_times_that_jump_tell_no_rate(tmp_path):
    path = tmp_path / "a.csv"
    write_trajectories_csv(path, markers(0))
    changed(path, 12, lambda s: s.replace("11,0.2,", "11,7.2,"))
    with pytest.raises(KinemarkError, match=r"line 12: time_s goes on by 7.* by 0\.02 s.*--rate-hz"):
        read_trajectories_csv(path)
    assert read_trajectories_csv(path, rate=50.0).rate == 50.0


def test_a_rate_of_0_is_none_and_the_times_count(tmp_path):
    path = tmp_path / "a.trc"
    write_trc(path, markers(0))
    changed(path, 3, lambda s: s.replace("50.0", "0", 1))
    assert read_trc(path).rate == 50.0


def test_a_csv_that_ends_within_a_row_is_read_in_part_when_asked(tmp_path):
    """A last number that may have lost digits is no measurement."""
    table = "frame,time_s,a_x_mm,a_y_mm,a_z_mm\n" + "".join(f"{f},{f / 100},1.25,2.25,3.25\n" for f in range(1, 6))
    path = tmp_path / "a.csv"
    path.write_text(table[:-12], "utf-8")
    with pytest.raises(KinemarkError, match=r"line 6: has . cells, wanted 5.*cut off.*--partial"):
        read_trial(path)
    assert read_trial(path, partial=True).trajectories.n_frames == 4
    two = "".join(table.splitlines(keepends=True)[:3])
    path.write_text(two[:-2], "utf-8")  # one row tells how many digits there are
    assert np.isnan(read_trial(path).trajectories.xyz[0, :, 0]).tolist() == [False, True]
    path.write_text(table[:-2], "utf-8")
    trial = read_trial(path)
    assert np.isnan(trial.trajectories.xyz[0, :, 0]).tolist() == [False] * 4 + [True] and "line 6" in trial.notes[0]
    path.write_text(table[:-1], "utf-8")
    assert np.isfinite(read_trial(path).trajectories.xyz).all()
