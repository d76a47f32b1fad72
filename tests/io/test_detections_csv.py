"""Detections as CSV."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark.data import Detections, KinemarkError, Validity, same
from kinemark.io.detections_csv import read_detections_csv, write_detections_csv
from support.examples import examples


def detections(seed, cameras=("left", "right, é"), n_frames=7, known=True):
    rng = np.random.default_rng(seed)
    counts = rng.integers(0, 4, (len(cameras), n_frames))
    n = counts.sum()
    cov = rng.uniform(0, 1, (n, 2, 1)) * np.eye(2)
    cov[rng.random(n) < 0.3] = np.nan
    area = np.where(rng.random(n) < 0.3, np.nan, rng.uniform(1, 90, n))
    extra = {"cov": cov, "area": area, "merged": rng.random(n) < 0.3} if known else {}
    return Detections.build(cameras, 50.0, counts, rng.uniform(-1, 700, (n, 2)), **extra)


@settings(max_examples=examples(40), deadline=None)
@given(seed=st.integers(0, 10**6), n_frames=st.integers(0, 9), known=st.booleans())
def test_what_is_written_reads_back_the_same(tmp_path_factory, seed, n_frames, known):
    before = detections(seed, n_frames=n_frames, known=known)
    path = tmp_path_factory.mktemp("d") / "d.csv"
    write_detections_csv(path, before)
    after = read_detections_csv(path, rate=50.0, cameras=before.cameras, n_frames=n_frames)
    assert same(after, before)


def test_order_of_rows_and_columns_does_not_matter(tmp_path):
    before, path, rng = detections(1), tmp_path / "d.csv", np.random.default_rng(0)
    write_detections_csv(path, before)
    head, *rows = [line.split(",") for line in path.read_text("utf-8").replace('"right, é"', "right").splitlines()]
    columns = rng.permutation(len(head))
    camera, frame = head.index("camera"), head.index("frame")
    groups = rng.permutation(sorted({(row[camera], row[frame]) for row in rows}))
    rows = [row for group in groups for row in rows if (row[camera], row[frame]) == tuple(group)]
    path.write_text("".join(",".join(row[k] for k in columns) + "\n" for row in [head, *rows]) + "\n\n", "utf-8")
    after = read_detections_csv(path, rate=50.0, cameras=("left", "right"), n_frames=7)
    assert same(after.uv, before.uv) and same(after.start, before.start) and same(after.cov, before.cov)


def test_cameras_and_frames_follow_from_the_file(tmp_path):
    path = tmp_path / "d.csv"
    path.write_text("camera,frame,u_px,v_px\nb,3,1,2\na,0,3,4\nb,1,5,6\n")
    read = read_detections_csv(path, rate=10.0)
    assert (read.cameras, read.n_frames, read.rate) == (("b", "a"), 4, 10.0)
    assert read.uv.tolist() == [[5, 6], [1, 2], [3, 4]]
    assert read.valid.all() and np.isnan(read.cov).all() and np.isnan(read.area).all() and not read.merged.any()


def test_arguments_that_changed_places_are_refused(tmp_path):
    with pytest.raises(TypeError, match=r"wanted write_detections_csv\(path, detections\)"):
        write_detections_csv(detections(1), tmp_path / "d.csv")


def test_invalid_detections_are_not_written(tmp_path):
    before = detections(2)
    validity = np.where(np.arange(len(before)) % 3 == 0, Validity.TOO_SMALL, Validity.VALID)
    some = Detections.build(before.cameras, 50.0, before.counts, before.uv, validity=validity)
    write_detections_csv(tmp_path / "d.csv", some)
    after = read_detections_csv(tmp_path / "d.csv", rate=50.0, cameras=before.cameras, n_frames=7)
    assert same(after, some.keep(some.valid)) and len(after) < len(before)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("camera,frame,u_px,v_px,colour\n", "unknown column 'colour'"),
        ("camera,frame,u_px\n", "no column 'v_px'"),
        ("camera,frame,u_px,v_px,var_u_px2\n", "come together"),
        ("camera,frame,u_px,v_px,u_px\n", "differ"),
        ("camera,frame,u_px,v_px\na,0,1\n", "line 2: has 3 cells, wanted 4"),
        ("camera,frame,u_px,v_px\na,0,1,2\n\na,0,x,2\n", "line 4: .*x"),
        ("camera,frame,u_px,v_px\na,0,1,2\na,0,1,\n", "line 3: u_px or v_px is missing"),
        ("camera,frame,u_px,v_px\na,0,1,2\na,0,1,inf\n", "line 3: u_px or v_px is missing"),
        ("camera,frame,u_px,v_px\na,0.5,1,2\n", "line 2: frame is 0.5"),
        ("camera,frame,u_px,v_px\na,,1,2\n", "line 2: frame is nan"),
        ("camera,frame,u_px,v_px\na,-1,1,2\n", "line 2: frame is not one of"),
        ("camera,frame,u_px,v_px\na,9,1,2\n", "line 2: frame is not one of 0 … 5"),
        ("camera,frame,u_px,v_px\nc,0,1,2\n", "camera 'c' is not one of a, b"),
        ("camera,frame,u_px,v_px,var_u_px2,var_v_px2\na,0,1,2,1,-1\n", "line 2: var_v_px2 is negative"),
        ("camera,frame,u_px,v_px,merged\na,0,1,2,0\na,0,1,2,2\n", "line 3: merged is neither 0 nor 1. Write 1 where"),
        ("camera,frame,u_px,v_px,merged\na,0,1,2,\n", "line 2: merged is neither 0 nor 1"),
        ("", "empty"),
        ('"' + "x" * 200000, "field larger"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, text, says):
    path = tmp_path / "d.csv"
    path.write_text(text)
    with pytest.raises(KinemarkError, match=says):
        read_detections_csv(path, rate=50.0, cameras=("a", "b"), n_frames=6)


def test_a_frame_number_cannot_exhaust_memory(tmp_path):
    path = tmp_path / "d.csv"
    path.write_text("camera,frame,u_px,v_px\na,9000000000000,1,2\n")
    with pytest.raises(KinemarkError, match="frames count from 0"):
        read_detections_csv(path, rate=50.0)
