"""The files of UM²AS: its printed examples to the last bit, 999 stays in them, and sets that do not fit are refused."""

from datetime import date

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.io.um2as import (
    files_of_set,
    read_angles,
    read_cp,
    read_cp_set,
    read_da,
    read_da_set,
    read_msr,
    read_rf,
    read_tdc,
    write_angles,
    write_cp,
    write_da,
    write_msr,
    write_rf,
    write_tdc,
)

# What the thesis prints, as facts of the formats (figures 3.5, 3.12, 3.17 and 3.21; parts of the longer ones).
MSR = """72.2\t40.5\t-6.4
60.0\t31.8\t31.5
63.6\t5.8\t59.5
46.8\t16.8\t-7.5
21.0\t5.7\t73.9
13.7\t46.7\t37.8
48.3\t72.3\t62.2
32.5\t31.2\t58.9
"""
CP1 = """YEAR: 92 MONTH: 11 DAY: 27
-0.7230327
3.6617928
0.0439470
115.3470764
-0.7258390
0.1574676
-4.1144953
395.9822693
-0.0029378
0.0008468
-0.0003879
"""
DA1 = """Number of frames: 2 Number of markers: 3
262.8384705\t137.0000000
999\t999
148.5855255\t164.1882324
260.7773438\t135.8426514
999\t999
148.2273407\t164.2426453
"""
TDC = """Number of frames: 2 Number of markers: 2
7.1348953\t50.8270798\t52.6812515
-4.4081936\t73.8573608\t-2.3287313
6.6324863\t50.1592369\t52.7665749
-4.0715818\t74.1440277\t-2.1017463
"""
WST = """-10.74\t5.97\t0.52
-10.81\t7.01\t0.83
-10.96\t8.35\t0.90
-11.55\t8.36\t1.21
-11.55\t8.35\t1.97
"""


def wrote(path, text):
    path.write_text(text, "utf-8")
    return path


# ---- The printed examples ----


def test_measured_places(tmp_path):
    xyz = read_msr(wrote(tmp_path / "box.msr", MSR))
    assert xyz.shape == (8, 3) and xyz[0].tolist() == [722.0, 405.0, -64.0]  # cm there, mm here
    write_msr(tmp_path / "again.msr", xyz)
    assert (tmp_path / "again.msr").read_text() == MSR


def test_calibration_parameters(tmp_path):
    found = read_cp(wrote(tmp_path / "box.cp1", CP1))
    assert found.made == date(1992, 11, 27)
    write_cp(tmp_path / "again.cp1", found.L, made=found.made)
    assert (tmp_path / "again.cp1").read_text() == CP1
    L = found.L  # a ball is seen where it is, whatever the unit
    X, Y, Z = 722.0, 405.0, -64.0
    u = (L[0] * X + L[1] * Y + L[2] * Z + L[3]) / (L[8] * X + L[9] * Y + L[10] * Z + 1)
    in_cm = (-0.7230327 * 72.2 + 3.6617928 * 40.5 + 0.0439470 * -6.4 + 115.3470764) / (
        -0.0029378 * 72.2 + 0.0008468 * 40.5 - 0.0003879 * -6.4 + 1
    )
    assert u == pytest.approx(in_cm, rel=1e-12)


def test_only_camera_1_has_the_date(tmp_path):
    text = CP1.split("\n", 1)[1]
    found = read_cp(wrote(tmp_path / "box.cp2", text))
    assert found.made is None
    write_cp(tmp_path / "again.cp3", found.L, made=date(1992, 11, 27))
    assert (tmp_path / "again.cp3").read_text() == text


def test_digitised_centroids(tmp_path):
    uv = read_da(wrote(tmp_path / "feed.da1", DA1))
    assert uv.shape == (3, 2, 2) and uv[2, 1].tolist() == [148.2273407, 164.2426453]
    assert np.isnan(uv[1]).all() and not (uv == 999).any()
    write_da(tmp_path / "again.da1", uv)
    assert (tmp_path / "again.da1").read_text() == DA1
    write_da(tmp_path / "again.da2", uv)
    assert (tmp_path / "again.da2").read_text() == DA1.split("\n", 1)[1]


def test_calculated_places(tmp_path):
    xyz = read_tdc(wrote(tmp_path / "feed.tdc", TDC))
    np.testing.assert_allclose(xyz[1, 0], [-44.081936, 738.573608, -23.287313], rtol=1e-14)
    write_tdc(tmp_path / "again.tdc", xyz)
    assert (tmp_path / "again.tdc").read_text() == TDC


