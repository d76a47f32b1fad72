"""A newcomer's walk: what `docs/architecture.md` says of where things are, held against the sources."""

import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "kinemark"
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
SECTION = PAGE.partition("## Where things are")[2].partition("\n## ")[0]
ROWS = [row.strip("| ").split(" | ") for row in SECTION.splitlines() if row.startswith("|") and "grep" in row]
MOST_FILES = 12  # what a search may find: a list that is read at a glance

# What is looked for → words that stand in the first file that the row names
SAYS = {
    "KISS eq. 8": ("KISS eq. 8 with nine constants", "def epipolar_constants"),
    "UM²AS eq. 2.8": ("UM²AS eq. 2.8", "one of them is left out if it is at least twice as far"),
    "Swamidas' region of acceptance": ("region of acceptance", "h = n (e + p |v|)"),
    "the Schur complement": ("Schur complement", "def schur_complement"),
    "what happens when a video is truncated": ("def truncated", "is truncated or damaged. Copy it again"),
}


def words(path: Path) -> str:
    """A file's text, lower case, in one line."""
    return " ".join(path.read_text(encoding="utf-8").lower().split())


def found_by(command: str) -> set[str]:
    """The files below src/kinemark that `grep -rn WORDS src` names; with i, whatever the case."""
    _, options, searched, where = shlex.split(command)
    pattern = re.compile(searched, re.IGNORECASE if "i" in options else 0)
    files = {p for p in (ROOT / where).rglob("*.py") if pattern.search(p.read_text(encoding="utf-8"))}
    return {path.relative_to(PACKAGE).as_posix() for path in files}


def test_the_walk_has_a_row_for_each():
    assert [any(row[0].startswith(what) for row in ROWS) for what in SAYS] == [True] * len(SAYS)
    assert len(ROWS) == len(SAYS)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_a_row_of_the_walk_leads_there(row):
    looked_for, folders, command, place = row
    files = re.findall(r"`([\w/]+\.py)`", place)
    for what in SAYS[next(key for key in SAYS if looked_for.startswith(key))]:
        assert what.lower() in words(PACKAGE / files[0])
    assert all((PACKAGE / file).is_file() for file in files)
    found = found_by(command.strip("`"))
    assert files[0] in found and len(found) <= MOST_FILES
    steps = [step.replace(" ", "_") for step in folders.split(" › ")]
    assert "/".join(steps) + ".py" == files[0]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_what_a_row_says_is_used_there_is_used_there(row):
    first, *users = re.findall(r"`([\w/]+)\.py`", row[3])
    module = first.rpartition("/")[2]
    assert [user for user in users if module not in (PACKAGE / f"{user}.py").read_text(encoding="utf-8")] == []


def test_the_message_of_a_truncated_video_is_the_one_on_its_page():
    page = words(ROOT / "docs" / "how-to" / "truncated-video.md").replace("> ", "")
    for part in ("is truncated or damaged. copy it again", "convert it first", "ffmpeg -i"):
        assert part in page and part in words(PACKAGE / "io" / "video.py")
