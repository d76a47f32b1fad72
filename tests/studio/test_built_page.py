"""The page as it is built: its colours, its contract, its size, and what it asks for."""

import gzip
import json
import re
import sys

import pytest

from support.studio_page import PAGE, ROOT, entry, needed_by

UI = ROOT / "ui"
FIRST_BYTES = {"Home": 150_000, "Tracks": 300_000}
"""gzip: the JavaScript that a browser reads before it shows the screen, where the page is opened on it."""
ALL_BYTES, CSS_BYTES = 400_000, 15_000
"""gzip: of all screens together, and of all their styles."""


def built(ending):
    if not PAGE.is_file():
        pytest.skip("the page of the studio is not built: python3 dev.py studio")
    return sorted((PAGE.parent / "assets").glob(f"*{ending}"))


def test_the_colours_of_data_are_those_of_the_reports():
    sys.path.insert(0, str(UI))
    try:
        from colours import TARGET, colours_css
    finally:
        sys.path.remove(str(UI))
    assert TARGET.read_text("utf-8") == colours_css(), "run python3 dev.py studio"


def test_colours_are_stated_in_the_tokens_alone():
    """Views take them from there, so that both themes have all; images of cameras are dark in both."""
    stray = re.compile(r"#[0-9a-fA-F]{3,8}\b|\brgb\(")
    allowed = {"tokens.css", "colours.css", "base.css", "Modal.module.css"}
    found = [path.name for path in (UI / "src").rglob("*.css") if stray.search(path.read_text("utf-8"))]
    assert set(found) <= allowed


def test_the_lock_file_names_no_registry():
    lock = json.loads((UI / "package-lock.json").read_text("utf-8"))
    assert not [name for name, package in lock["packages"].items() if "resolved" in package]


def test_the_types_are_those_of_the_contract():
    """Every record of the contract is in the generated types; `npm run types` writes them."""
    records = json.loads((UI / "openapi.json").read_text("utf-8"))["components"]["schemas"]
    types = (UI / "src" / "api.gen.ts").read_text("utf-8")
    missing = [name for name in records if f"\n        {name}: {{" not in types and f"\n        {name}: " not in types]
    assert not missing
    fields = {(name, field) for name, record in records.items() for field in record.get("properties", {})}
    assert not [one for one in fields if not re.search(rf"\b{re.escape(one[1])}\??:", types)]


def zipped(paths):
    """Bytes of files as they go over the wire."""
    return sum(len(gzip.compress(path.read_bytes())) for path in paths)


def test_the_page_is_small():
    assert 0 < zipped(built(".js")) <= ALL_BYTES
    assert 0 < zipped(built(".css")) <= CSS_BYTES


@pytest.mark.parametrize("screen", FIRST_BYTES)
def test_a_screen_that_is_opened_first_loads_little(screen):
    if built(".js"):
        assert 0 < zipped(needed_by(screen)) <= FIRST_BYTES[screen]


def test_three_dimensions_and_curves_come_with_the_screens_that_have_them():
    """Home needs neither, and what it needs Tracks needs too, save itself."""
    if not built(".js"):
        return
    home, tracks = needed_by("Home"), needed_by("Tracks")
    large = {path for path in tracks if len(path.read_bytes()) > 50_000} - {entry()}
    assert large
    assert not large & home
    assert {path.name.split("-")[0] for path in home - tracks} == {"Home"}


def test_the_page_asks_nobody_else_for_anything():
    """No address of another host is fetched, and nothing needs what the policy forbids."""
    html = PAGE.read_text("utf-8") if built(".js") else ""
    assert not re.search(r"<script(?![^>]*src=)|<style|\sstyle=|\son\w+=|https?://", html)
    for path in built(".css"):
        assert not re.search(r"url\(|@import", path.read_text("utf-8"))
    code = "".join(path.read_text("utf-8") for path in built(".js"))
    assert not re.search(r"\bnew Function\(|[^.\w]eval\(", code)
