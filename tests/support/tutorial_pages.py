"""Tutorials as programs: the fenced blocks of a page, run in order, and their output compared with what it shows.

`console` blocks hold commands after `$ ` and, below each, its output. A `text` block after a `python` block is what
that prints. In shown output `…` stands for anything, a line of `…` for any lines; words must agree, whole numbers too,
and numbers with decimals within a third, as machines differ.
"""

from __future__ import annotations

import contextlib
import io
import math
import os
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

from support.command_line import command as run_words

FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"-?\d+\.\d+")
SLACK = 1 / 3


class Block(NamedTuple):
    """A fenced block: its language, and what stands in it."""

    language: str
    text: str


def blocks(page: str) -> list[Block]:
    """Of a page in Markdown."""
    return [Block(*found) for found in FENCE.findall(page)]


def run_page(page: str) -> int:
    """Run a page's blocks in the present folder; how many outputs were compared.

    Raises:
        AssertionError: an output is not what the page shows.
    """
    names: dict[str, Any] = {}
    printed, compared = "", 0
    for block in blocks(page):
        if block.language == "python":
            printed = run_python(block.text, names)
        elif block.language == "text":
            compare(block.text, printed)
            compared += 1
        elif block.language == "console":
            for command, shown in commands(block.text):
                compare(shown, run_command(command))
                compared += 1
    return compared


def run_python(text: str, names: dict[str, Any]) -> str:
    """What a block prints."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        exec(compile(text, "tutorial", "exec"), names)
    return out.getvalue()


def commands(text: str) -> Iterator[tuple[str, str]]:
    """Each command of a console block, and the output shown below it."""
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command, _, shown = part.partition("\n")
        yield command, shown


def run_command(command: str) -> str:
    """What `kinemark …` prints; the shell's wildcards are expanded.

    It runs in this process; what a process of its own costs and does is tested elsewhere (tests/apps/test_startup.py).

    Raises:
        AssertionError: it is another command, or it failed.
    """
    program, *words = shlex.split(command)
    assert program == "kinemark", command
    arguments = [name for word in words for name in (sorted(map(str, Path().glob(word))) if "*" in word else [word])]
    with (
        contextlib.redirect_stdout(io.StringIO()) as out,
        contextlib.redirect_stderr(io.StringIO()),
        mock.patch.dict(os.environ, {"COLUMNS": "200"}),
    ):
        run_words(*arguments)
    return out.getvalue()


def compare(shown: str, real: str) -> None:
    """Hold what a page shows against what came out.

    Raises:
        AssertionError: a line that is shown does not come, or not in this order.
    """
    lines, at, anywhere = [line for line in real.splitlines() if line.strip()], 0, False
    for line in shown.splitlines():
        if not line.strip():
            continue
        if line.strip() == "…":
            anywhere = True
            continue
        reach = range(at, len(lines)) if anywhere else range(at, min(at + 1, len(lines)))
        found = next((k for k in reach if agrees(line, lines[k])), None)
        assert found is not None, f"the page shows\n  {line}\nand this came:\n{real}"
        at, anywhere = found + 1, False
    assert anywhere or at == len(lines), f"the page ends before\n  {lines[at]}"


def agrees(shown: str, real: str) -> bool:
    """Whether one line is another, but for `…` and the digits after the point."""
    pieces = [re.escape(part) for part in re.split(r"…|-?\d+\.\d+", shown.rstrip())]
    holes = re.findall(r"…|-?\d+\.\d+", shown)
    wanted = pieces[0] + "".join(
        ("(?:.*)" if hole == "…" else r"(-?\d+\.\d+)") + part for hole, part in zip(holes, pieces[1:], strict=True)
    )
    wanted = re.sub(r"(\\ )+", r"\\s+", wanted)
    match = re.fullmatch(wanted, real.rstrip())
    numbers = [float(hole) for hole in holes if hole != "…"]
    return match is not None and all(
        math.isclose(float(found), number, rel_tol=SLACK, abs_tol=0.15)
        for found, number in zip(match.groups(), numbers, strict=True)
    )


def pages(folder: Path) -> list[Path]:
    """The tutorials, without the page that lists them."""
    return sorted(page for page in folder.glob("*.md") if page.stem != "index")
