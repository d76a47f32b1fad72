"""Tables in text, however programs and systems write them: encodings, endings, words for missing, marks."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories
from kinemark.io.control_points import read_control_points
from kinemark.io.detections_csv import read_detections_csv
from kinemark.io.dlt_csv import read_dlt_csv
from kinemark.io.named_points_csv import read_named_detections
from kinemark.io.number_text import separator
from kinemark.io.stated_names_csv import read_stated_names
from kinemark.io.track_names import read_track_names
from kinemark.io.trajectories_csv import read_trajectories_csv, write_trajectories_csv
from kinemark.io.trc import write_trc
from kinemark.io.trial import read_trial
from kinemark.io.um2as import read_cp, read_msr
from support.exported_csv import nexus

QTM = "NO_OF_FRAMES\t2\nFREQUENCY\t100\nDATA_INCLUDED\t3D\nMARKER_NAMES\tA\tB\n1\t2\t3\t4\t5\t6\n1\t2\t3\t4\t5\t7\n"
TRC = (
    "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t100\t2\t2\tmm\n"
    "Frame#\tTime\tA\t\t\tB\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n1\t0.00\t1\t2\t3\t4\t5\t6\n2\t0.01\t1\t2\t3\t4\t5\t7\n"
)
OURS = "frame,time_s,A_x_mm,A_y_mm,A_z_mm,B_x_mm,B_y_mm,B_z_mm\n1,0,1,2,3,4,5,6\n2,0.01,1,2,3,4,5,7\n"


def walk(frames=20):
    rng = np.random.default_rng(3)
    xyz = np.round(rng.normal(0, 900, (3, frames, 3)), 3)
    xyz[1, 5:9] = np.nan
    return Trajectories(tuple(map(MarkerTrajectory.measured, ("LASI", "RASI", "C7"), xyz)), 29.97)


@pytest.mark.parametrize("text", [QTM, TRC, OURS], ids=["QTM", "TRC", "ours"])
@pytest.mark.parametrize("ending", [".csv", ".txt", ".tsv"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_what_a_table_is_stands_in_it(tmp_path, text, ending, encoding):
    file = tmp_path / f"a{ending}"
    file.write_bytes(text.encode(encoding))
    found = read_trial(file).trajectories
    assert (found.names, found.rate) == (("A", "B"), 100.0)
    assert found.xyz.tolist() == [[[1, 2, 3]] * 2, [[4, 5, 6], [4, 5, 7]]]


@pytest.mark.parametrize(("text", "ending"), [(QTM, ".tsv"), (TRC, ".trc"), (OURS, ".csv")])
def test_the_end_of_a_file_in_dos_is_no_row(tmp_path, text, ending):
    (tmp_path / f"a{ending}").write_bytes(text.encode() + b"\x1a")
    assert read_trial(tmp_path / f"a{ending}").trajectories.n_frames == 2


@pytest.mark.parametrize("word", ["NA", "NaN", "n/a", "NULL", "None", "-", "-nan(ind)", "1.#QNAN", ""])
def test_words_for_missing(tmp_path, word):
    for text, ending in ((QTM, ".tsv"), (TRC, ".trc"), (OURS, ".csv")):
        file = tmp_path / f"a{ending}"
        mark = "," if ending == ".csv" else "\t"
        file.write_text(text.replace(mark.join("123"), mark.join([word] * 3), 1))
        found = read_trial(file).trajectories["A"].xyz
        assert np.isnan(found[0]).all()
        assert found[1].tolist() == [1, 2, 3]


def test_underscores_are_in_no_number(tmp_path):
    """Python reads 1_000 as 1000; no program writes that, so that the cell is something else."""
    for name, text, read in (
        ("a.csv", OURS.replace("1,2,3,4", "1_000,2,3,4", 1), read_trial),
        ("a.trc", TRC.replace("\t1\t2\t3", "\t1_0\t2\t3", 1), read_trial),
        ("d.csv", "camera,frame,u_px,v_px\nc1,0,1_0,2\n", lambda file: read_detections_csv(file, rate=1.0)),
        ("p.csv", "x_mm,y_mm,z_mm,c_u_px,c_v_px\n1_0,2,3,4,5\n", lambda file: read_control_points(file, ["c"])),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(KinemarkError, match="no number"):
            read(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "text", "read"),
    [
        ("box.msr", "72.2\t4_0\t-6.4\n", read_msr),
        ("box.cp2", "".join(f"{k}_0\n" for k in range(11)), read_cp),
        ("names.csv", "trial,frame,x_mm,y_mm,z_mm,name\nwalk,2,1_0,2,3,LASI\n", read_stated_names),
        ("names.csv", "trial,frame,x_mm,y_mm,z_mm,name\nwalk,2_0,1,2,3,LASI\n", read_stated_names),
        ("a.trc", TRC.replace("100", "1_00", 1), read_trial),
        ("a.tsv", QTM.replace("100", "1_00", 1), read_trial),
    ],
)
def test_nor_in_tables_of_um2as_in_stated_names_or_in_headings(tmp_path, name, text, read):
    (tmp_path / name).write_text(re.sub(r"(?<=\d)_(?=\d)", "", text))
    read(tmp_path / name)
    (tmp_path / name).write_text(text)
    with pytest.raises(KinemarkError, match=r"\d_"):
        read(tmp_path / name)


@pytest.mark.parametrize("mark", [";", "\t"])
def test_a_rate_with_a_decimal_comma_is_no_two_cells(tmp_path, mark):
    text = nexus(before := walk())
    (tmp_path / "a.csv").write_text(text.replace(",", mark).replace(".", ","))
    found = read_trial(tmp_path / "a.csv").trajectories
    assert found.rate == 29.97
    np.testing.assert_allclose(found.xyz, before.xyz, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "mark"),
    [("0.5,0.25\n", ","), ("0,5;0,25;1\n", ";"), ("29,97\na\tb\tc", "\t"), ("a,b,c\nd;e;f\n", ","), ("1\n2\n", ",")],
)
def test_the_mark_between_cells(text, mark):
    assert separator(text) == mark


def test_tables_of_points_and_names_as_spreadsheets_save_them(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text("name;x_mm;y_mm;z_mm;c_u_px;c_v_px\nP1;1,5;2;3;4,25;\n")
    found = read_control_points(file, ["c"])
    assert (found.xyz.tolist(), found.names) == ([[1.5, 2.0, 3.0]], ("P1",))
    assert found.uv[0, 0, 0] == 4.25
    file.write_text("track;name;first;last\n*1;LASI;1;20\n")
    assert [(one.track, one.name, one.last) for one in read_track_names(file)] == [("*1", "LASI", 20)]
    file.write_bytes("camera;frame;marker;u_px;v_px\nc1;0;A;1,5;2\n".encode("utf-16"))
    assert read_named_detections(file, rate=1.0).detections.uv.tolist() == [[1.5, 2.0]]


def test_a_table_without_a_heading_may_have_decimal_commas(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text("".join(f"{k},5;{k},25\n" for k in range(11)))
    assert read_dlt_csv(file).tolist() == [[k + 0.5 for k in range(11)], [k + 0.25 for k in range(11)]]


@pytest.mark.parametrize("ending", [".csv", ".tsv", ".txt"])
def test_an_empty_table_is_called_so(tmp_path, ending):
    (tmp_path / f"a{ending}").touch()
    with pytest.raises(KinemarkError, match="is empty"):
        read_trial(tmp_path / f"a{ending}")


def test_quotes_and_line_breaks_in_cells(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text(OURS.replace("A_x_mm,A_y_mm,A_z_mm", '"A_x_mm","A_y_mm","A_z_mm"').replace("\n1,0,", '\n"1",0,'))
    assert read_trajectories_csv(file).names == ("A", "B")
    head = OURS.replace("B_", "B\n2_").split("\n1,0")[0]
    quoted = ",".join(f'"{cell}"' for cell in head.split(","))
    file.write_text(quoted + OURS[OURS.index("\n1,0") :])
    assert read_trajectories_csv(file).names == ("A", "B\n2")


@pytest.mark.parametrize(("ending", "write"), [(".trc", write_trc), (".csv", write_trajectories_csv)])
def test_memory_of_a_long_table_stays_below_four_times_the_file(tmp_path, ending, write):
    """Its cells as text would be eight times the file."""
    rng = np.random.default_rng(5)
    paths = tuple(MarkerTrajectory.measured(f"M{k}", rng.normal(0, 900, (900, 3))) for k in range(60))
    write(file := tmp_path / f"a{ending}", Trajectories(paths, 100.0))
    measure = (
        "import sys, tracemalloc\nfrom kinemark.io.trial import read_trial\nfrom pathlib import Path\n"
        "read_trial(Path(sys.argv[1]))\ntracemalloc.start()\nread_trial(Path(sys.argv[1]))\nprint(tracemalloc.get_traced_memory()[1])"
    )
    out = subprocess.run([sys.executable, "-c", measure, file], capture_output=True, text=True, env=os.environ)
    assert int(out.stdout) < 4 * file.stat().st_size, out.stderr
