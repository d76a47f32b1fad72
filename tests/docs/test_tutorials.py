"""The tutorials do what they say, on recordings that the package simulates itself."""

from pathlib import Path

import pytest

from support.tutorial_pages import agrees, blocks, commands, compare, pages, run_page

TUTORIALS = Path(__file__).parents[2] / "docs" / "tutorials"
RUN = [page for page in pages(TUTORIALS) if page.stem != "day"]  # that one is of the screen: tests/docs/test_day.py


@pytest.mark.parametrize("page", RUN, ids=lambda page: page.stem)
def test_a_tutorial_runs_and_prints_what_it_shows(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run_page(page.read_text(encoding="utf-8")) >= 3


def test_there_are_four_tutorials():
    assert [page.stem for page in RUN] == ["angles", "demo", "folder", "wand"]


def test_output_is_compared_word_by_word_and_numbers_within_a_third():
    assert agrees("error 0.10 mm, 15 of 15", "error 0.12 mm, 15 of 15")
    assert not agrees("error 3.0 mm", "error 6.0 mm")
    assert not agrees("15 of 15", "14 of 15")
    assert not agrees("all is well", "all is lost")
    assert agrees("took … s", "took 12.3 s")


def test_a_line_that_does_not_come_is_an_error():
    compare("a\n…\nc\n", "a\nb\nc\n")
    compare("a\n…\n", "a\nb\nc\n")
    for shown in ("a\nc\n", "a\n", "b\n…\n", "…\nd\n", "c\n…\na\n…\n"):
        with pytest.raises(AssertionError):
            compare(shown, "a\nb\nc\n")


def test_blocks_and_commands_are_told_apart():
    page = "```python\nx = 1\n```\nwords\n```console\n$ kinemark a\nout\n$ kinemark b\n```\n"
    assert [block.language for block in blocks(page)] == ["python", "console"]
    assert list(commands(blocks(page)[1].text)) == [("kinemark a", "out\n"), ("kinemark b", "")]