def test_angles(tmp_path):
    deg = read_angles(wrote(tmp_path / "feed.wst", WST))
    assert deg.shape == (5, 3) and deg[2].tolist() == [-10.96, 8.35, 0.9]
    write_angles(tmp_path / "again.wst", deg)
    assert (tmp_path / "again.wst").read_text() == WST
    write_angles(tmp_path / "feed.elb", deg)
    assert (tmp_path / "feed.elb").read_text().split("\n")[0] == "-10.74\t0.52"
    back = read_angles(tmp_path / "feed.elb")
    assert np.isnan(back[:, 1]).all() and (back[:, ::2] == deg[:, ::2]).all()
    assert read_angles(wrote(tmp_path / "three.elb", WST)).tolist() == deg.tolist()


# ---- Round trips ----


@pytest.mark.parametrize("seed", range(5))
def test_what_is_written_reads_back_to_half_of_the_last_decimal(tmp_path, seed):
    rng = np.random.default_rng(seed)
    uv = rng.uniform(-5, 2000, (4, 6, 5, 2))
    uv[rng.random(uv.shape[:3]) < 0.3] = np.nan
    for c, own in enumerate(uv):
        write_da(tmp_path / f"f.da{c + 1}", own)
    back, numbers = read_da_set([tmp_path / f"f.da{n}" for n in (3, 1, 4, 2)])
    assert numbers == (1, 2, 3, 4)
    np.testing.assert_allclose(back, uv, atol=0.51e-7, rtol=0)
    xyz = rng.normal(0, 1000, (6, 5, 3))
    xyz[rng.random((6, 5)) < 0.3] = np.nan
    write_tdc(tmp_path / "f.tdc", xyz)
    np.testing.assert_allclose(read_tdc(tmp_path / "f.tdc"), xyz, atol=0.51e-6, rtol=0)
    places = rng.normal(0, 1000, (8, 3))
    write_msr(tmp_path / "f.msr", places)
    np.testing.assert_allclose(read_msr(tmp_path / "f.msr"), places, atol=0.51e-6, rtol=0)
    write_rf(tmp_path / "f.rf2", uv[0, 0, 0] if np.isfinite(uv[0, 0, 0]).all() else (3.25, 4.5))
    assert read_rf(tmp_path / "f.rf2").shape == (2,)


def test_a_place_at_999_is_no_missing_one(tmp_path):
    """Images are wider than 999 px today."""
    uv = np.array([[[999.0, 300.0]], [[999.00000001, 999.0]], [[np.nan, np.nan]]])
    write_da(tmp_path / "wide.da1", uv)
    back = read_da(tmp_path / "wide.da1")
    np.testing.assert_allclose(back, uv, atol=2e-7)
    assert (tmp_path / "wide.da1").read_text().count("999\t999\n") == 1


def test_dates_of_two_digits_are_of_a_hundred_years_from_1980(tmp_path):
    L = np.arange(11.0)
    for year in (1980, 1999, 2000, 2026, 2079, 2080, 1979):
        write_cp(tmp_path / "a.cp1", L, made=date(year, 2, 3))
        assert read_cp(tmp_path / "a.cp1").made == date(year, 2, 3)


def test_the_files_of_a_set_are_found(tmp_path):
    for name in ("a.da1", "a.da2", "a.da10", "b.da3", "a.cp3", "a.dat"):
        wrote(tmp_path / name, "1 2\n")
    assert [p.name for p in files_of_set(tmp_path / "a.da2", "da")] == ["a.da1", "a.da2", "a.da10"]
    with pytest.raises(KinemarkError, match="not a file"):
        files_of_set(tmp_path / "a.da4", "da")


def test_blanks_and_empty_lines_do_no_harm(tmp_path):
    text = "\n" + DA1.replace("\t", "   ").replace("\n", " \r\n\r\n")
    assert np.array_equal(
        read_da(wrote(tmp_path / "a.da1", text)), read_da(wrote(tmp_path / "b.da1", DA1)), equal_nan=True
    )


# ---- Sets and files that do not fit ----

ROWS = DA1.split("\n", 1)[1]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.da1", ROWS, "does not begin with the header"),
        ("a.da2", DA1, "has a header, which only camera 1"),
        ("a.da1", DA1.replace("frames: 2", "frames: 3"), "6 rows, and 3 frames of 3 markers are 9"),
        ("a.da1", DA1.replace("frames: 2", "frames: 0"), "announces 0 frames"),
        ("a.da1", DA1.replace("999\t999", "999\t120.5", 1), "line 3: 999.* in one column only"),
        ("a.da1", DA1.replace("137.0000000", "x"), "line 2: .* is not 2 numbers"),
        ("a.da1", DA1.replace("137.0000000", "nan"), "line 2: .* is not finite"),
        ("a.da1", DA1.replace("137.0000000", "1 2"), "line 2: has 3 entries"),
        ("a.da1", DA1.replace("164.1882324", ""), "line 4: has 1 entries"),
        ("a.da1", "", "is empty"),
        ("a.da1", "Number of frames: 2 Number of markers: 3\n", "no rows of numbers"),
        ("a.da", DA1, "does not end in .da and a camera's number"),
        ("a.da0", DA1, "does not end in .da and a camera's number"),
    ],
)
def test_wrong_motion_files_are_refused(tmp_path, name, text, message):
    with pytest.raises(KinemarkError, match=message):
        read_da(wrote(tmp_path / name, text), markers=3)


