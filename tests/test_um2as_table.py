"""The tables of UM²AS' menu name tests that exist, and every entry of the menu."""

import re
from pathlib import Path

from kinemark.engine.um2as.menu import MENU

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "theory" / "um2as.md").read_text("utf-8")
NAMED = re.compile(r"`((?:\w+/)*test_\w+\.py)(?:::(\w+))?`")
ELSEWHERE = {"View Angles"}
"""Ours, beyond the thesis'."""


def test_every_test_that_a_table_names_exists():
    named = [(file.removeprefix("tests/"), test) for file, test in NAMED.findall(PAGE)]
    lacking = [
        f"{file}::{test}" for file, test in named
        if not (ROOT / "tests" / file).is_file()
        or (test and f"def {test}(" not in (ROOT / "tests" / file).read_text("utf-8"))
    ]  # fmt: skip
    assert lacking == [] and len(named) > 40


def test_every_row_of_the_whole_menu_names_one():
    table = PAGE.split("## The whole menu on the screen")[1].split("\n## ")[0]
    rows = [line for line in table.splitlines() if line.startswith("| ") and "---" not in line][1:]
    assert [row for row in rows if not any(test for _, test in NAMED.findall(row))] == [] and len(rows) > 25


def test_every_entry_of_the_menu_is_told_of():
    assert {entry.title for entry in MENU if entry.title not in PAGE} <= ELSEWHERE
