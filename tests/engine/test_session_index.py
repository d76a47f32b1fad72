"""The index of a session and what its pages say of subject and date."""

import os
import re
from datetime import date, datetime
from urllib.parse import unquote

import pytest

from kinemark.data import KinemarkError
from kinemark.engine.identities import identity_of_entry, identity_of_file, with_identity
from kinemark.engine.session import Session
from kinemark.io.tdf import read_tdf
from kinemark.io.trial import read_trial
from kinemark.report.drawing_library import library_name
from support.schema import check_quality
from support.sessions import folder_of
from support.shared import shared_data

SECOND = '[[trials]]\nname = "two & <b>"\ndetections = "one.h5"\n'
ABOUT = 'subject = "S <i>01</i>"\ndate = 2026-05-03\n'


def session_of(path, *, more="", about=""):
    folder_of(path, more=more)
    file = path / "session.toml"
    file.write_text(about + file.read_text())
    return path


def links(page):
    """The files that a page links to, as a browser finds them."""
    found = re.findall(r'<a href="([^#"]+)"', page.read_text("utf-8"))
    return [page.parent / unquote(address) for address in found]


def test_the_index_has_every_trial_with_verdict_and_links_that_are_there(tmp_path):
    session = Session.open(session_of(tmp_path, more=SECOND))
    session.run(["one"])
    index = tmp_path / "results/index.html"
    html = index.read_text("utf-8")
    assert "two &amp; &lt;b&gt;" in html and "<b></th>" not in html and html.count("not processed yet") == 1
    before = html
    done = session.run()
    html = index.read_text("utf-8")
    assert "not processed yet" not in html and html != before
    for name, trial in done.items():
        assert trial.quality["verdict"]["headline"].split(":")[0] in html
        assert tmp_path / "results" / name / "report.html" in links(index)
    assert all(file.is_file() for file in links(index)) and len(links(index)) >= 7
    assert "default-src 'none'" in html


def test_an_index_that_says_the_same_is_left_alone(tmp_path):
    session = Session.open(session_of(tmp_path))
    session.run()
    index = tmp_path / "results/index.html"
    os.utime(index, (1, 1))
    session.run()
    assert index.stat().st_mtime == 1


def test_a_trial_that_cannot_be_processed_keeps_the_index_from_nobody(tmp_path):
    session_of(tmp_path, more='[[trials]]\nname = "two"\ndetections = "two.h5"\n')
    (tmp_path / "two.h5").write_bytes(b"no detections")
    with pytest.raises(KinemarkError):
        Session.open(tmp_path).run()
    html = (tmp_path / "results/index.html").read_text("utf-8")
    assert html.count("not processed yet") == 1 and 'href="one/report.html"' in html


def test_the_index_says_why_a_trial_could_not_be_processed(tmp_path):
    """Also where its pages of an earlier run are there; it said "not processed yet", or the verdict of before."""
    session = Session.open(session_of(tmp_path, more=SECOND.replace("one.h5", "two.h5")))
    (tmp_path / "two.h5").write_bytes((tmp_path / "one.h5").read_bytes())
    for _ in range(2):
        session.run(keep_going=True)
        html = (tmp_path / "results/index.html").read_text("utf-8")
        (tmp_path / "two.h5").write_bytes(b"no detections")
    assert "could not be processed: " in html and "two.h5" in html and "not processed yet" not in html
    assert html.count('class="grade') == 1


def test_subject_and_date_stand_on_every_page(tmp_path):
    done = Session.open(session_of(tmp_path, about=ABOUT, more="[fill]\n")).run()
    check_quality(done["one"].quality)
    assert done["one"].quality["identity"]["date"] == "2026-05-03"
    results = tmp_path / "results"
    pages = [results / "index.html", results / "calibration.html", *(results / "one").glob("*.html")]
    assert {page.name for page in pages} == {"index.html", "calibration.html", "report.html", "gaps.html"}
    for page in pages:
        html = page.read_text("utf-8")
        assert "Subject S &lt;i&gt;01&lt;/i&gt; · recorded 2026-05-03" in html and "<i>01" not in html


def test_a_trial_may_say_its_own_and_a_change_is_taken_over(tmp_path):
    session_of(tmp_path, about=ABOUT)
    Session.open(tmp_path).run()
    file = tmp_path / "session.toml"
    file.write_text(file.read_text() + 'subject = "S02"\ndate = "2026-05-04"\n')
    done = Session.open(tmp_path).run()["one"]
    assert "track" not in done.computed and "write" in done.computed
    assert "Subject S02 · recorded 2026-05-04" in (done.folder / "report.html").read_text("utf-8")


def test_what_nobody_states_is_said_and_the_file_gives_its_date(tmp_path):
    session_of(tmp_path)
    noon = datetime(2020, 2, 29, 12).timestamp()
    for file in ("one.h5", "rig.toml"):
        os.utime(tmp_path / file, (noon, noon))
    done = Session.open(tmp_path).run()["one"]
    assert "Subject not stated · file of 2020-02-29" in (done.folder / "report.html").read_text("utf-8")
    assert date.fromisoformat(done.quality["identity"]["file_date"]) == date(2020, 2, 29)
    assert " · file of 2020-02-29 · " in (tmp_path / "results/calibration.html").read_text("utf-8")


def test_pages_of_a_session_share_the_library_or_hold_it_and_nothing_is_computed_for_that(tmp_path):
    session_of(tmp_path)
    Session.open(tmp_path).run()
    results = tmp_path / "results"
    pages = [results / "calibration.html", results / "one/report.html"]
    assert (results / "assets" / library_name()).is_file()
    assert all(page.stat().st_size < 500_000 for page in pages)
    done = Session.open(tmp_path, self_contained=True).run()["one"]
    assert done.computed == () and all(page.stat().st_size > 4_000_000 for page in pages)
    file = tmp_path / "session.toml"
    assert Session.open(tmp_path).run()["one"].computed == () and pages[1].stat().st_size < 500_000
    file.write_text(file.read_text() + "[report]\nself_contained = true\n")
    assert Session.open(tmp_path).run()["one"].computed == () and pages[1].stat().st_size > 4_000_000


def test_a_trial_cannot_take_the_name_of_what_pages_share(tmp_path):
    session_of(tmp_path, more='[[trials]]\nname = "assets"\ndetections = "one.h5"\n')
    with pytest.raises(KinemarkError, match="assets"):
        Session.open(tmp_path)


def test_what_nobody_states_is_as_the_recording_says_it(tmp_path):
    """Subject and day of a BTS file go on its pages and into the C3D file; what the session states goes before."""
    file = shared_data("cameras/gait9_bts/gait9.tdf")
    about = read_tdf(file).about
    text = f'name = "g"\n[calibration]\nfile = "{file}"\n[[trials]]\nname = "g"\ndetections = "{file}"\n'
    for stated, day in (("", "2011-12-15"), ("date = 2011-12-01\n", "2011-12-01")):
        (tmp_path / "session.toml").write_text(stated + text, "utf-8")
        settings = Session.open(tmp_path).settings
        found = identity_of_entry(tmp_path, settings, settings.trials[0], {**about, "subject": "P1"})
        assert (found["subject"], found["date"]) == ("P1", day)
        assert with_identity(about, found)["date"][:10] == day
    trial = read_trial(file)
    assert identity_of_file(trial, file)["date"] == "2011-12-15"
