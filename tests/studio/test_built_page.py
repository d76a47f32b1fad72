"""The page as it is built: its colours, its contract, its size, and what it asks for."""

import gzip
import json
import re
import sys

import pytest

from support.studio_page import PAGE, ROOT

UI = ROOT / "ui"
JS_BYTES, CSS_BYTES = 300_000, 15_000  # gzip: what a browser reads before it shows anything


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


def test_the_page_is_small():
    for ending, most in ((".js", JS_BYTES), (".css", CSS_BYTES)):
        assert 0 < sum(len(gzip.compress(path.read_bytes())) for path in built(ending)) <= most


def test_the_page_asks_nobody_else_for_anything():
    """No address of another host is fetched, and nothing needs what the policy forbids."""
    html = PAGE.read_text("utf-8") if built(".js") else ""
    assert not re.search(r"<script(?![^>]*src=)|<style|\sstyle=|\son\w+=|https?://", html)
    for path in built(".css"):
        assert not re.search(r"url\(|@import", path.read_text("utf-8"))
    code = "".join(path.read_text("utf-8") for path in built(".js"))
    assert not re.search(r"\bnew Function\(|[^.\w]eval\(", code)
