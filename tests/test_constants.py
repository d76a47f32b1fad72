"""Every number that stands at the top of a module says what it is, and what it comes from.

Said beside it or below it: unit and meaning, and one of these origins (docs/architecture.md has the list): a format, a
definition or exact mathematics; a paper or thesis, by its year or its authors; a convention; a measurement, with the
benchmark, study or page of the documentation that has it; or *chosen*, where it is none of these.
"""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ROOT / "src" / "kinemark"
ORIGIN = re.compile(
    r"\bformats?\b|by definition|\bexact\b|convention|[cC]hosen|measured (?:on|in|by)|kernel\.c|library\.c|\bpapers?\b"
    r"|\bthesis|\bdocument|KISS|UM²AS|Swamidas|ITU|\b(?:19|20)\d\d\b|benchmarks/|studies/|docs/"
)
PAGE = re.compile(r"(?:benchmarks|studies|docs)/[\w/.-]*\w")
ASIDE = re.compile(PAGE.pattern + r"|\b(?:[cC]hosen|conventional|exact|by definition|of the format|see)\b")
FEWEST_WORDS = 3
"""Words of a statement besides its origin; chosen: a unit alone does not say what a number means."""


class Constant(NamedTuple):
    name: str
    line: int
    said: str


def constants(source: str) -> Iterator[Constant]:
    """The numbers at the top of a module, whose names are in capitals, and what is said of each."""
    body, lines = ast.parse(source).body, source.splitlines()
    for node, after in zip(body, [*body[1:], None], strict=True):
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None or not numeric(node.value):
            continue
        names = [n.id for n in ast.walk(ast.Module([node], [])) if isinstance(n, ast.Name) and is_stored(n)]
        if names and all(name.lstrip("_").isupper() for name in names):
            beside = comments("\n".join(lines[node.lineno - 1 : node.end_lineno]))
            below = after.value.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else ""
            yield Constant(", ".join(names), node.lineno, " ".join([*beside, str(below)]).strip())


def comments(statement: str) -> list[str]:
    """Those beside the lines of a statement."""
    tokens = tokenize.generate_tokens(io.StringIO(statement).readline)
    return [token.string.lstrip("# ") for token in tokens if token.type == tokenize.COMMENT]


def is_stored(name: ast.Name) -> bool:
    return isinstance(name.ctx, ast.Store)


def numeric(value: ast.expr) -> bool:
    """Whether there are numbers in it and no texts."""
    leaves = [node.value for node in ast.walk(value) if isinstance(node, ast.Constant)]
    numbers = [leaf for leaf in leaves if isinstance(leaf, int | float) and not isinstance(leaf, bool)]
    return bool(numbers) and not any(isinstance(leaf, str) for leaf in leaves)


def wrong(constant: Constant) -> str:
    """What its statement lacks; empty where nothing."""
    if len(re.findall(r"\w+", ASIDE.sub("", constant.said))) < FEWEST_WORDS:
        return "says neither what it is nor its unit"
    if not ORIGIN.search(constant.said):
        return "does not say what it comes from"
    gone = [page for page in PAGE.findall(constant.said) if not (ROOT / page).exists()]
    return f"names {gone[0]}, which is not there" if gone else ""


def test_constants_say_their_unit_and_origin():
    found = [(path, c) for path in sorted(SOURCES.rglob("*.py")) for c in constants(path.read_text("utf-8"))]
    bad = [f"{path.relative_to(SOURCES)}:{c.line} {c.name} {wrong(c)}" for path, c in found if wrong(c)]
    assert len(found) > 500
    assert not bad, "\n".join(bad)


@pytest.mark.parametrize(
    "source, lack",
    [
        ("MOST = 5", "says neither"),
        ("MOST = 5  # px; chosen", "says neither"),
        ("MOST = 5  # px; what is farther off is another thing", "comes from"),
        ("MOST = 5  # px that a marker may be off; chosen", ""),
        ('MOST = 5\n"""px that a marker may be off (Shafiq 2001)."""', ""),
        ("A, B = 2, 3  # px and mm of a marker; of the format", ""),
        ("MOST = 5  # px that a marker may be off; measured in studies/nowhere.py", "which is not there"),
    ],
)
def test_a_statement_that_lacks_something_is_told(source, lack):
    (constant,) = constants(source)
    assert (lack in wrong(constant)) if lack else not wrong(constant)


def test_texts_and_small_names_are_no_constants():
    assert not list(constants('NAME = "px"\nplace = 3\nTABLE = {"a": 1}\nOTHER = NAME\nFLAG = True'))
