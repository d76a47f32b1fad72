"""The works that Kinemark's methods come from: `references.toml`, as text or BibTeX."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any

from ..data import KinemarkError

Entry = Mapping[str, Any]

KINDS = (("journal", "article"), ("book", "inproceedings"), ("publisher", "book"))
"""A field of an entry that tells its kind in BibTeX; the first that it has counts."""


@cache
def references() -> dict[str, Entry]:
    """All entries by their keys: first author and year, as docstrings cite them."""
    return tomllib.loads(files("kinemark").joinpath("references.toml").read_text("utf-8"))


def chosen(words: Sequence[str] = ()) -> dict[str, Entry]:
    """The entries whose key, authors, year or title hold every word; all where none is given.

    Raises:
        KinemarkError: no entry does.
    """
    found = {key: entry for key, entry in references().items() if all(_holds(key, entry, word) for word in words)}
    if not found:
        raise KinemarkError(f"No work holds {' '.join(words)!r}. kinemark cite lists them all.")
    return found


def as_text(entries: Mapping[str, Entry]) -> str:
    """A line an entry, by first author and year."""
    return "\n".join(_line(entry) for _, entry in sorted(entries.items(), key=lambda item: item[0].lower()))


def as_bibtex(entries: Mapping[str, Entry]) -> str:
    """The entries for LaTeX."""
    return "\n\n".join(_bibtex(key, entry) for key, entry in sorted(entries.items(), key=lambda item: item[0].lower()))


def _holds(key: str, entry: Entry, word: str) -> bool:
    text = " ".join([key, *entry["author"], *entry.get("also", ()), str(entry["year"]), entry["title"]])
    return word.casefold() in text.casefold()


def _line(entry: Entry) -> str:
    authors = ", ".join(author.replace(", ", " ").replace(". ", ".") for author in entry["author"])
    where = ", ".join(str(entry[key]) for key in ("journal", "book", "volume", "publisher", "pages") if key in entry)
    doi = f" doi:{entry['doi']}" if "doi" in entry else ""
    return f"{authors} ({entry['year']}). {entry['title']}. {where}.{doi}"


def _bibtex(key: str, entry: Entry) -> str:
    kind = next((kind for field, kind in KINDS if field in entry), "misc")
    fields = {"author": " and ".join(entry["author"])}
    fields |= {name: entry[name] for name in entry if name not in ("author", "also")}
    if kind == "inproceedings":
        fields = {("booktitle" if name == "book" else name): value for name, value in fields.items()}
    body = ",\n".join(f"  {name} = {{{value}}}" for name, value in fields.items())
    return f"@{kind}{{{key},\n{body}\n}}"
