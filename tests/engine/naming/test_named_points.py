"""CSV files of 2D points that name their markers: read, reconstructed by name, written."""

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.engine.describe import describe
from kinemark.engine.first_session import propose_session
from kinemark.engine.formats import convert
from kinemark.engine.session import Session
from kinemark.geometry import project
from kinemark.io.c3d import read_c3d
from kinemark.io.named_points_csv import layout_of, read_named_detections
from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.text_rows import csv_rows
from support.findings import found
from support.laboratory import ring
from support.motions import swarm
from support.shared import shared_data

NAMES = ("hip", "knee_r", "ankle")
RIG = ring(3)
XYZ = swarm(3, frames=25, seed=5)
HIDDEN = {(0, 1, 4), (1, 1, 4), (2, 2, 9)}  # camera, marker, frame


def places():
    """(C, M, F, 2) px, NaN where hidden."""
    uv = np.stack([project(camera, XYZ) for camera in RIG])
    for at in HIDDEN:
        uv[at] = np.nan
    return uv


def long_form(path, short=False):
    lines = ["frame,camera,marker,u,v" if short else "marker,camera,u_px,v_px,frame"]
    for (c, m, f), uv in np.ndenumerate(places()[..., 0]):
        v = places()[c, m, f, 1]
        row = [str(f), RIG.names[c], NAMES[m], repr(float(uv)), repr(float(v))]
        if np.isfinite(uv):
            lines.append(",".join(row if short else [row[k] for k in (2, 1, 3, 4, 0)]))
    path.write_text("\n".join(lines) + "\n")


def wide_form(path, axes=("X", "Y"), frame=False):
    cells = [f"{name}_{camera}_{axis}" for name in NAMES for camera in RIG.names for axis in axes]
    table = places().transpose(2, 1, 0, 3).reshape(XYZ.shape[1], -1)
    rows = [",".join(map(repr, row)) for row in table.tolist()]
    head = ",".join([*(["frame"] if frame else []), *cells])
    path.write_text("\n".join([head, *(f"{k},{row}" if frame else row for k, row in enumerate(rows))]) + "\n")


def deeplabcut(folder):
    """A file a camera; hidden points are guesses of small likelihood."""
    for c, camera in enumerate(RIG.names):
        head = [f"{w}," + ",".join(cells) for w, cells in (
            ("scorer", ["net"] * 9),
            ("bodyparts", [n for n in NAMES for _ in range(3)]),
            ("coords", ["x", "y", "likelihood"] * 3),
        )]  # fmt: skip
        rows = []
        for f in range(XYZ.shape[1]):
            cells = [(*uv, 0.99) if np.isfinite(uv).all() else (7.0, 8.0, 0.1) for uv in places()[c, :, f].tolist()]
            rows.append(f"{f}," + ",".join(repr(float(x)) for cell in cells for x in cell))
        (folder / f"walk_{camera}.csv").write_text("\n".join([*head, *rows]) + "\n")


WRITERS = {
    "long": lambda folder: long_form(folder / "walk.csv"),
    "long, short names": lambda folder: long_form(folder / "walk.csv", short=True),
    "wide": lambda folder: wide_form(folder / "walk.csv"),
    "wide, px": lambda folder: wide_form(folder / "walk.csv", ("u_px", "v_px"), frame=True),
    "DeepLabCut": deeplabcut,
}


@pytest.mark.parametrize("form", WRITERS)
def test_markers_are_reconstructed_by_their_names(form, tmp_path):
    WRITERS[form](tmp_path)
    write_rig_toml(tmp_path / "rig.toml", RIG)
    detections = "walk_{camera}.csv" if form == "DeepLabCut" else "walk.csv"
    (tmp_path / "session.toml").write_text(
        f'name = "n"\nsubject = "S07"\ndate = 2026-05-03\nrate_hz = 100\n'
        '[calibration]\nfile = "rig.toml"\n[[trials]]\nname = "walk"\n'
        f'detections = "{detections}"\n'
    )
    done = Session.open(tmp_path).run()["walk"]
    assert done.failed is None
    trial = read_c3d(tmp_path / "results/walk/walk.c3d")
    assert (trial.about["subject"], trial.about["date"]) == ("S07", "2026-05-03")
    trajectories = trial.trajectories
    assert set(trajectories.names) == set(NAMES)
    for name, xyz in zip(NAMES, XYZ, strict=True):
        error = np.linalg.norm(trajectories[name].xyz - xyz, axis=1)
        assert np.nanmax(error) < 0.01
        assert np.isnan(error).sum() == (name == "knee_r")  # one camera alone sees it in frame 4


def test_who_names_markers_in_the_recording_needs_no_files_of_names(tmp_path):
    """Of a session in which other trials are named by these."""
    WRITERS["wide"](tmp_path)
    write_rig_toml(tmp_path / "rig.toml", RIG)
    (tmp_path / "session.toml").write_text(
        'name = "n"\nrate_hz = 100\n[calibration]\nfile = "rig.toml"\n[label]\ntemplate = ["later.c3d"]\n'
        '[[trials]]\nname = "walk"\ndetections = "walk.csv"\n'
    )
    assert set(Session.open(tmp_path).run(to="label")["walk"].trajectories.names) == set(NAMES)


