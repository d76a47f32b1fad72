"""One way from any file to a trial and back: each format, what it cannot hold, and every command on every format."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.apps import cli
from kinemark.data import (
    Analog,
    Cloud,
    Events,
    ForcePlate,
    KinemarkError,
    MarkerTrajectory,
    Signal,
    Signals,
    Tracks,
    Trajectories,
    Trial,
    same,
)
from kinemark.engine import error_budget as budget
from kinemark.engine.angles.of_trial import AngleSettings, angles_of_file
from kinemark.engine.fill_files import fill_file
from kinemark.engine.formats import convert
from kinemark.fill import Linear
from kinemark.io.detections_csv import write_detections_csv
from kinemark.io.formats import FORMATS, endings
from kinemark.io.notes import file_note_text
from kinemark.io.records import save
from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.trial import read_trial, write_trial
from kinemark.synth import observe, ring
from kinemark.synth.arm import arm
from support.tdf_files import tracks_block, write

RATE = 50.0
ARM = arm(duration_s=2.0, seed=2)
XYZ = ARM.xyz.copy()
XYZ[3, 40:46] = np.nan
MARKERS = Trajectories(tuple(MarkerTrajectory.measured(n, x) for n, x in zip(ARM.names, XYZ, strict=True)), RATE)


def whole_trial():
    """A trial with a part of every sort."""
    rng = np.random.default_rng(0)
    n = MARKERS.n_frames
    knee = Signal.of("LKneeAngles", "angle", "deg", rng.normal(0, 40, (n, 3)), rate=RATE)
    envelope = Signal.of("TA", "emg", "mV", rng.random((300, 1)), rate=75.0, axes=("envelope",))
    analog = Analog(("Fz1", "b"), ("N", "V"), 333.0, rng.normal(size=(2, 600)), 0.25)
    plate = ForcePlate(1, np.arange(12.0).reshape(4, 3), np.zeros(3), ("Fz1",), np.eye(6))
    events = Events(("Foot Strike",), ("Left",), np.array([0.5]))
    return Trial("whole", MARKERS, (analog,), (plate,), events, signals=Signals((knee, envelope)))


def tdf(path, trajectories):
    xyz = trajectories.xyz / 1000
    block = bytearray(tracks_block(1, xyz, trajectories.names))
    block[4:8] = int(trajectories.rate).to_bytes(4, "little")
    write(path, (5, 1, bytes(block)))


def tracks_h5(path, trajectories):
    """The same points as tracks, as a run leaves them."""
    m, f = np.nonzero(np.isfinite(trajectories.xyz).all(2).T)[::-1]
    start = np.concatenate([[0], np.cumsum(np.bincount(f, minlength=trajectories.n_frames))])
    n = len(f)
    cloud = Cloud(RATE, start, trajectories.xyz[m, f], np.zeros((n, 3, 3)), np.ones(n), np.full((n, 2), -1))
    save(path, Tracks(cloud, m))


FILES = {
    "a.c3d": lambda path: write_trial(Trial("a", MARKERS), path),
    "a.trc": lambda path: write_trial(Trial("a", MARKERS), path),
    "a.csv": lambda path: write_trial(Trial("a", MARKERS), path),
    "a.tdc": lambda path: write_trial(Trial("a", MARKERS), path),
    "trial.h5": lambda path: write_trial(Trial("a", MARKERS), path),
    "trajectories.h5": lambda path: save(path, MARKERS),
    "tracks.h5": lambda path: tracks_h5(path, MARKERS),
    "a.tdf": lambda path: tdf(path, MARKERS),
}
"""One trial in every format that holds one."""


@pytest.fixture(scope="module", params=FILES)
def file(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("trial") / request.param
    FILES[request.param](path)
    return path


def is_the_trial(found):
    """The same markers, in the digits of the format, by their names or, where it has none, their numbers."""
    away = np.abs(found.xyz - MARKERS.xyz)
    named = found.names == MARKERS.names or found.names in (tuple("1234567"), tuple(f"*{k}" for k in range(1, 8)))
    gaps = np.array_equal(np.isnan(found.xyz), np.isnan(MARKERS.xyz))
    return named and gaps and found.rate == RATE and np.nanmax(away) < 0.02


def test_there_is_a_file_of_every_format_that_holds_a_trial():
    assert {path.split(".")[-1] for path in FILES} == {ending[1:] for ending in (*endings("trajectories"), ".tdf")}


# Every command takes every file and sees the same markers


def test_reading(file):
    assert is_the_trial(read_trial(file, rate_hz=RATE).trajectories)


def test_filling(file, tmp_path):
    done = fill_file(file, tmp_path / "out.h5", method=Linear(), name="linear", limit_mm=np.inf, trim=0, rate_hz=RATE)
    (gap,) = done.figures["list"]
    assert (gap["first_frame"], gap["last_frame"], gap["method"]) == (41, 46, "linear")
    filled = read_trial(tmp_path / "out.h5").trajectories
    seen = np.isfinite(MARKERS.xyz)
    assert np.isfinite(filled.xyz).all() and np.abs(filled.xyz - MARKERS.xyz)[seen].max() < 0.02


@pytest.mark.parametrize("ending", endings("trajectories"))
def test_converting(file, ending, tmp_path):
    convert(file, tmp_path / f"b{ending}", rate_hz=RATE)
    assert is_the_trial(read_trial(tmp_path / f"b{ending}", rate_hz=RATE).trajectories)


def test_angles(file, tmp_path):
    model = tmp_path / "model.toml"
    numbers = "\n".join(f'{name} = ["{k}", "*{k}"]' for k, name in enumerate(ARM.names, 1))
    model.write_text(f'name = "numbered"\nbase = "um2as"\n[aliases]\n{numbers}\n')
    settings = AngleSettings(marker_sd_mm=0.5, rate_hz=RATE)
    found = angles_of_file(file, model=str(model), folder=tmp_path / "out", settings=settings).angles
    seen = np.isfinite(found.deg).all(2)
    assert seen.mean() > 0.9 and np.abs(found.deg - ARM.angles.deg)[seen].max() < 0.1


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    folder, rig = tmp_path_factory.mktemp("session"), ring(4)
    write_rig_toml(folder / "rig.toml", rig)
    seen = observe(rig, ARM, noise_px=0.1, seed=1)
    write_detections_csv(folder / "one.csv", seen.detections)
    (folder / "session.toml").write_text(
        'name = "s"\nrate_hz = 50.0\n[calibration]\nfile = "rig.toml"\n[[trials]]\nname = "one"\n'
        'detections = "one.csv"\n'
    )
    return folder


def test_what_limits_a_trial(file, session, monkeypatch):
    """The command reads the names of the markers from the file."""
    given = []

    class Enough(Exception):
        pass

    def taken(named, *args, **options):
        given.append(named)
        raise Enough

    monkeypatch.setattr(budget, "gather_named", taken)
    with pytest.raises(Enough):
        budget.error_budget(session, markers=file, rate_hz=RATE)
    assert is_the_trial(given[0])


# What a format holds


def test_hdf5_holds_all_of_a_trial(tmp_path):
    trial = whole_trial()
    assert write_trial(trial, tmp_path / "a.h5") == ()
    assert same(read_trial(tmp_path / "a.h5"), trial)


@pytest.mark.parametrize("ending", [".trc", ".csv", ".tdc"])
def test_what_a_format_cannot_hold_is_said(ending, tmp_path):
    notes = write_trial(whole_trial(), tmp_path / f"a{ending}")
    said = {note.what: note.names for note in notes if note.kind == "not_written"}
    assert said["signals"] == ("LKneeAngles", "TA") and said["analog"] == ("Fz1", "b")
    assert {"force plates", "events"} <= set(said)
    assert all(note.what in file_note_text(note) for note in notes)


def test_c3d_says_what_it_resampled(tmp_path):
    notes = write_trial(whole_trial(), tmp_path / "a.c3d")
    assert {(note.kind, note.what, note.names) for note in notes} == {
        ("resampled", "analog", ("Fz1", "b")),
        ("resampled", "signals", ("TA",)),
        ("cut", "signals", ("TA",)),
    } | {("cut", "analog", ("Fz1", "b"))}
    back = read_trial(tmp_path / "a.c3d")
    assert back.signals.names == ("LKneeAngles", "TA") and back.analog[0].names == ("Fz1", "b")


def test_the_command_line_passes_it_on(tmp_path, capsys):
    write_trial(whole_trial(), tmp_path / "a.h5")
    cli.app(["convert", str(tmp_path / "a.h5"), str(tmp_path / "a.trc")], result_action="return_value")
    assert "note: signals LKneeAngles, TA" in capsys.readouterr().out


# What is no trial


def test_a_file_without_trajectories_says_what_it_holds(tmp_path):
    rig = ring(2)
    write_rig_toml(tmp_path / "rig.toml", rig)
    seen = observe(rig, ARM, seed=0).detections
    write_detections_csv(tmp_path / "seen.csv", seen)
    save(tmp_path / "seen.h5", seen)
    for name, holds in (("rig.toml", "a calibrated rig"), ("seen.csv", "2D points"), ("seen.h5", "2D points")):
        with pytest.raises(KinemarkError, match=rf"{name} holds {holds} and no trajectories.*\.c3d"):
            read_trial(tmp_path / name)
    (tmp_path / "a.xyz").write_text("1")
    with pytest.raises(KinemarkError, match="no known kind"):
        read_trial(tmp_path / "a.xyz")
    with pytest.raises(KinemarkError, match="Wanted is one above 0"):
        read_trial(tmp_path / "seen.csv", rate_hz=0.0)
    with pytest.raises(KinemarkError, match="wants one of the endings"):
        write_trial(Trial("a", MARKERS), tmp_path / "a.toml")


def test_markers_alone_are_no_file_of_nothing(tmp_path):
    with pytest.raises(KinemarkError, match="no markers"):
        write_trial(replace(whole_trial(), trajectories=Trajectories((), RATE)), tmp_path / "a.trc")


@pytest.mark.parametrize("ending", [".c3d", ".h5", ".trc", ".csv"])
def test_nothing_is_written_that_cannot_be_read(tmp_path, ending):
    for rate in (0.0, float("nan"), -5.0):
        still = Trajectories(tuple(MARKERS), rate)
        with pytest.raises(KinemarkError, match="above 0"):
            write_trial(Trial("a", still), tmp_path / f"a{ending}")
    assert not list(tmp_path.iterdir())
    if ending in (".trc", ".csv"):
        with pytest.raises(KinemarkError, match="no frames"):
            write_trial(Trial("a", MARKERS.frames(0, 0)), tmp_path / f"a{ending}")


def test_every_format_that_is_written_is_read():
    assert all(one.read is not None for one in FORMATS.values())


def test_what_is_known_of_a_capture_goes_along(tmp_path):
    about = {"date": "2011-12-15T09:31:28", "subject": "P 7, é", "plate 1": "AMTI: 0003581"}
    trial = replace(whole_trial(), about=about)
    for ending in (".c3d", ".h5"):
        write_trial(trial, tmp_path / f"a{ending}")
        assert dict(read_trial(tmp_path / f"a{ending}").about) == about
    write_trial(replace(read_trial(tmp_path / "a.c3d"), about={}), tmp_path / "b.c3d")
    assert dict(read_trial(tmp_path / "b.c3d").about) == {}
    notes = write_trial(trial, tmp_path / "a.trc")
    assert ("about the capture", tuple(about)) in {(note.what, note.names) for note in notes}


@pytest.mark.parametrize("ending", [".trc", ".csv", ".tdc"])
def test_a_table_of_markers_says_that_it_does_not_hold_which_axis_goes_up(tmp_path, ending):
    notes = write_trial(replace(whole_trial(), about={"up": "+Y"}), tmp_path / f"a{ending}")
    assert ("which axis goes up", ("+Y",)) in {(note.what, note.names) for note in notes}


@pytest.mark.parametrize(
    ("name", "stated"),
    [
        ("a.tdf", {"rate_hz": 2 * RATE}), ("a.tdf", {"length_unit": "mm"}), ("a.csv", {"length_unit": "m"}),
        ("trial.h5", {"rate_hz": 2 * RATE}), ("tracks.h5", {"rate_hz": 2 * RATE}), ("trial.h5", {"length_unit": "m"}),
    ],
)  # fmt: skip
def test_what_a_file_states_itself_is_not_passed_over(tmp_path, name, stated):
    """Where a rate or a unit that the caller states would change nothing, that is said."""
    FILES[name](tmp_path / name)
    flag = "--rate-hz" if "rate_hz" in stated else "--length-unit"
    with pytest.raises(KinemarkError, match=flag):
        read_trial(tmp_path / name, **stated)
    own = {"a.tdf": "m"}.get(name, "mm")
    assert is_the_trial(read_trial(tmp_path / name, rate_hz=RATE, length_unit=own).trajectories)


def test_a_csv_of_one_frame_says_that_its_rate_is_lost(tmp_path):
    notes = write_trial(Trial("a", MARKERS.frames(0, 1)), tmp_path / "a.csv")
    assert [note.what for note in notes] == ["the rate"]
    assert not write_trial(Trial("a", MARKERS.frames(0, 2)), tmp_path / "b.csv")
    assert not write_trial(Trial("a", MARKERS.frames(0, 1)), tmp_path / "a.trc")


def test_zeros_in_a_csv_are_gaps_as_in_other_files_and_a_marker_at_the_origin_is_not(tmp_path):
    """They were read as samples at the origin, so that `kinemark fill` found no gap."""
    xyz = np.ones((6, 3))
    xyz[2], xyz[4] = 0, [0, 0, 1]
    (tmp_path / "a.csv").write_text(
        "frame,time_s,A_x_mm,A_y_mm,A_z_mm\n"
        + "".join(f"{k + 1},{k / 50},{x},{y},{z}\n" for k, (x, y, z) in enumerate(xyz))
    )
    trial = read_trial(tmp_path / "a.csv")
    assert np.flatnonzero(np.isnan(trial.trajectories.xyz[0]).any(1)).tolist() == [2]
    assert trial.notes == ("(0, 0, 0) is taken for missing; samples: 1",)
    write_trial(Trial("a", Trajectories((MarkerTrajectory.measured("A", xyz),), 50.0)), tmp_path / "b.csv")
    back = read_trial(tmp_path / "b.csv")
    assert np.allclose(back.trajectories.xyz[0], xyz, atol=2e-6) and not back.notes
