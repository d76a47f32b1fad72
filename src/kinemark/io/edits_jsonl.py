"""Lines of a journal of edits: one JSON object a line, each sealed by its own hash and by that of the line before.

    {"id": 3, "at": …, "by": …, "why": …, "version": …, "before": hash of line 2, "edits": […], "hash": own}

`before` is the SHA-256 of the whole line before, without its end of line, and of nothing for the first; `hash` is the
SHA-256 of all that stands before `,"hash":` in its own line. So a line that was changed is found by its own hash; one
that was changed with its hash, removed, added or moved is found by the line after it. What no hash can tell is that the
last lines were removed, or the last rewritten together with its hash: note the head elsewhere, or sign it, where that
matters.
"""

from __future__ import annotations

import codecs
import hashlib
import json
import re
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

from pydantic import Field, TypeAdapter, ValidationError

from ..data.edits import SMOOTHING, Edit, Entry

SEAL = re.compile(rb'(.*),"hash":"([0-9a-f]{64})"\}', re.DOTALL)
NOTHING = hashlib.sha256(b"").hexdigest()
"""What the first line says of the line before it."""
KNOWN_TEXTS = 8
"""Journals that are kept as they were parsed; chosen: one that was edited is read several times in each act."""
KNOWN_LINES = 4096
"""Lines that are kept as they were parsed, 2.5 kB each; chosen: more than a day's work."""

_EDITS: TypeAdapter[Any] = TypeAdapter(tuple[Annotated[Edit, Field(discriminator="kind")], ...])
_FIELDS = ("id", "at", "by", "why", "version", "before", "edits")


class Fault(NamedTuple):
    """What is wrong with a line.

    Attributes:
        line: its number, from 1. kind: "damaged" (it cannot be read), "tampered" (it is not what was written), "broken"
            (a line before it was removed, added or changed) or "unknown" (written by a later version).
        text: in words.
    """

    line: int
    kind: str
    text: str


class JournalText(NamedTuple):
    """A journal: its entries in order, what is wrong with its lines, the number of these, and the last one's hash."""

    entries: tuple[Entry, ...]
    faults: tuple[Fault, ...]
    lines: int
    head: str


def line_of(entry: Entry) -> bytes:
    """The line of an entry, with its end."""
    body = {name: getattr(entry, name) for name in _FIELDS if name != "edits"}
    body["edits"] = _plain(entry.edits)
    text = json.dumps(body, ensure_ascii=False, separators=(",", ":"), allow_nan=False)[:-1].encode()
    return text + b',"hash":"' + hashlib.sha256(text).hexdigest().encode() + b'"}\n'


def hash_of(line: bytes) -> str:
    """Of a whole line."""
    return hashlib.sha256(line.removesuffix(b"\n")).hexdigest()


@lru_cache(maxsize=KNOWN_TEXTS)
def parse_journal(content: bytes) -> JournalText:
    """All lines of a journal; those that are not right are named, and the rest stands."""
    # Ends of line and a mark of UTF-8 as some programs leave them, that copy, show or keep versions.
    lines = content.removeprefix(codecs.BOM_UTF8).replace(b"\r\n", b"\n").split(b"\n")
    if lines[-1] == b"":
        lines.pop()
    entries: list[Entry] = []
    faults: list[Fault] = []
    before, ids = NOTHING, set[int]()
    for number, line in enumerate(lines, 1):
        found, own = _parse(number, line)
        if isinstance(found, Fault):
            faults.append(found)
        elif found.id in ids:
            faults.append(Fault(number, "tampered", f"it has the number {found.id} of an earlier line"))
        else:
            if found.before != before:
                faults.append(Fault(number, "broken", "the line before it was changed, removed or added"))
            entries.append(found)
            ids.add(found.id)
        before = own
    return JournalText(tuple(entries), tuple(faults), len(lines), before)


@lru_cache(maxsize=KNOWN_LINES)
def _parse(number: int, line: bytes) -> tuple[Entry | Fault, str]:
    """The entry of one line, or what is wrong with it, and its hash; lines never change, and are read at each edit."""
    return _entry(number, line), hash_of(line)


def _entry(number: int, line: bytes) -> Entry | Fault:
    """The entry of one line, or what is wrong with it."""
    sealed = SEAL.fullmatch(line)
    if sealed is None:
        return Fault(number, "damaged", "it is cut off or was written over")
    if hashlib.sha256(sealed[1]).hexdigest().encode() != sealed[2]:
        return Fault(number, "tampered", "it is not what was written")
    try:
        body = json.loads(sealed[1] + b"}")
        edits = _EDITS.validate_json(json.dumps(body["edits"]))
        if set(body) != set(_FIELDS) or _plain(edits) != body["edits"]:
            raise ValueError("fields")
        return Entry(**{**body, "edits": edits})
    except (ValueError, TypeError, KeyError, ValidationError, RecursionError):
        return Fault(number, "unknown", "this version of Kinemark does not know such an edit; a later one wrote it")


def _plain(edits: tuple[Edit, ...]) -> Any:
    """Edits as JSON has them, without what older journals do not say: witnesses, rate, the usual smoothing function."""
    said = json.loads(_EDITS.dump_json(edits))
    for one in said:
        for unsaid in ("where", "whose", "rate"):
            if one.get(unsaid, "") is None:
                del one[unsaid]
        if one.get("function") == SMOOTHING[0]:
            del one["function"]
    return said
