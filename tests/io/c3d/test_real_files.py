"""C3D on real recordings: nothing is lost, other readers agree, odd files are read or refused."""

import pickle
import subprocess
import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import KinemarkError, Origin, same
from kinemark.io.c3d import (
    ByteOrder,
    decode_document,
    document_of,
    encode_document,
    read_c3d,
    read_document,
    trial_of,
)
from kinemark.io.c3d.to_trial import analog_of
from support.shared import ROOT, shared_data

MALFORMED = "mocap3d/c3d_malformed/"
FILES = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob("mocap3d/**/*.[cC]3[dD]"))
SOUND = [path for path in FILES if not path.startswith(MALFORMED)] or ["mocap3d"]
READABLE = ["Dance", "Mega Electronics Isokinetic EMG Angle Torque Sample File", "bigparlove", "giant"]
READABLE = [f"{MALFORMED}{name}.c3d" for name in [*READABLE, "mocap36", "parameterOverflow", "phasespace_sample"]]
# In a process of its own, because ezc3d can crash.
EZC3D = """
import pickle, sys, ezc3d
out = {}
for path in sys.argv[2:]:
    c = ezc3d.c3d(path)
    out[path] = c["data"]["points"], c["data"]["analogs"], {
        (g, p): c["parameters"][g][p]["value"] for g in c["parameters"] for p in c["parameters"][g]
        if p != "__METADATA__" and "value" in c["parameters"][g][p]}
pickle.dump(out, open(sys.argv[1], "wb"))
"""


@cache
def oracle(directory, paths):
    """What ezc3d finds in the files: points (4, M, F), analog (1, A, N), parameters."""
    command = [sys.executable, "-c", EZC3D, str(directory / "oracle"), *map(str, paths)]
    subprocess.run(command, check=True, timeout=120)
    return pickle.loads((directory / "oracle").read_bytes())


@pytest.fixture(scope="session")
def ezc3d(tmp_path_factory):
    known = [path for path in SOUND if "sgi_" not in path] + [f"{MALFORMED}{n}.c3d" for n in ("giant", "bigparlove")]
    return oracle(tmp_path_factory.mktemp("ezc3d"), tuple(shared_data(path) for path in known))


@pytest.mark.parametrize("path", [*SOUND, *READABLE])
def test_a_file_is_written_as_it_was_read(path):
    trial = read_c3d(shared_data(path))
    doc = trial.source
    raw = encode_document(doc)
    found = decode_document(raw, name=path)
    assert same(replace(found, notes=()), replace(doc, notes=()))
    assert same(document_of(trial), doc)
    original = shared_data(path).read_bytes()
    start, size = (doc.data_block - 1) * 512, 4 if doc.floats else 2
    stop = start + size * len(doc.points) * (4 * doc.points.shape[1] + len(doc.analog) * doc.samples)
    assert raw[start:stop] == original[start:stop]


@pytest.mark.parametrize("path", [path for path in SOUND if "sgi_" not in path])
def test_points_analog_and_parameters_are_those_of_ezc3d(path, ezc3d):
    points, analog, parameters = ezc3d[str(shared_data(path))]
    doc = read_document(shared_data(path))
    valid = doc.word >= 0
    theirs = np.moveaxis(points[:3], 0, 2).swapaxes(0, 1)
    assert theirs.shape == doc.points.shape
    tolerance = 0 if doc.floats else 1e-6  # ezc3d multiplies integers in single precision
    assert np.allclose(theirs[valid], doc.points[valid], rtol=tolerance, atol=0, equal_nan=True)
    assert np.isnan(theirs[~valid]).all()
    if len(doc.analog):
        ours = analog_of(doc).values
        assert np.allclose(analog[0], ours, rtol=1e-5, atol=1e-6 * np.abs(ours).max())
    for (group, name), value in parameters.items():
        p = doc.get(group, name)
        if p is None:  # ezc3d adds what it expects to find
            assert np.size(value) <= 1 or set(np.ravel(value)) <= {0, 1}
        elif p.is_text:
            assert [text.strip() for text in value] == list(p.texts)
        elif name not in ("DATA_START", "OFFSET", "FRAMES"):
            assert np.array_equal(np.ravel(value, order="F"), p.numbers)