def test_a_marker_twice_in_an_image_is_an_error(tmp_path):
    path = tmp_path / "d.csv"
    path.write_text("camera,frame,marker,u_px,v_px\na,0,hip,1,2\na,0,knee,3,4\na,0,hip,5,6\n")
    with pytest.raises(KinemarkError, match="line 4: marker 'hip' comes twice"):
        read_named_detections(path, rate=1.0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("frame,marker,u_px,v_px\n0,hip,1,2\n", "no column 'camera'"),
        ("camera,frame,marker,u_px\na,0,hip,1\n", "no column 'v_px'"),
        ("hip_cam1_X,hip_cam1_Y,hip_cam2_X\n1,2,3\n", "'hip' of camera 'cam2' wants one X and one Y"),
        ("scorer,net,net\nbodyparts,hip,hip\n0,1,2\n", "no line 'coords'"),
        ("scorer,net\nbodyparts,hip\ncoords,x\n0,1\n", "'hip' has no column 'y'"),
        ("camera,frame,u_px,v_px\na,0,1,2\n", "names no markers"),
    ],
)
def test_what_is_missing_is_named(text, says, tmp_path):
    (tmp_path / "d.csv").write_text(text)
    with pytest.raises(KinemarkError, match=says):
        read_named_detections(tmp_path / "d.csv", rate=1.0)


def test_names_are_kept_from_file_to_file(tmp_path):
    wide_form(tmp_path / "wide.csv")
    assert describe(tmp_path / "wide.csv")["markers"] == list(NAMES)
    assert convert(tmp_path / "wide.csv", tmp_path / "long.csv", rate_hz=100.0) == ()
    before, after = (read_named_detections(tmp_path / f"{name}.csv", rate=1.0) for name in ("wide", "long"))
    assert layout_of(tmp_path / "long.csv") == "long"
    by_name = [
        {(c, f, one.names[m]): tuple(uv) for c, f, m, uv in zip(
            one.detections.camera.tolist(), one.detections.frame.tolist(), one.marker, one.detections.uv.tolist(),
            strict=True,
        )}
        for one in (before, after)
    ]  # fmt: skip
    assert by_name[0] == by_name[1]
    (note,) = convert(tmp_path / "wide.csv", tmp_path / "points.h5", rate_hz=100.0)
    assert set(note.names) == set(NAMES)


def test_a_folder_of_named_points_proposes_a_session(tmp_path):
    deeplabcut(tmp_path)
    for camera in RIG.names:  # DeepLabCut names its network behind the video's name
        (tmp_path / f"walk_{camera}.csv").rename(tmp_path / f"walk_{camera}DLC_resnet50.csv")
    write_rig_toml(tmp_path / "rig.toml", RIG)
    proposed = propose_session(tmp_path)
    assert [one.path for one in proposed.trials] == ["walk_{camera}DLC_resnet50.csv"]
    assert proposed.cameras == RIG.names


def test_dltdv_points_agree_with_its_own_reconstruction(tmp_path):
    folder = shared_data("cameras/dltdv_thermal_3cam")
    stem = "DLTdv7_data_2018-08-17_P03_1000TMC"
    (tmp_path / "session.toml").write_text(
        'name = "throw"\nrate_hz = 25\n[cameras]\nnames = ["cam1", "cam2", "cam3"]\n[calibration]\n'
        f'file = "{folder}/2018-08-17_wand_dltCoefs_round4.csv"\nlength_unit = "m"\n[[trials]]\nname = "throw"\n'
        f'detections = "{folder}/{stem}xypts.csv"\n'
    )
    assert Session.open(tmp_path).run()["throw"].failed is None
    ours = read_c3d(tmp_path / "results/throw/throw.c3d").trajectories["pt1"].xyz
    stored = np.array([[float(x) for x in row] for _, row in csv_rows(folder / f"{stem}xyzpts.csv")[1:]]) * 1000
    error = np.linalg.norm(ours - stored[: len(ours)], axis=1)
    assert np.isfinite(error).sum() >= 20
    assert np.nanmedian(error) < 20


def test_markers_outside_the_volume_are_not_called_unseen(tmp_path):
    long_form(tmp_path / "walk.csv")
    write_rig_toml(tmp_path / "rig.toml", RIG)
    low, high = XYZ[:2].min((0, 1)) - 50, XYZ[:2].max((0, 1)) + 50  # the ankle is half a metre below
    (tmp_path / "session.toml").write_text(
        f'name = "n"\nrate_hz = 100\nvolume_mm = [{low.tolist()}, {high.tolist()}]\n[calibration]\nfile = "rig.toml"\n'
        '[[trials]]\nname = "walk"\ndetections = "walk.csv"\n'
    )
    figures = Session.open(tmp_path).run(to="quality")["walk"].quality
    kept = {m["name"] for m in figures["trajectories"]["markers"] if m["samples"]}
    assert kept == {"hip", "knee_r"}
    (said,) = found(figures, "points_dropped_outside")
    assert said.markers == ("ankle",) and said.values["points"] == 25
    assert not found(figures, "markers_never_seen")
