"""Every command that a page shows is one: its words are those of a command that is there, with options that it has."""

import re
import shlex
from pathlib import Path

import pytest

from kinemark.apps.cli import app

ROOT = Path(__file__).parents[2]
FOLDERS = ("tutorials", "how-to", "theory", "reference")
PAGES = [ROOT / "README.md", *sorted(p for name in FOLDERS for p in (ROOT / "docs" / name).glob("*.md"))]
FENCE = re.compile(r"^```(?:\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def commands_of(page: str) -> list[str]:
    """Lines that call `kinemark` in the fenced blocks of a page, with their continuations, without comments."""
    found = []
    for block in FENCE.findall(page):
        for line in block.replace("\\\n", " ").splitlines():
            if re.match(r"(\$ )?kinemark ", line):
                found.append(line.removeprefix("$ ").removeprefix("kinemark "))
    return found


def refused(command: str) -> str:
    """Why the command line does not understand it; "" where it does. Nothing is run."""
    text = command.replace("…", "um2as").replace("|", "/")  # for what stands "…", any word
    words = shlex.split(text, comments=True)
    try:
        app.parse_args(words, print_error=False, exit_on_error=False)
    except Exception as error:
        return f"{command}: {error!r}"
    return ""


SHOWN = {
    page.relative_to(ROOT).as_posix(): found
    for page in PAGES
    if (found := commands_of(page.read_text(encoding="utf-8")))
}


@pytest.mark.parametrize("page", SHOWN)
def test_what_a_page_tells_to_type_is_understood(page):
    assert [why for command in SHOWN[page] if (why := refused(command))] == []


def test_a_command_that_rots_is_found():
    assert len(SHOWN) > 12 and commands_of("```\n$ kinemark info a.c3d # what\n```\n") == ["info a.c3d # what"]
    assert refused("info a.c3d # what it holds") == ""
    assert refused("info --no-such-option a.c3d") and refused("no-such-command a.c3d") and refused("convert a.c3d")
    assert refused("fill a.c3d -o b.c3d --limit-mm much")
