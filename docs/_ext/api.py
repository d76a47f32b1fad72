"""The API reference: a page for each part of the package, from its `__all__` and docstrings, made at every build.

Docstrings are plain text in Google's convention with indented equations. Before Sphinx reads them as
reStructuredText, `as_rst` protects what that would take for markup.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import kinemark
from sphinx.application import Sphinx

SECTIONS = re.compile(r"^(Args|Attributes|Example|Examples|Note|Raises|Returns|Yields):$")
DIRECTIVES = {"class": "autoclass", "exception": "autoexception", "function": "autofunction", "data": "py:data"}


# ---- Pages ----


def parts() -> dict[str, list[str]]:
    """part of the package, as `fill` → full names of what it exports, each once, its shortest name."""
    found: dict[str, dict[int, str]] = {}
    for name in kinemark.__all__:
        thing = getattr(kinemark, name)
        if (part := _part_of(thing)) is not None:
            found.setdefault(part, {})[id(thing)] = f"kinemark.{name}"
    for module in pkgutil.iter_modules(kinemark.__path__):
        if module.ispkg:
            package = importlib.import_module(f"kinemark.{module.name}")
            for name in getattr(package, "__all__", ()):
                thing = getattr(package, name)
                elsewhere = any(id(thing) in names for part, names in found.items() if part != module.name)
                if not inspect.ismodule(thing) and not (elsewhere and _part_of(thing) != module.name):
                    found.setdefault(module.name, {}).setdefault(id(thing), f"kinemark.{module.name}.{name}")
    return {part: sorted(set(names.values()), key=_by_last_name) for part, names in sorted(found.items())}


def _part_of(thing: Any) -> str | None:
    """Second component of the module that defines something, None for plain values as the version."""
    module = getattr(thing, "__module__", "").split(".")
    return module[1] if module[0] == "kinemark" and len(module) > 1 else None


def _by_last_name(name: str) -> tuple[bool, str]:
    """Classes first."""
    last = name.rsplit(".", 1)[-1]
    return last[0].islower(), last


def page(part: str, names: list[str]) -> str:
    """One page of the reference, reStructuredText."""
    title = f"kinemark.{part}"
    package = importlib.import_module(title)
    said = "\n".join(as_rst((inspect.getdoc(package) or "").splitlines()))
    return "\n\n".join([f"{title}\n{'=' * len(title)}", said, *(_entry(name) for name in names), ""])


def _entry(name: str) -> str:
    """The directive that documents one thing."""
    module, last = name.rsplit(".", 1)
    thing = getattr(importlib.import_module(module), last)
    kind = "data"
    if inspect.isclass(thing):
        kind = "exception" if issubclass(thing, BaseException) else "class"
    elif callable(thing) and hasattr(thing, "__name__"):
        kind = "function"
    options = "\n   :members:" if kind == "class" else ""
    return f".. {DIRECTIVES[kind]}:: {name}{options}"


def write(app: Sphinx) -> None:
    """The pages of all parts, in `reference/api`; files that are as they were keep their time."""
    folder = Path(app.srcdir) / "reference" / "api"
    folder.mkdir(exist_ok=True)
    pages = {f"{part}.rst": page(part, names) for part, names in parts().items()}
    for old in folder.iterdir():
        if old.name not in pages:
            old.unlink()
    for file, text in pages.items():
        if not (folder / file).is_file() or (folder / file).read_text(encoding="utf-8") != text:
            (folder / file).write_text(text, encoding="utf-8")


# ---- Docstrings ----


def as_rst(lines: list[str]) -> list[str]:
    """A docstring in which indented blocks are literal and nothing else is markup but code in backquotes."""
    return list(_converted(lines))


def _converted(lines: list[str]) -> Iterator[str]:
    section = literal = False
    before = ""
    for line in lines:
        indent = len(line) - len(line.lstrip())
        if not line.strip():
            yield ""
        elif indent == 0:
            section, literal = bool(SECTIONS.match(line)), False
            yield line if section else escaped(line)
        elif section:
            yield escaped(line)
        else:
            if not literal and not before.strip():
                literal = True
                yield from ("::", "")
            yield line if literal else escaped(line)
        before = line


def escaped(line: str) -> str:
    """A line with code as literals, and everything else as it stands."""
    pieces = line.split("`")
    if len(pieces) % 2 == 0:  # a lone backquote
        return _plain(line.replace("`", "'"))
    joined = "".join(f"``{piece}``" if k % 2 else _plain(piece) for k, piece in enumerate(pieces))
    return re.sub(r"``(?=[^\s`.,:;!?()\[\]'\"/-])(?=[^`]*(?:``[^`]*``[^`]*)*$)", r"``\\ ", joined)


def _plain(text: str) -> str:
    """Text in which no sign is markup."""
    return re.sub(r"([*|\\]|_(?!\w))", r"\\\1", text)


def process(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Sphinx asks for this before it reads a docstring."""
    lines[:] = as_rst(lines)


def setup(app: Sphinx) -> dict[str, bool]:
    """Make the pages before sources are read; read docstrings before napoleon does."""
    app.connect("builder-inited", write)
    app.connect("autodoc-process-docstring", process, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
