"""Figures that a page takes from a kept run are those of the run, where `<!-- figures: STUDY -->` stands before them.

Each decimal figure up to the next empty line must stand in the run, or be what a figure of the run rounds to.
"""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
RUNS = DOCS / "validation" / "runs"
MARKED = re.compile(r"<!-- figures: (\w+) -->\n(.*?)(?:\n\n|\Z)", re.DOTALL)
FIGURE = re.compile(r"(?<![\w.])\d+\.\d+(?![\w.])")
PARTS = [
    (page.relative_to(DOCS).as_posix(), study, text)
    for page in sorted(DOCS.rglob("*.md"))
    if "_build" not in page.parts
    for study, text in MARKED.findall(page.read_text(encoding="utf-8"))
]


def stale(text: str, output: str) -> list[str]:
    """The figures of a text that no figure of the output is, or rounds to."""
    there = [float(figure) for figure in FIGURE.findall(output)]
    return [
        figure
        for figure in FIGURE.findall(text)
        if not any(abs(float(figure) - one) <= 0.5001 * 10.0 ** -len(figure.partition(".")[2]) for one in there)
    ]


@pytest.mark.parametrize(("page", "study", "text"), PARTS, ids=[f"{page}: {study}" for page, study, _ in PARTS])
def test_figures_of_a_page_are_those_of_the_run_that_it_names(page, study, text):
    assert FIGURE.search(text), "no figure follows the mark"
    output = (RUNS / f"{study}.txt").read_text(encoding="utf-8").partition("\n\n")[2]
    assert stale(text, output) == []


def test_a_figure_that_is_not_of_the_run_is_found():
    assert len(PARTS) >= 5
    assert stale("97.8 % within 5 mm, 0.1 px", "recall 97.8, 0.104") == []
    assert stale("98.1 % within 5 mm", "recall 97.8") == ["98.1"]
