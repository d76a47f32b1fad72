"""Pages share one drawing library, wherever they lie, or hold it."""

import re
from urllib.parse import unquote

import pytest
from plotly.offline import get_plotlyjs

from kinemark.data import KinemarkError
from kinemark.report import write_report
from kinemark.report.drawing_library import ASSETS, assets_for, drawing_library, library_name, relink
from support.captures import capture, judge, ring, walk


def written(page, assets):
    rig = ring()
    records = capture(rig, walk())
    write_report(page, quality=judge(rig, records), rig=rig, **records, assets=assets)
    return page.read_text("utf-8")


def linked(page):
    """The files that a page links to by src, as a browser finds them."""
    found = re.findall(r'<script type="text/plain" id="library" src="([^"]*)"', page.read_text("utf-8"))
    return [(page.parent / unquote(address)).resolve() for address in found]


@pytest.mark.parametrize("place", ["report.html", "walk01/report.html", "a b#?%/preview/rep.html", "../beside/r.html"])
def test_a_page_anywhere_finds_the_file(tmp_path, place):
    results = tmp_path / "results & more"
    page = results / place
    html = written(page, results / ASSETS)
    library = results / ASSETS / library_name()
    assert linked(page) == [library.resolve()] and library.read_text("utf-8") == get_plotlyjs()
    assert len(html) < 150_000 and "://" not in re.findall(r'src="([^"]*)"', html)[0]


def test_without_a_folder_the_page_needs_no_other_file(tmp_path):
    html = written(tmp_path / "report.html", None)
    assert html.count(get_plotlyjs()) == 1 and not linked(tmp_path / "report.html")
    assert [file.name for file in tmp_path.iterdir()] == ["report.html"]


def test_the_file_is_written_once_and_mended_where_it_is_cut(tmp_path):
    drawing_library(tmp_path / "a.html", tmp_path / ASSETS)
    file = tmp_path / ASSETS / library_name()
    before = file.stat().st_mtime_ns
    drawing_library(tmp_path / "sub/b.html", tmp_path / ASSETS)
    assert file.stat().st_mtime_ns == before and [f.name for f in file.parent.iterdir()] == [file.name]
    file.write_bytes(file.read_bytes()[:1000])
    drawing_library(tmp_path / "a.html", tmp_path / ASSETS)
    assert file.read_text("utf-8") == get_plotlyjs()


def test_a_page_goes_from_one_way_to_the_other_and_back(tmp_path):
    page, assets = tmp_path / "walk01/report.html", tmp_path / ASSETS
    shared = written(page, assets)
    relink(page, assets, self_contained=True)
    whole = page.read_text("utf-8")
    assert get_plotlyjs() in whole and not linked(page)
    (assets / library_name()).unlink()
    relink(page, assets, self_contained=False)
    assert page.read_text("utf-8") == shared and linked(page)[0].is_file()
    (assets / library_name()).unlink()
    changed = page.stat().st_mtime_ns
    relink(page, assets, self_contained=False)  # the file alone was lost
    assert page.stat().st_mtime_ns == changed and linked(page)[0].is_file()
    relink(tmp_path / "absent.html", assets, self_contained=True)


def test_a_page_that_shares_the_library_is_not_searched_for_it(tmp_path, monkeypatch):
    page, assets = tmp_path / "walk01/report.html", tmp_path / ASSETS
    written(page, assets)
    monkeypatch.setattr("kinemark.report.drawing_library.inside", lambda: pytest.fail("4.8 MB for nothing"))
    relink(page, assets, self_contained=False)


def test_pages_in_the_results_of_a_session_share_its_library(tmp_path):
    assert assets_for(tmp_path / "walk01_angles") == tmp_path / "walk01_angles" / ASSETS
    drawing_library(tmp_path / "calibration.html", tmp_path / ASSETS)
    assert assets_for(tmp_path / "walk01" / "walk01_angles") == tmp_path / ASSETS


def test_a_folder_that_cannot_be_written_is_told(tmp_path):
    (tmp_path / ASSETS).write_text("a file where the folder should be")
    with pytest.raises(KinemarkError, match="cannot be written"):
        drawing_library(tmp_path / "page.html", tmp_path / ASSETS)
