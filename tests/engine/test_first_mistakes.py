"""Mistakes of the first day: each error says what there is, in words of the file, before hours of work."""

import pytest

from kinemark.apps.cli import app, error_text
from kinemark.data import KinemarkError
from kinemark.data.edits import Trim
from kinemark.engine.editing.journal import Journal
from kinemark.engine.formats import convert
from kinemark.engine.session import Session
from kinemark.engine.settings import read_settings
from kinemark.engine.white_pixels import write_white_pixels
from kinemark.io.model_toml import load_model
from kinemark.io.rig_toml import read_rig_toml
from support.named_sessions import session_of

WHOLE = 'name = "n"\n[calibration]\nfile = "rig.toml"\n[[trials]]\nname = "a"\ndetections = "a.csv"\n'


def error_of(folder, text):
    """What is said of a session file with this text."""
    (folder / "session.toml").write_text(text)
    with pytest.raises(KinemarkError) as said:
        read_settings(folder / "session.toml")
    return str(said.value)


@pytest.mark.parametrize(
    ("left_out", "advice"),
    [
        ('[calibration]\nfile = "rig.toml"\n', "one of file, control_points, control_frame, wand, single_marker"),
        ('[[trials]]\nname = "a"\ndetections = "a.csv"\n', "each recording has a table [[trials]]"),
        ('name = "n"\n', 'name = "normal gait"'),
    ],
)
def test_what_is_missing_is_said_with_what_to_write(tmp_path, left_out, advice):
    said = error_of(tmp_path, WHOLE.replace(left_out, "", 1))
    assert "is missing" in said and advice in said


def test_keys_that_are_listed_can_be_written(tmp_path):
    said = error_of(tmp_path, "nmae = 1\n" + WHOLE)
    listed = said.partition("there are ")[2].partition("\n")[0].split(", ")
    assert "detect" in listed and not [key for key in listed if key in ("detect_cameras", "label_subjects")]


def test_a_trial_that_is_not_there_is_named_as_it_was_typed(tmp_path):
    session = Session.open(session_of(tmp_path, "walk01"))
    for ask in (lambda: session.run(["walk07"]), lambda: session.trial("walk07")):
        with pytest.raises(KinemarkError, match=r"There is no trial walk07; the session has walk01\."):
            ask()


@pytest.mark.parametrize("label", ['template = ["earlyer.c3d"]', 'static = ["earlyer.c3d"]', 'names = "earlyer.c3d"'])
def test_files_that_name_markers_are_looked_for_before_the_work(tmp_path, label):
    session = Session.open(session_of(tmp_path, "walk01", label=label))
    with pytest.raises(KinemarkError, match=r"\[label\] names earlyer\.c3d, which is not a file"):
        session.run()
    assert not list((tmp_path / "results").rglob("*.h5"))  # nothing was computed of the trial
    assert session.run(to="detect")["walk01"].computed == ("detect",)  # which needs no names


def test_a_file_where_a_list_is_wanted_is_answered_with_the_list(tmp_path):
    said = error_of(tmp_path, WHOLE + '[label]\ntemplate = "earlier.c3d"\n')
    assert """label.template: wants a list: ['earlier.c3d']""" in said and "tuple" not in said


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [
        ('name = "n"', 'name = "n"\nrate_hz = nan', "rate_hz: wants a finite number, found nan"),
        ('name = "n"', 'name = "n"\nrate_hz = "fast"', "rate_hz: wants a number, found 'fast'"),
        ('name = "n"', 'name = "n"\nvolume_mm = [[0, 0, 0], [1, 1]]', "volume_mm #2 #3: is missing"),
        ("[calibration]", '[cameras]\ninterlaced = "up"\n[calibration]', "cameras.interlaced: wants true or false"),
        ("[calibration]", '[cameras]\nnames = ["c", "c"]\n[calibration]', "names must differ, found ['c', 'c']\n"),
        ("[[trials]]", "[trials]", "write [[trials]], with two brackets"),
        ('name = "a"', 'name = "a"\nframes = [0, 5]', "trials #1.frames #1: should be greater than or equal to 1"),
        ('name = "a"', 'name = "a"\nkind = "sttic"', "trials #1.kind: should be 'motion', 'static'"),
    ],
)
def test_a_value_of_the_wrong_kind_is_told_in_words_of_the_file(tmp_path, old, new, wanted):
    said = error_of(tmp_path, WHOLE.replace(old, new, 1))
    assert wanted in said and "Input" not in said and "constrained" not in said


@pytest.mark.parametrize(
    ("table", "meant"),
    [('[label]\ntemplat = ["a.c3d"]', "'template'"), ("[track]\nmethd = 'kiss_tracking'", "'method'")],
)
def test_a_mistyped_key_of_a_method_is_guessed_from_all_that_its_table_may_have(tmp_path, table, meant):
    said = error_of(tmp_path, f"{WHOLE}{table}\n")
    assert f"did you mean {meant}?" in said and "there are method, " in said


def test_an_ending_that_holds_nothing_of_it_is_answered_with_those_that_do(tmp_path):
    session_of(tmp_path)
    with pytest.raises(KinemarkError, match=r"Choose another ending: \.c3d, .*\.trc"):
        convert(tmp_path / "earlier.c3d", tmp_path / "earlier.xyz")
    with pytest.raises(KinemarkError, match=r"a file without an ending can hold none of it"):
        convert(tmp_path / "earlier.c3d", tmp_path / "earlier")


