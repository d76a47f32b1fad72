"""Pages printed to PDF: A4, of what the page draws by its scripts; and what is said where that cannot be."""

import stat
import sys
from pathlib import Path

import pytest

from kinemark.apps.commands.pdf import pdf
from kinemark.apps.pdf import print_pdf
from kinemark.data import KinemarkError
from support.browser import chromium
from support.paper import A4_PT, sizes

PAGE = """<!DOCTYPE html><title>a</title><style>@page { size: A4 } h1 { break-before: page }</style><p>one</p>
<script>setTimeout(() => document.body.append(document.createElement("h1")), 500);</script>"""


def test_a_page_is_printed_on_a4_when_its_scripts_have_drawn(tmp_path):
    chromium()
    page = tmp_path / "a page.html"
    page.write_text(PAGE, "utf-8")
    target = print_pdf(page, tmp_path / "out" / "a page.pdf")
    assert sizes(target.read_bytes()) == [A4_PT, A4_PT]  # the second page comes half a second later
    assert [path.name for path in target.parent.iterdir()] == [target.name]


def test_without_a_browser_it_is_said_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setenv("KINEMARK_BROWSER", "")
    (tmp_path / "a.html").write_text(PAGE, "utf-8")
    with pytest.raises(KinemarkError, match=r"neither Chromium, Chrome nor Edge was found.*print it to a file there"):
        print_pdf(tmp_path / "a.html", tmp_path / "a.pdf")
    with pytest.raises(KinemarkError, match="There is no page"):
        print_pdf(tmp_path / "b.html", tmp_path / "b.pdf")
    (tmp_path / "c.csv").write_text("1")
    with pytest.raises(KinemarkError, match=r"c\.csv is no page"):
        print_pdf(tmp_path / "c.csv", tmp_path / "c.pdf")


@pytest.mark.skipif(sys.platform == "win32", reason="a script as a program")
def test_what_a_browser_said_is_said_where_it_printed_nothing(tmp_path, monkeypatch):
    browser, kept = tmp_path / "browser", tmp_path / "a.pdf"
    browser.write_text("#!/bin/sh\necho 'no paper' >&2\n")
    browser.chmod(browser.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("KINEMARK_BROWSER", str(browser))
    (tmp_path / "a.html").write_text(PAGE, "utf-8")
    kept.write_bytes(b"an earlier one")
    with pytest.raises(KinemarkError, match=r"browser printed nothing of .*a\.html: no paper"):
        print_pdf(tmp_path / "a.html", kept)
    assert kept.read_bytes() == b"an earlier one"


def test_the_command_prints_the_reports_of_a_session_by_its_trials(tmp_path, monkeypatch, capsys):
    """What is printed and where to; the printing itself is above."""
    for name in ("walk01", "walk02"):
        (tmp_path / "results" / name).mkdir(parents=True)
        (tmp_path / "results" / name / "report.html").write_text(PAGE, "utf-8")
    printed = {}
    monkeypatch.setattr("kinemark.apps.pdf.print_pdf", lambda page, target: printed.setdefault(page, target))
    pdf(tmp_path, output=tmp_path / "out")
    assert [(page.parent.name, target.name) for page, target in printed.items()] == [
        ("walk01", "walk01.pdf"),
        ("walk02", "walk02.pdf"),
    ]
    pdf(tmp_path / "results" / "walk01" / "report.html")
    said = capsys.readouterr().out.split()
    assert [Path(line).name for line in said] == ["walk01.pdf", "walk02.pdf", "walk01.pdf"]
    with pytest.raises(KinemarkError, match="holds no report"):
        pdf(tmp_path / "results")