@pytest.mark.parametrize("name", ["giant", "bigparlove"])
def test_points_of_odd_files_are_those_of_ezc3d(name, ezc3d):
    path = shared_data(f"{MALFORMED}{name}.c3d")
    doc = read_document(path)
    theirs = np.moveaxis(ezc3d[str(path)][0][:3], 0, 2).swapaxes(0, 1)
    valid = doc.word >= 0
    assert np.array_equal(theirs[valid], doc.points[valid]) and np.isnan(theirs[~valid]).all()


def test_the_six_formats_hold_one_trial():
    folder = shared_data("mocap3d/c3d_six_formats")
    trials = {name: read_c3d(folder / f"{name}.c3d") for name in ("pc_real", "dec_real", "sgi_real")}
    whole = {name: read_c3d(folder / f"{name}.c3d") for name in ("pc_int", "dec_int", "sgi_int")}
    first = trials["pc_real"]
    orders = [t.source.order for t in trials.values()]
    assert orders == [ByteOrder.INTEL, ByteOrder.DEC, ByteOrder.SGI] == [t.source.order for t in whole.values()]
    for trial in (*trials.values(), *whole.values()):
        assert trial.trajectories.names == first.trajectories.names
        away = np.abs(trial.trajectories.xyz - first.trajectories.xyz)
        assert np.nanmax(away) <= first.source.scale  # whoever made the integers cut off what was behind the point
        assert np.array_equal(*([path.origin for path in t.trajectories] for t in (trial, first)))
        assert np.array_equal(trial.source.residual, first.source.residual)
        # dec_int.c3d differs by itself in the cameras of 96 samples and lacks the last event.
        cameras = (trial.source.cameras != first.source.cameras).sum()
        assert (cameras, len(trial.events)) == ((96, 8) if trial.name == "dec_int" else (0, 9))
        assert trial.events.label == first.events.label[: len(trial.events)]
        assert np.allclose(trial.analog[0].values, first.analog[0].values, rtol=1e-6, atol=1e-9)
        assert same(trial.plates, first.plates)


@pytest.mark.parametrize(
    "path", ["c3d_six_formats/pc_int.c3d", "pig_gait_child/HC030A05.c3d", "arm_box_lift_gaps/Vicon.c3d"]
)
@pytest.mark.parametrize("order", list(ByteOrder))
@pytest.mark.parametrize("floats", [True, False])
def test_a_real_trial_comes_back_in_every_format(path, order, floats):
    trial = read_c3d(shared_data(f"mocap3d/{path}"))
    back = trial_of(
        decode_document(encode_document(document_of(trial, order=order, floats=floats)), name=path), name="t"
    )
    a, b = trial.trajectories.xyz, back.trajectories.xyz
    assert np.array_equal(np.isnan(a), np.isnan(b))
    away = np.abs(a - b)[np.abs(a).max(-1) > back.source.scale]  # what is nearer to 0 is moved off it
    assert np.nanmax(away) <= (np.spacing(np.float32(np.nanmax(np.abs(a)))) if floats else 0.501 * back.source.scale)
    assert same((back.plates, back.events), (trial.plates, trial.events))
    for old, new in zip(trial.signals, back.signals, strict=True):
        assert (new.name, new.kind, new.unit, new.axes, new.description) == (
            old.name, old.kind, old.unit, old.axes, old.description
        )  # fmt: skip
        assert np.array_equal(np.isnan(old.values), np.isnan(new.values))
        away = np.abs(old.values - new.values)[np.abs(old.values).max(-1) > back.source.scale]
        most = np.abs(np.nan_to_num(old.values)).max(initial=0)
        assert away.max(initial=0) <= (np.spacing(np.float32(most)) if floats else 0.501 * back.source.scale)
    for old, new in zip(trial.analog, back.analog, strict=True):
        error = np.abs(old.values - new.values).max(1)
        assert (error <= (1e-6 if floats else 0.51 / 32000) * np.abs(old.values).max(1)).all()


