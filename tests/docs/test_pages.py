"""What the pages name is there: imports of their code, files of the project, sources that are cited."""

import ast
import builtins
import importlib
import re
import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest

from support.tutorial_pages import blocks

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [page for page in sorted(DOCS.rglob("*.md")) if not {"_build", "_generated", "api"} & set(page.parts)]
SOURCES = [*sorted((ROOT / "src").rglob("*.py")), *PAGES]
sys.path.insert(0, str(DOCS / "_ext"))

references = tomllib.loads((ROOT / "src" / "kinemark" / "references.toml").read_text(encoding="utf-8"))


def imports(code):
    """(module, name) of all that is imported from Kinemark."""
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("kinemark"):
            yield from ((node.module, alias.name) for alias in node.names)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_code_on_a_page_imports_what_exists(page):
    for block in blocks(page.read_text(encoding="utf-8")):
        if block.language == "python":
            for module, name in imports(block.text):
                assert hasattr(importlib.import_module(module), name), f"{module} has no {name}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_classes_and_functions_that_code_on_a_page_uses_are_imported_there(page):
    """What a reader copies runs, but for the data, which they have themselves."""
    known, used = set(dir(builtins)), set()
    for block in blocks(page.read_text(encoding="utf-8")):
        if block.language == "python":
            for node in ast.walk(ast.parse(block.text)):
                if isinstance(node, ast.ImportFrom | ast.Import):
                    known |= {alias.asname or alias.name for alias in node.names}
                elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                    used.add(node.func.id)
                elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                    known.add(node.id)
    assert used - known == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_programs_and_tests_that_a_page_names_exist(page):
    named = re.findall(r"\b((?:studies|benchmarks|tests)/[\w/]+\.(?:py|toml))\b", page.read_text(encoding="utf-8"))
    assert [name for name in named if not (ROOT / name).exists()] == []


FILES = [
    f"/{path.relative_to(ROOT).as_posix()}"
    for folder in ("src", "studies", "benchmarks", "tests", "docs")
    for path in (ROOT / folder).rglob("*.py")
]
"""All modules and programs of the project."""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_modules_that_a_page_names_exist(page):
    """By their whole path or the end of it."""
    named = re.findall(r"`([\w/]+\.py)`", page.read_text(encoding="utf-8"))
    ends = [name for name in named if not any(path.endswith(f"/{name}") for path in FILES)]
    assert ends == []


@cache
def spelt():
    """Every name that stands in the project's own programs, tests and page."""
    kinds = [
        "*.py",
        "src/**/*.toml",
        "ui/src/**/*.ts*",
        *(f"{d}/**/*.py" for d in ("src", "studies", "benchmarks", "tests")),
    ]
    return {name for kind in kinds for path in ROOT.glob(kind) for name in re.findall(r"\w+", path.read_text("utf-8"))}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_names_of_the_code_that_a_page_spells_exist(page):
    """Each part of such as `passes.without_outliers`; files' names are not looked at, nor numbers at a name's end."""
    named = re.findall(r"`([A-Za-z]\w*(?:\.\w+)+|[A-Za-z]+_\w+)(?:\(\))?`", page.read_text(encoding="utf-8"))
    of_code = [name for name in named if not re.search(r"\.(py|csv|c3d|cff)$", name)]
    strange = [n for n in of_code if any(not {part, part.rstrip("0123456789")} & spelt() for part in n.split("."))]
    assert strange == []


@pytest.mark.parametrize("key", references)
def test_every_source_is_complete(key):
    entry = references[key]
    assert {"author", "year", "title"} <= entry.keys()
    assert {"journal", "book", "publisher"} & entry.keys()
    assert all(re.fullmatch(r"[^,]+, .+", author) for author in entry["author"])
    assert key.endswith(str(entry["year"])) and 1900 < entry["year"] < 2100
    assert re.fullmatch(r"10\.\d{4,}/\S+", entry.get("doi", "10.1000/none"))


def cited():
    """The words before every year in parentheses or after a name, in sources and pages."""
    name = r"[A-ZÅÖÜÉØ][\w’-]+"
    pattern = re.compile(rf"\b({name})((?:,? (?:&|and|et al\.|{name}))*),? \(?(1[89]\d\d|20[0-2]\d)\b")
    for path in SOURCES:
        for first, others, year in pattern.findall(" ".join(path.read_text(encoding="utf-8").split())):
            yield first, others, int(year), path


NOT_SOURCES = {
    "January",
    "November",
    "April",
    "May",
    "Of",
    "In",
    "For",
    "From",
    "Kinemark",
    "SMART",
    "Hz",
    "All",
    "Over",
}


def test_every_citation_has_its_entry():
    by_year = {}
    for entry in references.values():
        names = {author.split(",")[0].split("-")[-1].split()[-1] for author in entry["author"]}
        by_year.setdefault(entry["year"], []).append(names)
    unknown = set()
    for first, others, year, path in cited():
        said = {word.split("-")[-1] for word in (first, *re.findall(r"[A-ZÅÖÜÉØ][\w’-]+", others))} - NOT_SOURCES
        if said and not any(said & names for names in by_year.get(year, [])):
            unknown.add(f"{first}{others} {year} ({path.name})")
    assert sorted(unknown) == []


def test_every_entry_is_cited():
    text = " ".join(path.read_text(encoding="utf-8") for path in SOURCES)
    others = [*sorted((ROOT / "src").rglob("*.toml")), *sorted((ROOT / "studies").glob("*.py"))]
    text += " ".join(path.read_text(encoding="utf-8") for path in others if path.name != "references.toml")
    for key, entry in references.items():
        said = [entry["author"][0].split(",")[0], *entry.get("also", [])]
        assert any(name in text for name in said), key


def test_the_site_tells_what_a_page_would_load(tmp_path):
    offline = pytest.importorskip("offline", reason="needs Sphinx: pip install '.[docs]'")
    (tmp_path / "a.html").write_text(
        '<a href="https://x.org">x</a><img src="_static/a.png"><link rel="search" href="/x">'
    )
    assert list(offline.remote(tmp_path)) == []
    (tmp_path / "b.html").write_text(
        '<script src="https://x.org/a.js"></script><link rel="stylesheet" href="//x.org/b.css">'
    )
    (tmp_path / "c.css").write_text('@font-face { src: url("https://x.org/f.woff") }')
    assert len(list(offline.remote(tmp_path))) == 3


def test_pages_that_the_sources_name_exist():
    programs = [path for part in ("src", "studies", "benchmarks") for path in sorted((ROOT / part).rglob("*.py"))]
    named = {page for path in programs for page in re.findall(r"\bdocs/[\w/-]+\.md", path.read_text(encoding="utf-8"))}
    assert named and not [page for page in sorted(named) if not (ROOT / page).is_file()]