def test_motion_files_that_do_not_belong_together_are_refused(tmp_path):
    one = wrote(tmp_path / "a.da1", DA1)
    with pytest.raises(KinemarkError, match="no whole number of frames of 3 markers"):
        read_da_set([one, wrote(tmp_path / "a.da2", "\n".join(ROWS.split("\n")[:5]))])
    with pytest.raises(KinemarkError, match=r"2 frames and .*a\.da3 1"):
        read_da_set([one, wrote(tmp_path / "a.da3", "\n".join(ROWS.split("\n")[:3]))])
    with pytest.raises(KinemarkError, match="both of camera 1"):
        read_da_set([one, wrote(tmp_path / "b.da1", DA1)])
    with pytest.raises(KinemarkError, match="does not say how many markers"):
        read_da_set([wrote(tmp_path / "c.da2", ROWS)])
    with pytest.raises(KinemarkError, match="3 markers a frame, wanted 4"):
        read_da_set([one], markers=4)
    with pytest.raises(ValueError, match="empty"):
        read_da_set([])
    assert read_da_set([tmp_path / "c.da2"], markers=3)[0].shape == (1, 3, 2, 2)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.cp1", CP1.split("\n", 1)[1], "wanted camera 1's date"),
        ("a.cp2", CP1, "a date, which only camera 1"),
        ("a.cp1", CP1.replace("MONTH: 11", "MONTH: 13"), "no date"),
        ("a.cp1", CP1.rsplit("\n", 2)[0], "has 10 parameters, wanted 11"),
        ("a.cp1", CP1 + "1.0\n", "has 12 parameters"),
        ("a.cp1", CP1.replace("3.6617928", "3,6617928"), "line 3: '3,6617928'"),
        ("a.cp1", CP1.replace("3.6617928", "inf"), "not finite"),
        ("a.cp", CP1, "camera's number"),
    ],
)
def test_wrong_parameters_are_refused(tmp_path, name, text, message):
    with pytest.raises(KinemarkError, match=message):
        read_cp_set([wrote(tmp_path / name, text)])


@pytest.mark.parametrize(
    ("read", "name", "text", "message"),
    [
        (read_msr, "a.msr", "1 2\n", "has 2 entries, wanted 3"),
        (read_msr, "a.msr", TDC, "header of a .tdc file"),
        (read_rf, "a.rf1", "1 2\n3 4\n", "has 2 rows, wanted one"),
        (read_rf, "a.rf1", "999 999\n", "was not seen"),
        (read_rf, "a.rf", "1 2\n", "camera's number"),
        (read_tdc, "a.tdc", TDC.split("\n", 1)[1], "does not begin with 'Number of frames"),
        (read_tdc, "a.tdc", TDC.replace("52.6812515", "999"), "one column only"),
        (read_angles, "a.wst", "1 2\n", "wanted 3"),
        (read_angles, "a.elb", "1 2 3 4\n", "wanted 2 or 3"),
        (read_angles, "a.txt", "1 2 3\n", "does not end in"),
        (read_angles, "a.shd", TDC, "has a header"),
    ],
)
def test_other_wrong_files_are_refused(tmp_path, read, name, text, message):
    with pytest.raises(KinemarkError, match=message):
        read(wrote(tmp_path / name, text))


def test_999_may_be_measured_but_an_angle_of_999_is_none(tmp_path):
    assert read_msr(wrote(tmp_path / "a.msr", "999 1 2\n")).tolist() == [[9990.0, 10.0, 20.0]]
    assert np.isnan(read_angles(wrote(tmp_path / "a.shd", "999 999 999\n1 2 3\n"))[0]).all()


def test_arrays_that_are_no_motion_are_refused(tmp_path):
    half = np.array([[[1.0, np.nan]]])
    for write, name, value, message in (
        (write_da, "a.da1", np.zeros((2, 2)), "shape"),
        (write_da, "a.da1", half, "some coordinates"),
        (write_da, "a.da1", np.full((1, 1, 2), np.inf), "infinite"),
        (write_tdc, "a.tdc", np.zeros((2, 3, 2)), "shape"),
        (write_cp, "a.cp1", np.zeros(11), "date"),
        (write_cp, "a.cp2", np.zeros(10), "shape"),
        (write_msr, "a.msr", np.full((8, 3), np.nan), "finite"),
        (write_rf, "a.rf1", np.array([1.0, np.nan]), "finite"),
        (write_angles, "a.shd", np.zeros((0, 3)), "shape"),
    ):
        with pytest.raises(ValueError, match=message):
            write(tmp_path / name, value)
        assert not (tmp_path / name).exists()