def test_gaps_and_fills_of_known_files():
    expected = {
        "qualisys_gait/Gait - CGM2 1.c3d": (0, 3),  # three frames filled by the software that tracked them
        "tennis_serve_gap_pair/kinematics_tennis_serve_nan.c3d": (145, 0),
        "tennis_serve_gap_pair/kinematics_tennis_serve.c3d": (0, 0),
        "wheelchair_racing_gaps/kinematics_racing_propulsion.c3d": (6384, 0),
        "arm_box_lift_gaps/Vicon.c3d": (305, 0),
    }
    for path, (gaps, fills) in expected.items():
        trial = read_c3d(shared_data(f"mocap3d/{path}"))
        origin = np.concatenate([path.origin for path in trial.trajectories])
        assert ((origin == Origin.MISSING).sum(), (origin == Origin.FILLED).sum()) == (gaps, fills), path


def test_a_calibration_matrix_maps_channels_to_forces():
    folder = shared_data("mocap3d/force_plate_types")
    two, four = (read_c3d(folder / f"TYPE-{kind}.C3D") for kind in (2, 4))
    forces, channels = two.analog[0].values[:3], four.analog[0].values
    assert (two.plates[0].type, four.plates[0].type, two.plates[0].calibration) == (2, 4, None)
    error = [
        np.abs((m @ channels)[:3] - forces).max() for m in (four.plates[0].calibration, four.plates[0].calibration.T)
    ]
    assert error[0] < 0.05 * np.abs(forces).max() < error[1]


def test_recordings_in_metres_and_the_number_of_the_first_frame():
    serve = read_c3d(shared_data("mocap3d/tennis_serve_gap_pair/kinematics_tennis_serve.c3d"))
    assert 1500 < np.nanmax(serve.trajectories.xyz[..., 2]) < 3000
    gait = read_c3d(shared_data("mocap3d/pig_gait_3plates_emg/PiG_Motion3_FF.c3d"))
    assert gait.trajectories.first_frame == 725 and len(gait.events) == 12
    assert ((gait.events.time > 7.24) & (gait.events.time < 10.18)).all()
    assert [plate.channels[2] for plate in gait.plates] == ["Fz1", "Fz2", "Fz3"]


def test_odd_files_are_read_as_the_table_in_the_documentation_says():
    docs = {path.split("/")[-1][:5]: read_document(shared_data(path)) for path in READABLE}
    shapes = {name: (*doc.points.shape[:2], *doc.analog.shape) for name, doc in docs.items()}
    assert shapes == {
        "Dance": (499, 40, 8, 499),
        "Mega ": (29, 0, 4, 36250),
        "bigpa": (323, 205, 30, 1615),
        "giant": (355, 29, 0, 355 * docs["giant"].samples),
        "mocap": (1380, 36, 0, 1380 * docs["mocap"].samples),
        "param": (101, 142, 36, 101),
        "phase": (701, 40, 0, 701 * docs["phase"].samples),
    }
    assert [bool(doc.notes) for doc in docs.values()] == [True, True, False, False, False, False, True]
    assert docs["Mega "].texts("ANALOG", "UNITS") == ("uV", "uV", "°", "Nm")
    assert sum(group.name == "PROCESSING" for group in docs["bigpa"].groups) == 2
    giant = read_c3d(shared_data(f"{MALFORMED}giant.c3d"), units="m")
    assert 1000 < np.nanmedian(giant.trajectories.xyz[1]) < 4000
    assert sum(int((p.origin == Origin.MISSING).sum()) for p in giant.trajectories) == 1806


@pytest.mark.parametrize(("name", "says"), [("Empty", "is empty"), ("bad_parameter_section", "LABELS.*--partial")])
def test_files_that_lost_something_are_refused(name, says):
    with pytest.raises(KinemarkError, match=says):
        read_c3d(shared_data(f"{MALFORMED}{name}.c3d"))


def test_what_is_left_of_a_damaged_file():
    trial = read_c3d(shared_data(f"{MALFORMED}bad_parameter_section.c3d"), partial=True)
    assert trial.trajectories.n_frames == 332 and len(trial.plates) == 2 and trial.events.label[0] == "LHS"
    assert any("unreadable" in note for note in trial.source.notes)
