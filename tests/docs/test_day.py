"""The operator's manual names screens, keys and buttons that the studio has, and its pictures are there and small."""

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "tutorials" / "day.md"
MOST_BYTES = 100_000

text = PAGE.read_text("utf-8")
table = json.loads((ROOT / "ui" / "keys.json").read_text("utf-8"))
screens = {screen["title"]: screen["id"] for screen in table["screens"]}
sections = re.split(r"^## ", text, flags=re.MULTILINE)


def keys_on(named):
    """The keys of commands that can be done on some of these screens; those of no screen can be done on all."""
    return {key for c in table["commands"] if c["screens"] is None or named & {*c["screens"]} for key in c["keys"]}


def bold(part):
    return re.findall(r"\*\*([^*]+)\*\*", part)


@pytest.mark.parametrize("section", sections, ids=lambda section: section.split("\n")[0])
def test_keys_are_those_of_the_screens_that_a_section_names(section):
    named = {screens[words] for words in bold(section) if words in screens}
    keys = re.findall(r"\{kbd\}`([^`]+)`", section)
    assert [key for key in keys if key not in keys_on(named)] == []
    assert keys and named


def test_all_screens_are_in_it():
    assert set(screens) <= set(bold(text))


def test_what_is_set_in_bold_stands_on_the_page():
    """Buttons and words of the studio, as they are written there; whole sentences of the manual's own excepted."""
    sources = "".join(path.read_text("utf-8") for path in sorted((ROOT / "ui" / "src").rglob("*.ts*")))
    said = [words for words in bold(text) if words not in screens]
    own = {"The line at the foot says what the next keys do.", "Click on a place", "Click on a leap"}
    assert own <= set(said)
    assert [words for words in said if words not in own and words not in sources.replace("&nbsp;", " ")] == []


def test_pictures_are_there_small_and_all_shown():
    shown = {name for name in re.findall(r"\(\.\./images/day/([\w-]+\.webp)\)", text)}
    there = {path.name: path.stat().st_size for path in (ROOT / "docs" / "images" / "day").iterdir()}
    assert shown == set(there)
    assert max(there.values()) <= MOST_BYTES