def test_results_of_before_are_told_from_none(tmp_path, capsys):
    """After an update of the program or another setting nothing is up to date, and yet there are results."""
    folder, said = session_of(tmp_path, "walk01"), []
    for change in ("", "[track]\ngate = 4.0\n"):
        file = folder / "session.toml"
        file.write_text(file.read_text() + change)
        for run in (False, True):
            if run and not change:
                Session.open(folder).run(to="track")
            with pytest.raises(SystemExit):
                app(["status", str(folder)])
            said.append(capsys.readouterr().out)
    assert said[0].startswith("walk01: nothing done; to do: detect") and "there are results" not in said[0]
    assert said[1].startswith("walk01: detect, track done") and "there are results" not in said[1]
    assert said[2].startswith("walk01: detect done; to do: track")
    assert "(there are results of other settings, input or version)" in said[2]


def test_results_that_were_deleted_are_not_said_to_be_of_other_settings(tmp_path, capsys):
    session = Session.open(session_of(tmp_path, "walk01"))
    session.run(to="detect")
    next((tmp_path / "results/walk01").glob("detect*.h5")).unlink()
    with pytest.raises(SystemExit):
        app(["status", str(tmp_path)])
    said = capsys.readouterr().out
    assert "to do: detect" in said and "there are results" not in said


def test_a_session_where_a_trial_is_wanted_is_told_so(tmp_path):
    session_of(tmp_path, "walk01")
    with pytest.raises(KinemarkError, match="is a session, not a file of cameras or a trial"):
        read_rig_toml(tmp_path / "session.toml")


def test_a_file_where_a_folder_is_wanted_is_told_so(tmp_path):
    (tmp_path / "a.c3d").touch()
    with pytest.raises(OSError) as said:
        (tmp_path / "a.c3d").mkdir()
    assert "a.c3d is a file, and a folder is wanted there" in error_text(said.value)


def test_a_model_with_another_dash_is_guessed():
    with pytest.raises(KinemarkError, match="did you mean 'isb_upper_limb'"):
        load_model("isb-upper-limb")


@pytest.mark.parametrize(("target", "wanted"), [("a.avi", "does not end in .mkv"), ("a.mkv", "a.mkv exists")])
def test_a_target_of_white_pixels_that_cannot_be_is_told_why(tmp_path, target, wanted):
    (tmp_path / "a.mkv").touch()
    with pytest.raises(KinemarkError, match=wanted):
        write_white_pixels(tmp_path / "in.mkv", tmp_path / target, threshold=60)


@pytest.mark.parametrize("name", ["laborotory", "day.2", "laborotory/session.toml"])
def test_a_mistyped_folder_does_not_lead_to_a_session_of_the_folder_above_it(tmp_path, name):
    with pytest.raises(KinemarkError, match="Look at its name") as raised:
        Session.open(tmp_path / name)
    assert "init" not in str(raised.value)
    (tmp_path / "bare").mkdir()
    with pytest.raises(KinemarkError, match=r"kinemark init .*bare"):
        Session.open(tmp_path / "bare")


def test_a_session_file_with_a_byte_order_mark_is_read(tmp_path):
    """As Windows' editor writes one."""
    (tmp_path / "session.toml").write_bytes(b"\xef\xbb\xbf" + WHOLE.replace("\n", "\r\n").encode())
    assert read_settings(tmp_path / "session.toml").name == "n"


def test_what_was_said_of_a_trial_that_was_renamed_is_not_passed_over(tmp_path, capsys):
    root = session_of(tmp_path, "walk01")
    Journal.of(root, "walk01").append([Trim(2, 9)])
    assert not Session.open(root).journals_of_no_trial
    file = root / "session.toml"
    file.write_text(file.read_text().replace('name = "walk01"', 'name = "gait01"'))
    Journal.of(root, "empty").path.touch()
    app(["status", str(root)], result_action="return_value")
    told = " ".join(capsys.readouterr().err.split())
    assert "walk01.jsonl has what people said of a trial 'walk01'" in told and "empty" not in told


def test_a_folder_inside_or_around_a_session_names_the_session(tmp_path, monkeypatch):
    """`kinemark run lab/results` advised to make a second session in the results of the first."""
    lab = tmp_path / "my lab"
    (lab / "results").mkdir(parents=True)
    (lab / "session.toml").write_text(WHOLE)
    for wrong, meant in (("my lab/results", "'my lab'"), (".", "'my lab'")):
        monkeypatch.chdir(tmp_path)
        with pytest.raises(KinemarkError, match=f"Did you mean the session in {meant}"):
            Session.open(wrong)
    monkeypatch.chdir(lab / "results")
    with pytest.raises(KinemarkError, match=r"Did you mean the session in .*my lab'"):
        Session.open(".")


def test_a_session_in_place_of_a_file_names_the_file(tmp_path):
    (tmp_path / "session.toml").write_text(WHOLE)
    with pytest.raises(KinemarkError, match="Process it with kinemark run"):
        convert(tmp_path, tmp_path / "a.trc")
    (tmp_path / "results" / "a").mkdir(parents=True)
    (tmp_path / "results" / "a" / "a.c3d").touch()
    with pytest.raises(KinemarkError, match=r"Give a file in its results, as .*a\.c3d"):
        convert(tmp_path, tmp_path / "a.trc")
