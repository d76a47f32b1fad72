"""The bibliography, from `references.toml`, and links to it wherever a page says “Author year”.

Pages and docstrings cite in plain text, as “Söderkvist & Wedin 1993” or “Swamidas (1997, 3.4)”. Every such place that
names the first author and the year of an entry becomes a link.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import kinemark
from docutils import nodes
from generated import write
from sphinx import addnodes
from sphinx.application import Sphinx

FILE = Path(kinemark.__file__).parent / "references.toml"
References = dict[str, dict[str, Any]]


def references() -> References:
    """key → its fields."""
    return tomllib.loads(FILE.read_text(encoding="utf-8"))


def pattern(entry: dict[str, Any]) -> re.Pattern[str]:
    """The first author, others perhaps, and the year."""
    first = re.escape(entry["author"][0].split(",")[0])
    return re.compile(
        rf"\b{first}(?:(?:,|\s|&|and\b|et al\.|'s|[A-ZÅÖÜÉØ][\w’-]+|van\b|de\b)*?\s*\(?){entry['year']}\b"
    )


def text(found: References) -> str:
    """Markdown: a paragraph an entry, with a label."""
    by_author = sorted(found.items(), key=lambda item: (item[1]["author"][0].lower(), item[1]["year"]))
    return "\n".join(f"({key.lower()})=\n{line(entry)}\n" for key, entry in by_author)


def line(entry: dict[str, Any]) -> str:
    """One entry as it is printed."""
    authors = [author.replace(", ", " ").replace(". ", ".") for author in entry["author"]]
    title = entry["title"] if "journal" in entry or "book" in entry else f"*{entry['title']}*"
    where = [f"*{entry[key]}*" for key in ("journal", "book") if key in entry]
    if "volume" in entry:
        where = [f"{where[0]} {entry['volume']}"]
    where += [str(entry[key]) for key in ("publisher", "pages") if key in entry]
    doi = f" [doi:{entry['doi']}](https://doi.org/{entry['doi']})" if "doi" in entry else ""
    return f"{', '.join(authors)} ({entry['year']}). {title}. {', '.join(where)}.{doi}".replace("J*FLY", "J\\*FLY")


def link(app: Sphinx, doctree: nodes.document) -> None:
    """Turn citations in a page's text into links."""
    if app.env.docname == "bibliography":
        return
    patterns = [(key, pattern(entry)) for key, entry in references().items()]
    for node in list(doctree.findall(nodes.Text)):
        if not any(isinstance(above, SKIPPED) for above in _above(node)):
            pieces = list(_pieces(app, str(node), patterns))
            if len(pieces) > 1:
                node.parent.replace(node, pieces)


SKIPPED = (nodes.literal, nodes.literal_block, nodes.reference, nodes.title, addnodes.pending_xref, nodes.raw)


def _above(node: nodes.Node) -> Iterator[nodes.Node]:
    """What a node stands in."""
    while (node := node.parent) is not None:
        yield node


def _pieces(app: Sphinx, said: str, patterns: list[tuple[str, re.Pattern[str]]]) -> Iterator[nodes.Node]:
    """A text as text and links."""
    found = sorted((m.start(), m.end(), key) for key, wanted in patterns for m in wanted.finditer(said))
    at = 0
    for begin, end, key in found:
        if begin < at:
            continue
        if begin > at:
            yield nodes.Text(said[at:begin])
        label = {"reftype": "ref", "refdomain": "std", "reftarget": key.lower(), "refexplicit": True}
        yield addnodes.pending_xref("", nodes.inline("", said[begin:end]), refdoc=app.env.docname, **label)
        at = end
    if at < len(said):
        yield nodes.Text(said[at:])


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the fragment before sources are read; link when each has been."""
    app.connect("builder-inited", lambda app: write(app, "bibliography.md", text(references())))
    app.connect("doctree-read", link)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
